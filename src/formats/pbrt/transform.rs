//! Transforms of pbrt files.

use glam::{DAffine3, DMat3, DVec3};

use crate::math::affine;
use crate::math::precise::{sin_cos_degrees, unit};

/// The affine map of 16 numbers, column by column.
///
/// # Errors
/// If the map is not affine, or is singular.
pub(crate) fn of_numbers(numbers: &[f64; 16]) -> Result<DAffine3, String> {
    let last = [numbers[3], numbers[7], numbers[11], numbers[15]];
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the transform must be affine, its last row is {last:?}"));
    }
    checked(affine::of_columns(numbers))
}

/// `map`, if it can be inverted.
///
/// # Errors
/// If it cannot.
pub(crate) fn checked(map: DAffine3) -> Result<DAffine3, String> {
    let ok = map.is_finite() && map.matrix3.determinant() != 0.0 && map.inverse().is_finite();
    ok.then_some(map).ok_or_else(|| "the transform is singular or not finite".to_owned())
}

/// A right-handed rotation by an angle in degrees (Rodrigues' formula).
pub(crate) fn rotation(degrees: f64, axis: DVec3) -> DAffine3 {
    let (sin, cos) = sin_cos_degrees(degrees);
    let axis = unit(axis);
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DAffine3::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)))
}

/// From the scene to a camera at `from` that looks at `at`. pbrt's cameras look along +z, and x
/// points to the right.
pub(crate) fn look_at(from: DVec3, at: DVec3, up: DVec3) -> DAffine3 {
    let forward = unit(at - from);
    let right = unit(unit(up).cross(forward));
    let matrix3 = DMat3::from_cols(right, forward.cross(right), forward);
    DAffine3 { matrix3, translation: from }.inverse()
}

/// `point`, rounded.
pub(crate) fn rounded(point: DVec3) -> [f32; 3] {
    point.as_vec3().to_array()
}

/// The scale of a map that keeps shapes; `None` if it does not.
pub(crate) fn uniform_scale(map: &DAffine3) -> Option<f64> {
    let scale = map.matrix3.x_axis.dot(map.matrix3.x_axis).sqrt();
    let turned = map.matrix3 * (1.0 / scale);
    (turned.transpose() * turned).abs_diff_eq(DMat3::IDENTITY, 1e-5).then_some(scale)
}

/// The angle in [0, 180) degrees whose half has this tangent.
pub(crate) fn twice_angle_of(tangent: f64) -> f64 {
    let (mut least, mut most) = (0.0, 180.0);
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        let (sin, cos) = sin_cos_degrees(0.5 * middle);
        if sin < tangent * cos { least = middle } else { most = middle }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_map_points() {
        let quarter = rotation(90.0, DVec3::Z);
        assert!(quarter.transform_point3(DVec3::X).abs_diff_eq(DVec3::Y, 1e-15));
        let camera = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y);
        assert!(camera.transform_point3(DVec3::ZERO).abs_diff_eq(DVec3::Z * 5.0, 1e-15));
        // Looking along -z, x points to the left in pbrt.
        assert!(camera.transform_point3(DVec3::X).abs_diff_eq(DVec3::new(-1.0, 0.0, 5.0), 1e-15));
        assert!((twice_angle_of(1.0) - 90.0).abs() < 1e-12);
        assert_eq!(uniform_scale(&DAffine3::from_scale(DVec3::splat(2.0))), Some(2.0));
        assert_eq!(uniform_scale(&DAffine3::from_scale(DVec3::new(2.0, 2.0, 1.0))), None);
        assert!(of_numbers(&[0.0; 16]).is_err());
    }
}
