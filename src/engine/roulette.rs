//! Russian roulette: paths of low throughput end at random, without bias.

use std::fmt;
use std::str::FromStr;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The segments of a path that it reaches only if it survives Russian roulette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roulette {
    /// None.
    Off,
    /// This one and all later ones. The camera ray is segment 1.
    From(u32),
}

impl Roulette {
    /// Whether a path must survive to reach segment number `segment`.
    #[inline(always)]
    pub(super) fn applies(self, segment: u32) -> bool {
        match self {
            Self::Off => false,
            Self::From(first) => segment >= first,
        }
    }
}

/// The form on the command line: a number, or `off`.
impl fmt::Display for Roulette {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::From(first) => first.fmt(f),
        }
    }
}

impl FromStr for Roulette {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(first) => Ok(Self::From(first)),
            Err(_) if text == "off" => Ok(Self::Off),
            Err(_) => Err(format!("must be `off` or a whole number, is `{text}`")),
        }
    }
}

impl Serialize for Roulette {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Off => serializer.serialize_str("off"),
            Self::From(first) => serializer.serialize_u32(*first),
        }
    }
}

impl<'de> Deserialize<'de> for Roulette {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrOff;

        impl Visitor<'_> for NumberOrOff {
            type Value = Roulette;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a segment, or \"off\"")
            }

            fn visit_u64<E: Error>(self, first: u64) -> Result<Roulette, E> {
                let known = u32::try_from(first).map(Roulette::From);
                known.map_err(|_| E::invalid_value(Unexpected::Unsigned(first), &self))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Roulette, E> {
                text.parse().map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_any(NumberOrOff)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_is_written_as_it_is_read() {
        for (roulette, text, json) in
            [(Roulette::Off, "off", "\"off\""), (Roulette::From(7), "7", "7")]
        {
            assert_eq!(roulette.to_string(), text);
            assert_eq!(text.parse(), Ok(roulette));
            assert_eq!(serde_json::to_string(&roulette).unwrap(), json);
            assert_eq!(serde_json::from_str::<Roulette>(json).unwrap(), roulette);
        }
        for wrong in ["-1", "4294967296", "\"on\"", "null", "true"] {
            assert!(serde_json::from_str::<Roulette>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn roulette_begins_at_its_segment() {
        let from = Roulette::From(3);
        assert_eq!([2, 3, 4].map(|segment| from.applies(segment)), [false, true, true]);
        assert!(!Roulette::Off.applies(u32::MAX));
    }
}
