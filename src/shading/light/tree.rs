//! The choice among many lights by a tree, which favours lights that are near, bright and turned
//! towards the point that they light (Conty Estevez, Kulla 2018, "Importance Sampling of Many Lights
//! with Adaptive Tree Splitting").
//!
//! The tree is complete, so that all lanes descend through the same number of levels. It differs from
//! the paper in three points: nodes are split at the median, nothing depends on the normal of the
//! point, which paths do not keep until they hit a light, and no light has a probability of 0.

use glam::{DVec3, Vec3};

use crate::geometry::Bounds;
use crate::math::random::unit_interval;
use crate::math::{Mask, Real, Row, Word, clamp, dot, max, min, mix32, row};

/// Least cosine of the angle between the direction of a light and that to the point.
const LEAST_COSINE: f32 = 0.01;
/// Least probability of a branch with lights. It bounds the weight of lights whose importance is
/// underestimated, and the rounding error of probabilities.
const LEAST_CHANCE: f32 = 1.0 / 1024.0;
/// Once the chosen branches have a probability below this one, a random number has too few digits
/// left, and a hash of it takes its place.
const FEW_DIGITS: f32 = 1.0 / 16.0;
/// The leaf of lights that are not in the tree.
const NO_LEAF: u32 = u32::MAX;
/// The largest random number.
const LAST: f32 = 1.0 - 1.0 / (1 << 24) as f32;

/// The position, direction and power of a light, or bounds on those of several.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub(super) bounds: Bounds,
    /// Unit axis of a cone.
    pub(super) axis: DVec3,
    /// Cosine of the angle from the axis to the normals of the lights, which emit to up to 90° from
    /// their normals; −1 if they emit in all directions.
    pub(super) cos: f64,
    /// Whether the lights also emit to the other side.
    pub(super) two_sided: bool,
    /// Share of the power of all lights, above 0.
    pub(super) power: f64,
}

/// A node: (centre of a sphere around the lights, square of its radius), (axis of the cone of their
/// normals, cosine of its angle), and (power, 1 if the lights emit to both sides, 0, 0).
type Node = [Row; 3];

/// A complete binary tree over lights.
#[derive(Debug)]
pub(super) struct LightTree {
    /// The children of node `i` are `2 i` and `2 i + 1`, and the root is node 1.
    nodes: Vec<Node>,
    /// Number of levels below the root.
    depth: u32,
    /// The light of each leaf, or 0 for leaves without a light, which have no power.
    light_of: Vec<u32>,
    /// The leaf of each light, or [`NO_LEAF`].
    leaf_of: Vec<u32>,
}

impl LightTree {
    /// Creates the tree of these lights. At least one must be in the tree; those that are not are `None`.
    pub(super) fn new(lights: &[Option<LightBounds>]) -> Self {
        let number = |light: &u32| lights[*light as usize].is_some();
        let mut order: Vec<u32> = (0..lights.len() as u32).filter(number).collect();
        let depth = order.len().next_power_of_two().ilog2();
        let leaves = 1 << depth;
        let mut tree = Self {
            nodes: vec![[[0; 4]; 3]; 2 * leaves],
            depth,
            light_of: vec![0; leaves],
            leaf_of: vec![NO_LEAF; lights.len()],
        };
        tree.fill(1, lights, &mut order);
        tree
    }

    /// Fills the subtree of `node` with the lights `order`.
    fn fill(&mut self, node: usize, lights: &[Option<LightBounds>], order: &mut [u32]) {
        let of =
            |light: u32| lights[light as usize].as_ref().expect("`order` has only such lights");
        let Some(all) = union(order.iter().map(|&light| of(light))) else { return };
        self.nodes[node] = all.node();
        let leaves = self.light_of.len();
        if node >= leaves {
            let light = order[0];
            self.light_of[node - leaves] = light;
            self.leaf_of[light as usize] = (node - leaves) as u32;
            return;
        }
        let center = |light: u32| {
            let Bounds { min, max } = of(light).bounds;
            (min + max) * 0.5
        };
        let centers = Bounds::of(order.iter().map(|&light| center(light)));
        let size = centers.max - centers.min;
        let axis = if size.x >= size.y { 0 } else { 1 };
        let axis = if size[axis] >= size.z { axis } else { 2 };
        let half = order.len().div_ceil(2);
        if half < order.len() {
            let key = |light: &u32| (center(*light)[axis], *light);
            let by_key = |a: &u32, b: &u32| {
                let ((a, i), (b, j)) = (key(a), key(b));
                a.total_cmp(&b).then(i.cmp(&j))
            };
            order.select_nth_unstable_by(half, by_key);
        }
        let (left, right) = order.split_at_mut(half);
        self.fill(2 * node, lights, left);
        self.fill(2 * node + 1, lights, right);
    }

    /// Chooses a light for the point `from` by `bits`. Returns its index and its probability.
    #[inline(never)]
    pub(super) fn choose<R: Real>(&self, from: R::Vec3, bits: R::Word) -> (R::Word, R) {
        let (mut node, one) = (R::Word::splat(1), R::Word::splat(1));
        let (mut chance, mut digits) = (R::ONE, R::ONE);
        let mut u = unit_interval::<R>(bits);
        for level in 0..self.depth {
            let children = node << 1;
            let left = self.left_chance::<R>(children, from);
            let goes_left = u.lt(left);
            let part = goes_left.select(left, R::ONE - left);
            // Rounding must not yield 1, or the search would enter a branch without lights.
            u = min(goes_left.select(u, u - left) / part, R::splat(LAST));
            (chance, digits) = (chance * part, digits * part);
            node = goes_left.select(children, children.wrapping_add(one));
            let few = digits.lt(R::splat(FEW_DIGITS));
            if few.any() {
                let fresh = unit_interval::<R>(mix32(bits.wrapping_add(R::Word::splat(level + 1))));
                u = few.select(fresh, u);
                digits = few.select(R::ONE, digits);
            }
        }
        let leaf = node.wrapping_sub(R::Word::splat(self.light_of.len() as u32));
        (R::pick(&self.light_of, R::index(leaf, self.light_of.len())), chance)
    }

    /// Returns the probability with which [`LightTree::choose`] chooses `light` for the point `from`,
    /// or 1 for a light that is not in the tree.
    #[inline(never)]
    pub(super) fn chance<R: Real>(&self, light: R::Word, from: R::Vec3) -> R {
        let leaf = R::pick(&self.leaf_of, R::index(light, self.leaf_of.len()));
        let missing = leaf.eq(R::Word::splat(NO_LEAF));
        let leaf = missing.select(R::Word::splat(0), leaf);
        let end = leaf.wrapping_add(R::Word::splat(self.light_of.len() as u32));
        let (mut chance, one) = (R::ONE, R::Word::splat(1));
        for level in (0..self.depth).rev() {
            let child = end >> level;
            let is_left = (child & one).eq(R::Word::splat(0));
            let left = self.left_chance::<R>((child >> 1) << 1, from);
            chance = chance * is_left.select(left, R::ONE - left);
        }
        missing.select(R::ONE, chance)
    }

    /// The probability of the node `left` instead of its sibling.
    #[inline(always)]
    fn left_chance<R: Real>(&self, left: R::Word, from: R::Vec3) -> R {
        let right = left.wrapping_add(R::Word::splat(1));
        let (left, right) = (self.importance::<R>(left, from), self.importance::<R>(right, from));
        let chance = left / (left + right);
        // Only right branches may be without lights.
        let kept = clamp(chance, R::splat(LEAST_CHANCE), R::splat(1.0 - LEAST_CHANCE));
        right.gt(R::ZERO).select(kept, R::ONE)
    }

    /// An estimate of the light that the lights of `node` send to the point `from`, above 0 if they
    /// have any power.
    #[inline(always)]
    fn importance<R: Real>(&self, node: R::Word, from: R::Vec3) -> R {
        let index = R::index(node, self.nodes.len());
        let (center, radius2) = R::gather(&self.nodes, index, |node| &node[0]);
        let (axis, cos_cone) = R::gather(&self.nodes, index, |node| &node[1]);
        let (rest, _) = R::gather(&self.nodes, index, |node| &node[2]);
        let to = from - center;
        let distance2 = dot(to, to);
        let outside = distance2.gt(radius2);
        let nearest2 = outside.select(distance2, radius2);
        let cos = dot(axis, to) / distance2.sqrt();
        let cos = rest[1].gt(R::ZERO).select(cos.abs(), cos);
        let sine = |cos: R| max(R::ONE - cos * cos, R::ZERO).sqrt();
        // The angle to the axis, less that of the cone, less that of the sphere as seen from the point.
        let (cos, sin) = less((cos, sine(cos)), (cos_cone, sine(cos_cone)));
        let sin2 = radius2 / nearest2;
        let sphere = (max(R::ONE - sin2, R::ZERO).sqrt(), sin2.sqrt());
        let (cos, _) = less((cos, sin), sphere);
        let facing = outside.select(max(cos, R::splat(LEAST_COSINE)), R::ONE);
        // A point in the only point of a light without size has no direction to it.
        rest[0] * facing / max(nearest2, R::splat(f32::MIN_POSITIVE))
    }
}

/// Cosine and sine of the difference of two angles in [0, π], or of 0 if it is negative.
#[inline(always)]
fn less<R: Real>((cos_a, sin_a): (R, R), (cos_b, sin_b): (R, R)) -> (R, R) {
    let negative = cos_a.gt(cos_b);
    let cos = cos_a * cos_b + sin_a * sin_b;
    let sin = sin_a * cos_b - cos_a * sin_b;
    (negative.select(R::ONE, cos), negative.select(R::ZERO, sin))
}

impl LightBounds {
    fn node(&self) -> Node {
        let Bounds { min, max } = self.bounds;
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let rest = Vec3::new(self.power as f32, f32::from(u8::from(self.two_sided)), 0.0);
        [row(center, dot(half, half)), row(self.axis.as_vec3(), self.cos as f32), row(rest, 0.0)]
    }
}

/// Bounds on all lights of a list; `None` if it is empty.
fn union<'a>(lights: impl Iterator<Item = &'a LightBounds> + Clone) -> Option<LightBounds> {
    let first = lights.clone().next()?;
    // Normals of two-sided lights may be turned around.
    let aligned = |light: &LightBounds, axis: DVec3| {
        if light.two_sided && light.axis.dot(axis) < 0.0 { -light.axis } else { light.axis }
    };
    let sum: DVec3 = lights.clone().map(|light| aligned(light, first.axis)).sum();
    let length = sum.dot(sum).sqrt();
    let axis = if length > 1e-9 { sum / length } else { first.axis };
    let mut all = LightBounds { axis, cos: 1.0, power: 0.0, bounds: Bounds::EMPTY, ..*first };
    for light in lights {
        let cos = aligned(light, axis).dot(axis).clamp(-1.0, 1.0);
        // Cosine of the sum of two angles, or −1 if that exceeds 180°.
        let sin = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let widest =
            if cos + light.cos <= 0.0 { -1.0 } else { cos * light.cos - sin(cos) * sin(light.cos) };
        all.cos = all.cos.min(widest);
        all.two_sided |= light.two_sided;
        all.power += light.power;
        all.bounds = all.bounds.union(light.bounds);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::math::warp::uniform_sphere;

    fn lights(count: usize, random: &mut Stream) -> Vec<Option<LightBounds>> {
        let mut light = || {
            let center =
                uniform_sphere(random.uniform(), random.uniform()) * random.between(0.0, 5.0);
            let half = Vec3::splat(random.between(0.0, 0.1));
            LightBounds {
                bounds: Bounds { min: center - half, max: center + half },
                axis: uniform_sphere(random.uniform(), random.uniform()).as_dvec3().normalize(),
                cos: [1.0, 1.0, -1.0, 0.3][random.bits() as usize % 4],
                two_sided: random.bits().is_multiple_of(3),
                // Over six orders of magnitude.
                power: [1.0, 1e-2, 1e-4, 1e-6][random.bits() as usize & 3],
            }
        };
        (0..count).map(|_| Some(light())).collect()
    }

    #[test]
    fn probabilities_add_up_to_1_and_are_those_of_choices() {
        let mut random = Stream::new(5);
        for count in [1, 2, 3, 64, 100] {
            let lights = lights(count, &mut random);
            let tree = LightTree::new(&lights);
            for _ in 0..4 {
                let from = uniform_sphere(random.uniform(), random.uniform()) * 3.0;
                let chances: Vec<f32> =
                    (0..count as u32).map(|light| tree.chance::<f32>(light, from)).collect();
                let sum: f64 = chances.iter().map(|&chance| f64::from(chance)).sum();
                assert!((sum - 1.0).abs() < 1e-5, "{count}: {sum}");
                let (mut counts, n) = (vec![0u32; count], 200_000);
                for _ in 0..n {
                    let (light, chance) = tree.choose::<f32>(from, random.bits() as u32);
                    assert_eq!(chance, chances[light as usize]);
                    counts[light as usize] += 1;
                }
                for (&count, &chance) in counts.iter().zip(&chances) {
                    let expected = f64::from(chance) * f64::from(n);
                    let off = (f64::from(count) - expected).abs();
                    assert!(off < 6.0 * expected.sqrt() + 3.0, "{count} {expected}");
                }
            }
        }
    }

    #[test]
    #[allow(clippy::disallowed_methods)] // angles are computed in f64 with libm
    fn bounds_contain_their_lights() {
        let mut random = Stream::new(6);
        for _ in 0..400 {
            // Lights that shine in all directions would hide the cones of the others.
            let mut lights = lights(3, &mut random);
            lights.iter_mut().flatten().for_each(|light| light.cos = light.cos.max(0.3));
            let all = union(lights.iter().flatten()).unwrap();
            for light in lights.iter().flatten() {
                let cos = light.axis.dot(all.axis);
                let cos = if all.two_sided { cos.abs() } else { cos };
                // The angle to the axis of the union, and that of the light's own cone.
                let angle = cos.clamp(-1.0, 1.0).acos() + light.cos.acos();
                let angle = angle.min(std::f64::consts::PI);
                assert!(angle <= all.cos.acos() + 1e-6, "{angle} {}", all.cos);
                let both = all.bounds.union(light.bounds);
                assert_eq!((both.min, both.max), (all.bounds.min, all.bounds.max));
            }
        }
    }
}
