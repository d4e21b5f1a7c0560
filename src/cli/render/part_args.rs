//! The arguments that select a part of a render: pixels, samples, or one of many shards.

use std::env;
use std::ops::Range;

use clap::Args;

use super::scheduler;
use crate::checkpoint::{Identity, Part, Shard};
use crate::engine::ImageSettings;
use crate::error::{Error, Result};
use crate::film::{CHUNK, Tile};

/// Heading in the help.
pub(crate) const HEADING: &str = "Parts and long renders";

#[derive(Clone, Debug, Args)]
pub(crate) struct PartArgs {
    /// Render only these pixels: left, upper, right and lower edge, from the top left of the image
    #[arg(long, help_heading = HEADING, allow_hyphen_values = true, value_name = "X0,Y0,X1,Y1", value_parser = crop)]
    crop: Option<[u32; 4]>,
    /// Render shard I of N, counted from 0, into a .film for `ptfast merge`; auto: I and N from the
    /// variables of a Slurm array; auto/N: I from those of a Slurm array or a Kubernetes indexed
    /// job
    #[arg(long, help_heading = HEADING, allow_hyphen_values = true, value_name = "I/N|auto|auto/N", value_parser = shard)]
    shard: Option<ShardChoice>,
    /// Render the samples A to B-1 of each pixel into a .film for `ptfast merge`. A and B must be
    /// multiples of 16, but B can also be the number of --spp
    #[arg(long, help_heading = HEADING, allow_hyphen_values = true, value_name = "A..B", value_parser = samples)]
    sample_range: Option<SampleRange>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ShardChoice {
    Given(Shard),
    Auto(Option<u32>),
}

/// A non-empty range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SampleRange {
    first: u32,
    end: u32,
}

fn numbers<const N: usize>(text: &str, separator: &str) -> Option<[u32; N]> {
    let numbers: Option<Vec<u32>> =
        text.split(separator).map(|number| number.parse().ok()).collect();
    numbers?.try_into().ok()
}

fn crop(text: &str) -> Result<[u32; 4], String> {
    let edges =
        numbers(text, ",").filter(|[left, upper, right, lower]| left < right && upper < lower);
    edges.ok_or_else(|| {
        "must be left,upper,right,lower with left < right and upper < lower, such as 0,0,640,360".to_owned()
    })
}

fn samples(text: &str) -> Result<SampleRange, String> {
    match numbers(text, "..") {
        Some([first, end]) if first < end => Ok(SampleRange { first, end }),
        _ => Err("must be two numbers, the first less than the second, such as 0..64".to_owned()),
    }
}

fn shard(text: &str) -> Result<ShardChoice, String> {
    let given = |[index, count]: [u32; 2]| (index < count).then_some(Shard { index, count });
    let choice = match text.strip_prefix("auto") {
        Some("") => Some(ShardChoice::Auto(None)),
        Some(count) => {
            let count = count.strip_prefix('/').and_then(|count| count.parse().ok());
            count.filter(|&count| count > 0).map(|count| ShardChoice::Auto(Some(count)))
        }
        None => numbers(text, "/").and_then(given).map(ShardChoice::Given),
    };
    choice.ok_or_else(|| "must be I/N with I < N, such as 0/4, or auto, or auto/4".to_owned())
}

impl ShardChoice {
    fn shard(self) -> Result<Shard> {
        match self {
            Self::Given(shard) => Ok(shard),
            Self::Auto(count) => scheduler::shard(count, |name| env::var(name).ok()),
        }
    }
}

impl PartArgs {
    /// The part of the image to render. Its identity lacks the hash of the scene.
    ///
    /// # Errors
    /// [`Error::Usage`] if the image has no such part.
    pub(crate) fn part(&self, settings: &ImageSettings) -> Result<Part> {
        let ImageSettings { width, height, spp, .. } = *settings;
        let [left, upper, right, lower] = self.crop.unwrap_or([0, 0, width, height]);
        if right > width || lower > height {
            let message = format!("--crop must be within {width} x {height}");
            return Err(Error::Usage(format!("{message}, is {left},{upper},{right},{lower}")));
        }
        let SampleRange { first, end } =
            self.sample_range.unwrap_or(SampleRange { first: 0, end: spp });
        let whole = |end: u32| end.is_multiple_of(CHUNK) || end == spp;
        if !(first.is_multiple_of(CHUNK) && whole(end) && end <= spp) {
            return Err(Error::Usage(format!(
                "--sample-range must begin and end at multiples of {CHUNK}, or end at {spp}, is {first}..{end}"
            )));
        }
        let area = Tile { x: left, y: upper, width: right - left, height: lower - upper };
        Ok(Part {
            identity: Identity::without_scene(settings, area),
            shard: self.shard()?,
            samples: first..end,
        })
    }

    /// The shard, if there are several.
    ///
    /// # Errors
    /// [`Error::Usage`] if `auto` is asked for, and the variables of the scheduler are missing.
    pub(crate) fn shard(&self) -> Result<Option<Shard>> {
        self.shard.map(ShardChoice::shard).transpose()
    }

    /// Renders all of the image.
    pub(crate) fn unshard(&mut self) {
        self.shard = None;
    }
}

/// The suffix of the default output name for a part of an image.
pub(crate) fn suffix(Part { identity, shard, samples }: &Part) -> String {
    let [left, upper, right, lower] = identity.crop;
    let crop = (!identity.is_whole()).then(|| format!(".crop-{left}-{upper}-{right}-{lower}"));
    let shard = shard.map(|Shard { index, count }| format!(".{index}-of-{count}"));
    let Range { start, end } = *samples;
    let some = (start, end) != (0, identity.settings.spp);
    let samples = some.then(|| format!(".samples-{start}-{end}"));
    [crop, shard, samples].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_parsed() {
        let given = |index, count| Ok(ShardChoice::Given(Shard { index, count }));
        assert_eq!((shard("0/1"), shard("3/4")), (given(0, 1), given(3, 4)));
        assert_eq!(shard("auto"), Ok(ShardChoice::Auto(None)));
        assert_eq!(shard("auto/7"), Ok(ShardChoice::Auto(Some(7))));
        for wrong in ["", "1", "4/4", "0/0", "-1/4", "1/4/5", "auto/0", "auto7", "auto/"] {
            assert!(shard(wrong).is_err(), "{wrong}");
        }
        assert!(samples("16..64").is_ok() && samples("64..64").is_err() && samples("64").is_err());
        assert!(crop("0,0,1,1").is_ok() && crop("1,0,1,1").is_err() && crop("0,0,1").is_err());
    }

    #[test]
    fn parts_are_within_the_image() {
        let scene = crate::scene::Scene::load("cornell").unwrap();
        let settings = ImageSettings { spp: 50, ..ImageSettings::of(&scene) };
        let part = |crop, samples: Option<(u32, u32)>| {
            let sample_range = samples.map(|(first, end)| SampleRange { first, end });
            PartArgs { crop, shard: None, sample_range }.part(&settings)
        };
        assert_eq!(part(None, None).unwrap().samples, 0..50);
        assert_eq!(
            part(Some([5, 6, 15, 400]), Some((16, 50))).unwrap().identity.area().height,
            394
        );
        for samples in [(0, 51), (1, 16), (16, 33), (48, 64)] {
            assert!(part(None, Some(samples)).is_err(), "{samples:?}");
        }
        assert!(part(Some([0, 0, 401, 1]), None).is_err());
    }
}
