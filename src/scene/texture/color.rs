//! Colours of materials, each a constant colour or a texture.

use std::fmt;
use std::sync::Arc;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::Texture;
use crate::error::Result;
use crate::image::Image;
use crate::scene::place::Element;

/// A constant colour, a texture, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// A constant colour in linear RGB.
    Rgb([f32; 3]),
    /// A texture's name, a key of [`SceneFile::textures`](crate::scene::SceneFile::textures).
    Named(String),
    /// A texture.
    Texture(Arc<Texture>),
}

impl Color {
    /// Checks that a constant colour is an albedo, with each channel in [0, 1].
    pub(in crate::scene) fn check(&self, e: &Element<'_>, name: &str) -> Result<()> {
        match self {
            Self::Rgb(rgb) => e.color(name, *rgb, 1.0).map(|_| ()),
            Self::Named(_) | Self::Texture(_) => Ok(()),
        }
    }

    /// Checks that a normal map is a texture that contains normals.
    pub(in crate::scene) fn check_normals(&self, e: &Element<'_>) -> Result<()> {
        match self {
            Self::Texture(texture) if texture.holds_normals() => Ok(()),
            _ => Err(e.error(
                "normal must be the name of an `image` texture with `encoding: linear` and `uv: 0`",
            )),
        }
    }

    /// Returns the image of the texture, if it has one.
    pub(in crate::scene) fn image(&self) -> Option<Arc<Image>> {
        match self {
            Self::Texture(texture) => texture.image(),
            _ => None,
        }
    }
}

impl From<[f32; 3]> for Color {
    fn from(rgb: [f32; 3]) -> Self {
        Self::Rgb(rgb)
    }
}

impl From<Texture> for Color {
    fn from(texture: Texture) -> Self {
        Self::Texture(Arc::new(texture))
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Rgb(rgb) => rgb.serialize(serializer),
            Self::Named(name) => name.serialize(serializer),
            // Becomes a map in any format, as `visit_map` expects.
            Self::Texture(texture) => {
                serde_json::to_value(&**texture).map_err(S::Error::custom)?.serialize(serializer)
            }
        }
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct ColorVisitor;

        impl<'de> Visitor<'de> for ColorVisitor {
            type Value = Color;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a colour of three numbers or the name of a texture in quotes")
            }

            // Reads a texture without a name, as `Serialize` writes it.
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Color, A::Error> {
                let value = Value::deserialize(MapAccessDeserializer::new(map))?;
                serde_json::from_value(value).map(Texture::into).map_err(A::Error::custom)
            }

            fn visit_str<E: Error>(self, name: &str) -> std::result::Result<Color, E> {
                Ok(Color::Named(name.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(
                self,
                mut seq: A,
            ) -> std::result::Result<Color, A::Error> {
                let mut color = [0.0; 3];
                for (i, channel) in color.iter_mut().enumerate() {
                    *channel =
                        seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
                }
                match seq.next_element::<f32>()? {
                    None => Ok(Color::Rgb(color)),
                    Some(_) => Err(A::Error::invalid_length(4, &self)),
                }
            }
        }

        deserializer.deserialize_any(ColorVisitor)
    }
}
