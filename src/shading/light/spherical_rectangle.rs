//! Uniform sampling of the solid angle of a rectangle (Ureña, Fajardo, King 2013, "An
//! Area-Preserving Parametrization for Spherical Rectangles").
//!
//! The code departs from the paper in two points to keep precision in f32:
//! 1. An inner angle is π/2 plus the angle whose tangent is xy/(|z|r) at its corner (x, y),
//!    with r the corner's distance. This avoids an arccosine near ±1, and it avoids adding a
//!    2π that would cancel later.
//! 2. The angle of a sample is measured from π, the cotangent that the paper divides by is
//!    multiplied out, and the rectangle is mirrored so that y1 ≥ |y0|. This avoids a pole in
//!    the middle of the rectangle and differences of almost equal terms.

use super::{MIN_SINE, MIN_SOLID_ANGLE};
use crate::math::{Mask, Real, atan2, clamp, dot, max, sin_cos};

/// A rectangle in space.
pub(super) struct Rectangle<R: Real> {
    pub(super) corner: R::Vec3,
    /// Unit vectors along the edges and the normal.
    pub(super) axes: [R::Vec3; 3],
    /// Lengths of the edges.
    pub(super) size: (R, R),
}

/// A rectangle as seen from a point, in a frame with the rectangle's axes around that point.
pub(super) struct SphericalRectangle<'a, R: Real> {
    rectangle: &'a Rectangle<R>,
    from: R::Vec3,
    /// Extent along the x axis.
    x: (R, R),
    /// Extent along the y axis, mirrored in the lanes of `mirrored`.
    y: (R, R),
    mirrored: R::Mask,
    /// Signed height of the rectangle's plane above the point.
    height: R,
    /// Angle of the samples with u = 0.
    start: R,
    solid_angle: R,
    /// Whether f32 is precise enough to sample by solid angle. Otherwise the rectangle appears too
    /// small, or its plane almost contains the point, and the rectangle is sampled by area.
    pub(super) exact: R::Mask,
}

impl<'a, R: Real> SphericalRectangle<'a, R> {
    #[inline(always)]
    pub(super) fn new(rectangle: &'a Rectangle<R>, from: R::Vec3) -> Self {
        let to_corner = rectangle.corner - from;
        let [ax, ay, az] = rectangle.axes;
        let (x0, y0, height) = (dot(to_corner, ax), dot(to_corner, ay), dot(to_corner, az));
        let (x1, y1) = (x0 + rectangle.size.0, y0 + rectangle.size.1);
        let mirrored = (y0 + y1).lt(R::ZERO);
        let (y0, y1) = (mirrored.select(-y1, y0), mirrored.select(-y0, y1));
        let z2 = height * height;
        let distance = |x: R, y: R| (x * x + y * y + z2).sqrt();
        let farthest = distance(max(x0.abs(), x1.abs()), y1);
        let angle = |x: R, y: R| atan2(x * y, height.abs() * distance(x, y));
        let (a2, a3) = (-angle(x0, y1), angle(x0, y0));
        let solid_angle = (angle(x1, y1) + a2) - (angle(x1, y0) - a3);
        let exact =
            solid_angle.gt(R::splat(MIN_SOLID_ANGLE)) & height.abs().gt(farthest * MIN_SINE);
        let start = -(a2 + a3);
        let (x, y) = ((x0, x1), (y0, y1));
        Self { rectangle, from, x, y, mirrored, height, start, solid_angle, exact }
    }

    /// Returns the density of [`Self::sample`]'s directions per unit solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> R {
        R::ONE / self.solid_angle
    }

    /// Samples a point of the rectangle.
    #[inline(always)]
    pub(super) fn sample(&self, u: R, v: R) -> R::Vec3 {
        let (y0, y1) = self.y;
        let z2 = self.height * self.height;
        // z components of the normals of the planes through the edges at y0 and y1.
        let (d0, d1) = ((y0 * y0 + z2).sqrt(), (y1 * y1 + z2).sqrt());
        let (b0, b1) = (-y0 / d0, y1 / d1);
        // The sum b0 + b1, computed as a quotient in lanes where the terms may nearly cancel.
        let quotient = z2 * ((y1 - y0) * (y1 + y0)) / (d0 * d1 * (y1 * d0 + y0 * d1));
        let sum = y0.gt(R::ZERO).select(quotient, b0 + b1);
        // The column that has the share u of the solid angle to its left.
        let angle = self.start + u * self.solid_angle;
        let (sin, _) = sin_cos(angle);
        let (half_sin, _) = sin_cos(angle * 0.5);
        let n = sum - b0 * (half_sin * 2.0 * half_sin); // b0 cos + b1
        let radicand = n * n - sin * sin * (z2 / (d0 * d0));
        let side = n.lt(R::ZERO).select(-sin, sin);
        let x = self.height.abs() * side / max(radicand, R::ZERO).sqrt();
        let x = clamp(x, self.x.0, self.x.1);
        // The y coordinate within that column, uniform in the sine of its elevation.
        let d2 = x * x + z2;
        let elevation = |y: R| y / (d2 + y * y).sqrt();
        let (h0, h1) = (elevation(y0), elevation(y1));
        let h = h0 + v * (h1 - h0);
        let y = h * d2.sqrt() / max((R::ONE - h) * (R::ONE + h), R::splat(1e-12)).sqrt();
        let y = clamp(y, y0, y1);
        let [ax, ay, az] = self.rectangle.axes;
        self.from + ax * x + ay * self.mirrored.select(-y, y) + az * self.height
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::Stream;

    fn rectangle() -> Rectangle<f32> {
        Rectangle {
            corner: Vec3::new(213.0, 554.0, 227.0),
            axes: [Vec3::X, Vec3::NEG_Z, Vec3::Y],
            size: (130.0, 105.0),
        }
    }

    /// Solid angle of the part of the rectangle from its corner to (x, y), in f64.
    #[allow(clippy::disallowed_methods)]
    fn solid_angle(r: &Rectangle<f32>, from: Vec3, x: f64, y: f64) -> f64 {
        let d = (r.corner - from).as_dvec3();
        let [x0, y0, z] = r.axes.map(|a| d.dot(a.as_dvec3()));
        // ∬ z dx dy/(x² + y² + z²)^(3/2) over [0, x] × [0, y].
        let part = |x: f64, y: f64| (x * y / (z.abs() * (x * x + y * y + z * z).sqrt())).atan();
        let (x1, y1) = (x0 + x, y0 + y);
        part(x1, y1) - part(x0, y1) - part(x1, y0) + part(x0, y0)
    }

    const VIEWS: [Vec3; 7] = [
        Vec3::new(278.0, 0.0, 279.0),
        Vec3::new(0.0, 300.0, 0.0),
        Vec3::new(250.0, 555.0, 200.0), // on the ceiling, 1 above the lamp
        Vec3::new(400.0, 555.0, 300.0),
        Vec3::new(300.0, 555.0, 60.0),
        Vec3::new(214.0, 553.0, 226.0),
        Vec3::new(450.0, 550.0, 130.0),
    ];

    #[test]
    fn solid_angle_agrees_with_the_closed_form() {
        for from in VIEWS {
            let r = rectangle();
            let got = f64::from(1.0 / SphericalRectangle::new(&r, from).pdf());
            let want = solid_angle(&r, from, 130.0, 105.0);
            let error = (got - want).abs() / want;
            assert!(error < 5e-4, "{from}: {got} {want}: {error:e}");
        }
        let far = Vec3::new(0.0, -1e5, 0.0);
        assert!(!SphericalRectangle::new(&rectangle(), far).exact);
    }

    #[test]
    fn samples_are_uniform_in_solid_angle() {
        const N: usize = 200_000;
        for from in VIEWS {
            let r = rectangle();
            let spherical = SphericalRectangle::new(&r, from);
            assert!(spherical.exact);
            let whole = solid_angle(&r, from, 130.0, 105.0);
            let mut random = Stream::new(11);
            // Compares the share of samples below each of 7 × 7 points with the exact share.
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
                    // Five standard deviations, over 343 tests.
                    let bound = 5.0 * (p * (1.0 - p) / N as f64).sqrt() + 1e-5;
                    assert!((got - p).abs() < bound, "{from} ({u}, {v}): {got} {p}");
                }
            }
        }
    }
}
