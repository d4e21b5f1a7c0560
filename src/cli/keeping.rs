//! Where a render is kept, and when.

use std::ffi::{OsStr, OsString};
use std::fs;
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
    /// The image as far as it is, when it is stopped; none for those who want no image.
    pub(super) partial: Option<(PathBuf, Transfer)>,
    /// Another name for the checkpoint, where another program has taken the first meanwhile; none where the user
    /// gave it.
    names: Option<Names>,
    /// What an earlier run left, which is of no use when all is done.
    leftovers: Vec<PathBuf>,
}

/// `NAME.partial.EXT`, `NAME.partial.2.EXT` and so on beside `NAME.png`.
struct Names(PathBuf);

impl Names {
    fn name(&self, number: u32, extension: &OsStr) -> PathBuf {
        let mut name = OsString::from(self.0.file_stem().unwrap_or_default());
        name.push(".partial.");
        if number > 1 {
            name.push(format!("{number}."));
        }
        name.push(extension);
        self.0.with_file_name(name)
    }

    /// The number of the first film that is not there yet.
    fn free(&self) -> u32 {
        let is_free = |number: &u32| !self.film(*number).exists();
        (1..).find(is_free).expect("no folder is so full")
    }

    fn film(&self, number: u32) -> PathBuf {
        self.name(number, OsStr::new("film"))
    }
}

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
        let number = if given.is_some() { 1 } else { names.free() };
        let image = |number| names.name(number, output.extension().unwrap_or_default());
        // Those of this render's own making, by their names.
        let mut own = (1..100).map(|number| (names.film(number), image(number)));
        let left = resumed
            .filter(|_| self.checkpoint.is_none())
            .and_then(|file| own.find(|(film, _)| same_file(film, file)));
        Keeping {
            file: given.cloned().unwrap_or_else(|| names.film(number)),
            every: self.checkpoint.as_ref().map(|_| self.checkpoint_every.unwrap_or(INTERVAL)),
            time_limit: self.time_limit,
            start,
            partial: transfer.map(|transfer| (image(number), transfer)),
            leftovers: left.map_or_else(Vec::new, |(film, image)| vec![film, image]),
            names: given.is_none().then_some(names),
        }
    }
}

impl Keeping {
    /// Refuses to replace what is not of this render, or more of it: it would be lost.
    ///
    /// # Errors
    /// [`Error::Usage`] that says what to do.
    pub(super) fn check(&self, identity: &Identity, share: &Share, limits: &Limits) -> Result<()> {
        if fs::symlink_metadata(&self.file).is_err() {
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
        // What is complete will be the same again.
        if there.is_complete() || there.rendering.film.samples_done() == 0 {
            return Ok(());
        }
        let percent = there.percent();
        Err(Error::Usage(format!(
            "{file} has {percent}% of this render: go on with --resume {file}, or remove it"
        )))
    }

    /// For this run.
    pub(super) fn place(&self) -> Place<'_> {
        Place { file: self.file.clone(), names: self.names.as_ref(), last: changed(&self.file) }
    }

    /// Removes what an earlier run left, now that all is done.
    pub(super) fn clean_up(&self) {
        for file in &self.leftovers {
            // They are in nobody's way.
            let _ = fs::remove_file(file);
        }
    }
}

/// A place for checkpoints that nobody else is to take.
pub(super) struct Place<'a> {
    file: PathBuf,
    names: Option<&'a Names>,
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
        if changed(&self.file) != self.last {
            let Some(names) = self.names else {
                let error = std::io::Error::other("another program writes it, too");
                return Err(Error::io(&self.file, "write")(error));
            };
            self.file = names.film(names.free());
        }
        checkpoint.write(&self.file)?;
        self.last = changed(&self.file);
        Ok(())
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
        let names = |keeping: &Keeping| (keeping.file.clone(), keeping.partial.clone().unwrap().0);
        assert_eq!(names(&keeping(None, "a.png")), (at("a.partial.film"), at("a.partial.png")));
        fs::write(at("a.partial.film"), "").unwrap();
        assert_eq!(names(&keeping(None, "a.png")), (at("a.partial.2.film"), at("a.partial.2.png")));
        let resumed = keeping(Some("a.partial.film"), "a.png");
        assert_eq!(names(&resumed), (at("a.partial.film"), at("a.partial.png")));
        assert_eq!(resumed.leftovers, [at("a.partial.film"), at("a.partial.png")]);
        let other = keeping(Some("b.film"), "a.png");
        assert_eq!((other.file, other.leftovers), (at("b.film"), Vec::new()));
        assert_eq!(keeping(Some("a.film"), "a.film").file, at("a.partial.2.film"));
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
        }
    }
}
