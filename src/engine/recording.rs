//! The rays of paths, as the reference engine traces them.

use glam::Vec3;

use super::prepared::{PreparedScene, View};
use super::scalar::{Intersect, ScalarEngine, Tree};
use super::settings::RenderSettings;
use crate::error::Result;
use crate::geometry::{Hit, Ray};

/// What a ray is traced for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayKind {
    /// From the camera, for the closest hit.
    Primary,
    /// From a surface or out of a medium, for the closest hit.
    Bounce,
    /// From there to a light, for any hit.
    Shadow,
}

/// A ray and what it hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TracedRay {
    /// What for.
    pub kind: RayKind,
    /// Segment of the path, from 1; of a shadow ray the one that it starts at the end of.
    pub segment: u32,
    /// The ray.
    pub ray: Ray,
    /// Upper end of the open interval of distances that starts at 0.
    pub t_max: f32,
    /// What it hits. A shadow ray's hit is primitive 0 at distance 0 where it is occluded.
    pub hit: Option<Hit>,
    /// Distance of the collision in a medium that ends the segment before that.
    pub collision: Option<f32>,
}

/// A path, and what arrives along it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TracedPath {
    /// In the order in which they are traced.
    pub rays: Vec<TracedRay>,
    /// Neither clamped nor counted as black.
    pub radiance: Vec3,
}

/// Traces paths with the reference engine and tells their rays.
#[derive(Debug)]
pub(crate) struct PathRecorder(ScalarEngine);

impl PathRecorder {
    /// # Errors
    /// Where a setting is out of its range.
    pub(crate) fn new(scene: impl Into<PreparedScene>, settings: RenderSettings) -> Result<Self> {
        settings.check()?;
        Ok(Self(ScalarEngine::new(View::new(scene.into(), settings))))
    }

    /// Sample `sample` of pixel `(x, y)`.
    pub(crate) fn trace(&self, x: u32, y: u32, sample: u32) -> TracedPath {
        let mut tracer = self.0.tracer(Recording { tree: self.0.tree(), rays: Vec::new() });
        let (ray, key) = self.0.camera_ray(x, y, sample);
        let radiance = tracer.radiance(ray, key);
        TracedPath { rays: tracer.intersect.rays, radiance }
    }
}

/// Keeps what it is asked and what it answers.
struct Recording<'a> {
    tree: Tree<'a>,
    rays: Vec<TracedRay>,
}

impl Intersect for Recording<'_> {
    fn closest(&mut self, ray: &Ray, segment: u32) -> Option<Hit> {
        let hit = self.tree.closest(ray, segment);
        let kind = if segment == 1 { RayKind::Primary } else { RayKind::Bounce };
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

    fn collided(&mut self, t: f32) {
        self.rays.last_mut().expect("closest was asked before").collision = Some(t);
    }

    fn occluded(&mut self, ray: &Ray, t_max: f32, segment: u32) -> bool {
        let occluded = self.tree.occluded(ray, t_max, segment);
        let hit = occluded.then_some(Hit { t: 0.0, primitive: 0 });
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
