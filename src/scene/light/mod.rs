//! Lights that paths sample directly. Each kind has a file with its table and its sampling.
//!
//! The list in `lights!` generates the kinds, the tables and the dispatch.

mod alias;
mod distant;
mod environment;
mod file;
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

use glam::{DVec3, Vec3};

use self::alias::AliasTable;
pub use self::distant::Distant;
pub(crate) use self::environment::Environment;
pub use self::environment::Mapping;
pub use self::file::LightFile;
use self::file::{FreeLight, FreeLightModel};
pub use self::point::Point;
pub(crate) use self::sample::LightSample;
pub use self::spot::Spot;
use self::tree::{LightBounds, LightTree};
use super::background::Background;
pub use super::background::EnvironmentMap;
use super::emission::{Emission, Sides, luminance};
use crate::geometry::{Primitive, Ray};
use crate::math::random::unit_interval;
use crate::math::{Mask, Real, Row, Vector, Word, row, whole};
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
    fn pdf<R: Real>(table: &[Self], index: R::Index, ray: &Ray<R>, t: R) -> R;
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

/// Up to this number of lights, they are chosen by power alone.
const MOST_BY_POWER: usize = 64;

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

/// Collects the lights of a scene.
#[derive(Default)]
pub(super) struct LightsBuilder {
    lights: Lights,
    /// The bounds and the power of each light, or `None` for light from outside the scene.
    inside: Vec<Option<LightBounds>>,
}

impl LightsBuilder {
    /// Adds a primitive that emits light.
    pub(super) fn push(&mut self, primitive: Primitive, emission: Emission) {
        let Emission { radiance, sides } = emission;
        let (kind, place, area, normal) = self.lights.tables.push(primitive);
        let one_sided = if sides == Sides::Front { FRONT_ONLY } else { 0 };
        let faces = if sides == Sides::Both { 2.0 } else { 1.0 };
        let bounds = LightBounds {
            bounds: primitive.bounds(),
            axis: normal.unwrap_or(DVec3::Z),
            cos: if normal.is_some() { 1.0 } else { -1.0 },
            two_sided: sides == Sides::Both,
            power: luminance(radiance) * area * faces,
        };
        self.add(kind, place as usize, radiance, one_sided, Some(bounds));
    }

    /// Adds a light that is not a primitive, unless it is black.
    pub(super) fn push_free(&mut self, light: &LightFile) {
        let tables = &mut self.lights.tables;
        let (kind, place, FreeLight { radiance, inside }) = match light {
            LightFile::Point(light) => file::push(light, LightKind::PointLight, &mut tables.point),
            LightFile::Spot(light) => file::push(light, LightKind::SpotLight, &mut tables.spot),
            LightFile::Distant(light) => {
                file::push(light, LightKind::DistantLight, &mut tables.distant)
            }
        };
        if radiance != Vec3::ZERO {
            self.add(kind, place, radiance, 0, inside);
        }
    }

    /// Adds the environment map, if the background is one and is not black.
    pub(super) fn push_background(&mut self, background: &Background) {
        if let Background::Image(map) = background
            && let Some(light) = Environment::new(map)
        {
            self.lights.environment = Some(self.inside.len() as u32);
            self.lights.tables.environment.push(light);
            self.add(LightKind::Environment, 0, Vec3::splat(map.scale), 0, None);
        }
    }

    /// Adds the row of a light whose entry is at `place` in the table of its kind.
    fn add(
        &mut self,
        kind: LightKind,
        place: usize,
        radiance: Vec3,
        flags: u32,
        inside: Option<LightBounds>,
    ) {
        let flags = (kind as u32) << KIND_SHIFT | flags;
        self.lights.rows.push([row(radiance, f32::from_bits(flags)), [0, place as u32, 0, 0]]);
        // Above 0 even for the dimmest light.
        let power = |power: f64| if power > 1e-300 { power } else { 1e-300 };
        self.inside.push(inside.map(|light| LightBounds { power: power(light.power), ..light }));
    }

    /// Prepares the choice of lights: in proportion to their power, or by a tree if there are many.
    /// Each light from outside, whose power depends on the size of the scene, is as probable as all
    /// others together.
    pub(super) fn finish(self) -> Lights {
        let Self { mut lights, inside } = self;
        let (count, outside) =
            (inside.iter().flatten().count(), |light: &u32| inside[*light as usize].is_none());
        if inside.len() <= 1 {
            return lights;
        }
        let all: f64 = inside.iter().flatten().map(|light| light.power).sum();
        if count > MOST_BY_POWER {
            // A single-precision number can hold these shares.
            let share = |power: f64| (power / all).max(1e-12);
            let relative =
                |light: &LightBounds| LightBounds { power: share(light.power), ..*light };
            let bounds: Vec<_> = inside.iter().map(|light| light.as_ref().map(relative)).collect();
            let others = (0..inside.len() as u32).filter(outside).collect();
            lights.choice = Choice::Tree(LightTree::new(&bounds), others);
            return lights;
        }
        let weight = |light: &Option<LightBounds>| match light {
            Some(light) => light.power,
            None if count > 0 => all,
            None => 1.0,
        };
        let weights: Vec<f64> = inside.iter().map(weight).collect();
        let table = AliasTable::new(&weights);
        for ([_, chance], index) in lights.rows.iter_mut().zip(0..) {
            chance[0] = (table.share(index) as f32 * (1.0 / 4_294_967_296.0)).to_bits();
        }
        lights.choice = Choice::Power(table);
        lights
    }
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
                let parts = R::splat(1.0 / (others.len() + 1) as f32);
                let is = |kind| self.is(kind);
                let outside = is(LightKind::DistantLight) | is(LightKind::Environment);
                // The tree does not know the lights outside the scene, but has some leaf for them.
                outside.select(parts, parts * tree.chance::<R>(self.light, from))
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
