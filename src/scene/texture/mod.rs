//! Textures: one file each. The list in `textures!` makes the enum of scene files, the tables, and
//! the dispatch.

mod checker;
mod color;
mod image;
mod solid;

use std::fmt::Debug;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use color::Color;

use super::files::Images;
use super::place::Element;
use crate::error::Result;
use crate::image::Image as Pixels;
use crate::math::{Mask, Real, Row, Word, row};

/// A point of a surface, or one a lane, as textures see it.
pub(crate) trait TexturePoint<R: Real>: Copy {
    /// The point.
    fn point(&self) -> R::Vec3;

    /// Texture coordinates, both in [0, 1] up to rounding.
    fn uv(&self) -> (R, R);
}

/// What a kind of texture is: parameters, a table, and how it is evaluated.
pub(crate) trait TextureModel {
    /// The parameters as they lie in the table of the kind.
    type Entry: Debug + Send + Sync;

    /// Checks the parameters and reads files.
    fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()>;

    /// What decides the colours, in a canonical form.
    fn identity(&self) -> Value;

    /// Whether each texture of the kind has one colour everywhere.
    const CONSTANT: bool = false;

    /// The one colour that it has everywhere, if so.
    fn constant(&self) -> Option<[f32; 3]> {
        None
    }

    /// The image that it has, once it is loaded.
    fn image(&self) -> Option<Arc<Pixels>> {
        None
    }

    /// The parameters for the table.
    fn entry(&self) -> Self::Entry;

    /// The colours of the entries at `index`.
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

        /// The textures of a scene, a table a kind.
        #[derive(Debug, Default)]
        pub(crate) struct TextureTables {
            $($module: Vec<<$name as TextureModel>::Entry>,)*
            /// The textures that are in the tables, and their codes.
            known: Vec<(Arc<Texture>, u32)>,
            /// How many rows have a code.
            uses: usize,
        }

        impl TextureTables {
            /// The row of the colour that `texture` has everywhere, or of its code.
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
                        // A copy: one that is passed on by reference would be in memory always.
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
    /// One colour.
    Solid in solid,
    /// A 3-D checker.
    Checker in checker,
    /// A picture over the surface's texture coordinates.
    Image in image,
}

/// A code is a kind and a place in its table; 0 is none.
const KIND_SHIFT: u32 = 28;

impl TextureTables {
    /// How many rows have the code of a texture.
    pub(super) fn uses(&self) -> usize {
        self.uses
    }

    /// The row of a colour: itself and 0, or a texture's code.
    pub(super) fn row(&mut self, color: &Color) -> Row {
        let texture = match color {
            Color::Rgb(rgb) => return row((*rgb).into(), 0.0),
            Color::Texture(texture) => texture,
            Color::Named(name) => unreachable!("texture {name} was looked up"),
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

    /// The colour of a row at `at`.
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
