//! Triangle meshes that are read from files.

use std::borrow::Cow;
use std::path::PathBuf;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Builder, Expand, MeshKey, PrimitiveFile};
use crate::checks::{Location, MAX_COORDINATE, MAX_ORIGIN};
use crate::error::{Error, Result};
use crate::geometry::Instance;
use crate::input::{length, path_within};
use crate::math::affine;
use crate::scene::{Smooth, Transform, Transformed};

/// The triangles of an OBJ or PLY file, or a list of triangles in a glTF or pbrt file.
///
/// Positions, normals, texture coordinates, colours and faces are read, of lists also tangents. Polygons become triangles,
/// and triangles without area are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct MeshFile {
    /// Path of the mesh, relative to the scene file. For a list of a glTF or pbrt file, `#` and its number follow,
    /// as `ptfast scenes show` prints them: `helmet.glb#0`.
    pub file: String,
    /// The point of the file that is at the origin, for files in map coordinates. It is subtracted before positions
    /// are rounded and transformed.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub origin: [f64; 3],
    /// Scale factor about the origin, above 0. It is applied before the rotation.
    #[serde(default = "unit")]
    pub scale: f32,
    /// Right-handed rotation in degrees about x, then y, then z, through the origin.
    #[serde(default)]
    pub rotation: [f32; 3],
    /// Translation, applied last.
    #[serde(default)]
    pub translation: [f32; 3],
    /// An affine map of the vertices in three rows, applied last. Each row has three factors and a
    /// coordinate of the translation. If it mirrors the mesh, the front stays outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[[f32; 4]; 3]>,
    /// Whether the triangles are shaded with the interpolated normals of their vertices.
    #[serde(default, skip_serializing_if = "is_auto")]
    pub smooth: Smooth,
    /// Whether shadows on smooth triangles fade out towards the terminator, which hides the edges of
    /// the triangles (Chiang, Li, Burley 2019, "Taming the Shadow Terminator").
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub soft_terminator: bool,
    /// Name of a group of an OBJ file (`g` or `o`), if only its triangles are wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials). Without
    /// it, each triangle has the material whose name the OBJ file gives it (`usemtl`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl MeshFile {
    /// Creates a mesh from `file` without a transform, with the material named `material`.
    pub fn new(file: impl Into<String>, material: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            origin: [0.0; 3],
            scale: unit(),
            rotation: [0.0; 3],
            translation: [0.0; 3],
            matrix: None,
            smooth: Smooth::Auto,
            soft_terminator: true,
            group: None,
            material: Some(material.into()),
        }
    }
}

fn is_zero(origin: &[f64; 3]) -> bool {
    *origin == [0.0; 3]
}

fn unit() -> f32 {
    1.0
}

pub(super) fn yes() -> bool {
    true
}

pub(super) fn is_yes(value: &bool) -> bool {
    *value
}

fn is_auto(smooth: &Smooth) -> bool {
    *smooth == Smooth::Auto
}

/// The bits of a point, by which files of meshes that were read from different origins differ.
fn bits(origin: [f64; 3]) -> [u64; 3] {
    origin.map(f64::to_bits)
}

/// Most bytes of memory for each byte of a mesh file while it is read: a corner of a polygon in a binary PLY
/// file may take one byte, and becomes a triangle.
const READING: u64 = 40;

impl Builder<'_> {
    /// Reads the files of `primitives` on all threads, if there is memory for all at once. Those that
    /// cannot be read are left to `expand`, which knows where the scene names them.
    pub(crate) fn preload<'p>(&mut self, primitives: impl Iterator<Item = &'p PrimitiveFile>) {
        let (folder, assets, budget) = (self.folder, self.assets, self.budget);
        // Files that need another origin are read later.
        let path = |primitive: &PrimitiveFile| match primitive {
            PrimitiveFile::Mesh(mesh)
                if is_zero(&mesh.origin) && numbered(&mesh.file).1.is_none() =>
            {
                path_within(folder, &mesh.file, &budget.limits).ok()
            }
            _ => None,
        };
        let mut paths: Vec<PathBuf> = primitives.filter_map(path).collect();
        paths.sort_unstable();
        paths.dedup();
        // The size of a compressed file says nothing about its content.
        paths.retain(|path| path.extension().is_some_and(|of| !of.eq_ignore_ascii_case("gz")));
        let bytes: u64 = paths.iter().filter_map(|path| length(path).ok()).sum();
        if paths.len() < 2 || READING.saturating_mul(bytes) > budget.room() {
            return;
        }
        let read =
            |path: PathBuf| assets.mesh(&path, DVec3::ZERO, budget).ok().map(|mesh| (path, mesh));
        let meshes: Vec<_> = paths.into_par_iter().filter_map(read).collect();
        for (path, mesh) in meshes {
            if budget.hold(mesh.memory()).is_ok() {
                self.meshes.insert((path, None, bits([0.0; 3])), mesh);
            }
        }
    }

    /// Reads the mesh with this key, unless it is known.
    fn read_mesh(&mut self, e: &Location<'_>, key: &MeshKey, origin: DVec3) -> Result<()> {
        let (path, number, origin_bits) = key;
        if !self.meshes.contains_key(key) {
            let failed = |error: Error| error.of_file(|error| e.error(error));
            let read = match number {
                None => vec![(None, self.assets.mesh(path, origin, self.budget).map_err(failed)?)],
                // All lists, so that the file is read once.
                Some(_) => {
                    let lists = self.assets.lists(path, origin, self.budget).map_err(failed)?;
                    lists.into_iter().map(|(number, list)| (Some(number), list)).collect()
                }
            };
            for (number, mesh) in read {
                self.budget.hold(mesh.memory()).map_err(|message| e.error(message))?;
                self.meshes.insert((path.clone(), number, *origin_bits), mesh);
            }
        }
        if self.meshes.contains_key(key) {
            return Ok(());
        }
        let same = self.meshes.keys().filter(|known| known.0 == *path && known.2 == *origin_bits);
        let (last, path) = (same.filter_map(|known| known.1).max(), path.display());
        Err(e.error(match (number, last) {
            (Some(number), Some(last)) => {
                format!("{path}#{number} is no list of triangles, the last one is {path}#{last}")
            }
            _ => format!("{path} has no triangles"),
        }))
    }
}

/// The path of the file of a mesh, and its number, if the file is a scene of another program. No file of a mesh ends in
/// a number, since it ends in the extension of its format.
fn numbered(file: &str) -> (&str, Option<usize>) {
    match file.rsplit_once('#') {
        Some((path, number))
            if !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()) =>
        {
            (path, Some(number.parse().unwrap_or(usize::MAX)))
        }
        _ => (file, None),
    }
}

impl Expand for MeshFile {
    fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        let &Self { ref file, scale, rotation, translation, smooth, soft_terminator, .. } = self;
        let ok = scale > 0.0 && scale <= MAX_COORDINATE;
        e.check(ok, "scale", "above 0 and at most 1e9", scale)?;
        e.rotation(rotation)?;
        e.point("translation", translation)?;
        let ok = self.origin.iter().all(|c| c.abs() <= MAX_ORIGIN);
        let [x, y, z] = self.origin;
        e.check(ok, "origin", "three numbers in [-1e12, 1e12]", format!("({x}, {y}, {z})"))?;
        let (path, number) = numbered(file);
        let path = e.path_within(to.folder, path, &to.budget.limits)?;
        let before = to.count();
        let key = (path, number, bits(self.origin));
        to.read_mesh(e, &key, self.origin.into())?;
        let mesh = to.meshes.get_mut(&key).expect("it was read above");
        if self.material.is_some() {
            mesh.ignore_materials();
        }
        let named = |message: String| e.error(format!("{file}: {message}"));
        let (mesh, within) = match &self.group {
            None => (Cow::Borrowed(&*mesh), to.budget.clone()),
            Some(group) => {
                to.budget.check(2 * mesh.memory()).map_err(named)?;
                let part = mesh.group(group).map_err(named)?;
                let within = to.budget.with(part.memory());
                (Cow::Owned(part), within)
            }
        };
        to.budget
            .hold_primitives(before, mesh.triangles.len())
            .and_then(|()| to.budget.hold_vertices(mesh.vertices.positions.len()))
            .map_err(|message| e.error(message))?;
        if let Some(matrix) = &self.matrix {
            Instance::new(0, matrix).map_err(|message| e.error(format!("matrix {message}")))?;
        }
        let matrix = self.matrix.as_ref().map(affine::of_rows);
        let transform = Transform { scale, rotation, translation, matrix };
        let placed = mesh.transformed(&transform, smooth, &within);
        let Transformed { vertices, faces, ranges } = placed.map_err(named)?;
        if faces.is_empty() {
            to.meshes.get_mut(&key).expect("it was read above").ignore_all();
            return Ok(());
        }
        let material_of = |name: u32| {
            let Some(name) = mesh.materials.names.get(name as usize) else {
                let what = "has triangles without the name of a material, so add `material`";
                return Err(e.error(format!("{file} {what}")));
            };
            to.materials.find(e, name)
        };
        let ranges = if self.material.is_some() { Vec::new() } else { ranges };
        let mut begin = 0;
        let mut materials: Vec<(u32, u32)> = Vec::new();
        for (end, name) in ranges {
            // All triangles of a range may lack an area. Then its material need not exist.
            if end > begin {
                materials.push((end, material_of(name)?));
            }
            begin = end;
        }
        let before = to.geometry.triangles.len();
        to.triangles(e, vertices, faces, soft_terminator)?;
        for (end, material) in materials {
            to.ranges.cover(before + end as usize, material);
        }
        Ok(())
    }
}
