//! Holes in triangles, such as those between the leaves on a picture of foliage.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use super::{Ray, Triangles};

/// Decides where triangles have holes.
pub trait HoleTest: Any + Debug + Send + Sync {
    /// Whether triangle `triangle` of `triangles` has a hole where `ray` hits it at distance `t`. The
    /// ray is in the space of the triangles. `instance` is 0 for triangles that no instance places.
    ///
    /// The answer may depend on nothing else, so that hits are defined without a tree.
    fn is_hole(
        &self,
        triangles: &Triangles,
        triangle: u32,
        instance: u32,
        ray: &Ray,
        t: f32,
    ) -> bool;

    /// Whether `other` has the same holes.
    fn equals(&self, other: &dyn HoleTest) -> bool;
}

/// The triangles that may have holes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holes(Option<Arc<Marked>>);

#[derive(Debug)]
struct Marked {
    /// A bit for each triangle.
    bits: Vec<u64>,
    holes: Arc<dyn HoleTest>,
}

impl PartialEq for Marked {
    fn eq(&self, other: &Self) -> bool {
        self.bits == other.bits && self.holes.equals(&*other.holes)
    }
}

impl Holes {
    /// The triangles among the first `count` for which `has_holes` returns true.
    pub fn new(count: usize, has_holes: impl Fn(usize) -> bool, holes: Arc<dyn HoleTest>) -> Self {
        let mut bits = vec![0; count.div_ceil(64)];
        for triangle in (0..count).filter(|&triangle| has_holes(triangle)) {
            bits[triangle / 64] |= 1 << (triangle % 64);
        }
        let some = bits.iter().any(|&word| word != 0);
        Self(some.then(|| Arc::new(Marked { bits, holes })))
    }

    /// Whether any triangle may have holes.
    pub(crate) fn any(&self) -> bool {
        self.0.is_some()
    }

    /// Whether `ray` hits triangle `triangle` of `triangles` at distance `t` in a hole.
    #[inline]
    pub(super) fn is_hole(
        &self,
        triangles: &Triangles,
        triangle: usize,
        instance: u32,
        ray: &Ray,
        t: f32,
    ) -> bool {
        let Some(marked) = &self.0 else { return false };
        let may = marked.bits[triangle / 64] >> (triangle % 64) & 1 == 1;
        may && marked.holes.is_hole(triangles, triangle as u32, instance, ray, t)
    }
}
