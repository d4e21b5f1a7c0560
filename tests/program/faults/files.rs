//! Files that cannot be written, or not as far as they go.

use std::process::Output;

use super::{RENDER, fails, names, shell};
use crate::common::{stderr, stdout};

/// Each kind of file that a render writes, in files of at most 1 KiB.
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

/// What was kept before is what remains, and that is told.
#[test]
fn checkpoints_that_cannot_be_replaced() {
    let render = "$P render --scene cornell --width 64 --threads 2 -o a.png";
    let begun =
        format!("{render} --spp 100000 --quiet --checkpoint k.film --time-limit 1ms 2>/dev/null");
    // Less than there is.
    let limit = "ulimit -f $(($(stat -c %s k.film) / 1024 - 1))";
    let render = format!("{render} --resume k.film");
    let same = "--spp 100000";
    for more in [same, "--spp 100000 --checkpoint n.film", "--spp 200000"] {
        let stopped = format!("{render} --quiet --time-limit 100ms {more}");
        fails(
            &format!("{begun}; rm a.partial.png; {limit}; exec {stopped}"),
            74,
            "; go on with --resume k.film, as it was",
            &["k.film"],
        );
    }
    let until_it_renders = "until grep -qs start e; do sleep 0.01; done; kill -TERM $!; wait $!";
    fails(
        &format!(
            "{begun}; {limit}; {render} {same} --progress json 2>e & {until_it_renders}; c=$?; \
             echo ptfast: $(tail -n 1 e | cut -d'\"' -f10) >&2; rm e; exit $c"
        ),
        143,
        "go on with --resume k.film, as it was; k.film: cannot write: ",
        &["a.partial.png", "k.film"],
    );
}

/// Runs `line` where `d` is a file system of so many KiB, in a name space of its own, and then prints what is there.
fn with_disk(kib: u32, line: &str) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let mount = format!("mkdir d && mount -t tmpfs -o size={kib}k none d");
    shell(
        folder.path(),
        &format!("unshare -Urm bash -c '{mount} && {line}; c=$?; ls -A d; exit $c'"),
    )
}

/// Whether [`with_disk`] can be had; else it is told that nothing is tried.
fn has_disks() -> bool {
    let has_disks = with_disk(4, "true").status.success();
    if !has_disks {
        println!("no file systems can be mounted here");
    }
    has_disks
}

/// A film that is kept, a newer one and its picture: the newer one comes first.
#[test]
fn pictures_do_not_take_the_room_of_checkpoints() {
    let first = "--spp 16 -o d/k.film";
    let second = "--spp 100000 -o d/a.pfm --resume d/k.film --checkpoint d/k.film";
    let render = "$P render --scene cornell --width 300 --threads 2 --quiet";
    // Each film takes 1.4 MB and the picture 1.1.
    let line = format!("{render} {first} >/dev/null && {render} {second} --time-limit 50ms");
    if !has_disks() {
        return;
    }
    for _ in 0..4 {
        let stopped = with_disk(3000, &line);
        assert_eq!(stopped.status.code(), Some(75), "{}", stderr(&stopped));
        let says = "go on with --resume d/k.film, d/a.partial.pfm shows it";
        assert!(stderr(&stopped).contains(says), "{}", stderr(&stopped));
        assert_eq!(stdout(&stopped), "a.partial.pfm\nk.film\n");
    }
}

/// A film of fewer samples is only read.
#[test]
fn films_on_read_only_disks_are_added_to() {
    if !has_disks() {
        return;
    }
    let render = "$P render --scene cornell --width 32 --quiet";
    let film = format!("{render} --spp 16 -o d/k.film && mount -o remount,ro d");
    let more = with_disk(200, &format!("{film} && {render} --spp 20 --resume d/k.film -o a.png"));
    assert_eq!(more.status.code(), Some(0), "{}", stderr(&more));
    let same = with_disk(200, &format!("{film} && {render} --spp 16 --resume d/k.film -o a.png"));
    assert_eq!(same.status.code(), Some(74), "{}", stderr(&same));
    assert!(stderr(&same).contains("d/k.film: cannot write: read-only"), "{}", stderr(&same));
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
        assert!(full.stdout.is_empty(), "something is left");
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
fn places_that_are_no_files() {
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

/// A pipe that nobody reads any more.
const NO_READER: &str = "exec 3> >(true); wait $!; ";

/// The image is there, whole; only what is printed is lost.
#[test]
fn standard_output_that_takes_nothing() {
    let says = "standard output: cannot write: ";
    fails(&format!("$P {RENDER} -o a.png > /dev/full"), 74, says, &["a.png"]);
    fails(&format!("{NO_READER}$P {RENDER} -o a.png >&3"), 74, says, &["a.png"]);
    fails(&format!("{NO_READER}$P scenes list >&3"), 74, says, &[]);
    let folder = tempfile::tempdir().unwrap();
    let closed = shell(folder.path(), &format!("$P {RENDER} -o a.png >&- 2>&-"));
    assert_eq!(closed.status.code(), Some(0), "both are closed, and the image is there");
    assert!(folder.path().join("a.png").exists());
}

/// A checkpoint that cannot be written does not end a render: there may be room the next time.
#[test]
fn renders_go_on_without_a_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    // Room for the image, of at most three bytes a pixel, not for the film, of at least four.
    let line = "ulimit -f 13; exec $P render --scene cornell --width 64 --spp 4000 -o a.png \
                --checkpoint kept.film --checkpoint-every 1ms";
    let output = shell(folder.path(), line);
    let (says, code) = (stderr(&output), output.status.code());
    let warnings = says.lines().filter(|line| line.ends_with(", the render goes on")).count();
    assert!(warnings > 0 && says.contains("kept.film: cannot write: "), "{says}");
    assert_eq!(code, Some(74), "not all that was asked for is there: {says}");
    assert_eq!(names(folder.path()), ["a.png"]);
}
