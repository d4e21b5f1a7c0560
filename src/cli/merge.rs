//! `ptfast merge`.

use std::path::PathBuf;

use clap::Args;

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
    match &output {
        Target::Film(_) if args.partial => Err(Error::Usage(format!(
            "{output}: --partial writes an image: .png, .exr, .hdr or .pfm"
        ))),
        Target::Film(_) if args.layers.is_some() => Err(Error::Usage(format!(
            "{output}: --layers is for images, a film keeps all layers of its parts"
        ))),
        _ if args.partial => write_partial(args, &output),
        _ => write_whole(args, &output),
    }
}

impl MergeArgs {
    /// The image of `film` with the layers that are asked for.
    fn image(&self, identity: &Identity, film: &impl Totals) -> Result<Image> {
        let settings = &identity.settings;
        let layers = self.layers.as_ref().unwrap_or(&settings.layers);
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
        develop(settings, layers, identity.area(), film)
    }
}

fn write_whole(args: &MergeArgs, output: &Target) -> Result<()> {
    let whole = merge(&args.parts, &args.limits.limits())?;
    if let Target::Film(path) = output {
        whole.write(path)?;
    }
    let Checkpoint { scene, identity, rendering, .. } = whole;
    let image = args.image(&identity, &Rows::all(&rendering.film))?;
    let hash = image.hash();
    if let Target::Image(path) = output {
        image.write(path, args.display.display(), &identity.metadata(&hash))?;
    }
    let settings = settings::describe(&identity.settings);
    say(format_args!("scene   {scene}, {settings}, of {} parts", args.parts.len()))?;
    say(format_args!("rays    {:.2} M", rendering.tally.rays.total() as f64 * 1e-6))?;
    say(format_args!("hash    {hash}"))?;
    say(format_args!("file    {output}"))
}

fn write_partial(args: &MergeArgs, output: &Target) -> Result<()> {
    let PartialRender { scene, identity, film } =
        merge_partial(&args.parts, &args.limits.limits())?;
    let (image, samples, spp) =
        (args.image(&identity, &film)?, film.samples(), identity.settings.spp);
    let metadata = Metadata::of_partial(samples);
    image.write(&args.output, args.display.display(), &metadata)?;
    let (width, height) = (image.width(), image.height());
    let per_pixel = samples as f64 / (f64::from(width) * f64::from(height));
    say(format_args!(
        "scene   {scene}, {width} x {height}, {per_pixel:.1} of {spp} spp on average"
    ))?;
    say(format_args!("file    {output}"))
}
