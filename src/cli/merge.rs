//! `ptfast merge`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::denoise::{DenoiseArgs, Denoised};
use super::arguments::display::DisplayArgs;
use super::arguments::limits::LimitArgs;
use super::console::say;
use super::files;
use super::render::target::Target;
use crate::checkpoint::{Checkpoint, Identity, PartialRender, merge, merge_partial};
use crate::engine::{Layers, Rows, Totals, develop};
use crate::error::{Error, Result};
use crate::image::{Image, Metadata};
use crate::measure::settings;

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// All parts of one render, in any order: .film files of `ptfast render`
    #[arg(required = true, value_name = "FILE")]
    parts: Vec<PathBuf>,
    /// Output file: an image (.png, .exr, .hdr, .pfm), or a .film that can be continued
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    /// Write the picture of the samples that are finished so far, even if parts are unfinished or
    /// missing
    #[arg(long)]
    partial: bool,
    /// Layers to write to the image besides color [default: all that the parts have]
    #[arg(long, value_name = "LIST")]
    layers: Option<Layers>,
    #[command(flatten)]
    denoise: DenoiseArgs,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    limits: LimitArgs,
}

pub(crate) fn run(args: &MergeArgs) -> Result<()> {
    let output = Target::of_path(args.output.clone())?;
    let Some(file) = output.path() else {
        return Err(Error::Usage("-o -: merge writes to files only".to_owned()));
    };
    let read: Vec<_> = args.parts.iter().map(|part| ("a part", part.as_path())).collect();
    files::check(&read, &[("the image", file)])?;
    args.denoise.check()?;
    match &output {
        Target::Film(_) if args.partial => Err(Error::Usage(format!(
            "{output}: --partial writes an image: .png, .exr, .hdr or .pfm"
        ))),
        Target::Film(_) if args.denoise.denoise.is_some() => Err(Error::Usage(format!(
            "{output}: --denoise is for images, a film keeps the samples"
        ))),
        Target::Film(_) if args.layers.is_some() => Err(Error::Usage(format!(
            "{output}: --layers is for images, a film keeps all layers of its parts"
        ))),
        _ if args.partial => write_partial(args, &output),
        _ => write_whole(args, &output),
    }
}

impl MergeArgs {
    /// The image of `film` with the layers that are asked for, its hash, and how it was denoised.
    fn image(
        &self,
        identity: &Identity,
        film: &impl Totals,
        output: &Target,
    ) -> Result<(Image, String, Option<Denoised>)> {
        let settings = &identity.settings;
        let asked = self.layers.as_ref().unwrap_or(&settings.layers);
        let needed = self.denoise.layers(settings)?;
        let layers = &Layers::new(asked.iter().chain(needed.iter()));
        if let Some(lacking) =
            layers.iter().find(|layer| !settings.stored_layers().contains(*layer))
        {
            let message = format!(
                "--layers {}: the parts lack this layer, render them with --layers {}",
                lacking.name(),
                lacking.name()
            );
            return Err(Error::Usage(message));
        }
        let mut image = develop(settings, layers, identity.area(), film)?;
        let hash = image.hash();
        let denoised = self.denoise.apply(&mut image, 0, asked, output.is_exr())?;
        Ok((image, hash, denoised))
    }
}

fn write_whole(args: &MergeArgs, output: &Target) -> Result<()> {
    let whole = merge(&args.parts, &args.limits.limits())?;
    if let Target::Film(path) = output {
        whole.write(path)?;
    }
    let Checkpoint { scene, identity, rendering, .. } = whole;
    let (image, hash, denoised) = args.image(&identity, &Rows::all(&rendering.film), output)?;
    if let Target::Image(path) = output {
        let metadata = Denoised::noted(denoised.as_ref(), identity.metadata(&hash));
        image.write(path, args.display.display(), &metadata)?;
    }
    let settings = settings::describe(&identity.settings);
    say(format_args!("scene   {scene}, {settings}, of {} parts", args.parts.len()))?;
    say(format_args!("rays    {:.2} M", rendering.tally.rays.total() as f64 * 1e-6))?;
    say(format_args!("hash    {hash}"))?;
    if let Some(Denoised { hash: Some(hash), .. }) = &denoised {
        say(format_args!("denoised {hash}"))?;
    }
    say(format_args!("file    {output}"))
}

fn write_partial(args: &MergeArgs, output: &Target) -> Result<()> {
    let PartialRender { scene, identity, film } =
        merge_partial(&args.parts, &args.limits.limits())?;
    let (samples, spp) = (film.samples(), identity.settings.spp);
    let (image, _, denoised) = args.image(&identity, &film, output)?;
    let metadata = Denoised::noted(denoised.as_ref(), Metadata::of_partial(samples));
    image.write(&args.output, args.display.display(), &metadata)?;
    let (width, height) = (image.width(), image.height());
    let per_pixel = samples as f64 / (f64::from(width) * f64::from(height));
    say(format_args!(
        "scene   {scene}, {width} x {height}, {per_pixel:.1} of {spp} spp on average"
    ))?;
    say(format_args!("file    {output}"))
}
