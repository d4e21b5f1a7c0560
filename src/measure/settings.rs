//! Image settings in words, and as flags in commands.

use serde_json::Value;

use crate::engine::ImageSettings;

/// The settings in words, such as `640 x 360, 16 spp, depth 50, seed 1`.
pub(crate) fn describe(settings: &ImageSettings) -> String {
    let ImageSettings { width, height, spp, .. } = settings;
    let others = words(settings).filter(|(name, _)| !["width", "height", "spp"].contains(&&**name));
    let others = others.map(|(name, value)| format!(", {name}{value}"));
    format!("{width} x {height}, {spp} spp{}", others.collect::<String>())
}

/// The flags that stand for the settings, of those that a command `has`.
pub(crate) fn flags(settings: &ImageSettings, has: impl Fn(&str) -> bool) -> String {
    let flags = words(settings).map(|(name, value)| (name.replace('_', "-"), value));
    let flags = flags.filter(|(flag, _)| has(flag)).map(|(flag, value)| format!("--{flag}{value}"));
    flags.collect::<Vec<_>>().join(" ")
}

/// The names of all settings that are on, with their values after a blank.
fn words(settings: &ImageSettings) -> impl Iterator<Item = (String, String)> {
    settings.by_name().into_iter().filter_map(|(name, value)| match value {
        Value::Null | Value::Bool(false) => None,
        Value::Bool(true) => Some((name, String::new())),
        Value::String(word) => Some((name, format!(" {word}"))),
        other => Some((name, format!(" {other}"))),
    })
}

/// `word` as a shell takes it literally.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use crate::scene::{Roulette, Scene};

    #[test]
    fn settings_are_described_by_name() {
        let scene = Scene::load("cornell").unwrap();
        let mut settings = ImageSettings { spp: 4, ..ImageSettings::of(&scene) };
        let words = "depth 50, seed 1, sampling mis, sampler sobol, roulette 5";
        assert_eq!(describe(&settings), format!("400 x 400, 4 spp, {words}"));
        (settings.roulette, settings.clamp, settings.transparent) =
            (Roulette::Off, Some(2.5), true);
        let all = flags(&settings, |_| true);
        assert!(all.starts_with("--width 400 --height 400 --spp 4 --depth 50 --seed 1"), "{all}");
        assert!(all.ends_with("--roulette off --clamp 2.5 --transparent"), "{all}");
        assert_eq!(flags(&settings, |flag| flag == "spp"), "--spp 4");
    }

    #[test]
    fn words_are_quoted_where_they_must_be() {
        assert_eq!(quoted("cloud:1000"), "cloud:1000");
        assert_eq!(quoted("-C target-cpu=native"), "'-C target-cpu=native'");
        assert_eq!(quoted("it's; rm"), "'it'\\''s; rm'");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn settings_of_older_versions_are_complete() {
        let old =
            r#""width": 8, "height": 4, "spp": 4, "depth": 50, "seed": 1, "sampling": "bsdf""#;
        let read = |text: &str| serde_json::from_str::<ImageSettings>(&format!("{{{text}}}"));
        let settings = read(old).unwrap();
        assert_eq!((settings.sampler, settings.clamp), (Sampler::Independent, None));
        assert_eq!(settings.roulette, Roulette::From(5));
        assert!(read(&old.replace("\"seed\": 1, ", "")).is_err());
        assert!(read(&old.replace("\"bsdf\"", "\"bsdf; rm\"")).is_err());
    }
}
