//! What each kind of material implements.

use std::fmt::Debug;

use glam::Vec3;

use super::{Bsdf, Emission, Opacity, Sides};
use crate::checks::Location;
use crate::error::Result;
use crate::math::Real;
use crate::shading::{Color, Interaction, TextureRef, TextureTables};

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

    /// Whether smooth meshes need tangents for the material's maps or directions.
    fn needs_tangents(&self) -> bool {
        self.normal().is_some()
    }

    /// Returns the light that the material emits, if it is the same everywhere.
    fn emission(&self) -> Option<Emission> {
        None
    }

    /// Returns the light that the material emits and the sides that emit it, if it varies: by a texture, or
    /// by holes.
    fn varied_emission(&self) -> Option<(&Color, Sides)> {
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

    /// Returns the absorption per unit of length in the bodies that the surface encloses, if light enters
    /// them by refraction.
    fn absorption(&self) -> Option<Vec3> {
        None
    }

    /// Whether the surface is a pane: thin, smooth glass, through which rays pass without being deflected.
    fn is_pane(&self) -> bool {
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

    /// Returns the share of light that passes the pane of the entry at `index`, which the BSDF leaves out.
    fn passes(_table: &[Self::Entry], _index: u32, _at: &Interaction<'_, f32>) -> Vec3 {
        Vec3::ZERO
    }

    /// Returns the BSDFs of the entries at `index` for the point `at`.
    fn bsdf<R: Real>(
        table: &[Self::Entry],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> Self::Bsdf<R>;
}
