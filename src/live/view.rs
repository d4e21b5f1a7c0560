//! A view: a camera that somebody moves, and the pictures that it sees.

use std::mem;
use std::time::{Duration, Instant};

use super::fade::Fade;
use super::history::{self, History};
use super::pace::Pace;
use super::paint::paint;
use crate::denoise::Denoise;
use crate::engine::{
    ComputeSettings, ImageSettings, Layer, Layers, Observer, Plan, PlanChoice, Progress, Session,
    Stop, Until,
};
use crate::error::{Error, Result};
use crate::film::CHUNK;
use crate::image::Display;
use crate::limits::MAX_SPP;
use crate::scene::Scene;
use crate::shading::{Camera, CameraFile};

/// Without a movement for so long, a camera is at rest.
const REST: Duration = Duration::from_millis(120);
/// Frames per second while the camera moves.
const RATE: f64 = 30.0;
/// The first samples at rest are shown after this time. Later pictures take at most this share of the time.
const FIRST: Duration = Duration::from_millis(60);
const SHARE: u32 = 12;
/// Turns of a view are about as long at most, since others wait.
const LONGEST: Duration = Duration::from_millis(100);

/// A picture of a view.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Red, green, blue and 255 of each pixel.
    pub(crate) codes: Vec<u8>,
    /// Samples per pixel: of the render at rest, or 0 while the camera moves.
    pub(crate) samples: u32,
    /// Rays that were traced for it since the last one, and in what time.
    pub(crate) rays: u64,
    pub(crate) seconds: f64,
}

/// What a view has done in its turn.
#[derive(Debug)]
pub(crate) enum Turn {
    /// There was nothing to do.
    Idle,
    /// There are more samples.
    Works,
    /// There is something to show.
    Shows(Picture),
}

/// What a view does.
#[derive(Clone, Copy, Debug)]
enum State {
    /// The camera was moved at this time.
    Moving(Instant),
    /// The camera rests.
    Resting,
}

/// A camera that somebody moves.
#[derive(Debug)]
pub(crate) struct View {
    session: Session,
    /// The settings of the picture at rest.
    settings: ImageSettings,
    compute: ComputeSettings,
    /// The plan that was found for the first picture at rest.
    plan: Option<Plan>,
    camera: CameraFile,
    display: Display,
    /// The layer that is shown instead of the colour.
    layer: Option<Layer>,
    history: History,
    pace: Pace,
    state: State,
    /// The seed of the last frame in motion.
    seed: u64,
    /// When the next picture at rest is due.
    due: Instant,
    /// How much of the denoiser's result the picture at rest has.
    fade: Fade,
    /// Seconds that a sample of each pixel takes.
    per_sample: Option<f64>,
    /// The hash of the picture at rest, once it has the wanted samples.
    hash: Option<String>,
    /// Rays of the render at rest up to the last picture, and the time of those after it.
    rays: u64,
    seconds: f64,
}

/// The layers of pictures at rest.
const RESTING: [Layer; 5] =
    [Layer::Albedo, Layer::Normal, Layer::Depth, Layer::ColorEven, Layer::ColorOdd];

impl View {
    /// The settings of a frame in motion, for those of a picture at rest.
    pub(crate) fn first(settings: &ImageSettings) -> ImageSettings {
        ImageSettings { spp: 1, layers: Layers::new(history::LAYERS), ..settings.clone() }
    }

    /// A view of the scene of a session, on its threads. `settings` are those of the picture at rest, whose hash is
    /// given at their number of samples.
    ///
    /// # Errors
    /// Those of [`Session::beside`].
    pub(crate) fn new(
        of: &Session,
        settings: ImageSettings,
        camera: CameraFile,
        display: Display,
    ) -> Result<Self> {
        let compute = of.renderer().compute_settings().clone();
        let session = of.beside(Self::first(&settings), compute.clone())?;
        Ok(Self {
            session,
            seed: settings.seed,
            settings,
            compute,
            plan: None,
            camera,
            per_sample: None,
            hash: None,
            display,
            layer: None,
            history: History::default(),
            pace: Pace::new(RATE),
            state: State::Moving(Instant::now()),
            due: Instant::now(),
            fade: Fade::default(),
            rays: 0,
            seconds: 0.0,
        })
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &Scene {
        self.session.renderer().prepared().scene()
    }

    /// The camera.
    pub(crate) fn camera(&self) -> &CameraFile {
        &self.camera
    }

    /// How pictures look.
    pub(crate) fn display(&self) -> Display {
        self.display
    }

    /// The settings of the picture at rest.
    pub(crate) fn settings(&self) -> &ImageSettings {
        &self.settings
    }

    /// Replaces the camera.
    pub(crate) fn set_camera(&mut self, camera: CameraFile) {
        self.camera = camera;
        self.restart();
    }

    /// Changes the size of the output.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        (self.settings.width, self.settings.height) = (width, height);
        self.restart();
    }

    /// Changes the number of samples at which the picture at rest has its hash.
    pub(crate) fn want(&mut self, spp: u32) {
        self.settings.spp = spp;
        self.restart();
    }

    /// Aims at so many frames per second while the camera moves.
    pub(crate) fn aim_at(&mut self, rate: f64) {
        self.pace = Pace::new(rate);
    }

    /// Shows a layer, or the colour.
    pub(crate) fn show(&mut self, layer: Option<Layer>) {
        self.layer = layer;
        self.restart();
    }

    /// A view with the same looks of the scene of another session.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub(crate) fn of(
        &self,
        session: &Session,
        settings: ImageSettings,
        camera: CameraFile,
    ) -> Result<Self> {
        let mut view = Self::new(session, settings, camera, self.display)?;
        view.layer = self.layer;
        Ok(view)
    }

    /// Changes how pictures look.
    pub(crate) fn set_display(&mut self, display: Display) {
        self.display = display;
        self.hurry();
    }

    /// Shows the next picture soon.
    pub(crate) fn hurry(&mut self) {
        self.due = Instant::now();
    }

    /// Begins anew after something changed that may be seen.
    fn restart(&mut self) {
        (self.state, self.hash) = (State::Moving(Instant::now()), None);
    }

    /// The hash of the picture at rest with the wanted number of samples, once it had so many.
    pub(crate) fn hash(&self) -> Option<&str> {
        self.hash.as_deref()
    }

    /// The distance along the direction of view at a place of the picture, in shares of its width and height; `None`
    /// for the background.
    pub(crate) fn depth(&self, x: f32, y: f32) -> Option<f32> {
        self.history.depth(x, y)
    }

    /// Renders for a while, or until `is_asked`, and gives a picture if one is wanted and there is something new.
    ///
    /// # Errors
    /// Those of [`Session::set`] and [`Session::render`].
    pub(crate) fn next(
        &mut self,
        wanted: bool,
        is_asked: &(dyn Fn() -> bool + Sync),
    ) -> Result<Turn> {
        match self.state {
            State::Moving(_) if !wanted => return Ok(Turn::Idle),
            State::Moving(since) if since.elapsed() < REST || self.history.is_empty() => {
                return self.frame().map(Turn::Shows);
            }
            State::Moving(_) => self.rest()?,
            // Nobody looks.
            State::Resting if !wanted && self.hash.is_some() => return Ok(Turn::Idle),
            State::Resting => {}
        }
        self.refine(is_asked)?;
        match wanted && self.session.samples() > 0 && Instant::now() >= self.due {
            true => self.refined().map(Turn::Shows),
            false => Ok(Turn::Works),
        }
    }

    /// How pictures are computed: by the plan that was found at rest, or else by this choice.
    fn compute(&self, plan: PlanChoice) -> ComputeSettings {
        let plan = self.plan.clone().map_or(plan, PlanChoice::Given);
        ComputeSettings { plan, ..self.compute.clone() }
    }

    /// A frame with one sample per pixel.
    fn frame(&mut self) -> Result<Picture> {
        let start = Instant::now();
        let [width, height] = self.pace.size([self.settings.width, self.settings.height]);
        self.seed = self.seed.wrapping_add(1);
        let camera = Camera::try_from(&self.camera)?;
        let seen = camera.frame(width, height);
        let settings = ImageSettings {
            camera: Some(camera),
            width,
            height,
            spp: 1,
            seed: self.seed,
            layers: Layers::new(history::LAYERS.into_iter().chain(self.layer)),
            ..self.settings.clone()
        };
        self.session.set(settings, self.compute(PlanChoice::Usual))?;
        let Progress { samples, rays } = self.session.render(Until::Complete, &())?;
        let stored = self.session.renderer().image_settings().stored_layers();
        let state = self.session.state();
        let (film, history, display) = (&state.film, &mut self.history, &self.display);
        let codes = self.session.renderer().install(|| {
            let image = history.blend(film, &stored, seen);
            if self.layer.is_some() {
                return Ok(Vec::new());
            }
            Ok::<_, Error>(display.rgba(image.denoised(Denoise::Fast)?.pixels()))
        })?;
        drop(state);
        let codes = match self.layer {
            Some(layer) => self.painted(layer)?,
            None => codes,
        };
        self.pace.note(samples, start.elapsed());
        let seconds = start.elapsed().as_secs_f64();
        Ok(Picture { width, height, codes, samples: 0, rays, seconds })
    }

    /// Begins the render of the camera that rests now.
    fn rest(&mut self) -> Result<()> {
        let camera = Some(Camera::try_from(&self.camera)?);
        let layers = Layers::new(RESTING.into_iter().chain(self.layer));
        let settings = ImageSettings { camera, layers, ..self.settings.clone() };
        self.session.set(settings, self.compute(PlanChoice::Measured))?;
        self.plan = self.session.renderer().plan().cloned();
        (self.state, self.rays, self.seconds) = (State::Resting, 0, 0.0);
        (self.fade, self.per_sample) = (Fade::default(), None);
        self.due = Instant::now() + FIRST;
        Ok(())
    }

    /// Adds samples to the picture at rest: at first one, then more and more until the next picture is due.
    fn refine(&mut self, is_asked: &(dyn Fn() -> bool + Sync)) -> Result<()> {
        let (done, wanted) = (self.session.samples(), self.settings.spp);
        let left = self.due.saturating_duration_since(Instant::now()).min(LONGEST);
        let fit = self.per_sample.map_or(1, |one| (left.as_secs_f64() / one) as u32);
        let mut until = (done + fit.clamp(1, done.max(1))).min(MAX_SPP);
        // The film keeps sums of so many samples.
        until -= if until - until % CHUNK > done { until % CHUNK } else { 0 };
        if done < wanted {
            until = until.min(wanted);
        }
        if self.session.renderer().image_settings().spp < until {
            let settings = self.session.renderer().image_settings();
            let spp = until.saturating_mul(2).min(MAX_SPP);
            let settings = ImageSettings { spp, ..settings.clone() };
            self.session.set(settings, self.compute(PlanChoice::Measured))?;
        }
        let start = Instant::now();
        self.session.render(Until::Samples(until), &Watch(is_asked))?;
        let seconds = start.elapsed().as_secs_f64();
        self.seconds += seconds;
        if self.session.samples() == until && until > done {
            self.per_sample = Some(seconds / f64::from(until - done));
        }
        if self.hash.is_none() && self.session.samples() == wanted {
            self.hash = Some(self.session.snapshot_of(&Layers::default())?.hash());
        }
        Ok(())
    }

    /// The picture at rest.
    fn refined(&mut self) -> Result<Picture> {
        let start = Instant::now();
        let samples = self.session.samples();
        let ImageSettings { width, height, .. } = *self.session.renderer().image_settings();
        let codes = match self.layer {
            Some(layer) => self.painted(layer)?,
            None => {
                let (image, display) = (self.session.snapshot()?, &self.display);
                let fade = &mut self.fade;
                self.session.renderer().install(|| fade.shown(image, samples, display))?
            }
        };
        let traced = self.session.progress().rays;
        let rays = traced - mem::replace(&mut self.rays, traced);
        let seconds = mem::take(&mut self.seconds);
        // Most of the time is for samples.
        self.due = Instant::now() + (start.elapsed() * SHARE).max(FIRST);
        Ok(Picture { width, height, codes, samples, rays, seconds })
    }

    /// The codes of a layer.
    fn painted(&self, layer: Layer) -> Result<Vec<u8>> {
        let image = self.session.snapshot_of(&Layers::new([layer]))?;
        Ok(self.session.renderer().install(|| paint(&image, layer, &self.display)))
    }
}

/// Stops a render when something is asked.
struct Watch<'a>(&'a (dyn Fn() -> bool + Sync));

impl Observer for Watch<'_> {
    fn progressed(&self, _: Progress) {}

    fn stop(&self) -> Stop {
        if (self.0)() { Stop::Now } else { Stop::No }
    }
}
