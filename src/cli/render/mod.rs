//! `ptfast render`.

pub(super) mod args;
mod checkpoint_args;
mod checkpoint_file;
mod checkpointing;
mod frame_args;
mod frames;
mod goal;
mod goal_args;
mod job;
mod part_args;
mod plan_file;
mod record;
mod report;
mod scheduler;
mod stats;
mod summary;
pub(super) mod target;
mod timeline;
mod watch;

use std::borrow::Cow;
use std::thread;
use std::time::Instant;

use self::args::RenderArgs;
use self::checkpoint_file::CheckpointFile;
use self::checkpointing::Saved;
use self::job::RenderJob;
use self::record::{Run, StepSeconds};
use self::target::Target;
use self::watch::Schedule;
use super::arguments::denoise::Denoised;
use super::console::{advise_on_build, notice, say};
use super::progress::{ProgressMode, ProgressReport};
use super::{console, progress};
use crate::checkpoint::Part;
use crate::denoise::Denoise;
use crate::engine::{PreparedScene, Render, Renderer, Session};
use crate::error::Result;
use crate::image::{Display, Image};
use crate::interrupt;
use crate::isa::Isa;
use crate::measure::machine::Interference;

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    let start = Instant::now();
    console::write_json(args.mode() == ProgressMode::Json);
    if args.quiet {
        console::suppress_notices();
    }
    interrupt::leave_at_once(true);
    interrupt::watch()?;
    if let Some(frames) = args.frame.frames() {
        return frames::run(args, frames);
    }
    let mut job = RenderJob::new(args, start)?;
    if args.skip_complete && job.is_complete()? {
        return job.report_complete();
    }
    job.run()
}

impl RenderJob<'_> {
    /// The appearance of the image.
    fn display(&self) -> Display {
        let display = self.args.display.display();
        let half_layers = display.half_layers && !self.settings.layers.is_empty();
        Display { half_layers, ..display }
    }

    /// Whether all output files exist, and the image or film belongs to this render.
    fn is_complete(&mut self) -> Result<bool> {
        self.part.identity.scene_hash = self.scene_hash();
        let reports = [&self.args.json, &self.args.trace];
        let layers = self.output.layer_files(&self.args.layers);
        let exist = reports.into_iter().flatten().chain(&layers).all(|file| file.exists());
        Ok(exist
            && self.output.is_complete(
                &self.part,
                (&self.args.denoise, &self.args.layers),
                self.display(),
                self.scene.limits(),
            )?)
    }

    fn report_complete(&self) -> Result<()> {
        if !self.args.quiet {
            say(format_args!("{} is complete", self.output))?;
        }
        if self.args.mode() == ProgressMode::Json {
            progress::write_complete(self.part.empty_rendering()?.film.samples_to_do());
        }
        Ok(())
    }

    /// The hash of the scene as seen by the camera.
    fn scene_hash(&self) -> String {
        match &self.part.identity.scene_hash {
            hash if hash.is_empty() => self.scene.hash_with(self.settings.camera(&self.scene)),
            // `--skip-complete` has asked for it before.
            known => known.clone(),
        }
    }

    /// Builds the trees of a large scene, and meanwhile hashes it.
    fn build_and_hash(&self, prepared: &PreparedScene) -> String {
        thread::scope(|scope| {
            if prepared.is_large() {
                // Without a thread, the renderer builds them.
                let build = || prepared.build(&self.compute);
                let _ = thread::Builder::new().spawn_scoped(scope, build);
            }
            self.scene_hash()
        })
    }

    fn checkpoint_file(&self) -> CheckpointFile<'_> {
        CheckpointFile::new(
            &self.part,
            &self.output,
            self.args.sample.scene.name(),
            self.args.checkpoint.checkpoint.as_deref(),
        )
    }

    fn run(mut self) -> Result<()> {
        let file = self.checkpoint_file();
        self.check_files(&file)?;
        let preparing = Instant::now();
        let what = "preparing the render";
        let prepared = self.prepared.clone();
        let hash = progress::waiting(what, self.args.mode(), || match file.exists() {
            // No tree is built for a checkpoint of another render.
            true => self.scene_hash(),
            false => self.build_and_hash(&prepared),
        });
        self.part.identity.scene_hash = hash;
        let preparing = preparing.elapsed().as_secs_f64();
        let Self { args, scene, part, .. } = &self;
        let mut file = self.checkpoint_file();
        let rendering = file.load(scene.limits())?;
        let left = rendering.film.samples_to_do() - rendering.progress().samples;
        let pixels = rendering.film.pixels();
        let paths =
            self.goal.map_or(left, |goal| left.min(u64::from(goal.samples(pixels)) * pixels));
        let renderer = progress::waiting(what, args.mode(), || {
            Renderer::for_paths(prepared, self.settings.clone(), self.compute.clone(), paths)
        })?;
        let mut session = Session::of(renderer, rendering);
        advise_on_build(Isa::Avx2);
        let before = Interference::so_far();
        // From here on, a signal saves the samples that are finished.
        interrupt::leave_at_once(false);
        let progress = ProgressReport::new(&session, scene.name(), args.mode());
        let schedule = Schedule {
            every: args.checkpoint.checkpoint_every,
            time_limit: args.checkpoint.time_limit,
            start: self.start,
        };
        if file.exists() {
            let samples = self.saved(&session, part, &file).samples_per_pixel();
            let file = file.path().display();
            notice(format_args!("continuing {file}, which has {samples}"));
        }
        let noise = self.saved(&session, part, &file).render(&schedule, &progress)?.noise();
        let interference = Interference::so_far().since(before);

        let writing = Instant::now();
        let mut part = Cow::Borrowed(part);
        if self.goal.is_some() {
            session.end();
            progress.expect(session.progress().samples);
            part.to_mut().end_at(session.samples());
        }
        let mut render = session.finish()?;
        // Only whole images have a hash.
        let hash = part.is_whole().then(|| render.image.hash());
        let mean = render.image.mean();
        let denoised = self
            .denoise(&session, &mut render.image)
            .map_err(|error| self.saved(&session, &part, &file).save_instead(error))?;
        let denoise = denoised.as_ref().map(|denoised| denoised.seconds);
        self.write(&part, &session, &render, hash.as_deref(), denoised.as_ref())
            .map_err(|error| self.saved(&session, &part, &file).save_instead(error))?;
        let finished = file.finish(&part.checkpoint(scene.name(), &session.state()), left > 0);
        let seconds = StepSeconds {
            load: self.load,
            build: preparing + render.seconds.build,
            plan: render.seconds.plan,
            render: render.seconds.render,
            write: writing.elapsed().as_secs_f64() - denoise.unwrap_or(0.0),
            denoise,
        };
        let hash = hash.as_deref();
        let run = Run {
            scene,
            renderer: session.renderer(),
            render: &render,
            scene_hash: &part.identity.scene_hash,
            mean,
            hash,
            denoised: denoised.as_ref().and_then(|denoised| denoised.hash.as_deref()),
            seconds,
            noise,
        };
        self.report(&run, interference)?;
        self.say_what_goal_missed(&run);
        self.say_what_would_help(&run, &session);
        finished?;
        progress.done(session.progress());
        Ok(())
    }

    /// The render `part` so far, which is saved in `file`.
    fn saved<'b>(
        &'b self,
        session: &'b Session,
        part: &'b Part,
        file: &'b CheckpointFile<'b>,
    ) -> Saved<'b> {
        let (scene, goal, display) = (self.scene.name(), self.goal, self.display());
        Saved { session, scene, part, file, goal, denoise: &self.args.denoise, display }
    }

    /// Denoises the picture of a finished render, if that is asked for.
    fn denoise(&self, session: &Session, image: &mut Image) -> Result<Option<Denoised>> {
        let mut args = self.args.denoise.clone();
        if args.denoise == Some(Denoise::Good) && session.samples() < 2 {
            notice(format_args!(
                "with one sample per pixel, which has no halves, the picture is denoised as by --denoise=fast"
            ));
            args.denoise = Some(Denoise::Fast);
        }
        args.apply(image, self.compute.threads, &self.args.layers, self.output.is_exr())
    }

    /// Writes the image or the film.
    fn write(
        &self,
        part: &Part,
        session: &Session,
        render: &Render,
        hash: Option<&str>,
        denoised: Option<&Denoised>,
    ) -> Result<()> {
        if let Target::Film(path) = &self.output {
            return part.checkpoint(self.scene.name(), &session.state()).write(path);
        }
        let metadata = part.identity.metadata(hash.unwrap_or_default());
        let metadata = Denoised::noted(denoised, metadata);
        self.output.write_image(&render.image, self.display(), &metadata)
    }
}
