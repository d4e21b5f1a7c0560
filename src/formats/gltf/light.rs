//! Lights of glTF files (KHR_lights_punctual). Their photometric units count as ours, unless the options say
//! otherwise: an intensity of 1 candela is 1.

use glam::{DAffine3, DVec3};

use super::Reader;
use super::file::Light;
use crate::formats::import::LightUnits;
use crate::math::affine;
use crate::shading::light::{Distant, Falloff, Point, Spot};

/// By which Blender multiplies the power of lamps.
const LUMENS_PER_WATT: f64 = 683.0;

impl Reader<'_, '_, '_> {
    /// Adds a light, which shines along the −z-axis of its node.
    pub(crate) fn light(&mut self, light: &Light, map: &DAffine3) {
        let generator = self.gltf.document.asset.generator.as_deref().unwrap_or_default();
        let intensity = match self.import.options.light_units {
            LightUnits::Blender => light.intensity / LUMENS_PER_WATT,
            LightUnits::File => {
                self.import.maybe_blender |= generator.contains("Blender");
                light.intensity
            }
        };
        let color = light.color.map(|c| (c * intensity).clamp(0.0, 1e30) as f32);
        let rounded = |v: DVec3| v.as_vec3().to_array();
        let (position, forward) = (rounded(map.translation), -(map.matrix3 * DVec3::Z));
        match &*light.kind {
            "directional" => {
                let direction = rounded(forward);
                self.scene.lights.push(Distant { direction, irradiance: color, angle: 0.0 }.into());
            }
            "point" => self.scene.lights.push(Point { position, intensity: color }.into()),
            "spot" => {
                let outer =
                    light.spot.outer_cone_angle.map_or(45.0, f64::to_degrees).clamp(0.1, 180.0);
                let inner = light.spot.inner_cone_angle.to_degrees().clamp(0.0, 0.999 * outer);
                let look_at = affine::point_along(map.translation, forward);
                let (outer, inner) = (outer as f32, inner as f32);
                let falloff = Falloff::Square;
                let spot = Spot { position, look_at, intensity: color, outer, inner, falloff };
                self.scene.lights.push(spot.into());
            }
            kind => self
                .import
                .warn(format!("lights of the type {kind} are not supported, so they are left out")),
        }
    }
}
