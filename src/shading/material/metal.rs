//! The report's metal (III.D), which blurs the mirror direction.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, SPECULAR, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::warp::uniform_ball;
use crate::math::{Mask, Real, Row, cross, dot, max, normalize, reflect};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Color, Interaction, Number, TextureRef, TextureTables};

/// A mirror that offsets the reflected direction by `fuzz` times a uniformly distributed
/// random point of the unit ball. Paths whose direction then points below the surface are absorbed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Metal {
    /// Reflectance, a colour with each channel in [0, 1] or a texture.
    pub albedo: Color,
    /// Size of the blur, 0 (mirror) to 1, or a texture.
    #[serde(default = "Number::zero")]
    pub fuzz: Number,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

impl Metal {
    /// Creates the material without a normal map and without holes.
    pub fn new(albedo: impl Into<Color>, fuzz: impl Into<Number>) -> Self {
        Self { albedo: albedo.into(), fuzz: fuzz.into(), normal: None, opacity: None }
    }
}

impl MaterialParameters for Metal {
    texture_methods!(albedo, fuzz);

    fn check(&self, e: &Location<'_>) -> Result<()> {
        self.albedo.check(e, "albedo")?;
        self.fuzz.check(e, "fuzz", 0.0..=1.0)
    }
}

impl MaterialModel for Metal {
    /// Row of the albedo, and the two words of `fuzz`.
    type Entry = [Row; 2];
    type Bsdf<R: Real> = MetalBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> [Row; 2] {
        let [fuzz, code] = textures.number(&self.fuzz);
        [textures.row(&self.albedo), [fuzz, code, 0, 0]]
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[[Row; 2]], index: R::Index, at: &Interaction<'_, R>) -> MetalBsdf<R> {
        let albedo = at.color(R::gather(table, index, |entry| &entry[0]));
        let (fuzz, _) = R::gather(table, index, |entry| &entry[1]);
        let fuzz = at.number([fuzz[0], fuzz[1]]);
        let mirror = reflect(at.ray.direction, at.normals.mirror);
        MetalBsdf { normal: at.normals.mirror, mirror, albedo, fuzz }
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
    fn albedo(&self) -> R::Vec3 {
        self.albedo
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
