//! Faults of the machine while the program runs: a non-zero exit, one line, and nothing half-written.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU64, Ordering};

use common::stderr;
use ptfast::engine::{Observer, Progress};
use ptfast::{Engine, RenderSettings, Renderer, Scene};
use tempfile::TempDir;

const RENDER: &str = "render --scene cornell --width 64 --spp 2 --quiet";

/// Runs a line of the shell in which `$P` is the program.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("bash")
        .args(["-c", line])
        .env("P", env!("CARGO_BIN_EXE_ptfast"))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// That `line` ends with `code` and one line that holds `says`, and leaves nothing but the files `left`.
#[track_caller]
fn fails(line: &str, code: i32, says: &str, left: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let output = shell(folder.path(), line);
    let message = stderr(&output);
    println!("{code:>4} {}   # {line}", message.trim_end());
    assert_eq!(output.status.code(), Some(code), "{line}: {message}");
    assert_eq!(message.lines().count(), 1, "{line}: {message}");
    assert!(message.starts_with("ptfast: ") && message.contains(says), "{line}: {message}");
    let mut files: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, left, "{line}");
}

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

/// A file system of 4 KiB, in a name space of its own.
#[test]
fn full_disks() {
    let folder = tempfile::tempdir().unwrap();
    let within = |line: &str| {
        let mount = "mkdir d && mount -t tmpfs -o size=4k none d";
        shell(
            folder.path(),
            &format!(
                "unshare -Urm bash -c '{mount} && {line}; c=$?; ls -A d; exit $c'; c=$?; rmdir d; exit $c"
            ),
        )
    };
    if !within("true").status.success() {
        println!("no file systems can be mounted here: only the limit of files was tried");
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

/// A folder in which what C functions do is replaced by `source`.
struct Replaced(TempDir);

impl Replaced {
    fn by(source: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.c"), source).unwrap();
        // The linker of Rust programs is a C compiler.
        let built = shell(folder.path(), "cc -shared -fPIC -o a.so a.c");
        assert!(built.status.success(), "{}", stderr(&built));
        Self(folder)
    }

    /// Renders there.
    fn render(&self, more: &str) -> Output {
        shell(self.0.path(), &format!("LD_PRELOAD=$PWD/a.so $P {RENDER} {more}"))
    }

    fn has(&self, file: &str) -> bool {
        self.0.path().join(file).exists()
    }
}

/// Where the operating system refuses.
#[test]
fn threads_that_cannot_be_pinned() {
    let replaced = Replaced::by(
        "#include <errno.h>\nint sched_setaffinity(int p, unsigned long n, const void *m)\n\
         { (void)p; (void)n; (void)m; errno = EPERM; return -1; }\n",
    );
    let run = |more| replaced.render(more);
    let refused = run("--pin on -o a.png");
    assert_eq!(refused.status.code(), Some(70), "{}", stderr(&refused));
    let message = "ptfast: internal fault: threads cannot be pinned to cores here: pin auto goes on without\n";
    assert_eq!(stderr(&refused), message);
    assert!(!replaced.has("a.png"));
    assert!(run("--pin auto -o b.png").status.success() && replaced.has("b.png"));
}

/// The operating system starts two threads, and no more.
#[test]
fn threads_that_cannot_be_started() {
    let replaced = Replaced::by(
        "#define _GNU_SOURCE\n#include <dlfcn.h>\n#include <errno.h>\n#include <pthread.h>\n\
         int pthread_create(pthread_t *t, const pthread_attr_t *a, void *(*f)(void *), void *x)\n\
         { static int started; if (started++ == 2) return EAGAIN;\n\
         int (*next)() = (int (*)())dlsym(RTLD_NEXT, \"pthread_create\"); return next(t, a, f, x); }\n",
    );
    let refused = replaced.render("--threads 3 -o a.png");
    assert_eq!(refused.status.code(), Some(70), "{}", stderr(&refused));
    let says = "ptfast: internal fault: cannot start the threads: ";
    assert!(stderr(&refused).starts_with(says) && stderr(&refused).lines().count() == 1);
    assert!(!replaced.has("a.png"));
    let long = "render --scene cornell --spp 10000 --quiet --threads 2 --time-limit 1ms -o a.png";
    let stopped = shell(replaced.0.path(), &format!("LD_PRELOAD=$PWD/a.so $P {long}"));
    assert_eq!(stopped.status.code(), Some(75), "{}", stderr(&stopped));
    assert!(replaced.has("a.partial.film") && replaced.has("a.partial.png"));
}

/// The clock fails all threads but the first, and so does what std makes of it: a panic.
#[test]
fn a_panic_in_a_worker_is_an_internal_fault() {
    let replaced = Replaced::by(
        "#define _GNU_SOURCE\n#include <errno.h>\n#include <sys/syscall.h>\n#include <time.h>\n\
         #include <unistd.h>\nint clock_gettime(clockid_t c, struct timespec *t)\n\
         { if (syscall(SYS_gettid) == getpid()) return syscall(SYS_clock_gettime, c, t);\n\
         errno = EINVAL; return -1; }\n",
    );
    for engine in ["wavefront", "scalar"] {
        let panicked = replaced.render(&format!("--engine {engine} --threads 2 -o a.png"));
        let says = stderr(&panicked);
        println!("{:?} {says}", panicked.status.code());
        assert_eq!(panicked.status.code(), Some(70), "{says}");
        assert!(
            says.starts_with("ptfast: internal fault: panicked at ") && says.contains("time.rs")
        );
        assert_eq!(says.lines().count(), 1, "{says}");
        assert!(panicked.stdout.is_empty());
        let left = ["a.png", "a.partial.png", "a.partial.film"].map(|file| replaced.has(file));
        assert_eq!(left, [false; 3]);
        let kept =
            replaced.render(&format!("--engine {engine} -o a.png --checkpoint {engine}.film"));
        assert_eq!(kept.status.code(), Some(70), "{}", stderr(&kept));
        assert!(replaced.has(&format!("{engine}.film")) && !replaced.has("a.png"));
    }
}

/// Panics when the first work is done.
struct Panics(AtomicU64);

impl Observer for Panics {
    fn progressed(&self, _: Progress) {
        let before = self.0.fetch_add(1, Ordering::Relaxed);
        // As a panic, but nobody prints a backtrace meanwhile.
        if before == 0 {
            std::panic::resume_unwind(Box::new("on purpose"));
        }
    }
}

/// The other workers stop, and the caller is told.
#[test]
fn a_panic_in_a_worker_ends_the_render() {
    let scene = Scene::load("cornell").unwrap();
    for engine in Engine::ALL {
        let settings = RenderSettings {
            width: 64,
            height: 64,
            spp: 640,
            wave_size: 256,
            threads: 4,
            engine,
            ..RenderSettings::of(&scene)
        };
        let renderer = Renderer::new(&scene, settings).unwrap();
        let panics = Panics(AtomicU64::new(0));
        let mut rendering = renderer.begin().unwrap();
        let advance = std::panic::AssertUnwindSafe(|| renderer.advance(&mut rendering, &panics));
        assert!(std::panic::catch_unwind(advance).is_err());
        // There are 10 240 units.
        let reports = panics.0.load(Ordering::Relaxed);
        assert!(reports < 5000, "{engine:?}: {reports}");
        // What was done before is not lost.
        renderer.advance(&mut rendering, &()).unwrap();
        assert_eq!(rendering.film.samples_done(), rendering.film.samples_to_do());
    }
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
    assert!(folder.path().join("a.png").exists() && !folder.path().join("kept.film").exists());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
