//! What rays have of a volume, over lanes: [`Volume::interval`] to the bit.

use crate::geometry::Volume;
use crate::simd::{Float, Vec3x};

/// The parts of rays inside `volume`, from distance 0 on.
#[inline(always)]
pub(crate) fn interval(volume: &Volume, origin: Vec3x, direction: Vec3x) -> (Float, Float) {
    let (near, far) = match volume {
        Volume::Sphere { center, radius } => {
            let (f, radius) = (origin - Vec3x::splat(*center), Float::splat(*radius));
            let b = -f.dot(direction);
            let l = f + direction * b;
            let half = Float::ZERO.max(radius * radius - l.dot(l)).sqrt();
            (b - half, b + half)
        }
        Volume::Box { center, axes, half } => {
            let f = origin - Vec3x::splat(*center);
            let (mut near, mut far) = (-Float::INFINITY, Float::INFINITY);
            for axis in 0..3 {
                let (along, half) = (Vec3x::splat(axes[axis]), Float::splat(half[axis]));
                let (o, d) = (along.dot(f), along.dot(direction));
                let (a, b) = ((-half - o) / d, (half - o) / d);
                near = a.min(b).max(near);
                far = a.max(b).min(far);
            }
            (near, far)
        }
    };
    (near.max(Float::ZERO), far)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::Ray;
    use crate::math::random::Stream;
    use crate::math::warp::uniform_sphere;
    use crate::simd::{LANES, Lanes, axes};

    #[test]
    fn lanes_are_the_scalar_intervals() {
        let mut random = Stream::new(5);
        let frame = crate::math::orthonormal_basis(uniform_sphere(0.3, 0.7));
        let volumes = [
            Volume::Sphere { center: Vec3::new(0.5, 0.0, 1.0), radius: 1.5 },
            Volume::Box { center: Vec3::Y, axes: [Vec3::X, Vec3::Y, Vec3::Z], half: Vec3::ONE },
            Volume::Box {
                center: Vec3::Z,
                axes: [frame.0, frame.1, uniform_sphere(0.3, 0.7)],
                half: Vec3::new(0.5, 1.0, 2.0),
            },
        ];
        for volume in (0..20_000).flat_map(|_| &volumes) {
            let origins: Lanes<Vec3> = std::array::from_fn(|_| {
                // Some on faces.
                Vec3::from_array([(); 3].map(|()| match random.bits() % 8 {
                    0 => 1.0,
                    _ => random.between(-3.0, 3.0),
                }))
            });
            let directions: Lanes<Vec3> = std::array::from_fn(|_| match random.bits() % 8 {
                0 => Vec3::X,
                1 => Vec3::NEG_Z,
                _ => uniform_sphere(random.uniform(), random.uniform()),
            });
            let lanes = |v: &Lanes<Vec3>| Vec3x(axes(|axis| Float::new(v.map(|v| v[axis]))));
            let (near, far) = interval(volume, lanes(&origins), lanes(&directions));
            for lane in 0..LANES {
                let (origin, direction) = (origins[lane], directions[lane]);
                let want = volume.interval(&Ray { origin, direction, time: 0.0 });
                let found = (near.to_array()[lane], far.to_array()[lane]);
                assert_eq!(found.0.to_bits(), want.0.to_bits());
                assert_eq!(found.1.to_bits(), want.1.to_bits());
            }
        }
    }
}
