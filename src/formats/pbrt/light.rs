//! Lights of pbrt files.

use std::f64::consts::PI;
use std::rc::Rc;

use glam::DVec3;

use super::texture::ValueKey;
use super::{Params, Reader, rounded};
use crate::math::affine;
use crate::math::precise::unit;
use crate::shading::light::{Distant, EnvironmentMap, Falloff, Mapping, Point, Spot};
use crate::shading::material::{Light, Principled};
use crate::shading::{Background, Material, Sides};

/// The directive `AreaLightSource`.
#[derive(Clone, Debug)]
pub(crate) struct AreaLight {
    radiance: [f64; 3],
    two_sided: bool,
    /// The power of each shape, if it decides the radiance.
    pub(crate) power: Option<f64>,
}

/// Everything that determines the material of an area light: radiance, whether both sides emit it, and the number of
/// the material that scatters light, with its alpha.
pub(crate) type LightKey = ([u32; 3], bool, Option<(usize, Option<ValueKey>)>);

/// A surface that scatters light beside emitting it.
pub(crate) struct LitSurface {
    pub(crate) material: Principled,
    pub(crate) key: (usize, Option<ValueKey>),
}

/// Luminance of linear RGB.
fn luminance(rgb: [f64; 3]) -> f64 {
    0.212_639 * rgb[0] + 0.715_169 * rgb[1] + 0.072_192 * rgb[2]
}

fn scaled(rgb: [f64; 3], by: f64) -> [f32; 3] {
    rgb.map(|c| (c * by).clamp(0.0, 1e30) as f32)
}

impl Reader<'_, '_> {
    /// The colour `name` of a light, which is white by default.
    fn light_color(&mut self, params: &Params, name: &str) -> Result<[f64; 3], String> {
        let Some(param) = params.find(name) else { return Ok([1.0; 3]) };
        let color = self.spectrum(param)?;
        // pbrt normalises spectra, but not colours.
        Ok(match param.kind.as_str() {
            "spectrum" => color.map(|c| c / luminance(color).clamp(1e-30, 1e30)),
            _ => color,
        })
    }

    /// The directive `AreaLightSource`.
    pub(crate) fn area_light_source(&mut self, class: &str, params: &Params) -> Result<(), String> {
        if class != "diffuse" && class != "area" {
            self.import.warn(format!(
                "area lights of the class {class} are not supported, so they are diffuse"
            ));
        }
        if params.find("filename").is_some() {
            self.import.warn("images on area lights are not supported, so these are of one colour");
        }
        let (color, scale) = (self.light_color(params, "L")?, scale(params)?);
        let radiance = color.map(|c| c * scale);
        let power = params.number("power")?.filter(|power| *power > 0.0);
        let two_sided = params.flag("twosided")?.unwrap_or(false);
        params.ignore(&["samples", "nsamples"]);
        self.warn_unused(params, "area lights");
        self.state.area_light = Some(Rc::new(AreaLight { radiance, two_sided, power }));
        Ok(())
    }

    /// The name of a material for `light` on a shape of this area, which may also scatter light.
    pub(crate) fn light_material(
        &mut self,
        light: &AreaLight,
        area: f64,
        surface: Option<LitSurface>,
    ) -> String {
        let AreaLight { radiance, two_sided, power } = light;
        let sides = if *two_sided { 2.0 } else { 1.0 };
        let factor = power.map_or(1.0, |power| power / (PI * sides * area));
        let radiance = scaled(*radiance, factor);
        let (material, key) = surface.map(|surface| (surface.material, surface.key)).unzip();
        let key = (radiance.map(f32::to_bits), *two_sided, key);
        if let Some(known) = self.lights.get(&key) {
            return known.clone();
        }
        let name = self.materials.unique("light");
        let sides = if *two_sided { Sides::Both } else { Sides::Front };
        match material {
            None => self.scene.add_material(name.clone(), Light { radiance, sides }),
            Some(material) => {
                let emission = radiance.into();
                let material = Principled { emission, emission_sides: sides, ..material };
                let mut material = Material::from(material);
                // Only triangles may have opacity, too.
                if !material.textures().is_empty() || material.model().opacity().is_some() {
                    self.materials.textured.insert(name.clone());
                }
                self.scene.add_material(name.clone(), material);
            }
        }
        self.lights.insert(key, name.clone());
        name
    }

    /// The directive `LightSource`.
    pub(crate) fn light_source(&mut self, class: &str, params: &Params) -> Result<(), String> {
        let (to_scene, scale) = (self.to_scene(), scale(params)?);
        let point = |name: &str, usual: DVec3| -> Result<DVec3, String> {
            Ok(params.tuple(name)?.map_or(usual, DVec3::from))
        };
        match class {
            "infinite" => self.infinite(params)?,
            "distant" => {
                let radiance = self.light_color(params, "L")?;
                let illuminance = params.number("illuminance")?.filter(|lux| *lux > 0.0);
                let factor = scale * illuminance.unwrap_or(1.0);
                let (from, to) = (point("from", DVec3::ZERO)?, point("to", DVec3::Z)?);
                let direction = rounded(unit(to_scene.transform_vector3(to - from)));
                let irradiance = scaled(radiance, factor);
                self.scene.lights.push(Distant { direction, irradiance, angle: 0.0 }.into());
            }
            "point" | "spot" => {
                let intensity = self.light_color(params, "I")?;
                let power = params.number("power")?.filter(|power| *power > 0.0);
                let from = point("from", DVec3::ZERO)?;
                let from_there = to_scene.transform_point3(from);
                let position = rounded(from_there);
                if class == "point" {
                    let factor = scale * power.map_or(1.0, |power| power / (4.0 * PI));
                    let intensity = scaled(intensity, factor);
                    self.scene.lights.push(Point { position, intensity }.into());
                } else {
                    let axis = to_scene.transform_vector3(point("to", DVec3::Z)? - from);
                    let look_at = affine::point_along(from_there, axis);
                    let outer = params.number("coneangle")?.unwrap_or(30.0);
                    let inner = outer - params.number("conedeltaangle")?.unwrap_or(5.0);
                    let factor = scale * power.map_or(1.0, |power| power / cone(inner, outer));
                    let intensity = scaled(intensity, factor);
                    let outer = outer.clamp(0.01, 180.0);
                    let (inner, outer) = (inner.clamp(0.0, 0.999 * outer) as f32, outer as f32);
                    let falloff = Falloff::Smooth;
                    let spot = Spot { position, look_at, intensity, outer, inner, falloff };
                    self.scene.lights.push(spot.into());
                }
            }
            _ => {
                self.import.warn(format!(
                    "lights of the class {class} are not supported, so they are left out"
                ));
            }
        }
        params.ignore(&["samples", "nsamples"]);
        self.warn_unused(params, &format!("{class} lights"));
        Ok(())
    }

    fn infinite(&mut self, params: &Params) -> Result<(), String> {
        if self.has_background {
            self.import.warn("several infinite lights are not supported, so the first is used");
            params.ignore(&["L", "scale", "filename", "illuminance", "portal"]);
            return Ok(());
        }
        if params.find("portal").is_some() {
            self.import.warn("portals are not supported, so light is sampled without them");
        }
        let (radiance, scale) = (self.light_color(params, "L")?, scale(params)?);
        let illuminance = params.number("illuminance")?.filter(|lux| *lux > 0.0);
        let file = params.text("filename")?.map(str::to_owned);
        let file =
            file.filter(|file| self.import.is_usable(file, "so the background is of one colour"));
        self.has_background = true;
        let Some(file) = file else {
            let factor = scale * illuminance.map_or(1.0, |lux| lux / PI);
            self.scene.background = Background::Constant { radiance: scaled(radiance, factor) };
            return Ok(());
        };
        if illuminance.is_some() {
            self.import.warn("the illuminance of environment maps is not supported, so they are as bright as their image");
        }
        let mut map = EnvironmentMap::from_file(file);
        map.mapping = Mapping::EqualArea;
        map.scale = scale.clamp(0.0, 1e30) as f32;
        let columns = self.state.transform.matrix3;
        let columns = [columns.x_axis, columns.y_axis, columns.z_axis].map(unit);
        map.matrix = Some([0, 1, 2].map(|i| columns.map(|column| column[i] as f32)));
        self.scene.background = Background::Image(map);
        Ok(())
    }
}

/// The factor of a light.
fn scale(params: &Params) -> Result<f64, String> {
    Ok(params.number("scale")?.unwrap_or(1.0))
}

/// The solid angle of a spot's cone, weighted by its intensity: that of the middle between the inner
/// and the outer cone.
fn cone(inner: f64, outer: f64) -> f64 {
    let [inner, outer] = [inner, outer].map(crate::math::precise::one_minus_cos);
    PI * (inner + outer)
}
