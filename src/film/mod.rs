//! Sums of samples in a fixed order, and the tiles that an image is rendered in.

mod sum;
mod tile;

pub use sum::{CHUNK, PixelSum};
pub use tile::{Tile, Tiles};
