//! Lights that paths sample directly. Each kind has a file with its table and its sampling.
//!
//! The list in `lights!` generates the kinds, the tables and the dispatch.

mod alias;
mod builder;
mod distant;
mod environment;
mod file;
mod free;
mod point;
mod quad;
mod sample;
mod shares;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod spot;
mod tree;
mod triangle;

use std::fmt::Debug;

use glam::DVec3;

use self::alias::AliasTable;
pub(crate) use self::builder::LightsBuilder;
pub use self::distant::Distant;
pub(crate) use self::environment::Environment;
pub use self::environment::{EnvironmentMap, Mapping};
pub use self::file::LightFile;
pub use self::point::Point;
pub(crate) use self::sample::LightSample;
pub use self::spot::Spot;
use self::tree::LightTree;
use crate::geometry::{Primitive, Ray};
use crate::math::random::unit_interval;
use crate::math::{Mask, Real, Row, Vector, Word, whole};
use crate::sampler::{Dimension, Randoms};

/// A kind of light. The implementing type is an entry in the table of that kind.
///
/// Samples are uniform in the light's solid angle whenever that can be computed.
pub(crate) trait LightModel: Debug + Sized {
    /// Whether only light samples find lights of this kind: no path can hit them.
    const UNSEEN: bool = false;

    /// Returns the primitive as a light of this kind. Returns `None` if the primitive has another
    /// shape. Kinds of lights that are not primitives always return `None`.
    fn of(_primitive: Primitive) -> Option<PrimitiveLight<Self>> {
        None
    }

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
    ///
    /// The default is for lights that no path can hit.
    #[inline(always)]
    fn pdf<R: Real>(_table: &[Self], _index: R::Index, _ray: &Ray<R>, _t: R) -> R {
        R::ZERO
    }
}

/// A primitive as a light.
pub(crate) struct PrimitiveLight<L> {
    light: L,
    area: f64,
    /// Unit normal of a flat light.
    normal: Option<DVec3>,
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
        enum LightKind {
            $($name,)*
        }

        /// The lights of a scene, one table per kind.
        #[derive(Debug, Default)]
        struct LightTables {
            $($module: Vec<$module::$name>,)*
        }

        impl LightTables {
            /// Adds a primitive. Returns its kind, its index in that kind's table, its area, and the
            /// normal of a flat light.
            fn push(&mut self, primitive: Primitive) -> (LightKind, u32, f64, Option<DVec3>) {
                $(if let Some(PrimitiveLight { light, area, normal }) = LightModel::of(primitive) {
                    self.$module.push(light);
                    return (LightKind::$name, self.$module.len() as u32 - 1, area, normal);
                })*
                unreachable!("every primitive can be a light")
            }
        }

        impl<R: Real> Chosen<'_, R> {
            /// Samples directions from `from` to the lights.
            ///
            /// It is inlined, for without that `cornell` takes 1.1 times as long. Only lights on primitives
            /// are: the others would make all loops over vertices larger.
            #[inline(always)]
            pub(crate) fn sample(&self, from: R::Vec3, time: R, uv: (R, R)) -> LightSample<R> {
                let mut found = LightSample {
                    direction: from,
                    distance: R::ZERO,
                    pdf: R::ZERO,
                    tint: R::Vec3::gray(R::ONE),
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

            /// Returns which of the lights only light samples find.
            #[inline(always)]
            pub(crate) fn unseen(&self) -> R::Mask {
                let mut unseen = R::Mask::NONE;
                $(if $module::$name::UNSEEN {
                    unseen = unseen | self.is(LightKind::$name);
                })*
                unseen
            }
        }
    };
}

lights! {
    SphereLight in sphere,
    QuadLight in quad,
    TriangleLight in triangle,
    PointLight in point,
    SpotLight in spot,
    DistantLight in distant,
    Environment in environment,
}

/// The lights of a scene: those of primitives in their order, then those of the list of lights, then
/// the environment map.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    rows: Vec<LightRows>,
    tables: LightTables,
    choice: Choice,
    /// Index of the environment map.
    environment: Option<u32>,
}

/// How a light is chosen.
#[derive(Debug, Default)]
enum Choice {
    /// There is at most one light.
    #[default]
    Only,
    /// In proportion to the power.
    Power(AliasTable),
    /// With a tree over the lights inside the scene. Each of the others, whose indices follow, is as
    /// probable as the whole tree.
    Tree(LightTree, Vec<u32>),
}

/// A chosen light, or one per lane.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a, R: Real> {
    lights: &'a Lights,
    light: R::Word,
    index: R::Index,
    emission: R::Vec3,
    flags: R::Word,
    /// The probability of the choice, if it is known.
    chance: Option<R>,
}

impl Lights {
    /// Whether the scene has no lights.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Chooses a light for the point `from`.
    ///
    /// # Panics
    /// If the scene has no lights.
    #[inline(always)]
    pub(crate) fn choose<R: Real>(&self, randoms: &Randoms<R>, from: R::Vec3) -> Chosen<'_, R> {
        let bits = || randoms.bits(Dimension::LIGHT_CHOICE);
        match &self.choice {
            Choice::Only => self.get(R::Word::splat(0)),
            Choice::Power(table) => self.get(table.choose::<R>(bits())),
            Choice::Tree(tree, others) => self.choose_by_tree(tree, others, bits(), from),
        }
    }

    #[inline(never)]
    fn choose_by_tree<R: Real>(
        &self,
        tree: &LightTree,
        others: &[u32],
        bits: R::Word,
        from: R::Vec3,
    ) -> Chosen<'_, R> {
        // The product of the random number and the number of parts is the chosen part, and the lower
        // bits are a random number again.
        let parts = R::Word::splat(others.len() as u32 + 1);
        let part = whole(unit_interval::<R>(bits) * (others.len() + 1) as f32);
        let (mut light, chance) = tree.choose::<R>(from, bits.wrapping_mul(parts));
        let mut chance = chance / R::from_word(parts);
        if !others.is_empty() {
            let last = R::Word::splat(others.len() as u32 - 1);
            let outside = part.le(last);
            let other = R::pick(others, R::index(outside.select(part, last), others.len()));
            light = outside.select(other, light);
            chance = outside.select(R::ONE / R::from_word(parts), chance);
        }
        Chosen { chance: Some(chance), ..self.get(light) }
    }

    /// Returns the environment map and its light.
    #[inline(always)]
    pub(crate) fn environment<R: Real>(&self) -> Option<(&Environment, Chosen<'_, R>)> {
        let light = self.get(R::Word::splat(self.environment?));
        Some((&self.tables.environment[0], light))
    }

    /// Number of lights.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are lights that only light samples find.
    #[inline(always)]
    pub(crate) fn has_unseen(&self) -> bool {
        let tables = &self.tables;
        !(tables.point.is_empty() && tables.spot.is_empty() && tables.distant.is_empty())
    }

    /// Returns the lights at the indices `light`.
    #[inline(always)]
    pub(crate) fn get<R: Real>(&self, light: R::Word) -> Chosen<'_, R> {
        let index = R::index_of_few(light, self.rows.len());
        let (emission, flags) = R::gather(&self.rows, index, |rows| &rows[0]);
        Chosen { lights: self, light, index, emission, flags: flags.to_bits(), chance: None }
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

    /// Returns the probability with which [`Lights::choose`] chooses the light for the point `from`.
    #[inline(always)]
    pub(crate) fn chance(&self, from: R::Vec3) -> R {
        match &self.lights.choice {
            Choice::Only => R::ONE,
            Choice::Power(_) => self.chance_and_place()[0],
            Choice::Tree(tree, others) => self.chance.unwrap_or_else(|| {
                tree.chance::<R>(self.light, from) * (1.0 / (others.len() + 1) as f32)
            }),
        }
    }

    /// Returns the radiance towards a viewer. `front` marks viewers on the front side of the light.
    #[inline(always)]
    pub(crate) fn radiance(&self, front: R::Mask) -> R::Vec3 {
        let one_sided = (self.flags & R::Word::splat(FRONT_ONLY)).eq(R::Word::splat(FRONT_ONLY));
        (one_sided & !front).select(R::Vec3::zero(), self.emission)
    }
}
