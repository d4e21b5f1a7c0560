//! Expansion of primitives, and the material of each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::Resolver;
use crate::error::Result;
use crate::geometry::Geometry;
use crate::scene::{Assets, Builder, IndexedMesh, Materials};
use crate::shading::{Material, MaterialMap};

impl Resolver<'_> {
    /// Returns the primitives, their materials, and the meshes by file.
    pub(super) fn primitives(
        &self,
        materials: &[Material],
        folder: &Path,
        assets: &dyn Assets,
    ) -> Result<(Geometry, MaterialMap, BTreeMap<PathBuf, IndexedMesh>)> {
        let all = materials;
        let materials = Materials::new(self.file.materials.names(), materials);
        let mut builder = Builder::new(&self.file.meshes, &materials, folder, assets, &self.budget);
        builder.preload(self.file.primitives.iter());
        let mut solids = [const { Vec::new() }; 2];
        for (index, primitive) in self.file.primitives.iter().enumerate() {
            let e = self.element(format!("primitives[{index}]"), primitive.name());
            let model = primitive.model();
            let material = model.material().map(|name| materials.find(&e, name)).transpose()?;
            let solids_before = [builder.geometry.spheres.len(), builder.geometry.quads.len()];
            model.expand(&e, &mut builder)?;
            // Instances set the materials of their triangles themselves.
            let Some(material) = material else { continue };
            let geometry = &builder.geometry;
            let has_solids = solids_before != [geometry.spheres.len(), geometry.quads.len()];
            if has_solids && all[material as usize].model().opacity().is_some() {
                return Err(e.error("a material with `opacity` can only be that of triangles"));
            }
            for (list, count) in
                solids.iter_mut().zip([geometry.spheres.len(), geometry.quads.len()])
            {
                list.resize(count, material);
            }
            builder.ranges.cover(geometry.triangles.len(), material);
        }
        let Builder { mut geometry, ranges, mesh_ranges, meshes, .. } = builder;
        geometry.settle();
        let solids = solids.concat();
        let shifted = |ranges: Vec<(u32, u32)>, first: usize| {
            ranges.into_iter().map(move |(end, material)| (first as u32 + end, material))
        };
        let ranges =
            shifted(ranges.0, solids.len()).chain(shifted(mesh_ranges.0, geometry.len())).collect();
        Ok((
            geometry,
            MaterialMap { solids, ranges },
            meshes.into_iter().map(|((file, ..), mesh)| (file, mesh)).collect(),
        ))
    }
}
