//! Images as textures keep them in memory: with alpha, and with bytes where the file has bytes.

use super::size::Size;
use crate::math::max;

/// The texels of a texture, row 0 on top.
#[derive(Debug, PartialEq)]
pub(crate) struct Texels {
    width: u32,
    height: u32,
    data: Data,
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

    /// Creates an image from `width × height` texels of bytes.
    pub(super) fn from_bytes(
        width: u32,
        height: u32,
        codes: Vec<[u8; 4]>,
        values: Box<[f32; 256]>,
    ) -> Self {
        assert_eq!(codes.len(), width as usize * height as usize);
        Self { width, height, data: Data::Bytes { codes, values } }
    }

    /// Creates an image from `width × height` linear texels.
    pub(crate) fn from_floats(width: u32, height: u32, texels: Vec<[f32; 4]>) -> Self {
        assert_eq!(texels.len(), width as usize * height as usize);
        Self { width, height, data: Data::Floats(texels) }
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

    /// Linear RGBA of the texel with this index, row by row from the top.
    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> [f32; 4] {
        match &self.data {
            Data::Bytes { codes, values } => {
                let [r, g, b, a] = codes[index];
                let [r, g, b] = [r, g, b].map(|code| values[usize::from(code)]);
                [r, g, b, f32::from(a) * (1.0 / 255.0)]
            }
            Data::Floats(texels) => texels[index],
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

    /// A texel with a value that is negative, infinite or NaN, if there is one.
    pub(crate) fn unusable(&self) -> Option<[f32; 4]> {
        let usable = |value: &f32| (0.0..=f32::MAX).contains(value);
        match &self.data {
            Data::Bytes { .. } => None,
            Data::Floats(texels) => texels.iter().find(|texel| !texel.iter().all(usable)).copied(),
        }
    }

    /// Whether any colour is not black.
    pub(crate) fn shines(&self) -> bool {
        (0..self.len()).any(|index| self.get(index)[..3] != [0.0; 3])
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
        for first in (0..self.len()).step_by(self.width as usize) {
            row.clear();
            let texels = (first..first + self.width as usize).map(|index| self.get(index));
            row.extend(texels.flatten().flat_map(f32::to_le_bytes));
            hasher.update(&row);
        }
        hasher.finalize().to_hex().to_string()
    }
}
