//! Lights that paths sample directly. Each kind has a file with its table and its sampling.
//!
//! The list in `lights!` generates the kinds, the tables and the dispatch.

mod alias;
mod quad;
mod sample;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod triangle;

use std::fmt::Debug;

use glam::Vec3;

use self::alias::AliasTable;
pub(crate) use self::sample::LightSample;
use super::emission::{Emission, Sides};
use crate::geometry::{Primitive, Ray};
use crate::math::{Mask, Real, Row, Vector, Word, row};
use crate::sampler::{Dimension, Randoms};

/// A kind of light. The implementing type is an entry in the table of that kind.
///
/// Samples are uniform in the light's solid angle whenever that can be computed.
pub(crate) trait LightModel: Copy + Debug {
    /// Returns the primitive as a light of this kind, and its area. Returns `None` if the primitive
    /// has another shape. Kinds of lights that are not primitives always return `None`.
    fn of(primitive: Primitive) -> Option<(Self, f64)>;

    /// Samples directions from `from` to the entries at `index`.
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        time: R,
        uv: (R, R),
    ) -> LightSample<R>;

    /// Returns the density with which [`LightModel::sample`] draws `ray.direction` from
    /// `ray.origin`. The rays hit the entries at distance `t`.
    fn pdf<R: Real>(table: &[Self], index: R::Index, ray: &Ray<R>, t: R) -> R;
}

/// Data of every light: (radiance, flags) and (chance of being chosen, index in the table of its
/// kind, 0, 0).
type LightRows = [Row; 2];

/// Flag of lights that emit on their front side only. The kind is in the bits above it.
const FRONT_ONLY: u32 = 1;
const KIND_SHIFT: u32 = 1;

/// Smallest solid angle at which flat lights are sampled by solid angle. Below it, the sum of the
/// corner angles has lost too many digits.
const MIN_SOLID_ANGLE: f32 = 1e-3;
/// A flat light is sampled by solid angle only if the sine of the angle between its plane and the
/// direction to its farthest corner is above this value. Below it, the mapping from angles to
/// points has lost too many digits.
const MIN_SINE: f32 = 2.5e-3;

macro_rules! lights {
    ($($name:ident in $module:ident,)*) => {
        #[derive(Clone, Copy)]
        #[expect(clippy::enum_variant_names, reason = "a kind has the name of its type")]
        enum LightKind {
            $($name,)*
        }

        /// The lights of a scene, one table per kind.
        #[derive(Debug, Default)]
        struct LightTables {
            $($module: Vec<$module::$name>,)*
        }

        impl LightTables {
            /// Adds a primitive. Returns its kind, its index in that kind's table, and its area.
            fn push(&mut self, primitive: Primitive) -> (LightKind, u32, f64) {
                $(if let Some((light, area)) = LightModel::of(primitive) {
                    self.$module.push(light);
                    return (LightKind::$name, self.$module.len() as u32 - 1, area);
                })*
                unreachable!("every primitive can be a light")
            }
        }

        impl<R: Real> Chosen<'_, R> {
            /// Samples directions from `from` to the lights.
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
                        let table = &self.lights.tables.$module[..];
                        let index = self.place(here, table.len());
                        let sample = $module::$name::sample(table, index, from, time, uv);
                        found = here.select(sample, found);
                    }
                )*
                found
            }

            /// Returns the density with which [`Chosen::sample`] draws `ray.direction` from
            /// `ray.origin`. The rays hit the lights at distance `t`.
            #[inline(always)]
            pub(crate) fn pdf(&self, ray: &Ray<R>, t: R) -> R {
                let mut pdf = R::ZERO;
                $(
                    let here = self.is(LightKind::$name);
                    if here.any() {
                        let table = &self.lights.tables.$module[..];
                        let index = self.place(here, table.len());
                        pdf = here.select($module::$name::pdf(table, index, ray, t), pdf);
                    }
                )*
                pdf
            }
        }
    };
}

lights! {
    SphereLight in sphere,
    QuadLight in quad,
    TriangleLight in triangle,
}

/// The lights of a scene, in the order of their primitives.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    rows: Vec<LightRows>,
    tables: LightTables,
    choice: Option<AliasTable>,
}

/// A chosen light, or one per lane.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a, R: Real> {
    lights: &'a Lights,
    index: R::Index,
    emission: R::Vec3,
    flags: R::Word,
}

/// Collects the lights of a scene.
#[derive(Default)]
pub(super) struct LightsBuilder {
    lights: Lights,
    powers: Vec<f64>,
}

impl LightsBuilder {
    /// Adds a primitive that emits light.
    pub(super) fn push(&mut self, primitive: Primitive, emission: Emission) {
        let Emission { radiance, sides } = emission;
        let (kind, place, area) = self.lights.tables.push(primitive);
        let one_sided = if sides == Sides::Front { FRONT_ONLY } else { 0 };
        let flags = (kind as u32) << KIND_SHIFT | one_sided;
        self.lights.rows.push([row(radiance, f32::from_bits(flags)), [0, place, 0, 0]]);
        self.powers.push(power(radiance, sides, area));
    }

    pub(super) fn finish(self) -> Lights {
        let Self { mut lights, powers } = self;
        if !powers.is_empty() {
            let table = AliasTable::new(&powers);
            for ([_, chance], index) in lights.rows.iter_mut().zip(0..) {
                chance[0] = (table.share(index) as f32 * (1.0 / 4_294_967_296.0)).to_bits();
            }
            lights.choice = Some(table);
        }
        lights
    }
}

impl Lights {
    /// Whether the scene has no lights.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Chooses a light with a probability in proportion to its power.
    ///
    /// # Panics
    /// If the scene has no lights.
    #[inline(always)]
    pub(crate) fn choose<R: Real>(&self, randoms: &Randoms<R>) -> Chosen<'_, R> {
        match &self.choice {
            Some(table) if self.rows.len() > 1 => {
                self.get(table.choose::<R>(randoms.bits(Dimension::LIGHT_CHOICE)))
            }
            _ => self.get(R::Word::splat(0)),
        }
    }

    /// Returns the lights at the indices `light`.
    #[inline(always)]
    pub(crate) fn get<R: Real>(&self, light: R::Word) -> Chosen<'_, R> {
        let index = R::index_of_few(light, self.rows.len());
        let (emission, flags) = R::gather(&self.rows, index, |rows| &rows[0]);
        Chosen { lights: self, index, emission, flags: flags.to_bits() }
    }
}

impl<R: Real> Chosen<'_, R> {
    #[inline(always)]
    fn is(&self, kind: LightKind) -> R::Mask {
        (self.flags >> KIND_SHIFT).eq(R::Word::splat(kind as u32))
    }

    /// For each lane in `here`, returns the index of the light in the table of its kind, which has
    /// `len` entries. The other lanes are 0.
    #[inline(always)]
    fn place(&self, here: R::Mask, len: usize) -> R::Index {
        let place = self.chance_and_place()[1].to_bits();
        R::index_of_few(here.select(place, R::Word::splat(0)), len)
    }

    #[inline(always)]
    fn chance_and_place(&self) -> R::Vec3 {
        R::gather(&self.lights.rows, self.index, |rows| &rows[1]).0
    }

    /// Returns the probability with which [`Lights::choose`] chooses the light.
    #[inline(always)]
    pub(crate) fn chance(&self) -> R {
        self.chance_and_place()[0]
    }

    /// Returns the radiance towards a viewer. `front` marks viewers on the front side of the light.
    #[inline(always)]
    pub(crate) fn radiance(&self, front: R::Mask) -> R::Vec3 {
        let one_sided = (self.flags & R::Word::splat(FRONT_ONLY)).eq(R::Word::splat(FRONT_ONLY));
        (one_sided & !front).select(R::Vec3::zero(), self.emission)
    }
}

/// Returns the relative power of a light: the luminance (Rec. 709) of its radiance, times its area
/// and the number of sides that emit. It is above 0 even for the dimmest light.
fn power(radiance: Vec3, sides: Sides, area: f64) -> f64 {
    let [r, g, b] = radiance.as_dvec3().to_array();
    let sides = if sides == Sides::Both { 2.0 } else { 1.0 };
    let power = (0.2126 * r + 0.7152 * g + 0.0722 * b) * area * sides;
    if power > 1e-300 { power } else { 1e-300 }
}
