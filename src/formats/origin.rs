//! The origin of scenes that are far from that of their file, such as a city in map coordinates.

use std::collections::HashMap;

use glam::DVec3;

use super::view::GROUND;
use crate::geometry::Bounds;
use crate::scene::{NamedMesh, PrimitiveFile, SceneFile};

/// A scene is moved if its centre is more than this many of its sizes from the origin of its file, so that each
/// coordinate gains at least four bits.
const FAR: f64 = 16.0;

/// The point of the file that becomes the origin of a scene in this box; `None` if the scene stays where it is.
/// Its coordinates are multiples of a power of two, so that no difference to it is rounded.
pub(crate) fn of_box(bounds: Bounds) -> Option<DVec3> {
    if bounds == Bounds::EMPTY {
        return None;
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (size, center) = ((max - min).max_element(), (min + max) * 0.5);
    let distance = center.abs().max_element();
    if !distance.is_finite() || distance <= FAR * size {
        return None;
    }
    let mut step = f64::from(f32::MIN_POSITIVE);
    while step < size {
        step *= 2.0;
    }
    let origin = (center / step).round() * step;
    (size > 0.0 && origin != DVec3::ZERO).then_some(origin)
}

/// The sentence, after the name of the file, that says so.
pub(crate) fn note(origin: DVec3) -> String {
    let DVec3 { x, y, z } = origin;
    format!("is far from its origin, so the scene is relative to ({x}, {y}, {z}), with more bits")
}

/// As [`of_box`], for a scene of another program. The ground of the view does not count.
pub(crate) fn of_scene(scene: &SceneFile) -> Option<DVec3> {
    let mut meshes = Meshes::new();
    for (name, mesh) in &scene.meshes.0 {
        let NamedMesh::Parts(parts) = mesh else { continue };
        if let Some(bounds) = union(parts.iter().map(|part| box_of(part, &meshes))) {
            meshes.insert(name, bounds);
        }
    }
    let is_ground = |primitive: &PrimitiveFile| matches!(primitive, PrimitiveFile::Quad(quad) if quad.material == GROUND);
    let shown = scene.primitives.iter().filter(|primitive| !is_ground(primitive));
    of_box(union(shown.map(|primitive| box_of(primitive, &meshes)))?)
}

/// The boxes of named meshes, as far as they are known.
type Meshes<'a> = HashMap<&'a str, Bounds>;

/// The union of boxes, if all are known.
fn union(mut boxes: impl Iterator<Item = Option<Bounds>>) -> Option<Bounds> {
    boxes.try_fold(Bounds::EMPTY, |sum, bounds| Some(sum.union(bounds?)))
}

/// The box of a primitive; `None` if another file contains it.
fn box_of(primitive: &PrimitiveFile, meshes: &Meshes<'_>) -> Option<Bounds> {
    let points = |points: &[[f32; 3]]| Bounds::of(points.iter().map(|&point| point.into()));
    match primitive {
        PrimitiveFile::Triangles(triangles) => Some(points(&triangles.vertices)),
        PrimitiveFile::Sphere(sphere) => {
            Some(points(&[-1.0, 1.0].map(|side| sphere.center.map(|c| c + side * sphere.radius))))
        }
        PrimitiveFile::Quad(quad) => {
            let corner =
                |u: f32, v: f32| [0, 1, 2].map(|i| quad.q[i] + u * quad.u[i] + v * quad.v[i]);
            Some(points(&[corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)]))
        }
        PrimitiveFile::Instance(instance) => {
            let Bounds { min, max } = *meshes.get(&*instance.mesh)?;
            let corner = |i: usize| {
                let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
                instance.matrix.map(|[x, y, z, w]| x * pick(0) + y * pick(1) + z * pick(2) + w)
            };
            Some(points(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner)))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn scenes_that_are_far_are_moved_by_a_multiple_of_a_power_of_two() {
        let around = |center: Vec3, half: f32| Bounds { min: center - half, max: center + half };
        assert_eq!(of_box(Bounds::EMPTY), None);
        assert_eq!(of_box(around(Vec3::ZERO, 0.0)), None);
        assert_eq!(of_box(around(Vec3::new(30.0, 0.0, 0.0), 1.0)), None);
        let origin = of_box(around(Vec3::new(85_000.3, 446_000.0, 5.0), 300.0));
        assert_eq!(origin, Some(DVec3::new(84_992.0, 446_464.0, 0.0)));
    }
}
