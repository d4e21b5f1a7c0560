//! A simple test material that both scatters light and is a lamp.
//!
//! The engines' tests use it.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::lambertian::Lambertian;
use super::{Emission, MaterialModel, Sides};
use crate::error::Result;
use crate::math::Real;
use crate::scene::interaction::Interaction;
use crate::scene::place::Element;
use crate::scene::texture::{TextureRef, TextureTables};

/// A Lambertian surface that emits light on both sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Glow {
    /// The material that scatters.
    pub base: Lambertian,
    /// Emitted radiance in linear RGB.
    pub radiance: [f32; 3],
}

impl MaterialModel for Glow {
    type Entry = <Lambertian as MaterialModel>::Entry;
    type Bsdf<R: Real> = <Lambertian as MaterialModel>::Bsdf<R>;

    const TEXTURED: bool = true;

    fn textures(&mut self) -> Vec<&mut TextureRef> {
        self.base.textures()
    }

    fn emission(&self) -> Option<Emission> {
        Some(Emission { radiance: Vec3::from(self.radiance), sides: Sides::Both })
    }

    fn check(&self, e: &Element<'_>) -> Result<()> {
        self.base.check(e)
    }

    fn entry(&self, textures: &mut TextureTables) -> Self::Entry {
        self.base.entry(textures)
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[Self::Entry],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> Self::Bsdf<R> {
        Lambertian::bsdf(table, index, at)
    }
}
