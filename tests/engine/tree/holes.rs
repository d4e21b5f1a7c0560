//! Triangles with holes, in scenes with and without instances.

use std::any::Any;
use std::sync::Arc;

use glam::Vec3;
use ptfast::internals::{Geometry, HoleTest, Holes, Ray, Stream, Triangles};

use super::check::{RAYS, check_kernels};
use super::instances::{Kind, instanced};
use super::rays::{Bundles, adversarial, soup};

/// Half of the points of triangles are holes, in a pattern that depends on all arguments.
#[derive(Debug)]
struct Pattern;

impl HoleTest for Pattern {
    fn is_hole(
        &self,
        triangles: &Triangles,
        triangle: u32,
        instance: u32,
        ray: &Ray,
        t: f32,
    ) -> bool {
        let [a, ..] = triangles.vertices(triangle as usize);
        let distance = (ray.origin + ray.direction * t - a).length_squared();
        let bits = distance.to_bits() >> 20 ^ ray.direction.x.to_bits() >> 13;
        (bits ^ triangle ^ instance) & 1 == 1
    }

    fn equals(&self, other: &dyn HoleTest) -> bool {
        (other as &dyn Any).is::<Self>()
    }
}

/// Two of three triangles of the geometry may have holes.
fn cut(mut geometry: Geometry) -> Geometry {
    let holes = |count| Holes::new(count, |triangle| triangle % 3 > 0, Arc::new(Pattern));
    geometry.holes = holes(geometry.triangles.len());
    geometry.instances.set_holes(holes(geometry.instances.triangle_count()));
    geometry
}

#[test]
fn kernels_agree_with_brute_force_on_triangles_with_holes() {
    let plain = |seed, count| {
        let geometry = soup(seed, count, 1.0, Vec3::ZERO);
        (geometry.clone(), geometry)
    };
    for (name, (geometry, placed)) in [
        ("few", plain(31, 12)),
        ("many", plain(32, 400)),
        ("instances", instanced(33, Kind::Rigid, 1.0, Vec3::ZERO)),
        ("sheared instances", instanced(34, Kind::Sheared, 1.0, Vec3::ZERO)),
    ] {
        let (solid, geometry) = (geometry.clone(), cut(geometry));
        let mut random = Stream::new(97);
        let make = |i| adversarial(&mut random, i, &placed, 1.0, Vec3::ZERO);
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels(name, &geometry, RAYS / 8, make, oracle);
        let mut bundles = Bundles::new(96, &placed, 1.0, Vec3::ZERO);
        let mut differ = 0;
        let rays: Vec<_> = (0..2000).map(|i| bundles.next(i)).collect();
        for (ray, t_max) in &rays {
            let hit = |geometry: &Geometry| geometry.closest_by_brute_force(ray, 0.0, *t_max);
            differ += u32::from(hit(&solid) != hit(&geometry));
        }
        assert!(differ > 30, "{name}: only {differ} rays meet holes");
        check_kernels(name, &geometry, RAYS / 8, |i| bundles.next(i), oracle);
    }
}
