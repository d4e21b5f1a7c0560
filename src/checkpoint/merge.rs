//! A whole render of its parts.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{Checkpoint, Identity};
use crate::engine::Rendering;
use crate::error::{Error, Result};
use crate::film::{Conflict, Film, Sample};
use crate::limits::{Limit, Limits};

/// The render of which `files` are all parts: shards, ranges of samples, or both. `limits` hold for each.
///
/// # Errors
/// Where a file cannot be read, is of another render than the first, is not done or overlaps with another;
/// where a part is missing.
pub(crate) fn merge(files: &[PathBuf], limits: &Limits) -> Result<Checkpoint> {
    let parts = files.iter().map(|file| Part::read(file, limits));
    let mut parts = parts.collect::<Result<Vec<_>>>()?;
    let Some(first) = parts.first() else {
        return Err(Error::Usage("there is nothing to be merged".to_owned()));
    };
    let (scene, identity) = (first.scene.clone(), first.identity.clone());
    for part in &parts {
        part.check(first)?;
    }
    // One film at a time is in memory, beside the whole.
    let memory = |samples: &Range<u32>| Film::memory(identity.area(), samples.clone());
    let largest = parts.iter().map(|part| memory(&part.samples)).max().unwrap_or(0);
    limits.check(Limit::Memory, largest + memory(&(0..identity.spp))).map_err(Error::Usage)?;
    parts.sort_by_key(|part| part.samples.start);
    let mut whole = Rendering::new(Film::new(identity.area(), 0..identity.spp)?);
    for (number, part) in parts.iter().enumerate() {
        let there = Checkpoint::read(part.file, limits)?.rendering;
        match whole.film.append(&there.film)? {
            None => whole.add(&there),
            Some(Conflict::Twice(sample)) => {
                return Err(twice(part, &parts[..number], sample, limits)?);
            }
            Some(Conflict::Missing(sample)) => return Err(missing(files, sample)),
        }
    }
    match whole.film.missing() {
        Some(sample) => Err(missing(files, sample)),
        None => Ok(Checkpoint { scene, identity, shard: None, rendering: whole }),
    }
}

/// What is known of a part before its film is read again.
struct Part<'a> {
    file: &'a Path,
    scene: String,
    identity: Identity,
    samples: Range<u32>,
    percent: Option<u64>,
}

impl<'a> Part<'a> {
    fn read(file: &'a Path, limits: &Limits) -> Result<Self> {
        let there = Checkpoint::read(file, limits)?;
        let percent = (!there.is_complete()).then(|| there.percent());
        let samples = there.rendering.film.samples();
        Ok(Self { file, scene: there.scene, identity: there.identity, samples, percent })
    }

    /// Whether it is a part of the same render as `first`, and done.
    fn check(&self, first: &Self) -> Result<()> {
        let bad = |message| Err(Error::input(self.file.display().to_string(), "", message));
        if let Some((field, here, there)) = self.identity.difference(&first.identity) {
            let first = first.file.display();
            return bad(format!("is of a render with {field} {here}, {first} of one with {there}"));
        }
        if let Some(percent) = self.percent {
            return bad(format!("is not done, but to {percent}%: go on with --resume"));
        }
        Ok(())
    }
}

fn describe((x, y, sample): Sample) -> String {
    format!("sample {sample} of pixel {x},{y}")
}

/// That `part` has a sample which one of `before` has, too.
fn twice(part: &Part<'_>, before: &[Part<'_>], sample: Sample, limits: &Limits) -> Result<Error> {
    let mut other = None;
    for before in before {
        if Checkpoint::read(before.file, limits)?.rendering.film.has(sample) {
            other = Some(before.file.display().to_string());
            break;
        }
    }
    let other = other.unwrap_or_default();
    let message = format!("{} is in {other}, too", describe(sample));
    Ok(Error::input(part.file.display().to_string(), "", message))
}

fn missing(files: &[PathBuf], sample: Sample) -> Error {
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    Error::input(names.join(", "), "", format!("{} is in none of these", describe(sample)))
}
