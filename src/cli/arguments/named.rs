//! Arguments that take the name of a value.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// A parser of the names of `all`.
pub(crate) fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|&value| name(value))).map(move |word| {
        let value = all.iter().find(|&&value| name(value) == word);
        *value.expect("only the names of values are possible")
    })
}
