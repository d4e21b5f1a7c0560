//! Axis-aligned bounding boxes.

use glam::Vec3;

use crate::math::{max, min};

/// A closed axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Bounds {
    /// The empty box, which is the neutral element of [`Bounds::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.union(Self { min: p, max: p }))
    }

    /// The smallest box around both boxes.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: componentwise(min, self.min, other.min),
            max: componentwise(max, self.max, other.max),
        }
    }

    /// The box with each face moved outward to the next f32, `ulps` times.
    pub fn widened(self, ulps: u32) -> Self {
        (0..ulps).fold(self, |b, _| Self {
            min: b.min.map(f32::next_down),
            max: b.max.map(f32::next_up),
        })
    }

    /// The box with subnormal coordinates moved outward to normal ones. An operation on a subnormal
    /// number can cost over a hundred cycles, and a sphere that rests on y = 0 has such a
    /// coordinate.
    pub fn without_subnormals(self) -> Self {
        let outward = |value: f32, by: f32| if value.is_subnormal() { by } else { value };
        Self {
            min: self.min.map(|low| outward(low, -f32::MIN_POSITIVE)),
            max: self.max.map(|high| outward(high, f32::MIN_POSITIVE)),
        }
    }

    /// Half the surface area, which is 0 for the empty box.
    pub fn half_area(self) -> f32 {
        let d = componentwise(max, self.max - self.min, Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// An upper bound on the distance from `point` to the farthest point of the box.
    pub fn farthest_distance(self, point: Vec3) -> f32 {
        let reach = componentwise(max, (self.min - point).abs(), (self.max - point).abs());
        // The 1-norm is never below the Euclidean norm.
        reach.x + reach.y + reach.z
    }
}

fn componentwise(f: fn(f32, f32) -> f32, a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(f(a.x, b.x), f(a.y, b.y), f(a.z, b.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_and_distance() {
        let b = Bounds::of([Vec3::new(1.0, -2.0, 3.0), Vec3::ZERO]);
        assert_eq!((b.min, b.max), (Vec3::new(0.0, -2.0, 0.0), Vec3::new(1.0, 0.0, 3.0)));
        assert_eq!(Bounds::EMPTY.union(b), b);
        assert!(b.farthest_distance(Vec3::new(5.0, 0.0, 0.0)) >= length_to_far_corner());
        let wide = b.widened(2);
        assert!(wide.min.x < 0.0 && wide.max.z > 3.0);
        let normal = wide.without_subnormals();
        assert!(wide.min.x.is_subnormal() && normal.min.x == -f32::MIN_POSITIVE);
        assert_eq!(normal.max, Vec3::new(wide.max.x, f32::MIN_POSITIVE, wide.max.z));
    }

    fn length_to_far_corner() -> f32 {
        (25.0f32 + 4.0 + 9.0).sqrt()
    }
}
