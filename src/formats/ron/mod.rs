//! Parses text into a [`SceneFile`], with errors that name the place and suggest a correction.

mod locate;

use ::ron::extensions::Extensions;

pub(crate) use self::locate::locate;
use crate::error::{Error, Result, suggestion};
use crate::scene::SceneFile;

/// The forms of scene files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `.ron`
    Ron,
    /// `.json`, with the same schema.
    Json,
}

/// Allows `light(radiance: …)` for `light((radiance: …))`, and values of optional fields without
/// `Some`.
pub(crate) fn options() -> ::ron::Options {
    ::ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Reads the RON form.
pub(crate) fn from_ron(file: &str, text: &str) -> Result<SceneFile> {
    options().from_str(text).map_err(|error| {
        let place = format!("{}:{}", error.span.start.line, error.span.start.col);
        Error::input(file, place, ron_message(&error.code))
    })
}

fn ron_message(code: &::ron::Error) -> String {
    match code {
        ::ron::Error::NoSuchStructField { expected, found, .. } => {
            format!("unknown field `{found}`{}", suggestion(found, expected.iter().copied()))
        }
        ::ron::Error::NoSuchEnumVariant { expected, found, .. } => {
            format!("unknown kind `{found}`{}", suggestion(found, expected.iter().copied()))
        }
        ::ron::Error::MissingStructField { field, .. } => format!("the field `{field}` is missing"),
        ::ron::Error::DuplicateStructField { field, .. } => {
            format!("the field `{field}` is given twice")
        }
        ::ron::Error::Message(message) => message.clone(),
        ::ron::Error::InvalidValueForType { expected, found } => {
            format!("expected {expected}, found {found}")
        }
        ::ron::Error::ExpectedNamedStructLike(_)
        | ::ron::Error::ExpectedStructLike
        | ::ron::Error::ExpectedStructLikeEnd
        | ::ron::Error::ExpectedDifferentStructName { .. } => {
            "expected values in parentheses, such as `(1, 2, 3)` or `(radius: 1)`".to_owned()
        }
        ::ron::Error::ExceededRecursionLimit => "nested more than 128 levels deep".to_owned(),
        other => format!("RON syntax: {}", one_line(&other.to_string())),
    }
}

/// Reads the same schema as JSON.
pub(crate) fn from_json(file: &str, text: &str) -> Result<SceneFile> {
    serde_json::from_str(text).map_err(|error| {
        let place = format!("{}:{}", error.line(), error.column());
        let message = error.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(m, _)| m);
        Error::input(file, place, json_message(message, error.is_data()))
    })
}

/// Rewords a message of serde. The message contains the name found and then the known names, all in
/// backticks.
fn json_message(message: &str, is_data: bool) -> String {
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    match names.split_first() {
        Some((found, known)) if message.starts_with("unknown field") => {
            format!("unknown field `{found}`{}", suggestion(found, known.iter().copied()))
        }
        Some((found, known)) if message.starts_with("unknown variant") => {
            format!("unknown kind `{found}`{}", suggestion(found, known.iter().copied()))
        }
        Some((field, _)) if message.starts_with("missing field") => {
            format!("the field `{field}` is missing")
        }
        Some((field, _)) if message.starts_with("duplicate field") => {
            format!("the field `{field}` is given twice")
        }
        _ if is_data => one_line(&plain(message)),
        _ => format!("JSON syntax: {}", one_line(message)),
    }
}

/// A message of serde with words for JSON in place of Rust's types.
fn plain(message: &str) -> String {
    let (found, expected) = message.split_once("expected ").unwrap_or((message, ""));
    let expected = match expected.split_whitespace().next() {
        Some("struct") => "an object",
        Some("f32") => "a number",
        Some("u32") => "a whole number of 0 or more",
        _ => return message.to_owned(),
    };
    format!("{found}expected {expected}")
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The scene as RON text that [`from_ron`] reads back to the same bits.
pub(crate) fn to_ron(scene: &SceneFile) -> String {
    let config = ::ron::ser::PrettyConfig::new().depth_limit(2).compact_arrays(false);
    let mut text =
        options().to_string_pretty(scene, config).expect("every scene can be written as RON");
    text.push('\n');
    text
}

/// The scene as JSON text that [`from_json`] reads back to the same bits.
pub(crate) fn to_json(scene: &SceneFile) -> String {
    let mut text = serde_json::to_string_pretty(scene).expect("every scene can be written as JSON");
    text.push('\n');
    text
}
