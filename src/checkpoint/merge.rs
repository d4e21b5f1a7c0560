//! Merges the parts of a render into the whole.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{Checkpoint, Identity, Shard};
use crate::engine::RenderState;
use crate::error::{Error, Result};
use crate::film::{Conflict, Film, SampleIndex};
use crate::image::Image;
use crate::limits::{Limit, Limits};

/// Merges `files`, the parts of one render: shards, ranges of samples, or both. `limits` apply to
/// each part. The memory limit also applies to the whole render together with the largest part.
///
/// # Errors
/// If a file cannot be read, belongs to another render than the first, is not complete or overlaps with
/// another, if a part is missing, or if a limit is exceeded.
pub(crate) fn merge(files: &[PathBuf], limits: &Limits) -> Result<Checkpoint> {
    let parts = files.iter().map(|file| PartFile::read(file, limits));
    let mut parts = parts.collect::<Result<Vec<_>>>()?;
    let Some(first) = parts.first() else {
        return Err(Error::Usage("there are no parts to merge".to_owned()));
    };
    let (scene, identity) = (first.scene.clone(), first.identity.clone());
    for part in &parts {
        part.check(first)?;
    }
    // Memory holds the whole and one part at a time.
    let memory = |samples: &Range<u32>| Film::memory(identity.area(), samples.clone());
    let largest = parts.iter().map(|part| memory(&part.samples)).max().unwrap_or(0);
    limits
        .check(Limit::Memory, largest + memory(&(0..identity.settings.spp)))
        .map_err(Error::Usage)?;
    parts.sort_by_key(|part| part.samples.start);
    let mut whole = RenderState::new(Film::new(identity.area(), 0..identity.settings.spp)?);
    for (number, part) in parts.iter().enumerate() {
        let there = Checkpoint::read(part.file, limits)?.rendering;
        match whole.film.append(&there.film)? {
            None => whole.add(&there),
            Some(Conflict::Twice(sample)) => {
                return Err(twice(part, &parts[..number], sample, limits)?);
            }
            Some(Conflict::Missing(sample)) => return Err(missing(&parts, sample)),
        }
    }
    match whole.film.missing() {
        Some(sample) => Err(missing(&parts, sample)),
        None => Ok(Checkpoint { scene, identity, shard: None, rendering: whole }),
    }
}

/// Description of a part. Its film is read again when it is merged, to save memory.
struct PartFile<'a> {
    file: &'a Path,
    scene: String,
    identity: Identity,
    shard: Option<Shard>,
    samples: Range<u32>,
    percent: Option<u64>,
}

impl<'a> PartFile<'a> {
    fn read(file: &'a Path, limits: &Limits) -> Result<Self> {
        Ok(Self::of(file, &Checkpoint::read(file, limits)?))
    }

    fn of(file: &'a Path, part: &Checkpoint) -> Self {
        Self {
            file,
            scene: part.scene.clone(),
            identity: part.identity.clone(),
            shard: part.shard,
            samples: part.rendering.film.samples(),
            percent: (!part.is_complete()).then(|| part.percent()),
        }
    }

    /// Checks that the part belongs to the same render as `first`.
    fn check_identity(&self, first: &Self) -> Result<()> {
        let Some((field, here, there)) = self.identity.difference(&first.identity) else {
            return Ok(());
        };
        let first = first.file.display();
        let message = format!(
            "belongs to a render with {field} {here}, but {first} to one with {field} {there}"
        );
        Err(Error::input(self.file.display().to_string(), "", message))
    }

    /// Checks that the part belongs to the same render as `first` and is complete.
    fn check(&self, first: &Self) -> Result<()> {
        self.check_identity(first)?;
        let Some(percent) = self.percent else { return Ok(()) };
        let message = format!("is only {percent}% complete: continue this part before merging");
        Err(Error::input(self.file.display().to_string(), "", message))
    }
}

fn describe((x, y, sample): SampleIndex) -> String {
    format!("sample {sample} of pixel {x},{y}")
}

/// The error for a `sample` that is in `part` and also in one of the parts `before`.
fn twice(
    part: &PartFile<'_>,
    before: &[PartFile<'_>],
    sample: SampleIndex,
    limits: &Limits,
) -> Result<Error> {
    let mut other = None;
    for before in before {
        if Checkpoint::read(before.file, limits)?.rendering.film.has(sample) {
            other = Some(before.file.display().to_string());
            break;
        }
    }
    let other = other.unwrap_or_default();
    let message = format!("{} is also in {other}: parts must not overlap", describe(sample));
    Ok(Error::input(part.file.display().to_string(), "", message))
}

/// The error that `sample` is in no part. For shards of tiles, it names the missing shards.
fn missing(parts: &[PartFile<'_>], sample: SampleIndex) -> Error {
    let names: Vec<String> = parts.iter().map(|part| part.file.display().to_string()).collect();
    let shards: Option<Vec<Shard>> = parts.iter().map(|part| part.shard).collect();
    let message = match shards.as_deref() {
        Some([first, others @ ..]) if others.iter().all(|shard| shard.count == first.count) => {
            let indices = || [first].into_iter().chain(others).map(|shard| shard.index);
            let absent =
                (0..first.count).filter(|&index| indices().all(|present| present != index));
            // Many shards can be missing, so only the first ten are named.
            let absent: Vec<String> =
                absent.take(10).map(|index| format!("{index}/{}", first.count)).collect();
            match absent.is_empty() {
                true => format!("{} is missing: add the part that contains it", describe(sample)),
                false => format!("shards are missing: {}", absent.join(", ")),
            }
        }
        _ => format!("{} is missing: add the part that contains it", describe(sample)),
    };
    Error::input(names.join(", "), "", message)
}

/// The image of the samples that are finished in parts of a render.
pub(crate) struct PartialRender {
    /// The name of the scene.
    pub(crate) scene: String,
    /// The mean of each pixel's finished samples, or black if the pixel has none.
    pub(crate) image: Image,
    /// Number of finished samples.
    pub(crate) samples: u64,
    /// Samples per pixel of the complete render.
    pub(crate) spp: u32,
}

/// Averages the finished samples in `files`, which are parts of one render. The parts may be
/// unfinished, and some parts may be missing.
///
/// # Errors
/// If a file cannot be read, belongs to another render than the first, or exceeds a limit.
pub(crate) fn merge_partial(files: &[PathBuf], limits: &Limits) -> Result<PartialRender> {
    let mut first: Option<PartFile<'_>> = None;
    let (mut sums, mut counts) = (Vec::new(), Vec::new());
    for file in files {
        let part = Checkpoint::read(file, limits)?;
        let known = PartFile::of(file, &part);
        match &first {
            Some(first) => known.check_identity(first)?,
            None => {
                let pixels = known.identity.area().pixels() as usize;
                (sums, counts) = (vec![[0.0f64; 3]; pixels], vec![0u64; pixels]);
                first = Some(known);
            }
        }
        let film = &part.rendering.film;
        let pixels =
            sums.iter_mut().zip(&mut counts).zip(film.means()?.into_iter().zip(film.counts()));
        for ((sum, count), (mean, samples)) in pixels.filter(|(_, (_, samples))| *samples > 0) {
            let add = |axis: usize| sum[axis] + f64::from(mean[axis]) * f64::from(samples);
            *sum = [add(0), add(1), add(2)];
            *count += u64::from(samples);
        }
    }
    let Some(PartFile { scene, identity, .. }) = first else {
        return Err(Error::Usage("there are no parts to merge".to_owned()));
    };
    let mean = |(sum, count): (&[f64; 3], &u64)| sum.map(|c| (c / (*count).max(1) as f64) as f32);
    let pixels = sums.iter().zip(&counts).map(mean).collect();
    let (area, spp) = (identity.area(), identity.settings.spp);
    let image = Image::from_pixels(area.width, area.height, pixels);
    Ok(PartialRender { scene, image, samples: counts.iter().sum(), spp })
}
