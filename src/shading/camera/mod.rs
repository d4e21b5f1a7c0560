//! The thin-lens camera.

use glam::{DVec3, Vec3};

mod file;
mod filter;

pub use self::file::CameraFile;
pub(crate) use self::filter::FilterTable;
pub use self::filter::PixelFilter;
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::math::precise::tan_degrees;
use crate::math::warp::uniform_disk;
use crate::math::{Real, Vector, dot, normalize};
use crate::sampler::{Dimension, Randoms};

/// A checked camera with an orthonormal frame, in f64.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Centre of the lens.
    pub(crate) look_from: DVec3,
    /// Unit vectors to the right, up and backward, orthogonal to each other.
    pub(crate) frame: [DVec3; 3],
    /// The projection and its size.
    pub(crate) projection: Projection,
    /// Apex angle of the cone from a point in focus to the lens, in degrees.
    pub(crate) defocus_angle: f64,
    /// Distance of the plane in focus.
    pub(crate) focus_distance: f64,
    /// Times at which the shutter opens and closes.
    pub(crate) shutter: (f32, f32),
    /// The filter of the pixels.
    pub(crate) filter: PixelFilter,
}

/// How a camera projects points onto its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Projection {
    /// Towards the camera, with this full vertical angle of view in degrees.
    Perspective(f64),
    /// In parallel. The view has this height.
    Parallel(f64),
}

/// A camera for one image size, which generates rays. Its values are rounded once, from f64.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraFrame {
    pub(crate) origin: Vec3,
    /// Vector from the lens's centre to the upper left corner of the image, in the plane of focus, or
    /// for parallel rays in the plane of the lens.
    pub(crate) corner: Vec3,
    /// Vectors from a pixel to its neighbours on the right and below, in the plane of focus.
    pub(crate) pixel_steps: (Vec3, Vec3),
    /// The lens's semi-axes; `None` for a pinhole.
    pub(crate) lens: Option<(Vec3, Vec3)>,
    /// Unit vector along the direction of view.
    forward: Vec3,
    /// Direction of all rays, if they are parallel.
    parallel: Option<Vec3>,
    shutter_open: f32,
    shutter_duration: f32,
    /// The table of the pixel filter; `None` for the box.
    filter: Option<FilterTable>,
}

impl TryFrom<&CameraFile> for Camera {
    type Error = Error;

    /// # Errors
    /// If a parameter is out of range: an [`Error::Input`] that names the first such parameter.
    fn try_from(camera: &CameraFile) -> Result<Self> {
        Self::new(&Location { file: "scene", place: String::new(), kind: "camera" }, camera)
    }
}

impl Camera {
    /// Checks `camera`, the element `e` of a scene file.
    pub(crate) fn new(e: &Location<'_>, camera: &CameraFile) -> Result<Self> {
        let from = e.point("look_from", camera.look_from)?.as_dvec3();
        let at = e.point("look_at", camera.look_at)?.as_dvec3();
        let up = e.point("up", camera.up)?.as_dvec3();
        let (vfov, defocus) = (camera.vfov, camera.defocus_angle);
        let projection = match camera.parallel {
            None => {
                e.check(vfov > 0.0 && vfov < 180.0, "vfov", "in (0, 180) degrees", vfov)?;
                Projection::Perspective(vfov.into())
            }
            Some(height) => {
                let ok = height > 0.0 && height <= MAX_COORDINATE;
                e.check(ok, "parallel", "above 0 and at most 1e9", height)?;
                e.check(defocus == 0.0, "defocus_angle", "0 for parallel rays", defocus)?;
                Projection::Parallel(height.into())
            }
        };
        let defocus_ok = (0.0..180.0).contains(&defocus);
        e.check(defocus_ok, "defocus_angle", "in [0, 180) degrees", defocus)?;
        let focus = camera.focus_distance;
        let focus_ok = focus > 0.0 && focus <= MAX_COORDINATE;
        e.check(focus_ok, "focus_distance", "above 0 and at most 1e9", focus)?;
        let (open, close) = camera.shutter;
        let shutter_ok = (0.0..=close).contains(&open) && close <= 1.0;
        e.check(shutter_ok, "shutter", "two times with 0 <= open <= close <= 1", (open, close))?;
        camera.filter.check(e)?;
        let unit = |v: DVec3| v / v.dot(v).sqrt();
        let back = unit(from - at);
        if !back.is_finite() {
            return Err(e.error("look_from and look_at must differ, or there is no view direction"));
        }
        let right = up.cross(back);
        if !(right.dot(right) > 1e-12 * up.dot(up)) {
            return Err(e.error("up must not be zero or parallel to the view direction"));
        }
        let right = unit(right);
        let up = back.cross(right);
        Ok(Self {
            look_from: from,
            frame: [if camera.mirrored { -right } else { right }, up, back],
            projection,
            defocus_angle: f64::from(defocus),
            focus_distance: f64::from(focus),
            shutter: camera.shutter,
            filter: camera.filter,
        })
    }

    /// The camera of an image of `width × height` pixels.
    pub(crate) fn frame(&self, width: u32, height: u32) -> CameraFrame {
        let [right, up, back] = self.frame;
        let (width, height) = (f64::from(width), f64::from(height));
        let (image_height, distance) = match self.projection {
            Projection::Perspective(vfov) => {
                (2.0 * tan_degrees(vfov / 2.0) * self.focus_distance, self.focus_distance)
            }
            Projection::Parallel(height) => (height, 0.0),
        };
        let image_width = image_height * width / height;
        let corner = up * (image_height / 2.0) - right * (image_width / 2.0) - back * distance;
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
            forward: -back.as_vec3(),
            parallel: matches!(self.projection, Projection::Parallel(_)).then(|| -back.as_vec3()),
            shutter_open: self.shutter.0,
            shutter_duration: self.shutter.1 - self.shutter.0,
            filter: FilterTable::new(&self.filter),
        }
    }

    /// All numbers that the camera's rays depend on besides the filter, for the scene's hash.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        let Self { look_from, frame: [right, up, back], shutter: (open, close), .. } = *self;
        let vectors = [look_from, right, up, back].into_iter().flat_map(|v| v.to_array());
        // A negative number is the height of a parallel projection.
        let size = match self.projection {
            Projection::Perspective(vfov) => vfov,
            Projection::Parallel(height) => -height,
        };
        let rest = [size, self.defocus_angle, self.focus_distance, open.into(), close.into()];
        vectors.chain(rest)
    }

    /// Times at which the shutter opens and closes.
    pub fn shutter(&self) -> (f32, f32) {
        self.shutter
    }
}

impl CameraFrame {
    /// Whether samples have weights other than 1.
    pub(crate) fn is_weighted(&self) -> bool {
        self.filter.is_some()
    }

    /// Whether rays start at the lens, and pixels have a box as their filter.
    pub(crate) fn is_plain(&self) -> bool {
        self.filter.is_none() && self.parallel.is_none()
    }

    /// The ray through the middle of the image from the middle of the lens, when the shutter opens.
    pub(crate) fn middle(&self) -> Ray {
        Ray { origin: self.origin, direction: self.forward, time: self.shutter_open }
    }

    /// The middle of the lens.
    pub(crate) fn eye(&self) -> Vec3 {
        self.origin
    }

    /// The direction of the ray from the middle of the lens through the point `(x, y)` of the image, in pixels.
    pub(crate) fn toward(&self, x: f32, y: f32) -> Vec3 {
        self.ray_through::<f32, false>(x, y, Vec3::ZERO, 0.0).direction
    }

    /// Where the middle of the lens sees `point`, in pixels of the image, which may be outside it; `None` for points
    /// that are not in front of it.
    #[inline]
    pub(crate) fn project(&self, point: Vec3) -> Option<(f32, f32)> {
        let at = point - self.origin;
        let in_plane = match self.parallel {
            Some(_) => at,
            None => {
                let depth = dot(at, self.forward);
                if !(depth > 0.0) {
                    return None;
                }
                at * (dot(self.corner, self.forward) / depth)
            }
        };
        let (right, down) = self.pixel_steps;
        let along = |step: Vec3| dot(in_plane - self.corner, step) / dot(step, step);
        Some((along(right), along(down)))
    }

    /// Distance of a point from the camera along the direction of view.
    #[inline(always)]
    pub(crate) fn depth<R: Real>(&self, point: R::Vec3) -> R {
        dot(point - R::Vec3::splat(self.origin), R::Vec3::splat(self.forward))
    }

    /// A random ray for pixel `(x, y)`, with a direction of unit length, and its weight: the value
    /// of the pixel filter divided by the density. The weight is 1 with the box, and may be
    /// negative with other filters. `PLAIN` may be set if [`CameraFrame::is_plain`]; it affects only speed.
    #[inline(always)]
    pub(crate) fn ray<R: Real, const PLAIN: bool>(
        &self,
        x: R,
        y: R,
        randoms: &Randoms<R>,
    ) -> (Ray<R>, R) {
        let (mut dx, mut dy) = randoms.two(Dimension::PIXEL);
        let mut weight = R::ONE;
        if !PLAIN && let Some(filter) = &self.filter {
            let (across, down) = (filter.sample(dx), filter.sample(dy));
            (dx, dy, weight) = (across.0, down.0, across.1 * down.1);
        }
        let lens = match self.lens {
            None => R::Vec3::zero(),
            Some((u, v)) => {
                let (a, b) = randoms.two(Dimension::LENS);
                let (a, b) = uniform_disk(a, b);
                vector::<R>(u) * a + vector::<R>(v) * b
            }
        };
        let time = randoms.one(Dimension::TIME);
        (self.ray_through::<R, PLAIN>(x + dx, y + dy, lens, time), weight)
    }

    /// The ray through the point `(x, y)` of the image, in pixels, and the point of the lens at
    /// offset `lens` from its centre. `time` in [0, 1] runs from the opening of the shutter to its
    /// closing.
    #[inline(always)]
    fn ray_through<R: Real, const PLAIN: bool>(
        &self,
        x: R,
        y: R,
        lens: R::Vec3,
        time: R,
    ) -> Ray<R> {
        let (right, down) = self.pixel_steps;
        let target = vector::<R>(self.corner) + vector::<R>(right) * x + vector::<R>(down) * y;
        let (origin, direction) = match self.parallel {
            Some(direction) if !PLAIN => {
                (vector::<R>(self.origin) + target, vector::<R>(direction))
            }
            _ => (vector::<R>(self.origin) + lens, normalize(target - lens)),
        };
        Ray { origin, direction, time: time * self.shutter_duration + R::splat(self.shutter_open) }
    }
}

#[inline(always)]
fn vector<R: Real>(v: Vec3) -> R::Vec3 {
    <R::Vec3 as Vector>::splat(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            look_from: DVec3::new(0.0, 0.0, 5.0),
            frame: [DVec3::X, DVec3::Y, DVec3::Z],
            projection: Projection::Perspective(90.0),
            defocus_angle: 0.0,
            focus_distance: 2.0,
            shutter: (0.25, 0.75),
            filter: PixelFilter::Box,
        }
    }

    #[test]
    fn corners_of_the_image_are_at_the_angle_of_view() {
        let frame = camera().frame(200, 100);
        let upper_left: Ray = frame.ray_through::<f32, false>(0.0, 0.0, Vec3::ZERO, 0.0);
        assert!(
            (upper_left.direction - normalize(Vec3::new(-2.0, 1.0, -1.0))).length_squared() < 1e-12
        );
        assert_eq!(upper_left.time, 0.25);
        let middle: Ray = frame.ray_through::<f32, false>(100.0, 50.0, Vec3::ZERO, 0.5);
        assert!((middle.direction - Vec3::NEG_Z).length_squared() < 1e-12);
        assert_eq!((middle.origin, middle.time), (Vec3::Z * 5.0, 0.5));
    }

    #[test]
    fn points_are_seen_where_their_rays_begin() {
        for projection in [Projection::Perspective(70.0), Projection::Parallel(3.0)] {
            let frame = Camera { projection, ..camera() }.frame(64, 32);
            for (x, y) in [(3.25, 30.5), (63.0, 0.5), (-9.0, 40.0)] {
                let ray: Ray = frame.ray_through::<f32, false>(x, y, Vec3::ZERO, 0.0);
                let seen = frame.project(ray.origin + ray.direction * 7.5).unwrap();
                assert!((seen.0 - x).abs() + (seen.1 - y).abs() < 1e-3, "{seen:?} ({x}, {y})");
            }
        }
        assert_eq!(camera().frame(64, 32).project(Vec3::Z * 6.0), None);
    }

    #[test]
    fn rays_through_the_lens_meet_in_the_plane_of_focus() {
        let frame = Camera { defocus_angle: 20.0, ..camera() }.frame(64, 64);
        let mut origins = Vec::new();
        for i in 0..16u8 {
            let (a, b) = uniform_disk(f32::from(i) / 16.0, f32::from(i * 7 % 16) / 16.0);
            let (u, v) = frame.lens.unwrap();
            let ray: Ray = frame.ray_through::<f32, false>(10.5, 20.5, u * a + v * b, 0.0);
            let focus = ray.origin + ray.direction * ((3.0 - ray.origin.z) / ray.direction.z);
            let pinhole: Ray =
                camera().frame(64, 64).ray_through::<f32, false>(10.5, 20.5, Vec3::ZERO, 0.0);
            let want = pinhole.origin + pinhole.direction * (-2.0 / pinhole.direction.z);
            assert!((focus - want).length_squared() < 1e-10, "{focus} {want}");
            origins.push(ray.origin);
        }
        let radius = 2.0 * tan_degrees(10.0) as f32;
        assert!(origins.iter().all(|o| (*o - Vec3::Z * 5.0).length_squared() <= radius * radius));
        assert!(origins.iter().any(|o| *o != origins[0]));
    }
}
