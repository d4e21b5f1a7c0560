//! Textures, one file per kind.
//!
//! The list in `textures!` generates the enum of scene files and the tables.

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
pub(crate) use lookup::TextureTables;
pub use number::Number;
use product::Product;
pub use reference::TextureRef;
use serde_json::Value;

use super::kinds::kinds;
use super::{ImageFile, Images};
use crate::checks::Location;
use crate::error::Result;
pub use crate::image::Encoding;
use crate::image::Texels;
use crate::math::Real;

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

/// The parameters of a texture, as scene files describe them.
pub(crate) trait TextureParameters {
    /// Checks the parameters and reads the files that they name.
    fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()>;

    /// Returns everything that determines the colours, for the hash of the scene.
    fn identity(&self) -> Value;

    /// Returns the path of its image, if it has one.
    fn file_mut(&mut self) -> Option<&mut String> {
        None
    }

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

    /// Divides colours by alpha, if the file of the image has colours that are multiplied by it.
    fn divide_by_alpha(&mut self) {}

    /// Returns the file of the texture's image, if it has one.
    fn file(&self) -> Option<ImageFile<'_>> {
        None
    }

    /// Whether the texture depends on the colours of vertices.
    fn uses_vertex_colors(&self) -> bool {
        false
    }

    /// Checks that the texture can be used for colours or numbers, as the parameter `name`.
    fn check_as_color(&self, _e: &Location<'_>, _name: &str) -> Result<()> {
        Ok(())
    }

    /// Whether the texture can be a normal map.
    fn holds_normals(&self) -> bool {
        false
    }
}

/// A kind of texture: its table and its evaluation.
trait TextureModel: TextureParameters {
    /// The parameters as stored in the table of this kind.
    type Entry: Debug + Send + Sync;

    /// Whether every texture of this kind has the same colour everywhere.
    const CONSTANT: bool = false;

    /// Returns the parameters for the table.
    fn entry(&self) -> Self::Entry;

    /// Returns the colours and alpha of the entries at `index` at the point `at`.
    fn value<R: Real>(table: &[Self::Entry], index: R::Word, at: &impl TexturePoint<R>) -> Rgba<R>;
}

macro_rules! textures {
    ($($(#[$doc:meta])* $name:ident in $module:ident,)*) => {
        kinds! {
            /// A colour that varies over a surface.
            pub enum Texture: pub(crate) TextureParameters {
                $($(#[$doc])* $name($name) in $module called stringify!($module),)*
            }
        }

        impl Texture {
            /// The names of the kinds in scene files.
            const KINDS: &[&str] = &[$(stringify!($module),)*];

            /// The path of its image, relative to the scene file, if it has one.
            pub fn file_mut(&mut self) -> Option<&mut String> {
                self.model_mut().file_mut()
            }

            pub(crate) fn model_mut(&mut self) -> &mut dyn TextureParameters {
                match self {
                    $(Self::$name(texture) => texture,)*
                }
            }
        }

        #[derive(Clone, Copy)]
        enum TextureKind {
            $($name,)*
        }

        /// The entries of textures, one table per kind.
        #[derive(Debug, Default)]
        struct Entries {
            $($module: Vec<<$name as TextureModel>::Entry>,)*
        }

        impl Entries {
            /// Adds a texture to its table and returns its code.
            fn push(&mut self, texture: &Texture) -> u32 {
                match texture {
                    $(Texture::$name(texture) => {
                        lookup::push(TextureKind::$name, &mut self.$module, texture)
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
                $(
                    let (kind, table) = (TextureKind::$name, &self.$module[..]);
                    value = lookup::textured::<$name, R>(kind, table, value, code, at);
                )*
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
