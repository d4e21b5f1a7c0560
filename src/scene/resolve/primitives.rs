//! Primitives, and which material each has.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::Resolver;
use crate::error::{Result, suggestion};
use crate::geometry::{Geometry, Quad, Sphere, Triangle};
use crate::scene::description::PrimitiveFile;
use crate::scene::looks::MaterialMap;
use crate::scene::mesh::{self, Mesh, Transform};
use crate::scene::place::{Element, MAX_COORDINATE};
use crate::scene::{boxes, files};

impl Resolver<'_> {
    /// The primitives, the material of each in their order, and the files that meshes were read from.
    pub(super) fn primitives(
        &self,
        folder: &Path,
    ) -> Result<(Geometry, MaterialMap, BTreeSet<PathBuf>)> {
        let mut geometry = Geometry::default();
        let mut meshes = HashMap::new();
        let mut solids = [const { Vec::new() }; 2];
        // One past the last triangle, and the material.
        let mut ranges: Vec<(u32, u32)> = Vec::new();
        let names: HashMap<&str, u32> = self.file.materials.names().zip(0..).collect();
        for (index, primitive) in self.file.primitives.iter().enumerate() {
            let (kind, material) = primitive.kind_and_material();
            let e = self.element(self.places.primitive(index), kind);
            let material = *names.get(material).ok_or_else(|| {
                let known = self.file.materials.names();
                e.error(format!("unknown material `{material}`{}", suggestion(material, known)))
            })?;
            self.add(&e, folder, primitive, &mut meshes, &mut geometry)?;
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
        Ok((geometry, MaterialMap { solids, ranges }, meshes.into_keys().collect()))
    }

    /// Checks one primitive and appends what it stands for; `meshes` are those that were read before.
    fn add(
        &self,
        e: &Element<'_>,
        folder: &Path,
        primitive: &PrimitiveFile,
        meshes: &mut HashMap<PathBuf, Mesh>,
        geometry: &mut Geometry,
    ) -> Result<()> {
        let before = geometry.len();
        let room = |more: usize| {
            self.budget.hold_primitives(before, more).map_err(|message| e.error(message))
        };
        let radius_of = |radius: f32| {
            let ok = radius > 0.0 && radius <= MAX_COORDINATE;
            e.check(ok, "radius", "above 0 and at most 1e9", radius).map(|()| radius)
        };
        let quad = |q, u, v| {
            Quad::new(q, u, v).ok_or_else(|| {
                e.error("the edges must span an area, they are zero or (all but) parallel")
            })
        };
        match primitive {
            PrimitiveFile::Sphere { center, radius, .. } => {
                let center = e.point("center", *center)?;
                room(1)?;
                geometry.spheres.push(Sphere::still(center, radius_of(*radius)?));
            }
            PrimitiveFile::MovingSphere { center, center1, radius, .. } => {
                let center = e.point("center", *center)?;
                let center1 = e.point("center1", *center1)?;
                room(1)?;
                geometry.spheres.push(Sphere { center, center1, radius: radius_of(*radius)? });
            }
            PrimitiveFile::Quad { q, u, v, .. } => {
                room(1)?;
                geometry.quads.push(quad(e.point("q", *q)?, e.point("u", *u)?, e.point("v", *v)?)?);
            }
            PrimitiveFile::Box { min, max, rotation, .. } => {
                e.bounds(*min, *max)?;
                e.rotation(*rotation)?;
                room(6)?;
                for (q, u, v) in boxes::faces(*min, *max, *rotation) {
                    geometry.quads.push(quad(q.into(), u.into(), v.into())?);
                }
            }
            PrimitiveFile::Mesh { file, scale, rotation, translation, .. } => {
                let ok = *scale > 0.0 && *scale <= MAX_COORDINATE;
                e.check(ok, "scale", "above 0 and at most 1e9", scale)?;
                e.rotation(*rotation)?;
                e.point("translation", *translation)?;
                let (scale, rotation, translation) = (*scale, *rotation, *translation);
                let path = files::path(e, folder, file, &self.budget.limits)?;
                let mesh = match meshes.entry(path) {
                    Entry::Occupied(there) => there.into_mut(),
                    Entry::Vacant(place) => {
                        let mesh = mesh::read(place.key(), &self.budget);
                        let mesh = mesh.map_err(|error| e.error(error))?;
                        let room = self.budget.hold(mesh.memory());
                        room.map_err(|message| e.error(message))?;
                        place.insert(mesh)
                    }
                };
                room(mesh.triangles.len())?;
                let placed =
                    mesh.transformed(&Transform { scale, rotation, translation }, &self.budget);
                let placed = placed.map_err(|message| e.error(format!("{file}: {message}")))?;
                geometry.triangles.extend(placed);
            }
            PrimitiveFile::Triangles { vertices, indices, .. } => {
                room(indices.len())?;
                for (i, vertex) in vertices.iter().enumerate() {
                    e.point(&format!("vertices[{i}]"), *vertex)?;
                }
                for (i, corner) in indices.iter().enumerate() {
                    let vertex = |k: u32| vertices.get(k as usize).map(|v| Vec3::from_array(*v));
                    let [Some(a), Some(b), Some(c)] = corner.map(vertex) else {
                        return Err(e.error(format!(
                            "indices[{i}] must be below the number of vertices {}, is {corner:?}",
                            vertices.len()
                        )));
                    };
                    let triangle = Triangle { vertices: [a, b, c] };
                    // Meshes have some; they have no normal.
                    if !triangle.is_degenerate() {
                        geometry.triangles.push(triangle);
                    }
                }
            }
        }
        Ok(())
    }
}
