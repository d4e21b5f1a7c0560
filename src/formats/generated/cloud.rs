//! `cloud:N`, spheres in a ball.

use super::scene_of;
use crate::math::Stream;
use crate::math::precise::cbrt;
use crate::scene::{Named, SceneFile, SphereFile};
use crate::shading::material::{Dielectric, Fresnel, Lambertian, Material, Metal};

/// Spheres of radius 0.1 to 0.5, distributed uniformly in a ball that grows with their number, so
/// that the density is constant. About four in five of the 64 materials are diffuse.
pub(super) fn scene(count: u32) -> SceneFile {
    let mut random = Stream::new(12_345);
    let radius = 100.0 * cbrt(f64::from(count as f32 / 1e6)) as f32;
    let materials = (0..64).map(|index| {
        let color = [(); 3].map(|()| 0.2 + 0.7 * random.uniform());
        let albedo = color;
        let kind = random.uniform();
        let material: Material = if kind < 0.80 {
            Lambertian::new(albedo).into()
        } else if kind < 0.95 {
            Metal::new(albedo, 0.3 * random.uniform()).into()
        } else {
            Dielectric::new(1.5, Fresnel::Schlick).into()
        };
        (format!("m{index}"), material)
    });
    let materials = Named(materials.collect());
    let mut primitives = Vec::with_capacity(count as usize);
    while primitives.len() < count as usize {
        let [x, y, z] = [(); 3].map(|()| 2.0 * random.uniform() - 1.0);
        if x * x + y * y + z * z >= 1.0 {
            continue;
        }
        let sphere = SphereFile {
            center: [x * radius, y * radius, z * radius],
            radius: 0.1 + 0.4 * random.uniform(),
            material: format!("m{}", random.bits() % 64),
        };
        primitives.push(sphere.into());
    }
    scene_of([0.0, 40.0, 260.0], 45.0, materials, primitives)
}
