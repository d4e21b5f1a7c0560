//! Materials, one file per kind with its parameters, their checks, its physics and its table.
//!
//! The list in `materials!` generates the enum of scene files, the kinds by which paths are sorted,
//! and the tables.

/// The methods of [`MaterialParameters`] for the fields `normal` and `opacity`.
macro_rules! normal_and_opacity {
    () => {
        fn normal(&self) -> Option<&TextureRef> {
            self.normal.as_ref()
        }

        fn opacity(&self) -> Option<&Opacity> {
            self.opacity.as_ref()
        }

        fn opacity_mut(&mut self) -> Option<&mut Option<Opacity>> {
            Some(&mut self.opacity)
        }
    };
}

mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod lambertian;
mod light;
mod metal;
mod principled;
mod rough_dielectric;

use std::fmt::Debug;
use std::sync::Arc;

pub use dielectric::Fresnel;
use serde::{Deserialize, Serialize};

pub(crate) use super::bsdf::{Bsdf, SPECULAR, Scatter};
pub use super::emission::{Emission, Sides};
use super::interaction::Interaction;
pub use super::opacity::Opacity;
use super::texture::{Color, TextureRef, TextureTables};
use crate::checks::Location;
use crate::error::Result;
use crate::image::Texels;
use crate::math::{Real, Row};

/// The parameters of a material, as scene files describe them.
pub(crate) trait MaterialParameters {
    /// Returns all references to textures.
    fn textures(&mut self) -> Vec<&mut TextureRef> {
        Vec::new()
    }

    /// Returns the normal map.
    fn normal(&self) -> Option<&TextureRef> {
        None
    }

    /// Returns the light that the material emits, if any.
    fn emission(&self) -> Option<Emission> {
        None
    }

    /// Returns the texture of the light that the material emits, if it has one. Such light is not
    /// sampled: only paths that hit the surface find it.
    fn emission_texture(&self) -> Option<&Color> {
        None
    }

    /// Returns where the surface has holes, if anywhere.
    fn opacity(&self) -> Option<&Opacity> {
        None
    }

    /// Returns the field `opacity`, if the material has one.
    fn opacity_mut(&mut self) -> Option<&mut Option<Opacity>> {
        None
    }

    /// Whether light passes through the surface.
    fn transmits(&self) -> bool {
        false
    }

    /// Checks the parameters.
    fn check(&self, e: &Location<'_>) -> Result<()>;
}

/// A kind of material: its table and its physics.
pub(crate) trait MaterialModel: MaterialParameters {
    /// The parameters as stored in the table of this kind.
    type Entry: Copy + Debug + Send + Sync;
    /// The scattering of light at a point.
    type Bsdf<R: Real>: Bsdf<R> + 'static;

    /// Whether the material scatters any light.
    const SCATTERS: bool = true;
    /// Whether it reflects light like a mirror, sharp or blurred.
    const GLOSSY: bool = false;
    /// Whether a parameter may be a texture.
    const TEXTURED: bool = false;

    /// Whether a single loop shades materials with and without textures, because the code is large or
    /// rarely without them.
    const LARGE: bool = false;

    /// Returns the parameters for the table, and adds their textures to `textures`.
    fn entry(&self, textures: &mut TextureTables) -> Self::Entry;

    /// Returns the BSDFs of the entries at `index` for the point `at`.
    fn bsdf<R: Real>(
        table: &[Self::Entry],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> Self::Bsdf<R>;
}

/// An operation on the table of any kind of material.
pub(crate) trait MaterialVisitor {
    /// Result of the operation.
    type Output;

    /// Runs the operation on the table of the kind `M`.
    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Self::Output;
}

/// The materials of one kind.
#[derive(Debug)]
pub(crate) struct MaterialTable<E> {
    pub(crate) entries: Vec<E>,
    /// Whether any of them has a texture.
    pub(crate) textured: bool,
    /// For each of them, the code of its normal map; empty if none has one.
    pub(crate) normals: Vec<u32>,
    /// For each of them, the row of the texture of its light; empty if none has one.
    pub(crate) emission_rows: Vec<Row>,
}

impl<E> Default for MaterialTable<E> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            textured: false,
            normals: Vec::new(),
            emission_rows: Vec::new(),
        }
    }
}

impl<E> MaterialTable<E> {
    /// Adds a material and returns its index.
    fn push<M: MaterialModel<Entry = E>>(
        &mut self,
        material: &M,
        textures: &mut TextureTables,
    ) -> u32 {
        let before = textures.uses();
        let index = self.entries.len();
        self.entries.push(material.entry(textures));
        let normal = textures.normal_code(material.normal());
        if normal != 0 || !self.normals.is_empty() {
            self.normals.resize(index, 0);
            self.normals.push(normal);
        }
        let emission = material.emission_texture();
        if emission.is_some() || !self.emission_rows.is_empty() {
            self.emission_rows.resize(index, [0; 4]);
            self.emission_rows.push(emission.map_or([0; 4], |texture| textures.row(texture)));
        }
        self.textured |= textures.uses() > before;
        assert!(
            M::TEXTURED || !self.textured,
            "a kind of material with a texture must set TEXTURED"
        );
        index as u32
    }
}

macro_rules! materials {
    ($($(#[doc = $doc:literal])* $name:ident in $module:ident,)*) => {
        $(pub use $module::$name;)*

        /// How a surface scatters and emits light.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        // A scene has few materials.
        #[allow(clippy::large_enum_variant)]
        pub enum Material {
            $($(#[doc = $doc])* $name($name),)*
        }

        $(impl From<$name> for Material {
            fn from(material: $name) -> Self {
                Self::$name(material)
            }
        })*

        /// The kinds of materials.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum MaterialKind {
            $($name,)*
        }

        /// The materials of a scene, one table per kind.
        #[derive(Debug, Default)]
        pub(crate) struct MaterialTables {
            $($module: MaterialTable<<$name as MaterialModel>::Entry>,)*
        }

        impl Material {
            /// Returns the kind, its name in scene files, and the parameters.
            fn parts(&self) -> (MaterialKind, &'static str, &dyn MaterialParameters) {
                match self {
                    $(Self::$name(material) => {
                        (MaterialKind::$name, stringify!($module), material)
                    })*
                }
            }

            fn parameters_mut(&mut self) -> &mut dyn MaterialParameters {
                match self {
                    $(Self::$name(material) => material,)*
                }
            }
        }

        impl MaterialTables {
            /// Adds a material and returns its index in the table of its kind.
            pub(crate) fn push(&mut self, material: &Material, textures: &mut TextureTables) -> u32 {
                match material {
                    $(Material::$name(material) => self.$module.push(material, textures),)*
                }
            }

            /// Calls `visitor` with the table of `kind`.
            #[inline(always)]
            pub(crate) fn visit<V: MaterialVisitor>(
                &self,
                kind: MaterialKind,
                visitor: V,
            ) -> V::Output {
                match kind {
                    $(MaterialKind::$name => visitor.visit::<$name>(&self.$module),)*
                }
            }
        }
    };
}

materials! {
    /// The report's ideal diffuse material.
    Diffuse in diffuse,
    /// A thin matte surface that also lets light through.
    DiffuseTransmission in diffuse_transmission,
    /// A matte surface that follows Lambert's law.
    Lambertian in lambertian,
    /// The report's metal.
    Metal in metal,
    /// Clear, smooth glass.
    Dielectric in dielectric,
    /// Frosted glass.
    RoughDielectric in rough_dielectric,
    /// A metal with a complex index of refraction.
    Conductor in conductor,
    /// A matte surface below a clear coat.
    CoatedDiffuse in coated_diffuse,
    /// A surface between matte, metal and glass, with a clear coat.
    Principled in principled,
    /// A surface that emits light and absorbs all light that hits it.
    Light in light,
}

/// Checks that a normal map is a texture that contains normals.
fn check_normals(normal: &TextureRef, e: &Location<'_>) -> Result<()> {
    match normal.get().holds_normals() {
        true => Ok(()),
        false => Err(e.error(
            "normal must be the name of an `image` texture with `encoding: linear` and `uv: 0`",
        )),
    }
}

impl Material {
    pub(crate) fn kind(&self) -> MaterialKind {
        self.parts().0
    }

    /// Returns the name of the material's kind in scene files.
    pub fn name(&self) -> &'static str {
        self.parts().1
    }

    fn parameters(&self) -> &dyn MaterialParameters {
        self.parts().2
    }

    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        let parameters = self.parameters();
        parameters.normal().map_or(Ok(()), |normal| check_normals(normal, e))?;
        parameters.opacity().map_or(Ok(()), |opacity| opacity.check(e))?;
        parameters.check(e)
    }

    /// Returns all references to textures.
    pub(crate) fn textures(&mut self) -> Vec<&mut TextureRef> {
        self.parameters_mut().textures()
    }

    /// Whether the material has a normal map.
    pub(crate) fn has_normal_map(&self) -> bool {
        self.parameters().normal().is_some()
    }

    /// Returns the light that the material emits, if any.
    pub fn emission(&self) -> Option<Emission> {
        self.parameters().emission()
    }

    /// Whether the material emits the light of a texture.
    pub(crate) fn has_emission_texture(&self) -> bool {
        self.parameters().emission_texture().is_some()
    }

    /// Returns where the surface has holes, if anywhere.
    pub(crate) fn opacity(&self) -> Option<&Opacity> {
        self.parameters().opacity()
    }

    /// Returns the field `opacity`, if the material has one.
    pub(crate) fn opacity_mut(&mut self) -> Option<&mut Option<Opacity>> {
        self.parameters_mut().opacity_mut()
    }

    /// Whether light passes through its surface.
    pub(crate) fn transmits(&self) -> bool {
        self.parameters().transmits()
    }

    /// Whether a texture of the material depends on the colours of vertices.
    pub(crate) fn uses_vertex_colors(&self) -> bool {
        let uses = |texture: &mut TextureRef| matches!(texture, TextureRef::Texture(texture) if texture.uses_vertex_colors());
        self.clone().textures().into_iter().any(uses)
    }

    /// Returns the images of the material's textures, once they are loaded.
    pub(crate) fn images(&self) -> Vec<Arc<Texels>> {
        let image = |texture: &mut TextureRef| texture.get().texels().cloned();
        self.clone().textures().into_iter().filter_map(image).collect()
    }
}
