//! Textures, one file per kind.
//!
//! The list in `textures!` generates the enum of scene files, the tables and the dispatch.

mod checker;
mod color;
mod image;
mod solid;
mod vertex_color;

use std::fmt::Debug;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use crate::image::Encoding;
pub use color::Color;

use super::files::Images;
use super::place::Element;
use crate::error::Result;
use crate::image::Image as Pixels;
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

    /// Returns the texture's image, if it has one and it is loaded.
    fn image(&self) -> Option<Arc<Pixels>> {
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

    /// Returns the colours of the entries at `index` at the point `at`.
    fn color<R: Real>(table: &[Self::Entry], index: R::Word, at: &impl TexturePoint<R>) -> R::Vec3;
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

            pub(super) fn image(&self) -> Option<Arc<Pixels>> {
                match self {
                    $(Self::$name(texture) => texture.image(),)*
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
            /// Number of rows that hold a texture's code.
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

            #[inline(always)]
            fn textured<R: Real>(
                &self,
                mut color: R::Vec3,
                code: R::Word,
                at: &impl TexturePoint<R>,
            ) -> R::Vec3 {
                $(if !$name::CONSTANT {
                    let kind = R::Word::splat(TextureKind::$name as u32 + 1);
                    let here = (code >> KIND_SHIFT).eq(kind);
                    if here.any() {
                        let entry = code & R::Word::splat((1 << KIND_SHIFT) - 1);
                        let entry = here.select(entry, R::Word::splat(0));
                        // Pass a copy: if the original were passed by reference, the compiler would
                        // always keep it in memory instead of in registers.
                        let at = *at;
                        color = here.select($name::color(&self.$module, entry, &at), color);
                    }
                })*
                color
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

/// Number of low bits in a texture's code, which hold its index in its table. The bits above them
/// hold its kind plus 1, so that code 0 means no texture.
const KIND_SHIFT: u32 = 28;

impl TextureTables {
    /// Returns the number of rows that hold a texture's code.
    pub(super) fn uses(&self) -> usize {
        self.uses
    }

    /// Returns the row of a colour: (the colour, 0), or (0, code) for a texture.
    ///
    /// # Panics
    /// If the colour is still a name.
    pub(super) fn row(&mut self, color: &Color) -> Row {
        let texture = match color {
            Color::Rgb(rgb) => return row((*rgb).into(), 0.0),
            Color::Texture(texture) => texture,
            Color::Named(name) => unreachable!("the name `{name}` is not resolved"),
        };
        let known = self.known.iter().find(|(known, _)| Arc::ptr_eq(known, texture));
        let code = match known {
            Some((_, code)) => *code,
            None => match self.push(texture) {
                Ok(color) => return row(color.into(), 0.0),
                Err(code) => {
                    self.known.push((Arc::clone(texture), code));
                    code
                }
            },
        };
        self.uses += 1;
        [0, 0, 0, code]
    }

    /// Returns the code of a normal map, or 0 without one.
    pub(super) fn normal_code(&mut self, normal: Option<&Color>) -> u32 {
        normal.map_or(0, |normal| self.row(normal)[3])
    }

    /// Returns the colours of the normal maps with these codes at the point `at`. Code 0 gives black.
    #[inline(always)]
    pub(super) fn normal<R: Real>(&self, code: R::Word, at: &impl TexturePoint<R>) -> R::Vec3 {
        self.textured(R::Vec3::zero(), code, at)
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
        if (!plain).any() { self.textured(color, code, at) } else { color }
    }
}
