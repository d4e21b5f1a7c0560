//! Image textures.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TextureParameters, TexturePoint};
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::Result;
use crate::image::{Encoding, Texels};
use crate::math::precise::sin_cos_degrees;
use crate::math::{Mask, Real, Row, Vector, Word, clamp, whole};
use crate::shading::{ImageFile, Images};

/// An image mapped to the surface's texture coordinates. v = 0 is the bottom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Image {
    /// Path of the image, relative to the scene file.
    pub file: String,
    /// Number of the image in a glTF file, from 0; for such files only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<u32>,
    /// What the integers in the file mean.
    #[serde(default, skip_serializing_if = "is_default")]
    pub encoding: Encoding,
    /// The set of texture coordinates, 0 or 1. Surfaces with a single set use that.
    #[serde(default, skip_serializing_if = "is_default")]
    pub uv: u32,
    /// How the image continues to the left and right.
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap_u: Wrap,
    /// How the image continues above and below.
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap_v: Wrap,
    /// How values between texels are found.
    #[serde(default, skip_serializing_if = "is_default")]
    pub filter: Filter,
    /// Factors of the texture coordinates, before they are rotated; within ±1e9.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: (f32, f32),
    /// Counter-clockwise rotation of the texture coordinates in degrees, within ±1e9.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: f32,
    /// Added to the texture coordinates at last; within ±1e9.
    #[serde(default, skip_serializing_if = "is_default")]
    pub offset: (f32, f32),
    /// Whether the colours at the vertices of meshes multiply those of the image.
    #[serde(default, skip_serializing_if = "is_default")]
    pub vertex_colors: bool,
    /// For normal maps: a factor of the components along the surface, within ±1e3.
    #[serde(default = "unchanged", skip_serializing_if = "is_unchanged")]
    pub normal_scale: f32,
    /// Whether colours are divided by alpha, after they are interpolated.
    #[serde(skip)]
    divided: bool,
    /// The image, once it is read.
    #[serde(skip)]
    pub(super) texels: Option<Arc<Texels>>,
}

/// How an image continues beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    /// It starts again.
    #[default]
    Repeat,
    /// It is mirrored at every edge.
    Mirror,
    /// Its edge continues.
    Clamp,
}

/// How values between the centres of texels are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    /// By bilinear interpolation of the four nearest texels.
    #[default]
    Bilinear,
    /// From the nearest texel.
    Nearest,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn one() -> (f32, f32) {
    (1.0, 1.0)
}

fn is_one(scale: &(f32, f32)) -> bool {
    *scale == one()
}

fn unchanged() -> f32 {
    1.0
}

fn is_unchanged(scale: &f32) -> bool {
    *scale == unchanged()
}

impl Image {
    /// Creates a texture of the image in `file`, which is read when the scene is resolved.
    pub fn from_file(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            index: None,
            encoding: Encoding::Auto,
            uv: 0,
            wrap_u: Wrap::default(),
            wrap_v: Wrap::default(),
            filter: Filter::default(),
            scale: one(),
            rotation: 0.0,
            offset: (0.0, 0.0),
            vertex_colors: false,
            normal_scale: unchanged(),
            divided: false,
            texels: None,
        }
    }

    /// Creates a normal map from the image in `file`, which is read when the scene is resolved.
    pub fn normals_from_file(file: impl Into<String>) -> Self {
        Self { encoding: Encoding::Linear, ..Self::from_file(file) }
    }

    fn texels(&self) -> &Arc<Texels> {
        self.texels.as_ref().expect("`load` reads the image before it is used")
    }
}

const SECOND_UV: u32 = 1;
const NEAREST: u32 = 2;
const VERTEX_COLORS: u32 = 4;
const NORMALS: u32 = 8;
const DIVIDED: u32 = 256;
/// The bits of the wraps.
const WRAP_U: u32 = 4;
const WRAP_V: u32 = 6;

/// An image and its mapping.
#[derive(Debug)]
pub(crate) struct ImageEntry {
    texels: Arc<Texels>,
    /// Position of u in the image: factors of u and v, and a sum; width.
    across: Row,
    /// Position of v in the image: factors of u and v, and a sum; height.
    up: Row,
    /// The bits below and the wraps as their numbers, the factor of normals, the largest colour, 0.
    flags: Row,
}

impl TextureParameters for Image {
    fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()> {
        e.check(self.uv <= 1, "uv", "0 or 1", self.uv)?;
        let within = |value: f32| value.abs() <= MAX_COORDINATE;
        let Self { scale, rotation, offset, .. } = *self;
        e.check(within(scale.0) && within(scale.1), "scale", "within ±1e9", scale)?;
        e.check(within(rotation), "rotation", "within ±1e9", rotation)?;
        let normal_scale = self.normal_scale;
        e.check(normal_scale.abs() <= 1e3, "normal_scale", "within ±1e3", normal_scale)?;
        e.check(within(offset.0) && within(offset.1), "offset", "within ±1e9", offset)?;
        let image = self.file().expect("every image has a file");
        self.texels = Some(images.texels(e, image, false)?);
        Ok(())
    }

    /// The content replaces the file, the number and the encoding.
    fn identity(&self) -> Value {
        let (file, encoding) = (self.texels().hash(), Encoding::Auto);
        let image = Self { file, index: None, encoding, ..self.clone() };
        let mut identity = json!({ "image": image });
        if self.divided {
            identity["divided"] = true.into();
        }
        identity
    }

    fn file(&self) -> Option<ImageFile<'_>> {
        let Self { ref file, index, encoding, .. } = *self;
        Some(ImageFile { file, index, encoding })
    }

    fn file_mut(&mut self) -> Option<&mut String> {
        Some(&mut self.file)
    }

    fn uses_vertex_colors(&self) -> bool {
        self.vertex_colors
    }

    fn check_as_color(&self, e: &Location<'_>, name: &str) -> Result<()> {
        match self.normal_scale {
            1.0 => Ok(()),
            _ => Err(
                e.error(format!("{name} must not have a `normal_scale`, which is for normal maps"))
            ),
        }
    }

    fn holds_normals(&self) -> bool {
        self.encoding == Encoding::Linear && self.uv == 0
    }

    fn largest(&self) -> f32 {
        if self.divided { self.texels().largest_divided() } else { self.texels().largest() }
    }

    fn divide_by_alpha(&mut self) {
        self.divided = self.encoding == Encoding::Auto && self.texels().associated();
    }

    fn texels(&self) -> Option<&Arc<Texels>> {
        self.texels.as_ref()
    }
}

impl TextureModel for Image {
    type Entry = ImageEntry;

    fn entry(&self) -> ImageEntry {
        let texels = Arc::clone(self.texels());
        let (sin, cos) = sin_cos_degrees(self.rotation.into());
        let (su, sv) = (f64::from(self.scale.0), f64::from(self.scale.1));
        let row = |a: f64, b: f64, c: f32, size: u32| {
            [a as f32, b as f32, c, size as f32].map(f32::to_bits)
        };
        let flag = |flag: u32, is_set: bool| if is_set { flag } else { 0 };
        ImageEntry {
            across: row(cos * su, -sin * sv, self.offset.0, texels.width()),
            up: row(sin * su, cos * sv, self.offset.1, texels.height()),
            flags: [
                flag(SECOND_UV, self.uv == 1)
                    | flag(NEAREST, self.filter == Filter::Nearest)
                    | flag(VERTEX_COLORS, self.vertex_colors)
                    | flag(NORMALS, self.normal_scale != 1.0)
                    | flag(DIVIDED, self.divided)
                    | (self.wrap_u as u32) << WRAP_U
                    | (self.wrap_v as u32) << WRAP_V,
                self.normal_scale.to_bits(),
                if self.divided { self.largest().to_bits() } else { 0 },
                0,
            ],
            texels,
        }
    }

    #[inline(never)]
    fn value<R: Real>(table: &[ImageEntry], index: R::Word, at: &impl TexturePoint<R>) -> Rgba<R> {
        let place = R::index_of_few(index, table.len());
        let (words, _) = R::gather(table, place, |image| &image.flags);
        let flags = words[0].to_bits();
        let has = |flag: u32| !(flags & R::Word::splat(flag)).eq(R::Word::splat(0));
        let (mut u, mut v) = at.uv();
        let second = has(SECOND_UV);
        if second.any() {
            let (second_u, second_v) = at.second_uv();
            (u, v) = (second.select(second_u, u), second.select(second_v, v));
        }
        let (across, width) = R::gather(table, place, |image| &image.across);
        let (up, height) = R::gather(table, place, |image| &image.up);
        let x = across[0] * u + across[1] * v + across[2];
        let y = up[0] * u + up[1] * v + up[2];
        let wraps = |shift: u32, wrap: Wrap| {
            (flags >> shift & R::Word::splat(3)).eq(R::Word::splat(wrap as u32))
        };
        let [repeat_u, repeat_v] = [WRAP_U, WRAP_V].map(|shift| wraps(shift, Wrap::Repeat));
        let x = wrapped(x, repeat_u, wraps(WRAP_U, Wrap::Mirror)) * width;
        let y = (R::ONE - wrapped(y, repeat_v, wraps(WRAP_V, Wrap::Mirror))) * height;
        let nearest = has(NEAREST);
        let (x0, x1, fx) = taps(x, width, nearest, repeat_u);
        let (y0, y1, fy) = taps(y, height, nearest, repeat_v);
        let [x0, x1, y0, y1] = [whole(x0), whole(x1), whole(y0), whole(y1)];
        let size = [whole(width), whole(height)];
        let tap = |x: R::Word, y: R::Word| R::from_bits(Texels::index::<R>([x, y], size));
        let indices = [tap(x0, y0), tap(x1, y0), tap(x0, y1), tap(x1, y1)];
        let texels = |image: u32| &*table[image as usize].texels;
        // Most texels are in no cache. A loop that does nothing else waits for many at a time.
        let fetched = R::each_lane(index, indices, |image, [a, b, c, d]| {
            let texels = texels(image);
            let fetch = |index: f32| f32::from_bits(texels.fetch(index.to_bits()));
            [fetch(a), fetch(b), fetch(c), fetch(d)]
        });
        let taps = R::each_lane(index, fetched, |image, [a, b, c, d]| {
            let texels = texels(image);
            let value = |fetched: f32| texels.value(fetched.to_bits());
            let taps = [value(a), value(b), value(c), value(d)];
            std::array::from_fn::<f32, 16, _>(|i| taps[i / 4][i % 4])
        });
        let channel = |c: usize| {
            let row = |first: usize| taps[first + c] * (R::ONE - fx) + taps[first + 4 + c] * fx;
            row(0) * (R::ONE - fy) + row(8) * fy
        };
        let mut color = R::Vec3::new(channel(0), channel(1), channel(2));
        let divided = has(DIVIDED);
        if divided.any() {
            let alpha = channel(3);
            let alpha = alpha.gt(R::ZERO).select(alpha, R::ONE);
            // A glow without alpha makes colours brighter than those of all texels.
            let quotient = |c: R| clamp(c / alpha, R::ZERO, words[2]);
            let colors = [color[0], color[1], color[2]].map(quotient);
            color = divided.select(R::Vec3::new(colors[0], colors[1], colors[2]), color);
        }
        let colored = has(VERTEX_COLORS);
        if colored.any() {
            color = color * colored.select(at.vertex_color(), R::Vec3::gray(R::ONE));
        }
        let normals = has(NORMALS);
        if normals.any() {
            // A channel of 0.5 is a component of 0.
            let scaled = |c: R| (c - R::splat(0.5)) * words[1] + R::splat(0.5);
            let scaled = R::Vec3::new(scaled(color[0]), scaled(color[1]), color[2]);
            color = normals.select(scaled, color);
        }
        (color, channel(3))
    }
}

/// Moves a coordinate into [0, 1]. NaN becomes 0.
#[inline(always)]
fn wrapped<R: Real>(x: R, repeats: R::Mask, mirrors: R::Mask) -> R {
    let half = x * 0.5;
    let pair = (half - half.floor()) * 2.0;
    let mirrored = pair.gt(R::ONE).select(R::splat(2.0) - pair, pair);
    let inside = mirrors.select(mirrored, x);
    clamp(repeats.select(x - x.floor(), inside), R::ZERO, R::ONE)
}

/// The two texels whose centres are on both sides of the position `x` in [0, `size`], and the weight
/// of the second. With `nearest`, both are the texel at `x`.
#[inline(always)]
fn taps<R: Real>(x: R, size: R, nearest: R::Mask, repeats: R::Mask) -> (R, R, R) {
    let last = size - R::ONE;
    let before = nearest.select(x, x - R::splat(0.5)).floor();
    let weight = nearest.select(R::ZERO, x - R::splat(0.5) - before);
    let after = before + R::ONE;
    let over = after.gt(last);
    let first = before.lt(R::ZERO).select(repeats.select(last, R::ZERO), before);
    let second = over.select(repeats.select(R::ZERO, last), after);
    (clamp(first, R::ZERO, last), second, weight)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[derive(Clone, Copy)]
    struct At(f32, f32);

    impl TexturePoint<f32> for At {
        fn point(&self) -> Vec3 {
            unreachable!("an image does not depend on the position")
        }

        fn uv(&self) -> (f32, f32) {
            (self.0, self.1)
        }

        fn second_uv(&self) -> (f32, f32) {
            (self.1, self.0)
        }

        fn vertex_color(&self) -> Vec3 {
            Vec3::new(0.5, 0.25, 1.0)
        }
    }

    /// An image of 2 × 2 texels: 0 and 4 above 8 and 12.
    fn image() -> Image {
        let texels = [0.0, 4.0, 8.0, 12.0].map(|v| [v, v, v, 1.0 - v / 16.0]).to_vec();
        let texels = Some(Arc::new(Texels::from_floats(2, 2, texels)));
        Image { texels, ..Image::from_file("") }
    }

    fn value(image: &Image, u: f32, v: f32) -> f32 {
        let (color, alpha) = Image::value::<f32>(&[image.entry()], 0, &At(u, v));
        assert!((alpha - (1.0 - color.x / 16.0)).abs() < 1e-6);
        color.x
    }

    #[test]
    fn images_are_filtered_and_continue_beyond_their_edges() {
        let image = image();
        let at = |u, v| value(&image, u, v);
        assert_eq!(at(0.25, 0.75), 0.0, "middle of the upper left texel");
        assert_eq!(at(0.75, 0.25), 12.0, "middle of the lower right texel");
        assert_eq!(at(0.5, 0.5), 6.0);
        assert_eq!((at(1.25, 0.75), at(-0.25, 0.25)), (0.0, 12.0), "u repeats");
        assert_eq!((at(0.25, 1.75), at(0.75, -0.75)), (0.0, 12.0), "v repeats");
        assert_eq!((at(0.0, 0.75), at(0.25, 1.0)), (2.0, 4.0), "opposite edges are neighbours");
        assert_eq!(at(1e30, 0.75), at(0.0, 0.75));
        assert_eq!(at(f32::NAN, f32::NAN), at(0.0, 0.0));
        let clamped = Image { wrap_u: Wrap::Clamp, wrap_v: Wrap::Clamp, ..image.clone() };
        assert_eq!((value(&clamped, 0.0, 1.0), value(&clamped, 7.0, -3.0)), (0.0, 12.0));
        let mirrored = Image { wrap_u: Wrap::Mirror, wrap_v: Wrap::Mirror, ..image };
        for (u, v) in [(0.3, 0.6), (0.75, 0.75), (0.02, 0.98)] {
            let here = value(&mirrored, u, v);
            assert!((value(&mirrored, -u, v) - here).abs() < 1e-5);
            assert!((value(&mirrored, u, 2.0 - v) - here).abs() < 1e-5);
            assert!((value(&mirrored, u + 4.0, v - 2.0) - here).abs() < 1e-4);
        }
    }

    /// The colour (0.8, 0.4, 0.2) with an alpha of 0.5, beside a hole.
    #[test]
    fn colors_that_are_multiplied_by_alpha_are_divided_once() {
        let texels = vec![[0.4, 0.2, 0.1, 0.5], [0.0; 4]];
        let texels = Texels::from_floats(2, 1, texels).with_associated(true);
        let mut image = Image { texels: Some(Arc::new(texels)), ..Image::from_file("") };
        let at = |image: &Image, u| Image::value::<f32>(&[image.entry()], 0, &At(u, 0.5));
        assert_eq!(at(&image, 0.25), (Vec3::new(0.4, 0.2, 0.1), 0.5));
        let identity = image.identity();
        image.divide_by_alpha();
        assert_ne!(image.identity(), identity, "the scene has another hash");
        for (u, alpha) in [(0.25, 0.5), (0.375, 0.375), (0.5, 0.25)] {
            assert_eq!(at(&image, u), (Vec3::new(0.8, 0.4, 0.2), alpha), "{u}");
        }
        assert_eq!((at(&image, 0.75).1, image.largest()), (0.0, 1.0));
    }

    #[test]
    fn colors_of_vertices_and_factors_of_normals_change_values() {
        let colored = Image { vertex_colors: true, ..image() };
        let color = |image: &Image| Image::value::<f32>(&[image.entry()], 0, &At(0.75, 0.25)).0;
        assert_eq!(color(&colored), Vec3::new(6.0, 3.0, 12.0));
        let scaled = Image { normal_scale: -0.5, ..image() };
        assert_eq!(color(&scaled), Vec3::new(-5.25, -5.25, 12.0));
    }

    #[test]
    fn nearest_texels_have_edges_and_transforms_move_them() {
        let nearest = Image { filter: Filter::Nearest, ..image() };
        for (u, v, want) in
            [(0.49, 0.51, 0.0), (0.51, 0.51, 4.0), (0.1, 0.49, 8.0), (1.0, 0.0, 8.0)]
        {
            assert_eq!(value(&nearest, u, v), want, "{u} {v}");
        }
        let second = Image { uv: 1, ..nearest.clone() };
        assert_eq!(value(&second, 0.1, 0.9), 12.0, "the coordinates are exchanged");
        let scaled = Image { scale: (2.0, 1.0), ..nearest.clone() };
        assert_eq!((value(&scaled, 0.3, 0.7), value(&scaled, 0.6, 0.7)), (4.0, 0.0));
        // (0.25, 0.25) turns to (−0.25, 0.25), and moves by 1 and by (0.5, 0).
        let turned = Image { rotation: 90.0, offset: (0.5, 1.0), ..nearest };
        assert_eq!(value(&turned, 0.25, 0.25), 8.0);
    }
}
