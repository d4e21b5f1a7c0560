//! Affine maps, as rows in scene files and as columns in those of other programs.

use glam::{DAffine3, DMat3, DVec3};

/// The map with the rows of `matrix`.
pub(crate) fn of_rows(matrix: &[[f32; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::from_array(matrix.map(|row| f64::from(row[i])));
    let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
    DAffine3 { matrix3, translation: column(3) }
}

/// The map with these four columns, whose fourth numbers are left out.
pub(crate) fn of_columns(numbers: &[f64; 16]) -> DAffine3 {
    let column = |i: usize| DVec3::new(numbers[4 * i], numbers[4 * i + 1], numbers[4 * i + 2]);
    let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
    DAffine3 { matrix3, translation: column(3) }
}

/// A point in this direction from `from`, rounded, and so far away that the roundings of both points, which grow with
/// the distance from the origin, hardly change the direction.
pub(crate) fn point_along(from: DVec3, direction: DVec3) -> [f32; 3] {
    let from = from.as_vec3().as_dvec3();
    let most = from.abs().max_element();
    let away = (most + 1.0).min(1e9 - most).max(1.0);
    (from + direction / direction.dot(direction).sqrt() * away).as_vec3().to_array()
}

/// The rows of a map, rounded.
pub(crate) fn rows(map: &DAffine3) -> [[f32; 4]; 3] {
    let DAffine3 { matrix3: DMat3 { x_axis, y_axis, z_axis }, translation } = *map;
    [0, 1, 2].map(|i| [x_axis[i], y_axis[i], z_axis[i], translation[i]].map(|x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Far from the origin, a point one unit away would be rounded to another direction.
    #[test]
    fn points_along_a_direction_keep_it() {
        let direction = DVec3::new(-0.48, 0.6, 0.64);
        for from in [0.0, 3.0, 1e4, 1e6, 9e8] {
            let from = DVec3::new(from, -0.3 * from, from);
            let point = point_along(from, direction * 7.0);
            let along = glam::Vec3::from_array(point).as_dvec3() - from.as_vec3().as_dvec3();
            let off = along.cross(direction).length() / along.length();
            assert!(off < if from.x > 1e8 { 1e-5 } else { 2e-7 }, "{from}: {off}");
            assert!(point.iter().all(|c| c.abs() <= 1e9), "{point:?}");
        }
    }
}
