//! The view of a file without a camera: a camera, and a ground and light if the file has none.

use glam::{DMat3, DVec3, Vec3};

use crate::checks::MAX_COORDINATE;
use crate::geometry::Bounds;
use crate::math::precise::{sin_cos_degrees, unit};
use crate::math::{self, length};
use crate::scene::{QuadFile, SceneFile};
use crate::shading::light::Distant;
use crate::shading::material::Lambertian;
use crate::shading::{Background, CameraFile};

/// Vertical field of view in degrees.
const VFOV: f32 = 35.0;

/// Share of the picture's width or height that the object fills.
const FILLED: f64 = 0.8;

/// The material of the ground.
pub(crate) const GROUND: &str = "ground of the view";

/// The points that the camera must show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) bounds: Bounds,
    /// The axes of the camera: right, up, and back from the object.
    axes: DMat3,
    /// How much the filled part of the picture widens to the right and upwards with the distance.
    slopes: [f64; 2],
    /// The largest of x + sz, −x + sz, y + tz and −y + tz, for points (x, y, z) along the axes and the slopes s and t.
    /// They decide the camera: a side of the view touches the points where one of them is largest.
    reach: [f64; 4],
}

impl Extent {
    /// No points yet, for pictures whose width is `aspect` times their height.
    pub(crate) fn new(aspect: f64) -> Self {
        // From in front, a little from the right and above.
        let back = unit(DVec3::new(0.5, 0.35, 1.0));
        let right = unit(DVec3::Y.cross(back));
        let (sin, cos) = sin_cos_degrees(f64::from(VFOV) * 0.5);
        let up = FILLED * sin / cos;
        Self {
            bounds: Bounds::EMPTY,
            axes: DMat3::from_cols(right, back.cross(right), back),
            slopes: [up * aspect, up],
            reach: [f64::NEG_INFINITY; 4],
        }
    }

    /// Adds points.
    pub(crate) fn add(&mut self, points: impl IntoIterator<Item = Vec3>) {
        let [s, t] = self.slopes;
        let DMat3 { x_axis: right, y_axis: up, z_axis: back } = self.axes;
        let sides = [right + back * s, back * s - right, up + back * t, back * t - up];
        for point in points {
            self.bounds = self.bounds.union(Bounds { min: point, max: point });
            for (reach, side) in self.reach.iter_mut().zip(sides) {
                let along = side.dot(point.as_dvec3());
                *reach = if along > *reach { along } else { *reach };
            }
        }
    }

    /// A camera that shows all points.
    pub(crate) fn camera(&self) -> CameraFile {
        let Bounds { min, max } = self.bounds;
        let [right, left, top, bottom] = self.reach;
        let [s, t] = self.slopes;
        let (x, y) = ((right - left) / 2.0, (top - bottom) / 2.0);
        let (wide, tall) = ((right + left) / (2.0 * s), (top + bottom) / (2.0 * t));
        let mut z = if wide > tall { wide } else { tall };
        let center = ((min + max) * 0.5).as_dvec3();
        let depth = self.axes.z_axis.dot(center);
        if min == max {
            z = depth + 1.0;
        }
        // The middle of the picture, at the depth of the object.
        let [from, at] = [z, depth].map(|z| (self.axes * DVec3::new(x, y, z)).as_vec3().to_array());
        CameraFile::new(from, at, VFOV)
    }

    /// Puts a matte ground under the points, and a soft sky and a soft sun above them. White surfaces stay below 1.
    /// Without `ground`, only the light is added.
    pub(crate) fn add_stage(&self, scene: &mut SceneFile, ground: bool) {
        scene.background = Background::Gradient { bottom: [0.15; 3], top: [0.32, 0.35, 0.38] };
        let direction = [0.7, -0.8, -0.6];
        scene.lights.push(Distant { direction, irradiance: [1.9; 3], angle: 12.0 }.into());
        if !ground {
            return;
        }
        let Bounds { min, max } = self.bounds;
        let size = length(max - min);
        let size = if size > 0.0 { size } else { 2.0 };
        // A little lower, so that it does not hide flat objects.
        let (mut side, y) = (60.0 * size, min.y - 1e-3 * size);
        let center = (min + max) * 0.5;
        // Of objects that reach as far as coordinates may, the ground is smaller, or left out.
        let room = 2.0 * (0.99 * MAX_COORDINATE - math::max(center.x.abs(), center.z.abs()));
        side = math::min(side, room);
        if side < size || -y > MAX_COORDINATE {
            return;
        }
        // Its name must differ from those of the file.
        let material = GROUND.to_owned();
        scene.add_material(material.clone(), Lambertian::new([0.35; 3]));
        scene.add(QuadFile {
            q: [center.x - side / 2.0, y, center.z + side / 2.0],
            u: [side, 0.0, 0.0],
            v: [0.0, 0.0, -side],
            material,
        });
    }
}

/// Turns the z-axis up.
pub(crate) const Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::Camera;

    /// The points touch opposite sides of the filled part, and no side is passed.
    #[test]
    fn objects_fill_four_fifths_of_the_picture() {
        for (stretch, aspect) in
            [([1.0, 1.0, 1.0], 16.0 / 9.0), ([9.0, 1.0, 1.0], 16.0 / 9.0), ([1.0, 9.0, 1.0], 0.5)]
        {
            let corner = |i: u32| {
                let pick = |bit: u32| if i >> bit & 1 == 0 { 100.0f32 } else { 102.0 };
                Vec3::new(pick(0), pick(1), pick(2)) * Vec3::from_array(stretch)
            };
            let mut extent = Extent::new(aspect);
            extent.add((0..8).map(corner));
            let file = extent.camera();
            assert!(Camera::try_from(&file).is_ok());
            let [from, at] = [file.look_from, file.look_at].map(|p| Vec3::from(p).as_dvec3());
            let back = unit(from - at);
            let right = unit(DVec3::Y.cross(back));
            let up = back.cross(right);
            let (sin, cos) = sin_cos_degrees(f64::from(VFOV) / 2.0);
            let tan = sin / cos;
            let [mut wide, mut tall] = [(f64::MAX, f64::MIN); 2];
            for point in (0..8).map(corner) {
                let seen = point.as_dvec3() - from;
                let depth = -seen.dot(back) * tan;
                for (side, axis) in [(&mut wide, right / aspect), (&mut tall, up)] {
                    let place = seen.dot(axis) / depth;
                    *side = (side.0.min(place), side.1.max(place));
                }
            }
            let most = wide.1.max(tall.1);
            assert!((most - 0.8).abs() < 1e-3, "{stretch:?}: {wide:?} {tall:?}");
            for (low, high) in [wide, tall] {
                assert!(low > -0.801 && high < 0.801, "{stretch:?}: {low} {high}");
            }
            let full = if wide.1 > tall.1 { wide } else { tall };
            assert!((full.0 + full.1).abs() < 1e-3, "{full:?}");
        }
    }

    #[test]
    fn a_point_is_seen_from_a_distance() {
        let mut extent = Extent::new(1.0);
        extent.add([Vec3::ONE]);
        assert!(Camera::try_from(&extent.camera()).is_ok());
    }
}
