//! Named meshes, and how instances place them.
//!
//! Meshes may contain instances of others. A scene has only two levels, so an instance of such a
//! group becomes one instance for each mesh in it. Triangles that are lights become ordinary
//! triangles wherever they are placed, because each of them is a light of its own.

use std::collections::HashMap;
use std::mem::{replace, take};
use std::rc::Rc;

use glam::{DAffine3, Vec3};

use super::{Builder, Expand, InstanceFile, MeshFile, NamedMesh, PrimitiveFile, Ranges};
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::{Result, suggestion};
use crate::geometry::{Bounds, Instance, Triangles};
use crate::math::affine;
use crate::scene::Named;

/// Largest number of instances around a mesh.
const MAX_NESTING: usize = 64;
/// Bytes of memory for each instance in a group while the list grows. It has 104.
const CHILD: u64 = 208;

/// The named meshes of a scene. Those that no instance places are not read.
pub(super) struct NamedMeshes<'a> {
    meshes: &'a Named<NamedMesh>,
    numbers: HashMap<&'a str, usize>,
    /// The groups read so far, by mesh and by the material that replaces those of the parts.
    known: HashMap<(usize, Option<u32>), Rc<ReadMesh>>,
    /// The meshes that are being read, each a part of the one before.
    open: Vec<usize>,
}

/// A named mesh whose parts have been read.
#[derive(Default)]
struct ReadMesh {
    /// The triangles that do not emit light, as a mesh of the geometry.
    mesh: Option<u32>,
    /// The triangles that emit light, with their material.
    lights: Vec<(Triangles, u32)>,
    /// Instances of other groups.
    children: Vec<(DAffine3, Rc<ReadMesh>)>,
    /// Number of instances, of triangles and of their vertices that one placement adds.
    adds: [u64; 3],
    /// Number of instances around its innermost mesh.
    nesting: usize,
}

/// Triangles that do not emit light, and the ranges of their materials.
#[derive(Default)]
struct Still {
    triangles: Triangles,
    ranges: Ranges,
}

impl<'a> NamedMeshes<'a> {
    pub(super) fn new(meshes: &'a Named<NamedMesh>) -> Self {
        let (known, open) = Default::default();
        Self { meshes, numbers: meshes.names().zip(0..).collect(), known, open }
    }
}

/// Checks that a mesh whose box is `placed` is within the range of coordinates.
fn check_place(e: &Location<'_>, placed: Bounds) -> Result<()> {
    let within = |p: Vec3| p.is_finite() && p.abs().max_element() <= MAX_COORDINATE;
    if placed == Bounds::EMPTY || within(placed.min) && within(placed.max) {
        return Ok(());
    }
    let (from, to) = (placed.min.to_array(), placed.max.to_array());
    let range = "coordinates must be within ±1e9";
    Err(e.error(format!("the mesh is placed at {from:?} to {to:?}, {range}")))
}

impl<'a> Builder<'a> {
    /// Adds an instance and all that it contains.
    pub(super) fn place(&mut self, e: &Location<'_>, file: &InstanceFile) -> Result<()> {
        let map = affine::of_rows(&file.matrix);
        let group = self.group(e, file, None)?;
        let [instances, triangles, vertices] = group.adds;
        self.budget
            .hold_placement(self.count() as u64, instances, triangles, vertices)
            .map_err(|message| e.error(message))?;
        self.put(e, &group, &map, "matrix")
    }

    /// Adds a group placed by `map`, which messages call `name`.
    fn put(
        &mut self,
        e: &Location<'_>,
        group: &ReadMesh,
        map: &DAffine3,
        name: &str,
    ) -> Result<()> {
        let instance = Instance::new(group.mesh.unwrap_or(0), &affine::rows(map))
            .map_err(|message| e.error(format!("{name} {message}")))?;
        if let Some(mesh) = group.mesh {
            let mesh = self.geometry.instances.mesh_bounds(mesh as usize);
            check_place(e, instance.bounds(mesh))?;
            self.geometry.instances.push(instance);
        }
        for (triangles, material) in &group.lights {
            let placed = instance.placed(triangles);
            check_place(e, Bounds::of(placed.iter().flat_map(|triangle| triangle.vertices)))?;
            self.geometry.triangles.append(&placed);
            self.ranges.cover(self.geometry.triangles.len(), *material);
        }
        for (child, group) in &group.children {
            self.put(e, group, &(*map * *child), "the product of nested matrices")?;
        }
        Ok(())
    }

    /// Returns the group that `file` places. `material` replaces the materials of all parts, as
    /// that of `file` does otherwise.
    fn group(
        &mut self,
        e: &Location<'_>,
        file: &InstanceFile,
        material: Option<u32>,
    ) -> Result<Rc<ReadMesh>> {
        let InstanceFile { mesh: name, material: own, .. } = file;
        let own = own.as_ref().map(|own| self.materials.find(e, own)).transpose()?;
        let material = material.or(own);
        let NamedMeshes { meshes, ref numbers, ref known, ref open } = self.groups;
        let Some(&number) = numbers.get(name.as_str()) else {
            let known = suggestion(name, meshes.names());
            return Err(e.error(format!("unknown mesh `{name}`{known}")));
        };
        let too_deep = || e.error(format!("meshes may be nested at most {MAX_NESTING} times"));
        if let Some(group) = known.get(&(number, material)) {
            let all = open.len() + group.nesting;
            return if all < MAX_NESTING { Ok(Rc::clone(group)) } else { Err(too_deep()) };
        }
        if open.contains(&number) {
            return Err(e.error(format!("the mesh `{name}` contains itself")));
        }
        if open.len() == MAX_NESTING {
            return Err(too_deep());
        }
        self.groups.open.push(number);
        let group = match &meshes.0[number].1 {
            NamedMesh::File(path) => {
                let part = [MeshFile { material: None, ..MeshFile::new(path, "") }.into()];
                self.read(e, &part, |_| format!("meshes.{name}"), material)?
            }
            NamedMesh::Parts(parts) => {
                self.read(e, parts, |i| format!("meshes.{name}[{i}]"), material)?
            }
        };
        self.groups.open.pop();
        let group = Rc::new(group);
        self.groups.known.insert((number, material), Rc::clone(&group));
        Ok(group)
    }

    /// Reads the parts of a mesh, whose places in the file are `place`.
    fn read(
        &mut self,
        e: &Location<'_>,
        parts: &[PrimitiveFile],
        place: impl Fn(usize) -> String,
        material: Option<u32>,
    ) -> Result<ReadMesh> {
        let mut group = ReadMesh::default();
        let mut still = Still::default();
        let [mut instances, mut triangles, mut vertices] = [0u64; 3];
        for (i, part) in parts.iter().enumerate() {
            let e = Location { file: e.file, place: place(i), kind: part.name() };
            match part {
                PrimitiveFile::Instance(file) => {
                    Instance::new(0, &file.matrix)
                        .map_err(|message| e.error(format!("matrix {message}")))?;
                    let child = self.group(&e, file, material)?;
                    instances = instances.saturating_add(child.adds[0]);
                    triangles = triangles.saturating_add(child.adds[1]);
                    vertices = vertices.saturating_add(child.adds[2]);
                    // Placing what adds nothing could take forever: 10 in 10 in 10, 64 times.
                    if child.adds != [0; 3] {
                        self.budget.hold(CHILD).map_err(|message| e.error(message))?;
                        group.nesting = group.nesting.max(child.nesting + 1);
                        group.children.push((affine::of_rows(&file.matrix), child));
                    }
                }
                PrimitiveFile::Triangles(_) | PrimitiveFile::Mesh(_) => {
                    let (list, materials) = self.part(&e, part, material)?;
                    self.sort(list, materials, &mut group.lights, &mut still)
                        .map_err(|message| e.error(message))?;
                }
                _ => {
                    let message = "a mesh consists of `triangles`, `mesh` and `instance` only";
                    return Err(e.error(message));
                }
            }
        }
        for (list, _) in &group.lights {
            triangles = triangles.saturating_add(list.len() as u64);
            vertices = vertices.saturating_add(list.vertex_count() as u64 * list.tables() as u64);
        }
        if !still.triangles.is_empty() {
            instances = instances.saturating_add(1);
            let before = self.geometry.instances.triangle_count();
            group.mesh = Some(self.geometry.instances.add_mesh(still.triangles));
            for (end, material) in still.ranges.0 {
                self.mesh_ranges.cover(before + end as usize, material);
            }
        }
        group.adds = [instances, triangles, vertices];
        Ok(group)
    }

    /// Adds triangles, with the ranges of their materials, to `lights` if they emit light, and to `still`
    /// if not.
    fn sort(
        &self,
        mut list: Triangles,
        materials: Vec<(u32, u32)>,
        lights: &mut Vec<(Triangles, u32)>,
        still: &mut Still,
    ) -> Result<(), String> {
        let mut is_still = Vec::with_capacity(list.len());
        let mut count = still.triangles.len();
        for (end, material) in materials {
            let range = is_still.len()..end as usize;
            let emits = self.materials.emits[material as usize];
            if emits && range == (0..list.len()) && !list.is_empty() {
                lights.push((list, material));
                return Ok(());
            }
            is_still.resize(range.end, !emits);
            if !emits {
                count += range.len();
                still.ranges.cover(count, material);
            } else if !range.is_empty() {
                // A copy, because the others keep all vertices.
                let vertices = list.vertex_count().min(3 * range.len());
                self.budget.hold_vertices(vertices * list.tables())?;
                lights.push((list.select(range), material));
            }
        }
        list.retain(&is_still);
        if !list.is_empty() {
            still.triangles.append(&list);
        }
        Ok(())
    }

    /// Reads a part that consists of triangles. Returns them with the ranges of their materials.
    fn part(
        &mut self,
        e: &Location<'_>,
        part: &PrimitiveFile,
        material: Option<u32>,
    ) -> Result<(Triangles, Vec<(u32, u32)>)> {
        let own = part.model().material().map(|own| self.materials.find(e, own)).transpose()?;
        let before = self.geometry.triangles.mark();
        let ranges = take(&mut self.ranges);
        // If another material replaces those of the file, their names need not exist.
        match part {
            PrimitiveFile::Mesh(file) if own.is_none() && material.is_some() => {
                MeshFile { material: Some(String::new()), ..file.clone() }.expand(e, self)?;
            }
            _ => part.model().expand(e, self)?,
        }
        let Ranges(read) = replace(&mut self.ranges, ranges);
        let list = self.geometry.triangles.split_off(before);
        let materials = match material.or(own) {
            Some(material) => vec![(list.len() as u32, material)],
            None => read.into_iter().map(|(end, of)| (end - before.triangles(), of)).collect(),
        };
        Ok((list, materials))
    }
}
