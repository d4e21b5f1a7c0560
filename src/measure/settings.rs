//! Settings of renders by their names, as records contain them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::engine::ImageSettings;
use crate::scene::Named;

/// The settings that decide an image, by name. Records of other versions may lack some.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Map<String, Value>")]
pub(crate) struct NamedSettings(Named<Value>);

impl From<Map<String, Value>> for NamedSettings {
    /// Keeps the settings among the fields of a record.
    fn from(mut fields: Map<String, Value>) -> Self {
        let named = |name: String| fields.remove_entry(&name);
        Self(Named(ImageSettings::names().filter_map(named).collect()))
    }
}

impl From<&ImageSettings> for NamedSettings {
    fn from(settings: &ImageSettings) -> Self {
        Self(Named(settings.by_name()))
    }
}

impl NamedSettings {
    fn get(&self, name: &str) -> Option<&Value> {
        let Named(settings) = &self.0;
        settings.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    /// Returns a setting that is a number, or 0 if it is missing.
    pub(crate) fn number(&self, name: &str) -> u64 {
        self.get(name).and_then(Value::as_u64).unwrap_or(0)
    }

    /// Whether all settings that both have are equal.
    pub(crate) fn agree(&self, other: &Self) -> bool {
        let Named(settings) = &self.0;
        settings.iter().all(|(name, here)| other.get(name).is_none_or(|there| here == there))
    }

    /// The settings in words, such as `640 x 360, 16 spp, depth 50, seed 1`.
    pub(crate) fn describe(&self) -> String {
        let [width, height, spp] = ["width", "height", "spp"].map(|name| self.number(name));
        let others = self.words().filter(|(name, _)| !["width", "height", "spp"].contains(name));
        let others = others.map(|(name, value)| format!(", {name}{value}"));
        format!("{width} x {height}, {spp} spp{}", others.collect::<String>())
    }

    /// The flags of `ptfast render` that stand for the settings, without those called `except`.
    pub(crate) fn flags(&self, except: &[&str]) -> String {
        let wanted = self.words().filter(|(name, _)| !except.contains(name));
        let flags: Vec<String> = wanted.map(|(name, value)| format!("--{name}{value}")).collect();
        flags.join(" ")
    }

    /// The names of all settings that are on, with their values after a blank.
    fn words(&self) -> impl Iterator<Item = (&str, String)> {
        let Named(settings) = &self.0;
        settings.iter().filter_map(|(name, value)| match value {
            Value::Null | Value::Bool(false) => None,
            Value::Bool(true) => Some((name.as_str(), String::new())),
            Value::String(word) => Some((name.as_str(), format!(" {word}"))),
            other => Some((name.as_str(), format!(" {other}"))),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Roulette;
    use crate::scene::Scene;

    #[test]
    fn settings_are_described_by_name() {
        let scene = Scene::load("cornell").unwrap();
        let mut settings = ImageSettings { spp: 4, ..ImageSettings::of(&scene) };
        let named = NamedSettings::from(&settings);
        let words = "depth 50, seed 1, sampling mis, sampler sobol, roulette 5";
        assert_eq!(named.describe(), format!("400 x 400, 4 spp, {words}"));
        (settings.roulette, settings.clamp, settings.transparent) =
            (Roulette::Off, Some(2.5), true);
        let flags = NamedSettings::from(&settings).flags(&[]);
        assert!(
            flags.starts_with("--width 400 --height 400 --spp 4 --depth 50 --seed 1"),
            "{flags}"
        );
        assert!(flags.ends_with("--roulette off --clamp 2.5 --transparent"), "{flags}");
    }

    #[test]
    fn settings_that_a_record_lacks_do_not_count() {
        let named = |text: &str| serde_json::from_str::<NamedSettings>(text).unwrap();
        let old = named(r#"{"width": 8, "spp": 4, "hash": "ab"}"#);
        assert_eq!((old.number("width"), old.number("depth")), (8, 0));
        assert!(old.agree(&named(r#"{"width": 8, "spp": 4, "sampler": "sobol"}"#)));
        assert!(!old.agree(&named(r#"{"width": 9, "spp": 4}"#)));
        assert_eq!(serde_json::to_string(&old).unwrap(), r#"{"width":8,"spp":4}"#);
    }
}
