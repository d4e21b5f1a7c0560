//! Boxes of six quads.

use serde::{Deserialize, Serialize};

use super::{Builder, Expand};
use crate::checks::Location;
use crate::error::Result;
use crate::math::precise::{rotate, turns};

/// A box of six quads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Lower corner before rotation.
    pub min: [f32; 3],
    /// Upper corner before rotation.
    pub max: [f32; 3],
    /// Right-handed rotation in degrees about x, then y, then z, through the middle of the box.
    #[serde(default)]
    pub rotation: [f32; 3],
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
}

impl Expand for BoxFile {
    fn material(&self) -> Option<&str> {
        Some(&self.material)
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        e.bounds(self.min, self.max)?;
        e.rotation(self.rotation)?;
        to.room(e, 6)?;
        faces(self.min, self.max, self.rotation).into_iter().try_for_each(|face| to.quad(e, face))
    }
}

/// Corner and edges of a quad.
type Face = [[f32; 3]; 3];

/// Returns the six faces of the box from `min` to `max`, rotated about its middle by `rotation`
/// degrees about x, then y, then z. They are computed in f64 and rounded once.
fn faces(min: [f32; 3], max: [f32; 3], rotation: [f32; 3]) -> [Face; 6] {
    let (min, max) = (min.map(f64::from), max.map(f64::from));
    let middle: [f64; 3] = std::array::from_fn(|i| (min[i] + max[i]) * 0.5);
    let turns = turns(rotation);
    let turn = |p: [f64; 3]| rotate(p, turns);
    let transformed = |p: [f64; 3]| {
        let turned = turn(std::array::from_fn(|i| p[i] - middle[i]));
        std::array::from_fn(|i| (turned[i] + middle[i]) as f32)
    };
    let edge = |i: usize| {
        let mut e = [0.0; 3];
        e[i] = max[i] - min[i];
        turn(e).map(|c| c as f32)
    };
    let (near, far): ([f32; 3], [f32; 3]) = (transformed(min), transformed(max));
    let [x, y, z] = [edge(0), edge(1), edge(2)];
    let negative = |e: [f32; 3]| e.map(|c| -c);
    let mut faces = [[near, x, y]; 6];
    for (i, (a, b)) in [(x, y), (y, z), (x, z)].into_iter().enumerate() {
        faces[2 * i] = [near, a, b];
        faces[2 * i + 1] = [far, negative(a), negative(b)];
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_y_takes_z_to_x() {
        let faces = faces([0.0; 3], [2.0, 4.0, 6.0], [0.0, 90.0, 0.0]);
        // The middle is (1, 2, 3). The lower corner moves to (1 − 3, 0, 3 + 1).
        assert_eq!(faces[0][0], [-2.0, 0.0, 4.0]);
        assert_eq!(faces[0][1], [0.0, 0.0, -2.0], "x becomes −z");
        assert_eq!(faces[2][2], [6.0, 0.0, 0.0], "z becomes x");
    }

    #[test]
    fn every_face_lies_on_the_surface() {
        for [q, u, v] in faces([1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0; 3]) {
            for i in 0..3 {
                for corner in [q[i], q[i] + u[i], q[i] + v[i], q[i] + u[i] + v[i]] {
                    assert!(corner == [1.0, 2.0, 3.0][i] || corner == [2.0, 4.0, 6.0][i]);
                }
            }
        }
    }
}
