//! `ptfast merge`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::display::DisplayArgs;
use super::arguments::limits::LimitArgs;
use super::console::say;
use super::files;
use super::render::target::Target;
use crate::checkpoint::{Checkpoint, PartialRender, merge, merge_partial};
use crate::error::{Error, Result};
use crate::image::Metadata;
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
        _ if args.partial => write_partial(args, &output),
        _ => write_whole(args, &output),
    }
}

fn write_whole(args: &MergeArgs, output: &Target) -> Result<()> {
    let whole = merge(&args.parts, &args.limits.limits())?;
    if let Target::Film(path) = output {
        whole.write(path)?;
    }
    let Checkpoint { scene, identity, rendering, .. } = whole;
    let image = rendering.image()?;
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
    let PartialRender { scene, image, samples, spp } =
        merge_partial(&args.parts, &args.limits.limits())?;
    let metadata = Metadata::of_partial(samples);
    image.write(&args.output, args.display.display(), &metadata)?;
    let (width, height) = (image.width(), image.height());
    let per_pixel = samples as f64 / (f64::from(width) * f64::from(height));
    say(format_args!(
        "scene   {scene}, {width} x {height}, {per_pixel:.1} of {spp} spp on average"
    ))?;
    say(format_args!("file    {output}"))
}
