//! Maps of all directions to the unit square.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use crate::math::{Mask, Real, Vector, atan2, sin_cos_turns};

/// How an image shows all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mapping {
    /// Longitude runs from left to right, and latitude from +y on top to −y at the bottom. The
    /// middle shows −z, and the right half +x.
    #[default]
    LatLong,
    /// The square map of pbrt-v4, in which equal areas show equal solid angles (Clarberg 2008,
    /// "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD"). The middle shows +z, the corners
    /// −z, the right +x and the bottom +y.
    EqualArea,
}

impl Mapping {
    /// The position of the unit vector `d`, from the upper left corner, in [0, 1].
    #[inline(always)]
    pub(super) fn place<R: Real>(self, d: R::Vec3) -> (R, R) {
        match self {
            Self::LatLong => {
                let across = (d[0] * d[0] + d[2] * d[2]).sqrt();
                let turn = atan2(d[0], -d[2]) * (0.5 / PI);
                (turn + R::splat(0.5), atan2(across, d[1]) * (1.0 / PI))
            }
            Self::EqualArea => {
                let (x, y, z) = (d[0].abs(), d[1].abs(), d[2].abs());
                // 1 − |z| = r², without the cancellation.
                let r = ((x * x + y * y) / (R::ONE + z)).sqrt();
                let v = r * atan2(y, x) * (2.0 / PI);
                let u = r - v;
                let below = d[2].lt(R::ZERO);
                let (u, v) = (below.select(R::ONE - v, u), below.select(R::ONE - u, v));
                let place = |part: R, sign: R| (part.copysign(sign) + R::ONE) * 0.5;
                (place(u, d[0]), place(v, d[1]))
            }
        }
    }

    /// The direction at a position of an equal-area map, nearly of unit length.
    #[inline(always)]
    pub(super) fn equal_area_direction<R: Real>(u: R, v: R) -> R::Vec3 {
        let (u, v) = (u * 2.0 - R::ONE, v * 2.0 - R::ONE);
        let (x, y) = (u.abs(), v.abs());
        let inside = R::ONE - (x + y);
        let r = R::ONE - inside.abs();
        let slope = r.gt(R::ZERO).select((y - x) / r, R::ZERO);
        let (sin, cos) = sin_cos_turns((slope + R::ONE) * 0.125);
        let across = r * (R::splat(2.0) - r * r).sqrt();
        let z = (R::ONE - r * r).copysign(inside);
        R::Vec3::new(cos.copysign(u) * across, sin.copysign(v) * across, z)
    }
}

/// The texel that lies at (x, y) in a continued image of `size`, where x and y may be one beyond an
/// edge.
pub(super) fn neighbor(mapping: Mapping, [x, y]: [i32; 2], size: [u32; 2]) -> [u32; 2] {
    let [width, height] = size.map(|side| side as i32);
    let inside = (0..width).contains(&x) && (0..height).contains(&y);
    let (x, y) = match mapping {
        _ if inside => (x, y),
        Mapping::LatLong => (x.rem_euclid(width), y.clamp(0, height - 1)),
        // Each edge is folded in half about its middle.
        Mapping::EqualArea => {
            let (x, y) = match x < 0 || x >= width {
                true => (x.clamp(0, width - 1), height - 1 - y),
                false => (x, y),
            };
            match y < 0 || y >= height {
                true => (width - 1 - x, y.clamp(0, height - 1)),
                false => (x, y),
            }
        }
    };
    [x as u32, y as u32]
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::warp::uniform_sphere;
    use crate::math::{Stream, length, max};

    #[test]
    fn places_of_the_axes_are_as_documented() {
        let near = |mapping: Mapping, axis: Vec3, want: (f32, f32)| {
            let (u, v) = mapping.place::<f32>(axis);
            assert!(max((u - want.0).abs(), (v - want.1).abs()) < 1e-6, "{axis}: {u} {v}");
        };
        near(Mapping::LatLong, -Vec3::Z, (0.5, 0.5));
        near(Mapping::LatLong, Vec3::X, (0.75, 0.5));
        near(Mapping::LatLong, -Vec3::X, (0.25, 0.5));
        assert!(Mapping::LatLong.place::<f32>(Vec3::Y).1 < 1e-6);
        assert!(Mapping::LatLong.place::<f32>(-Vec3::Y).1 > 1.0 - 1e-6);
        near(Mapping::EqualArea, Vec3::Z, (0.5, 0.5));
        near(Mapping::EqualArea, Vec3::X, (1.0, 0.5));
        near(Mapping::EqualArea, -Vec3::Y, (0.5, 0.0));
    }

    #[test]
    fn equal_area_maps_are_inverted_and_equal_in_area() {
        let mut random = Stream::new(3);
        let mut cells = [[0u32; 8]; 8];
        for _ in 0..200_000 {
            let direction = uniform_sphere(random.uniform(), random.uniform());
            let (u, v) = Mapping::EqualArea.place::<f32>(direction);
            let back = Mapping::equal_area_direction::<f32>(u, v);
            assert!(length(back - direction) < 1e-6, "{direction} {back}");
            cells[(v * 7.999) as usize][(u * 7.999) as usize] += 1;
        }
        let mean = 200_000.0 / 64.0;
        let chi: f64 = cells
            .iter()
            .flatten()
            .map(|&n| (f64::from(n) - mean) * (f64::from(n) - mean) / mean)
            .sum();
        assert!(chi < 63.0 + 6.0 * 11.3, "{chi}");
    }

    /// Neighbours across an edge show neighbouring directions.
    #[test]
    fn edges_are_joined_to_where_they_continue() {
        const SIDE: u32 = 64;
        let direction = |[x, y]: [u32; 2]| {
            let at = |i: u32| (i as f32 + 0.5) / SIDE as f32;
            Mapping::equal_area_direction::<f32>(at(x), at(y))
        };
        for i in 0..SIDE as i32 {
            let last = SIDE as i32 - 1;
            let pairs = [[[-1, i], [0, i]], [[last + 1, i], [last, i]], [[i, -1], [i, 0]]];
            for [beyond, inside] in pairs {
                let at = |place| direction(neighbor(Mapping::EqualArea, place, [SIDE; 2]));
                assert!(length(at(beyond) - at(inside)) < 0.09, "{beyond:?}");
            }
        }
        assert_eq!(neighbor(Mapping::LatLong, [-1, -1], [4, 2]), [3, 0]);
        assert_eq!(neighbor(Mapping::LatLong, [4, 2], [4, 2]), [0, 1]);
    }
}
