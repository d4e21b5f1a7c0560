//! Bodies: what surfaces of glass enclose, which absorbs light along the segments of paths.

use glam::Vec3;

use crate::math::powers::exp;
use crate::math::{Mask, Real, Row, Vector, Word, row};

/// What the bodies of a scene absorb.
#[derive(Debug)]
pub(crate) struct Bodies {
    /// Absorption per unit of length. Bodies that absorb the same share a row. The first is the outside.
    rows: Vec<Row>,
    absorb: bool,
}

impl Default for Bodies {
    fn default() -> Self {
        Self { rows: vec![[0; 4]], absorb: false }
    }
}

/// Largest number of different absorptions.
const MOST: usize = 1 << 16;

impl Bodies {
    /// Returns the code of a body with this absorption, or 0 for a surface that encloses none.
    pub(super) fn code(&mut self, absorption: Option<Vec3>) -> u32 {
        let Some(absorption) = absorption else { return 0 };
        self.absorb |= absorption != Vec3::ZERO;
        let body = row(absorption, 0.0);
        let index =
            1 + self.rows[1..].iter().position(|&other| other == body).unwrap_or_else(|| {
                self.rows.push(body);
                self.rows.len() - 2
            });
        assert!(index < MOST, "a scene can have at most 65535 kinds of glass");
        index as u32
    }

    /// Whether no body absorbs light. Paths then need no [`Nesting`].
    pub(crate) fn are_clear(&self) -> bool {
        !self.absorb
    }

    /// The share of light that travels this distance in the body that was entered last.
    #[inline(always)]
    pub(crate) fn transmittance<R: Real>(&self, nesting: Nesting<R>, distance: R) -> R::Vec3 {
        let index = R::index(nesting.inner(), self.rows.len());
        let (absorption, _) = R::gather(&self.rows, index, |row| row);
        let kept = |i: usize| {
            let absorbs = absorption[i].gt(R::ZERO);
            // A path that leaves the scene has an infinite distance.
            absorbs.select(exp(-(absorption[i] * distance)), R::ONE)
        };
        R::Vec3::new(kept(0), kept(1), kept(2))
    }
}

/// The bodies that a path is in, or that one path per lane is in: the code of the one entered last, and in
/// the upper half of the word the code of the one entered before. The outside has code 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nesting<R: Real>(pub(crate) R::Word);

impl<R: Real> Nesting<R> {
    pub(crate) const BITS: u32 = 16;

    #[inline(always)]
    fn inner(self) -> R::Word {
        self.0 & R::Word::splat((1 << Self::BITS) - 1)
    }

    /// The bodies beyond the surface of `body`, which a path passes from its `front` or from within.
    #[inline(always)]
    pub(crate) fn beyond(self, body: R::Word, front: R::Mask) -> Self {
        let (inner, outer) = (self.inner(), self.0 >> Self::BITS);
        let entered = inner << Self::BITS | body;
        let left = outer.eq(body).select(inner, self.0);
        let left = inner.eq(body).select(outer, left);
        let none = body.eq(R::Word::splat(0));
        Self(none.select(self.0, front.select(entered, left)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_left_in_any_order() {
        let beyond = |Nesting::<f32>(word), body, front| Nesting::<f32>(word).beyond(body, front).0;
        let at = |steps: &[(u32, bool)]| {
            steps.iter().fold(0, |word, &(body, front)| beyond(Nesting(word), body, front)) & 0xffff
        };
        assert_eq!(at(&[(3, true)]), 3);
        assert_eq!(at(&[(3, true), (3, false)]), 0);
        assert_eq!(at(&[(3, true), (5, true)]), 5, "the body entered last counts");
        assert_eq!(at(&[(3, true), (5, true), (5, false)]), 3, "ice in a drink");
        assert_eq!(at(&[(3, true), (5, true), (3, false)]), 5, "a drink that overlaps its glass");
        assert_eq!(at(&[(3, true), (5, true), (3, false), (5, false)]), 0);
        assert_eq!(at(&[(3, true), (3, true), (3, false)]), 3, "two bodies that overlap");
        assert_eq!(at(&[(3, false)]), 0, "a body that was not entered");
        assert_eq!(at(&[(3, true), (0, true), (0, false)]), 3, "a surface that encloses nothing");
    }

    #[test]
    fn light_fades_by_the_distance() {
        let mut bodies = Bodies::default();
        assert!(bodies.are_clear());
        assert_eq!([bodies.code(None), bodies.code(Some(Vec3::ZERO))], [0, 1]);
        assert!(bodies.are_clear());
        let absorption = Vec3::new(0.0, 0.5, 2.0);
        assert_eq!([(); 2].map(|()| bodies.code(Some(absorption))), [2, 2]);
        assert!(!bodies.are_clear());
        let kept = |body, t| bodies.transmittance::<f32>(Nesting(body), t);
        assert_eq!(kept(0, 9.0), Vec3::ONE);
        assert_eq!(kept(1, f32::INFINITY), Vec3::ONE);
        assert_eq!(kept(2, f32::INFINITY), Vec3::X);
        let (want, got) = (Vec3::new(1.0, exp(-1.0_f32), exp(-4.0_f32)), kept(2, 2.0));
        assert!((got - want).abs().max_element() < 1e-6, "{got}");
    }
}
