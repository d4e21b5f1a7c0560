//! The written form of a texture with a factor: `(texture: "bark", factor: 0.5)`.

use serde::Serialize;
use serde::de::{DeserializeOwned, Error, MapAccess};
use serde_json::{Map, Value};

use super::{Channel, Texture, TextureRef};

/// A texture, a channel of it, and a factor, as scene files write them.
#[derive(Serialize)]
pub(super) struct Product<F> {
    pub(super) texture: TextureRef,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) channel: Option<Channel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) factor: Option<F>,
}

impl<F: DeserializeOwned> Product<F> {
    /// Reads a product, or a texture without a name, as [`TextureRef`] writes it.
    ///
    /// Fields are read with their types: a `Value` would lose the names of variants in RON.
    pub(super) fn read<'de, A: MapAccess<'de>>(mut map: A) -> Result<Self, A::Error> {
        let (mut texture, mut channel, mut factor) = (None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "texture" => texture = Some(map.next_value()?),
                "channel" => channel = Some(map.next_value()?),
                "factor" => factor = Some(map.next_value()?),
                _ if texture.is_none() && Texture::KINDS.contains(&key.as_str()) => {
                    let kind = Map::from_iter([(key, map.next_value::<Value>()?)]);
                    let read: Texture =
                        serde_json::from_value(kind.into()).map_err(A::Error::custom)?;
                    texture = Some(read.into());
                }
                _ => {
                    return Err(A::Error::unknown_field(&key, &["texture", "channel", "factor"]));
                }
            }
        }
        let texture = texture.ok_or_else(|| A::Error::missing_field("texture"))?;
        Ok(Self { texture, channel, factor })
    }
}
