//! Watches the files of a scene, and reads it again when one has changed.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use super::ViewArgs;
use crate::engine::{ImageSettings, Session};
use crate::error::{Error, Result};
use crate::live::View;
use crate::scene::Scene;

/// How often the files are looked at.
const EVERY: Duration = Duration::from_millis(300);

/// A scene that was read again.
pub(super) type Reloaded = Result<(Session, ImageSettings, Watch)>;

/// The files of a scene.
#[derive(Debug)]
pub(super) struct Watch {
    files: Vec<(PathBuf, Option<SystemTime>)>,
    looked: Instant,
    reads: Option<JoinHandle<Reloaded>>,
}

fn time(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).and_then(|about| about.modified()).ok()
}

impl Watch {
    /// Watches the files of `scene`, which was read from the file `name`, if it is one, after the time `began`.
    pub(super) fn new(name: &str, scene: &Scene, began: SystemTime) -> Self {
        let files = [Path::new(name)].into_iter().chain(scene.files());
        // What has changed since then may not be what was read. Times in the future come from other clocks.
        let now = SystemTime::now();
        let known = |file: &Path| time(file).filter(|time| *time <= began || *time > now);
        let files = files.map(|file| (file.to_owned(), known(file))).collect();
        Self { files, looked: Instant::now(), reads: None }
    }

    /// The scene, if it was read again since the last call. After an error, the next change reads it again.
    pub(super) fn reloaded(&mut self, args: &ViewArgs) -> Option<Reloaded> {
        if let Some(reads) = self.reads.take_if(|reads| reads.is_finished()) {
            let failed = |_| Err(Error::Resource("reading the scene again failed".to_owned()));
            return Some(reads.join().unwrap_or_else(failed));
        }
        if self.reads.is_none() && self.looked.elapsed() >= EVERY {
            self.looked = Instant::now();
            let mut changed = false;
            for (file, known) in &mut self.files {
                let now = time(file);
                changed |= now != *known;
                *known = now;
            }
            if changed {
                let args = args.clone();
                // A thread that cannot be started is tried again at the next change.
                self.reads = thread::Builder::new().spawn(move || read(&args)).ok();
            }
        }
        None
    }
}

/// Reads the scene, and prepares it.
fn read(args: &ViewArgs) -> Reloaded {
    let began = SystemTime::now();
    let scene = args.load()?;
    let settings = args.settings(&scene)?;
    let watch = Watch::new(args.sample.scene.name(), &scene, began);
    let session = Session::new(scene, View::first(&settings), args.compute())?;
    Ok((session, settings, watch))
}
