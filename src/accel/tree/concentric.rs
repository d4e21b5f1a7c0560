//! Groups of primitives whose boxes have the same centre. The builder treats each group as one
//! primitive.
//!
//! The builder of the crate obvhs merges boxes that are nearest neighbours of each other (PLOC).
//! Among boxes that are all equally near, it merges one pair in each round and takes quadratic
//! time: 100 000 equal spheres took over ten minutes.

use std::ops::Range;

use crate::geometry::Bounds;

/// The members of each group, one group after the other.
pub(crate) struct Concentric {
    members: Vec<u32>,
    ranges: Vec<Range<usize>>,
}

/// Up to this number of primitives with the same centre are passed to the builder individually.
const MOST_SEPARATE: usize = 8;

impl Concentric {
    pub(crate) fn new(boxes: &[Bounds], primitives: &[u32]) -> Self {
        let middle = |primitive: u32| {
            let b = boxes[primitive as usize];
            (b.min + b.max).to_array().map(f32::to_bits)
        };
        let mut by_middle: Vec<([u32; 3], u32)> =
            (0..).zip(primitives).map(|(at, &primitive)| (middle(primitive), at)).collect();
        by_middle.sort_unstable();
        let runs = by_middle.chunk_by(|a, b| a.0 == b.0);
        let crowds: Vec<_> = runs.filter(|run| run.len() > MOST_SEPARATE).collect();
        let mut crowded = vec![false; primitives.len()];
        crowds.iter().copied().flatten().for_each(|&(_, at)| crowded[at as usize] = true);

        // The others keep their order, since neighbours in memory are mostly neighbours in space.
        let separate = primitives.iter().zip(&crowded).filter(|(_, crowded)| !**crowded);
        let mut members: Vec<u32> = separate.map(|(primitive, _)| *primitive).collect();
        let mut ranges: Vec<Range<usize>> = (0..members.len()).map(|i| i..i + 1).collect();
        for crowd in crowds {
            let start = members.len();
            members.extend(crowd.iter().map(|&(_, at)| primitives[at as usize]));
            ranges.push(start..members.len());
        }
        Self { members, ranges }
    }

    pub(crate) fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Returns the primitives of one group.
    pub(crate) fn members(&self, group: usize) -> &[u32] {
        &self.members[self.ranges[group].clone()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn only_crowds_are_grouped() {
        let about = |middle: f32, size: f32| Bounds {
            min: Vec3::splat(middle - size),
            max: Vec3::splat(middle + size),
        };
        let mut boxes = vec![about(1.0, 0.5), about(3.0, 0.5), about(3.0, 0.25)];
        boxes.extend((0..9u8).map(|i| about(2.0, 1.0 / f32::from(1u8 << i.min(6)))));
        let each: Vec<u32> = (0..boxes.len() as u32).collect();
        let groups = Concentric::new(&boxes, &each);
        let mut sizes: Vec<usize> = (0..groups.len()).map(|g| groups.members(g).len()).collect();
        // Those that are no crowd keep their order.
        assert!((0..3).all(|group| groups.members(group as usize) == [group]));
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 1, 1, 9]);
        let mut all: Vec<u32> =
            (0..groups.len()).flat_map(|g| groups.members(g).to_vec()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..12).collect::<Vec<u32>>());
    }
}
