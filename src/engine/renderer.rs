//! From a scene and settings to an image: units of work on threads, whatever the engine.

use std::mem;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rayon::{BroadcastContext, ThreadPool};

use super::pool::{self, Pin, Pinned};
use super::rendering::{Progress, Rendering, Shared, Taken, Task};
use super::scalar::ScalarEngine;
use super::settings::{Engine, RenderSettings};
use super::stats::WaveStats;
use super::tally::Tally;
use super::timeline::{Event, Lap, Work};
use super::wavefront::{Plan, Planning, WavefrontEngine};
use crate::error::{Error, Result};
use crate::film::{Film, Schedule};
use crate::image::Image;
use crate::scene::Scene;

/// A scene with its acceleration structure and threads, ready to be rendered.
#[derive(Debug)]
pub struct Renderer<'a> {
    scene: &'a Scene,
    settings: RenderSettings,
    engine: Box<dyn UnitEngine + 'a>,
    pool: ThreadPool,
    pinned: Pinned,
    seconds: Seconds,
}

/// What an engine does: its workers take units of work.
pub(super) trait UnitEngine: Sync + std::fmt::Debug {
    /// What a thread works with, for units of at most so many paths.
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker + '_>;

    /// Paths that it takes best at once.
    fn unit_paths(&self) -> u32;

    /// How it works, if it has a plan, where that is from, and the seconds that finding it took.
    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
        None
    }
}

/// What a thread does.
pub(super) trait UnitWorker {
    /// Renders `task`; `None` where `abandon`, which is called now and then, returns true.
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken>;
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Render {
    /// The linear image.
    pub image: Image,
    /// What was traced, and what came of it.
    pub tally: Tally,
    /// What the stages of the wavefront engine did; of the scalar engine, where it is asked to count,
    /// the work of its rays, without times.
    pub waves: WaveStats,
    /// Time of each step.
    pub seconds: Seconds,
    /// What each worker did when, if that was asked for; the first
    /// [`MOST_EVENTS`](super::MOST_EVENTS).
    pub timeline: Vec<Event>,
}

/// Wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Building the acceleration structure and starting the threads.
    pub build: f64,
    /// Finding the plan, and making what its trials need.
    pub plan: f64,
    /// Rendering.
    pub render: f64,
}

/// Is told how far a render is, and may stop it.
pub trait Observer: Sync {
    /// `progress` is the state now; reports of several threads may arrive out of order.
    fn progressed(&self, progress: Progress);

    /// Whether the render is to go on. Is asked often, from any thread.
    fn stop(&self) -> Stop {
        Stop::No
    }
}

/// Whether a render is to go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// It is.
    #[default]
    No,
    /// Workers finish what they are at, a few thousand paths.
    Soon,
    /// Workers leave what they are at.
    Now,
}

/// Nobody watches.
impl Observer for () {
    fn progressed(&self, _: Progress) {}
}

/// Tells the other workers when one fails, by an error or a panic: what they do would be in vain.
struct Alarm<'a>(&'a AtomicBool);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl<'a> Renderer<'a> {
    /// Checks the settings, starts the threads, builds the acceleration structure and finds the
    /// plan.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) where a setting is out of its range or memory would not suffice,
    /// [`Error::Internal`](crate::Error::Internal) where the threads cannot be started, or not be pinned as asked
    /// for.
    pub fn new(scene: &'a Scene, settings: RenderSettings) -> Result<Self> {
        let paths = settings.paths();
        Self::for_paths(scene, settings, paths)
    }

    /// As [`new`](Self::new), for a render of which but so many paths are left: the less there is to do, the less is
    /// tried before it.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn for_paths(scene: &'a Scene, settings: RenderSettings, paths: u64) -> Result<Self> {
        settings.check()?;
        settings.check_memory(scene, 0)?;
        let start = Instant::now();
        let (pool, pinned) = pool::start(settings.threads, settings.pin)?;
        if (settings.pin, pinned) == (Pin::On, Pinned::Failed) {
            let message = "threads cannot be pinned to cores here: pin auto goes on without";
            return Err(Error::Internal(message.to_owned()));
        }
        let engine: Box<dyn UnitEngine + 'a> = match settings.engine {
            Engine::Wavefront => Box::new(WavefrontEngine::new(scene, &settings, paths, &pool)),
            Engine::Scalar => Box::new(ScalarEngine::new(scene, &settings)),
        };
        let plan = engine.plan().map_or(0.0, |(.., seconds)| seconds);
        let seconds = Seconds { build: start.elapsed().as_secs_f64() - plan, plan, render: 0.0 };
        Ok(Self { scene, settings, engine, pool, pinned, seconds })
    }

    /// How the wavefront engine works; `None` for others.
    pub fn plan(&self) -> Option<&Plan> {
        self.engine.plan().map(|(plan, ..)| plan)
    }

    /// Where that is from.
    pub fn planning(&self) -> Option<Planning> {
        self.engine.plan().map(|(_, planning, _)| planning)
    }

    /// Worker threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Whether they are pinned to cores.
    pub fn pinned(&self) -> Pinned {
        self.pinned
    }

    /// Renders the image.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) where there is no memory for the image.
    pub fn render(&self) -> Result<Render> {
        let mut rendering = self.begin()?;
        self.advance(&mut rendering, &())?;
        self.finish(&mut rendering)
    }

    /// A render of the whole image, of which nothing is done.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) where memory would not suffice for the image,
    /// [`Error::Internal`](crate::Error::Internal) where there is none.
    pub fn begin(&self) -> Result<Rendering> {
        let (image, samples) = (self.settings.image(), 0..self.settings.spp);
        self.settings.check_memory(self.scene, Film::memory(image, samples.clone()))?;
        Film::new(image, samples).map(Rendering::new)
    }

    /// Renders what is left of `rendering`, or until `observer` stops it.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) where memory runs out.
    pub fn advance(&self, rendering: &mut Rendering, observer: &dyn Observer) -> Result<()> {
        let start = Instant::now();
        let schedule = Schedule::new(&rendering.film, self.engine.unit_paths());
        let most_paths = schedule.most_paths();
        let shared = Mutex::new(Shared::new(rendering, schedule));
        let lock = || shared.lock().expect("no thread panics while it holds the film");
        let failed = AtomicBool::new(false);
        let stop = || if failed.load(Ordering::Relaxed) { Stop::Now } else { observer.stop() };
        let next = || {
            while stop() == Stop::No {
                let mut shared = lock();
                if !shared.is_far_ahead() {
                    return shared.next();
                }
                drop(shared);
                // A worker that is held up may hold up others, but not have them pile up what they did.
                thread::sleep(Duration::from_millis(1));
            }
            None
        };
        let abandon = || stop() == Stop::Now;
        let work = |thread: BroadcastContext<'_>| {
            let alarm = Alarm(&failed);
            // None for threads that find no work.
            let mut worker = None;
            while let Some(task) = next() {
                let worker = worker.get_or_insert_with(|| self.engine.worker(most_paths));
                let begin = Instant::now();
                let Some(mut taken) = worker.take(&task, &abandon) else { break };
                #[cfg(feature = "slowed")]
                super::slowed::dawdle(begin.elapsed());
                if self.settings.timeline {
                    taken.laps.push(Lap {
                        start: begin,
                        end: Instant::now(),
                        work: Work::Unit(task.unit),
                    });
                }
                let progress = lock().add(taken, thread.index())?;
                observer.progressed(progress);
            }
            mem::forget(alarm);
            Ok(())
        };
        let worked: Result<Vec<()>> = self.pool.broadcast(work).into_iter().collect();
        rendering.seconds += start.elapsed().as_secs_f64();
        worked.map(|_| ())
    }

    /// The image as far as it is rendered. Takes the timeline out of `rendering`: it may be large.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) where there is no memory for it.
    pub fn finish(&self, rendering: &mut Rendering) -> Result<Render> {
        Ok(Render {
            image: rendering.image()?,
            tally: rendering.tally.clone(),
            waves: rendering.waves.clone(),
            seconds: Seconds { render: rendering.seconds, ..self.seconds },
            timeline: mem::take(&mut rendering.timeline),
        })
    }
}
