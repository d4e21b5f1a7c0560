//! Uniform samples of the solid angle of a rectangle (Ureña, Fajardo, King 2013, "An
//! Area-Preserving Parametrization for Spherical Rectangles").
//!
//! Departures from the paper, for f32:
//! 1. The inner angles are π/2 + asin of products of cosines, so that the solid angle is a
//!    sum of four arcsines and the 2π that would cancel is never added.
//! 2. The angle of a sample is measured from π, and the cotangent that the paper divides by
//!    is multiplied out: no pole in the middle of the rectangle.

use glam::Vec3;

use crate::math::trig::{asin, sin_cos};
use crate::math::{clamp, dot, max};
use crate::scene::Rectangle;

/// A rectangle as seen from a point.
pub(super) struct SphericalRectangle<'a> {
    rectangle: &'a Rectangle,
    from: Vec3,
    /// Edges and (negative) height in the rectangle's frame about the point.
    x: (f32, f32),
    y: (f32, f32),
    z: f32,
    /// Whether the frame's z-axis is the rectangle's normal reversed.
    flipped: bool,
    /// z components of the normals of the planes through the edges at y0 and y1.
    normals_z: (f32, f32),
    /// Angle of the first sample.
    start: f32,
    solid_angle: f32,
}

/// Below this the sum of arcsines has lost too many digits: sample by area there.
const MIN_SOLID_ANGLE: f32 = 1e-3;

impl<'a> SphericalRectangle<'a> {
    /// `None` where the rectangle is too small, as seen from `from`, for f32.
    pub(super) fn new(rectangle: &'a Rectangle, from: Vec3) -> Option<Self> {
        let to_corner = rectangle.corner - from;
        let [x0, y0, height] = rectangle.axes.map(|axis| dot(to_corner, axis));
        let (x1, y1) = (x0 + rectangle.size.0, y0 + rectangle.size.1);
        let flipped = height > 0.0;
        let z = -height.abs();
        let normal_z = |edge: f32| edge / (edge * edge + z * z).sqrt();
        let n = [normal_z(-y0), normal_z(x1), normal_z(y1), normal_z(-x0)];
        let angles = [0, 1, 2, 3].map(|i| asin(n[i] * n[(i + 1) % 4]));
        let solid_angle = angles[0] + angles[1] + angles[2] + angles[3];
        (solid_angle > MIN_SOLID_ANGLE).then(|| Self {
            rectangle,
            from,
            x: (x0, x1),
            y: (y0, y1),
            z,
            flipped,
            normals_z: (n[0], n[2]),
            start: -(angles[2] + angles[3]),
            solid_angle,
        })
    }

    /// Density of [`Self::sample`]'s directions per unit solid angle.
    pub(super) fn pdf(&self) -> f32 {
        1.0 / self.solid_angle
    }

    /// A point of the rectangle.
    pub(super) fn sample(&self, u: f32, v: f32) -> Vec3 {
        let (b0, b1) = self.normals_z;
        let (z, z2) = (self.z, self.z * self.z);
        // The column whose share of the solid angle to its left is u.
        let (sin, cos) = sin_cos(self.start + u * self.solid_angle);
        let n = b0 * cos + b1;
        let y0 = self.y.0;
        let radicand = n * n - sin * sin * (z2 / (y0 * y0 + z2));
        let side = if n < 0.0 { -sin } else { sin };
        let x = -z * side / max(radicand, 0.0).sqrt();
        let x = clamp(x, self.x.0, self.x.1);
        // The height in that column, uniform in the sine of its elevation.
        let d2 = x * x + z2;
        let elevation = |y: f32| y / (d2 + y * y).sqrt();
        let (h0, h1) = (elevation(self.y.0), elevation(self.y.1));
        let h = h0 + v * (h1 - h0);
        let y = h * d2.sqrt() / max((1.0 - h) * (1.0 + h), 1e-12).sqrt();
        let y = clamp(y, self.y.0, self.y.1);
        let [ax, ay, az] = self.rectangle.axes;
        let height = if self.flipped { -z } else { z };
        self.from + ax * x + ay * y + az * height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    fn rectangle() -> Rectangle {
        Rectangle {
            corner: Vec3::new(213.0, 554.0, 227.0),
            axes: [Vec3::X, Vec3::NEG_Z, Vec3::Y],
            size: (130.0, 105.0),
            area: 130.0 * 105.0,
        }
    }

    /// Solid angle of the part of the rectangle up to (x, y) of its size, in f64.
    #[allow(clippy::disallowed_methods)]
    fn solid_angle(r: &Rectangle, from: Vec3, x: f64, y: f64) -> f64 {
        let d = (r.corner - from).as_dvec3();
        let [x0, y0, z] = r.axes.map(|a| d.dot(a.as_dvec3()));
        // ∬ z dx dy/(x² + y² + z²)^(3/2) over [0, x] × [0, y].
        let part = |x: f64, y: f64| (x * y / (z.abs() * (x * x + y * y + z * z).sqrt())).atan();
        let (x1, y1) = (x0 + x, y0 + y);
        part(x1, y1) - part(x0, y1) - part(x1, y0) + part(x0, y0)
    }

    const VIEWS: [Vec3; 6] = [
        Vec3::new(278.0, 0.0, 279.0),
        Vec3::new(0.0, 300.0, 0.0),
        Vec3::new(250.0, 555.0, 200.0), // 1 above the lamp, as from the ceiling
        Vec3::new(400.0, 555.0, 300.0),
        Vec3::new(214.0, 553.99, 226.0),
        Vec3::new(555.0, 550.0, 130.0),
    ];

    #[test]
    fn solid_angle_agrees_with_the_closed_form() {
        for from in VIEWS {
            let r = rectangle();
            let got = f64::from(1.0 / SphericalRectangle::new(&r, from).unwrap().pdf());
            let want = solid_angle(&r, from, 130.0, 105.0);
            // The arcsine of 1 − u, u the unit roundoff, is off by √(2u) = 3.5e-4.
            assert!((got - want).abs() < 3.5e-4, "{from}: {got} {want}");
        }
        let far = Vec3::new(0.0, -1e5, 0.0);
        assert!(SphericalRectangle::new(&rectangle(), far).is_none());
    }

    #[test]
    fn samples_are_uniform_in_solid_angle() {
        const N: usize = 200_000;
        for from in VIEWS {
            let r = rectangle();
            let spherical = SphericalRectangle::new(&r, from).unwrap();
            let whole = solid_angle(&r, from, 130.0, 105.0);
            let mut random = Stream::new(11);
            // Share of the samples below 7 × 7 points of the rectangle, against the exact one.
            let mut below = [[0u32; 7]; 7];
            for _ in 0..N {
                let p = spherical.sample(random.uniform(), random.uniform()) - r.corner;
                let (x, y) = (dot(p, r.axes[0]), dot(p, r.axes[1]));
                assert!((-1e-3..=130.001).contains(&x) && (-1e-3..=105.001).contains(&y));
                for (i, row) in below.iter_mut().enumerate() {
                    for (j, count) in row.iter_mut().enumerate() {
                        let (u, v) = ((i + 1) as f32 / 8.0, (j + 1) as f32 / 8.0);
                        *count += u32::from(x < 130.0 * u && y < 105.0 * v);
                    }
                }
            }
            for (i, row) in below.iter().enumerate() {
                for (j, &count) in row.iter().enumerate() {
                    let (u, v) = ((i + 1) as f64 / 8.0, (j + 1) as f64 / 8.0);
                    let p = solid_angle(&r, from, 130.0 * u, 105.0 * v) / whole;
                    let got = f64::from(count) / N as f64;
                    // Five standard deviations, over 294 tests.
                    let bound = 5.0 * (p * (1.0 - p) / N as f64).sqrt() + 1e-5;
                    assert!((got - p).abs() < bound, "{from} ({u}, {v}): {got} {p}");
                }
            }
        }
    }
}
