//! The path of a pixel, as a page shows it.

use glam::Vec3;

use super::message::Traced;
use crate::cli::path::{arriving, describe};
use crate::engine::{ImageSettings, PathRecorder, PreparedScene, RayKind, TracedPath, TracedRay};
use crate::error::Result;
use crate::geometry::Ray;
use crate::shading::CameraFrame;

/// How far rays go that leave the scene, in distances from the camera to the first hit.
const FAR: f32 = 10.0;

/// Traces the first sample of the pixel at this place of the picture, in shares of its width and height.
///
/// # Errors
/// Those of [`PathRecorder::new`].
pub(super) fn trace(
    prepared: &PreparedScene,
    settings: ImageSettings,
    (x, y): (f32, f32),
) -> Result<Traced> {
    let ImageSettings { width, height, .. } = settings;
    let pixel = |share: f32, side: u32| ((share * side as f32) as u32).min(side - 1);
    let scene = prepared.scene();
    let frame = settings.camera(scene).frame(width, height);
    let recorder = PathRecorder::new(prepared.clone(), settings)?;
    let TracedPath { rays, radiance } = recorder.trace(pixel(x, width), pixel(y, height), 0);
    let lines = rays.iter().map(|ray| describe(scene, ray));
    let lines = lines.chain([arriving(radiance)]).collect();
    let first = rays.first().and_then(|ray| ray.hit).map_or(1.0, |hit| hit.t);
    let seen = |ray: &TracedRay| {
        let ends = drawn(&frame, ray, FAR * first)?;
        let [width, height] = [width, height].map(|side| side as f32);
        let [a, b, c, d] = ends;
        Some((ray.kind == RayKind::Shadow, [a / width, b / height, c / width, d / height]))
    };
    Ok(Traced { lines, rays: rays.iter().filter_map(seen).collect() })
}

/// Where the camera sees both ends of a ray, in pixels; `None` if it does not see one.
fn drawn(frame: &CameraFrame, ray: &TracedRay, far: f32) -> Option<[f32; 4]> {
    let TracedRay { kind, ray: Ray { origin, direction, .. }, t_max, hit, collision, .. } = *ray;
    let length = match (kind, collision, hit) {
        (RayKind::Shadow, ..) => t_max.clamp(0.0, far),
        (_, Some(t), _) => t,
        (_, None, Some(hit)) => hit.t,
        (_, None, None) => far,
    };
    let end: Vec3 = origin + direction * length;
    // The camera itself is nowhere in the picture: its rays are seen as points.
    let begin = if kind == RayKind::Primary { end } else { origin };
    let ((a, b), (c, d)) = (frame.project(begin)?, frame.project(end)?);
    Some([a, b, c, d])
}
