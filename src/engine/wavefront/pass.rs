//! Pass: lets rays through panes.

use glam::Vec3;

use super::extend::trace;
use super::{Columns, Paths, WaveRays};
use crate::accel::{Accelerator, HitBatch, Kernel, RayBatch};
use crate::engine::{ImageSettings, StageWork};
use crate::geometry::Hit;
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Beyond, MOST_PANES, SceneTables};

/// How rays are traced beyond panes.
#[derive(Clone, Copy)]
pub(super) struct Passing<'a> {
    pub(super) tables: &'a SceneTables,
    pub(super) accelerator: &'a Accelerator,
    pub(super) kernel: Kernel,
    pub(super) count: bool,
}

impl Passing<'_> {
    /// Traces the closest hits of `parts` before the distances beside them.
    fn trace(&self, parts: &[(Beyond, f32)], work: &mut StageWork) -> HitBatch {
        let (mut batch, mut hits) = (RayBatch::default(), HitBatch::default());
        for (part, t_max) in parts {
            batch.push(&part.ray, 0.0, *t_max);
        }
        let counters = trace(self.accelerator, self.kernel, false, &batch, &mut hits, self.count);
        work.add(&StageWork { counters, ..StageWork::of(parts.len()) });
        hits
    }

    /// Replaces the hits of paths that pass panes with what they meet beyond. Returns the work for the rays
    /// that go on.
    #[inline(never)]
    pub(super) fn pass(
        &self,
        settings: &ImageSettings,
        segment: u32,
        paths: &mut Paths,
        rays: &WaveRays,
        hits: &mut HitBatch,
    ) -> StageWork {
        let mut work = StageWork::default();
        let mut meeting: Vec<usize> = (0..rays.len()).collect();
        for number in 1..=MOST_PANES {
            let (mut going, mut parts) = (Vec::new(), Vec::new());
            for index in meeting {
                let path = rays.paths[index] as usize;
                let Some(hit) = hits.get(index) else { continue };
                let (ray, key) = paths.ray(path);
                let Some(pane) = self.tables.pane(&ray, hit) else { continue };
                let randoms = Randoms::<f32>::new(settings.sampler, key.beyond(number), segment);
                let chance = pane.chance();
                if randoms.one(Dimension::PANE) < chance {
                    paths.weaken(path, pane.transmittance / chance);
                    going.push((index, key));
                    parts.push((Beyond::new(&ray, &pane), f32::INFINITY));
                } else {
                    paths.weaken(path, Vec3::splat(1.0 / (1.0 - chance)));
                }
            }
            if going.is_empty() {
                break;
            }
            let found = self.trace(&parts, &mut work);
            meeting = going.iter().map(|(index, _)| *index).collect();
            for (i, ((index, key), (part, _))) in going.into_iter().zip(parts).enumerate() {
                let hit = found.get(i).unwrap_or(Hit::of(Hit::MISS, f32::INFINITY));
                let randoms = Randoms::<f32>::new(settings.sampler, key.beyond(number), segment);
                let (t, primitive) =
                    self.tables.media.collide(&part.ray, (hit.t, hit.primitive), &randoms);
                hits.set(index, part.whole(Hit { t, primitive, ..hit }));
            }
        }
        work
    }

    /// Lets the shadow rays through that only panes block. Panes weaken the light of a ray in the order in which
    /// it meets them. Returns the work for the rays that go on.
    #[inline(never)]
    pub(super) fn pass_shadows(
        &self,
        rays: &RayBatch,
        light: &mut Columns<4>,
        hits: &mut HitBatch,
    ) -> StageWork {
        let mut work = StageWork::default();
        let blocked = (0..rays.len()).filter(|&index| hits.primitive[index] != HitBatch::MISS);
        let (mut going, mut parts): (Vec<_>, Vec<_>) = blocked
            .map(|index| {
                let (ray, _, t_max) = rays.get(index);
                (index, (Beyond::all(ray), t_max))
            })
            .unzip();
        for number in 0..=MOST_PANES {
            if going.is_empty() {
                break;
            }
            let found = self.trace(&parts, &mut work);
            let before = std::mem::take(&mut going).into_iter().zip(std::mem::take(&mut parts));
            for (i, (index, (part, t_max))) in before.enumerate() {
                let Some(hit) = found.get(i) else {
                    hits.primitive[index] = HitBatch::MISS;
                    continue;
                };
                let pane = self.tables.pane(&part.ray, hit).filter(|_| number < MOST_PANES);
                let Some(pane) = pane else { continue };
                for channel in 0..3 {
                    let word = &mut light.column_mut(channel)[index];
                    *word = (f32::from_bits(*word) * pane.transmittance[channel]).to_bits();
                }
                going.push(index);
                parts.push((Beyond::new(&part.ray, &pane), t_max - hit.t));
            }
        }
        work
    }
}
