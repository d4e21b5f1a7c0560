//! Textures, one file per kind.
//!
//! The list in `textures!` generates the enum of scene files, the tables and the dispatch.

mod checker;
mod color;
mod image;
mod number;
mod product;
mod reference;
mod solid;
mod vertex_color;

use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use crate::image::Encoding;
pub use color::Color;
pub use image::{Filter, Wrap};
pub use number::{Channel, Number};
pub use reference::TextureRef;

use product::Product;

use super::files::Images;
use super::place::Element;
use crate::error::Result;
use crate::image::Texels;
use crate::math::{Mask, Real, Row, Vector, Word, row};

/// The properties of a surface point, or of one per lane, that textures depend on.
pub(crate) trait TexturePoint<R: Real>: Copy {
    /// Position of the point.
    fn point(&self) -> R::Vec3;

    /// Texture coordinates, both in [0, 1] up to rounding unless a mesh has its own.
    fn uv(&self) -> (R, R);

    /// Texture coordinates of the second set, or of the first if the surface has only one.
    fn second_uv(&self) -> (R, R);

    /// The colour of the surface itself, or white if it has none.
    fn vertex_color(&self) -> R::Vec3;
}

/// A linear colour and alpha, or one per lane.
pub(crate) type Rgba<R> = (<R as Real>::Vec3, R);

/// A kind of texture: its parameters, its table and its evaluation.
pub(crate) trait TextureModel {
    /// The parameters as stored in the table of this kind.
    type Entry: Debug + Send + Sync;

    /// Checks the parameters and reads the files that they name.
    fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()>;

    /// Returns everything that determines the colours, for the hash of the scene.
    fn identity(&self) -> Value;

    /// Whether every texture of this kind has the same colour everywhere.
    const CONSTANT: bool = false;

    /// Returns the texture's colour if it is the same everywhere.
    fn constant(&self) -> Option<[f32; 3]> {
        None
    }

    /// Returns a bound on all its colours and alpha values, none of which is negative.
    fn largest(&self) -> f32 {
        1.0
    }

    /// Returns the texture's image, if it has one and it is loaded.
    fn texels(&self) -> Option<&Arc<Texels>> {
        None
    }

    /// Whether the texture depends on the colours of vertices.
    const USES_VERTEX_COLORS: bool = false;

    /// Whether the texture can be a normal map.
    fn holds_normals(&self) -> bool {
        false
    }

    /// Returns the parameters for the table.
    fn entry(&self) -> Self::Entry;

    /// Returns the colours and alpha of the entries at `index` at the point `at`.
    fn value<R: Real>(table: &[Self::Entry], index: R::Word, at: &impl TexturePoint<R>) -> Rgba<R>;
}

macro_rules! textures {
    ($($(#[doc = $doc:literal])* $name:ident in $module:ident,)*) => {
        $(pub use $module::$name;)*

        /// A colour that varies over a surface.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum Texture {
            $($(#[doc = $doc])* $name($name),)*
        }

        $(impl From<$name> for Texture {
            fn from(texture: $name) -> Self {
                Self::$name(texture)
            }
        })*

        impl Texture {
            pub(super) fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()> {
                match self {
                    $(Self::$name(texture) => texture.load(e, images),)*
                }
            }

            pub(super) fn texels(&self) -> Option<&Arc<Texels>> {
                match self {
                    $(Self::$name(texture) => TextureModel::texels(texture),)*
                }
            }

            pub(super) fn largest(&self) -> f32 {
                match self {
                    $(Self::$name(texture) => texture.largest(),)*
                }
            }

            pub(super) fn uses_vertex_colors(&self) -> bool {
                match self {
                    $(Self::$name(_) => $name::USES_VERTEX_COLORS,)*
                }
            }

            pub(super) fn holds_normals(&self) -> bool {
                match self {
                    $(Self::$name(texture) => texture.holds_normals(),)*
                }
            }

            pub(super) fn identity(&self) -> Value {
                match self {
                    $(Self::$name(texture) => texture.identity(),)*
                }
            }
        }

        #[derive(Clone, Copy)]
        enum TextureKind {
            $($name,)*
        }

        /// The textures of a scene, one table per kind.
        #[derive(Debug, Default)]
        pub(crate) struct TextureTables {
            $($module: Vec<<$name as TextureModel>::Entry>,)*
            /// The textures in the tables, with their codes.
            known: Vec<(Arc<Texture>, u32)>,
            /// Number of parameters that are textures.
            uses: usize,
        }

        impl TextureTables {
            /// Adds a texture to its table and returns its code as `Err`. If the texture has the
            /// same colour everywhere, returns that colour as `Ok` and adds nothing.
            fn push(&mut self, texture: &Texture) -> std::result::Result<[f32; 3], u32> {
                match texture {
                    $(Texture::$name(texture) => {
                        if let Some(color) = texture.constant() {
                            return Ok(color);
                        }
                        let entry = self.$module.len() as u32;
                        self.$module.push(texture.entry());
                        Err(((TextureKind::$name as u32 + 1) << KIND_SHIFT) | entry)
                    })*
                }
            }

            /// Returns `value`, but the colour and alpha of the texture in the lanes whose `code`
            /// is of one.
            #[inline(always)]
            fn textured<R: Real>(
                &self,
                mut value: Rgba<R>,
                code: R::Word,
                at: &impl TexturePoint<R>,
            ) -> Rgba<R> {
                $(if !$name::CONSTANT {
                    let kind = R::Word::splat(TextureKind::$name as u32 + 1);
                    let here = (code >> KIND_SHIFT).eq(kind);
                    if here.any() {
                        let entry = code & R::Word::splat((1 << CHANNEL_SHIFT) - 1);
                        let entry = here.select(entry, R::Word::splat(0));
                        // Pass a copy: if the original were passed by reference, the compiler would
                        // always keep it in memory instead of in registers.
                        let at = *at;
                        let found = $name::value(&self.$module, entry, &at);
                        value.0 = here.select(found.0, value.0);
                        value.1 = here.select(found.1, value.1);
                    }
                })*
                value
            }
        }
    };
}

textures! {
    /// A constant colour.
    Solid in solid,
    /// A 3-D checker.
    Checker in checker,
    /// An image mapped to the surface's texture coordinates.
    Image in image,
    /// The colours at the vertices of a mesh.
    VertexColor in vertex_color,
}

/// Number of low bits in a texture's code that hold its index in its table and the channel. The
/// bits above them hold its kind plus 1, so that code 0 means no texture.
const KIND_SHIFT: u32 = 28;
/// Number of low bits that hold the index. The bits from here to the kind hold the channel.
const CHANNEL_SHIFT: u32 = 26;

impl TextureTables {
    /// Returns the number of parameters that are textures.
    pub(super) fn uses(&self) -> usize {
        self.uses
    }

    /// Returns the code of a texture, or its colour as `Ok` if that is the same everywhere.
    fn code(&mut self, texture: &TextureRef) -> std::result::Result<[f32; 3], u32> {
        let texture = texture.get();
        let known = self.known.iter().find(|(known, _)| Arc::ptr_eq(known, texture));
        let code = match known {
            Some((_, code)) => *code,
            None => match self.push(texture) {
                Ok(color) => return Ok(color),
                Err(code) => {
                    let entry = code & ((1 << KIND_SHIFT) - 1);
                    assert!(entry < 1 << CHANNEL_SHIFT, "too many textures of one kind");
                    self.known.push((Arc::clone(texture), code));
                    code
                }
            },
        };
        self.uses += 1;
        Err(code)
    }

    /// Returns the row of a colour: (the colour, 0), or (the factor, code) for a texture.
    pub(super) fn row(&mut self, color: &Color) -> Row {
        match color {
            Color::Rgb(rgb) => row((*rgb).into(), 0.0),
            Color::Texture { texture, factor } => match self.code(texture) {
                Ok(color) => row(Vec3::from(color) * Vec3::from(*factor), 0.0),
                Err(code) => row((*factor).into(), f32::from_bits(code)),
            },
        }
    }

    /// Returns two words for a number: the number and 0, or the factor and the code for a texture.
    pub(super) fn number(&mut self, number: &Number) -> [u32; 2] {
        match number {
            Number::Value(value) => [value.to_bits(), 0],
            Number::Texture { texture, channel, factor } => match self.code(texture) {
                Ok([r, g, b]) => [([r, g, b, 1.0][*channel as usize] * factor).to_bits(), 0],
                Err(code) => [factor.to_bits(), code | (*channel as u32) << CHANNEL_SHIFT],
            },
        }
    }

    /// Returns the code of a normal map, or 0 without one.
    pub(super) fn normal_code(&mut self, normal: Option<&TextureRef>) -> u32 {
        normal.map_or(0, |normal| self.code(normal).expect_err("a normal map is an image"))
    }

    /// Returns the colours of the normal maps with these codes at the point `at`. Code 0 gives black.
    #[inline(always)]
    pub(super) fn normal<R: Real>(&self, code: R::Word, at: &impl TexturePoint<R>) -> R::Vec3 {
        self.textured((R::Vec3::zero(), R::ZERO), code, at).0
    }

    /// Returns the colour of a row at the point `at`.
    #[inline(always)]
    pub(super) fn color<R: Real>(
        &self,
        (color, code): (R::Vec3, R),
        at: &impl TexturePoint<R>,
    ) -> R::Vec3 {
        let code = code.to_bits();
        let plain = code.eq(R::Word::splat(0));
        if !(!plain).any() {
            return color;
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        color * self.textured(white, code, at).0
    }

    /// Returns the number for two words of [`TextureTables::number`] at the point `at`.
    #[inline(always)]
    pub(super) fn number_at<R: Real>(
        &self,
        [number, code]: [R; 2],
        at: &impl TexturePoint<R>,
    ) -> R {
        let code = code.to_bits();
        let plain = code.eq(R::Word::splat(0));
        if !(!plain).any() {
            return number;
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        let texture = code & R::Word::splat(!(3 << CHANNEL_SHIFT));
        number * channel(self.textured(white, texture, at), code)
    }

    /// As [`number_at`](Self::number_at), for two numbers. If they are channels of the same
    /// textures, these are evaluated once.
    #[inline(always)]
    pub(super) fn two_numbers_at<R: Real>(
        &self,
        numbers: [[R; 2]; 2],
        at: &impl TexturePoint<R>,
    ) -> [R; 2] {
        let [[first, code], [second, other]] = numbers;
        let texture = |code: R| code.to_bits() & R::Word::splat(!(3 << CHANNEL_SHIFT));
        let (one, two) = (texture(code), texture(other));
        let plain = (one | two).eq(R::Word::splat(0));
        if (!one.eq(two)).any() || !(!plain).any() {
            return [self.number_at([first, code], at), self.number_at([second, other], at)];
        }
        let white = (R::Vec3::gray(R::ONE), R::ONE);
        let value = self.textured(white, one, at);
        [first * channel(value, code.to_bits()), second * channel(value, other.to_bits())]
    }
}

/// The channel of `value` that the code of a number names.
#[inline(always)]
fn channel<R: Real>((color, alpha): Rgba<R>, code: R::Word) -> R {
    let named = (code >> CHANNEL_SHIFT) & R::Word::splat(3);
    let is = |c: Channel| named.eq(R::Word::splat(c as u32));
    let red_or_alpha = is(Channel::A).select(alpha, color[0]);
    is(Channel::G).select(color[1], is(Channel::B).select(color[2], red_or_alpha))
}
