//! Generators of primitives and rays that are hard for trees and kernels.

use glam::Vec3;
use ptfast::internals::{
    Bounds, Geometry, Quad, Ray, Sphere, Stream, Triangle, cross, dot, length, normalize,
    uniform_sphere,
};

pub(crate) fn vector(random: &mut Stream, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.between(-size, size)))
}

/// Spheres (some moving), quads and meshes of triangles that share edges, in a box of side
/// `2 scale` about `shift`. Some primitives are duplicated.
pub(crate) fn soup(seed: u64, primitives: usize, scale: f32, shift: Vec3) -> Geometry {
    let mut random = Stream::new(seed);
    let mut geometry = Geometry::default();
    while geometry.len() < primitives {
        let center = shift + vector(&mut random, scale);
        let again = random.uniform() < 0.1;
        let kind = random.uniform();
        if kind < 0.4 {
            let motion = if kind < 0.1 { vector(&mut random, 0.2 * scale) } else { Vec3::ZERO };
            let center1 = center + motion;
            let radius = scale * random.between(0.01, 0.2);
            geometry.spheres.push(Sphere { center, center1, radius });
        } else if kind < 0.7 {
            let mut u = vector(&mut random, 0.3 * scale);
            // Some are as thin as a quad may be.
            let thin = if kind < 0.5 { 0.02 } else { 1.0 };
            let mut v = u * (1.0 - thin) + vector(&mut random, 0.3 * scale) * thin;
            // Some are perpendicular to an axis, some have an edge along an axis, and some have
            // both properties.
            let along = geometry.quads.len() % 3;
            if kind > 0.56 {
                u[along] = 0.0;
                v = if kind > 0.6 {
                    Vec3::AXES[along] * v[along]
                } else {
                    v - Vec3::AXES[along] * v[along]
                };
            }
            if kind > 0.65 {
                u[(along + 1) % 3] = 0.0;
            }
            geometry.quads.extend(Quad::new(center, u, v));
        } else {
            // A fan about `center`: neighbours share edges and all share a vertex.
            let rim: Vec<Vec3> =
                (0..6).map(|_| center + vector(&mut random, 0.3 * scale)).collect();
            for i in 0..6 {
                let vertices = [center, rim[i], rim[(i + 1) % 6]];
                geometry.triangles.push(Triangle { vertices });
            }
        }
        if again {
            // Bitwise equal duplicates, so that ties must go to the lower index.
            let Geometry { spheres, quads, triangles, .. } = &mut geometry;
            spheres.extend_from_within(spheres.len().saturating_sub(1)..);
            quads.extend_from_within(quads.len().saturating_sub(1)..);
            let last = (triangles.len().saturating_sub(3)..triangles.len())
                .filter_map(|i| triangles.get(i));
            let last: Vec<_> = last.collect();
            triangles.extend(last);
        }
    }
    geometry
}

/// A target for rays: a random point, a vertex, an edge, a silhouette, or a corner, an edge or a
/// face of a primitive's box.
pub(crate) fn target(
    random: &mut Stream,
    geometry: &Geometry,
    origin: Vec3,
    scale: f32,
    shift: Vec3,
) -> Vec3 {
    match pick(random, 7) {
        0 if !geometry.triangles.is_empty() => {
            let [a, b, c] = geometry.triangles.vertices(pick(random, geometry.triangles.len()));
            let t = random.uniform();
            match pick(random, 3) {
                0 => a,
                1 => a * (1.0 - t) + b * t,
                _ => b * (1.0 - t) + c * t,
            }
        }
        1 if !geometry.quads.is_empty() => {
            let quad = geometry.quads[pick(random, geometry.quads.len())];
            quad.q + quad.u * random.uniform() + quad.v * (pick(random, 2) as f32)
        }
        2 if !geometry.spheres.is_empty() => {
            let sphere = geometry.spheres[pick(random, geometry.spheres.len())];
            let to = sphere.center - origin;
            let side = normalize(cross(to, vector(random, 1.0)));
            sphere.center + side * sphere.radius
        }
        3 if !geometry.is_empty() => {
            let Bounds { min, max } = random_box(random, geometry);
            Vec3::from_array(std::array::from_fn(|axis| match pick(random, 3) {
                0 => min[axis],
                1 => max[axis],
                _ => random.between(min[axis], max[axis]),
            }))
        }
        _ => shift + vector(random, scale),
    }
}

fn pick(random: &mut Stream, n: usize) -> usize {
    (random.bits() % n as u64) as usize
}

/// The box of a random primitive.
fn random_box(random: &mut Stream, geometry: &Geometry) -> Bounds {
    geometry.get(pick(random, geometry.len()) as u32).bounds()
}

/// Ray number `i`, with a difficult target, origin or direction, and the end of its interval.
pub(crate) fn adversarial(
    random: &mut Stream,
    i: usize,
    geometry: &Geometry,
    scale: f32,
    shift: Vec3,
) -> (Ray, f32) {
    let time = random.uniform();
    let mut origin = match i % 3 {
        0 => shift + uniform_sphere(random.uniform(), random.uniform()) * (scale * 4.0),
        1 => shift + vector(random, scale),
        _ => target(random, geometry, shift, scale, shift),
    };
    let mut direction = target(random, geometry, origin, scale, shift) - origin;
    match i % 11 {
        0 => direction *= [1e-6, 1e6][i % 2],
        // 2⁻²⁰ to 2²⁰.
        1 => direction *= f32::from_bits((107 + random.bits() as u32 % 41) << 23),
        2 => direction[i % 3] = 0.0,
        3 => direction[i % 3] = -0.0,
        4 => {
            let axis = i % 3;
            direction = Vec3::ZERO;
            direction[axis] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            // Exactly in the plane of one box face, or of two.
            if !geometry.is_empty() {
                let faces = random_box(random, geometry);
                for other in [(axis + 1) % 3, (axis + 2) % 3].into_iter().take(1 + i / 11 % 2) {
                    origin[other] = [faces.min, faces.max][pick(random, 2)][other];
                }
            }
        }
        _ => {}
    }
    if i.is_multiple_of(13) && !geometry.triangles.is_empty() {
        // In the plane of a triangle.
        let [a, b, c] = geometry.triangles.vertices(i / 13 % geometry.triangles.len());
        let at = |s: f32, t: f32| a + (b - a) * s + (c - a) * t;
        origin = at(random.between(-2.0, 3.0), random.between(-2.0, 3.0));
        direction = at(random.uniform(), random.uniform() * 0.5) - origin;
    }
    if i.is_multiple_of(17) && !geometry.quads.is_empty() {
        // Past a corner of a quad, from in front of it.
        let quad = geometry.quads[i / 17 % geometry.quads.len()];
        let corner = quad.q + (quad.u + quad.v) * random.between(0.999_999, 1.000_001);
        origin = corner + quad.normal * scale + vector(random, scale);
        direction = corner - origin;
    }
    if i.is_multiple_of(19) && !geometry.spheres.is_empty() {
        // Tangent to a sphere at its surface, up to a few rounding errors.
        let sphere = geometry.spheres[pick(random, geometry.spheres.len())];
        let normal = uniform_sphere(random.uniform(), random.uniform());
        let few = |random: &mut Stream| random.between(-4.0, 4.0) * f32::EPSILON;
        origin = sphere.center_at(time) + normal * (sphere.radius * (1.0 + few(random)));
        let any = vector(random, scale);
        direction = any - normal * (dot(any, normal) * (1.0 + few(random)));
    }
    let t_max = if i.is_multiple_of(7) { random.uniform() } else { f32::INFINITY };
    (Ray { origin, direction, time }, t_max)
}

/// Generates coherent rays, as the packet kernels expect them: bundles of similar rays that start
/// either at one point or side by side with equal directions.
pub(crate) struct Bundles<'a> {
    random: Stream,
    geometry: &'a Geometry,
    scale: f32,
    shift: Vec3,
    base: Ray,
}

impl<'a> Bundles<'a> {
    pub(crate) const SIZE: usize = 64;

    pub(crate) fn new(seed: u64, geometry: &'a Geometry, scale: f32, shift: Vec3) -> Self {
        let base = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
        Self { random: Stream::new(seed), geometry, scale, shift, base }
    }

    pub(crate) fn next(&mut self, i: usize) -> (Ray, f32) {
        let Self { random, geometry, scale, shift, base } = self;
        let bundle = i / Self::SIZE;
        if i.is_multiple_of(Self::SIZE) {
            *base = adversarial(random, bundle, geometry, *scale, *shift).0;
        }
        let wide = [1e-6, 1e-3, 0.1][bundle % 3];
        let mut ray = *base;
        let length = length(ray.direction);
        if bundle.is_multiple_of(2) {
            // Turn the ray a little towards a second target, often a vertex or a corner of a box.
            let near = target(random, geometry, ray.origin, *scale, *shift) - ray.origin;
            let to = near * (length / (1e-30 + near.length_squared().sqrt()));
            ray.direction += (to - ray.direction) * (wide * random.uniform());
            ray.direction += vector(random, wide * length);
        } else {
            ray.origin += vector(random, wide * *scale);
        }
        ray.time = random.uniform();
        // Some rays are perpendicular to an axis, and some are invalid.
        match i {
            // In some bundles, zeros of the other sign give packets of mixed octants.
            i if i.is_multiple_of(19) => {
                let sign = if bundle.is_multiple_of(3) {
                    i as f32 % 2.0 - 0.5
                } else {
                    base.direction[i % 3]
                };
                ray.direction[i % 3] = 0.0f32.copysign(sign);
            }
            i if i.is_multiple_of(23) => ray.direction = Vec3::ZERO,
            i if i.is_multiple_of(29) => ray.origin.y = f32::NAN,
            // Invalidate part of a packet.
            i if bundle.is_multiple_of(7) && i % Self::SIZE < 20 => ray.direction = Vec3::ZERO,
            _ => {}
        }
        let t_max = match i % 31 {
            0 => f32::NAN,
            1 => 0.0,
            2 => random.uniform(),
            _ => f32::INFINITY,
        };
        (ray, t_max)
    }
}
