//! Text to [`SceneFile`], with errors that say where and what would be right.

use ron::extensions::Extensions;

use super::description::SceneFile;
use super::nesting;
use crate::error::{Error, Result, suggestion};
use crate::limits::{Limit, Limits};

/// `light(radiance: …)` is the struct of a light, without another pair of brackets.
fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Reads the RON form.
pub(super) fn from_ron(file: &str, text: &str, limits: &Limits) -> Result<SceneFile> {
    check_nesting(file, text, limits)?;
    options().from_str(text).map_err(|error| {
        let place = format!("{}:{}", error.span.start.line, error.span.start.col);
        Error::input(file, place, ron_message(&error.code))
    })
}

fn ron_message(code: &ron::Error) -> String {
    match code {
        ron::Error::NoSuchStructField { expected, found, .. } => {
            format!("unknown field `{found}`{}", suggestion(found, expected.iter().copied()))
        }
        ron::Error::NoSuchEnumVariant { expected, found, .. } => {
            format!("unknown kind `{found}`{}", suggestion(found, expected.iter().copied()))
        }
        ron::Error::MissingStructField { field, .. } => format!("the field `{field}` is missing"),
        ron::Error::DuplicateStructField { field, .. } => {
            format!("the field `{field}` is given twice")
        }
        ron::Error::Message(message) => message.clone(),
        other => format!("RON syntax: {}", one_line(&other.to_string())),
    }
}

/// Reads the same schema as JSON.
pub(super) fn from_json(file: &str, text: &str, limits: &Limits) -> Result<SceneFile> {
    check_nesting(file, text, limits)?;
    serde_json::from_str(text).map_err(|error| {
        let place = format!("{}:{}", error.line(), error.column());
        let message = error.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(m, _)| m);
        Error::input(file, place, json_message(message, error.is_data()))
    })
}

/// serde's messages put the name found and the names known in backticks, in this order.
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
        _ if is_data => one_line(message),
        _ => format!("JSON syntax: {}", one_line(message)),
    }
}

/// The parsers call themselves for what is nested.
fn check_nesting(file: &str, text: &str, limits: &Limits) -> Result<()> {
    let Some(((line, column), depth)) = nesting::deeper_than(text, limits.get(Limit::Nesting))
    else {
        return Ok(());
    };
    let checked = limits.check(Limit::Nesting, depth);
    checked.map_err(|message| Error::input(file, format!("{line}:{column}"), message))
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The scene as RON text that [`from_ron`] reads back to the same bits.
pub(super) fn to_ron(scene: &SceneFile) -> String {
    let config = ron::ser::PrettyConfig::new().depth_limit(2).compact_arrays(false);
    let mut text = options()
        .to_string_pretty(scene, config)
        .expect("a scene has no value that RON cannot say");
    text.push('\n');
    text
}

/// The scene as JSON text that [`from_json`] reads back to the same bits.
pub(super) fn to_json(scene: &SceneFile) -> String {
    let mut text =
        serde_json::to_string_pretty(scene).expect("a scene has no value that JSON cannot say");
    text.push('\n');
    text
}
