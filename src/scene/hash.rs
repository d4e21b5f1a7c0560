//! The identity of a scene: a hash over what it is, not how its file says it.

use glam::Vec3;

use super::texture::Texture;
use super::{Background, Camera, Fresnel, Material, Medium, Scene};
use crate::geometry::{Primitive, Volume};

/// BLAKE3 over camera, background and, primitive by primitive, shape and looks.
pub(super) fn hash(scene: &Scene, camera: &Camera) -> String {
    let mut hasher = Hasher(blake3::Hasher::new());
    hasher.text(&format!("{camera:?}"));
    match *scene.background() {
        Background::Constant(radiance) => hasher.vectors(0, &[radiance]),
        Background::Gradient { bottom, top } => hasher.vectors(1, &[bottom, top]),
    }
    for primitive in 0..scene.geometry().len() as u32 {
        match scene.geometry().get(primitive) {
            Primitive::Sphere(s) => {
                hasher.vectors(2, &[s.center, s.motion(), Vec3::splat(s.radius)])
            }
            Primitive::Quad(q) => hasher.vectors(3, &[q.q, q.u, q.v]),
            Primitive::Triangle(t) => hasher.vectors(4, &t.vertices),
        }
        let texture = |index: u32| &scene.textures()[index as usize];
        match scene.material(primitive) {
            Material::Diffuse { albedo } => hasher.texture(5, 0.0, texture(*albedo)),
            Material::Lambertian { albedo } => hasher.texture(6, 0.0, texture(*albedo)),
            Material::Metal { albedo, fuzz } => hasher.texture(7, *fuzz, texture(*albedo)),
            Material::Dielectric { ior, fresnel: Fresnel::Schlick } => {
                hasher.vectors(8, &[Vec3::splat(*ior)]);
            }
            Material::Dielectric { ior, fresnel: Fresnel::Exact } => {
                hasher.vectors(11, &[Vec3::splat(*ior)]);
            }
            Material::RoughDielectric { ior, alpha } => {
                hasher.vectors(12, &[Vec3::new(*ior, *alpha, 0.0)]);
            }
            Material::Conductor { eta, k, alpha } => {
                hasher.vectors(13, &[*eta, *k, Vec3::splat(*alpha)]);
            }
            Material::Light(light) => {
                hasher.vectors(9 + light.sides as u8, &[light.radiance]);
            }
        }
    }
    for Medium { volume, density, albedo } in scene.media() {
        match *volume {
            Volume::Sphere { center, radius } => {
                hasher.vectors(14, &[center, Vec3::new(radius, *density, 0.0), *albedo]);
            }
            Volume::Box { center, axes: [x, y, z], half } => {
                hasher.vectors(15, &[center, x, y, z, half, Vec3::splat(*density), *albedo]);
            }
        }
    }
    hasher.0.finalize().to_hex().to_string()
}

struct Hasher(blake3::Hasher);

impl Hasher {
    /// Vectors behind a byte that says what they are.
    fn vectors(&mut self, what: u8, vectors: &[Vec3]) {
        self.0.update(&[what]);
        for value in vectors.iter().flat_map(Vec3::to_array) {
            // −0 and 0 are the same number.
            self.0.update(&(value + 0.0).to_le_bytes());
        }
    }

    fn texture(&mut self, what: u8, fuzz: f32, texture: &Texture) {
        match texture {
            Texture::Solid(color) => self.vectors(what, &[Vec3::splat(fuzz), *color]),
            Texture::Checker(checker) => self.vectors(
                what + 16,
                &[Vec3::splat(fuzz), checker.odd, checker.even, Vec3::splat(checker.frequency)],
            ),
            Texture::Image(image) => {
                self.vectors(what + 32, &[Vec3::splat(fuzz)]);
                self.text(&image.hash());
            }
        }
    }

    fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
    }
}
