//! Instances: meshes that are placed any number of times.

mod placement;

use glam::{DMat3, DVec3, Vec3};

pub(super) use self::placement::Placement;
pub(crate) use self::placement::ToObject;
use super::{Bounds, Triangles};
use crate::math::{Row, UNIT_ROUNDOFF, row};

/// Largest condition number of the matrix of an instance.
const MAX_CONDITION: f64 = 1e4;
/// Range of the sums of magnitudes in the rows and columns of the matrix and of its inverse.
const MAX_SCALE: f64 = 1e9;

/// A mesh placed by an affine map.
///
/// The map from world to object space takes a point p to L (p − c). Its numbers decide hits, so the
/// instance is where they place it. The map from object to world space takes a point q to A q + c,
/// where A is the inverse of L up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The rows of L, each with a coordinate of c.
    to_object: [Row; 3],
    /// The rows of A. The numbers beside them are the two constants of [`Placement::surface`] and
    /// the index of the mesh.
    to_world: [Row; 3],
}

/// The sum of magnitudes in a row or column.
fn sum(v: DVec3) -> f64 {
    v.abs().element_sum()
}

/// The largest sum of magnitudes in a row of the product of two matrices, whose entries are replaced
/// by their magnitudes.
fn condition(a: DMat3, b: DMat3) -> f64 {
    let magnitudes = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    (magnitudes(a) * magnitudes(b) * DVec3::ONE).max_element()
}

impl Instance {
    /// Places the mesh with index `mesh` by `matrix`, which has the rows of the linear part and, in
    /// the last column, the translation.
    ///
    /// # Errors
    /// If the matrix is singular, nearly singular or out of range. The error completes a sentence
    /// that begins with the name of the matrix.
    pub fn new(mesh: u32, matrix: &[[f32; 4]; 3]) -> Result<Self, String> {
        let rows = matrix.map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into()));
        let center = Vec3::from_array(matrix.map(|[.., t]| t));
        let is_finite = rows.iter().all(|row| row.is_finite()) && center.is_finite();
        if !(is_finite && center.abs().max_element() <= 1e9) {
            return Err("must be finite, with a translation within ±1e9".to_owned());
        }
        let to_world = DMat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose();
        let inverse =
            inverse(to_world).ok_or("must not be singular, or it would flatten the mesh")?;
        let columns = inverse.to_cols_array_2d().map(|column| column.map(|x| x as f32));
        let to_object = DMat3::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
        let scales = [to_world, to_world.transpose(), to_object, to_object.transpose()];
        let scale = scales.iter().flat_map(|m| [m.x_axis, m.y_axis, m.z_axis].map(sum));
        let largest = scale.fold(0.0, f64::max);
        if !(largest <= MAX_SCALE) {
            return Err("must scale lengths by 1e-9 to 1e9".to_owned());
        }
        let rounded = self::inverse(to_object).map_or(f64::INFINITY, |a| condition(a, to_object));
        if !(rounded <= MAX_CONDITION) {
            return Err(format!(
                "must have a condition number of at most {MAX_CONDITION}, has {rounded:.0}"
            ));
        }
        let u = f64::from(UNIT_ROUNDOFF);
        let slope = 20.0 * u * condition(to_world, to_object);
        let base = 10.0 * u * f64::from(center.abs().max_element());
        let vector = |v: DVec3| v.as_vec3();
        let l = to_object.transpose();
        let a = to_world.transpose();
        Ok(Self {
            to_object: [
                row(vector(l.x_axis), center.x),
                row(vector(l.y_axis), center.y),
                row(vector(l.z_axis), center.z),
            ],
            to_world: [
                row(vector(a.x_axis), slope as f32),
                row(vector(a.y_axis), base as f32),
                row(vector(a.z_axis), f32::from_bits(mesh)),
            ],
        })
    }

    /// The index of the mesh.
    pub(crate) fn mesh(&self) -> usize {
        self.to_world[2][3] as usize
    }

    pub(crate) fn world_to_object(&self) -> ToObject<f32> {
        let [x, y, z] = self.to_object.map(|[x, y, z, c]| [x, y, z, c].map(f32::from_bits));
        let rows = [x, y, z].map(|[a, b, c, _]| Vec3::new(a, b, c));
        ToObject { rows, center: Vec3::new(x[3], y[3], z[3]) }
    }

    /// The triangles that have an area where the instance places them.
    pub(crate) fn placed(&self, triangles: &Triangles) -> Triangles {
        let mut placed = triangles.clone();
        let (to_world, center) = (self.exact_to_world(), self.world_to_object().center.as_dvec3());
        placed.map_vertices(|vertex| (to_world * vertex.as_dvec3() + center).as_vec3());
        // Normals are mapped by the transpose of L and scaled to unit length; 0 stays 0.
        let to_normals = self.linear().transpose();
        let unit = |v: DVec3| {
            let length = v.dot(v).sqrt();
            if length > 0.0 { (v / length).as_vec3() } else { Vec3::ZERO }
        };
        placed.map_normals(|normal| unit(to_normals * normal.as_dvec3()));
        placed.map_tangents(|tangent| unit(to_world * tangent.as_dvec3()));
        if self.mirrors() {
            // The front is the side from which the vertices are in counter-clockwise order.
            placed.turn_over();
        }
        placed.remove_degenerate();
        placed
    }

    /// The point in world space of a point in object space, rounded once.
    #[cfg(test)]
    fn point(&self, point: Vec3) -> Vec3 {
        let center = self.world_to_object().center.as_dvec3();
        (self.exact_to_world() * point.as_dvec3() + center).as_vec3()
    }

    /// Whether the map turns left hands into right hands.
    fn mirrors(&self) -> bool {
        let DMat3 { x_axis, y_axis, z_axis } = self.linear();
        x_axis.dot(y_axis.cross(z_axis)) < 0.0
    }

    /// L in f64.
    fn linear(&self) -> DMat3 {
        let [x, y, z] = self.world_to_object().rows.map(Vec3::as_dvec3);
        DMat3::from_cols(x, y, z).transpose()
    }

    /// The inverse of L in f64. The map of rays defines the instance, so its inverse tells exactly
    /// where the mesh is.
    fn exact_to_world(&self) -> DMat3 {
        inverse(self.linear()).expect("the condition number was checked")
    }

    /// The factor by which rounding errors of rays grow between the two spaces, at least 1: the
    /// largest sum in a row of |L⁻¹| |L| (Skeel's condition number).
    pub(crate) fn condition(&self) -> f32 {
        condition(self.exact_to_world(), self.linear()) as f32 * (1.0 + 1e-6)
    }

    /// The largest factors by which L and its inverse scale the sum of the magnitudes of a vector's
    /// components.
    pub(crate) fn scales(&self) -> [f32; 2] {
        let largest = |m: DMat3| sum(m.x_axis).max(sum(m.y_axis)).max(sum(m.z_axis)) as f32 * 1.01;
        [largest(self.linear()), largest(self.exact_to_world())]
    }

    /// The numbers of the matrix from object to world space, row by row.
    pub(crate) fn identity(&self) -> [f32; 12] {
        let center = self.world_to_object().center;
        let mut numbers = [0.0; 12];
        for (i, [x, y, z, _]) in self.to_world.into_iter().enumerate() {
            let row = [x, y, z].map(f32::from_bits);
            numbers[4 * i..4 * i + 3].copy_from_slice(&row);
            numbers[4 * i + 3] = center[i];
        }
        numbers
    }

    /// A box in world space that contains the instance of a mesh with the box `object`.
    ///
    /// The ray test shears vertices along the ray. This moves them by up to 10 roundings of the
    /// largest edge E of the box, on any axis of object space. In world space, that is 10 u |A| E.
    /// All other rounding errors grow with the distance of the ray's origin and are covered by the
    /// slack of the box test (`accel/slab.rs`).
    pub(crate) fn bounds(&self, object: Bounds) -> Bounds {
        let a = self.exact_to_world();
        let (low, high) = (object.min.as_dvec3(), object.max.as_dvec3());
        let middle = a * (0.5 * (low + high)) + self.world_to_object().center.as_dvec3();
        let half = 0.5 * (high - low);
        let reach = a.x_axis.abs() * half.x + a.y_axis.abs() * half.y + a.z_axis.abs() * half.z;
        let sheared = 20.0 * f64::from(UNIT_ROUNDOFF) * half.max_element();
        let reach = reach + (a.x_axis.abs() + a.y_axis.abs() + a.z_axis.abs()) * sheared;
        Bounds { min: (middle - reach).as_vec3(), max: (middle + reach).as_vec3() }.widened(1)
    }
}

/// The inverse of a matrix; `None` if it is singular or not finite.
fn inverse(m: DMat3) -> Option<DMat3> {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let rows = [y.cross(z), z.cross(x), x.cross(y)];
    let determinant = x.dot(rows[0]);
    let [a, b, c] = rows.map(|row| row / determinant);
    let inverse = DMat3::from_cols(a, b, c).transpose();
    let exists = determinant != 0.0 && [a, b, c].iter().all(|row| row.is_finite());
    exists.then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_matrices_are_rejected() {
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let with = |row: usize, column: usize, value: f32| {
            let mut matrix = identity;
            matrix[row][column] = value;
            Instance::new(0, &matrix).map(|_| ())
        };
        assert_eq!(with(0, 0, 1.0), Ok(()));
        assert_eq!(with(2, 2, -1e-3), Ok(()), "flat along an axis is well-conditioned");
        for (row, column, value, want) in [
            (1, 1, 0.0, "must not be singular, or it would flatten the mesh"),
            (1, 1, f32::NAN, "must be finite, with a translation within ±1e9"),
            (0, 2, f32::INFINITY, "must be finite, with a translation within ±1e9"),
            (0, 3, 2e9, "must be finite, with a translation within ±1e9"),
            (0, 0, 1e10, "must scale lengths by 1e-9 to 1e9"),
            (0, 0, 1e-10, "must scale lengths by 1e-9 to 1e9"),
            (0, 1, 1e5, "must have a condition number of at most 10000, has 200001"),
        ] {
            assert_eq!(with(row, column, value), Err(want.to_owned()), "{row} {column} {value}");
        }
    }

    #[test]
    fn boxes_contain_the_placed_corners() {
        let matrix = [[0.3, -2.0, 0.1, 7.0], [1.0, 0.2, 0.4, -3.0], [0.0, 0.5, -0.9, 1e3]];
        let instance = Instance::new(0, &matrix).unwrap();
        let object = Bounds { min: Vec3::new(-1.0, 2.0, 0.5), max: Vec3::new(4.0, 2.5, 9.0) };
        let bounds = instance.bounds(object);
        let corner = |i: usize| {
            let side = |axis: usize| if i >> axis & 1 == 1 { object.max } else { object.min };
            instance.point(Vec3::new(side(0).x, side(1).y, side(2).z))
        };
        let corners = Bounds::of((0..8).map(corner));
        assert_eq!(bounds.union(corners), bounds);
        assert!((bounds.max - bounds.min - (corners.max - corners.min)).max_element() < 1e-3);
        assert!(
            instance.mirrors()
                == (DMat3::from_cols_array_2d(
                    &matrix.map(|[x, y, z, _]| [x, y, z].map(f64::from))
                )
                .determinant()
                    < 0.0)
        );
    }
}
