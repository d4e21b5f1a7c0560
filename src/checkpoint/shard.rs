//! Shards: parts of an image that consist of one of every N tiles.

use serde::{Deserialize, Serialize};

use crate::math::mix32;

/// Side of a tile in pixels.
const TILE: u32 = 32;

/// A part of an image: one tile of each group of `count` consecutive tiles. The choice is
/// pseudo-random, so that no shard consists of just a few columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// Index of this shard, from 0.
    pub index: u32,
    /// Number of shards that make up the image.
    pub count: u32,
}

impl Shard {
    /// Whether the shard contains pixel `(x, y)` of an image of this width.
    pub fn has(&self, width: u32, x: u32, y: u32) -> bool {
        let tile = y / TILE * width.div_ceil(TILE) + x / TILE;
        index_of(tile, self.count) == self.index
    }
}

/// Index of the shard, of `count` shards, that contains a tile.
fn index_of(tile: u32, count: u32) -> u32 {
    (tile + mix32(tile / count) % count) % count
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// For every number of shards, each tile is in exactly one shard, shards differ in size by at
    /// most one tile, and no shard consists of just a few columns or rows, which might take longer
    /// than others.
    #[test]
    fn shards_are_disjoint_equal_and_spread() {
        for (width, height) in [(400, 400), (600, 600), (1280, 720), (1920, 1080), (33, 1)] {
            let (columns, rows) = (u32::div_ceil(width, TILE), u32::div_ceil(height, TILE));
            let tiles: Vec<[u32; 2]> =
                (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y])).collect();
            for count in 1..=columns * rows + 1 {
                let mut shards = vec![Vec::new(); count as usize];
                for (tile, place) in (0..).zip(&tiles) {
                    shards[index_of(tile, count) as usize].push(*place);
                }
                let each = tiles.len() / count as usize;
                for shard in &shards {
                    assert!((each..=each + 1).contains(&shard.len()), "{width} {height} {count}");
                    for (side, length) in [columns, rows].into_iter().enumerate() {
                        let of = |tile: &[u32; 2]| tile[side];
                        let distinct = shard.iter().map(of).collect::<HashSet<_>>().len();
                        let least = shard.len().min(length as usize) / 3;
                        assert!(distinct >= least, "{width} {height} {count}: {shard:?}");
                    }
                }
            }
            for (x, y) in [(0, 0), (width - 1, height / 2), (width / 2, height - 1)] {
                let has = |index: &u32| Shard { index: *index, count: 7 }.has(width, x, y);
                let tile = tiles.iter().position(|tile| *tile == [x / TILE, y / TILE]);
                let index = index_of(u32::try_from(tile.expect("inside")).expect("few"), 7);
                assert_eq!((0..7).filter(has).collect::<Vec<_>>(), [index]);
            }
        }
        let last = Shard { index: 0, count: u32::MAX };
        assert!(last.has(1 << 16, 0, 0) && !last.has(1 << 16, (1 << 16) - 1, (1 << 16) - 1));
    }
}
