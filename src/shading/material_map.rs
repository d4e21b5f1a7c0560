//! The material of each primitive.

/// The materials of a geometry's primitives, stored for each sphere and quad and for ranges of
/// triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MaterialMap {
    /// The material of each sphere and quad.
    pub(crate) solids: Vec<u32>,
    /// Ranges of triangles with the same material: one past the last primitive, and the material.
    pub(crate) ranges: Vec<(u32, u32)>,
}

impl MaterialMap {
    /// The material of a primitive.
    pub(crate) fn get(&self, primitive: u32) -> u32 {
        match self.solids.get(primitive as usize) {
            Some(material) => *material,
            None => self.ranges[self.ranges.partition_point(|&(end, _)| end <= primitive)].1,
        }
    }
}
