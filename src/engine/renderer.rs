//! The renderer distributes a render's units of work to threads, for any engine.

use std::borrow::BorrowMut;
use std::mem;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::memory::FilmOf;
use super::roulette;
use super::scalar::ScalarEngine;
use super::wavefront::WavefrontEngine;
use super::{
    Activity, ComputeSettings, Engine, ImageSettings, Lap, Observer, Pinned, Plan, PlanChoice,
    Planning, Pool, PreparedScene, Render, RenderState, Seconds, Shared, Stop, Survival,
    UnitEngine, UnitWorker, View, locked,
};
use crate::error::Result;
use crate::film::{Film, Schedule};

/// Renders images of a prepared scene. The settings may change between renders; the threads are
/// kept.
#[derive(Debug)]
pub struct Renderer {
    view: Arc<View>,
    engine: Box<dyn UnitEngine>,
    pool: Arc<Pool>,
    /// Workers of finished passes, whose memory the next pass uses, with the number of paths that they have room for.
    idle: Mutex<Vec<(u64, Box<dyn UnitWorker>)>>,
    seconds: Seconds,
}

impl View {
    fn check(&self) -> Result<()> {
        self.settings.check(self.scene().limits())?;
        self.compute.check()?;
        self.compute.check_memory(self.scene(), None)
    }

    /// The view with its rule of Russian roulette. It must have been [checked](Self::check).
    pub(super) fn with_survival(mut self, pool: &Arc<Pool>) -> Result<Arc<Self>> {
        self.survival = match Survival::fixed(self.settings.roulette) {
            Some(survival) => survival,
            None => {
                let pilot = roulette::pilot(&self.settings);
                let paths = pilot.paths();
                let bounces = Renderer::pilot(&self, pilot, pool)?.tally.rays.bounce;
                Survival::of_bounces(bounces as f32 / paths as f32)
            }
        };
        Ok(Arc::new(self))
    }

    fn engine(
        self: &Arc<Self>,
        paths: u64,
        pool: &Pool,
        measured: Option<Plan>,
    ) -> Box<dyn UnitEngine> {
        match self.compute.engine {
            Engine::Wavefront => {
                Box::new(WavefrontEngine::new(Arc::clone(self), paths, pool, measured))
            }
            Engine::Scalar => Box::new(ScalarEngine::new(Arc::clone(self), pool.threads())),
        }
    }
}

/// Stops the other workers when it is dropped, because their results would be discarded. Only a
/// worker that fails, by an error or a panic, drops it.
struct Alarm<'a>(&'a AtomicBool);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Renderer {
    /// Checks the settings, starts the threads, builds the trees and tables that the prepared scene
    /// lacks, and finds the plan.
    ///
    /// # Errors
    /// If a setting is out of range or the render would exceed the memory limit, returns
    /// [`Error::Usage`](crate::Error::Usage).
    ///
    /// If the threads cannot be started, or cannot be pinned with [`Pin::On`](super::Pin::On),
    /// returns [`Error::Resource`](crate::Error::Resource).
    pub fn new(
        scene: impl Into<PreparedScene>,
        image: ImageSettings,
        compute: impl Into<ComputeSettings>,
    ) -> Result<Self> {
        let paths = image.paths();
        Self::for_paths(scene, image, compute, paths)
    }

    /// Like [`new`](Self::new), for a render with only `paths` paths left: the fewer paths, the
    /// fewer plans are tried.
    ///
    /// # Errors
    /// Returns the same errors as [`new`](Self::new).
    pub fn for_paths(
        scene: impl Into<PreparedScene>,
        image: ImageSettings,
        compute: impl Into<ComputeSettings>,
        paths: u64,
    ) -> Result<Self> {
        let view = View::new(scene.into(), image, compute.into());
        Self::on(view, paths, |compute| Pool::start(compute.threads, compute.pin))
    }

    /// Creates a renderer without threads of its own. It runs in the rayon pool from which it is
    /// called, or otherwise in rayon's global pool. The settings `threads` and `pin` have no
    /// effect.
    ///
    /// # Errors
    /// If a setting is out of range or the render would exceed the memory limit, returns
    /// [`Error::Usage`](crate::Error::Usage).
    pub fn in_current_pool(
        scene: impl Into<PreparedScene>,
        image: ImageSettings,
        compute: impl Into<ComputeSettings>,
    ) -> Result<Self> {
        let paths = image.paths();
        let threads = rayon::current_num_threads() as u32;
        let compute = ComputeSettings { threads, ..compute.into() };
        let view = View::new(scene.into(), image, compute);
        Self::on(view, paths, |_| Ok(Pool::Caller))
    }

    fn on(
        view: View,
        paths: u64,
        pool: impl FnOnce(&ComputeSettings) -> Result<Pool>,
    ) -> Result<Self> {
        view.check()?;
        let start = Instant::now();
        let pool = Arc::new(pool(&view.compute)?);
        view.prepared.accelerator().set_quality(view.compute.trees);
        let view = view.with_survival(&pool)?;
        let engine = view.engine(paths, &pool, None);
        let seconds = Seconds::of_build(&*engine, start);
        Ok(Self { view, engine, pool, idle: Mutex::default(), seconds })
    }

    /// Changes the camera and the settings. Trees, tables, threads and their pinning stay as they
    /// are. A measured plan is kept, too, unless the engine, the plan or the wave size changes.
    /// After an error, the renderer is unchanged.
    ///
    /// # Errors
    /// If a setting is out of range or the render would exceed the memory limit, returns
    /// [`Error::Usage`](crate::Error::Usage).
    pub fn set(&mut self, image: ImageSettings, compute: impl Into<ComputeSettings>) -> Result<()> {
        *self = self.with(self.view.prepared.clone(), image, compute.into())?;
        Ok(())
    }

    /// Another renderer on the same threads, of `prepared`, which shares the trees of the scene.
    pub(super) fn with(
        &self,
        prepared: PreparedScene,
        image: ImageSettings,
        compute: ComputeSettings,
    ) -> Result<Self> {
        let ComputeSettings { threads, pin, .. } = self.view.compute;
        let compute = ComputeSettings { threads, pin, ..compute };
        let view = View::new(prepared, image, compute);
        view.check()?;
        let start = Instant::now();
        // Scenes come last, since comparing them may take long.
        let same = view.settings.roulette == self.view.settings.roulette
            && roulette::pilot(&view.settings) == roulette::pilot(&self.view.settings)
            && view.scene() == self.view.scene();
        let view = match same {
            true => Arc::new(View { survival: self.view.survival, ..view }),
            false => view.with_survival(&self.pool)?,
        };
        let measured = self.measured_plan(&view.compute);
        let engine = view.engine(view.settings.paths(), &self.pool, measured);
        let seconds = Seconds::of_build(&*engine, start);
        Ok(Self { view, engine, pool: Arc::clone(&self.pool), idle: Mutex::default(), seconds })
    }

    /// Renders a picture that is not shown: of another size, by the engine, the trees and the threads of `view`.
    fn pilot(view: &View, image: ImageSettings, pool: &Arc<Pool>) -> Result<Render> {
        let compute = ComputeSettings { count: false, timeline: false, ..view.compute.clone() };
        let paths = image.paths();
        let view = Arc::new(View::new(view.prepared.clone(), image, compute));
        let engine = view.engine(paths, pool, None);
        let (pool, idle, seconds) = (Arc::clone(pool), Mutex::default(), Seconds::default());
        Self { view, engine, pool, idle, seconds }.render()
    }

    /// Returns the current plan if it was measured and also suits `settings`.
    fn measured_plan(&self, settings: &ComputeSettings) -> Option<Plan> {
        let serves = settings.wave_size == self.view.compute.wave_size
            && settings.plan == PlanChoice::Measured;
        let (plan, planning, _) = self.engine.plan()?;
        (serves && planning == Planning::Measured).then(|| plan.clone())
    }

    /// Changes the number of samples in the settings.
    pub(super) fn end_at(&mut self, samples: u32) {
        Arc::make_mut(&mut self.view).settings.spp = samples;
    }

    /// The prepared scene.
    pub fn prepared(&self) -> &PreparedScene {
        &self.view.prepared
    }

    /// The settings that decide the image.
    pub fn image_settings(&self) -> &ImageSettings {
        &self.view.settings
    }

    /// Which paths must survive Russian roulette.
    #[cfg(test)]
    pub(super) fn survival(&self) -> Survival {
        self.view.survival
    }

    /// The settings that decide how the image is computed.
    pub fn compute_settings(&self) -> &ComputeSettings {
        &self.view.compute
    }

    /// The plan of the wavefront engine; `None` for other engines.
    pub fn plan(&self) -> Option<&Plan> {
        self.engine.plan().map(|(plan, ..)| plan)
    }

    /// The origin of the plan; `None` for engines without a plan.
    pub fn planning(&self) -> Option<Planning> {
        self.engine.plan().map(|(_, planning, _)| planning)
    }

    /// Number of worker threads.
    pub fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// Whether the worker threads are pinned to cores.
    pub fn pinned(&self) -> Pinned {
        self.pool.pinned()
    }

    /// Runs `work` on the worker threads.
    pub(crate) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Renders the image.
    ///
    /// # Errors
    /// If memory for the image exceeds the limit, returns [`Error::Usage`](crate::Error::Usage). If
    /// its allocation fails, returns [`Error::Resource`](crate::Error::Resource).
    pub fn render(&self) -> Result<Render> {
        let mut rendering = self.begin()?;
        self.advance(&mut rendering, &())?;
        self.finish(&mut rendering)
    }

    /// Begins a render of the whole image, without any samples yet.
    ///
    /// # Errors
    /// If memory for the image exceeds the limit, returns [`Error::Usage`](crate::Error::Usage). If
    /// its allocation fails, returns [`Error::Resource`](crate::Error::Resource).
    pub fn begin(&self) -> Result<RenderState> {
        let View { settings, compute, .. } = &*self.view;
        let (image, samples) = (settings.image(), 0..settings.spp);
        compute.check_memory(self.view.scene(), Some(FilmOf(settings, samples.clone())))?;
        let channels = settings.stored_layers().channels();
        Film::new(image, samples, channels).map(|film| RenderState::new(film, settings))
    }

    /// Renders all missing samples of `rendering`, unless `observer` stops it.
    ///
    /// # Errors
    /// Returns the same errors as [`advance_to`](Self::advance_to).
    pub fn advance(&self, rendering: &mut RenderState, observer: &dyn Observer) -> Result<()> {
        let end = rendering.film.samples().end;
        self.advance_to(rendering, end, observer)
    }

    /// Renders the missing samples among the first `end` of each pixel of `rendering`, unless
    /// `observer` stops it. The image does not depend on the number or size of such passes.
    ///
    /// # Errors
    /// If `rendering` has samples of another scene or view, or samples that were rendered with
    /// other settings that affect the image, returns [`Error::Usage`](crate::Error::Usage). If
    /// memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub fn advance_to(
        &self,
        rendering: &mut RenderState,
        end: u32,
        observer: &dyn Observer,
    ) -> Result<()> {
        self.advance_shared(&Mutex::new(rendering), end, observer)
    }

    /// [`advance_to`](Self::advance_to) of a rendering that other threads may look at.
    pub(super) fn advance_shared(
        &self,
        rendering: &Mutex<impl BorrowMut<RenderState> + Send>,
        end: u32,
        observer: &dyn Observer,
    ) -> Result<()> {
        let start = Instant::now();
        let schedule = {
            let mut rendering = locked(rendering);
            let rendering = (*rendering).borrow_mut();
            rendering.claim(self.view.scene(), &self.view.settings)?;
            Schedule::new(&rendering.film, end, self.engine.unit_paths())
        };
        let most_paths = schedule.most_paths();
        let shared = Mutex::new(Shared::new(rendering, schedule));
        let lock = || locked(&shared);
        let failed = AtomicBool::new(false);
        let stop = || if failed.load(Ordering::Relaxed) { Stop::Now } else { observer.stop() };
        let next = || {
            while stop() == Stop::No {
                let mut shared = lock();
                if !shared.is_far_ahead() {
                    return shared.next();
                }
                drop(shared);
                // Wait for the worker that is still rendering an earlier unit: finished units stay
                // in memory until that unit is done.
                thread::sleep(Duration::from_millis(1));
            }
            None
        };
        let abandon = || stop() == Stop::Now;
        let work = |thread: usize| {
            let alarm = Alarm(&failed);
            // Created with the first task: a thread that finds no work allocates nothing.
            let mut worker = None;
            while let Some(task) = next() {
                let (_, worker) = worker.get_or_insert_with(|| self.worker(most_paths));
                let begin = Instant::now();
                let Some(mut taken) = worker.take(&task, &abandon) else { break };
                #[cfg(feature = "slowed")]
                super::slowed::dawdle(begin.elapsed());
                if self.view.compute.timeline {
                    taken.laps.push(Lap {
                        start: begin,
                        end: Instant::now(),
                        activity: Activity::Unit(task.unit),
                    });
                }
                let progress = lock().add(taken, thread)?;
                observer.progressed(progress);
            }
            locked(&self.idle).extend(worker);
            mem::forget(alarm);
            Ok(())
        };
        let worked: Result<Vec<()>> = self.pool.broadcast(work).into_iter().collect();
        (*locked(rendering)).borrow_mut().seconds += start.elapsed().as_secs_f64();
        worked.map(|_| ())
    }

    /// A worker for units of at most `paths` paths: an idle one, if there is one with enough room.
    fn worker(&self, paths: u64) -> (u64, Box<dyn UnitWorker>) {
        let mut idle = locked(&self.idle);
        match idle.iter().position(|(room, _)| *room >= paths) {
            Some(index) => idle.swap_remove(index),
            None => (paths, self.engine.worker(paths)),
        }
    }

    /// Returns the image rendered so far. Moves the timeline out of `rendering`, as it may be
    /// large.
    ///
    /// # Errors
    /// If there is not enough memory for the image, returns
    /// [`Error::Resource`](crate::Error::Resource).
    pub fn finish(&self, rendering: &mut RenderState) -> Result<Render> {
        Ok(Render {
            image: rendering.image()?,
            tally: rendering.tally.clone(),
            waves: rendering.waves.clone(),
            seconds: Seconds { render: rendering.seconds, ..self.seconds },
            timeline: mem::take(&mut rendering.timeline),
        })
    }
}
