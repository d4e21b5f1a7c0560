//! Volumes that media fill, and the part of a ray inside them.

use glam::{DVec3, Vec3};

use super::Ray;
use crate::math::{Real, Vector, dot, max, min};

/// A closed volume whose surface rays cannot hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Volume {
    /// A ball.
    Ball {
        /// Centre.
        center: Vec3,
        /// Radius, above 0.
        radius: f32,
    },
    /// A box.
    Box {
        /// Middle.
        center: Vec3,
        /// Unit vectors along its edges.
        axes: [Vec3; 3],
        /// Half the lengths of its edges, above 0.
        half: Vec3,
    },
}

impl Volume {
    /// The name of the kind of volume, and the vectors that define the volume, for the scene's
    /// hash.
    pub(crate) fn identity(&self) -> (&'static str, Vec<Vec3>) {
        match *self {
            Self::Ball { center, radius } => ("ball", vec![center, Vec3::splat(radius)]),
            Self::Box { center, axes: [x, y, z], half } => ("box", vec![center, x, y, z, half]),
        }
    }

    /// The interval of distances, from 0 on, in which `ray` is inside the volume. The ray's
    /// direction must have unit length. The interval is empty if the first distance is not below
    /// the second.
    #[inline(always)]
    pub(crate) fn interval<R: Real>(&self, ray: &Ray<R>) -> (R, R) {
        let vector = |v: Vec3| <R::Vec3 as Vector>::splat(v);
        let (near, far) = match *self {
            Self::Ball { center, radius } => {
                let (f, radius) = (ray.origin - vector(center), R::splat(radius));
                let b = -dot(f, ray.direction);
                let l = f + ray.direction * b;
                // Computed from `l` to avoid cancellation, as for the sphere primitive.
                let half = max(R::ZERO, radius * radius - dot(l, l)).sqrt();
                (b - half, b + half)
            }
            Self::Box { center, axes, half } => {
                let f = ray.origin - vector(center);
                let (mut near, mut far) = (-R::INFINITY, R::INFINITY);
                for (axis, half) in axes.into_iter().zip(half.to_array()) {
                    let (axis, half) = (vector(axis), R::splat(half));
                    let (o, d) = (dot(axis, f), dot(axis, ray.direction));
                    let (a, b) = ((-half - o) / d, (half - o) / d);
                    // For a ray within the plane of a face, a distance is NaN (0/0), and whether
                    // the ray counts as inside follows from how `min` and `max` treat NaN. All
                    // engines agree.
                    near = max(min(a, b), near);
                    far = min(max(a, b), far);
                }
                (near, far)
            }
        };
        (max(near, R::ZERO), far)
    }

    /// Whether the interiors overlap. Volumes that only touch do not overlap, even if rounding
    /// moves their surfaces slightly into each other.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        let slack = 1e-6 * (self.size() + other.size()) + 2.5e-7 * (self.reach() + other.reach());
        match (self, other) {
            (
                Self::Ball { center, radius },
                Self::Ball { center: other_center, radius: other_radius },
            ) => {
                let apart = (center.as_dvec3() - other_center.as_dvec3()).length();
                apart < f64::from(*radius) + f64::from(*other_radius) - slack
            }
            (ball @ Self::Ball { .. }, boxed @ Self::Box { .. }) => boxed.overlaps(ball),
            (Self::Box { .. }, Self::Ball { center: other_center, radius }) => {
                let (center, edges) = self.half_edges();
                let from = other_center.as_dvec3() - center;
                let nearest: DVec3 = edges
                    .map(|edge| edge * (from.dot(edge) / edge.dot(edge)).clamp(-1.0, 1.0))
                    .into_iter()
                    .sum();
                (from - nearest).length() < f64::from(*radius) - slack
            }
            (Self::Box { .. }, Self::Box { .. }) => self.box_overlaps(other, slack),
        }
    }

    /// The separating-axis test: two boxes are apart if a plane lies between them that is
    /// perpendicular to an edge of either, or parallel to an edge of each (Gottschalk, Lin, Manocha
    /// 1996, "OBBTree").
    fn box_overlaps(&self, other: &Self, slack: f64) -> bool {
        let ((a, edges_a), (b, edges_b)) = (self.half_edges(), other.half_edges());
        let unit = |edges: [DVec3; 3]| edges.map(DVec3::normalize);
        let across = unit(edges_a).into_iter().chain(unit(edges_b));
        let along = unit(edges_a).into_iter().flat_map(|e| unit(edges_b).map(|f| e.cross(f)));
        let edges = || edges_a.iter().chain(&edges_b);
        // Parallel edges, whose cross product is (nearly) zero, define no plane.
        across.chain(along).filter(|axis| axis.length() > 1e-6).map(DVec3::normalize).all(|axis| {
            let reach: f64 = edges().map(|edge| edge.dot(axis).abs()).sum();
            (b - a).dot(axis).abs() < reach - slack
        })
    }

    /// The longest half edge of a box, or the radius of a ball.
    fn size(&self) -> f64 {
        self.half_edges().1.into_iter().map(DVec3::length).fold(0.0, f64::max)
    }

    /// The largest absolute coordinate of the volume's middle.
    fn reach(&self) -> f64 {
        self.half_edges().0.abs().max_element()
    }

    /// The middle and the half edges of a box, or of the bounding box of a ball.
    fn half_edges(&self) -> (DVec3, [DVec3; 3]) {
        match self {
            Self::Ball { center, radius } => {
                (center.as_dvec3(), [DVec3::X, DVec3::Y, DVec3::Z].map(|e| e * f64::from(*radius)))
            }
            Self::Box { center, axes, half } => {
                let edge = |axis: usize| axes[axis].as_dvec3() * f64::from(half[axis]);
                (center.as_dvec3(), [edge(0), edge(1), edge(2)])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::uniform_sphere;
    use crate::math::{Stream, normalize};

    fn sphere(x: f32, radius: f32) -> Volume {
        Volume::Ball { center: Vec3::new(x, 0.0, 0.0), radius }
    }

    /// A cube rotated by 45 degrees about z.
    fn turned(x: f32, half: f32) -> Volume {
        let r = 0.5f32.sqrt();
        let axes = [Vec3::new(r, r, 0.0), Vec3::new(-r, r, 0.0), Vec3::Z];
        Volume::Box { center: Vec3::new(x, 0.0, 0.0), axes, half: Vec3::splat(half) }
    }

    fn straight(x: f32, half: f32) -> Volume {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        Volume::Box { center: Vec3::new(x, 0.0, 0.0), axes, half: Vec3::splat(half) }
    }

    #[test]
    fn intervals_agree_with_tests_of_points() {
        let inside = |volume: &Volume, p: Vec3| match *volume {
            Volume::Ball { center, radius } => (p - center).length_squared() < radius * radius,
            Volume::Box { center, axes, half } => {
                (0..3).all(|axis| dot(axes[axis], p - center).abs() < half[axis])
            }
        };
        let mut random = Stream::new(3);
        let volumes = [sphere(1.0, 2.0), turned(0.5, 1.5), straight(-1.0, 1.0)];
        let mut crossed = 0;
        for volume in (0..30_000).flat_map(|_| &volumes) {
            let direction = match random.bits() % 4 {
                0 => [Vec3::X, Vec3::Y, Vec3::NEG_Z][(random.bits() % 3) as usize],
                _ => normalize(uniform_sphere(random.uniform(), random.uniform())),
            };
            let origin = Vec3::from_array([(); 3].map(|()| random.between(-4.0, 4.0)));
            let ray = Ray { origin, direction, time: 0.0 };
            let (near, far) = volume.interval(&ray);
            crossed += u32::from(near < far);
            for t in [0.0f32, 0.5, 1.0, 2.0, 3.0, 5.0] {
                let away = (t - near).abs() > 1e-3 && (t - far).abs() > 1e-3;
                if away || !(near < far) && (far - near).abs() > 1e-2 {
                    let p = origin + direction * t;
                    assert_eq!(
                        inside(volume, p),
                        near < t + 1e-6 && t < far,
                        "{volume:?} {ray:?} {t}"
                    );
                }
            }
        }
        assert!(crossed > 9_000, "{crossed}");
    }

    /// A cube rotated by a tiny angle, whose edges are almost parallel to those of [`straight`].
    fn hardly_turned(x: f32, half: f32) -> Volume {
        let axes = [Vec3::X, Vec3::new(0.0, 1.0, 2e-6), Vec3::new(0.0, -2e-6, 1.0)];
        Volume::Box { center: Vec3::new(x, 0.0, 0.0), axes, half: Vec3::splat(half) }
    }

    #[test]
    fn overlaps_are_seen() {
        let root = 2.0f32.sqrt();
        for (a, b, want) in [
            (sphere(0.0, 1.0), sphere(1.9, 1.0), true),
            (sphere(0.0, 1.0), sphere(2.0, 1.0), false),
            (sphere(0.0, 1.0), sphere(0.1, 0.2), true),
            (straight(0.0, 1.0), sphere(1.9, 1.0), true),
            (straight(0.0, 1.0), sphere(2.01, 1.0), false),
            (straight(0.0, 9.0), sphere(0.5, 1.0), true),
            (straight(0.0, 1.0), straight(2.0, 1.0), false),
            (straight(0.0, 1.0), straight(1.99, 1.0), true),
            (straight(0.0, 1.0), hardly_turned(1.7, 1.0), true),
            (straight(0.0, 1.0), hardly_turned(2.0, 1.0), false),
            // Volumes that touch exactly in decimal arithmetic.
            (sphere(0.7, 0.3), sphere(0.2, 0.2), false),
            (sphere(1000.7, 0.3), sphere(1000.2, 0.2), false),
            (straight(0.7, 0.3), sphere(0.2, 0.2), false),
            (straight(0.7, 0.3), straight(0.2, 0.2), false),
            // The edges of a rotated cube reach farther than its faces.
            (straight(0.0, 1.0), turned(1.0 + root - 0.01, 1.0), true),
            (straight(0.0, 1.0), turned(1.0 + root + 0.01, 1.0), false),
            (turned(0.0, 1.0), turned(2.0 * root - 0.1, 1.0), true),
            (turned(0.0, 1.0), turned(2.0 * root + 0.1, 1.0), false),
        ] {
            assert_eq!(a.overlaps(&b), want, "{a:?} {b:?}");
            assert_eq!(b.overlaps(&a), want, "{b:?} {a:?}");
        }
    }
}
