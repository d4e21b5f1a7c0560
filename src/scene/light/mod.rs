//! Lights that paths look for: one file each.
//!
//! The list in `lights!` makes the kinds, the dispatch, and the code by which a row tells its kind. `from`
//! names the primitive that is such a light when it emits; lights without one need not be primitives.

mod alias;
mod quad;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod triangle;

use alias::AliasTable;

use glam::Vec3;

use super::emission::{Emission, Sides};
use crate::geometry::{Primitive, Ray};
use crate::math::{Mask, Real, Row, Select, Vector, Word, dot, row};
use crate::sampler::{Dimension, Randoms};

/// How a kind of light is sampled, uniformly in its solid angle where that can be computed.
pub(crate) trait LightModel {
    /// A direction from `from` to the light.
    fn sample<R: Real>(light: &Chosen<'_, R>, from: R::Vec3, time: R, uv: (R, R))
    -> LightSample<R>;

    /// Density with which [`LightModel::sample`] at `ray.origin` draws `ray.direction`, which meets the
    /// light at distance `t`.
    fn pdf<R: Real>(light: &Chosen<'_, R>, ray: &Ray<R>, t: R) -> R;
}

/// A light's rows: what it emits, and its flags; a point, and the chance of being chosen; three of its
/// kind.
type LightRows = [Row; 5];

/// Flags: shines on its front only; of a quad, is a rectangle. Above them is the kind.
const FRONT_ONLY: u32 = 1;
const RECTANGLE: u32 = 2;
const KIND_SHIFT: u32 = 8;

/// Shapes are sampled by solid angle above this: below it the sum of the corners' angles has lost too
/// many digits.
const MIN_SOLID_ANGLE: f32 = 1e-3;
/// And above this sine of the elevation of the farthest corner over the shape's plane: below it the mapping
/// from angles to points has lost too many digits.
const MIN_SINE: f32 = 2.5e-3;

macro_rules! lights {
    ($($name:ident in $module:ident $(from $primitive:ident)?,)*) => {
        #[derive(Clone, Copy)]
        enum LightKind {
            $($name,)*
        }

        /// A primitive as a light.
        fn shone(primitive: Primitive<'_>) -> Shone {
            match primitive {
                $($(Primitive::$primitive(primitive) => $module::shone(primitive),)?)*
            }
        }

        impl<R: Real> Chosen<'_, R> {
            /// Directions to the lights as seen from `from`.
            #[inline(always)]
            pub(crate) fn sample(&self, from: R::Vec3, time: R, uv: (R, R)) -> LightSample<R> {
                let mut found = LightSample {
                    direction: from,
                    distance: R::ZERO,
                    pdf: R::ZERO,
                    front: R::Mask::NONE,
                    visible: R::Mask::NONE,
                };
                $(
                    let here = self.is(LightKind::$name);
                    if here.any() {
                        found = here.select($module::$name::sample(self, from, time, uv), found);
                    }
                )*
                found
            }

            /// Density with which [`Chosen::sample`] at `ray.origin` draws `ray.direction`, which meets
            /// the lights at distance `t`.
            #[inline(always)]
            pub(crate) fn pdf(&self, ray: &Ray<R>, t: R) -> R {
                let mut pdf = R::ZERO;
                $(
                    let here = self.is(LightKind::$name);
                    if here.any() {
                        pdf = here.select($module::$name::pdf(self, ray, t), pdf);
                    }
                )*
                pdf
            }
        }
    };
}

lights! {
    Sphere in sphere from Sphere,
    Quad in quad from Quad,
    Triangle in triangle from Triangle,
}

/// A kind of light, its area, the flags of its kind, its point, and its other rows.
struct Shone {
    kind: LightKind,
    area: f64,
    flags: u32,
    point: Vec3,
    rows: [Row; 3],
}

/// The lights of a scene in the order of their primitives.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    rows: Vec<LightRows>,
    table: Option<AliasTable>,
}

/// One light, or one a lane.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a, R: Real> {
    rows: &'a [LightRows],
    index: R::Index,
    emission: R::Vec3,
    flags: R::Word,
}

/// A direction from a point to a light.
#[derive(Clone, Copy)]
pub(crate) struct LightSample<R: Real> {
    /// Of unit length.
    pub(crate) direction: R::Vec3,
    /// How far the light is.
    pub(crate) distance: R,
    /// Density of the direction per unit solid angle.
    pub(crate) pdf: R,
    /// Whether the direction meets the light's front.
    pub(crate) front: R::Mask,
    /// Whether the light can be seen at all; where it cannot, the rest means nothing.
    pub(crate) visible: R::Mask,
}

impl<R: Real> Select<R::Mask> for LightSample<R> {
    #[inline(always)]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            direction: mask.select(yes.direction, no.direction),
            distance: mask.select(yes.distance, no.distance),
            pdf: mask.select(yes.pdf, no.pdf),
            front: mask.select(yes.front, no.front),
            visible: mask.select(yes.visible, no.visible),
        }
    }
}

/// Collects the lights of a scene.
#[derive(Default)]
pub(super) struct LightsBuilder {
    rows: Vec<LightRows>,
    powers: Vec<f64>,
}

impl LightsBuilder {
    /// Adds a primitive that emits light.
    pub(super) fn push(&mut self, primitive: Primitive<'_>, emission: Emission) {
        self.add(shone(primitive), emission);
    }

    fn add(&mut self, light: Shone, Emission { radiance, sides }: Emission) {
        let Shone { kind, area, flags, point, rows: [a, b, c] } = light;
        let one_sided = if sides == Sides::Front { FRONT_ONLY } else { 0 };
        let flags = (kind as u32) << KIND_SHIFT | flags | one_sided;
        self.powers.push(power(radiance, sides, area));
        self.rows.push([row(radiance, f32::from_bits(flags)), row(point, 1.0), a, b, c]);
    }

    pub(super) fn finish(self) -> Lights {
        let Self { mut rows, powers } = self;
        let table = (!rows.is_empty()).then(|| AliasTable::new(&powers));
        for (rows, index) in rows.iter_mut().zip(0..) {
            let share = table.as_ref().map_or(0, |table| table.share(index));
            rows[1][3] = (share as f32 * (1.0 / 4_294_967_296.0)).to_bits();
        }
        Lights { rows, table }
    }
}

impl Lights {
    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// A light, in proportion to its power.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub(crate) fn choose<R: Real>(&self, randoms: &Randoms<R>) -> Chosen<'_, R> {
        match &self.table {
            Some(table) if self.rows.len() > 1 => {
                self.get(table.choose::<R>(randoms.bits(Dimension::LIGHT_CHOICE)))
            }
            _ => self.get(R::Word::splat(0)),
        }
    }

    /// The lights with these numbers.
    #[inline(always)]
    pub(crate) fn get<R: Real>(&self, light: R::Word) -> Chosen<'_, R> {
        let index = R::index_of_few(light, self.rows.len());
        let (emission, flags) = R::gather(&self.rows, index, |rows| &rows[0]);
        Chosen { rows: &self.rows, index, emission, flags: flags.to_bits() }
    }
}

impl<R: Real> Chosen<'_, R> {
    /// Row `place`.
    #[inline(always)]
    fn row(&self, place: usize) -> (R::Vec3, R) {
        R::gather(self.rows, self.index, |rows| &rows[place])
    }

    #[inline(always)]
    fn has(&self, flag: u32) -> R::Mask {
        (self.flags & R::Word::splat(flag)).eq(R::Word::splat(flag))
    }

    #[inline(always)]
    fn is(&self, kind: LightKind) -> R::Mask {
        (self.flags >> KIND_SHIFT).eq(R::Word::splat(kind as u32))
    }

    /// Chance of being chosen.
    #[inline(always)]
    pub(crate) fn chance(&self) -> R {
        self.row(1).1
    }

    /// Radiance towards a viewer, on the front of the light or not.
    #[inline(always)]
    pub(crate) fn radiance(&self, front: R::Mask) -> R::Vec3 {
        (self.has(FRONT_ONLY) & !front).select(R::Vec3::zero(), self.emission)
    }
}

/// Radiant power in proportion to others': the luminance of what is emitted (Rec. 709), on all sides
/// that shine. Not 0, however dim.
fn power(radiance: Vec3, sides: Sides, area: f64) -> f64 {
    let [r, g, b] = radiance.as_dvec3().to_array();
    let sides = if sides == Sides::Both { 2.0 } else { 1.0 };
    let power = (0.2126 * r + 0.7152 * g + 0.0722 * b) * area * sides;
    if power > 1e-300 { power } else { 1e-300 }
}

/// A flat light's plane.
struct Plane<R: Real> {
    point: R::Vec3,
    normal: R::Vec3,
    area: R,
}

impl<R: Real> Plane<R> {
    /// The sample in this direction: of density `pdf` where `exact`, else that of a point uniform by
    /// area.
    #[inline(always)]
    fn sample(&self, from: R::Vec3, direction: R::Vec3, exact: R::Mask, pdf: R) -> LightSample<R> {
        let slope = dot(self.normal, direction);
        let distance = -dot(self.normal, from - self.point) / slope;
        let pdf = exact.select(pdf, self.area_pdf(direction, distance));
        let positive = |x: R| x.gt(R::ZERO) & x.lt(R::INFINITY);
        LightSample {
            direction,
            distance,
            pdf,
            front: slope.lt(R::ZERO),
            visible: positive(distance) & positive(pdf),
        }
    }

    /// Density per unit solid angle of points uniform by area, at `distance` in this direction.
    #[inline(always)]
    fn area_pdf(&self, direction: R::Vec3, distance: R) -> R {
        distance * distance / (self.area * dot(self.normal, direction).abs())
    }
}
