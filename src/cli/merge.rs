//! `ptfast merge`.

use std::path::PathBuf;

use clap::Args;

use super::limits::LimitArgs;
use super::named::named;
use super::target::Target;
use super::{files, say};
use crate::checkpoint::{Checkpoint, merge};
use crate::error::Result;
use crate::image::Transfer;

#[derive(Debug, Args)]
pub(super) struct MergeArgs {
    /// All parts of one render, in any order: .film files of `ptfast render`
    #[arg(required = true, value_name = "FILE")]
    parts: Vec<PathBuf>,
    /// Image file: .png, .exr, .hdr or .pfm, or .film, which can be continued
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Transfer curve of 8-bit files
    #[arg(long, value_name = "GAMMA", default_value = Transfer::Srgb.name(), value_parser = named(&Transfer::ALL, Transfer::name))]
    gamma: Transfer,
    #[command(flatten)]
    limits: LimitArgs,
}

pub(super) fn run(args: &MergeArgs) -> Result<()> {
    let output = Target::of_path(args.output.clone())?;
    let read: Vec<_> = args.parts.iter().map(|part| ("a part", part.as_path())).collect();
    files::check(&read, &[("the image", output.path())])?;
    let whole = merge(&args.parts, &args.limits.limits())?;
    if let Target::Film(path) = &output {
        whole.write(path)?;
    }
    let Checkpoint { scene, identity, rendering, .. } = whole;
    let tally = &rendering.tally;
    let image = rendering.image()?;
    let hash = image.hash();
    if let Target::Image(path) = &output {
        image.write(path, args.gamma, &identity.metadata(&hash))?;
    }
    say(format_args!(
        "scene   {scene}, {} x {}, {} spp, seed {}, of {} parts",
        identity.width,
        identity.height,
        identity.spp,
        identity.seed,
        args.parts.len()
    ))?;
    say(format_args!("rays    {:.2} M", tally.rays.total() as f64 * 1e-6))?;
    say(format_args!("hash    {hash}"))?;
    say(format_args!("file    {}", output.path().display()))
}
