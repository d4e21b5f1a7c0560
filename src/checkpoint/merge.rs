//! Merges the parts of a render into the whole.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{Checkpoint, Identity, Shard};
use crate::engine::{RenderState, Rows, Totals};
use crate::error::{Error, Result};
use crate::film::{Conflict, Film, SampleIndex};
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
    let (settings, area) = (&identity.settings, identity.area());
    let channels = settings.stored_layers().channels();
    let memory = |samples: &Range<u32>| Film::memory(area, samples.clone(), channels);
    let largest = parts.iter().map(|part| memory(&part.samples)).max().unwrap_or(0);
    limits.check(Limit::Memory, largest + memory(&(0..settings.spp))).map_err(Error::Usage)?;
    parts.sort_by_key(|part| part.samples.start);
    let film = Film::new(area, 0..settings.spp, channels)?;
    let mut whole = RenderState::new(film, settings);
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
            percent: (!part.rendering.is_complete()).then(|| part.rendering.percent()),
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

/// The samples that are finished in parts of a render.
pub(crate) struct PartialRender {
    /// The name of the scene.
    pub(crate) scene: String,
    pub(crate) identity: Identity,
    pub(crate) film: PartialFilm,
}

/// Adds the finished samples in `files`, which are parts of one render. The parts may be unfinished, and some parts
/// may be missing.
///
/// # Errors
/// If a file cannot be read, belongs to another render than the first, or exceeds a limit.
pub(crate) fn merge_partial(files: &[PathBuf], limits: &Limits) -> Result<PartialRender> {
    let mut merged: Option<(PartFile<'_>, PartialFilm)> = None;
    for file in files {
        let part = Checkpoint::read(file, limits)?;
        let known = PartFile::of(file, &part);
        let (first, sums) = match &mut merged {
            Some(merged) => merged,
            None => {
                let sums = PartialFilm::new(&part.rendering.film, limits)?;
                merged.insert((PartFile::of(file, &part), sums))
            }
        };
        known.check_identity(first)?;
        sums.add(&part.rendering.film);
    }
    let Some((PartFile { scene, identity, .. }, film)) = merged else {
        return Err(Error::Usage("there are no parts to merge".to_owned()));
    };
    Ok(PartialRender { scene, identity, film })
}

/// Sums of all finished samples of several films.
pub(crate) struct PartialFilm {
    /// Pixels of a row.
    width: usize,
    channels: usize,
    /// For each pixel, a sum per channel.
    sums: Vec<f64>,
    /// For each pixel, the number of even and of odd samples.
    counts: Vec<[u32; 2]>,
}

impl PartialFilm {
    /// Without samples, for films like `film`.
    fn new(film: &Film, limits: &Limits) -> Result<Self> {
        let (pixels, channels) = (film.area().pixels() as usize, film.channels());
        let bytes = Film::memory(film.area(), film.samples(), channels)
            + 8 * (1 + channels as u64) * pixels as u64;
        limits.check(Limit::Memory, bytes).map_err(Error::Usage)?;
        let width = film.area().width as usize;
        let (sums, counts) = (vec![0.0; pixels * channels], vec![[0; 2]; pixels]);
        Ok(Self { width, channels, sums, counts })
    }

    /// Number of finished samples.
    pub(crate) fn samples(&self) -> u64 {
        self.counts.iter().flatten().map(|count| u64::from(*count)).sum()
    }

    fn add(&mut self, film: &Film) {
        let mut pixels = self.sums.chunks_exact_mut(self.channels).zip(&mut self.counts);
        for row in 0..film.area().height {
            Rows::all(film).row(row, |totals, counts| {
                let (sums, sum) = pixels.next().expect("all parts have the same pixels");
                for (sum, total) in sums.iter_mut().zip(totals) {
                    *sum += f64::from(*total);
                }
                *sum = [sum[0] + counts[0], sum[1] + counts[1]];
            });
        }
    }
}

impl Totals for PartialFilm {
    fn row(&self, row: u32, mut take: impl FnMut(&[f32], [u32; 2])) {
        let pixels = row as usize * self.width..(row as usize + 1) * self.width;
        let mut totals = vec![0.0; self.channels];
        for pixel in pixels {
            let sums = &self.sums[pixel * self.channels..][..self.channels];
            totals.iter_mut().zip(sums).for_each(|(total, sum)| *total = *sum as f32);
            take(&totals, self.counts[pixel]);
        }
    }
}
