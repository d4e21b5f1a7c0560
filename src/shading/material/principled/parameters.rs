//! The parameters of the principled material: in its table, and at a point.

use crate::math::{Mask, Real, Row, Vector, Word};
use crate::shading::Interaction;

/// The parameters of the material at a point.
pub(in crate::shading::material) struct Parameters<R: Real> {
    pub(in crate::shading::material) base_color: R::Vec3,
    pub(in crate::shading::material) metalness: R,
    pub(in crate::shading::material) roughness: R,
    pub(in crate::shading::material) specular: R,
    pub(in crate::shading::material) transmission: R,
    pub(in crate::shading::material) thin: R::Mask,
    /// Whether the light that passes is left to [`MaterialModel::passes`](super::MaterialModel::passes).
    pub(in crate::shading::material) pane: R::Mask,
    pub(in crate::shading::material) ior: R,
    pub(in crate::shading::material) coat: R,
    pub(in crate::shading::material) coat_roughness: R,
    pub(in crate::shading::material) coat_color: R::Vec3,
    /// Whether the normals of the coat are not those of the surface below it, and the code of its normal map.
    pub(in crate::shading::material) coat_apart: R::Mask,
    pub(in crate::shading::material) coat_normal: R::Word,
    pub(in crate::shading::material) extras: Extras<R>,
}

/// The parameters that few materials have.
pub(in crate::shading::material) struct Extras<R: Real> {
    pub(super) specular_color: R::Vec3,
    /// Strength of the anisotropy, and the direction along (tangent, bitangent) in which the surface is
    /// rougher.
    pub(super) anisotropy: R,
    pub(super) direction: [R; 2],
    pub(super) sheen_color: R::Vec3,
    pub(super) sheen_roughness: R,
    /// Share of the light of the diffuse base that leaves on the other side, and its colour.
    pub(super) through: R,
    pub(super) through_color: R::Vec3,
}

impl<R: Real> Extras<R> {
    /// Those of a material that has none of them.
    #[inline(always)]
    pub(super) fn none() -> Self {
        let white = R::Vec3::gray(R::ONE);
        Self {
            specular_color: white,
            anisotropy: R::ZERO,
            direction: [R::ONE, R::ZERO],
            sheen_color: R::Vec3::zero(),
            sheen_roughness: R::ZERO,
            through: R::ZERO,
            through_color: white,
        }
    }
}

impl<R: Real> Parameters<R> {
    /// An opaque surface of one layer that is not metal.
    #[inline(always)]
    pub(in crate::shading::material) fn plastic(base_color: R::Vec3, roughness: R, ior: R) -> Self {
        Self {
            base_color,
            metalness: R::ZERO,
            roughness,
            specular: R::ONE,
            transmission: R::ZERO,
            thin: R::Mask::NONE,
            pane: R::Mask::NONE,
            ior,
            coat: R::ZERO,
            coat_roughness: R::ZERO,
            coat_color: R::Vec3::gray(R::ONE),
            coat_apart: R::Mask::NONE,
            coat_normal: R::Word::splat(0),
            extras: Extras::none(),
        }
    }
}

/// A material as stored in the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    pub(super) base_color: Row,
    /// The words of metalness and roughness, of specular and transmission, of coat and coat roughness.
    pub(super) numbers: [Row; 3],
    pub(super) coat_color_ior: Row,
    /// 1 if thin; 1 if it is a pane; 1 if it has extras, plus 2 if the coat has another normal; the code of the
    /// coat's normal map.
    pub(super) flags: Row,
    /// Specular colour; sheen colour; the words of its roughness and of the diffuse transmission; the colour of
    /// that; strength, cosine, sine and map of the anisotropy.
    pub(super) extras: [Row; 5],
}

/// The parameters of the entries at `index` for the point `at`.
#[inline(always)]
pub(super) fn parameters<R: Real>(
    table: &[Rows],
    index: R::Index,
    at: &Interaction<'_, R>,
) -> Parameters<R> {
    let base_color = at.color(R::gather(table, index, |entry| &entry.base_color));
    let numbers = |i: usize| {
        let (words, last) = R::gather(table, index, |entry: &Rows| &entry.numbers[i]);
        at.two_numbers([[words[0], words[1]], [words[2], last]])
    };
    let [metalness, roughness] = numbers(0);
    let [specular, transmission] = numbers(1);
    let [coat, coat_roughness] = numbers(2);
    let (coat_color, ior) = R::gather(table, index, |entry| &entry.coat_color_ior);
    let (flags, coat_normal) = R::gather(table, index, |entry| &entry.flags);
    let is_set = |flag: R, bit: u32| !(flag.to_bits() & R::Word::splat(bit)).eq(R::Word::splat(0));
    let has_extras = is_set(flags[2], 1).any();
    let extras = if has_extras { extras(table, index, at) } else { Extras::none() };
    Parameters {
        base_color,
        metalness,
        roughness,
        specular,
        transmission,
        thin: is_set(flags[0], 1),
        pane: is_set(flags[1], 1),
        ior,
        coat,
        coat_roughness,
        coat_color,
        coat_apart: is_set(flags[2], 2),
        coat_normal: coat_normal.to_bits(),
        extras,
    }
}

/// Parameters that few materials have.
#[inline(never)]
fn extras<R: Real>(table: &[Rows], index: R::Index, at: &Interaction<'_, R>) -> Extras<R> {
    let row = |i: usize| R::gather(table, index, |entry: &Rows| &entry.extras[i]);
    let (words, last) = row(2);
    let [sheen_roughness, through] = at.two_numbers([[words[0], words[1]], [words[2], last]]);
    let (numbers, map) = row(4);
    let [mut anisotropy, cos, sin] = [numbers[0], numbers[1], numbers[2]];
    let mut direction = [cos, sin];
    let mapped = !map.to_bits().eq(R::Word::splat(0));
    if let Some(textures) = at.textures.filter(|_| mapped.any()) {
        let color = textures.normal(map.to_bits(), at);
        let [x, y] = [color[0], color[1]].map(|c| c * 2.0 - R::ONE);
        let turned = [x * cos - y * sin, x * sin + y * cos];
        direction = [0, 1].map(|i| mapped.select(turned[i], direction[i]));
        anisotropy = mapped.select(anisotropy * color[2], anisotropy);
    }
    Extras {
        specular_color: at.color(row(0)),
        anisotropy,
        direction,
        sheen_color: at.color(row(1)),
        sheen_roughness,
        through,
        through_color: at.color(row(3)),
    }
}
