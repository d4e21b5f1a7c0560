//! Files that a command reads and writes: none twice.

use std::iter;
use std::path::Path;

use crate::error::{Error, Result};
use crate::output::{check_writable, same_file};
use crate::scene::Scene;

/// A file, and what it is: "the record".
pub(super) type Named<'a> = (&'a str, &'a Path);

/// The files that `scene` was read from, which the user calls `name`.
pub(super) fn of_scene<'a>(name: &'a str, scene: &'a Scene) -> Vec<Named<'a>> {
    let parts = scene.files().map(|file| ("a part of the scene", file));
    iter::once(("the scene", Path::new(name))).chain(parts).collect()
}

/// Finds out, before the work is done, whether every file of `written` can be written and is another one
/// than the others and those of `read`.
///
/// # Errors
/// Where one is not.
pub(super) fn check(read: &[Named<'_>], written: &[Named<'_>]) -> Result<()> {
    for (number, (name, file)) in written.iter().enumerate() {
        let same = |(_, other): &&Named<'_>| same_file(other, file);
        if let Some((other, _)) = written[..number].iter().find(same) {
            let message = format!("{}: {other} and {name} need two files", file.display());
            return Err(Error::Usage(message));
        }
        if let Some((other, path)) =
            read.iter().find(|(_, path)| path.is_file() && same_file(path, file))
        {
            let message = format!("{}: {name} would replace {other}", path.display());
            return Err(Error::Usage(message));
        }
        check_writable(file)?;
    }
    Ok(())
}
