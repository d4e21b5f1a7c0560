//! Files that have no place yet.

use std::fs;
use std::io::{self, ErrorKind, Seek};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, PathPersistError, TempPath};

use super::folder_of;

/// A file that is not yet there.
pub(super) enum Temporary {
    /// Without a name, where the file system has such: it is gone with the process.
    Unnamed(fs::File, PathBuf),
    Named(NamedTempFile),
}

impl Temporary {
    pub(super) fn in_folder(folder: &Path) -> io::Result<Self> {
        // The crate's errors speak of the temporary file's name, which says nothing.
        fs::metadata(folder)?;
        match unnamed(folder) {
            Some(file) => Ok(Self::Unnamed(file, folder.to_owned())),
            None => {
                let named = builder().tempfile_in(folder).map(Self::Named);
                named.map_err(|error| io::Error::from(error.kind()))
            }
        }
    }

    pub(super) fn file(&self) -> &fs::File {
        match self {
            Self::Unnamed(file, _) => file,
            Self::Named(file) => file.as_file(),
        }
    }

    /// Puts it in the place of `target`, in the same folder.
    pub(super) fn persist(self, target: &Path) -> io::Result<()> {
        self.named()?.persist(target).map_err(|error| error.error)?;
        sync_folder(target);
        Ok(())
    }

    /// Gives it the first of `names`, all in its folder, that no file has.
    pub(super) fn persist_new(self, names: impl Iterator<Item = PathBuf>) -> io::Result<PathBuf> {
        let mut path = self.named()?;
        for name in names {
            let named = path.persist_noclobber(&name).or_else(|failed| match failed.error.kind() {
                ErrorKind::AlreadyExists => Err(failed),
                // Not every file system can do that.
                _ => take(failed.path, &name),
            });
            match named {
                Ok(()) => {
                    sync_folder(&name);
                    return Ok(name);
                }
                Err(taken) if taken.error.kind() == ErrorKind::AlreadyExists => path = taken.path,
                Err(failed) => return Err(failed.error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    fn named(self) -> io::Result<TempPath> {
        match self {
            Self::Named(file) => Ok(file.into_temp_path()),
            Self::Unnamed(file, folder) => {
                match builder().make_in(&folder, |path| link(&file, path)) {
                    Ok(named) => Ok(named.into_temp_path()),
                    // Not every process may do that.
                    Err(_) => copy(&file, &folder),
                }
            }
        }
    }
}

/// Gives `path` the name, if no file has it: in two steps, between which another program might take it.
fn take(path: TempPath, name: &Path) -> Result<(), PathPersistError> {
    match fs::symlink_metadata(name) {
        Ok(_) => Err(PathPersistError { error: ErrorKind::AlreadyExists.into(), path }),
        Err(_) => path.persist(name),
    }
}

/// Has the name of `file` outlive a crash of the machine, where the file system can.
fn sync_folder(file: &Path) {
    let _ = fs::File::open(folder_of(file)).and_then(|folder| folder.sync_all());
}

/// A file in `folder` with the content of `file`.
fn copy(mut file: &fs::File, folder: &Path) -> io::Result<TempPath> {
    let mut named = builder().tempfile_in(folder)?;
    file.rewind()?;
    io::copy(&mut file, named.as_file_mut())?;
    named.as_file().set_permissions(file.metadata()?.permissions())?;
    named.as_file().sync_all()?;
    Ok(named.into_temp_path())
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ptfast-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As any new file: 0666 less the umask, not the 0600 of private temporaries.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// An empty file in `folder` that has no name yet.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<fs::File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666)).ok()?;
    Some(file.into())
}

#[cfg(not(target_os = "linux"))]
fn unnamed(_: &Path) -> Option<fs::File> {
    None
}

/// Gives `file` the name `path`.
#[cfg(target_os = "linux")]
fn link(file: &fs::File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD};
    use std::os::fd::AsRawFd;
    let open = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(rustix::fs::linkat(CWD, open, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn link(_: &fs::File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn files_are_copied_where_they_cannot_be_named() {
        let folder = tempfile::tempdir().unwrap();
        let temporary = Temporary::in_folder(folder.path()).unwrap();
        temporary.file().write_all(b"content").unwrap();
        let path = folder.path().join("a.pfm");
        copy(temporary.file(), folder.path()).unwrap().persist(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"content");
    }

    #[test]
    fn names_that_are_taken_stay_so() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: u32| folder.path().join(name.to_string());
        for number in 0..3 {
            let temporary = Temporary::in_folder(folder.path()).unwrap();
            temporary.file().write_all(number.to_string().as_bytes()).unwrap();
            assert_eq!(temporary.persist_new((0..).map(at)).unwrap(), at(number));
        }
        for number in 0..3 {
            assert_eq!(fs::read_to_string(at(number)).unwrap(), number.to_string());
        }
        let temporary = Temporary::in_folder(folder.path()).unwrap();
        let refused = temporary.persist_new((0..3).map(at)).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[test]
    fn names_are_taken_in_two_steps() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("a.film");
        let path = |text: &str| {
            let mut named = builder().tempfile_in(folder.path()).unwrap();
            named.write_all(text.as_bytes()).unwrap();
            named.into_temp_path()
        };
        take(path("one"), &name).unwrap();
        let taken = take(path("two"), &name).unwrap_err();
        assert_eq!(taken.error.kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&taken.path).unwrap(), "two");
        drop(taken);
        let gone = path("three");
        fs::remove_file(&gone).unwrap();
        let other = folder.path().join("b.film");
        assert!(take(gone, &other).is_err() && !other.exists());
        assert_eq!(fs::read_to_string(&name).unwrap(), "one");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn files_with_and_without_a_name_take_the_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pfm");
        let named = || Ok(Temporary::Named(builder().tempfile_in(folder.path())?));
        let usual = || Temporary::in_folder(folder.path());
        let makers: [(&str, &dyn Fn() -> io::Result<Temporary>); 3] =
            [("one", &usual), ("two", &named), ("three", &usual)];
        for (text, make) in makers {
            let temporary = make().unwrap();
            temporary.file().write_all(text.as_bytes()).unwrap();
            temporary.persist(&path).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }
}
