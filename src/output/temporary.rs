//! Temporary files, which replace their target once they are complete.

use std::fs;
use std::io::{self, Seek};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use super::folder_of;

/// A file that has not replaced its target yet.
pub(super) enum Temporary {
    /// An unnamed file, which disappears with the process, and the folder in which it was created.
    /// Used if the file system supports unnamed files.
    Unnamed(fs::File, PathBuf),
    /// A file with a temporary name.
    Named(NamedTempFile),
}

impl Temporary {
    pub(super) fn in_folder(folder: &Path) -> io::Result<Self> {
        // Check the folder here: the crate's errors name the temporary file, which means nothing to
        // users.
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

    /// Replaces `target`, which must be in the same folder.
    pub(super) fn persist(self, target: &Path) -> io::Result<()> {
        self.named()?.persist(target).map_err(|error| error.error)?;
        sync_folder(target);
        Ok(())
    }

    fn named(self) -> io::Result<TempPath> {
        match self {
            Self::Named(file) => Ok(file.into_temp_path()),
            Self::Unnamed(file, folder) => {
                match builder().make_in(&folder, |path| link(&file, path)) {
                    Ok(named) => Ok(named.into_temp_path()),
                    // Not every process is allowed to link an unnamed file.
                    Err(_) => copy(&file, &folder),
                }
            }
        }
    }
}

/// Makes the name of `file` survive a crash of the machine, if the file system supports that.
fn sync_folder(file: &Path) {
    let _ = fs::File::open(folder_of(file)).and_then(|folder| folder.sync_all());
}

/// Copies `file` to a new file in `folder`.
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
        // The permissions of any new file: 0666 minus the umask, instead of the 0600 of private
        // temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// Creates an empty file without a name in `folder`; `None` if that is not supported.
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
    fn unnamed_files_can_be_copied_instead_of_linked() {
        let folder = tempfile::tempdir().unwrap();
        let temporary = Temporary::in_folder(folder.path()).unwrap();
        temporary.file().write_all(b"content").unwrap();
        let path = folder.path().join("a.pfm");
        copy(temporary.file(), folder.path()).unwrap().persist(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"content");
    }

    #[test]
    fn named_and_unnamed_files_replace_the_target() {
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
