//! Where a render is kept, and that nothing is replaced that would be lost.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, ErrorKind};
use std::mem;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::share::Share;
use crate::checkpoint::{Checkpoint, Identity};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::output::same_file;

/// `NAME.partial.EXT`, `NAME.partial.2.EXT` and so on beside `NAME.png`.
struct Names(PathBuf);

/// Bytes of a name that are kept, so that there is room for more.
const MOST_STEM: usize = 200;
/// Films of one image that are told by their names, at most.
const MOST_OWN: u32 = 10_000;

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

    /// The films that are not there yet, and neither are their images.
    fn free_films(&self) -> impl Iterator<Item = PathBuf> {
        let is_free = |path: PathBuf| fs::symlink_metadata(path).is_err();
        let are_free =
            move |&number: &u32| is_free(self.film(number)) && is_free(self.image(number));
        (1..).filter(are_free).map(|number| self.film(number))
    }

    fn free_film(&self) -> PathBuf {
        self.free_films().next().expect("no folder is so full")
    }

    fn film(&self, number: u32) -> PathBuf {
        self.name(number, OsStr::new("film"))
    }

    fn image(&self, number: u32) -> PathBuf {
        self.name(number, self.0.extension().unwrap_or_default())
    }

    /// That of `film`; of one that the user named, the first that is of no film here.
    fn image_of(&self, film: &Path) -> PathBuf {
        let is_it = |&number: &u32| {
            let own = self.film(number);
            own.file_name() == film.file_name() && same_file(&own, film)
        };
        let is_free = |&number: &u32| fs::symlink_metadata(self.film(number)).is_err();
        let number = (1..MOST_OWN).find(is_it).or_else(|| (1..).find(is_free));
        self.image(number.expect("no folder is so full"))
    }
}

/// A place for checkpoints that nobody else is to take.
pub(super) struct Place {
    file: PathBuf,
    /// Whether the user named it.
    is_given: bool,
    names: Names,
    /// When the file was changed last by this program; none while it is not there.
    last: Option<SystemTime>,
    /// What is gone on with, if that is another file: it has more until the render is kept here.
    resumed: Option<PathBuf>,
    is_kept: bool,
}

impl Place {
    /// The file that is given, or else one beside `output`, for what goes on from `resumed`.
    pub(super) fn new(output: &Path, given: Option<&Path>, resumed: Option<&Path>) -> Self {
        let names = Names(output.to_owned());
        let file = given.map_or_else(|| names.free_film(), Path::to_owned);
        let resumed = resumed.filter(|resumed| !same_file(resumed, &file)).map(Path::to_owned);
        Self {
            last: changed(&file),
            file,
            is_given: given.is_some(),
            names,
            resumed,
            is_kept: false,
        }
    }

    /// Leaves the file as it is, which is what is gone on with, and takes one beside the image.
    pub(super) fn leave(&mut self) {
        self.resumed = Some(mem::replace(&mut self.file, self.names.free_film()));
        (self.is_given, self.last) = (false, None);
    }

    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// How many samples there are of this render already.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is something else, which would be lost: it says what to do.
    pub(super) fn done(&self, identity: &Identity, share: &Share, limits: &Limits) -> Result<u64> {
        if fs::metadata(&self.file).is_err_and(|error| error.kind() == ErrorKind::NotFound) {
            return Ok(0);
        }
        let file = self.file.display();
        let refused = |what: &dyn std::fmt::Display| {
            Error::Usage(format!("{what}: name another file for --checkpoint, or remove it"))
        };
        let there = Checkpoint::read(&self.file, limits).map_err(|error| refused(&error))?;
        if !there.is_of(identity, share.shard, &share.samples) {
            return Err(refused(&format_args!("{file} is of another render")));
        }
        Ok(there.rendering.film.samples_done())
    }

    /// That there is so much of this render, and less would take its place.
    pub(super) fn has_more(&self, percent: u64) -> Error {
        let file = self.file.display();
        Error::Usage(format!(
            "{file} has {percent}% of this render: go on with --resume {file}, or remove it"
        ))
    }

    fn kept(&mut self) {
        (self.last, self.is_kept) = (changed(&self.file), true);
    }

    /// Writes `checkpoint`: under another name, where another program has taken that which was free.
    ///
    /// # Errors
    /// Where it cannot be written, or another program writes the file that the user named.
    pub(super) fn keep(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let pending = checkpoint.pending(&self.file)?;
        let failed = |error| Error::io(&self.file, "write")(error);
        let is_there = changed(&self.file).is_some();
        if self.is_as_it_was() {
            pending.replace(&self.file)?;
        } else if !self.is_given {
            self.file = pending.name(self.names.free_films()).map_err(failed)?;
        } else if is_there || !pending.create(&self.file)? {
            return Err(failed(io::Error::other("another program has changed it")));
        }
        self.kept();
        Ok(())
    }

    /// Writes `checkpoint`, the last of this run: under another name, where that of the user cannot be had.
    ///
    /// # Errors
    /// Where it cannot be written by any name.
    pub(super) fn keep_in_the_end(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let Err(error) = self.keep(checkpoint) else { return Ok(()) };
        let pending = checkpoint.pending(&self.names.free_film());
        let named = pending.ok().and_then(|file| file.name(self.names.free_films()).ok());
        self.file = named.ok_or(error)?;
        self.kept();
        Ok(())
    }

    /// The file that has the most of the render, where this is not kept.
    pub(super) fn earlier(&self) -> Option<&Path> {
        let own = self.is_as_it_was().then_some(&*self.file);
        let resumed = self.resumed.as_deref();
        if self.is_kept { own.or(resumed) } else { resumed.or(own) }
    }

    /// Whether there is a checkpoint as this program left it, or found it.
    fn is_as_it_was(&self) -> bool {
        self.last.is_some() && changed(&self.file) == self.last
    }

    /// Where the image is shown as far as it is, beside the checkpoint that was written last.
    pub(super) fn image(&self) -> PathBuf {
        self.names.image_of(&self.file)
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
    fn files_that_are_there_keep_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let place = |given: Option<&str>, output: &str| {
            let place = Place::new(&at(output), given.map(at).as_deref(), None);
            (place.file().to_owned(), place.image())
        };
        assert_eq!(place(None, "a.png"), (at("a.partial.film"), at("a.partial.png")));
        fs::write(at("a.partial.film"), "").unwrap();
        assert_eq!(place(None, "a.png"), (at("a.partial.2.film"), at("a.partial.2.png")));
        let resumed = place(Some("a.partial.film"), "a.png");
        assert_eq!(resumed, (at("a.partial.film"), at("a.partial.png")));
        let second = place(Some("a.partial.2.film"), "a.png");
        assert_eq!(second, (at("a.partial.2.film"), at("a.partial.2.png")));
        fs::write(at("a.partial.2.png"), "").unwrap();
        assert_eq!(place(None, "a.png").0, at("a.partial.3.film"), "the image is there");
        let other = place(Some("b.film"), "a.png");
        assert_eq!(other, (at("b.film"), at("a.partial.2.png")), "the first is of a.partial.film");
        assert_eq!(place(Some("b.film"), "c.png").1, at("c.partial.png"));
        let long = place(None, &format!("{}.png", "é".repeat(125)));
        assert_eq!(long.0, at(&format!("{}.partial.film", "é".repeat(50))));
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
            let kept = at("kept.film");
            let mut place = Place::new(&at("a.png"), given.then_some(&*kept), None);
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
