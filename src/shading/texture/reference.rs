//! References to textures, by name or directly.

use std::fmt;
use std::sync::Arc;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::Texture;

/// A texture, or the name of one.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureRef {
    /// A texture's name, a key of [`SceneFile::textures`](crate::scene::SceneFile::textures).
    Named(String),
    /// A texture without a name.
    Texture(Arc<Texture>),
}

impl TextureRef {
    /// The texture, if it has no name.
    pub(crate) fn unnamed(&self) -> Option<&Texture> {
        match self {
            Self::Texture(texture) => Some(texture),
            Self::Named(_) => None,
        }
    }

    /// The texture, once names are resolved.
    ///
    /// # Panics
    /// If it is still a name.
    pub(crate) fn get(&self) -> &Arc<Texture> {
        match self {
            Self::Texture(texture) => texture,
            Self::Named(name) => unreachable!("the name `{name}` is not resolved"),
        }
    }
}

impl From<&str> for TextureRef {
    fn from(name: &str) -> Self {
        Self::Named(name.to_owned())
    }
}

impl<T: Into<Texture>> From<T> for TextureRef {
    fn from(texture: T) -> Self {
        Self::Texture(Arc::new(texture.into()))
    }
}

impl Serialize for TextureRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Named(name) => name.serialize(serializer),
            // Becomes a map in any format, as `visit_map` expects.
            Self::Texture(texture) => {
                serde_json::to_value(&**texture).map_err(S::Error::custom)?.serialize(serializer)
            }
        }
    }
}

impl<'de> Deserialize<'de> for TextureRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RefVisitor;

        impl<'de> Visitor<'de> for RefVisitor {
            type Value = TextureRef;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a texture in quotes")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<TextureRef, E> {
                Ok(name.into())
            }

            // Reads a texture without a name, as `Serialize` writes it.
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TextureRef, A::Error> {
                let value = Value::deserialize(MapAccessDeserializer::new(map))?;
                serde_json::from_value::<Texture>(value).map(Into::into).map_err(A::Error::custom)
            }
        }

        deserializer.deserialize_any(RefVisitor)
    }
}
