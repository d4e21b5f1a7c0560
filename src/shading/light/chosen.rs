//! Chooses lights and samples them.

use super::lights::{Choice, FRONT_ONLY, KIND_SHIFT, Lights, UNSEEN, VARIES};
use super::tree::LightTree;
use super::{Environment, LightKind, LightSample, Listed, TableFold};
use crate::geometry::Ray;
use crate::math::random::unit_interval;
use crate::math::{Mask, Real, Vector, Word, whole};
use crate::sampler::{Dimension, Randoms};

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

    /// Returns the lights at the indices `light`.
    #[inline(always)]
    pub(crate) fn get<R: Real>(&self, light: R::Word) -> Chosen<'_, R> {
        let index = R::index_of_few(light, self.rows.len());
        let (emission, flags) = R::gather(&self.rows, index, |rows| &rows[0]);
        Chosen { lights: self, light, index, emission, flags: flags.to_bits(), chance: None }
    }
}

impl<R: Real> Chosen<'_, R> {
    /// Samples directions from `from` to the lights.
    ///
    /// It is inlined, for without that `cornell` takes 1.1 times as long. Only lights on primitives
    /// are: the others would make all loops over vertices larger.
    #[inline(always)]
    pub(crate) fn sample(&self, from: R::Vec3, time: R, uv: (R, R)) -> LightSample<R> {
        let none = LightSample {
            direction: from,
            distance: R::ZERO,
            pdf: R::ZERO,
            tint: R::Vec3::gray(R::ONE),
            front: R::Mask::NONE,
            visible: R::Mask::NONE,
        };
        self.lights.tables.fold(&Sample { chosen: self, from, time, uv }, none)
    }

    /// Returns the density with which [`Chosen::sample`] draws `ray.direction` from
    /// `ray.origin`. The rays hit the lights at distance `t`.
    #[inline(always)]
    pub(crate) fn pdf(&self, ray: &Ray<R>, t: R) -> R {
        self.lights.tables.fold(&Pdf { chosen: self, ray, t }, R::ZERO)
    }

    /// Returns which of the lights only light samples find.
    #[inline(always)]
    pub(crate) fn unseen(&self) -> R::Mask {
        self.has(UNSEEN)
    }

    /// Returns which of the lights have a radiance that varies.
    #[inline(always)]
    pub(crate) fn varies(&self) -> R::Mask {
        self.has(VARIES)
    }

    /// The primitives that are the lights.
    #[inline(always)]
    pub(crate) fn primitive(&self) -> R::Word {
        self.chance_and_place()[2].to_bits()
    }

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
        self.is_dark(front).select(R::Vec3::zero(), self.emission)
    }

    /// Returns which of the lights emit nothing to viewers on this side.
    #[inline(always)]
    pub(crate) fn is_dark(&self, front: R::Mask) -> R::Mask {
        self.has(FRONT_ONLY) & !front
    }

    #[inline(always)]
    fn has(&self, flag: u32) -> R::Mask {
        (self.flags & R::Word::splat(flag)).eq(R::Word::splat(flag))
    }
}

/// [`Chosen::sample`].
struct Sample<'a, R: Real> {
    chosen: &'a Chosen<'a, R>,
    from: R::Vec3,
    time: R,
    uv: (R, R),
}

impl<R: Real> TableFold for Sample<'_, R> {
    type Value = LightSample<R>;

    #[inline(always)]
    fn step<L: Listed>(&self, table: &[L], found: LightSample<R>) -> LightSample<R> {
        let here = self.chosen.is(L::KIND);
        if !here.any() {
            return found;
        }
        let index = self.chosen.place(here, table.len());
        here.select(L::sample(table, index, self.from, self.time, self.uv), found)
    }
}

/// [`Chosen::pdf`].
struct Pdf<'a, R: Real> {
    chosen: &'a Chosen<'a, R>,
    ray: &'a Ray<R>,
    t: R,
}

impl<R: Real> TableFold for Pdf<'_, R> {
    type Value = R;

    #[inline(always)]
    fn step<L: Listed>(&self, table: &[L], pdf: R) -> R {
        let here = self.chosen.is(L::KIND);
        if !here.any() {
            return pdf;
        }
        let index = self.chosen.place(here, table.len());
        here.select(L::pdf(table, index, self.ray, self.t), pdf)
    }
}
