//! Checkpoints: unfinished renders and parts of renders, in files that can be continued and merged.
//!
//! A file consists of a line that identifies the format, a line of JSON, the film in binary, and a BLAKE3
//! hash of everything before it:
//! ```text
//! ptfast film
//! {"schema":3,"scene":"spheres","identity":{...},"shard":null,"samples":[0,64],"tally":{...},"seconds":1.5}
//! for each pixel of the crop, row by row: one past its last finished sample, u32; u32::MAX if the pixel is in another shard
//! the first kept sum of each pixel that has one: 3 f32; the second of each that has two; ...
//! 32 bytes
//! ```
//! All numbers are little-endian. The finished samples of a pixel determine which sums it has; see
//! [`crate::film`].

mod file;
mod identity;
mod merge;
mod shard;

pub use identity::Identity;
pub(crate) use merge::{PartialRender, merge, merge_partial};
pub(crate) use shard::Shard;

use std::borrow::Borrow;
use std::ops::Range;

use crate::engine::RenderState;
use crate::error::Result;
use crate::film::Film;

/// The state of a render, or of a part of one.
#[derive(Clone, Debug)]
pub struct Checkpoint<R = RenderState> {
    /// Name of the scene.
    pub scene: String,
    /// Scene and settings that decide the image.
    pub identity: Identity,
    /// The shard to render; `None` for all pixels of the crop.
    pub shard: Option<Shard>,
    /// The samples rendered so far, with their statistics.
    pub rendering: R,
}

/// Which part of which render a checkpoint holds. Equal parts have equal bits once they are complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Scene and settings.
    pub identity: Identity,
    /// The shard; `None` for all pixels of the crop.
    pub shard: Option<Shard>,
    /// The samples of each pixel.
    pub samples: Range<u32>,
}

impl Part {
    /// Whether the part is the whole render: all pixels of the crop and all samples.
    pub(crate) fn is_whole(&self) -> bool {
        self.shard.is_none() && self.samples == (0..self.identity.settings.spp)
    }

    /// Ends the render with `samples` samples per pixel.
    pub(crate) fn end_at(&mut self, samples: u32) {
        self.identity.settings.spp = samples;
        self.samples.end = samples;
    }

    /// Number of channels of a sample.
    pub(crate) fn channels(&self) -> usize {
        self.identity.settings.stored_layers().channels()
    }

    /// A rendering of the part, without any samples.
    ///
    /// # Errors
    /// [`Error::Resource`](crate::Error::Resource) if there is not enough memory.
    pub(crate) fn empty_rendering(&self) -> Result<RenderState> {
        let mut film = Film::new(self.identity.area(), self.samples.clone(), self.channels())?;
        if let Some(shard) = self.shard {
            film.retain(|x, y| shard.has(self.identity.settings.width, x, y));
        }
        Ok(RenderState::new(film, &self.identity.settings))
    }

    /// The checkpoint of `rendering`, which has samples of this part, of the scene named `scene`.
    pub(crate) fn checkpoint<'a>(
        &self,
        scene: &str,
        rendering: &'a RenderState,
    ) -> Checkpoint<&'a RenderState> {
        let (scene, identity) = (scene.to_owned(), self.identity.clone());
        Checkpoint { scene, identity, shard: self.shard, rendering }
    }

    /// Why a checkpoint of this part cannot be continued as `wanted`; `None` if it can. A checkpoint that
    /// includes its render's last sample can be continued with more samples.
    pub fn mismatch(&self, wanted: &Self) -> Option<String> {
        let mut extended = self.clone();
        let ends = |part: &Self| part.samples.end == part.identity.settings.spp;
        if ends(self) && ends(wanted) && self.identity.settings.spp < wanted.identity.settings.spp {
            extended.identity.settings.spp = wanted.identity.settings.spp;
            extended.samples.end = wanted.samples.end;
        }
        let Self { identity, shard, samples } = extended;
        if let Some((field, here, wanted)) = identity.difference(&wanted.identity) {
            return Some(format!("belongs to a render with {field} {here}, not {wanted}"));
        }
        if shard != wanted.shard {
            let name = |shard: Option<Shard>| match shard {
                Some(Shard { index, count }) => format!("shard {index}/{count}"),
                None => "the whole image".to_owned(),
            };
            return Some(format!("holds {}, not {}", name(shard), name(wanted.shard)));
        }
        let name = |Range { start, end }: &Range<u32>| format!("{start}..{end}");
        (samples != wanted.samples)
            .then(|| format!("holds the samples {}, not {}", name(&samples), name(&wanted.samples)))
    }
}

impl<R: Borrow<RenderState>> Checkpoint<R> {
    /// The part of a render that the checkpoint holds.
    pub fn part(&self) -> Part {
        let samples = self.rendering.borrow().film.samples();
        Part { identity: self.identity.clone(), shard: self.shard, samples }
    }
}

impl Checkpoint {
    /// Returns the rendering, ready to be continued as `wanted`, which may have more samples.
    ///
    /// # Errors
    /// The reason, if the checkpoint holds another render or another part; see [`Part::mismatch`].
    pub fn resume(mut self, wanted: &Part) -> Result<RenderState, String> {
        if let Some(mismatch) = self.part().mismatch(wanted) {
            return Err(mismatch);
        }
        self.rendering.film.grow(wanted.samples.end);
        Ok(self.rendering)
    }
}
