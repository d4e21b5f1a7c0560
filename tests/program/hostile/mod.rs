//! Tests of hostile input. Each file must be rejected in one line with the exit code for its kind.
//!
//! The operating system limits memory, so that exceeding the limit aborts the program.

mod files;
mod imports;
mod instances;
mod meshes;
mod scenes;
mod textures;

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::common::{stderr, stdout};

/// Memory limit in KiB. The program gets it as `--memory-limit`, and the operating system enforces
/// it: beyond it, the program aborts.
const MEMORY: u32 = 32 << 10;
/// Limit on address space in KiB, which includes the program itself and the C library.
const ADDRESS_SPACE: u32 = 64 << 10;
/// CPU seconds after which the program is killed. Every case takes less than a tenth of a second.
const CPU_SECONDS: u32 = 60;

/// An entry of a folder.
enum Content {
    Bytes(Vec<u8>),
    /// A sparse file of this many zeros.
    Sparse(u64),
    /// These bytes, followed by zeros up to this length.
    Begun(Vec<u8>, u64),
    Link(&'static str),
    Folder,
    Pipe,
}

/// A test case: the files of a folder, a command to run there, and the expected result.
struct Case {
    name: String,
    files: Vec<(&'static str, Content)>,
    arguments: Vec<&'static str>,
    code: i32,
    /// Text that the message must contain.
    says: String,
}

impl Case {
    /// A faulty scene `file`, on which `scenes check` must fail with `says`.
    fn scene(file: &'static str, content: impl Into<Vec<u8>>, says: impl Into<String>) -> Self {
        let says = says.into();
        Self {
            name: format!("{file}: {says}"),
            files: vec![(file, Content::Bytes(content.into()))],
            arguments: vec!["scenes", "check", file],
            code: 65,
            says,
        }
    }

    /// Adds a file to the folder.
    fn with(mut self, file: &'static str, content: Content) -> Self {
        self.files.push((file, content));
        self
    }
}

fn write(folder: &Path, (name, content): &(&'static str, Content)) {
    let path = folder.join(name);
    match content {
        Content::Bytes(bytes) => fs::write(path, bytes).unwrap(),
        Content::Sparse(length) => File::create(path).unwrap().set_len(*length).unwrap(),
        Content::Begun(bytes, length) => {
            fs::write(&path, bytes).unwrap();
            File::options().write(true).open(path).unwrap().set_len(*length).unwrap();
        }
        Content::Link(target) => symlink(target, path).unwrap(),
        Content::Folder => fs::create_dir(path).unwrap(),
        Content::Pipe => assert!(Command::new("mkfifo").arg(path).status().unwrap().success()),
    }
}

/// Runs `case`. Returns a description if the result is not as expected.
fn fault(case: &Case) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    // Use an inner folder, so that paths that lead out of it stay in the temporary folder.
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    case.files.iter().for_each(|file| write(&inner, file));
    let limited = format!(
        "ulimit -d {MEMORY}; ulimit -v {ADDRESS_SPACE}; ulimit -t {CPU_SECONDS}; exec \"$0\" \"$@\""
    );
    let output = Command::new("bash")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_ptfast")])
        .args(&case.arguments)
        .args(["--memory-limit", &format!("{MEMORY}KiB")])
        .current_dir(&inner)
        .output()
        .unwrap();
    let (says, code) = (stderr(&output), output.status.code());
    println!("{:>4} {}", code.unwrap_or(-1), says.trim_end());
    let one_line = says.lines().count() == 1 && says.starts_with("ptfast: ") && says.len() < 12_000;
    let left = fs::read_dir(&inner).unwrap().count();
    // A file of any kind that cannot be read has a code of its own.
    let unread = says.contains(": cannot read: ");
    let wanted = if unread && case.code == 65 { 74 } else { case.code };
    let right = code == Some(wanted)
        && one_line
        && says.contains(&case.says)
        && stdout(&output).is_empty()
        && left == case.files.len();
    (!right).then(|| format!("{}: {:?}, {says}", case.name, output.status))
}

#[test]
fn hostile_files_are_rejected() {
    let lists =
        [scenes::cases(), meshes::cases(), instances::cases(), textures::cases(), files::cases()];
    let cases: Vec<Case> = lists.into_iter().flatten().chain(imports::cases()).collect();
    let faults: Vec<String> = cases.iter().filter_map(fault).collect();
    println!("{} cases", cases.len());
    assert!(cases.len() >= 200, "{} cases", cases.len());
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), cases.len(), faults.join("\n"));
}
