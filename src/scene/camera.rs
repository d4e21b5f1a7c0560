//! The thin-lens camera.

use glam::{DVec3, Vec3};

use crate::geometry::Ray;
use crate::math::normalize;
use crate::math::precise::tan_degrees;
use crate::math::warp::uniform_disk;

/// A camera whose frame is orthonormal, in f64 as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Centre of the lens.
    pub(super) look_from: DVec3,
    /// Right, up and backward, orthonormal.
    pub(super) frame: [DVec3; 3],
    /// Full vertical angle of view in degrees.
    pub(super) vfov: f64,
    /// Apex angle of the cone from a point in focus to the lens, in degrees.
    pub(super) defocus_angle: f64,
    /// Distance of the plane in focus.
    pub(super) focus_distance: f64,
    /// Times at which the shutter opens and closes.
    pub(super) shutter: (f32, f32),
}

/// Random numbers of one camera ray, each in `[0, 1)`.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Position in the pixel's square.
    pub pixel: (f32, f32),
    /// Position on the lens.
    pub lens: (f32, f32),
    /// Moment of the shutter.
    pub time: f32,
}

/// A camera with an image size: makes rays. Rounded once from f64.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFrame {
    pub(crate) origin: Vec3,
    /// From the lens's centre to the upper left corner of the image in the plane of focus.
    pub(crate) corner: Vec3,
    /// One pixel to the right, one pixel down.
    pub(crate) pixel_steps: (Vec3, Vec3),
    /// The lens's semi-axes; `None` for a pinhole.
    pub(crate) lens: Option<(Vec3, Vec3)>,
    pub(crate) shutter_open: f32,
    pub(crate) shutter_duration: f32,
}

impl Camera {
    /// The camera of an image of `width × height` pixels.
    pub fn frame(&self, width: u32, height: u32) -> CameraFrame {
        let [right, up, back] = self.frame;
        let (width, height) = (f64::from(width), f64::from(height));
        let image_height = 2.0 * tan_degrees(self.vfov / 2.0) * self.focus_distance;
        let image_width = image_height * width / height;
        let corner =
            up * (image_height / 2.0) - right * (image_width / 2.0) - back * self.focus_distance;
        let lens_radius = self.focus_distance * tan_degrees(self.defocus_angle / 2.0);
        CameraFrame {
            origin: self.look_from.as_vec3(),
            corner: corner.as_vec3(),
            pixel_steps: (
                (right * (image_width / width)).as_vec3(),
                (up * (-image_height / height)).as_vec3(),
            ),
            lens: (lens_radius > 0.0)
                .then(|| ((right * lens_radius).as_vec3(), (up * lens_radius).as_vec3())),
            shutter_open: self.shutter.0,
            shutter_duration: self.shutter.1 - self.shutter.0,
        }
    }

    /// Times at which the shutter opens and closes.
    pub fn shutter(&self) -> (f32, f32) {
        self.shutter
    }
}

impl CameraFrame {
    /// The ray through pixel `(x, y)` that `sample` chooses; its direction is of unit length.
    #[inline]
    pub fn ray(&self, x: u32, y: u32, sample: CameraSample) -> Ray {
        let (right, down) = self.pixel_steps;
        let target =
            self.corner + right * (x as f32 + sample.pixel.0) + down * (y as f32 + sample.pixel.1);
        let lens = match self.lens {
            None => Vec3::ZERO,
            Some((u, v)) => {
                let (a, b) = uniform_disk(sample.lens.0, sample.lens.1);
                u * a + v * b
            }
        };
        Ray {
            origin: self.origin + lens,
            direction: normalize(target - lens),
            time: self.shutter_open + self.shutter_duration * sample.time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            look_from: DVec3::new(0.0, 0.0, 5.0),
            frame: [DVec3::X, DVec3::Y, DVec3::Z],
            vfov: 90.0,
            defocus_angle: 0.0,
            focus_distance: 2.0,
            shutter: (0.25, 0.75),
        }
    }

    fn sample(pixel: (f32, f32), lens: (f32, f32), time: f32) -> CameraSample {
        CameraSample { pixel, lens, time }
    }

    #[test]
    fn corners_of_the_image_are_at_the_angle_of_view() {
        let frame = camera().frame(200, 100);
        let upper_left = frame.ray(0, 0, sample((0.0, 0.0), (0.0, 0.0), 0.0));
        assert!(
            (upper_left.direction - normalize(Vec3::new(-2.0, 1.0, -1.0))).length_squared() < 1e-12
        );
        assert_eq!(upper_left.time, 0.25);
        let middle = frame.ray(100, 50, sample((0.0, 0.0), (0.5, 0.5), 0.5));
        assert!((middle.direction - Vec3::NEG_Z).length_squared() < 1e-12);
        assert_eq!((middle.origin, middle.time), (Vec3::Z * 5.0, 0.5));
    }

    #[test]
    fn rays_through_the_lens_meet_in_the_plane_of_focus() {
        let frame = Camera { defocus_angle: 20.0, ..camera() }.frame(64, 64);
        let mut origins = Vec::new();
        for i in 0..16u8 {
            let lens = (f32::from(i) / 16.0, f32::from(i * 7 % 16) / 16.0);
            let ray = frame.ray(10, 20, sample((0.5, 0.5), lens, 0.0));
            let focus = ray.origin + ray.direction * ((3.0 - ray.origin.z) / ray.direction.z);
            let pinhole = camera().frame(64, 64).ray(10, 20, sample((0.5, 0.5), (0.0, 0.0), 0.0));
            let want = pinhole.origin + pinhole.direction * (-2.0 / pinhole.direction.z);
            assert!((focus - want).length_squared() < 1e-10, "{focus} {want}");
            origins.push(ray.origin);
        }
        let radius = 2.0 * tan_degrees(10.0) as f32;
        assert!(origins.iter().all(|o| (*o - Vec3::Z * 5.0).length_squared() <= radius * radius));
        assert!(origins.iter().any(|o| *o != origins[0]));
    }
}
