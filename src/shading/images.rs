//! Reads the images of textures and environment maps.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use crate::checks::Location;
use crate::error::{Error, Result};
use crate::image::{Encoding, Mended, Size, Source, Texels, split_layer};
use crate::input::path_within;
use crate::limits::{Budget, Limit};

/// Finds images that are not files of their own. The module of formats implements it, so that textures know no
/// format of scenes.
pub(crate) trait ImageFiles: Sync {
    /// The content of an image that is compiled into the program, if `path` is one.
    fn embedded(&self, path: &Path) -> Option<&'static [u8]>;

    /// Opens a file that has images in it.
    ///
    /// # Errors
    /// If the file cannot be read, has invalid content, or exceeds a limit.
    fn open<'b>(&self, path: &Path, budget: &'b Budget) -> Result<Box<dyn ImageContainer + 'b>>;
}

/// A file that has images in it.
pub(crate) trait ImageContainer: Send + Sync {
    /// The encoded content of image number `index`.
    fn image(&self, index: usize) -> Result<Cow<'_, [u8]>, String>;
}

/// An image that a texture names.
#[derive(Clone, Copy)]
pub(crate) struct ImageFile<'a> {
    pub(crate) file: &'a str,
    /// Its number, if it is in a file of several.
    pub(crate) index: Option<u32>,
    pub(crate) encoding: Encoding,
}

/// The path of a file, which may end with the name of a layer, and the number and the encoding of an image in it.
type Key = (PathBuf, Option<u32>, Encoding);

/// Reads the images of a scene, each only once.
pub(crate) struct Images<'a> {
    folder: &'a Path,
    budget: &'a Budget,
    images: HashMap<Key, Arc<Texels>>,
    /// The files that have images in them.
    containers: HashMap<PathBuf, Box<dyn ImageContainer + 'a>>,
    files: &'a dyn ImageFiles,
}

impl<'a> Images<'a> {
    pub(crate) fn new(folder: &'a Path, budget: &'a Budget, files: &'a dyn ImageFiles) -> Self {
        Self { folder, budget, images: HashMap::new(), containers: HashMap::new(), files }
    }

    /// Reads images on all threads. Those that cannot be read are left to [`texels`](Self::texels),
    /// which knows where the scene names them.
    pub(crate) fn preload<'t>(&mut self, wanted: impl Iterator<Item = ImageFile<'t>>) {
        let (mut keys, mut seen) = (Vec::new(), HashSet::new());
        for ImageFile { file, index, encoding } in wanted {
            let (own, layer) = split_layer(file);
            let Ok(path) = path_within(self.folder, own, &self.budget.limits) else { continue };
            let key = (with_layer(path, layer), index, encoding);
            if !self.images.contains_key(&key)
                && seen.insert(key.clone())
                && self.open(&key).is_ok()
            {
                keys.push(key);
            }
        }
        // Threads would gain nothing.
        if keys.len() < 2 {
            return;
        }
        let read: Vec<_> = keys.par_iter().map(|key| self.read(key)).collect();
        let read = keys.into_iter().zip(read);
        self.images.extend(read.filter_map(|(key, image)| Some((key, Arc::new(image.ok()?)))));
    }

    /// Reads the image in `file`, or image number `index` of it. With `outside`, it may be outside the folder of
    /// the scene.
    pub(crate) fn texels(
        &mut self,
        e: &Location<'_>,
        wanted: ImageFile<'_>,
        outside: bool,
    ) -> Result<Arc<Texels>> {
        let ImageFile { file, index, encoding } = wanted;
        let (own, layer) = split_layer(file);
        let path = match outside {
            true => self.folder.join(own),
            false => e.path_within(self.folder, own, &self.budget.limits)?,
        };
        let key = (with_layer(path, layer), index, encoding);
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let failed = |error: Error| error.of_file(|error| e.error(error));
        self.open(&key).map_err(failed)?;
        let texels = Arc::new(self.read(&key).map_err(failed)?);
        self.images.insert(key, Arc::clone(&texels));
        Ok(texels)
    }

    /// Opens the file that an image is in.
    fn open(&mut self, (path, index, _): &Key) -> Result<()> {
        if index.is_some() && !self.containers.contains_key(path) {
            self.containers.insert(path.clone(), self.files.open(path, self.budget)?);
        }
        Ok(())
    }

    /// Reads an image, whose container is open.
    fn read(&self, (path, index, encoding): &Key) -> Result<Texels> {
        let budget = self.budget;
        let held = Cell::new(0);
        let allow = |size: Size| {
            budget.limits.check(Limit::TextureBytes, Texels::bytes_of(size))?;
            let more = size.memory.saturating_sub(held.get());
            budget.hold(more)?;
            held.set(held.get() + more);
            Ok(())
        };
        let bad = |message: String| Error::input(path.display().to_string(), "", message);
        let read = |source: &Source<'_>| Texels::read(source, *encoding, &allow);
        let texels = match (*index, self.files.embedded(path)) {
            (None, None) => read(&Source::file(path)),
            (None, Some(bytes)) => read(&Source::part(path, 0, bytes)),
            (Some(index), _) => {
                let bytes = self.containers[path].image(index as usize).map_err(bad)?;
                read(&Source::part(path, index, &bytes))
            }
        };
        budget.release(held.get());
        let texels = texels?;
        budget.hold(texels.bytes()).map_err(bad)?;
        Ok(texels)
    }

    /// A sentence about all texels whose values were mended, if there are any.
    pub(crate) fn mended(&self) -> Option<String> {
        let (mut files, mut all) = (BTreeSet::new(), Mended::default());
        for ((path, ..), texels) in &self.images {
            if texels.mended() != Mended::default() {
                files.insert(path);
                all += texels.mended();
            }
        }
        let (first, sentence) = (files.first()?.display(), all.sentence()?);
        Some(match files.len() {
            1 => format!("{first}: {sentence}"),
            more => format!("{first} and {} more: {sentence}", more - 1),
        })
    }

    /// Holds memory for tables that belong to an image, unless it exceeds the limit.
    pub(crate) fn hold(&self, e: &Location<'_>, bytes: u64) -> Result<()> {
        self.budget.hold(bytes).map_err(|message| e.error(message))
    }

    /// The paths of all files that were read.
    pub(crate) fn files(self) -> impl Iterator<Item = PathBuf> + use<'a> {
        let (files, paths) = (self.files, self.images.into_keys().map(|(path, ..)| path));
        let paths = paths.filter(|path| files.embedded(path).is_none());
        paths.map(|path| match path.to_str().map(split_layer) {
            Some((file, Some(_))) => file.into(),
            _ => path,
        })
    }
}

/// The path of a layer of a file.
fn with_layer(path: PathBuf, layer: Option<&str>) -> PathBuf {
    let Some(layer) = layer else { return path };
    let mut path = path.into_os_string();
    path.push(format!(":{layer}"));
    path.into()
}
