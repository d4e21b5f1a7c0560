//! Lists of typed parameters, such as `"float radius" [ 1 ]`.

use std::cell::Cell;

use super::tokens::{Token, Tokens};

/// The values of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(crate) struct Param {
    /// Its type, such as `float` or `texture`.
    pub(crate) kind: String,
    pub(crate) name: String,
    pub(crate) values: Values,
    used: Cell<bool>,
}

/// The parameters of a directive.
#[derive(Clone, Debug, Default)]
pub(crate) struct Params(Vec<Param>);

impl Params {
    /// Reads the parameters up to the next directive.
    pub(crate) fn read(tokens: &mut Tokens<'_>) -> Result<Self, String> {
        let mut params = Vec::new();
        while let Some(Token::Text(declaration)) = tokens.peek()? {
            let declaration = declaration.to_string();
            tokens.next()?;
            let mut words = declaration.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(format!(
                    "expected a type and a name, such as \"float radius\", found \"{declaration}\""
                ));
            };
            let values = values(tokens).map_err(|message| format!("`{name}`: {message}"))?;
            let (kind, name) = (kind.to_owned(), name.to_owned());
            params.push(Param { kind, name, values, used: Cell::new(false) });
        }
        Ok(Self(params))
    }

    /// The parameter called `name`, which counts as used from now on.
    pub(crate) fn find(&self, name: &str) -> Option<&Param> {
        let param = self.0.iter().find(|param| param.name == name)?;
        param.used.set(true);
        Some(param)
    }

    /// Declares parameters as used that change nothing in ptfast, such as hints for speed.
    pub(crate) fn ignore(&self, names: &[&str]) {
        for name in names {
            self.find(name);
        }
    }

    /// Declares all parameters as used, because a warning says that what they belong to is not supported.
    pub(crate) fn ignore_all(&self) {
        self.0.iter().for_each(|param| param.used.set(true));
    }

    /// The names of the parameters that were not used.
    pub(crate) fn unused(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|param| !param.used.get()).map(|param| param.name.as_str())
    }

    pub(crate) fn numbers(&self, name: &str) -> Result<Option<&[f64]>, String> {
        match self.find(name).map(|param| &param.values) {
            None => Ok(None),
            Some(Values::Numbers(numbers)) => Ok(Some(numbers)),
            Some(_) => Err(format!("`{name}` must be numbers")),
        }
    }

    /// The numbers in groups of N.
    pub(crate) fn tuples<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<Vec<[f64; N]>>, String> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let (tuples, []) = numbers.as_chunks::<N>() else {
            let count = numbers.len();
            return Err(format!("`{name}` must be groups of {N} numbers, has {count} numbers"));
        };
        Ok(Some(tuples.to_vec()))
    }

    /// N numbers.
    pub(crate) fn tuple<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, String> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let count = numbers.len();
        let tuple = numbers.try_into();
        tuple.map(Some).map_err(|_| format!("`{name}` must be {N} numbers, has {count}"))
    }

    pub(crate) fn number(&self, name: &str) -> Result<Option<f64>, String> {
        self.tuple(name).map(|one| one.map(|[number]| number))
    }

    pub(crate) fn text(&self, name: &str) -> Result<Option<&str>, String> {
        match self.find(name).map(|param| &param.values) {
            None => Ok(None),
            Some(Values::Texts(texts)) if texts.len() == 1 => Ok(Some(&texts[0])),
            Some(_) => Err(format!("`{name}` must be one text in quotes")),
        }
    }

    pub(crate) fn texts(&self, name: &str) -> Result<&[String], String> {
        match self.find(name).map(|param| &param.values) {
            None => Ok(&[]),
            Some(Values::Texts(texts)) => Ok(texts),
            Some(_) => Err(format!("`{name}` must be texts in quotes")),
        }
    }

    pub(crate) fn flag(&self, name: &str) -> Result<Option<bool>, String> {
        match self.find(name).map(|param| &param.values) {
            None => Ok(None),
            Some(Values::Flags(flags)) if flags.len() == 1 => Ok(Some(flags[0])),
            Some(_) => Err(format!("`{name}` must be true or false")),
        }
    }
}

/// The values of a parameter: one, or several in brackets.
fn values(tokens: &mut Tokens<'_>) -> Result<Values, String> {
    let missing = || "has no value".to_owned();
    let first = tokens.next()?.ok_or_else(missing)?;
    if first != Token::Open {
        let mut values = None;
        push(&mut values, first)?;
        return values.ok_or_else(missing);
    }
    let mut values = None;
    loop {
        match tokens.next()? {
            None => return Err("has no closing bracket".to_owned()),
            Some(Token::Close) => return Ok(values.unwrap_or(Values::Numbers(Vec::new()))),
            Some(token) => push(&mut values, token)?,
        }
    }
}

fn push(values: &mut Option<Values>, token: Token<'_>) -> Result<(), String> {
    let flag = |word| match word {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    };
    match (values, token) {
        (values @ None, Token::Number(number)) => *values = Some(Values::Numbers(vec![number])),
        (Some(Values::Numbers(numbers)), Token::Number(number)) => numbers.push(number),
        (values, Token::Text(text)) => match (values, flag(&text)) {
            // Files of older versions have "true" in quotes.
            (values @ None, Some(flag)) => *values = Some(Values::Flags(vec![flag])),
            (values @ None, None) => *values = Some(Values::Texts(vec![text.into_owned()])),
            (Some(Values::Texts(texts)), _) => texts.push(text.into_owned()),
            _ => return Err("mixes texts with other values".to_owned()),
        },
        (values, Token::Word(word)) => match (values, flag(word)) {
            (values @ None, Some(flag)) => *values = Some(Values::Flags(vec![flag])),
            (Some(Values::Flags(flags)), Some(flag)) => flags.push(flag),
            _ => return Err(format!("expected a value, found `{word}`")),
        },
        (_, Token::Open | Token::Close) => {
            return Err("has a bracket in the wrong place".to_owned());
        }
        (Some(_), Token::Number(_)) => return Err("mixes numbers with other values".to_owned()),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Params, String> {
        Params::read(&mut Tokens::new(text))
    }

    #[test]
    fn parameters_have_types() {
        let text =
            r#""float radius" 2 "point3 P" [1 2 3 4 5 6] "bool b" [false] "string s" "x y" Shape"#;
        let params = read(text).unwrap();
        assert_eq!(params.number("radius"), Ok(Some(2.0)));
        assert_eq!(params.unused().collect::<Vec<_>>(), ["P", "b", "s"]);
        assert_eq!(params.tuples("P"), Ok(Some(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])));
        assert_eq!(params.flag("b"), Ok(Some(false)));
        assert_eq!(params.text("s"), Ok(Some("x y")));
        assert_eq!(params.number("none"), Ok(None));
        assert!(params.number("P").unwrap_err().contains("must be 1 numbers, has 6"));
        assert!(params.tuples::<4>("P").unwrap_err().contains("groups of 4"));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, want) in [
            ("\"radius\" 2", "a type and a name"),
            ("\"float radius\"", "`radius`: has no value"),
            ("\"float radius\" [ 1 \"a\" ]", "mixes texts"),
            ("\"float radius\" [ \"a\" 1 ]", "mixes numbers"),
            ("\"float radius\" [ 1", "no closing bracket"),
            ("\"float radius\" Shape", "found `Shape`"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(want), "{text}: {error}");
        }
    }
}
