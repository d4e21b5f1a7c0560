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
    /// Where in the image its pixel number `index` is, row by row.
    pub fn pixel(&self, index: u32) -> (u32, u32) {
        (self.x + index % self.width, self.y + index / self.width)
    }
}

/// The tiles of side `size` that cover an image, row by row.
pub fn tiles(width: u32, height: u32, size: u32) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(size as usize) {
        for x in (0..width).step_by(size as usize) {
            tiles.push(Tile { x, y, width: size.min(width - x), height: size.min(height - y) });
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height, size) in [(1, 1, 16), (33, 16, 16), (7, 90, 1), (100, 3, 64)] {
            let mut covered = vec![0; (width * height) as usize];
            for tile in tiles(width, height, size) {
                assert!(tile.width > 0 && tile.height > 0);
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        covered[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(covered.iter().all(|&n| n == 1));
        }
    }
}
