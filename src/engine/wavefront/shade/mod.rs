//! Shade: one kernel per shape and kind of material, which loops over the paths that have hit them.

mod bodies;
mod direct;
mod emit;
mod first_hits;
mod scatter;
mod vertex;

use self::scatter::{COLORED, GENERAL, PLAIN};
use super::layer_samples::LayerSamples;
use super::order::Next;
use super::{Cells, Paths, Queue, Queues, Shadows};
use crate::engine::{Endings, ImageSettings, StageWork, Survival};
use crate::geometry::Shape;
use crate::scene::Scene;
use crate::shading::material::{MaterialModel, MaterialTable, MaterialVisitor};
use crate::shading::{CameraFrame, Key, SceneTables};
use crate::simd::LANES;

/// The inputs that all paths of a segment share.
#[derive(Clone, Copy)]
pub(super) struct ShadeInputs<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a ImageSettings,
    pub(super) survival: Survival,
    pub(super) camera: &'a CameraFrame,
    pub(super) tables: &'a SceneTables,
    pub(super) cells: &'a Cells,
    /// Number of the segment that was traced, from 1.
    pub(super) segment: u32,
}

/// The outputs of shading.
pub(super) struct ShadeOutputs<'a> {
    pub(super) paths: &'a mut Paths,
    /// The paths that continue.
    pub(super) next: &'a mut Next,
    /// Shadow rays, with the light that they may add.
    pub(super) shadows: &'a mut Shadows,
    pub(super) layers: &'a mut LayerSamples,
    /// Counts of the paths that ended.
    pub(super) endings: &'a mut Endings,
}

impl ShadeInputs<'_> {
    /// Shades all queues. Returns the numbers of paths and lanes, without the queues whose paths
    /// were only ended at the depth limit.
    #[inline(never)]
    pub(super) fn shade(&self, queues: &Queues, shaded: &mut ShadeOutputs<'_>) -> StageWork {
        shaded.next.clear();
        shaded.shadows.clear();
        let (mut paths, mut lanes) = (0, 0);
        let layered = shaded.layers.is_pending(self.segment);
        for (&key, queue) in self.tables.looks.keys().iter().zip(queues.iter()) {
            if !self.tables.bodies.are_clear() {
                self.absorb(queue, shaded.paths);
            }
            let in_scatter = matches!(key, Key::Surface { .. }) && shaded.layers.need_surfaces;
            if layered && !in_scatter {
                self.first_hits(key, queue, shaded.paths, shaded.layers);
            }
            let done = match key {
                Key::Background => {
                    self.background(queue, shaded);
                    true
                }
                Key::Medium if self.ends_by_depth(queue, shaded) => false,
                Key::Medium => {
                    self.scatter_in_media(queue, shaded);
                    true
                }
                Key::Surface { shape, kind, emits, .. } => {
                    let layered = layered && in_scatter;
                    let visitor =
                        ShadeSurfaces { shading: self, shape, emits, queue, layered, shaded };
                    self.tables.materials.visit(kind, visitor)
                }
            };
            if done {
                paths += queue.len();
                lanes += queue.len().next_multiple_of(LANES);
            }
        }
        StageWork::in_lanes(paths, lanes)
    }

    /// Returns whether the depth limit ends the paths of `queue` here, and counts them if so. Rays
    /// beyond the limit are not traced, so scattering would be useless.
    fn ends_by_depth(&self, queue: Queue<'_>, shaded: &mut ShadeOutputs<'_>) -> bool {
        let ends = self.segment == self.settings.depth;
        if ends {
            shaded.endings.depth += queue.len() as u64;
        }
        ends
    }
}

/// Shades the paths of `queue`, which have hit surfaces of one shape and one kind of material.
struct ShadeSurfaces<'s, 'a> {
    shading: &'s ShadeInputs<'s>,
    shape: Shape,
    emits: bool,
    queue: Queue<'s>,
    /// Whether layers need first hits.
    layered: bool,
    shaded: &'s mut ShadeOutputs<'a>,
}

impl MaterialVisitor for ShadeSurfaces<'_, '_> {
    /// False if the paths were only ended at the depth limit.
    type Output = bool;

    #[inline(always)]
    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> bool {
        let Self { shading, shape, emits, queue, layered, shaded } = self;
        if emits {
            shading.emit(shape, &table.emission_rows, queue, shaded);
        }
        if layered {
            shading.first_hits_on::<M>(table, shape, queue, shaded.paths, shaded.layers);
        }
        if M::SCATTERS {
            if shading.ends_by_depth(queue, shaded) {
                return emits || layered;
            }
        } else {
            shaded.endings.light += queue.len() as u64;
            return true;
        }
        if M::LARGE
            || shape == Shape::Instance
            || !table.normals.is_empty()
            || !shading.tables.bodies.are_clear()
        {
            shading.scatter::<M, GENERAL>(table, shape, queue, shaded);
        } else if M::TEXTURED && table.textured {
            shading.scatter::<M, COLORED>(table, shape, queue, shaded);
        } else {
            shading.scatter::<M, PLAIN>(table, shape, queue, shaded);
        }
        true
    }
}
