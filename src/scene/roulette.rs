//! Russian roulette: paths of low throughput end at random, without bias.

use std::fmt;
use std::str::FromStr;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::limits;

/// Which paths Russian roulette may end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Roulette {
    /// Those whose throughput falls below a threshold. The longer the paths of the scene are, the higher is
    /// the threshold; some test paths, which are never shown, decide it.
    #[default]
    Auto,
    /// None.
    Off,
    /// All that reach this segment, 1 to 65 536. The camera ray is segment 1. They survive with a probability of
    /// their throughput, but at most 0.95.
    From(u32),
}

impl Roulette {
    /// Checks that the segment is in range.
    pub(crate) fn check(self) -> Result<(), String> {
        match self {
            Self::Auto | Self::Off => Ok(()),
            Self::From(first) => limits::check("roulette", first, limits::MAX_DEPTH),
        }
    }
}

/// The form on the command line: a number, `off` or `auto`.
impl fmt::Display for Roulette {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Off => f.write_str("off"),
            Self::From(first) => first.fmt(f),
        }
    }
}

impl FromStr for Roulette {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "off" => Ok(Self::Off),
            _ => text
                .parse()
                .map(Self::From)
                .map_err(|_| format!("must be `auto`, `off` or a whole number, is `{text}`")),
        }
    }
}

impl Serialize for Roulette {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::From(first) => serializer.serialize_u32(*first),
            word => serializer.collect_str(word),
        }
    }
}

impl<'de> Deserialize<'de> for Roulette {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrWord;

        impl Visitor<'_> for NumberOrWord {
            type Value = Roulette;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a segment, \"off\" or \"auto\"")
            }

            fn visit_u64<E: Error>(self, first: u64) -> Result<Roulette, E> {
                let known = u32::try_from(first).map(Roulette::From);
                known.map_err(|_| E::invalid_value(Unexpected::Unsigned(first), &self))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Roulette, E> {
                text.parse().map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_any(NumberOrWord)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_is_written_as_it_is_read() {
        for (roulette, text, json) in [
            (Roulette::Auto, "auto", "\"auto\""),
            (Roulette::Off, "off", "\"off\""),
            (Roulette::From(7), "7", "7"),
        ] {
            assert_eq!(roulette.to_string(), text);
            assert_eq!(text.parse(), Ok(roulette));
            assert_eq!(serde_json::to_string(&roulette).unwrap(), json);
            assert_eq!(serde_json::from_str::<Roulette>(json).unwrap(), roulette);
        }
        for wrong in ["-1", "4294967296", "\"on\"", "null", "true"] {
            assert!(serde_json::from_str::<Roulette>(wrong).is_err(), "{wrong}");
        }
    }
}
