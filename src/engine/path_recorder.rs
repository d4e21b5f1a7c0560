//! Records the rays of paths as the reference engine traces them.

use std::sync::Arc;

use glam::Vec3;

use super::scalar::{Intersect, ScalarEngine, Tree};
use super::{ComputeSettings, Engine, ImageSettings, Pool, PreparedScene, View};
use crate::error::Result;
use crate::geometry::{Hit, Ray};

/// The purpose of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayKind {
    /// A ray from the camera, traced for the closest hit.
    Primary,
    /// A ray from a surface or from within a medium, traced for the closest hit.
    Bounce,
    /// A ray from a surface or from within a medium to a light, traced for any hit.
    Shadow,
}

/// A ray and its hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TracedRay {
    /// The purpose of the ray.
    pub kind: RayKind,
    /// Segment of the path, from 1. For a shadow ray, the segment at whose end it starts.
    pub segment: u32,
    /// The ray.
    pub ray: Ray,
    /// Upper end of the open interval of distances in which hits count. The lower end is 0.
    pub t_max: f32,
    /// The hit, if any. For an occluded shadow ray it is primitive 0 at distance 0.
    pub hit: Option<Hit>,
    /// If the path collides in a medium before `hit`, the distance of the collision.
    pub collision: Option<f32>,
}

/// A path and the radiance that arrives along it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TracedPath {
    /// The rays in the order in which they were traced.
    pub rays: Vec<TracedRay>,
    /// The radiance before clamping, multiplied by the weight of the pixel filter. It may be
    /// non-finite, and negative for filters with negative lobes.
    pub radiance: Vec3,
}

/// Traces paths with the reference engine and returns their rays.
#[derive(Debug)]
pub(crate) struct PathRecorder(ScalarEngine);

impl PathRecorder {
    /// Creates a recorder of paths in `scene`.
    ///
    /// # Errors
    /// If a setting is out of range, returns [`Error::Usage`](crate::Error::Usage).
    pub(crate) fn new(scene: impl Into<PreparedScene>, settings: ImageSettings) -> Result<Self> {
        let prepared = scene.into();
        settings.check(prepared.scene().limits())?;
        let view = View::new(prepared, settings, ComputeSettings::from(Engine::Scalar));
        Ok(Self(ScalarEngine::new(view.with_survival(&Arc::new(Pool::Caller))?, 1)))
    }

    /// Traces the path of sample `sample` of pixel `(x, y)`.
    pub(crate) fn trace(&self, x: u32, y: u32, sample: u32) -> TracedPath {
        let mut recording = Recording { tree: self.0.tree(), rays: Vec::new() };
        let mut tracer = self.0.tracer(&mut recording);
        let (ray, weight, key) = self.0.camera_ray(x, y, sample);
        let mut values = vec![0.0; self.0.channels()];
        let (radiance, _) = tracer.radiance(ray, key, weight, &mut values);
        TracedPath { rays: recording.rays, radiance }
    }
}

/// Records each ray query together with the tree's answer.
struct Recording<'a> {
    tree: Tree<'a>,
    rays: Vec<TracedRay>,
}

impl Intersect for Recording<'_> {
    fn closest(&mut self, ray: &Ray, segment: u32) -> Option<Hit> {
        let hit = self.tree.closest(ray, segment);
        let first = self.rays.is_empty();
        let kind = if first { RayKind::Primary } else { RayKind::Bounce };
        self.rays.push(TracedRay {
            kind,
            segment,
            ray: *ray,
            t_max: f32::INFINITY,
            hit,
            collision: None,
        });
        hit
    }

    fn closest_before(&mut self, ray: &Ray, t_max: f32, segment: u32) -> Option<Hit> {
        let found = self.tree.closest_before(ray, t_max, segment);
        // As `occluded` records hits.
        let hit = found.map(|_| Hit::of(0, 0.0));
        let (kind, ray, collision) = (RayKind::Shadow, *ray, None);
        self.rays.push(TracedRay { kind, segment, ray, t_max, hit, collision });
        found
    }

    fn collided(&mut self, t: f32) {
        self.rays.last_mut().expect("`closest` recorded the ray").collision = Some(t);
    }

    fn occluded(&mut self, ray: &Ray, t_max: f32, segment: u32) -> bool {
        let occluded = self.tree.occluded(ray, t_max, segment);
        let hit = occluded.then_some(Hit::of(0, 0.0));
        self.rays.push(TracedRay {
            kind: RayKind::Shadow,
            segment,
            ray: *ray,
            t_max,
            hit,
            collision: None,
        });
        occluded
    }
}
