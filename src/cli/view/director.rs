//! The director: gives each page its share of the cores.

use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;

use super::ViewArgs;
use super::client::Client;
use super::hub::Hub;
use super::message::{About, Ask, Traced};
use super::trace::trace;
use super::watch::{Reloaded, Watch};
use crate::cli::arguments::CameraArgs;
use crate::cli::render::args::RenderArgs;
use crate::engine::{ImageSettings, Layer, Session};
use crate::error::{Error, Result};
use crate::image::{Display, Exposure, ToneMap};
use crate::interrupt;
use crate::limits::{MAX_SPP, check_image};
use crate::live::{Picture, Turn, View};
use crate::measure::settings;
use crate::shading::{Camera, CameraFile};

/// Time in which pages take their last message at the end.
const FAREWELL: Duration = Duration::from_millis(200);

/// Renders what pages see.
pub(super) struct Director<'a> {
    args: &'a ViewArgs,
    session: Session,
    settings: ImageSettings,
    hub: Arc<Hub>,
    watch: Watch,
    seats: Vec<Seat>,
}

/// A page and what it sees.
struct Seat {
    client: Arc<Client>,
    view: View,
    /// The arguments of the camera before it was moved.
    camera: CameraArgs,
    error: Option<String>,
    path: Option<Traced>,
}

impl<'a> Director<'a> {
    /// Prepares the scene of `session` for pages.
    pub(super) fn new(
        args: &'a ViewArgs,
        session: Session,
        settings: ImageSettings,
        hub: Arc<Hub>,
        watch: Watch,
    ) -> Self {
        Self { args, session, settings, hub, watch, seats: Vec::new() }
    }

    /// Renders until a signal arrives.
    pub(super) fn run(&mut self) {
        while interrupt::signal().is_none() {
            for client in self.hub.take_joined() {
                match self.seat(Arc::clone(&client)) {
                    Ok(seat) => self.seats.push(seat),
                    // Other pages go on.
                    Err(error) => {
                        let error = Some(error.to_string());
                        client
                            .send(About { error: error.as_deref(), ..About::default() }.with(&[]));
                        client.end();
                    }
                }
            }
            self.seats.retain(|seat| !seat.client.is_over());
            if let Some(reloaded) = self.watch.reloaded(self.args) {
                self.reload(reloaded);
            }
            let mut works = false;
            for seat in &mut self.seats {
                let asked = seat.client.take_asked();
                let first = &self.args.sample.camera;
                for ask in asked {
                    let taken = seat.take(ask, &self.session, first);
                    seat.error = taken.err().map(|error| error.to_string());
                }
                works |= seat.turn(self.args);
            }
            if !works {
                self.hub.wait();
            }
        }
        self.seats.iter().for_each(|seat| seat.client.end());
        let end = Instant::now() + FAREWELL;
        while Instant::now() < end
            && self.seats.iter().any(|seat| Arc::strong_count(&seat.client) > 1)
        {
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Shows a scene that was read again, by the cameras as they are. A broken one is reported, and the last good one stays.
    fn reload(&mut self, reloaded: Reloaded) {
        let changed = reloaded.and_then(|(session, settings, watch)| {
            let views = self.seats.iter().map(|seat| self.again(seat, &session, &settings));
            let views: Vec<_> = views.collect::<Result<_>>()?;
            for (seat, (view, camera)) in self.seats.iter_mut().zip(views) {
                (seat.view, seat.camera, seat.error, seat.path) = (view, camera, None, None);
            }
            (self.session, self.settings, self.watch) = (session, settings, watch);
            Ok(())
        });
        if let Err(error) = changed {
            for seat in &mut self.seats {
                seat.error = Some(error.to_string());
                seat.client.send(seat.message(None, self.args));
            }
        }
    }

    /// The view of a seat in the scene of another session: what the page has changed stays, and the rest is new. Also
    /// returns the arguments of its camera.
    fn again(
        &self,
        seat: &Seat,
        session: &Session,
        settings: &ImageSettings,
    ) -> Result<(View, CameraArgs)> {
        let (before, scene) = (seat.view.scene(), session.renderer().prepared().scene());
        let (camera, file) = match seat.camera.file(scene) {
            Ok(file) => (seat.camera.clone(), file),
            // Its camera is gone.
            Err(_) => {
                let first = self.args.sample.camera.clone();
                let file = first.file(scene)?;
                (first, file)
            }
        };
        let moved = seat.view.camera();
        let is_moved = seat.camera.file(before).is_ok_and(|file| file != *moved);
        let file = match is_moved {
            false => file,
            // These cannot be changed on the page.
            true => CameraFile {
                filter: file.filter,
                shutter: file.shutter,
                mirrored: file.mirrored,
                parallel: file.parallel,
                ..moved.clone()
            },
        };
        let own = seat.view.settings();
        let kept = |own: u32, before: u32, now: u32| if own == before { now } else { own };
        let settings = ImageSettings {
            width: kept(own.width, self.settings.width, settings.width),
            height: kept(own.height, self.settings.height, settings.height),
            spp: kept(own.spp, self.settings.spp, settings.spp),
            ..settings.clone()
        };
        Ok((seat.view.of(session, settings, file)?, camera))
    }

    fn seat(&self, client: Arc<Client>) -> Result<Seat> {
        let camera = self.args.sample.camera.clone();
        let file = camera.file(self.session.renderer().prepared().scene())?;
        let display = self.args.display.display();
        let view = View::new(&self.session, self.settings.clone(), file, display)?;
        Ok(Seat { client, view, camera, error: None, path: None })
    }
}

impl Seat {
    /// Renders for a while. Returns whether there was something to do.
    fn turn(&mut self, args: &ViewArgs) -> bool {
        let client = Arc::clone(&self.client);
        let is_asked = || client.has_asked() || client.is_over() || interrupt::signal().is_some();
        match self.view.next(client.is_ready(), &is_asked) {
            Ok(Turn::Idle) => false,
            Ok(Turn::Works) => true,
            Ok(Turn::Shows(picture)) => {
                client.send(self.message(Some(&picture), args));
                true
            }
            Err(error) => {
                // It is tried again, but told once.
                if self.error.replace(error.to_string()).is_none() {
                    client.send(self.message(None, args));
                }
                false
            }
        }
    }

    fn message(&self, picture: Option<&Picture>, args: &ViewArgs) -> Vec<u8> {
        let settings = self.view.settings();
        let scene = self.view.scene();
        let file = self.view.camera();
        let camera = self.camera.moved(scene, file);
        let pixels = |width: u32, height: u32| f64::from(width) * f64::from(height);
        let about = About {
            size: (settings.width, settings.height),
            hash: self.view.hash(),
            spp: settings.spp,
            command: &command(args, &camera, settings),
            fov: file.vfov,
            lens: (file.defocus_angle, file.focus_distance),
            cameras: scene.cameras().names().collect(),
            error: self.error.as_deref(),
            path: self.path.as_ref(),
            ..About::default()
        };
        let Some(Picture { width, height, codes, samples, rays, seconds }) = picture else {
            return about.with(&[]);
        };
        let traced = pixels(*width, *height) / pixels(settings.width, settings.height);
        let (width, height, samples, rays, seconds) = (*width, *height, *samples, *rays, *seconds);
        About { width, height, samples, traced, rays, seconds, ..about }.with(codes)
    }

    /// Does what the page asks for. `first` are the arguments of the camera that the program began with.
    fn take(&mut self, ask: Ask, session: &Session, first: &CameraArgs) -> Result<()> {
        let scene = session.renderer().prepared().scene();
        let file = self.view.camera().clone();
        let usage = |message: String| Err(Error::Usage(message));
        let camera = match ask {
            Ask::Shown => return Ok(()),
            Ask::Move(by) => by.apply(&file)?,
            Ask::Camera(name) => {
                let camera = match name.is_empty() {
                    true => first.clone(),
                    false => CameraArgs::named(&name),
                };
                let file = camera.file(scene)?;
                self.camera = camera;
                file
            }
            Ask::Fov(vfov) => CameraFile { vfov, parallel: None, ..file },
            Ask::Lens { angle, distance } => {
                CameraFile { defocus_angle: angle, focus_distance: distance, ..file }
            }
            Ask::Focus { x, y } => match self.view.depth(x, y) {
                None => return Ok(()),
                Some(focus_distance) => CameraFile { focus_distance, ..file },
            },
            Ask::Size(width, height) => {
                check_image(width, height).map_err(Error::Usage)?;
                let settings = ImageSettings { width, height, ..self.view.settings().clone() };
                settings.check(scene.limits())?;
                self.view.resize(width, height);
                return Ok(());
            }
            Ask::Exposure(stops) => {
                let exposure = Exposure::Stops(stops);
                self.view.set_display(Display { exposure, ..self.view.display() });
                return Ok(());
            }
            Ask::Tonemap(name) => {
                let map = ToneMap::ALL.into_iter().find(|map| map.name() == name);
                let Some(tone_map) = map else {
                    return usage(format!("unknown tone map `{name}`"));
                };
                self.view.set_display(Display { tone_map, ..self.view.display() });
                return Ok(());
            }
            Ask::Spp(spp) if (1..=MAX_SPP).contains(&spp) => {
                self.view.want(spp);
                return Ok(());
            }
            Ask::Path { x, y } => {
                let camera = Some(Camera::try_from(&file)?);
                let settings = ImageSettings { camera, ..self.view.settings().clone() };
                self.path = Some(trace(session.renderer().prepared(), settings, (x, y))?);
                self.view.hurry();
                return Ok(());
            }
            Ask::Layer(name) => {
                let layer = Layer::ALL.into_iter().find(|layer| layer.name() == name);
                if layer.is_none() && !name.is_empty() {
                    return usage(format!("unknown layer `{name}`"));
                }
                self.view.show(layer);
                return Ok(());
            }
            Ask::Rate(rate) if rate > 0.0 && rate.is_finite() => {
                self.view.aim_at(rate);
                return Ok(());
            }
            Ask::Rate(_) => return usage("the rate of frames must be above 0".to_owned()),
            Ask::Spp(_) => return usage(format!("samples must be from 1 to {MAX_SPP}")),
        };
        Camera::try_from(&camera)?;
        self.view.set_camera(camera);
        self.path = None;
        Ok(())
    }
}

/// The command that renders the picture of a page.
fn command(args: &ViewArgs, camera: &CameraArgs, image: &ImageSettings) -> String {
    // Each picture comes with its command.
    static RENDER: LazyLock<clap::Command> =
        LazyLock::new(|| RenderArgs::augment_args(clap::Command::new("render")));
    let has = |flag: &str| RENDER.get_arguments().any(|known| known.get_long() == Some(flag));
    let flags = settings::flags(image, has);
    format!("ptfast render {}{} {flags}", args.sample.scene.words(), camera.words())
}
