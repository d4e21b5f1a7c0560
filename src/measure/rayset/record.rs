//! Records the rays of a render.

use rayon::prelude::*;

use super::select::Selection;
use super::{Query, RaySet, RaySets};
use crate::accel::{HitBatch, RayBatch};
use crate::engine::{ImageSettings, PathRecorder, RayKind, TracedRay};
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::scene::Scene;

/// Number of paths in a wave. The rays of a wave are recorded segment by segment.
const WAVE: usize = 4096;
/// Number of waves that are traced before their rays are sorted into the sets. It bounds the
/// memory.
const WAVES_AT_ONCE: usize = 64;
/// Side in pixels of the tiles, which are recorded one after the other.
const TILE: u32 = 8;

/// The sets, in the order in which they are written.
pub(super) const KINDS: [(RayKind, &str, Query); 3] = [
    (RayKind::Primary, "primary", Query::Closest),
    (RayKind::Bounce, "bounce", Query::Closest),
    (RayKind::Shadow, "shadow", Query::Occluded),
];

/// Records the rays that a render of `scene` traces, at most `most` (2048 or more) of each kind.
///
/// Paths are recorded by tiles of 8 × 8 pixels, within a tile sample by sample, and within a sample
/// row by row. Bounce and shadow rays are recorded in waves of 4096 paths, segment by segment. The
/// scene is traced twice: once to count the rays, and once to keep the selected ones.
///
/// # Errors
/// If a setting is out of range, or if triangles have holes, which the files cannot describe.
pub fn record(scene: &Scene, settings: &ImageSettings, most: u64) -> Result<RaySets> {
    if scene.geometry().may_have_holes() {
        let message =
            "ray sets cannot describe holes in triangles: remove `opacity` from the materials";
        return Err(Error::input(scene.name(), "", message));
    }
    let recorder = PathRecorder::new(scene, settings.clone())?;
    let trace = |x, y, sample| recorder.trace(x, y, sample).rays;
    let mut totals = [0; 3];
    for_each_ray(&trace, settings, |kind, _| totals[kind as usize] += 1);
    let mut sets: Vec<(Selection, RaySet)> = KINDS
        .iter()
        .zip(totals)
        .map(|(&(_, name, query), total)| {
            let (rays, hits) = (RayBatch::default(), HitBatch::default());
            (Selection::new(total, most), RaySet { name: name.to_owned(), query, rays, hits })
        })
        .collect();
    for_each_ray(&trace, settings, |kind, traced| {
        let (selection, set) = &mut sets[kind as usize];
        if selection.next() {
            set.rays.push(&traced.ray, 0.0, traced.t_max);
            set.hits.push(traced.hit);
        }
    });
    Ok(RaySets {
        scene: scene.name().to_owned(),
        seed: settings.seed,
        image: [settings.width, settings.height],
        origin: scene.origin().to_array(),
        geometry: Geometry::clone(scene.geometry()),
        sets: sets.into_iter().map(|(_, set)| set).filter(|set| !set.rays.is_empty()).collect(),
    })
}

/// Calls `visit` with all rays of the paths that `trace` returns for a pixel and a sample. The rays of
/// each kind come in the order of their set.
fn for_each_ray(
    trace: &(impl Fn(u32, u32, u32) -> Vec<TracedRay> + Sync),
    settings: &ImageSettings,
    mut visit: impl FnMut(RayKind, &TracedRay),
) {
    let ImageSettings { width, height, spp, .. } = *settings;
    let starts = |side: u32| (0..side).step_by(TILE as usize);
    let within = |start: u32, side: u32| start..side.min(start + TILE);
    let tiles = starts(height).flat_map(|top| starts(width).map(move |left| (left, top)));
    let paths = tiles.flat_map(|(left, top)| {
        (0..spp).flat_map(move |sample| {
            within(top, height).flat_map(move |y| within(left, width).map(move |x| (x, y, sample)))
        })
    });
    let mut paths = paths.peekable();
    while paths.peek().is_some() {
        let waves: Vec<_> = paths.by_ref().take(WAVES_AT_ONCE * WAVE).collect();
        let traced: Vec<Vec<TracedRay>> =
            waves.par_iter().map(|&(x, y, sample)| trace(x, y, sample)).collect();
        for wave in traced.chunks(WAVE) {
            for (kind, ..) in KINDS {
                for_each_of_wave(wave, kind, |ray| visit(kind, ray));
            }
        }
    }
}

/// Calls `visit` with the rays of one kind, segment by segment, and within a segment path by path.
fn for_each_of_wave(wave: &[Vec<TracedRay>], kind: RayKind, mut visit: impl FnMut(&TracedRay)) {
    let mut open: Vec<_> =
        wave.iter().map(|path| path.iter().filter(|ray| ray.kind == kind).peekable()).collect();
    for segment in 1.. {
        open.retain_mut(|path| path.peek().is_some());
        if open.is_empty() {
            return;
        }
        for path in &mut open {
            // A segment or a shadow ray that passes panes has several rays.
            while let Some(ray) = path.next_if(|ray| ray.segment == segment) {
                visit(ray);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::Ray;
    use crate::math::{Stream, mix32};

    /// A path of one to five segments, some with shadow rays, whose rays are all different.
    fn path(x: u32, y: u32, sample: u32) -> Vec<TracedRay> {
        let mut random = Stream::new(mix32(x ^ mix32(y ^ mix32(sample))).into());
        let mut rays = Vec::new();
        for segment in 1..=1 + random.bits() as u32 % 5 {
            let kind = if segment == 1 { RayKind::Primary } else { RayKind::Bounce };
            let shadow = (random.uniform() < 0.5).then_some(RayKind::Shadow);
            for kind in [kind].into_iter().chain(shadow) {
                let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, time: 0.0 };
                let t_max = random.uniform();
                rays.push(TracedRay { kind, segment, ray, t_max, hit: None, collision: None });
            }
        }
        rays
    }

    /// Checks the documented order, which other programs rely on, with plain loops.
    #[test]
    fn rays_come_in_the_documented_order() {
        // Two waves, and tiles that are cut off at the right and lower edges.
        let (width, height, spp) = (37, 29, 5);
        let scene = Scene::load("cornell").unwrap();
        let settings = ImageSettings { width, height, spp, ..ImageSettings::of(&scene) };
        let mut paths = Vec::new();
        for top in (0..height).step_by(8) {
            for left in (0..width).step_by(8) {
                for sample in 0..spp {
                    for y in top..height.min(top + 8) {
                        for x in left..width.min(left + 8) {
                            paths.push(path(x, y, sample));
                        }
                    }
                }
            }
        }
        assert!(paths.len() > 4096 && paths.len() < 2 * 4096);
        let mut found = [const { Vec::new() }; 3];
        for_each_ray(&path, &settings, |kind, ray| found[kind as usize].push(*ray));
        for (found, (kind, name, _)) in found.iter().zip(KINDS) {
            let mut want = Vec::new();
            for wave in paths.chunks(4096) {
                for segment in 1..=5 {
                    let rays = wave.iter().flatten();
                    want.extend(rays.filter(|ray| ray.kind == kind && ray.segment == segment));
                }
            }
            assert!(want.len() > 4096, "{name}");
            assert_eq!(*found, want, "{name}");
        }
    }
}
