//! Images as textures keep them in memory: with alpha, and with bytes where the file has bytes.

use super::{Mended, Size};
use crate::huge_pages::settle;
use crate::math::{Mask, Real, Word, max};

/// Number of rows in a strip.
const STRIP: u32 = 4;

/// The texels of a texture, row 0 on top. They are stored in strips of four rows, and in each strip
/// column by column, so that the four texels of a lookup are in few cache lines: in one, for most
/// lookups of bytes.
#[derive(Debug, PartialEq)]
pub(crate) struct Texels {
    width: u32,
    height: u32,
    data: Data,
    mended: Mended,
    /// Whether the colours are multiplied by alpha.
    associated: bool,
}

#[derive(Debug, PartialEq)]
enum Data {
    /// RGBA codes, and the linear value of each code of a colour.
    Bytes { codes: Vec<[u8; 4]>, values: Box<[f32; 256]> },
    /// Linear RGBA.
    Floats(Vec<[f32; 4]>),
}

impl Texels {
    /// Bytes of the texels of an image of this size.
    pub(crate) fn bytes_of(size: Size) -> u64 {
        size.pixels.saturating_mul(if size.deep { 16 } else { 4 })
    }

    /// Creates an image from `width × height` texels of bytes, row by row from the top.
    pub(super) fn from_bytes(
        width: u32,
        height: u32,
        codes: Vec<[u8; 4]>,
        values: Box<[f32; 256]>,
    ) -> Self {
        let codes = in_strips(width, height, codes);
        let data = Data::Bytes { codes, values };
        Self { width, height, data, mended: Mended::default(), associated: false }
    }

    /// Creates an image from `width × height` linear texels, row by row from the top.
    pub(crate) fn from_floats(width: u32, height: u32, texels: Vec<[f32; 4]>) -> Self {
        let data = Data::Floats(in_strips(width, height, texels));
        Self { width, height, data, mended: Mended::default(), associated: false }
    }

    /// The image, whose colours are multiplied by alpha if `associated`.
    pub(crate) fn with_associated(self, associated: bool) -> Self {
        Self { associated, ..self }
    }

    /// Whether the colours are multiplied by alpha.
    pub(crate) fn associated(&self) -> bool {
        self.associated
    }

    /// The image, whose values were mended as `mended` says.
    pub(super) fn with_mended(self, mended: Mended) -> Self {
        Self { mended, ..self }
    }

    /// The texels whose values were mended.
    pub(crate) fn mended(&self) -> Mended {
        self.mended
    }

    /// Width in texels.
    pub(crate) fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels.
    pub(crate) fn height(&self) -> u32 {
        self.height
    }

    /// Number of texels.
    pub(crate) fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The index of the texel in column `x` and row `y` of an image of this size.
    #[inline(always)]
    pub(crate) fn index<R: Real>([x, y]: [R::Word; 2], [width, height]: [R::Word; 2]) -> R::Word {
        let strip = R::Word::splat(STRIP);
        let row = y & R::Word::splat(STRIP - 1);
        let first = y.wrapping_sub(row);
        let left = height.wrapping_sub(first);
        let rows = left.le(strip).select(left, strip);
        first.wrapping_mul(width).wrapping_add(x.wrapping_mul(rows)).wrapping_add(row)
    }

    /// Linear RGBA of the texel in column `x` and row `y`.
    #[inline(always)]
    pub(crate) fn get(&self, x: u32, y: u32) -> [f32; 4] {
        self.at(Self::index::<f32>([x, y], [self.width, self.height]))
    }

    /// Linear RGBA of the texel with this index.
    #[inline(always)]
    pub(crate) fn at(&self, index: u32) -> [f32; 4] {
        self.value(self.fetch(index))
    }

    /// What [`value`](Self::value) needs of the texel with this index: its code, or the index itself
    /// for floats.
    #[inline(always)]
    pub(crate) fn fetch(&self, index: u32) -> u32 {
        match &self.data {
            Data::Bytes { codes, .. } => u32::from_le_bytes(codes[index as usize]),
            Data::Floats(_) => index,
        }
    }

    /// Linear RGBA of a texel that was fetched.
    #[inline(always)]
    pub(crate) fn value(&self, fetched: u32) -> [f32; 4] {
        match &self.data {
            Data::Bytes { values, .. } => {
                let [r, g, b, a] = fetched.to_le_bytes();
                let value = |code: u8| values[usize::from(code)];
                [value(r), value(g), value(b), f32::from(a) * (1.0 / 255.0)]
            }
            Data::Floats(texels) => texels[fetched as usize],
        }
    }

    /// The largest value of all channels, at least 1.
    pub(crate) fn largest(&self) -> f32 {
        match &self.data {
            Data::Bytes { .. } => 1.0,
            Data::Floats(texels) => {
                texels.iter().flatten().fold(1.0, |most, &value| max(most, value))
            }
        }
    }

    /// The largest colour after a division by alpha, at least 1. Compression makes some larger than they were, so those
    /// slightly above 1 count as 1.
    pub(crate) fn largest_divided(&self) -> f32 {
        let quotients = |[r, g, b, alpha]: [f32; 4]| {
            let divided = (alpha > 0.0).then(|| [r, g, b].map(|value| value / alpha));
            divided.into_iter().flatten()
        };
        let all = (0..self.len()).flat_map(|index| quotients(self.at(index as u32)));
        let most = all.fold(1.0, max);
        if most <= 1.01 { 1.0 } else { most }
    }

    /// Whether any colour is not black.
    pub(crate) fn emits(&self) -> bool {
        (0..self.len()).any(|index| self.at(index as u32)[..3] != [0.0; 3])
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> u64 {
        let each = match self.data {
            Data::Bytes { .. } => 4,
            Data::Floats(_) => 16,
        };
        each * self.len() as u64
    }

    /// BLAKE3 over the size and the linear texels, in hexadecimal.
    pub(crate) fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.width.to_le_bytes());
        hasher.update(&self.height.to_le_bytes());
        let mut row = Vec::with_capacity(16 * self.width as usize);
        for y in 0..self.height {
            row.clear();
            let texels = (0..self.width).map(|x| self.get(x, y));
            row.extend(texels.flatten().flat_map(f32::to_le_bytes));
            hasher.update(&row);
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// Moves the texels of an image from rows to strips.
fn in_strips<T: Copy>(width: u32, height: u32, rows: Vec<T>) -> Vec<T> {
    let (width, height) = (width as usize, height as usize);
    assert_eq!(rows.len(), width * height);
    let mut strips = Vec::with_capacity(rows.len());
    for strip in rows.chunks(STRIP as usize * width) {
        for x in 0..width {
            strips.extend(strip.chunks_exact(width).map(|row| row[x]));
        }
    }
    drop(rows);
    settle(strips)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_found_in_strips_of_any_size() {
        for (width, height) in [(1, 1), (3, 4), (5, 7), (4, 9), (1, 6), (9, 2)] {
            let value = |x: u32, y: u32| [x as f32, y as f32, 0.0, 1.0];
            let rows = (0..height).flat_map(|y| (0..width).map(move |x| value(x, y)));
            let texels = Texels::from_floats(width, height, rows.collect());
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                assert_eq!(texels.get(x, y), value(x, y), "of {width} × {height}");
            }
        }
    }
}
