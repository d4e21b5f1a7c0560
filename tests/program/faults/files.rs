//! Tests of files that cannot be written, or only in part.

use std::process::Output;

use super::{RENDER, fails, names, shell};
use crate::common::{stderr, stdout};

/// Files may grow to 1 KiB only, which is too small for every kind of file that a render writes.
#[test]
fn files_that_cannot_grow() {
    for file in ["a.png", "a.exr", "a.hdr", "a.pfm", "a.film"] {
        let line = format!("ulimit -f 1; exec $P {RENDER} -o {file}");
        fails(&line, 74, &format!("{file}: cannot write: "), &[]);
    }
    let checkpoint = format!("ulimit -f 1; exec $P {RENDER} -o a.png --time-limit 1ms");
    fails(&checkpoint, 74, "a.partial.film: cannot write: ", &[]);
    fails(
        &format!("ulimit -f 1; exec $P {RENDER} -o a.png --trace t.json"),
        74,
        "cannot write",
        &[],
    );
    fails(
        "ulimit -f 1; exec $P rays --scene cornell --spp 1 --max-rays 2048 --out r",
        74,
        "cannot write",
        &["r"],
    );
}

/// The previous checkpoint remains, and the message says so.
#[test]
fn checkpoints_that_cannot_be_replaced() {
    let render = "$P render --scene cornell --width 64 --threads 2 -o a.png";
    let begun =
        format!("{render} --spp 100000 --quiet --checkpoint k.film --time-limit 1ms 2>/dev/null");
    // Less than the size of the existing checkpoint.
    let limit = "ulimit -f $(($(stat -c %s k.film) / 1024 - 1))";
    let render = format!("{render} --checkpoint k.film");
    for spp in ["100000", "200000"] {
        let stopped = format!("{render} --quiet --time-limit 100ms --spp {spp}");
        fails(
            &format!("{begun}; rm a.partial.png; {limit}; exec {stopped}"),
            74,
            "; k.film has a checkpoint of the render",
            &["k.film"],
        );
    }
    let until_it_renders = "until grep -qs start e; do sleep 0.01; done; kill -TERM $!; wait $!";
    fails(
        &format!(
            "{begun}; {limit}; {render} --spp 100000 --progress json 2>e & {until_it_renders}; c=$?; \
             echo ptfast: $(tail -n 1 e | cut -d'\"' -f10) >&2; rm e; exit $c"
        ),
        143,
        "cannot save it: k.film: cannot write: ",
        &["a.partial.png", "k.film"],
    );
}

/// Runs `line` in a mount namespace in which the folder `d` is a file system of `kib` KiB, and then lists its files.
fn with_disk(kib: u32, line: &str) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let mount = format!("mkdir d && mount -t tmpfs -o size={kib}k none d");
    shell(
        folder.path(),
        &format!("unshare -Urm bash -c '{mount} && {line}; c=$?; ls -A d; exit $c'"),
    )
}

/// Whether [`with_disk`] works here. If not, prints that the test is skipped.
fn has_disks() -> bool {
    let has_disks = with_disk(4, "true").status.success();
    if !has_disks {
        println!("skipped: file systems cannot be mounted here");
    }
    has_disks
}

/// If there is no room for both a new checkpoint and its picture, the checkpoint must be written first.
#[test]
fn pictures_do_not_take_the_room_of_checkpoints() {
    let first = "--spp 16 -o d/k.film";
    let second = "--spp 100000 -o d/a.pfm --checkpoint d/k.film";
    let render = "$P render --scene cornell --width 300 --threads 2 --quiet";
    // Each film takes 1.4 MB and the picture 1.1.
    let line = format!("{render} {first} >/dev/null && {render} {second} --time-limit 50ms");
    if !has_disks() {
        return;
    }
    for _ in 0..4 {
        let stopped = with_disk(3000, &line);
        assert_eq!(stopped.status.code(), Some(75), "{}", stderr(&stopped));
        let says = "continue from d/k.film; d/a.partial.pfm shows the picture so far";
        assert!(stderr(&stopped).contains(says), "{}", stderr(&stopped));
        assert_eq!(stdout(&stopped), "a.partial.pfm\nk.film\n");
    }
}

/// A file system of 4 KiB.
#[test]
fn full_disks() {
    let within = |line: &str| with_disk(4, line);
    if !has_disks() {
        return;
    }
    for file in ["a.png", "a.pfm", "a.film"] {
        let full = within(&format!("$P {RENDER} -o d/{file}"));
        let message = stderr(&full);
        println!("{:?} {message}", full.status.code());
        assert_eq!(full.status.code(), Some(74), "{message}");
        assert_eq!(
            message,
            format!("ptfast: d/{file}: cannot write: No space left on device (os error 28)\n")
        );
        assert!(full.stdout.is_empty(), "the folder must be empty");
    }
    let read_only = within(&format!("mount -o remount,ro d && $P {RENDER} -o d/a.png"));
    assert_eq!(read_only.status.code(), Some(74));
    assert!(
        stderr(&read_only).starts_with("ptfast: d/a.png: cannot write: "),
        "{}",
        stderr(&read_only)
    );
}

#[test]
fn targets_that_are_not_files() {
    fails(&format!("$P {RENDER} -o /dev/full"), 2, "/dev/full", &[]);
    fails(
        "mkdir d; ln -s /dev/full d/a.png; $P render --scene cornell -q -o d/a.png",
        74,
        "it is a device or pipe, not a file",
        &["d"],
    );
    fails(&format!("$P {RENDER} -o /proc/a.png"), 74, "/proc/a.png: cannot write", &[]);
    fails(&format!("$P {RENDER} -o none/a.png"), 74, "none/a.png: cannot write: No such file", &[]);
}

/// Opens descriptor 3 as a pipe whose reader has exited.
const NO_READER: &str = "exec 3> >(true); wait $!; ";

/// The image is written completely, and only the printed output is lost.
#[test]
fn standard_output_that_cannot_be_written() {
    let says = "standard output: cannot write: ";
    let loud = RENDER.replace(" --quiet", "");
    fails(&format!("$P {loud} -o a.png > /dev/full"), 74, says, &["a.png"]);
    let folder = tempfile::tempdir().unwrap();
    // It is no error if the reader exits before the program writes.
    for command in
        [format!("{loud} -o b.png"), "scenes list".to_owned(), "scenes show mesh:1000".to_owned()]
    {
        let closed = shell(folder.path(), &format!("{NO_READER}$P {command} >&3"));
        let says = stderr(&closed);
        assert_eq!((closed.status.code(), &*says), (Some(0), ""), "{command}");
    }
    assert!(folder.path().join("b.png").exists());
    let closed = shell(folder.path(), &format!("$P {RENDER} -o a.png >&- 2>&-"));
    assert_eq!(closed.status.code(), Some(0), "with both streams closed, the render must succeed");
    assert!(folder.path().join("a.png").exists());
}

/// A checkpoint that cannot be written does not stop the render, since there may be room for the next one.
#[test]
fn renders_go_on_without_a_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    // There is room for the image, with at most three bytes per pixel, but not for the film, with at least four.
    let line = "ulimit -f 13; exec $P render --scene cornell --width 64 --spp 4000 -o a.png \
                --checkpoint kept.film --checkpoint-every 1ms";
    let output = shell(folder.path(), line);
    let (says, code) = (stderr(&output), output.status.code());
    let warnings = says.lines().filter(|line| line.ends_with("; the render continues")).count();
    assert!(warnings > 0 && says.contains("kept.film: cannot write: "), "{says}");
    assert_eq!(code, Some(74), "a missing checkpoint must give exit code 74: {says}");
    assert_eq!(names(folder.path()), ["a.png"]);
}
