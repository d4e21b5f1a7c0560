//! Tiles: the units of work.

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Left edge in the image.
    pub x: u32,
    /// Upper edge in the image.
    pub y: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Tile {
    /// How many pixels it has.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Where in the image its pixel number `index` is, row by row.
    pub fn pixel(&self, index: u32) -> (u32, u32) {
        (self.x + index % self.width, self.y + index / self.width)
    }
}

/// The tiles that cover an image, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Tiles {
    width: u32,
    height: u32,
    size: u32,
}

impl Tiles {
    /// Tiles of side `size`, 1 or more; those at the right and lower edge may be smaller.
    pub fn new(width: u32, height: u32, size: u32) -> Self {
        Self { width, height, size }
    }

    /// How many.
    pub fn count(&self) -> u64 {
        let along = |side: u32| u64::from(side.div_ceil(self.size));
        along(self.width) * along(self.height)
    }

    /// Tile number `index`; `None` beyond the last.
    pub fn get(&self, index: u64) -> Option<Tile> {
        let Self { width, size, .. } = *self;
        let across = u64::from(width.div_ceil(size));
        let place = |index: u64| index as u32 * size;
        (index < self.count()).then(|| self.at(place(index % across), place(index / across)))
    }

    /// The tile of pixel `(x, y)`.
    pub fn at(&self, x: u32, y: u32) -> Tile {
        let Self { width, height, size } = *self;
        let (x, y) = (x - x % size, y - y % size);
        Tile { x, y, width: size.min(width - x), height: size.min(height - y) }
    }

    /// All of them.
    pub fn iter(self) -> impl Iterator<Item = Tile> {
        (0..self.count()).filter_map(move |index| self.get(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height, size) in [(1, 1, 16), (33, 16, 16), (7, 90, 1), (100, 3, 64)] {
            let mut covered = vec![0; (width * height) as usize];
            let tiles = Tiles::new(width, height, size);
            assert_eq!(tiles.iter().count() as u64, tiles.count());
            for tile in tiles.iter() {
                assert!(tile.width > 0 && tile.height > 0);
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        covered[(y * width + x) as usize] += 1;
                        assert_eq!(tiles.at(x, y), tile);
                    }
                }
            }
            assert!(covered.iter().all(|&n| n == 1));
        }
    }
}
