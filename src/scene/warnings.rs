//! Reasons why the picture of a valid scene may be black or incomplete.

use super::Scene;
use crate::geometry::Primitive;
use crate::math::length;
use crate::shading::{Camera, Sides};

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
        let emission_rows =
            self.materials().iter().any(|material| material.model().emission_texture().is_some());
        if self.lights() == 0 && !emission_rows && self.background().is_black() {
            let message =
                "the picture will be black: nothing emits light, and the background is black";
            warnings.push(message.to_owned());
        }
        warnings.extend(self.sphere_around(camera).map(|(primitive, material)| {
            format!("the camera is inside primitive {primitive}, an opaque sphere of {material}")
        }));
        warnings
    }

    /// The first opaque sphere that contains the camera when the shutter opens, and its material.
    fn sphere_around(&self, camera: &Camera) -> Option<(u32, &'static str)> {
        (0..self.geometry().spheres.len() as u32).find_map(|primitive| {
            let Primitive::Sphere(sphere) = self.geometry().get(primitive) else { return None };
            let (center, material) = (sphere.center_at(camera.shutter.0), self.material(primitive));
            let inside = length(camera.look_from.as_vec3() - center) < sphere.radius;
            let emits = material.emission().is_some_and(|emission| emission.sides == Sides::Both);
            (inside && !emits && !material.model().transmits())
                .then_some((primitive, material.name()))
        })
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
        for open in ["dielectric(ior: 1.5)", "light(radiance: (1, 1, 1), sides: both)"] {
            assert_eq!(warnings(&format!("({camera}, {sky}, {})", sphere(open))), "", "{open}");
        }
        for name in crate::formats::BUILTIN_NAMES {
            assert_eq!(Scene::load(name).unwrap().warnings(), [""; 0], "{name}");
        }
    }
}
