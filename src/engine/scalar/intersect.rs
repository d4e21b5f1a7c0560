//! Ray queries of the path tracing loop.

use crate::accel::{Bvh2, Counters};
use crate::engine::{Stage, StageWork, WaveStats};
use crate::geometry::{Geometry, Hit, Ray};

/// Answers ray queries. Only hits at distances above 0 count.
pub(in crate::engine) trait Intersect {
    /// Returns the closest hit along `ray`, which is segment `segment` of a path.
    fn closest(&mut self, ray: &Ray, segment: u32) -> Option<Hit>;

    /// Returns whether the shadow ray `ray`, from the end of segment `segment`, hits anything
    /// before distance `t_max`.
    fn occluded(&mut self, ray: &Ray, t_max: f32, segment: u32) -> bool;

    /// Returns the closest hit along the part of a shadow ray beyond panes, before distance `t_max`.
    fn closest_before(&mut self, ray: &Ray, t_max: f32, segment: u32) -> Option<Hit>;

    /// Called when the path collides in a medium at distance `t`, before the hit (if any) that the
    /// last call of `closest` returned.
    fn collided(&mut self, _t: f32) {}
}

/// The binary tree over a scene's primitives.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine) struct Tree<'a> {
    pub(in crate::engine) tree: &'a Bvh2,
    pub(in crate::engine) geometry: &'a Geometry,
}

impl Intersect for Tree<'_> {
    fn closest(&mut self, ray: &Ray, _segment: u32) -> Option<Hit> {
        self.tree.closest(self.geometry, ray, 0.0, f32::INFINITY)
    }

    fn closest_before(&mut self, ray: &Ray, t_max: f32, _segment: u32) -> Option<Hit> {
        self.tree.closest(self.geometry, ray, 0.0, t_max)
    }

    fn occluded(&mut self, ray: &Ray, t_max: f32, _segment: u32) -> bool {
        self.tree.occluded(self.geometry, ray, 0.0, t_max)
    }
}

/// A tree that counts its work per segment.
#[derive(Debug)]
pub(super) struct CountingTree<'a> {
    pub(super) tree: Tree<'a>,
    pub(super) stats: WaveStats,
}

impl CountingTree<'_> {
    /// Adds the work for one ray.
    fn note(&mut self, stage: Stage, segment: u32, counters: Counters) {
        let work = StageWork { counters, ..StageWork::in_lanes(1, 1) };
        self.stats.note(stage, segment, &work);
    }
}

impl Intersect for CountingTree<'_> {
    fn closest(&mut self, ray: &Ray, segment: u32) -> Option<Hit> {
        let (Tree { tree, geometry }, mut counters) = (self.tree, Counters::default());
        let hit = tree.count_closest(geometry, ray, 0.0, f32::INFINITY, &mut counters);
        self.note(Stage::Extend, segment, counters);
        hit
    }

    fn closest_before(&mut self, ray: &Ray, t_max: f32, segment: u32) -> Option<Hit> {
        let (Tree { tree, geometry }, mut counters) = (self.tree, Counters::default());
        let hit = tree.count_closest(geometry, ray, 0.0, t_max, &mut counters);
        self.note(Stage::Connect, segment, counters);
        hit
    }

    fn occluded(&mut self, ray: &Ray, t_max: f32, segment: u32) -> bool {
        let (Tree { tree, geometry }, mut counters) = (self.tree, Counters::default());
        let occluded = tree.any_occluded(geometry, 0, ray, (0.0, t_max), &mut counters);
        self.note(Stage::Connect, segment, counters);
        occluded
    }
}
