//! The written form of a texture with a factor: `(texture: "bark", factor: 0.5)`.

use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::{Channel, TextureRef};

/// A texture, a channel of it, and a factor, as scene files write them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Product<F> {
    pub(super) texture: TextureRef,
    #[serde(default = "Option::default", skip_serializing_if = "Option::is_none")]
    pub(super) channel: Option<Channel>,
    #[serde(default = "Option::default", skip_serializing_if = "Option::is_none")]
    pub(super) factor: Option<F>,
}

impl<F: DeserializeOwned> Product<F> {
    /// Reads a product, or a texture without a name, as [`TextureRef`] writes it.
    pub(super) fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        if value.get("texture").is_some() {
            return serde_json::from_value(value).map_err(D::Error::custom);
        }
        let texture = serde_json::from_value(value).map_err(D::Error::custom)?;
        Ok(Self { texture, channel: None, factor: None })
    }
}
