//! The radiance of light samples, which may vary over a light.

use glam::Vec3;

use super::glow::GlowPoint;
use super::light::Chosen;
use super::material::{MaterialModel, MaterialTable, MaterialVisitor};
use super::{Key, Looks, SceneTables};
use crate::geometry::{Hit, Ray, Shape};
use crate::math::{Mask, Real, Row, Vector};

/// Returns the row of the light that a primitive of this shape emits.
struct RowOf<'a>(&'a Looks, Shape, u32);

impl MaterialVisitor for RowOf<'_> {
    type Output = Row;

    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Row {
        let Self(looks, shape, primitive) = self;
        table.emission_rows[looks.entries::<f32>(shape, primitive, table.entries.len()) as usize]
    }
}

impl SceneTables {
    /// Returns the radiance of sampled lights on the side that is seen. It is `constant` where it does not vary.
    /// The light samples have these rays and distances.
    #[inline(always)]
    pub(crate) fn radiance_of_sample<R: Real>(
        &self,
        light: &Chosen<'_, R>,
        (constant, front): (R::Vec3, R::Mask),
        ray: &Ray<R>,
        distance: R,
    ) -> R::Vec3 {
        let varied = light.varies() & !light.is_dark(front);
        if !varied.any() {
            return constant;
        }
        self.varied_radiance(light.primitive(), varied, constant, ray, distance)
    }

    #[inline(never)]
    fn varied_radiance<R: Real>(
        &self,
        primitive: R::Word,
        varied: R::Mask,
        constant: R::Vec3,
        ray: &Ray<R>,
        distance: R,
    ) -> R::Vec3 {
        let Ray { origin: o, direction: d, time } = *ray;
        let flag = varied.select(R::ONE, R::ZERO);
        let numbers = [o[0], o[1], o[2], d[0], d[1], d[2], time, distance, flag];
        let [r, g, b] = R::each_lane(primitive, numbers, |primitive, numbers| {
            let [ox, oy, oz, dx, dy, dz, time, t, flag] = numbers;
            if flag == 0.0 {
                return [0.0; 3];
            }
            let key = self.looks.keys()[usize::from(self.looks.key(primitive))];
            let Key::Surface { shape, kind, .. } = key else { return [0.0; 3] };
            let row = self.materials.visit(kind, RowOf(&self.looks, shape, primitive));
            let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
            let ray = Ray { origin, direction, time };
            let point = GlowPoint::new(&self.surfaces, shape, ray, Hit::of(primitive, t));
            point.radiance(&self.textures, row).to_array()
        });
        varied.select(R::Vec3::new(r, g, b), constant)
    }
}
