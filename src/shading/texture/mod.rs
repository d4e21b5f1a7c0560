//! Textures, one file per kind.
//!
//! The list in `textures!` generates the enum of scene files, the tables and the dispatch.

mod channel;
mod checker;
mod color;
mod image;
mod lookup;
mod number;
mod product;
mod reference;
mod solid;
mod uv_checker;
mod vertex_color;

use std::fmt::Debug;
use std::sync::Arc;

pub use channel::Channel;
pub use color::Color;
pub use image::{Filter, Wrap};
pub use number::Number;
use product::Product;
pub use reference::TextureRef;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::images::{ImageFile, Images};
use crate::checks::Location;
use crate::error::Result;
pub use crate::image::Encoding;
use crate::image::Texels;
use crate::math::{Mask, Real, Word};

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
    fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()>;

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

    /// Returns the file of the texture's image, if it has one.
    fn file(&self) -> Option<ImageFile<'_>> {
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
            /// The names of the kinds in scene files.
            const KINDS: &[&str] = &[$(stringify!($module),)*];

            pub(crate) fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()> {
                match self {
                    $(Self::$name(texture) => texture.load(e, images),)*
                }
            }

            pub(crate) fn texels(&self) -> Option<&Arc<Texels>> {
                match self {
                    $(Self::$name(texture) => TextureModel::texels(texture),)*
                }
            }

            /// The file of its image, if it has one.
            pub(crate) fn file(&self) -> Option<ImageFile<'_>> {
                match self {
                    $(Self::$name(texture) => TextureModel::file(texture),)*
                }
            }

            fn constant(&self) -> Option<[f32; 3]> {
                match self {
                    $(Self::$name(texture) => texture.constant(),)*
                }
            }

            pub(crate) fn largest(&self) -> f32 {
                match self {
                    $(Self::$name(texture) => texture.largest(),)*
                }
            }

            pub(crate) fn uses_vertex_colors(&self) -> bool {
                match self {
                    $(Self::$name(_) => $name::USES_VERTEX_COLORS,)*
                }
            }

            pub(crate) fn holds_normals(&self) -> bool {
                match self {
                    $(Self::$name(texture) => texture.holds_normals(),)*
                }
            }

            pub(crate) fn identity(&self) -> Value {
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
    /// A 2-D checker of texture coordinates.
    UvChecker in uv_checker,
}

/// Number of low bits in a texture's code that hold its index in its table and the channel. The
/// bits above them hold its kind plus 1, so that code 0 means no texture.
const KIND_SHIFT: u32 = 28;
/// Number of low bits that hold the index. The bits from here to the kind hold the channel.
const CHANNEL_SHIFT: u32 = 26;
