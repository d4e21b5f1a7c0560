//! The bodies around a camera.

use super::material::{MaterialModel, MaterialTable, MaterialVisitor};
use super::{Key, Looks, Nesting, SceneTables};
use crate::geometry::{Hit, Ray, Shape};

/// Returns the code of the body that a primitive of this shape encloses.
struct BodyOf<'a>(&'a Looks, Shape, u32);

impl MaterialVisitor for BodyOf<'_> {
    type Output = u32;

    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> u32 {
        let Self(looks, shape, primitive) = self;
        table.bodies[looks.entries::<f32>(shape, primitive, table.entries.len()) as usize]
    }
}

/// Most surfaces that the search for the bodies around a camera passes.
const MOST_SURFACES: usize = 1 << 12;

impl SceneTables {
    /// The bodies around the origin of `ray`: those that it leaves without having entered them. `closest`
    /// finds the closest hit of a ray.
    pub(crate) fn bodies_around(
        &self,
        mut ray: Ray,
        mut closest: impl FnMut(&Ray) -> Option<Hit>,
    ) -> Nesting<f32> {
        let (mut entered, mut around) = (Vec::new(), Vec::new());
        if self.bodies.are_clear() {
            return Nesting(0);
        }
        for _ in 0..MOST_SURFACES {
            let Some(hit) = closest(&ray) else { break };
            let key = self.looks.keys()[usize::from(self.looks.key(hit.primitive))];
            let Key::Surface { shape, kind, .. } = key else { break };
            let instanced = shape == Shape::Instance;
            let at = self.interaction::<f32>(shape, ray, hit, false, false, instanced);
            let body = self.materials.visit(kind, BodyOf(&self.looks, shape, hit.primitive));
            if body != 0 && at.front {
                entered.push(body);
            } else if let Some(last) = entered.iter().rposition(|&other| other == body) {
                entered.remove(last);
            } else if body != 0 {
                around.push(body);
            }
            ray.origin = at.surface.spawn(-at.normal);
        }
        let body = |i: usize| around.get(i).copied().unwrap_or(0);
        Nesting(body(0) | body(1) << Nesting::<f32>::BITS)
    }
}
