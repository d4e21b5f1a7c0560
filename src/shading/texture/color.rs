//! Colours of materials, each a constant colour or a texture.

use std::fmt;

use glam::Vec3;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Product, Texture, TextureRef};
use crate::checks::{Location, limit};
use crate::error::Result;

/// A constant colour, or a texture times a constant colour.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// A constant colour in linear RGB.
    Rgb([f32; 3]),
    /// A texture, multiplied by a colour in linear RGB.
    Texture {
        /// The texture.
        texture: TextureRef,
        /// The colour by which it is multiplied, with channels of 0 or more.
        factor: [f32; 3],
    },
}

impl Color {
    /// The texture as it is.
    pub fn texture(texture: impl Into<TextureRef>) -> Self {
        Self::Texture { texture: texture.into(), factor: [1.0; 3] }
    }

    /// Checks that the colour is an albedo, with each channel in [0, 1]. The texture, if there is
    /// one, must be loaded.
    pub(crate) fn check(&self, e: &Location<'_>, name: &str) -> Result<()> {
        self.check_within(e, name, 1.0)
    }

    /// Checks that each channel is in [0, `most`].
    pub(crate) fn check_within(&self, e: &Location<'_>, name: &str, most: f32) -> Result<()> {
        match self {
            Self::Rgb(rgb) => e.color(name, *rgb, most).map(|_| ()),
            Self::Texture { texture, factor } => {
                e.color(&format!("the factor of {name}"), *factor, most)?;
                texture.get().model().check_as_color(e, name)?;
                let largest = texture.get().model().largest();
                let product = factor.map(|factor| factor * largest);
                let ok = product.iter().all(|&value| value <= most);
                let range = format!("textures and factors with products in [0, {}]", limit(most));
                e.check(ok, name, &range, format!("at most {product:?}"))
            }
        }
    }

    /// The colour, if it is the same everywhere.
    pub(crate) fn constant(&self) -> Option<[f32; 3]> {
        match self {
            Self::Rgb(rgb) => Some(*rgb),
            Self::Texture { factor: [0.0, 0.0, 0.0], .. } => Some([0.0; 3]),
            Self::Texture { texture: TextureRef::Texture(texture), factor } => {
                texture.model().constant().map(|color| [0, 1, 2].map(|i| color[i] * factor[i]))
            }
            Self::Texture { .. } => None,
        }
    }

    /// A bound on the colour. A texture must be loaded.
    pub(crate) fn largest(&self) -> Vec3 {
        match self {
            Self::Rgb(rgb) => (*rgb).into(),
            Self::Texture { texture, factor } => {
                Vec3::from(*factor) * texture.get().model().largest()
            }
        }
    }

    /// The reference to the texture, if there is one.
    pub(crate) fn reference(&mut self) -> Option<&mut TextureRef> {
        match self {
            Self::Rgb(_) => None,
            Self::Texture { texture, .. } => Some(texture),
        }
    }
}

impl From<[f32; 3]> for Color {
    fn from(rgb: [f32; 3]) -> Self {
        Self::Rgb(rgb)
    }
}

impl From<&str> for Color {
    fn from(name: &str) -> Self {
        Self::texture(name)
    }
}

impl From<Texture> for Color {
    fn from(texture: Texture) -> Self {
        Self::texture(texture)
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Rgb(rgb) => rgb.serialize(serializer),
            Self::Texture { texture, factor: [1.0, 1.0, 1.0] } => texture.serialize(serializer),
            Self::Texture { texture, factor } => {
                Product { texture: texture.clone(), channel: None, factor: Some(*factor) }
                    .serialize(serializer)
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
                f.write_str(
                    "a colour of three numbers, the name of a texture in quotes, or (texture: \
                     NAME, factor: COLOUR)",
                )
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Color, A::Error> {
                let product = Product::<[f32; 3]>::read(map)?;
                match product.channel {
                    Some(_) => Err(A::Error::custom("a colour has no `channel`")),
                    None => Ok(Color::Texture {
                        texture: product.texture,
                        factor: product.factor.unwrap_or([1.0; 3]),
                    }),
                }
            }

            fn visit_str<E: Error>(self, name: &str) -> std::result::Result<Color, E> {
                Ok(name.into())
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
