//! Checks of the files that a command reads and writes.

use std::iter;
use std::path::Path;

use crate::error::{Error, Result};
use crate::output::{check_writable, same_file};
use crate::scene::Scene;

/// A file with its role in messages, such as "the record".
pub(crate) type Named<'a> = (&'a str, &'a Path);

/// The files that the scene `name` was read from.
pub(crate) fn of_scene<'a>(name: &'a str, scene: &'a Scene) -> Vec<Named<'a>> {
    let parts = scene.files().map(|file| ("a part of the scene", file));
    iter::once(("the scene", Path::new(name))).chain(parts).collect()
}

/// Checks, before the work begins, that every file of `written` can be written, and differs from the others and
/// from those of `read`.
///
/// # Errors
/// If a file fails a check.
pub(crate) fn check(read: &[Named<'_>], written: &[Named<'_>]) -> Result<()> {
    for (number, (name, file)) in written.iter().enumerate() {
        let same = |(_, other): &&Named<'_>| same_file(other, file);
        if let Some((other, _)) = written[..number].iter().find(same) {
            let message = format!("{}: {other} and {name} need different files", file.display());
            return Err(Error::Usage(message));
        }
        if let Some((other, path)) =
            read.iter().find(|(_, path)| path.is_file() && same_file(path, file))
        {
            let message = format!("{}: {name} would overwrite {other}", path.display());
            return Err(Error::Usage(message));
        }
        check_writable(file)?;
    }
    Ok(())
}
