//! Where a render is kept, and when.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use jiff::SignedDuration;

use super::share::Share;
use crate::checkpoint::{Checkpoint, Identity};
use crate::error::{Error, Result};
use crate::image::Transfer;
use crate::limits::Limits;
use crate::output::same_file;

/// Time between checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);

#[derive(Debug, Args)]
pub(super) struct KeepArgs {
    /// Keep what is rendered so far in this .film file, now and then, on SIGUSR1 and when stopped [default: that of
    /// --resume, or one beside the image, when stopped]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Time between checkpoints, such as 90s or 1h30m [default: 60s]
    #[arg(long, value_name = "TIME", requires = "checkpoint", value_parser = duration)]
    checkpoint_every: Option<Duration>,
    /// Stop after this time, such as 90s or 1h30m, with a checkpoint and exit code 75; something is rendered in any
    /// case
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time_limit: Option<Duration>,
    /// Go on from a checkpoint of the same scene and settings; there may be more samples than it was for
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
}

fn duration(text: &str) -> Result<Duration, String> {
    let parsed = text.parse::<SignedDuration>().ok().and_then(|time| Duration::try_from(time).ok());
    parsed.filter(|time| !time.is_zero()).ok_or_else(|| "a time such as 90s or 1h30m".to_owned())
}

/// Where a render is kept, and when.
pub(super) struct Keeping {
    /// The checkpoint.
    pub(super) file: PathBuf,
    /// The time between checkpoints; none where there is one only when it is stopped.
    pub(super) every: Option<Duration>,
    /// How long it may take from `start` on.
    pub(super) time_limit: Option<Duration>,
    /// When the program began.
    pub(super) start: Instant,
    /// How the image is shown as far as it is, when it is stopped; none for those who want no image.
    pub(super) transfer: Option<Transfer>,
    /// What is kept under names of the program's choice.
    names: Names,
    /// Whether the user named the checkpoint.
    is_given: bool,
    /// When the checkpoint that is there was changed last.
    seen: Option<SystemTime>,
}

/// `NAME.partial.EXT`, `NAME.partial.2.EXT` and so on beside `NAME.png`.
struct Names(PathBuf);

/// Bytes of a name that are kept, so that there is room for more.
const MOST_STEM: usize = 200;

impl Names {
    fn name(&self, number: u32, extension: &OsStr) -> PathBuf {
        let stem = self.0.file_stem().unwrap_or_default();
        let mut name = match stem.len() <= MOST_STEM {
            true => stem.to_owned(),
            false => stem.to_string_lossy().chars().take(MOST_STEM / 4).collect::<String>().into(),
        };
        name.push(".partial.");
        if number > 1 {
            name.push(format!("{number}."));
        }
        name.push(extension);
        self.0.with_file_name(name)
    }

    /// The first film that is not there yet, and neither is its image.
    fn free_film(&self) -> PathBuf {
        let is_free = |path: PathBuf| fs::symlink_metadata(path).is_err();
        let are_free = |number: &u32| is_free(self.film(*number)) && is_free(self.image(*number));
        let number = (1..).find(are_free).expect("no folder is so full");
        self.film(number)
    }

    fn film(&self, number: u32) -> PathBuf {
        self.name(number, OsStr::new("film"))
    }

    fn image(&self, number: u32) -> PathBuf {
        self.name(number, self.0.extension().unwrap_or_default())
    }

    /// That of `film`; of one that the user named, the first.
    fn image_of(&self, film: &Path) -> PathBuf {
        let own = (1..MOST_OWN).find(|&number| same_file(&self.film(number), film));
        self.image(own.unwrap_or(1))
    }
}

/// Films of one image that are told by their names, at most.
const MOST_OWN: u32 = 100;

impl KeepArgs {
    /// Of a render that writes `output`, an image where `transfer` says how.
    pub(super) fn keeping(
        &self,
        output: &Path,
        transfer: Option<Transfer>,
        start: Instant,
    ) -> Keeping {
        let names = Names(output.to_owned());
        // A target is whole, or as it was.
        let resumed = self.resume.as_ref().filter(|file| !same_file(file, output));
        let given = self.checkpoint.as_ref().or(resumed);
        let file = given.cloned().unwrap_or_else(|| names.free_film());
        Keeping {
            seen: changed(&file),
            file,
            is_given: given.is_some(),
            every: self.checkpoint.as_ref().map(|_| self.checkpoint_every.unwrap_or(INTERVAL)),
            time_limit: self.time_limit,
            start,
            transfer,
            names,
        }
    }
}

impl Keeping {
    /// Refuses to replace what is not of this render, or has more of it than the samples that are `done`: it would
    /// be lost.
    ///
    /// # Errors
    /// [`Error::Usage`] that says what to do.
    pub(super) fn check(
        &self,
        identity: &Identity,
        share: &Share,
        done: u64,
        limits: &Limits,
    ) -> Result<()> {
        if fs::metadata(&self.file).is_err_and(|error| error.kind() == ErrorKind::NotFound) {
            return Ok(());
        }
        let file = self.file.display();
        let refused = |what: &dyn std::fmt::Display| {
            Error::Usage(format!("{what}: name another file for --checkpoint, or remove it"))
        };
        let there = Checkpoint::read(&self.file, limits).map_err(|error| refused(&error))?;
        let same = there.identity == *identity
            && there.shard == share.shard
            && there.rendering.film.samples() == share.samples;
        if !same {
            return Err(refused(&format_args!("{file} is of another render")));
        }
        if there.rendering.film.samples_done() <= done {
            return Ok(());
        }
        let percent = there.percent();
        Err(Error::Usage(format!(
            "{file} has {percent}% of this render: go on with --resume {file}, or remove it"
        )))
    }

    /// For this run.
    pub(super) fn place(&self) -> Place<'_> {
        Place { keeping: self, file: self.file.clone(), last: self.seen }
    }
}

/// A place for checkpoints that nobody else is to take.
pub(super) struct Place<'a> {
    keeping: &'a Keeping,
    file: PathBuf,
    /// When the file was changed last by this program; none while it is not there.
    last: Option<SystemTime>,
}

impl Place<'_> {
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// Writes `checkpoint`.
    ///
    /// # Errors
    /// Where it cannot be written, or another program writes the file that the user named.
    pub(super) fn keep(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let there = changed(&self.file);
        if there.is_some() && there != self.last {
            if self.keeping.is_given {
                let error = io::Error::other("another program has changed it");
                return Err(Error::io(&self.file, "write")(error));
            }
            self.file = self.keeping.names.free_film();
        }
        checkpoint.write(&self.file)?;
        self.last = changed(&self.file);
        Ok(())
    }

    /// Writes `checkpoint`, the last of this run: under another name, where that of the user cannot be had.
    ///
    /// # Errors
    /// Where it cannot be written by any name.
    pub(super) fn keep_in_the_end(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let Err(error) = self.keep(checkpoint) else { return Ok(()) };
        let other = self.keeping.names.free_film();
        checkpoint.write(&other).map_err(|_| error)?;
        self.file = other;
        Ok(())
    }

    /// Where the image is shown as far as it is, beside the checkpoint that was written last.
    pub(super) fn image(&self) -> PathBuf {
        self.keeping.names.image_of(&self.file)
    }
}

/// When `file` was changed last, if it is there.
fn changed(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).and_then(|metadata| metadata.modified()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{RenderSettings, Rendering};
    use crate::film::Film;
    use crate::scene::Scene;

    #[test]
    fn times_are_parsed() {
        let seconds = |text| duration(text).map(|time| time.as_secs_f64());
        assert_eq!(seconds("90s"), Ok(90.0));
        assert_eq!(seconds("1h30m"), Ok(5400.0));
        assert_eq!(seconds("500ms"), Ok(0.5));
        for wrong in ["", "90", "-5s", "0s", "5 parsecs"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn files_that_are_there_keep_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let args = |resume: Option<&str>| KeepArgs {
            checkpoint: None,
            checkpoint_every: None,
            time_limit: None,
            resume: resume.map(at),
        };
        let keeping = |resume, output: &str| {
            args(resume).keeping(&at(output), Some(Transfer::default()), Instant::now())
        };
        let names = |keeping: &Keeping| (keeping.file.clone(), keeping.place().image());
        assert_eq!(names(&keeping(None, "a.png")), (at("a.partial.film"), at("a.partial.png")));
        fs::write(at("a.partial.film"), "").unwrap();
        assert_eq!(names(&keeping(None, "a.png")), (at("a.partial.2.film"), at("a.partial.2.png")));
        let resumed = keeping(Some("a.partial.film"), "a.png");
        assert_eq!(names(&resumed), (at("a.partial.film"), at("a.partial.png")));
        let second = keeping(Some("a.partial.2.film"), "a.png");
        assert_eq!(names(&second), (at("a.partial.2.film"), at("a.partial.2.png")));
        fs::write(at("a.partial.2.png"), "").unwrap();
        assert_eq!(keeping(None, "a.png").file, at("a.partial.3.film"), "the image is there");
        let other = keeping(Some("b.film"), "a.png");
        assert_eq!(names(&other), (at("b.film"), at("a.partial.png")));
        assert_eq!(keeping(Some("a.film"), "a.film").file, at("a.partial.2.film"));
        let long = keeping(None, &format!("{}.png", "é".repeat(125)));
        assert_eq!(long.file, at(&format!("{}.partial.film", "é".repeat(50))));
    }

    #[test]
    fn another_program_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let scene = Scene::load("cornell").unwrap();
        let settings = RenderSettings { width: 2, height: 2, ..RenderSettings::of(&scene) };
        let area = settings.image();
        let checkpoint = Checkpoint {
            scene: "cornell".to_owned(),
            identity: Identity::new(&scene, &settings, area),
            shard: None,
            rendering: Rendering::new(Film::new(area, 0..16).unwrap()),
        };
        for given in [true, false] {
            let args = KeepArgs {
                checkpoint: given.then(|| at("kept.film")),
                checkpoint_every: None,
                time_limit: None,
                resume: None,
            };
            let keeping = args.keeping(&at("a.png"), None, Instant::now());
            let mut place = keeping.place();
            place.keep(&checkpoint).unwrap();
            place.keep(&checkpoint).unwrap();
            let file = place.file().to_owned();
            fs::write(&file, "another's").unwrap();
            let kept = place.keep(&checkpoint);
            assert_eq!(fs::read_to_string(&file).unwrap(), "another's");
            match given {
                true => assert!(kept.unwrap_err().to_string().contains("another program")),
                false => assert_eq!((kept.unwrap(), place.file()), ((), &*at("a.partial.2.film"))),
            }
            place.keep_in_the_end(&checkpoint).unwrap();
            let last = if given { "a.partial.film" } else { "a.partial.2.film" };
            assert_eq!(place.file(), at(last));
            fs::remove_file(place.file()).unwrap();
            place.keep(&checkpoint).unwrap();
            assert_eq!(place.file(), at(last), "what is gone is written again");
            fs::remove_file(place.file()).unwrap();
        }
    }
}
