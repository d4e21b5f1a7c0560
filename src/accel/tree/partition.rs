//! Splits the primitives of large scenes into clusters, whose trees are built separately.
//!
//! The builder of the crate obvhs takes more than linear time, because its searches miss the caches
//! in large trees. Clusters that fit into the caches take linear time, and threads can build
//! different ones at once. The clusters do not depend on the number of threads.

use crate::accel::threads::map;
use crate::geometry::Bounds;

/// Largest number of primitives in a cluster. With a quarter of it, large scenes were built as fast,
/// but rays took 6% longer in a mesh of 124 000 triangles (`profiling/`).
pub(crate) const MAX_CLUSTER: usize = 1 << 17;
/// Number of bins along the longest axis in which splits are compared.
const BINS: usize = 32;

/// The primitives in a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, count: 0 };

    fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// The share of this side in the cost of a split (surface area heuristic).
    fn cost(self) -> f32 {
        self.bounds.half_area() * self.count as f32
    }
}

/// Splits `primitives`, whose boxes are `boxes[primitive]`, into clusters of at most `most`. The result does not
/// depend on the number of threads.
pub(crate) fn clusters(
    boxes: &[Bounds],
    primitives: Vec<u32>,
    most: usize,
    threads: usize,
) -> Vec<Vec<u32>> {
    let mut parts = vec![primitives];
    while parts.iter().any(|part| part.len() > most) {
        let halves = |part: Vec<u32>| match part.len() > most {
            false => vec![part],
            true => split(boxes, part).into(),
        };
        parts = map(threads, parts, halves).into_iter().flatten().collect();
    }
    parts
}

/// Splits `primitives` in two. Of the planes between bins along the longest axis, it takes the one
/// of least cost (Wald 2007, "On Fast Construction of SAH-based Bounding Volume Hierarchies"). If all
/// centres are equal, each side gets half of the primitives.
fn split(boxes: &[Bounds], mut primitives: Vec<u32>) -> [Vec<u32>; 2] {
    let center = |&p: &u32| boxes[p as usize].min + boxes[p as usize].max;
    let centers = Bounds::of(primitives.iter().map(center));
    let edges = centers.max - centers.min;
    let axis = edges.max_position();
    let (low, scale) = (centers.min[axis], BINS as f32 / edges[axis]);
    let bin_of = |p: &u32| {
        let Bounds { min, max } = boxes[*p as usize];
        (((min[axis] + max[axis] - low) * scale) as usize).min(BINS - 1)
    };
    let mut bins = [Bin::EMPTY; BINS];
    for p in &primitives {
        let bin = &mut bins[bin_of(p)];
        *bin = bin.union(Bin { bounds: boxes[*p as usize], count: 1 });
    }

    let mut right = [Bin::EMPTY; BINS];
    for bin in (1..BINS).rev() {
        right[bin - 1] = right[bin].union(bins[bin]);
    }
    let (mut left, mut best) = (Bin::EMPTY, (f32::INFINITY, None));
    for bin in 0..BINS - 1 {
        left = left.union(bins[bin]);
        let cost = left.cost() + right[bin].cost();
        if left.count > 0 && right[bin].count > 0 && cost < best.0 {
            best = (cost, Some(bin));
        }
    }
    match best.1 {
        Some(last) => primitives.into_iter().partition(|p| bin_of(p) <= last).into(),
        None => {
            let second = primitives.split_off(primitives.len() / 2);
            [primitives, second]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use glam::Vec3;

    const MOST: usize = 1 << 14;

    /// Small boxes at random places, on a line, or all at one place.
    fn boxes(shape: usize, count: usize) -> Vec<Bounds> {
        let mut random = Stream::new(3);
        let place = |_| {
            let [x, y, z] = [(); 3].map(|()| random.uniform());
            let min = match shape {
                0 => Vec3::new(x, y, z),
                // Most are crowded at one end.
                1 => Vec3::X * (x * x * x * x * x * x * x * x),
                _ => Vec3::ONE,
            };
            Bounds { min, max: min + 1e-3 }
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn clusters_hold_all_primitives_on_any_number_of_threads() {
        for shape in 0..3 {
            let boxes = boxes(shape, 5 * MOST + 7);
            let all: Vec<u32> = (0..boxes.len() as u32).collect();
            let one = clusters(&boxes, all.clone(), MOST, 1);
            assert_eq!(one, clusters(&boxes, all.clone(), MOST, 3));
            assert!(one.len() > 5 && one.iter().all(|cluster| (1..=MOST).contains(&cluster.len())));
            let mut held = one.concat();
            held.sort_unstable();
            assert_eq!(held, all);
        }
    }
}
