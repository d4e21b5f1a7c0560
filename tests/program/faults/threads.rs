//! Tests of threads that cannot be started or pinned, and of workers that panic.

use std::fs;
use std::process::Output;
use std::sync::atomic::{AtomicU64, Ordering};

use ptfast::{ComputeSettings, Engine, ImageSettings, Observer, Progress, Renderer, Scene};
use tempfile::TempDir;

use super::{RENDER, shell};
use crate::common::stderr;

/// A folder with a library whose functions, given as C `source`, override those of the C library.
struct Replaced(TempDir);

impl Replaced {
    fn by(source: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.c"), source).unwrap();
        // A C compiler is installed, since Rust uses it as its linker.
        let built = shell(folder.path(), "cc -shared -fPIC -o a.so a.c");
        assert!(built.status.success(), "{}", stderr(&built));
        Self(folder)
    }

    /// Renders in the folder with the replaced functions.
    fn render(&self, more: &str) -> Output {
        shell(self.0.path(), &format!("LD_PRELOAD=$PWD/a.so $P {RENDER} {more}"))
    }

    fn has(&self, file: &str) -> bool {
        self.0.path().join(file).exists()
    }
}

/// The operating system refuses to pin threads.
#[test]
fn threads_that_cannot_be_pinned() {
    let replaced = Replaced::by(
        "#include <errno.h>\nint sched_setaffinity(int p, unsigned long n, const void *m)\n\
         { (void)p; (void)n; (void)m; errno = EPERM; return -1; }\n",
    );
    let run = |more| replaced.render(more);
    let refused = run("--pin on -o a.png");
    assert_eq!(refused.status.code(), Some(71), "{}", stderr(&refused));
    let message = "ptfast: threads cannot be pinned to cores here; pin auto continues without\n";
    assert_eq!(stderr(&refused), message);
    assert!(!replaced.has("a.png"));
    assert!(run("--pin auto -o b.png").status.success() && replaced.has("b.png"));
}

/// The operating system starts only three threads, of which one waits for SIGINT.
#[test]
fn threads_that_cannot_be_started() {
    let replaced = Replaced::by(
        "#define _GNU_SOURCE\n#include <dlfcn.h>\n#include <errno.h>\n#include <pthread.h>\n\
         int pthread_create(pthread_t *t, const pthread_attr_t *a, void *(*f)(void *), void *x)\n\
         { static int started; if (started++ == 3) return EAGAIN;\n\
         int (*next)() = (int (*)())dlsym(RTLD_NEXT, \"pthread_create\"); return next(t, a, f, x); }\n",
    );
    let refused = replaced.render("--threads 3 -o a.png");
    assert_eq!(refused.status.code(), Some(71), "{}", stderr(&refused));
    let says = "ptfast: cannot start 3 threads (";
    assert!(stderr(&refused).starts_with(says) && stderr(&refused).lines().count() == 1);
    assert!(!replaced.has("a.png"));
    let long = "render --scene cornell --spp 10000 --quiet --threads 2 --time-limit 1ms -o a.png";
    let stopped = shell(replaced.0.path(), &format!("LD_PRELOAD=$PWD/a.so $P {long}"));
    assert_eq!(stopped.status.code(), Some(75), "{}", stderr(&stopped));
    assert!(replaced.has("a.partial.film") && replaced.has("a.partial.png"));
}

/// Reading the clock fails in all threads except the first. When it fails, std panics.
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
        assert!(!replaced.has("a.png") && !replaced.has("a.partial.png"));
        // The other thread's work is saved.
        assert!(replaced.has("a.partial.film"));
        let kept =
            replaced.render(&format!("--engine {engine} -o a.png --checkpoint {engine}.film"));
        assert_eq!(kept.status.code(), Some(70), "{}", stderr(&kept));
        assert!(replaced.has(&format!("{engine}.film")) && !replaced.has("a.png"));
    }
}

/// Panics at the first progress report.
struct Panics(AtomicU64);

impl Observer for Panics {
    fn progressed(&self, _: Progress) {
        let before = self.0.fetch_add(1, Ordering::Relaxed);
        // This is a panic without a backtrace, which would take time to print.
        if before == 0 {
            std::panic::resume_unwind(Box::new("on purpose"));
        }
    }
}

/// The other workers stop, and the panic reaches the caller.
#[test]
fn a_panic_in_a_worker_ends_the_render() {
    let scene = Scene::load("cornell").unwrap();
    for engine in Engine::ALL {
        let settings =
            ImageSettings { width: 64, height: 64, spp: 640, ..ImageSettings::of(&scene) };
        let compute = ComputeSettings { engine, threads: 4, wave_size: 256, ..engine.into() };
        let renderer = Renderer::new(&scene, settings, compute).unwrap();
        let panics = Panics(AtomicU64::new(0));
        let mut rendering = renderer.begin().unwrap();
        let advance = std::panic::AssertUnwindSafe(|| renderer.advance(&mut rendering, &panics));
        assert!(std::panic::catch_unwind(advance).is_err());
        // There are 10 240 units.
        let reports = panics.0.load(Ordering::Relaxed);
        assert!(reports < 5000, "{engine:?}: {reports}");
        // The work done before the panic is not lost.
        renderer.advance(&mut rendering, &()).unwrap();
        assert_eq!(rendering.film.samples_done(), rendering.film.samples_to_do());
    }
}
