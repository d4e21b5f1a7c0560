//! A scene around a mesh file: `ptfast render model.obj`.

use std::collections::HashSet;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::assets::Files;
use super::import::ImportOptions;
use super::view::Extent;
use super::{mesh, origin};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::limits::Budget;
use crate::scene::{MeshFile, SceneFile};
use crate::shading::Color;
use crate::shading::material::Lambertian;
use crate::shading::texture::VertexColor;

/// The mesh in `path`, on a ground and under a soft sky, the names of its materials, and files with the mesh, so that
/// it is not read again. If it has no materials, it is grey or in the colours of its vertices. The camera shows all of it
/// from in front, a little to the right and above.
pub(crate) fn of_mesh(
    path: &Path,
    options: &ImportOptions,
    budget: &Budget,
) -> Result<(SceneFile, Vec<String>, Files)> {
    let mut mesh = mesh::read(path, DVec3::ZERO, budget)?;
    let positions = mesh.vertices.positions.iter().copied();
    let origin = origin::of_box(Bounds::of(positions)).unwrap_or_default();
    if origin != DVec3::ZERO {
        drop(mesh);
        mesh = mesh::read(path, origin, budget)?;
    }
    let turned = DVec3::new(origin.x, origin.z, -origin.y);
    let mut extent = Extent::new(options.aspect());
    let positions = mesh.vertices.positions.iter();
    match options.z_up {
        true => extent.add(positions.map(|p| Vec3::new(p.x, p.z, -p.y))),
        false => extent.add(positions.copied()),
    }
    let mut scene = SceneFile::new(extent.camera());
    scene.origin = if options.z_up { turned } else { origin }.to_array();
    if !options.environment {
        extent.add_stage(&mut scene, !options.no_ground);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut shown = MeshFile::new(name, "surface");
    shown.origin = origin.to_array();
    if options.z_up {
        shown.rotation[0] = -90.0;
    }
    if mesh.materials.name_all() {
        shown.material = None;
        scene.add(shown);
        let names = mesh.materials.names.clone();
        return Ok((scene, names, Files::with_mesh(path, origin, mesh)));
    }
    let albedo = if mesh.vertices.colors.is_empty() {
        Color::Rgb([0.5; 3])
    } else {
        scene.add_texture("colors", VertexColor {});
        "colors".into()
    };
    scene.add_material("surface", Lambertian::new(albedo));
    scene.add(shown);
    Ok((scene, Vec::new(), Files::with_mesh(path, origin, mesh)))
}

/// Adds a grey material for each of `names` that `scene` lacks. If there are any, returns a sentence that
/// says so.
pub(crate) fn add_missing_materials(scene: &mut SceneFile, names: Vec<String>) -> Option<String> {
    let known: HashSet<String> = scene.materials.names().map(str::to_owned).collect();
    let missing: Vec<_> = names.into_iter().filter(|name| !known.contains(name)).collect();
    let count = missing.len();
    for name in missing {
        scene.add_material(name, Lambertian::new([0.5; 3]));
    }
    match count {
        0 => None,
        1 => Some("one of its materials is grey, since no file describes it".to_owned()),
        _ => Some(format!("{count} of its materials are grey, since no file describes them")),
    }
}
