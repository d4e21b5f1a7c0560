//! Files that appear whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Calls `fill` with a temporary file beside `path`, which takes the place of `path` once
/// it is complete. On failure `path` is what it was and the temporary file is gone.
///
/// # Errors
/// Where `path` is something else than a file, its folder cannot be written, or `fill` fails.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
) -> Result<()> {
    let failed = |source| Error::io(path, "write")(source);
    let (target, file) = temporary_beside(path).map_err(failed)?;
    let mut writer = BufWriter::new(file.as_file());
    fill(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
    drop(writer);
    // Some file systems report a full disk only now.
    file.as_file().sync_all().map_err(failed)?;
    file.persist(&target).map_err(|e| failed(e.error))?;
    Ok(())
}

/// Finds out whether [`write_atomically`] could begin to write `path`, so that a long render
/// need not end in vain. Leaves nothing behind.
///
/// # Errors
/// As [`write_atomically`].
pub fn check_writable(path: &Path) -> Result<()> {
    temporary_beside(path).map(drop).map_err(Error::io(path, "write"))
}

/// Finds out whether files can be written into `folder`, or into the nearest one above it that is
/// there, so that a long run need not end in vain. Leaves nothing behind.
///
/// # Errors
/// Where they cannot.
pub fn check_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    temporary_in(there).map(drop).map_err(Error::io(folder, "make the folder"))
}

/// The file that `path` stands for, and an empty temporary file in its folder.
fn temporary_beside(path: &Path) -> io::Result<(PathBuf, tempfile::NamedTempFile)> {
    let target = resolve(path)?;
    let file = temporary_in(folder_of(&target))?;
    Ok((target, file))
}

/// Whether two paths stand for one file, which need not be there yet.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let target = resolve(path).ok()?;
        let folder = fs::canonicalize(folder_of(&target)).ok()?;
        Some(folder.join(target.file_name()?))
    };
    a == b || place(a).is_some_and(|a| place(b) == Some(a))
}

/// The folder that a file is in.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An empty temporary file in `folder`.
fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ptfast-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As any new file: 0666 less the umask, not the 0600 of private temporaries.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // The crate's errors speak of the temporary file's name, which says nothing.
    fs::metadata(folder)?;
    builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()))
}

/// The file that `path` stands for: links are followed, folders and devices refused.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => fs::canonicalize(path),
        Ok(found) if found.is_dir() => Err(io::Error::other("it is a folder")),
        Ok(_) => Err(io::Error::other("it is a device or pipe, not a file")),
        Err(_) => Ok(path.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pfm");
        fs::write(&path, "old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("the disk is full"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
