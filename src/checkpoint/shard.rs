//! Shards: one of every N tiles of an image.

use serde::{Deserialize, Serialize};

use crate::math::random::mix32;

/// Side of the tiles.
const TILE: u32 = 32;

/// Of every `count` consecutive tiles of an image one: which, differs at random, so that no shard is a few columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// Its number, from 0.
    pub index: u32,
    /// How many there are.
    pub count: u32,
}

impl Shard {
    /// Whether pixel `(x, y)` of an image of this width is in it.
    pub fn has(&self, width: u32, x: u32, y: u32) -> bool {
        let [columns, column, row] = [width.div_ceil(TILE), x / TILE, y / TILE];
        let tile = row * columns + column;
        let turned = tile + mix32(tile / self.count) % self.count;
        turned % self.count == self.index
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Every number of shards: each tile is in one, all have the same number of tiles but for one, and none is a few
    /// columns or rows, which might take longer than others.
    #[test]
    fn shards_are_disjoint_equal_and_spread() {
        for (width, height) in [(400, 400), (600, 600), (1280, 720), (1920, 1080), (33, 1)] {
            let (columns, rows) = (u32::div_ceil(width, TILE), u32::div_ceil(height, TILE));
            let tiles: Vec<[u32; 2]> =
                (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y])).collect();
            for count in 1..=columns * rows + 1 {
                let shards = (0..count).map(|index| Shard { index, count });
                let has = |shard: &Shard| {
                    let of = |&&[x, y]: &&[u32; 2]| shard.has(width, x * TILE, (y + 1) * TILE - 1);
                    tiles.iter().filter(of).copied().collect::<Vec<_>>()
                };
                let all: Vec<_> = shards.map(|shard| has(&shard)).collect();
                let each = tiles.len() / count as usize;
                for shard in &all {
                    assert!((each..=each + 1).contains(&shard.len()), "{width} {height} {count}");
                    for (side, length) in [columns, rows].into_iter().enumerate() {
                        let of = |tile: &[u32; 2]| tile[side];
                        let distinct = shard.iter().map(of).collect::<HashSet<_>>().len();
                        let least = shard.len().min(length as usize) / 3;
                        assert!(distinct >= least, "{width} {height} {count}: {shard:?}");
                    }
                }
                assert_eq!(all.concat().iter().collect::<HashSet<_>>().len(), tiles.len());
                assert_eq!(all.concat().len(), tiles.len());
            }
        }
        let last = Shard { index: 0, count: u32::MAX };
        assert!(last.has(1 << 16, 0, 0) && !last.has(1 << 16, (1 << 16) - 1, (1 << 16) - 1));
    }
}
