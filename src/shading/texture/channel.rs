//! Channels of textures.

use serde::{Deserialize, Serialize};

/// A channel of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Red, the channel of grey images.
    #[default]
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}
