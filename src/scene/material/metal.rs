//! The report's metal (III.D), which blurs the mirror direction.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, SPECULAR, Scatter};
use crate::error::Result;
use crate::math::warp::uniform_ball;
use crate::math::{Mask, Real, Row, cross, dot, max, normalize, reflect, row};
use crate::sampler::{Dimension, Randoms};
use crate::scene::interaction::Interaction;
use crate::scene::place::Element;
use crate::scene::texture::{Color, TextureTables};

/// A mirror that offsets the reflected direction by `fuzz` times a uniformly distributed
/// random point of the unit ball. Paths whose direction then points below the surface are absorbed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Metal {
    /// Reflectance, a colour with each channel in [0, 1] or a texture.
    pub albedo: Color,
    /// Size of the blur, 0 (mirror) to 1.
    #[serde(default)]
    pub fuzz: f32,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<Box<Color>>,
}

impl Metal {
    /// Creates the material without a normal map.
    pub fn new(albedo: impl Into<Color>, fuzz: f32) -> Self {
        Self { albedo: albedo.into(), fuzz, normal: None }
    }
}

impl MaterialModel for Metal {
    /// Row of the albedo, and (0, `fuzz`).
    type Entry = [Row; 2];
    type Bsdf<R: Real> = MetalBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;

    fn colors(&mut self) -> Vec<&mut Color> {
        [Some(&mut self.albedo), self.normal.as_deref_mut()].into_iter().flatten().collect()
    }

    fn normal(&self) -> Option<&Color> {
        self.normal.as_deref()
    }

    fn check(&self, e: &Element<'_>) -> Result<()> {
        self.albedo.check(e, "albedo")?;
        e.check((0.0..=1.0).contains(&self.fuzz), "fuzz", "in [0, 1]", self.fuzz)
    }

    fn entry(&self, textures: &mut TextureTables) -> [Row; 2] {
        [textures.row(&self.albedo), row(glam::Vec3::ZERO, self.fuzz)]
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[[Row; 2]], index: R::Index, at: &Interaction<'_, R>) -> MetalBsdf<R> {
        let albedo = at.color(R::gather(table, index, |entry| &entry[0]));
        let (_, fuzz) = R::gather(table, index, |entry| &entry[1]);
        let mirror = reflect(at.ray.direction, at.shading);
        MetalBsdf { normal: at.shading, mirror, albedo, fuzz }
    }
}

pub(crate) struct MetalBsdf<R: Real> {
    /// Normal on the side that was hit.
    normal: R::Vec3,
    mirror: R::Vec3,
    albedo: R::Vec3,
    fuzz: R,
}

/// Smallest fuzz for which a density is computed; smaller values count as specular. Below it,
/// rounding error dominates the distance from the mirror direction, and no light sample would hit
/// such a narrow blur.
const LEAST_BLUR: f32 = 1e-4;

impl<R: Real> MetalBsdf<R> {
    /// Density of `direction`: the share of the ball's volume in that direction.
    ///
    /// A ray in `direction` crosses the ball from b − s to b + s, where b is the cosine of its
    /// angle with the mirror direction and s² = fuzz² − 1 + b². The volume per solid angle is
    /// ∫r² dr = 2s(3b² + s²)/3.
    #[inline(always)]
    fn pdf(&self, direction: R::Vec3) -> R {
        let b = dot(self.mirror, direction);
        let across = cross(self.mirror, direction);
        let s2 = max(R::ZERO, self.fuzz * self.fuzz - dot(across, across));
        let cube = self.fuzz * self.fuzz * self.fuzz;
        let pdf = s2.sqrt() * (b * b * 3.0 + s2) / (cube * (2.0 * PI));
        b.gt(R::ZERO).select(pdf, R::ZERO)
    }
}

impl<R: Real> Bsdf<R> for MetalBsdf<R> {
    #[inline(always)]
    fn specular(&self) -> R::Mask {
        self.fuzz.lt(R::splat(LEAST_BLUR))
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let blur = uniform_ball(u, v, randoms.one(Dimension::BALL));
        let direction = normalize(self.mirror + blur * self.fuzz);
        Scatter {
            direction,
            transmitted: R::Mask::NONE,
            weight: self.albedo,
            pdf: self.specular().select(R::splat(SPECULAR), self.pdf(direction)),
            // Also false for NaN, which occurs if the blur exactly cancels the mirror direction.
            scattered: dot(direction, self.normal).gt(R::ZERO),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let possible = dot(direction, self.normal).gt(R::ZERO) & !self.specular();
        let pdf = possible.select(self.pdf(direction), R::ZERO);
        (self.albedo * pdf, pdf)
    }
}
