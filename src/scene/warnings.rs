//! Reasons why the picture of a valid scene may be black or incomplete.

use glam::Vec3;

use super::Scene;
use crate::geometry::{Bounds, Primitive};
use crate::math::length;
use crate::shading::light::LightFile;
use crate::shading::{Camera, Material, Sides};

/// Above this radius, the next number of f32 is more than 1 larger.
const MAX_RADIUS: f32 = 16_777_216.0;

impl Scene {
    /// Returns the reasons why the picture may be black, and the data in the scene's files that
    /// ptfast ignores, one line each.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings_with(self.camera())
    }

    /// [`Scene::warnings`] for another camera.
    pub(crate) fn warnings_with(&self, camera: &Camera) -> Vec<String> {
        let mut warnings = self.0.ignored.clone();
        if self.geometry().is_empty() {
            warnings.push("the scene has no primitives".to_owned());
        }
        // Meshes that instances place are no lights, but may emit light that varies.
        let varied = |material: &Material| material.model().varied_emission().is_some();
        let glows = self.materials().iter().any(varied);
        if self.lights() == 0 && !glows && self.background().is_black() {
            let message =
                "the picture will be black: nothing emits light, and the background is black";
            warnings.push(message.to_owned());
        }
        warnings.extend(self.sphere_around(camera).map(|(primitive, material)| {
            format!("the camera is inside primitive {primitive}, an opaque sphere of {material}")
        }));
        let spheres = &self.geometry().spheres;
        let large = spheres.iter().position(|sphere| sphere.radius > MAX_RADIUS);
        warnings.extend(large.map(|primitive| {
            let radius = spheres[primitive].radius;
            format!(
                "primitive {primitive} is a sphere of radius {radius}: above {MAX_RADIUS}, the numbers of f32 are too \
                 coarse for it, and its picture may be wrong; a plane or a smaller scale can replace it"
            )
        }));
        warnings
    }

    /// The first opaque sphere that contains the camera when the shutter opens but no light, and its material.
    fn sphere_around(&self, camera: &Camera) -> Option<(u32, &'static str)> {
        (0..self.geometry().spheres.len() as u32).find_map(|primitive| {
            let Primitive::Sphere(sphere) = self.geometry().get(primitive) else { return None };
            let (center, material) = (sphere.center_at(camera.shutter.0), self.material(primitive));
            let inside = length(camera.look_from.as_vec3() - center) < sphere.radius;
            let dark = || !self.has_light_in(primitive, center, sphere.radius);
            (inside && !material.model().transmits() && dark())
                .then_some((primitive, material.name()))
        })
    }

    /// Whether light may be inside a sphere: its own, that of another surface, or that of a point.
    fn has_light_in(&self, own: u32, center: Vec3, radius: f32) -> bool {
        let emits_inward = |material: &Material| {
            let constant = material.emission().map(|emission| emission.sides);
            let sides = constant.or(material.model().varied_emission().map(|(_, sides)| sides));
            material.emits() && sides == Some(Sides::Both)
        };
        let reaches = |bounds: Bounds| {
            let nearest = center.clamp(bounds.min, bounds.max);
            length(nearest - center) < radius
        };
        let has_surface_in = |primitive: u32| match self.geometry().get(primitive) {
            Primitive::Sphere(other) => {
                (length(other.center - center) - other.radius).abs() < radius
            }
            primitive => reaches(primitive.bounds()),
        };
        let glows = |primitive: u32| self.material(primitive).emits() && has_surface_in(primitive);
        let instanced = || {
            !self.geometry().instances.is_empty() && self.materials().iter().any(Material::emits)
        };
        let lamp = |light: &LightFile| light.emits() && light.place().is_some_and(reaches);
        emits_inward(self.material(own))
            || self.world().lights.iter().any(lamp)
            || instanced()
            || (0..self.geometry().len() as u32).any(|other| other != own && glows(other))
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    #[test]
    fn black_pictures_are_explained() {
        let warnings = |text: &str| Scene::from_ron(text).unwrap().warnings().join("; ");
        let camera = "camera: (look_from: (0, 0, 0), look_at: (0, 0, 1), vfov: 40)";
        let sky = "background: constant(radiance: (1, 1, 1))";
        let sphere = |material: &str| {
            format!(
                "materials: {{\"m\": {material}}}, primitives: [sphere(center: (0, 0, 0), radius: 1, material: \"m\")]"
            )
        };
        assert!(warnings(&format!("({camera}, {sky})")).contains("no primitives"));
        let grey = sphere("lambertian(albedo: (1, 1, 1))");
        assert!(warnings(&format!("({camera}, {grey})")).contains("nothing emits light"));
        let emissive = sphere("principled(emission: \"g\")");
        let textures = "textures: {\"g\": solid(color: (1, 1, 1))}";
        assert_eq!(warnings(&format!("({camera}, {textures}, {emissive})")), "");
        assert!(warnings(&format!("({camera}, {sky}, {grey})")).contains("inside primitive 0"));
        for open in [
            "dielectric(ior: 1.5)",
            "light(radiance: (1, 1, 1), sides: both)",
            "principled(base_color: (0, 0, 0), emission: (1, 1, 1))",
        ] {
            assert_eq!(warnings(&format!("({camera}, {sky}, {})", sphere(open))), "", "{open}");
        }
        let lamps = "lights: [point(position: (0.5, 0, 0), intensity: (1, 1, 1))]";
        assert_eq!(warnings(&format!("({camera}, {sky}, {lamps}, {grey})")), "");
        let outside = lamps.replace("0.5", "1.5");
        assert!(warnings(&format!("({camera}, {sky}, {outside}, {grey})")).contains("inside"));
        let two = |x: f32| {
            let lamp = "sphere(center: (X, 0, 0), radius: 0.4, material: \"l\")]";
            grey.replace("}, primitives", ", \"l\": light(radiance: (1, 1, 1))}, primitives")
                .replace(']', &format!(", {}", lamp.replace('X', &x.to_string())))
        };
        assert_eq!(warnings(&format!("({camera}, {sky}, {})", two(0.5))), "");
        assert!(warnings(&format!("({camera}, {sky}, {})", two(1.5))).contains("inside"));
        let planet = sphere("dielectric(ior: 1.5)").replace("radius: 1", "radius: 2e7");
        assert!(warnings(&format!("({camera}, {sky}, {planet})")).contains("radius 20000000"));
        for name in crate::formats::BUILTIN_NAMES {
            assert_eq!(Scene::load(name).unwrap().warnings(), [""; 0], "{name}");
        }
    }
}
