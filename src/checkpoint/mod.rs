//! Checkpoints: renders under way, and parts of renders, as files that can be continued and merged.
//!
//! A file is a line that says what it is, a line of JSON, the film in binary, and a BLAKE3 hash of all that:
//! ```text
//! ptfast film
//! {"schema":2,"scene":"spheres","identity":{...},"shard":null,"samples":[0,64],"tally":{...},"seconds":1.5}
//! for each pixel of the crop, row by row: one past its last finished sample, u32; u32::MAX if the pixel is not in it
//! the first kept sum of each pixel that has one: 3 f32; the second of each that has two; ...
//! 32 bytes
//! ```
//! All numbers are little-endian. Which sums are kept follows from the samples ([`crate::film`]).

mod file;
mod identity;
mod merge;
mod shard;

pub use identity::Identity;
pub(crate) use merge::merge;
pub(crate) use shard::Shard;

use std::ops::Range;

use crate::engine::Rendering;
use crate::error::{Error, Result};

/// A render under way, or a part of one.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// The name of its scene.
    pub scene: String,
    /// What decides its image.
    pub identity: Identity,
    /// Which of its pixels, where not all.
    pub shard: Option<Shard>,
    /// What there is of it.
    pub rendering: Rendering,
}

impl Checkpoint {
    /// Whether it is of this render, of this shard and these samples, however far it is.
    pub fn is_of(&self, wanted: &Identity, shard: Option<Shard>, samples: &Range<u32>) -> bool {
        self.identity == *wanted && self.shard == shard && self.rendering.film.samples() == *samples
    }

    /// Whether nothing is left to be done for it.
    pub fn is_complete(&self) -> bool {
        let film = &self.rendering.film;
        film.samples_done() == film.samples_to_do()
    }

    /// How much of it is done.
    pub fn percent(&self) -> u64 {
        let film = &self.rendering.film;
        film.samples_done() * 100 / film.samples_to_do().max(1)
    }

    /// Prepares the render of `wanted`, of so many `samples` a pixel, to be continued from here. There may be
    /// more samples than there were to be.
    ///
    /// # Errors
    /// [`Error::Input`] that names the first difference that matters; `file` is where this is from.
    pub fn resume(
        mut self,
        file: &str,
        wanted: &Identity,
        shard: Option<Shard>,
        samples: Range<u32>,
    ) -> Result<Rendering> {
        let rendering = &mut self.rendering;
        let grows = rendering.film.samples().end == self.identity.spp && samples.end == wanted.spp;
        if grows && self.identity.spp < wanted.spp {
            self.identity.spp = wanted.spp;
            rendering.film.grow(samples.end);
        }
        if let Some((field, here, wanted)) = self.identity.difference(wanted) {
            let message = format!("is of a render with {field} {here}, not {wanted}");
            return Err(Error::input(file, "", message));
        }
        if self.shard != shard {
            let name = |shard: Option<Shard>| match shard {
                Some(Shard { index, count }) => format!("shard {index}/{count}"),
                None => "all shards".to_owned(),
            };
            let message = format!("is of {}, not of {}", name(self.shard), name(shard));
            return Err(Error::input(file, "", message));
        }
        if self.rendering.film.samples() != samples {
            let Range { start, end } = self.rendering.film.samples();
            let message =
                format!("is of the samples {start}..{end}, not {}..{}", samples.start, samples.end);
            return Err(Error::input(file, "", message));
        }
        Ok(self.rendering)
    }
}
