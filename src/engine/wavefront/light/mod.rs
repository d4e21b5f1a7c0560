//! Sampling lights from points, over lanes: what the scalar engine finds, to the bit.

mod quad;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod table;
mod triangle;

use crate::geometry::lanes::Shape;
use crate::simd::{Float, Int, Lanes, Mask, Vec3x};
pub(super) use table::LightTable;

/// A light a lane.
#[derive(Clone, Copy)]
pub(super) struct Chosen<'a> {
    table: &'a LightTable,
    lights: Lanes<u32>,
    /// The light, where it is the same in all lanes.
    same: Option<u32>,
}

/// A direction to a light a lane.
#[derive(Clone, Copy)]
pub(super) struct LightSamples {
    /// Of unit length.
    pub(super) direction: Vec3x,
    /// How far the light is.
    pub(super) distance: Float,
    /// Density of the direction per unit solid angle.
    pub(super) pdf: Float,
    /// Whether the direction meets the light's front.
    pub(super) front: Mask,
    /// Whether the light can be seen at all; where it cannot, the rest means nothing.
    pub(super) visible: Mask,
}

impl Chosen<'_> {
    /// Samples of the lights as seen from `from`.
    #[inline(always)]
    pub(super) fn sample(&self, from: Vec3x, time: Float, numbers: (Float, Float)) -> LightSamples {
        let mut found = LightSamples {
            direction: from,
            distance: Float::ZERO,
            pdf: Float::ZERO,
            front: Mask::NONE,
            visible: Mask::NONE,
        };
        let (lights, ends) = (Int::new(self.lights), self.table.ends);
        // Lights are in the order of primitives.
        let below = |end: u32| (lights + Int::splat(1)).le(Int::splat(end));
        let (spheres, quads) = (below(ends.spheres), below(ends.quads) & !below(ends.spheres));
        if spheres.any() {
            found = found.unless(spheres, sphere::sample(self, from, time, numbers));
        }
        if quads.any() {
            found = found.unless(quads, quad::sample(self, from, numbers));
        }
        let triangles = !below(ends.quads);
        if triangles.any() {
            found = found.unless(triangles, triangle::sample(self, from, numbers));
        }
        found
    }

    /// Density with which [`Self::sample`] at `origin` draws `direction`, which meets the lights, all of
    /// this shape, at distance `t`.
    #[inline(always)]
    pub(super) fn pdf(
        &self,
        shape: Shape,
        (origin, direction): (Vec3x, Vec3x),
        time: Float,
        t: Float,
    ) -> Float {
        match shape {
            Shape::Sphere | Shape::MovingSphere => sphere::pdf(self, origin, time),
            Shape::Quad => quad::pdf(self, (origin, direction), t),
            Shape::Triangle => triangle::pdf(self, (origin, direction), t),
        }
    }

    /// Chances of being chosen.
    #[inline(always)]
    pub(super) fn chance(&self) -> Float {
        self.row(1).1
    }

    /// Radiance on the `front` or the back.
    #[inline(always)]
    pub(super) fn radiance(&self, front: Mask) -> Vec3x {
        let (emission, flags) = self.row(0);
        let one_sided = is_set(flags, table::FRONT_ONLY);
        Vec3x::select(one_sided & !front, Vec3x::ZERO, emission)
    }
}

impl LightSamples {
    /// `others` in `lanes`, these elsewhere.
    #[inline(always)]
    fn unless(self, lanes: Mask, others: Self) -> Self {
        Self {
            direction: Vec3x::select(lanes, others.direction, self.direction),
            distance: lanes.select(others.distance, self.distance),
            pdf: lanes.select(others.pdf, self.pdf),
            front: (lanes & others.front) | (!lanes & self.front),
            visible: (lanes & others.visible) | (!lanes & self.visible),
        }
    }
}

/// Where a bit of a number is set.
#[inline(always)]
fn is_set(flags: Float, bit: u32) -> Mask {
    (flags.to_bits() & Int::splat(bit)).eq(Int::splat(bit))
}

/// The planes of flat lights.
struct Planes {
    point: Vec3x,
    normal: Vec3x,
    area: Float,
}

impl Planes {
    /// The samples in these directions: of density `pdf` where `exact`, else that of points uniform by
    /// area.
    #[inline(always)]
    fn sample(&self, from: Vec3x, direction: Vec3x, exact: Mask, pdf: Float) -> LightSamples {
        let slope = self.normal.dot(direction);
        let distance = -self.normal.dot(from - self.point) / slope;
        let pdf = exact.select(pdf, self.area_pdf(direction, distance));
        let positive = |x: Float| x.gt(Float::ZERO) & x.lt(Float::INFINITY);
        LightSamples {
            direction,
            distance,
            pdf,
            front: slope.lt(Float::ZERO),
            visible: positive(distance) & positive(pdf),
        }
    }

    /// Density per unit solid angle of points uniform by area, at `distance` in this direction.
    #[inline(always)]
    fn area_pdf(&self, direction: Vec3x, distance: Float) -> Float {
        distance * distance / (self.area * self.normal.dot(direction).abs())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::engine::Sampler;
    use crate::engine::dimension::{Dimension, Randoms};
    use crate::engine::scalar::light;
    use crate::geometry::Ray;
    use crate::math::random::{PixelKey, Stream};
    use crate::scene::Scene;
    use crate::simd::{LANES, axes};

    fn scene() -> Scene {
        let lights = r#"(
            camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40),
            materials: {
                "lamp": light(radiance: (1, 1, 1)),
                "spot": light(radiance: (1, 2, 3), sides: front),
                "off": light(radiance: (0, 0, 0)),
            },
            primitives: [
                quad(q: (3, 2, 1), u: (-1, 0.3, 0.1), v: (0.1, 0.2, -1), material: "lamp"),
                quad(q: (-2, 4, -1), u: (3, 0, 0), v: (0, 0, 2), material: "spot"),
                quad(q: (0.9, 0.5, 0.5), u: (0, 1e-3, 0), v: (0, 0, 1e-3), material: "lamp"),
                sphere(center: (1, 1, 1), radius: 1.5, material: "lamp"),
                sphere(center: (1, 1, 1), radius: 9, material: "off"),
                moving_sphere(center: (5, 4, 3), center1: (6, 4.5, 3), radius: 0.01, material: "spot"),
                triangles(vertices: [(1, 4, 2), (4, 4, 2.5), (2, 4, 6), (3, 4.001, 3)],
                          indices: [(0, 1, 2), (0, 1, 3)], material: "spot"),
            ],
        )"#;
        Scene::from_ron(lights).unwrap()
    }

    #[test]
    fn lanes_are_the_scalar_samples() {
        let (scene, mut random) = (scene(), Stream::new(8));
        let (lights, table) = (scene.lights().all(), LightTable::new(scene.lights()));
        assert_eq!(lights.len(), 7);
        let (mut seen, mut unseen) = (0, 0);
        for round in 0..100_000u32 {
            // One light in all lanes, or another in each.
            let chosen: Lanes<u32> = match round % 8 {
                light @ 0..7 => [light; LANES],
                _ => std::array::from_fn(|_| random.bits() as u32 % 7),
            };
            let mut numbers = |size: f32| [(); LANES].map(|()| size * random.uniform());
            let (from, [u, v, time]) =
                ([(); 3].map(|()| numbers(8.0)), [(); 3].map(|()| numbers(1.0)));
            // Some in a light's plane.
            let from = [from[0], from[1].map(|y| if y < 1.0 { 4.0 } else { y }), from[2]];
            let [fu, fv, ft] = [u, v, time].map(Float::new);
            let (origin, t) = (Vec3x::new(&from), numbers(5.0));
            let lanes = table.chosen(Int::new(chosen));
            let samples = lanes.sample(origin, ft, (fu, fv));
            let radiance = lanes.radiance(samples.front);
            let to_arrays = |v: Vec3x| axes(|axis| v[axis].to_array());
            let (direction, radiance) = (to_arrays(samples.direction), to_arrays(radiance));
            let shape = [Shape::MovingSphere, Shape::Quad, Shape::Triangle]
                [usize::from(chosen[0] > 1) + usize::from(chosen[0] > 4)];
            let found = lanes.pdf(shape, (origin, samples.direction), ft, Float::new(t)).to_array();
            for lane in 0..LANES {
                let light = &lights[chosen[lane] as usize];
                let at = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let one = light::sample(light, at(&from), time[lane], (u[lane], v[lane]));
                assert_eq!(samples.visible.bits() >> lane & 1 == 1, one.is_some());
                let Some(one) = one else {
                    unseen += 1;
                    continue;
                };
                seen += 1;
                let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                assert_eq!(bits(at(&direction)), bits(one.direction), "{light:?}");
                assert_eq!(samples.distance.to_array()[lane].to_bits(), one.distance.to_bits());
                assert_eq!(samples.pdf.to_array()[lane].to_bits(), one.pdf.to_bits());
                assert_eq!(at(&radiance), light.emission.radiance(one.front));
                assert_eq!(lanes.chance().to_array()[lane], light.chance);
                if chosen.iter().all(|&other| other == chosen[0]) {
                    let ray = Ray { origin: at(&from), direction: one.direction, time: time[lane] };
                    let want = light::pdf(light, &ray, t[lane]);
                    assert_eq!(found[lane].to_bits(), want.to_bits(), "{light:?}");
                }
            }
        }
        assert!(seen > 500_000 && unseen > 1000, "{seen} {unseen}");
    }

    #[test]
    fn lights_are_those_that_the_scalar_engine_chooses() {
        let (scene, table) = (scene(), LightTable::new(scene().lights()));
        for (sampler, x) in Sampler::ALL.into_iter().flat_map(|s| (0..2000).map(move |x| (s, x))) {
            let pixel = PixelKey::new(5, x, 0);
            let (first, second) = pixel.words();
            let words = (Int::splat(first), Int::splat(second));
            let lanes = Randoms::new(sampler, sampler.paths(words, Int::LANE), 3);
            for (sample, light) in (0..).zip(table.choose(&lanes).lights) {
                let one = Randoms::new(sampler, sampler.path(pixel, sample), 3);
                let want = scene.lights().choose(one.bits(Dimension::LIGHT_CHOICE));
                assert_eq!(&scene.lights().all()[light as usize], want);
            }
        }
        let (of, are) = table.of(scene.lights(), &std::array::from_fn(|lane| lane as u32 % 8));
        for lane in 0..LANES {
            let want = scene.lights().of(lane as u32 % 8);
            assert_eq!(are.bits() >> lane & 1 == 1, want.is_some());
            assert!(
                want.is_none_or(|want| *want == scene.lights().all()[of.lights[lane] as usize])
            );
        }
    }
}
