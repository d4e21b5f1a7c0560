//! Expansion of primitives, and the material of each.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use super::Resolver;
use crate::error::{Result, suggestion};
use crate::geometry::Geometry;
use crate::scene::looks::MaterialMap;
use crate::scene::mesh::Mesh;
use crate::scene::primitive::Builder;

impl Resolver<'_> {
    /// Returns the primitives, their materials, and the meshes by file.
    pub(super) fn primitives(
        &self,
        folder: &Path,
    ) -> Result<(Geometry, MaterialMap, BTreeMap<PathBuf, Mesh>)> {
        let mut builder = Builder::new(folder, &self.budget);
        let mut solids = [const { Vec::new() }; 2];
        // For each range of triangles, one past its last triangle, and its material.
        let mut ranges: Vec<(u32, u32)> = Vec::new();
        let names: HashMap<&str, u32> = self.file.materials.names().zip(0..).collect();
        for (index, primitive) in self.file.primitives.iter().enumerate() {
            let material = primitive.material();
            let e = self.element(self.places.primitive(index), primitive.name());
            let material = *names.get(material).ok_or_else(|| {
                let known = self.file.materials.names();
                e.error(format!("unknown material `{material}`{}", suggestion(material, known)))
            })?;
            primitive.expand(&e, &mut builder)?;
            let geometry = &builder.geometry;
            for (list, count) in
                solids.iter_mut().zip([geometry.spheres.len(), geometry.quads.len()])
            {
                list.resize(count, material);
            }
            let end = geometry.triangles.len() as u32;
            let begin = ranges.last().map_or(0, |&(end, _)| end);
            match ranges.last_mut() {
                Some((last, same)) if *same == material => *last = end,
                _ if end > begin => ranges.push((end, material)),
                _ => {}
            }
        }
        let solids = solids.concat();
        let ranges = ranges.into_iter().map(|(end, m)| (end + solids.len() as u32, m)).collect();
        let Builder { geometry, meshes, .. } = builder;
        Ok((geometry, MaterialMap { solids, ranges }, meshes.into_iter().collect()))
    }
}
