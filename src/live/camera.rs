//! How a viewer moves a camera.

use glam::{DQuat, DVec3};
use serde::Deserialize;

use crate::error::Result;
use crate::math::precise::{exp2, tan_degrees};
use crate::shading::{Camera, CameraFile};

/// The largest angle between the direction of view and the horizon: beyond it, left and right would change places.
const STEEPEST: f64 = 89.5;

/// A movement of a camera. `right`, `up` and `forward` are as the camera sees them.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Move {
    /// Turns the camera about the point that it looks at, by degrees.
    Orbit { right: f64, up: f64 },
    /// Turns the camera about itself, by degrees.
    Look { right: f64, up: f64 },
    /// Moves the camera and the point that it looks at, in heights of the view there.
    Pan { right: f64, up: f64 },
    /// Moves the camera and the point that it looks at, in distances between them.
    Fly { right: f64, up: f64, forward: f64 },
    /// Halves the distance to the point that the camera looks at this many times.
    Dolly { halvings: f64 },
}

/// The camera's directions, and what it looks at.
struct Axes {
    up: DVec3,
    from: DVec3,
    at: DVec3,
}

impl Axes {
    fn of(camera: &CameraFile) -> Self {
        let [up, from, at] =
            [camera.up, camera.look_from, camera.look_at].map(|v| DVec3::from(v.map(f64::from)));
        Self { up: up.normalize_or(DVec3::Y), from, at }
    }

    /// From the camera to what it looks at.
    fn forward(&self) -> DVec3 {
        self.at - self.from
    }

    fn right(&self) -> DVec3 {
        self.forward().cross(self.up).normalize_or(DVec3::X)
    }

    /// Upwards in the image.
    fn upwards(&self) -> DVec3 {
        self.right().cross(self.forward()).normalize_or(self.up)
    }

    /// `forward`, turned by degrees, but not over the poles.
    fn turned(&self, right: f64, up: f64) -> DVec3 {
        let forward = self.forward();
        let height = 90.0 - forward.angle_between(self.up).to_degrees();
        let up = (height + up).clamp(-STEEPEST, STEEPEST) - height;
        let about = DQuat::from_axis_angle(self.up, -right.to_radians());
        about * DQuat::from_axis_angle(self.right(), up.to_radians()) * forward
    }
}

impl Move {
    /// `camera` after this movement.
    ///
    /// # Errors
    /// If the camera would leave the range of scenes.
    pub(crate) fn apply(self, camera: &CameraFile) -> Result<CameraFile> {
        let mut axes = Axes::of(camera);
        let distance = axes.forward().length();
        match self {
            Self::Orbit { right, up } => axes.from = axes.at - axes.turned(-right, -up),
            Self::Look { right, up } => axes.at = axes.from + axes.turned(right, up),
            Self::Pan { right, up } => {
                let height = match camera.parallel {
                    Some(height) => f64::from(height),
                    None => 2.0 * distance * tan_degrees(f64::from(camera.vfov) / 2.0),
                };
                let by = (axes.right() * right + axes.upwards() * up) * height;
                (axes.from, axes.at) = (axes.from + by, axes.at + by);
            }
            Self::Fly { right, up, forward } => {
                let ahead = axes.forward() * forward;
                let by = (axes.right() * right + axes.upwards() * up) * distance + ahead;
                (axes.from, axes.at) = (axes.from + by, axes.at + by);
            }
            Self::Dolly { halvings } => {
                axes.from = axes.at - axes.forward() * exp2(-halvings);
            }
        }
        let [look_from, look_at] = [axes.from, axes.at].map(|v| v.as_vec3().to_array());
        let moved = CameraFile { look_from, look_at, ..camera.clone() };
        Camera::try_from(&moved).map(|_| moved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> CameraFile {
        CameraFile::new([0.0, 0.0, 4.0], [0.0, 0.0, 0.0], 90.0)
    }

    fn moved(by: Move) -> [[f32; 3]; 2] {
        let CameraFile { look_from, look_at, .. } = by.apply(&camera()).unwrap();
        [look_from, look_at]
    }

    fn near(found: [[f32; 3]; 2], right: [[f32; 3]; 2]) {
        let differ =
            found.iter().flatten().zip(right.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-5);
        assert!(!differ, "{found:?} instead of {right:?}");
    }

    #[test]
    fn movements_go_where_they_say() {
        let zero = [0.0; 3];
        near(moved(Move::Orbit { right: 90.0, up: 0.0 }), [[4.0, 0.0, 0.0], zero]);
        let [[_, height, _], _] = moved(Move::Orbit { right: 0.0, up: 30.0 });
        assert!((height - 2.0).abs() < 1e-5, "{height}");
        near(moved(Move::Look { right: 90.0, up: 0.0 }), [[0.0, 0.0, 4.0], [4.0, 0.0, 4.0]]);
        // The view is 8 high at a distance of 4.
        near(moved(Move::Pan { right: 0.5, up: 0.25 }), [[4.0, 2.0, 4.0], [4.0, 2.0, 0.0]]);
        near(
            moved(Move::Fly { right: 0.0, up: 0.0, forward: 0.25 }),
            [[0.0, 0.0, 3.0], [0.0, 0.0, -1.0]],
        );
        near(moved(Move::Dolly { halvings: 2.0 }), [[0.0, 0.0, 1.0], zero]);
    }

    #[test]
    fn the_camera_stays_below_the_pole_and_within_the_scene() {
        let [[x, height, depth], _] = moved(Move::Orbit { right: 0.0, up: 1000.0 });
        assert!(x.abs() < 1e-5 && height > 3.9 && depth > 0.0);
        let far = Move::Dolly { halvings: -40.0 }.apply(&camera());
        assert!(far.is_err() && Move::Dolly { halvings: f64::NAN }.apply(&camera()).is_err());
    }
}
