//! Files that appear whole or not at all.

mod temporary;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::iter;
use std::path::{Path, PathBuf};

use self::temporary::Temporary;
use crate::error::{Error, Result};

/// Links that are followed from one to the next.
const MOST_LINKS: usize = 40;

/// Calls `fill` with a temporary file, which takes the place of `path` once it is complete. On failure `path` is
/// what it was and the temporary file is gone; a process that is killed leaves one only in the moment before it
/// takes its place, or where the file system has no files without a name.
///
/// # Errors
/// Where `path` is something else than a file, its folder cannot be written, or `fill` fails.
pub(crate) fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
) -> Result<()> {
    Pending::new(path, fill)?.replace(path)
}

/// A file that is on the disk, and has no name yet: it is gone with the process.
#[must_use]
pub(crate) struct Pending(Temporary);

impl Pending {
    /// Calls `fill` with a file that is to be in the folder of `path`, or where the link `path` leads to.
    ///
    /// # Errors
    /// As [`write_atomically`].
    pub(crate) fn new(
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
    ) -> Result<Self> {
        let failed = |source| Error::io(path, "write")(source);
        let target = resolve(path).map_err(failed)?;
        let temporary = Temporary::in_folder(folder_of(&target)).map_err(failed)?;
        if let Ok(replaced) = fs::metadata(&target) {
            // A file that is private stays so.
            let _ = temporary.file().set_permissions(replaced.permissions());
        }
        let mut writer = BufWriter::new(temporary.file());
        fill(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
        drop(writer);
        // Some file systems report a full disk only now.
        temporary.file().sync_all().map_err(failed)?;
        Ok(Self(temporary))
    }

    /// Puts it in the place of `path`, or of the file where that leads to.
    ///
    /// # Errors
    /// Where that cannot be.
    pub(crate) fn replace(self, path: &Path) -> Result<()> {
        let failed = Error::io(path, "write");
        resolve(path).and_then(|target| self.0.persist(&target)).map_err(failed)
    }

    /// Puts it at `path`, or where the link `path` leads to, where no file is yet: else returns false.
    ///
    /// # Errors
    /// Where it cannot be put there.
    pub(crate) fn create(self, path: &Path) -> Result<bool> {
        match resolve(path).and_then(|target| self.name(iter::once(target))) {
            Ok(_) => Ok(true),
            Err(taken) if taken.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(Error::io(path, "write")(error)),
        }
    }

    /// Gives it the first of `names`, all in its folder, that nobody has taken, and tells which that is.
    ///
    /// # Errors
    /// Where it cannot have one.
    pub(crate) fn name(self, names: impl Iterator<Item = PathBuf>) -> io::Result<PathBuf> {
        self.0.persist_new(names)
    }
}

/// Finds out whether [`write_atomically`] could begin to write `path`, so that a long render
/// need not end in vain. Leaves nothing behind.
///
/// # Errors
/// As [`write_atomically`].
pub(crate) fn check_writable(path: &Path) -> Result<()> {
    let temporary = resolve(path).and_then(|target| Temporary::in_folder(folder_of(&target)));
    temporary.map(drop).map_err(Error::io(path, "write"))
}

/// Finds out whether files can be written into `folder`, or into the nearest one above it that is
/// there, so that a long run need not end in vain. Leaves nothing behind.
///
/// # Errors
/// Where they cannot.
pub(crate) fn check_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    Temporary::in_folder(there).map(drop).map_err(Error::io(folder, "make the folder"))
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

/// The file that `path` stands for, there or not: links are followed, folders and devices refused, and what stands
/// for an open file, whose name nobody knows.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(folder) = fs::canonicalize(folder_of(&path)) else { return Ok(path) };
        if folder.starts_with("/proc") {
            return Err(io::Error::other("it stands for an open file or for none"));
        }
        let found = match fs::symlink_metadata(&path) {
            Ok(found) => found,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(path),
            Err(error) => return Err(error),
        };
        match found.file_type() {
            kind if kind.is_symlink() => path = folder.join(fs::read_link(&path)?),
            kind if kind.is_file() => return Ok(path),
            kind if kind.is_dir() => return Err(io::Error::other("it is a folder")),
            _ => return Err(io::Error::other("it is a device or pipe, not a file")),
        }
    }
    Err(io::Error::other("its links lead nowhere"))
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

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_modes_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let text = |name: &str| fs::read_to_string(at(name)).unwrap();
        let write = |name: &str, text: &str| {
            write_atomically(&at(name), |file| file.write_all(text.as_bytes()))
        };
        fs::create_dir(at("d")).unwrap();
        symlink("d/there", at("link")).unwrap();
        symlink("link", at("more")).unwrap();
        write("more", "one").unwrap();
        assert_eq!(text("d/there"), "one", "through links that led to nothing");
        fs::set_permissions(at("d/there"), fs::Permissions::from_mode(0o600)).unwrap();
        write("link", "two").unwrap();
        assert_eq!((text("d/there"), text("more")), ("two".to_owned(), "two".to_owned()));
        assert_eq!(fs::metadata(at("d/there")).unwrap().permissions().mode() & 0o777, 0o600);
        symlink("d/new", at("new")).unwrap();
        let pending = || Pending::new(&at("new"), |file| file.write_all(b"first")).unwrap();
        assert!(pending().create(&at("new")).unwrap() && !pending().create(&at("new")).unwrap());
        assert_eq!(text("d/new"), "first");
        symlink("round", at("round")).unwrap();
        symlink("/proc/self/fd/1", at("stdout")).unwrap();
        for (name, says) in [
            ("round", "lead nowhere"),
            ("stdout", "an open file"),
            ("d", "a folder"),
            (&"n".repeat(300), "too long"),
        ] {
            let refused = write(name, "three").unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 6);
    }
}
