//! What layers hold of the paths of a wave.

use std::ops::Range;

use glam::Vec3;

use super::paths::Paths;
use crate::engine::first_hit::FirstHit;
use crate::engine::layers::{FirstHits, Layers, LightParts, finite};
use crate::film::COLOR;
use crate::math::{Real, Row};
use crate::simd::{Float, Indices, Int, LANES, Mask, Vec3x};

/// At least the number of channels of all layers together.
const MOST: usize = 64;

/// What layers hold of the paths of a wave. It is empty if there are no layers.
#[derive(Debug)]
pub(super) struct LayerSamples {
    pub(super) layers: Layers,
    /// Whether some values depend on the surfaces that are hit.
    pub(super) need_surfaces: bool,
    /// Whether the layers contain light.
    pub(super) have_light: bool,
    /// For each path and each block of [`LANES`] channels, the values of the first hit.
    values: Vec<[Row; LANES / 4]>,
    /// For each block, the channels that count: of a pixel's first sample, of other even samples, and of odd ones.
    masks: Vec<[Mask; 3]>,
    /// Room for the values of some paths.
    columns: [Float; MOST],
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
        let blocks = (layers.channels() - COLOR).div_ceil(LANES);
        let mut masks = vec![[0; 3]; blocks];
        for (layer, place) in layers.places() {
            let counts = [0, 2, 1].map(|sample| layer.takes_hit(sample));
            for channel in place - COLOR..place - COLOR + layer.channels() {
                for (bits, counts) in masks[channel / LANES].iter_mut().zip(counts) {
                    *bits |= u32::from(counts) << (channel % LANES);
                }
            }
        }
        let masks = masks.into_iter().map(|masks| masks.map(Mask::from_bits)).collect();
        // As many as `Paths` has room for.
        let values = vec![[[0; 4]; LANES / 4]; capacity.next_multiple_of(LANES) * blocks];
        let columns = [Float::ZERO; MOST];
        let [pending, background] = [const { Vec::new() }; 2];
        let (need_surfaces, have_light) = (layers.need_surfaces(), layers.have_light());
        let radiance = Default::default();
        Self {
            layers,
            need_surfaces,
            have_light,
            values,
            masks,
            columns,
            pending,
            background,
            radiance,
        }
    }

    /// Prepares for `paths` new paths.
    pub(super) fn begin(&mut self, paths: usize, first_hit: FirstHits) {
        let of = |wanted: bool| if wanted { paths } else { 0 };
        let follows = of(first_hit == FirstHits::Through && !self.masks.is_empty());
        let light = of(self.have_light);
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
        segment == 1 && !self.masks.is_empty() || self.pending.contains(&true)
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
    pub(super) fn add_to(&self, sums: &mut [f32], path: usize, samples: Range<u32>) {
        let blocks = self.masks.len();
        let values = &self.values[path * blocks..][..samples.len() * blocks];
        for (block, (sums, masks)) in sums.chunks_mut(LANES).zip(&self.masks).enumerate() {
            let mut total = [0.0; LANES];
            // A copy of a length that is not known would be a call.
            total.iter_mut().zip(&*sums).for_each(|(total, sum)| *total = *sum);
            let mut total = Float::new(total);
            for (sample, values) in samples.clone().zip(values[block..].iter().step_by(blocks)) {
                let mask = masks[if sample == 0 { 0 } else { 1 + (sample % 2) as usize }];
                // Values of samples that do not count become 0, which changes no sum.
                let values = Float::from_bits(Int::load(values.as_flattened()));
                total = total + mask.select(values, Float::ZERO);
            }
            sums.iter_mut().zip(total.to_array()).for_each(|(sum, total)| *sum = total);
        }
    }

    /// Notes that the camera rays of some paths meet the background.
    pub(super) fn meet_background(&mut self, path: &Indices) {
        if !self.background.is_empty() {
            path.lanes().iter().for_each(|&path| self.background[path as usize] = true);
        }
    }

    /// Stores the first hits of some paths. Where `follows` is set, the first hit may be a later one.
    #[inline(always)]
    pub(super) fn store(&mut self, path: &Indices, hit: &FirstHit<Float>, follows: Mask) {
        let mut is_open = Mask::ALL;
        if !self.pending.is_empty() {
            let paths = path.lanes().map(|path| path as usize);
            let bit = |lane: usize| u32::from(self.pending[paths[lane]]) << lane;
            is_open = Mask::from_bits((0..LANES).map(bit).sum());
            if !is_open.any() {
                return;
            }
            for (lane, path) in paths.into_iter().enumerate() {
                self.pending[path] &= follows.bits() >> lane & 1 == 1;
            }
        }
        let mut next = self.columns.iter_mut();
        for layer in self.layers.iter() {
            let channels = layer.of_hit(hit).into_iter().take(layer.channels());
            // In the other order, `zip` would skip a value after each layer.
            for (value, to) in channels.zip(next.by_ref()) {
                *to = finite(value);
            }
        }
        let blocks = self.masks.len() as u32;
        let columns = &self.columns[..(self.layers.channels() - COLOR).next_multiple_of(4)];
        for (block, columns) in (0..blocks).zip(columns.chunks(LANES)) {
            let place = Int::new(path.lanes().map(|path| path * blocks + block));
            let place = Indices::new(place, self.values.len());
            for (half, &[x, y, z, w]) in columns.as_chunks().0.iter().enumerate() {
                let mut found = (Vec3x([x, y, z]), w);
                if !self.pending.is_empty() {
                    let (old, last) = place.gather(&self.values, |rows| &rows[half]);
                    found = (is_open.select(found.0, old), is_open.select(w, last));
                }
                place.scatter(&mut self.values, |rows| &mut rows[half], found);
            }
        }
    }
}
