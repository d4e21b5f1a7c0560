//! A scene around a mesh file: `ptfast render model.obj`.

use std::collections::HashSet;
use std::path::Path;

use glam::Vec3;

use super::mesh;
use crate::error::Result;
use crate::geometry::Bounds;
use crate::limits::Budget;
use crate::math::precise::sin_cos_degrees;
use crate::math::{length, normalize};
use crate::scene::{MeshFile, SceneFile};
use crate::shading::material::{Lambertian, Light, Sides};
use crate::shading::texture::VertexColor;
use crate::shading::{Background, CameraFile, Color};

/// Vertical field of view in degrees.
const VFOV: f32 = 35.0;

/// The centre and the radius of a sphere around a box.
fn sphere_around(bounds: Bounds) -> (Vec3, f32) {
    let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    // If the box is a single point, a radius of 1 keeps the camera away from it.
    let radius = match length(half) {
        0.0 => 1.0,
        radius => radius,
    };
    (center, radius)
}

/// A camera that shows all of a box from in front, a little to the right and above.
pub(crate) fn camera_around(bounds: Bounds) -> CameraFile {
    let (center, radius) = sphere_around(bounds);
    // The sphere fits into the field of view.
    let (sin, _) = sin_cos_degrees(f64::from(VFOV) * 0.5);
    let distance = 1.05 * radius / sin as f32;
    let from = center + normalize(Vec3::new(0.5, 0.35, 1.0)) * distance;
    CameraFile::new(from.to_array(), center.to_array(), VFOV)
}

/// The mesh in `path`, under a soft sky and a lamp, and the names of its materials. If it has none, it is
/// grey or in the colours of its vertices. The camera shows all of it from in front, a little to the
/// right and above (y is up).
pub(crate) fn of_mesh(path: &Path, budget: &Budget) -> Result<(SceneFile, Vec<String>)> {
    let mesh = mesh::read(path, budget)?;
    let bounds = Bounds::of(mesh.vertices.positions.iter().copied());
    let (center, radius) = sphere_around(bounds);
    let mut scene = SceneFile::new(camera_around(bounds));
    scene.background = Background::Gradient { bottom: [0.2; 3], top: [0.7, 0.75, 0.8] };
    // A soft lamp on the left, outside the picture, shades faces by their direction.
    // Its name must differ from those of the mesh.
    scene.add_material("lamp of the view", Light { radiance: [9.0; 3], sides: Sides::Both });
    let lamp = center + normalize(Vec3::new(-0.7, 0.8, 0.6)) * (8.0 * radius);
    scene.add_sphere(lamp.to_array(), 2.4 * radius, "lamp of the view");
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut shown = MeshFile::new(name, "surface");
    if mesh.materials.name_all() {
        shown.material = None;
        scene.add(shown);
        return Ok((scene, mesh.materials.names));
    }
    let albedo = if mesh.vertices.colors.is_empty() {
        Color::Rgb([0.5; 3])
    } else {
        scene.add_texture("colors", VertexColor {});
        "colors".into()
    };
    scene.add_material("surface", Lambertian::new(albedo));
    scene.add(shown);
    Ok((scene, Vec::new()))
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
