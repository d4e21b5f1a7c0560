//! The files of meshes and instances.

use std::path::Path;

use super::arrays::{read_records, write_floats, write_words};
use crate::error::{Error, Result};
use crate::geometry::{Instance, Instances, PrimitiveModel, Triangle, Triangles};

/// 9 f32 per triangle, mesh after mesh.
pub(super) const MESHES: &str = "meshes.f32";
/// 12 f32 per instance, the rows of its matrix, and the index of its mesh as u32.
pub(super) const INSTANCES: &str = "instances.f32";

/// Writes the files, unless there are no instances.
pub(super) fn write(folder: &Path, instances: &Instances) -> Result<()> {
    if instances.is_empty() {
        return Ok(());
    }
    let triangles = instances.triangles().triangles.iter();
    write_floats(&folder.join(MESHES), triangles.flat_map(|triangle| triangle.record()))?;
    let words = instances.list().iter().flat_map(|instance| {
        let matrix = instance.identity().map(f32::to_bits);
        matrix.into_iter().chain([instance.mesh() as u32])
    });
    write_words(&folder.join(INSTANCES), words)
}

/// Reads `count` instances of meshes with these numbers of triangles.
pub(super) fn read(folder: &Path, meshes: &[usize], count: usize) -> Result<Instances> {
    let mut instances = Instances::default();
    if count == 0 {
        return Ok(instances);
    }
    let bad = |file: &str, index: usize, message: &str| {
        Error::input(folder.join(file).display().to_string(), format!("[{index}]"), message)
    };
    let all = meshes.iter().fold(0, |sum: usize, &mesh| sum.saturating_add(mesh));
    let records = read_records::<9>(folder, MESHES, all)?;
    let mut rest = records.iter().enumerate();
    for &mesh in meshes {
        let mut triangles = Triangles::default();
        for (index, record) in rest.by_ref().take(mesh) {
            if !record.iter().all(|number| number.is_finite()) {
                return Err(bad(MESHES, index, "a coordinate is not finite"));
            }
            let triangle = Triangle::from_record(record);
            triangles.push(triangle.map_err(|message| bad(MESHES, index, message))?);
        }
        instances.add_mesh(triangles);
    }
    for (index, record) in read_records::<13>(folder, INSTANCES, count)?.iter().enumerate() {
        let &[a, b, c, x, d, e, f, y, g, h, i, z, mesh] = record;
        let mesh = mesh.to_bits();
        if mesh as usize >= meshes.len() {
            return Err(bad(INSTANCES, index, &format!("mesh {mesh} does not exist")));
        }
        let instance = Instance::new(mesh, &[[a, b, c, x], [d, e, f, y], [g, h, i, z]]);
        let instance =
            instance.map_err(|message| bad(INSTANCES, index, &format!("the matrix {message}")))?;
        instances.push(instance);
    }
    Ok(instances)
}
