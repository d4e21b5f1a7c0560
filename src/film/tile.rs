//! Rectangles of pixels.

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Position in the image of pixel number `index`, counted row by row.
    pub fn pixel(&self, index: u32) -> (u32, u32) {
        (self.x + index % self.width, self.y + index / self.width)
    }

    /// The two halves of the tile, cut across its longer side.
    pub(super) fn halves(&self) -> [Self; 2] {
        let Self { x, y, width, height } = *self;
        if width >= height {
            let left = width / 2;
            [Self { width: left, ..*self }, Self { x: x + left, width: width - left, ..*self }]
        } else {
            let upper = height / 2;
            [
                Self { height: upper, ..*self },
                Self { y: y + upper, height: height - upper, ..*self },
            ]
        }
    }
}

/// Largest step of [`Grid`]: a row of so many pixels has whole packets of 32 rays, and beams of 64 if
/// pixels have two samples or more.
const WIDEST_STEP: u64 = 32;

/// Iterator over the parts of a tile, row by row. The parts are about as wide as high.
///
/// Paths are numbered pixel by pixel in rows. A packet of rays that begins in one row and ends in the
/// next would span the part, so that a beam around it enters many boxes. All widths but the
/// last in a row are therefore multiples of `step`, a power of two of at most [`WIDEST_STEP`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    whole: Tile,
    /// Columns are cut at multiples of this number of pixels.
    step: u32,
    columns: u32,
    rows: u32,
    next: u64,
}

impl Grid {
    /// Cuts `whole` into parts of at most `pixels` pixels, or of one pixel if `pixels` is 0.
    pub(crate) fn new(whole: Tile, pixels: u64) -> Self {
        let Tile { width, height, .. } = whole;
        let pixels = pixels.max(1);
        let side = pixels.isqrt();
        // At most half a side, so that no column is more than about twice as wide as another.
        let step = 1 << (side / 2).min(u64::from(width / 4)).clamp(1, WIDEST_STEP).ilog2();
        let steps = u64::from(width).div_ceil(step);
        let columns = steps.div_ceil((side / step).max(1)).max(1);
        let widest = (steps.div_ceil(columns) * step).clamp(1, u64::from(width).max(1));
        let rows = u64::from(height).div_ceil(pixels / widest);
        Self { whole, step: step as u32, columns: columns as u32, rows: rows as u32, next: 0 }
    }

    /// Number of columns and rows.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.columns, self.rows]
    }

    /// The part at `column` and `row`.
    pub(crate) fn part(&self, column: u32, row: u32) -> Tile {
        let cut = |begin: u32, length: u32, step: u32, parts: u32, part: u32| {
            let steps = u64::from(length.div_ceil(step));
            let at = |part: u32| (steps * u64::from(part) / u64::from(parts)) as u32 * step;
            (begin + at(part), at(part + 1).min(length) - at(part))
        };
        let (x, width) = cut(self.whole.x, self.whole.width, self.step, self.columns, column);
        let (y, height) = cut(self.whole.y, self.whole.height, 1, self.rows, row);
        Tile { x, y, width, height }
    }
}

impl Iterator for Grid {
    type Item = Tile;

    fn next(&mut self) -> Option<Tile> {
        let (columns, rows) = (u64::from(self.columns), u64::from(self.rows));
        let number = (self.next < columns * rows).then_some(self.next)?;
        self.next += 1;
        Some(self.part((number % columns) as u32, (number / columns) as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cover(whole: Tile, parts: impl Iterator<Item = Tile>) {
        let mut covered = vec![0; whole.pixels() as usize];
        for part in parts {
            assert!(part.width > 0 && part.height > 0, "{part:?}");
            for index in 0..part.pixels() as u32 {
                let (x, y) = part.pixel(index);
                covered[((y - whole.y) * whole.width + x - whole.x) as usize] += 1;
            }
        }
        assert!(covered.iter().all(|&times| times == 1), "{whole:?}");
    }

    #[test]
    fn parts_have_the_widths_of_whole_packets() {
        for (width, pixels, step) in [(640, 2048, 16), (1000, 4096, 32), (333, 512, 8), (50, 5, 1)]
        {
            let parts: Vec<_> =
                Grid::new(Tile { x: 3, y: 0, width, height: 300 }, pixels).collect();
            for Tile { x, width: wide, .. } in &parts {
                assert!(wide.is_multiple_of(step) || x + wide == width + 3, "{width}: {x} {wide}");
            }
            let mean = width * 300 / parts.len() as u32;
            assert!(2 * u64::from(mean) > pixels, "{width}: {mean} of {pixels} pixels");
        }
    }

    /// The sizes by hand: (image), pixels, widths of the columns, number of rows.
    #[test]
    fn parts_are_cut_in_steps() {
        for ([width, height], pixels, columns, rows) in [
            // Steps of 16 pixels, two of which fit into the root of 2048.
            ([640, 360], 2048, &[32; 20][..], 6),
            // Five steps of 32 in two columns, the last step a pixel wide.
            ([129, 300], 16_384, &[64, 65], 2),
            ([130, 300], 4096, &[32, 64, 34], 5),
            ([50, 10], 5, &[2; 25], 5),
        ] {
            let grid = Grid::new(Tile { x: 0, y: 0, width, height }, pixels);
            let widths: Vec<_> =
                (0..grid.columns).map(|column| grid.part(column, 0).width).collect();
            assert_eq!((&widths[..], grid.rows), (columns, rows), "{width} {height} {pixels}");
        }
    }

    #[test]
    fn parts_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (33, 16), (7, 90), (100, 3), (400, 400), (333, 50)] {
            let whole = Tile { x: 5, y: 8, width, height };
            for pixels in [0, 1, 2, 3, 16, 100, 512, 1 << 20] {
                let grid = Grid::new(whole, pixels);
                assert!(
                    grid.clone().all(|part| part.pixels() <= pixels.max(1)),
                    "{whole:?} {pixels}"
                );
                cover(whole, grid);
            }
            if whole.pixels() > 1 {
                cover(whole, whole.halves().into_iter());
            }
        }
    }
}
