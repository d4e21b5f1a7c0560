//! A scene's materials as vectors read them: by kind, with their numbers in tables.

use glam::Vec3;

use crate::geometry::lanes::Shape;
use crate::scene::{Checker, Emission, Fresnel, Material, Scene, Sides, Texture};
use crate::simd::{Quad, quad};

/// Paths that are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bin {
    /// Those that have hit nothing.
    Background,
    /// Those that have collided in a medium.
    Medium,
    /// Those that have hit primitives of one shape and of one kind of materials.
    Surface(Shape, Kind),
}

/// A kind of materials: one routine each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Light,
    Diffuse(Pattern),
    Lambertian(Pattern),
    Metal(Pattern),
    Dielectric(Fresnel),
    RoughDielectric,
    Conductor,
}

/// How the colours of a material vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    Solid,
    Checker,
    Image,
}

/// A scene's materials.
#[derive(Debug)]
pub(super) struct Materials {
    /// Those in the scene, [`Bin::Background`] first.
    pub(super) bins: Vec<Bin>,
    /// The place in `bins` of each primitive, then of each medium; one more for none.
    bin_of: Vec<u8>,
    /// Albedos of the media.
    media: Vec<Quad>,
    /// Of each material: one colour, which is what a light emits or the real part of a conductor's
    /// index, and a number: fuzz, index of refraction, α of a conductor, or 1 for a light that shines
    /// on its front only.
    pub(super) solid: Vec<Quad>,
    /// Of each material: the odd colour and the frequency of a checker, or the imaginary part of a
    /// conductor's index, or α of a rough dielectric; the even colour of a checker.
    pub(super) more: Vec<[Quad; 2]>,
}

impl Materials {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut bins = vec![Bin::Background];
        let mut place = |bin| {
            let place = bins.iter().position(|&b| b == bin).unwrap_or(bins.len());
            if place == bins.len() {
                bins.push(bin);
            }
            place as u8
        };
        let geometry = scene.geometry();
        let surface = |p| Bin::Surface(Shape::of(geometry.get(p)), kind(scene, scene.material(p)));
        let mut bin_of: Vec<u8> =
            (0..geometry.len() as u32).map(|primitive| place(surface(primitive))).collect();
        bin_of.extend(scene.media().iter().map(|_| place(Bin::Medium)));
        bin_of.push(0);
        Self {
            bins,
            bin_of,
            media: scene.media().iter().map(|medium| quad(medium.albedo, 0.0)).collect(),
            solid: scene.materials().iter().map(|m| solid(scene, m)).collect(),
            more: scene.materials().iter().map(|m| more(scene, m)).collect(),
        }
    }

    /// What stands for the first medium where primitives are told.
    pub(super) fn first_medium(&self) -> u32 {
        (self.bin_of.len() - 1 - self.media.len()) as u32
    }

    /// The albedo of the medium that `code` stands for.
    #[inline(always)]
    pub(super) fn medium(&self, code: u32) -> &Quad {
        &self.media[(code - self.first_medium()) as usize]
    }

    /// The place in [`Self::bins`] of what is shaded where a path has hit `primitive`, or none.
    #[inline(always)]
    pub(super) fn bin(&self, primitive: u32) -> u8 {
        self.bin_of[(primitive as usize).min(self.bin_of.len() - 1)]
    }
}

fn kind(scene: &Scene, material: &Material) -> Kind {
    let pattern = |albedo: u32| match scene.textures()[albedo as usize] {
        Texture::Solid(_) => Pattern::Solid,
        Texture::Checker(_) => Pattern::Checker,
        Texture::Image(_) => Pattern::Image,
    };
    match *material {
        Material::Diffuse { albedo } => Kind::Diffuse(pattern(albedo)),
        Material::Lambertian { albedo } => Kind::Lambertian(pattern(albedo)),
        Material::Metal { albedo, .. } => Kind::Metal(pattern(albedo)),
        Material::Dielectric { fresnel, .. } => Kind::Dielectric(fresnel),
        Material::RoughDielectric { .. } => Kind::RoughDielectric,
        Material::Conductor { .. } => Kind::Conductor,
        Material::Light(_) => Kind::Light,
    }
}

/// The texture of a material's albedo, if it has one.
pub(super) fn texture<'a>(scene: &'a Scene, material: &Material) -> Option<&'a Texture> {
    match *material {
        Material::Diffuse { albedo }
        | Material::Lambertian { albedo }
        | Material::Metal { albedo, .. } => Some(&scene.textures()[albedo as usize]),
        Material::Dielectric { .. }
        | Material::RoughDielectric { .. }
        | Material::Conductor { .. }
        | Material::Light(_) => None,
    }
}

fn solid(scene: &Scene, material: &Material) -> Quad {
    let color = match (texture(scene, material), material) {
        (Some(Texture::Solid(color)), _) => *color,
        (_, Material::Light(emission)) => emission.radiance,
        (_, Material::Conductor { eta, .. }) => *eta,
        _ => Vec3::ZERO,
    };
    let number = match *material {
        Material::Metal { fuzz, .. } => fuzz,
        Material::Dielectric { ior, .. } | Material::RoughDielectric { ior, .. } => ior,
        Material::Conductor { alpha, .. } => alpha,
        Material::Light(Emission { sides: Sides::Front, .. }) => 1.0,
        _ => 0.0,
    };
    quad(color, number)
}

fn more(scene: &Scene, material: &Material) -> [Quad; 2] {
    match (texture(scene, material), material) {
        (Some(Texture::Checker(Checker { odd, even, frequency })), _) => {
            [quad(*odd, *frequency), quad(*even, 0.0)]
        }
        (_, Material::Conductor { k, .. }) => [quad(*k, 0.0), [0; 4]],
        (_, Material::RoughDielectric { alpha, .. }) => [quad(Vec3::ZERO, *alpha), [0; 4]],
        _ => [[0; 4]; 2],
    }
}
