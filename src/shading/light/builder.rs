//! Collects the lights of a scene and prepares their choice.

use glam::{DVec3, Vec3};

use super::alias::AliasTable;
use super::environment::{Environment, EnvironmentMap};
use super::lights::{Choice, FRONT_ONLY, Lights, UNSEEN, VARIES};
use super::tree::{LightBounds, LightTree};
use super::{Entry, LightFile};
use crate::geometry::Primitive;
use crate::math::row;
use crate::shading::emission::{Emission, Sides, luminance};

/// Up to this number of lights, they are chosen by power alone.
const MOST_BY_POWER: usize = 64;

/// Collects the lights of a scene.
#[derive(Default)]
pub(crate) struct LightsBuilder {
    lights: Lights,
    /// The bounds and the power of each light, or `None` for light from outside the scene.
    inside: Vec<Option<LightBounds>>,
}

impl LightsBuilder {
    /// Adds primitive number `number`, which emits light: at all of its points the same, or with this mean.
    pub(crate) fn push(
        &mut self,
        number: u32,
        primitive: Primitive,
        emission: Emission,
        varies: bool,
    ) {
        let Emission { radiance, sides } = emission;
        let (entry, area, normal) = self.lights.tables.push_primitive(primitive);
        let one_sided = if sides == Sides::Front { FRONT_ONLY } else { 0 };
        let varies = if varies { VARIES } else { 0 };
        let faces = if sides == Sides::Both { 2.0 } else { 1.0 };
        let bounds = LightBounds {
            bounds: primitive.bounds(),
            axis: normal.unwrap_or(DVec3::Z),
            cos: if normal.is_some() { 1.0 } else { -1.0 },
            two_sided: sides == Sides::Both,
            power: luminance(radiance) * area * faces,
        };
        self.add(entry, radiance, one_sided | varies, Some(bounds));
        let row = self.lights.rows.last_mut().expect("a row was added");
        row[1][2] = number;
    }

    /// Adds a light that is not a primitive, unless it is black.
    pub(crate) fn push_free(&mut self, light: &LightFile) {
        if !light.emits() {
            return;
        }
        let light = light.model();
        let entry = light.add_to(&mut self.lights.tables);
        self.add(entry, light.radiance(), 0, light.inside());
    }

    /// Adds an environment map, unless it is black.
    pub(crate) fn push_environment(&mut self, map: &EnvironmentMap) {
        if map.is_black() {
            return;
        }
        if let Some(light) = Environment::new(map) {
            self.lights.environment = Some(self.inside.len() as u32);
            let entry = self.lights.tables.push(light);
            self.add(entry, Vec3::splat(map.scale), 0, None);
        }
    }

    /// Adds the row of a light that is in the table of its kind.
    fn add(
        &mut self,
        (kind, index): Entry,
        radiance: Vec3,
        flags: u32,
        inside: Option<LightBounds>,
    ) {
        self.lights.has_varied |= flags & VARIES != 0;
        self.lights.has_unseen |= kind & UNSEEN != 0;
        self.lights.rows.push([row(radiance, f32::from_bits(kind | flags)), [0, index, 0, 0]]);
        // Above 0 even for the dimmest light.
        let power = |power: f64| if power > 1e-300 { power } else { 1e-300 };
        self.inside.push(inside.map(|light| LightBounds { power: power(light.power), ..light }));
    }

    /// Prepares the choice of lights: in proportion to their power, or by a tree if there are many.
    /// Each light from outside, whose power depends on the size of the scene, is as probable as all
    /// others together.
    pub(crate) fn finish(self) -> Lights {
        let Self { mut lights, inside } = self;
        let (count, outside) =
            (inside.iter().flatten().count(), |light: &u32| inside[*light as usize].is_none());
        if inside.len() <= 1 {
            return lights;
        }
        let all: f64 = inside.iter().flatten().map(|light| light.power).sum();
        if count > MOST_BY_POWER {
            // A single-precision number can hold these shares.
            let share = |power: f64| (power / all).max(1e-12);
            let relative =
                |light: &LightBounds| LightBounds { power: share(light.power), ..*light };
            let bounds: Vec<_> = inside.iter().map(|light| light.as_ref().map(relative)).collect();
            let others = (0..inside.len() as u32).filter(outside).collect();
            lights.choice = Choice::Tree(LightTree::new(&bounds), others);
            return lights;
        }
        let weight = |light: &Option<LightBounds>| match light {
            Some(light) => light.power,
            None if count > 0 => all,
            None => 1.0,
        };
        let weights: Vec<f64> = inside.iter().map(weight).collect();
        let table = AliasTable::new(&weights);
        for ([_, chance], index) in lights.rows.iter_mut().zip(0..) {
            chance[0] = (table.share(index) as f32 * (1.0 / 4_294_967_296.0)).to_bits();
        }
        lights.choice = Choice::Power(table);
        lights
    }
}
