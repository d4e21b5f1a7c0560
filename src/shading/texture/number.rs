//! Numbers of materials, each a constant or a channel of a texture.

use std::fmt;
use std::ops::RangeInclusive;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Channel, Product, TextureRef};
use crate::checks::Location;
use crate::error::Result;

/// A constant number, or a channel of a texture times a constant number.
#[derive(Clone, Debug, PartialEq)]
pub enum Number {
    /// A constant number.
    Value(f32),
    /// A channel of a texture, multiplied by a number.
    Texture {
        /// The texture.
        texture: TextureRef,
        /// The channel.
        channel: Channel,
        /// The number by which it is multiplied, 0 or more.
        factor: f32,
    },
}

impl Number {
    /// The channel `channel` of the texture as it is.
    pub fn texture(texture: impl Into<TextureRef>, channel: Channel) -> Self {
        Self::Texture { texture: texture.into(), channel, factor: 1.0 }
    }

    pub(crate) fn zero() -> Self {
        Self::Value(0.0)
    }

    /// Whether this is the number 0.
    pub(crate) fn is_zero(&self) -> bool {
        *self == Self::Value(0.0)
    }

    /// Checks that a constant is in `range`, and that a texture cannot exceed its end. Values of
    /// textures below its start are for the material to raise.
    pub(crate) fn check(
        &self,
        e: &Location<'_>,
        name: &str,
        range: RangeInclusive<f32>,
    ) -> Result<()> {
        let (least, most) = (*range.start(), *range.end());
        let expected = format!("in [{least}, {most}]");
        match self {
            Self::Value(value) => e.check(range.contains(value), name, &expected, value),
            Self::Texture { texture, factor, .. } => {
                let ok = (0.0..=most).contains(factor);
                e.check(ok, &format!("the factor of {name}"), &format!("in [0, {most}]"), factor)?;
                texture.get().model().check_as_color(e, name)?;
                let product = factor * texture.get().model().largest();
                let range = format!("a texture and a factor with products in [0, {most}]");
                e.check(product <= most, name, &range, format!("at most {product}"))
            }
        }
    }

    /// The reference to the texture, if there is one.
    pub(crate) fn reference(&mut self) -> Option<&mut TextureRef> {
        match self {
            Self::Value(_) => None,
            Self::Texture { texture, .. } => Some(texture),
        }
    }
}

impl From<f32> for Number {
    fn from(value: f32) -> Self {
        Self::Value(value)
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::Texture { texture, channel, factor } => {
                let (channel, factor) = (Some(*channel), Some(*factor));
                Product { texture: texture.clone(), channel, factor }.serialize(serializer)
            }
        }
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct NumberVisitor;

        impl<'de> Visitor<'de> for NumberVisitor {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a number, the name of a texture in quotes, or (texture: NAME, channel: g, \
                     factor: NUMBER)",
                )
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Number, A::Error> {
                let product = Product::<f32>::read(map)?;
                Ok(Number::Texture {
                    texture: product.texture,
                    channel: product.channel.unwrap_or_default(),
                    factor: product.factor.unwrap_or(1.0),
                })
            }

            fn visit_str<E: Error>(self, name: &str) -> std::result::Result<Number, E> {
                Ok(Number::texture(name, Channel::R))
            }

            fn visit_f64<E: Error>(self, value: f64) -> std::result::Result<Number, E> {
                Ok(Number::Value(value as f32))
            }

            fn visit_f32<E: Error>(self, value: f32) -> std::result::Result<Number, E> {
                Ok(Number::Value(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> std::result::Result<Number, E> {
                Ok(Number::Value(value as f32))
            }

            fn visit_u64<E: Error>(self, value: u64) -> std::result::Result<Number, E> {
                Ok(Number::Value(value as f32))
            }
        }

        deserializer.deserialize_any(NumberVisitor)
    }
}
