//! Shards: every N-th tile of an image.

use serde::{Deserialize, Serialize};

/// Side of the tiles.
const TILE: u32 = 32;

/// Tiles `index`, `index + count`, … of an image.
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
        let [columns, column, row] = [width.div_ceil(TILE), x / TILE, y / TILE].map(u64::from);
        // Each row begins one later, so that no shard is a few columns.
        let tile = row * (columns + 1) + column;
        tile % u64::from(self.count) == u64::from(self.index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_about_equal() {
        for (width, height, count) in [(400, 400, 16), (1280, 720, 40), (1280, 720, 7), (33, 1, 3)]
        {
            let mut sizes = vec![0u32; count as usize];
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let has = |&index: &u32| Shard { index, count }.has(width, x, y);
                let mut shards = (0..count).filter(has);
                sizes[shards.next().unwrap() as usize] += 1;
                assert_eq!(shards.next(), None);
            }
            let tiles = width * height / TILE / TILE;
            if tiles > 4 * count {
                let mean = width * height / count;
                assert!(sizes.iter().all(|size| size.abs_diff(mean) < mean / 5), "{sizes:?}");
            }
        }
    }
}
