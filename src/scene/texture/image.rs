//! Image textures.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{TextureModel, TexturePoint};
use crate::error::Result;
use crate::image::{Encoding, Image as Pixels};
use crate::math::{Mask, Real, Vector, Word, clamp};
use crate::scene::files::Images;
use crate::scene::place::Element;

/// An image mapped to the surface's texture coordinates, with bilinear filtering. u repeats, v is
/// clamped, and v = 0 is the bottom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Image {
    /// Path of the image, relative to the scene file.
    pub file: String,
    /// What the integers in the file mean.
    #[serde(default, skip_serializing_if = "is_default")]
    pub encoding: Encoding,
    /// The set of texture coordinates, 0 or 1. Surfaces with a single set use that.
    #[serde(default, skip_serializing_if = "is_default")]
    pub uv: u32,
    /// The image, once it is read.
    #[serde(skip)]
    pub(super) pixels: Option<Arc<Pixels>>,
}

impl Image {
    /// Creates a texture of the image in `file`, which is read when the scene is resolved.
    pub fn from_file(file: impl Into<String>) -> Self {
        Self { file: file.into(), encoding: Encoding::Auto, uv: 0, pixels: None }
    }

    /// Creates a normal map from the image in `file`, which is read when the scene is resolved.
    pub fn normals_from_file(file: impl Into<String>) -> Self {
        Self { encoding: Encoding::Linear, ..Self::from_file(file) }
    }

    fn pixels(&self) -> &Arc<Pixels> {
        self.pixels.as_ref().expect("`load` reads the image before it is used")
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl TextureModel for Image {
    /// The pixels, and the set of texture coordinates.
    type Entry = (Arc<Pixels>, u32);

    fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()> {
        e.check(self.uv <= 1, "uv", "0 or 1", self.uv)?;
        self.pixels = Some(images.albedo_map(e, &self.file, self.encoding)?);
        Ok(())
    }

    fn identity(&self) -> Value {
        match self.uv {
            0 => json!({ "image": self.pixels().hash() }),
            set => json!({ "image": self.pixels().hash(), "uv": set }),
        }
    }

    fn holds_normals(&self) -> bool {
        self.encoding == Encoding::Linear && self.uv == 0
    }

    fn image(&self) -> Option<Arc<Pixels>> {
        self.pixels.clone()
    }

    fn entry(&self) -> (Arc<Pixels>, u32) {
        (Arc::clone(self.pixels()), self.uv)
    }

    #[inline(never)]
    fn color<R: Real>(table: &[Self::Entry], index: R::Word, at: &impl TexturePoint<R>) -> R::Vec3 {
        let (mut u, mut v) = at.uv();
        let set = R::each_word(index, |image| table[image as usize].1);
        let first = set.eq(R::Word::splat(0));
        if (!first).any() {
            let (second_u, second_v) = at.second_uv();
            (u, v) = (first.select(u, second_u), first.select(v, second_v));
        }
        let color =
            |image: u32, [u, v]: [f32; 2]| bilinear(&table[image as usize].0, u, v).to_array();
        let [r, g, b] = R::each_lane(index, [u, v], color);
        R::Vec3::new(r, g, b)
    }
}

fn bilinear(image: &Pixels, u: f32, v: f32) -> Vec3 {
    let (width, height) = (image.width(), image.height());
    // 1 stays 1, the right edge.
    let u = if (0.0..=1.0).contains(&u) { u } else { u - u.floor() };
    let x = clamp(u, 0.0, 1.0) * width as f32 - 0.5;
    let y = (1.0 - clamp(v, 0.0, 1.0)) * height as f32 - 0.5;
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (x0, y0) = (x0 as i32, y0 as i32);
    let pixel = |x: i32, y: i32| {
        let x = if x < 0 { width - 1 } else { x as u32 % width };
        let y = y.clamp(0, height as i32 - 1) as u32;
        Vec3::from_array(image.pixels()[(y * width + x) as usize])
    };
    let row = |y| pixel(x0, y) * (1.0 - fx) + pixel(x0 + 1, y) * fx;
    row(y0) * (1.0 - fy) + row(y0 + 1) * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_filtered_and_wrap_around() {
        let image = Pixels::from_pixels(2, 2, vec![[0.0; 3], [4.0; 3], [8.0; 3], [12.0; 3]]);
        let at = |u, v| bilinear(&image, u, v).x;
        assert_eq!(at(0.25, 0.75), 0.0, "middle of the upper left pixel");
        assert_eq!(at(0.75, 0.25), 12.0, "middle of the lower right pixel");
        assert_eq!(at(0.5, 0.5), 6.0);
        assert_eq!(at(0.0, 1.0), 2.0, "u wraps, v is clamped");
        assert_eq!(at(1.0, 0.0), 10.0);
        assert_eq!((at(1.25, 0.75), at(-0.25, 0.25)), (0.0, 12.0), "u repeats");
        assert_eq!(at(1e30, 0.75), at(0.0, 0.75));
        assert_eq!(at(f32::NAN, f32::NAN), at(0.0, 0.0));
    }
}
