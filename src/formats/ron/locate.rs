//! Finds the line and column of an element in the text of a scene file, for errors that are found
//! after parsing.

use std::fmt;

use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::{Form, options};

/// Returns `line:column` of the element at `path`, such as `camera`, `primitives[3]` or
/// `materials.grey` or `meshes.tree[1]`. Returns `None` if the text has no such element.
///
/// The text is parsed again, and parsing deliberately fails at the element, so that the parser
/// reports the position of the element.
pub(crate) fn locate(form: Form, text: &str, path: &str) -> Option<String> {
    let keys = keys(path);
    let find = Find(&keys);
    match form {
        Form::Ron => {
            let position = options().from_str_seed(text, find).err()?;
            let (::ron::Error::Message(message), at) = (position.code, position.span.end) else {
                return None;
            };
            (message == FOUND).then(|| format!("{}:{}", at.line, at.col))
        }
        Form::Json => {
            let error = find.deserialize(&mut serde_json::Deserializer::from_str(text)).err()?;
            let found = error.to_string().starts_with(FOUND);
            found.then(|| format!("{}:{}", error.line(), error.column().max(1)))
        }
    }
}

/// The names and indices in `path`. An index in brackets may follow at the end.
fn keys(path: &str) -> Vec<&str> {
    let indexed = path.strip_suffix(']').and_then(|path| path.rsplit_once('['));
    let (names, index) = indexed.map_or((path, None), |(names, index)| (names, Some(index)));
    let names = names.splitn(2, '.');
    names.chain(index).collect()
}

/// Message of the deliberate error at the element.
const FOUND: &str = "found";

/// The names and indices that lead to an element.
struct Find<'a>(&'a [&'a str]);

impl<'de> DeserializeSeed<'de> for Find<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        match self.0 {
            [] => Err(D::Error::custom(FOUND)),
            _ => deserializer.deserialize_any(self),
        }
    }
}

impl<'de> Visitor<'de> for Find<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list or a map")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let index: usize = self.0[0].parse().map_err(A::Error::custom)?;
        for _ in 0..index {
            list.next_element::<IgnoredAny>()?;
        }
        list.next_element_seed(Find(&self.0[1..])).map(drop)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(name) = map.next_key::<Name>()? {
            match &self.0[1..] {
                _ if name.0 != self.0[0] => drop(map.next_value::<IgnoredAny>()?),
                // The position of the name, not of the value.
                [] => return Err(A::Error::custom(FOUND)),
                rest => map.next_value_seed(Find(rest))?,
            }
        }
        Ok(())
    }
}

/// A field name or a key.
struct Name(String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl Visitor<'_> for Text {
            type Value = Name;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a name")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Name, E> {
                Ok(Name(name.to_owned()))
            }
        }
        deserializer.deserialize_any(Text)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{from_ron, to_json};
    use super::*;

    #[test]
    fn elements_are_located() {
        let ron = "(\n  camera: (look_from: (0, 0, 0), look_at: (0, 0, 1), vfov: 40),\n  \
                   materials: {\n    \"a\": lambertian(albedo: (1, 1, 1)),\n    \"b\": metal(albedo: (1, 1, 1), fuzz: 0),\n  },\n  \
                   primitives: [\n    sphere(center: (0, 0, 0), radius: 1, material: \"a\"), // one\n    \
                   sphere(center: (0, 0, 0), radius: 2, material: \"b\"),\n  ],\n)\n";
        let line = |form, text, path| {
            let place = locate(form, text, path)?;
            place.split(':').next().map(|line| line.parse::<u32>().unwrap())
        };
        let file = from_ron("a.ron", ron).unwrap();
        let json = to_json(&file);
        for (path, want, text) in [
            ("camera", 2, "\"camera\""),
            ("materials.b", 5, "\"b\""),
            ("primitives[0]", 8, "sphere"),
            ("primitives[1]", 9, "sphere"),
        ] {
            assert_eq!(line(Form::Ron, ron, path), Some(want), "{path}");
            let found = line(Form::Json, &json, path).unwrap();
            let there = json.lines().nth(found as usize - 1).unwrap();
            assert!(there.contains(text) || text == "sphere", "{path} {there}");
        }
        assert_eq!(line(Form::Ron, ron, "primitives[2]"), None);
        assert_eq!(line(Form::Ron, ron, "media[0]"), None);
    }
}
