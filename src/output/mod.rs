//! Writes files atomically: they appear complete or not at all.

mod temporary;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use self::temporary::Temporary;
use crate::error::{Error, Result};

/// Largest number of symbolic links that are followed.
const MOST_LINKS: usize = 40;

/// Calls `fill` with a temporary file, which replaces `path` once it is complete and on the disk.
/// After an error `path` is unchanged, and the temporary file is removed. If the process is killed,
/// a temporary file can remain only if the file system does not support unnamed files, or if the
/// process is killed during the replacement.
///
/// # Errors
/// If `path` is not a regular file, its folder cannot be written, or `fill` fails.
pub(crate) fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
) -> Result<()> {
    write_atomically_if(path, || Ok(()), fill)
}

/// Does the same as [`write_atomically`], but calls `check` just before the replacement.
///
/// # Errors
/// As [`write_atomically`], and those of `check`.
pub(crate) fn write_atomically_if(
    path: &Path,
    check: impl FnOnce() -> Result<()>,
    fill: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
) -> Result<()> {
    let write = || {
        let target = resolve(path)?;
        let temporary = Temporary::in_folder(folder_of(&target))?;
        if let Ok(replaced) = fs::metadata(&target) {
            // Keep the permissions of the replaced file, so that a private file stays private.
            let _ = temporary.file().set_permissions(replaced.permissions());
        }
        let mut writer = BufWriter::new(temporary.file());
        fill(&mut writer)?;
        writer.flush()?;
        drop(writer);
        // Some file systems report a full disk only now.
        temporary.file().sync_all()?;
        Ok((temporary, target))
    };
    let (temporary, target) = write().map_err(Error::io(path, "write"))?;
    check()?;
    temporary.persist(&target).map_err(Error::io(path, "write"))
}

/// Checks that [`write_atomically`] could start to write `path`, so that a long render does not
/// fail at its end. Leaves no file behind.
///
/// # Errors
/// As [`write_atomically`].
pub(crate) fn check_writable(path: &Path) -> Result<()> {
    let temporary = resolve(path).and_then(|target| Temporary::in_folder(folder_of(&target)));
    temporary.map(drop).map_err(Error::io(path, "write"))
}

/// Checks that files can be written into `folder`, or into its nearest existing ancestor, so that a
/// long run does not fail at its end. Leaves no file behind.
///
/// # Errors
/// If files cannot be written there.
pub(crate) fn check_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    Temporary::in_folder(there).map(drop).map_err(Error::io(folder, "create the folder"))
}

/// Whether two paths refer to the same file, which need not exist yet.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let target = resolve(path).ok()?;
        let folder = fs::canonicalize(folder_of(&target)).ok()?;
        Some(folder.join(target.file_name()?))
    };
    a == b || place(a).is_some_and(|a| place(b) == Some(a))
}

/// The folder that contains `file`.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file that `path` refers to, which need not exist. Follows links, and rejects folders,
/// devices and entries of `/proc`, which stand for open files with unknown names.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(folder) = fs::canonicalize(folder_of(&path)) else { return Ok(path) };
        if folder.starts_with("/proc") {
            return Err(io::Error::other("it is under /proc, where files cannot be replaced"));
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
    Err(io::Error::other("it leads through too many symbolic links, or they form a loop"))
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

    #[test]
    fn a_failed_check_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        fs::write(&path, "old").unwrap();
        let refuse = || Err(Error::Usage("it belongs to another render".to_owned()));
        let error = write_atomically_if(&path, refuse, |file| file.write_all(b"new")).unwrap_err();
        assert_eq!(error.to_string(), "it belongs to another render");
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
        assert_eq!(text("d/there"), "one", "the target of dangling links is created");
        fs::set_permissions(at("d/there"), fs::Permissions::from_mode(0o600)).unwrap();
        write("link", "two").unwrap();
        assert_eq!((text("d/there"), text("more")), ("two".to_owned(), "two".to_owned()));
        assert_eq!(fs::metadata(at("d/there")).unwrap().permissions().mode() & 0o777, 0o600);
        symlink("round", at("round")).unwrap();
        symlink("/proc/self/fd/1", at("stdout")).unwrap();
        for (name, says) in [
            ("round", "too many symbolic links"),
            ("stdout", "under /proc"),
            ("d", "a folder"),
            (&"n".repeat(300), "too long"),
        ] {
            let refused = write(name, "three").unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5);
    }
}
