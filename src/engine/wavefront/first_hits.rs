//! First hits: writes what layers hold of the surfaces and media that paths meet first.

use glam::Vec3;

use super::material_sort::{Queue, Queues};
use super::paths::Paths;
use super::shade::{ShadeInputs, Vertex};
use crate::engine::first_hit::FirstHit;
use crate::engine::layers::{Combine, FirstHits, Layer, Layers, LightParts, finite};
use crate::film::COLOR;
use crate::geometry::Shape;
use crate::math::{Real, Row};
use crate::shading::Key;
use crate::shading::material::{Bsdf, MaterialModel, MaterialTable, MaterialVisitor};
use crate::simd::{Float, LANES, Mask, Vec3x};

/// At least the number of channels of all layers together.
const MOST: usize = 64;
/// Channels of a group, whose values are stored together.
const GROUP: usize = 4;

/// What layers hold of the paths of a wave. It is empty if there are no layers.
#[derive(Debug)]
pub(super) struct LayerSamples {
    pub(super) layers: Layers,
    /// For each group of channels and each path, the values of the first hit.
    groups: Vec<Vec<Row>>,
    /// For each group of channels, the bits that count: of a pixel's first sample, of other even samples, and of odd ones.
    masks: Vec<[Row; 3]>,
    /// Paths that have met only surfaces which first hits follow. Empty if they follow none.
    pending: Vec<bool>,
    /// Paths whose camera rays meet the background. Like the next list, it is empty if no layer holds light.
    background: Vec<bool>,
    /// Radiance of the paths after shading their first segment, and after shading their second.
    radiance: [Vec<Vec3>; 2],
}

impl LayerSamples {
    /// Room for `capacity` paths.
    pub(super) fn new(layers: Layers, capacity: usize) -> Self {
        let mut masks = vec![[[0; GROUP]; 3]; (layers.channels() - COLOR).div_ceil(GROUP)];
        for (layer, place) in layers.places() {
            let others = if layer.facts().1 == Combine::First { 0 } else { u32::MAX };
            let of = |sample, all| if layer.takes(sample) { all } else { 0 };
            for channel in place - COLOR..place - COLOR + layer.channels() {
                let values = [of(0, u32::MAX), of(0, others), of(1, others)];
                for (mask, value) in masks[channel / GROUP].iter_mut().zip(values) {
                    mask[channel % GROUP] = value;
                }
            }
        }
        // As many as `Paths` has room for.
        let groups = vec![vec![[0; GROUP]; capacity.next_multiple_of(LANES)]; masks.len()];
        let [pending, background] = [const { Vec::new() }; 2];
        Self { layers, groups, masks, pending, background, radiance: Default::default() }
    }

    /// Prepares for `paths` new paths.
    pub(super) fn begin(&mut self, paths: usize, first_hit: FirstHits) {
        let of = |wanted: bool| if wanted { paths } else { 0 };
        let follows = of(first_hit == FirstHits::Through && !self.groups.is_empty());
        let light = of(self.layers.have_light());
        for (list, length, value) in
            [(&mut self.pending, follows, true), (&mut self.background, light, false)]
        {
            list.clear();
            list.resize(length, value);
        }
        self.radiance.iter_mut().for_each(Vec::clear);
    }

    /// Whether the first hit of some path may be at segment number `segment`.
    pub(super) fn is_pending(&self, segment: u32) -> bool {
        segment == 1 && !self.groups.is_empty() || self.pending.contains(&true)
    }

    /// Stores the radiance of all paths, after shading segment number `segment`.
    pub(super) fn store_radiance(&mut self, paths: &Paths, segment: u32) {
        if let Some(list) = self.radiance.get_mut(segment as usize - 1) {
            list.extend(paths.radiances(0..self.background.len()));
        }
    }

    /// The light of path number `path`, whose weighted radiance is `all`.
    pub(super) fn light(&self, path: usize, all: Vec3, weight: f32) -> LightParts {
        let after = |list: &Vec<Vec3>| list.get(path).map(|radiance| *radiance * weight);
        LightParts::new(self.background[path], self.radiance.each_ref().map(after), all)
    }

    /// Adds the values of path number `path` and the following ones to the sums of their pixel, which have one number
    /// per channel of the layers. The samples of these paths are `samples`.
    pub(super) fn add_to(&self, sums: &mut [f32], path: usize, samples: std::ops::Range<u32>) {
        for ((sums, group), masks) in sums.chunks_mut(GROUP).zip(&self.groups).zip(&self.masks) {
            let mut totals = [0.0; GROUP];
            totals[..sums.len()].copy_from_slice(sums);
            for (sample, row) in samples.clone().zip(&group[path..]) {
                let mask = &masks[if sample == 0 { 0 } else { 1 + (sample % 2) as usize }];
                for ((total, word), mask) in totals.iter_mut().zip(row).zip(mask) {
                    // Values of samples that do not count become 0, which changes no sum.
                    *total += f32::from_bits(word & mask);
                }
            }
            sums.copy_from_slice(&totals[..sums.len()]);
        }
    }

    /// Stores the first hits of the paths of `vertex`. With `follows`, those of some paths may be later ones.
    #[inline(always)]
    fn store(&mut self, vertex: &Vertex, hit: &FirstHit<Float>, follows: Mask) {
        let mut values = [Float::ZERO; MOST];
        let mut next = values.iter_mut();
        for layer in self.layers.iter() {
            let channels = layer.of_hit(hit).into_iter().take(layer.channels());
            // In the other order, `zip` would skip a value after each layer.
            for (value, to) in channels.zip(next.by_ref()) {
                *to = finite(value);
            }
        }
        let values = values.as_chunks::<GROUP>().0;
        if self.pending.is_empty() {
            for (group, &[x, y, z, w]) in self.groups.iter_mut().zip(values) {
                vertex.path.scatter(group, |row| row, (Vec3x([x, y, z]), w));
            }
        } else {
            let paths = vertex.path.lanes().map(|path| path as usize);
            let bit = |lane: usize| u32::from(self.pending[paths[lane]]) << lane;
            let is_open = Mask::from_bits((0..LANES).map(bit).sum());
            for (group, &[x, y, z, w]) in self.groups.iter_mut().zip(values) {
                let (old, last) = vertex.path.gather(group, |row| row);
                let columns = (is_open.select(Vec3x([x, y, z]), old), is_open.select(w, last));
                vertex.path.scatter(group, |row| row, columns);
            }
            for (lane, path) in paths.into_iter().enumerate() {
                self.pending[path] &= follows.bits() >> lane & 1 == 1;
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
                    Key::Background => FirstHit::none(self.segment),
                    Key::Medium => {
                        let (ray, hit) = (vertex.segment.ray, vertex.hit);
                        let albedo = self.tables.media.phase::<Float>(hit.primitive).albedo();
                        FirstHit::in_medium(self.camera, ray.origin + ray.direction * hit.t, albedo)
                    }
                    Key::Surface { .. } => FirstHit::anything(),
                };
                samples.store(&vertex, &hit, Mask::NONE);
                if self.segment == 1 && !hit.exists && !samples.background.is_empty() {
                    for path in vertex.path.lanes() {
                        samples.background[*path as usize] = true;
                    }
                }
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
        let scene = (shading.scene, shading.tables, shading.camera);
        let follows = !samples.pending.is_empty();
        let needs_bsdf = follows || samples.layers.iter().any(Layer::is_of_bsdf);
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = shading.vertex(queue, first, paths, instanced);
            let found = (shape, vertex.segment.ray, vertex.hit);
            let (hit, specular) = FirstHit::on_surface::<M>(scene, found, table, needs_bsdf);
            samples.store(&vertex, &hit, specular);
        }
    }
}
