//! A scene around a mesh file: `ptfast render model.obj`.

use std::path::Path;

use glam::Vec3;

use super::Background;
use super::budget::Budget;
use super::description::{CameraFile, SceneFile};
use super::material::{Lambertian, Light, Sides};
use super::mesh;
use super::primitive::MeshFile;
use super::texture::{Color, VertexColor};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::math::precise::sin_cos_degrees;
use crate::math::{length, normalize};

/// Vertical field of view in degrees.
const VFOV: f32 = 35.0;

/// The mesh in `path`, grey or in the colours of its vertices, under a soft sky and a lamp. The camera
/// shows all of it from in front, a little to the right and above (y is up).
pub(super) fn of_mesh(path: &Path, budget: &Budget) -> Result<SceneFile> {
    let mesh = mesh::read(path, budget)?;
    let bounds = Bounds::of(mesh.vertices.positions.iter().copied());
    let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    // A sphere around the box fits into the field of view. If the mesh is a single point, a radius
    // of 1 keeps the camera away from it.
    let radius = match length(half) {
        0.0 => 1.0,
        radius => radius,
    };
    let (sin, _) = sin_cos_degrees(f64::from(VFOV) * 0.5);
    let distance = 1.05 * radius / sin as f32;
    let from = center + normalize(Vec3::new(0.5, 0.35, 1.0)) * distance;
    let mut scene = SceneFile::new(CameraFile::new(from.to_array(), center.to_array(), VFOV));
    scene.background = Background::Gradient { bottom: [0.2; 3], top: [0.7, 0.75, 0.8] };
    // A soft lamp on the left, outside the picture, shades faces by their direction.
    scene.add_material("lamp", Light { radiance: [9.0; 3], sides: Sides::Both });
    let lamp = center + normalize(Vec3::new(-0.7, 0.8, 0.6)) * (8.0 * radius);
    scene.add_sphere(lamp.to_array(), 2.4 * radius, "lamp");
    let albedo = if mesh.vertices.colors.is_empty() {
        Color::Rgb([0.5; 3])
    } else {
        scene.add_texture("colors", VertexColor {});
        "colors".into()
    };
    scene.add_material("surface", Lambertian::new(albedo));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    scene.add(MeshFile::new(name, "surface"));
    Ok(scene)
}
