//! What a render is to do: its arguments, checked.

use std::time::Instant;

use super::args::RenderArgs;
use super::checkpoint_file::CheckpointFile;
use super::goal::Goal;
use super::plan_file;
use super::target::Target;
use crate::accel::TreeQuality;
use crate::checkpoint::Part;
use crate::cli::console::notice;
use crate::cli::files;
use crate::cli::progress::{self, ProgressMode};
use crate::engine::{ComputeSettings, Engine, FilmOf, ImageSettings, PreparedScene};
use crate::error::{Error, Result};
use crate::scene::Scene;

/// A render whose arguments are valid, and whose output files can be written.
pub(super) struct RenderJob<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) start: Instant,
    pub(super) scene: Scene,
    pub(super) prepared: PreparedScene,
    /// Whether lamps may be in the units of Blender, although the options do not say so.
    pub(super) maybe_blender: bool,
    /// Seconds that loading the scene took.
    pub(super) load: f64,
    pub(super) settings: ImageSettings,
    pub(super) compute: ComputeSettings,
    pub(super) part: Part,
    pub(super) output: Target,
    pub(super) goal: Option<Goal>,
}

/// A scene that was read.
#[derive(Clone)]
pub(super) struct Loaded {
    pub(super) scene: Scene,
    pub(super) prepared: PreparedScene,
    maybe_blender: bool,
    seconds: f64,
}

impl Loaded {
    /// Reads the scene of `args`.
    pub(super) fn new(args: &RenderArgs) -> Result<Self> {
        // What is wrong without the scene is reported before a large one is loaded.
        args.goal.goal(Instant::now())?;
        args.output.clone().map(Target::of_path).transpose()?;
        args.denoise.check()?;
        let loading = Instant::now();
        let reading = format!("reading {}", args.sample.scene.name());
        let (scene, maybe_blender) = progress::waiting(&reading, args.mode(), || {
            let parsed = args.limits.read_for(&args.sample.scene, args.sample.size())?;
            Ok::<_, Error>((parsed.resolve()?, parsed.maybe_blender))
        })?;
        let seconds = loading.elapsed().as_secs_f64();
        let prepared = PreparedScene::new(scene.clone());
        Ok(Self { scene, prepared, maybe_blender, seconds })
    }
}

impl<'a> RenderJob<'a> {
    pub(super) fn new(args: &'a RenderArgs, start: Instant) -> Result<Self> {
        Self::of(args, Loaded::new(args)?, start)
    }

    /// The render of a scene that was read.
    pub(super) fn of(args: &'a RenderArgs, loaded: Loaded, start: Instant) -> Result<Self> {
        let Loaded { scene, prepared, maybe_blender, seconds: load } = loaded;
        let goal = args.goal.goal(start)?;
        let mut settings = args.image_settings(&scene)?;
        settings.spp = goal.map_or(settings.spp, |goal| goal.most);
        args.denoise.prepare(&mut settings)?;
        let mut compute = args.compute_settings(&scene, &settings)?;
        let warnings = scene.warnings_with(settings.camera(&scene));
        warnings.iter().for_each(|warning| notice(format_args!("{warning}")));
        settings.check(scene.limits())?;
        compute.check()?;
        let part = args.part.part(&settings)?;
        let pixels = part.identity.area().pixels();
        let denoising = args.denoise.seconds(pixels, compute.threads);
        let goal = goal.map(|goal| Goal { denoising, ..goal });
        // A film grows with its samples.
        let samples = goal.map_or(part.samples.end, |goal| goal.samples(pixels));
        let samples = part.samples.start..samples;
        compute.check_memory(&scene, Some(FilmOf(&settings, samples.clone())))?;
        let paths = pixels * samples.len() as u64;
        compute.trees =
            args.tree.unwrap_or_else(|| TreeQuality::for_paths(paths, scene.geometry()));
        let output = Target::new(args.output.clone(), args.sample.scene.name(), &part)?;
        check_output(args, &output)?;
        Ok(Self {
            args,
            start,
            scene,
            prepared,
            maybe_blender,
            load,
            settings,
            compute,
            part,
            output,
            goal,
        })
    }

    /// Rejects output files that cannot be written, are the same, or would overwrite input files.
    pub(super) fn check_files(&self, file: &CheckpointFile) -> Result<()> {
        let args = self.args;
        let mut read = files::of_scene(args.sample.scene.name(), &self.scene);
        read.extend(args.plan.as_deref().map(|file| ("the plan", file)));
        let to_file = self.output != Target::StandardOutput;
        let written = [
            ("the image", self.output.path()),
            // If the image goes to standard output, do not reject the render because of an
            // unwritable default checkpoint file.
            ("the checkpoint", Some(file.path()).filter(|_| file.is_named() || to_file)),
            ("the partial image", file.picture()),
            ("the record", args.json.as_deref()),
            ("the timeline", args.trace.as_deref()),
        ];
        let layers = self.output.layer_files(&args.layers);
        let layers = layers.iter().map(|file| ("a layer", Some(file.as_path())));
        let written: Vec<_> = written
            .into_iter()
            .chain(layers)
            .filter_map(|(name, file)| Some((name, file?)))
            .collect();
        files::check(&read, &written)
    }
}

/// Checks that `output` can be what the arguments ask for.
fn check_output(args: &RenderArgs, output: &Target) -> Result<()> {
    if args.transparent {
        output.check_alpha()?;
    }
    if args.denoise.denoise.is_some() && matches!(output, Target::Film(_)) {
        let message = format!(
            "{output}: --denoise is for images: render the film with --layers halves,albedo,normal,depth \
                 --first-hit through, then use `ptfast merge --denoise`"
        );
        return Err(Error::Usage(message));
    }
    if *output == Target::StandardOutput && !args.layers.is_empty() {
        let message = "--layers: standard output gets one picture, use -o FILE.exr";
        return Err(Error::Usage(message.to_owned()));
    }
    if *output == Target::StandardOutput && args.print.is_some() {
        let message = "--print and the image both need standard output: use -o FILE";
        return Err(Error::Usage(message.to_owned()));
    }
    Ok(())
}

impl RenderArgs {
    fn image_settings(&self, scene: &Scene) -> Result<ImageSettings> {
        let of_samples = self.sample.settings(scene)?;
        Ok(ImageSettings {
            spp: self.spp.unwrap_or(of_samples.spp),
            clamp: self.clamp,
            transparent: self.transparent,
            layers: self.layers.clone(),
            first_hit: self.first_hit,
            ..of_samples
        })
    }

    fn compute_settings(&self, scene: &Scene, image: &ImageSettings) -> Result<ComputeSettings> {
        if self.plan.is_some() && self.engine == Engine::Scalar {
            return Err(Error::Usage("--plan is for the wavefront engine".to_owned()));
        }
        let plan = |file| plan_file::read(file, scene, image.camera(scene));
        Ok(ComputeSettings {
            engine: self.engine,
            threads: self.threads.unwrap_or(0),
            pin: self.pin,
            wave_size: self.wave_size.unwrap_or(0),
            plan: self.plan.as_deref().map(plan).transpose()?.into(),
            trees: TreeQuality::default(),
            count: self.stats,
            timeline: self.trace.is_some(),
        })
    }

    pub(super) fn mode(&self) -> ProgressMode {
        if self.quiet { ProgressMode::None } else { self.progress }
    }
}
