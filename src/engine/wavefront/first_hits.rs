//! First hits: writes what layers hold of the surfaces and media that paths meet first.

use glam::Vec3;

use super::material_sort::{Queue, Queues};
use super::paths::Paths;
use super::shade::{ShadeInputs, Vertex};
use crate::engine::first_hit::FirstHit;
use crate::engine::layers::{FirstHits, Layers, LightParts, finite};
use crate::geometry::Shape;
use crate::shading::Key;
use crate::shading::material::{Bsdf, MaterialModel, MaterialTable, MaterialVisitor};
use crate::simd::{Float, LANES, Mask};

/// What layers hold of the paths of a wave. It is empty if there are no layers.
#[derive(Debug)]
pub(super) struct LayerSamples {
    pub(super) layers: Layers,
    capacity: usize,
    /// For each channel, a value per path.
    columns: Vec<f32>,
    /// Paths that have met only surfaces which first hits may follow.
    pending: Vec<bool>,
    /// Paths whose camera rays meet the background.
    background: Vec<bool>,
    /// Radiance of the paths after shading their first segment, and after shading their second.
    radiance: [Vec<Vec3>; 2],
}

impl LayerSamples {
    /// Room for `capacity` paths.
    pub(super) fn new(layers: Layers, capacity: usize) -> Self {
        let capacity = if layers.is_empty() { 0 } else { capacity };
        let columns = vec![0.0; layers.channels() * capacity];
        let [pending, background] = [const { Vec::new() }; 2];
        Self { layers, capacity, columns, pending, background, radiance: Default::default() }
    }

    /// Prepares for `paths` new paths.
    pub(super) fn begin(&mut self, paths: usize) {
        let Self { pending, background, .. } = self;
        let paths = if self.capacity == 0 { 0 } else { paths };
        for (list, value) in [(pending, true), (background, false)] {
            list.clear();
            list.resize(paths, value);
        }
        self.radiance.iter_mut().for_each(Vec::clear);
    }

    /// Whether the first hit of some path may come at a later segment.
    pub(super) fn is_pending(&self) -> bool {
        self.pending.contains(&true)
    }

    /// Stores the radiance of all paths, after shading segment number `segment`.
    pub(super) fn store_radiance(&mut self, paths: &Paths, segment: u32) {
        if let Some(list) = self.radiance.get_mut(segment as usize - 1) {
            list.extend(paths.radiances(0..self.pending.len()));
        }
    }

    /// The light of path number `path`, whose weighted radiance is `all`.
    pub(super) fn light(&self, path: usize, all: Vec3, weight: f32) -> LightParts {
        let after = |list: &Vec<Vec3>| list.get(path).map(|radiance| *radiance * weight);
        LightParts::new(self.background[path], self.radiance.each_ref().map(after), all)
    }

    /// The values of one channel for all paths.
    pub(super) fn column(&self, channel: usize) -> &[f32] {
        &self.columns[channel * self.capacity..][..self.capacity]
    }

    /// Stores the first hits of those paths of `vertex` that are pending. They stay pending if `follows` is set.
    #[inline(always)]
    fn store(&mut self, vertex: &Vertex, segment: u32, hit: &FirstHit<Float>, follows: Mask) {
        let paths = vertex.path.lanes().map(|path| path as usize);
        let lanes = || (0..LANES).filter(|lane| vertex.present >> lane & 1 == 1);
        for (layer, place) in self.layers.places() {
            if layer.is_of_camera_ray() && segment > 1 {
                continue;
            }
            let values = layer.of_hit(hit).map(Float::to_array);
            for (column, values) in (place..place + layer.channels()).zip(values) {
                let column = &mut self.columns[column * self.capacity..][..self.capacity];
                for lane in lanes().filter(|&lane| self.pending[paths[lane]]) {
                    column[paths[lane]] = finite(values[lane]);
                }
            }
        }
        for lane in lanes() {
            self.pending[paths[lane]] &= follows.bits() >> lane & 1 == 1;
            if segment == 1 {
                self.background[paths[lane]] = !hit.exists;
            }
        }
    }
}

impl ShadeInputs<'_> {
    /// Stores the first hits of the paths that end or scatter at this segment.
    #[inline(never)]
    pub(super) fn first_hits(&self, queues: &Queues, paths: &Paths, samples: &mut LayerSamples) {
        let need_surfaces = samples.layers.need_surfaces();
        for (&key, queue) in self.tables.looks.keys().iter().zip(queues.iter()) {
            if let (Key::Surface { shape, kind, .. }, true) = (key, need_surfaces) {
                let hits = SurfaceHits { shading: self, shape, queue, paths, samples };
                self.tables.materials.visit(kind, hits);
                continue;
            }
            for first in (0..queue.len()).step_by(LANES) {
                let vertex = self.vertex(queue, first, paths, false);
                let hit = match key {
                    Key::Background => FirstHit::none(),
                    Key::Medium => {
                        let (ray, hit) = (vertex.segment.ray, vertex.hit);
                        let albedo = self.tables.media.phase::<Float>(hit.primitive).albedo();
                        FirstHit::in_medium(self.camera, ray.origin + ray.direction * hit.t, albedo)
                    }
                    Key::Surface { .. } => FirstHit::anything(),
                };
                samples.store(&vertex, self.segment, &hit, Mask::NONE);
            }
        }
    }
}

/// Stores the first hits of the paths of `queue`, which have hit surfaces of one shape and one kind of material.
struct SurfaceHits<'s, 'a> {
    shading: &'s ShadeInputs<'a>,
    shape: Shape,
    queue: Queue<'s>,
    paths: &'s Paths,
    samples: &'s mut LayerSamples,
}

impl MaterialVisitor for SurfaceHits<'_, '_> {
    type Output = ();

    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) {
        let Self { shading, shape, queue, paths, samples } = self;
        let instanced = shape == Shape::Instance;
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = shading.vertex(queue, first, paths, instanced);
            let (hit, follows) = FirstHit::on_surface::<M>(
                (shading.scene, shading.tables, shading.camera),
                (shape, vertex.segment.ray, vertex.hit),
                table,
            );
            let follows =
                if shading.settings.first_hit == FirstHits::Through { follows } else { Mask::NONE };
            samples.store(&vertex, shading.segment, &hit, follows);
        }
    }
}
