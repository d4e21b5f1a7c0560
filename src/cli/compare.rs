//! `ptfast compare`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{LimitArgs, named};
use super::console::say;
use super::files;
use crate::error::Result;
use crate::image::{Format, Image, Metadata, Transfer, compare};

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// First image
    a: PathBuf,
    /// Second image, the reference for relative errors
    b: PathBuf,
    /// Compare display values: clamped to [0, 1], then through this transfer curve [default: linear values]
    #[arg(long, value_name = "GAMMA", value_parser = named(&Transfer::ALL, Transfer::name))]
    display: Option<Transfer>,
    /// Write a false-colour image of the differences
    #[arg(
        short = 'o',
        long = "output",
        alias = "out",
        visible_alias = "heatmap",
        value_name = "FILE"
    )]
    heatmap: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// Returns exit code 0 if the images are identical, else 1.
pub(crate) fn run(args: &CompareArgs) -> Result<u8> {
    if let Some(path) = &args.heatmap {
        Format::of_path(path)?;
        let read =
            [("an image that is compared", &*args.a), ("an image that is compared", &*args.b)];
        files::check(&read, &[("the heatmap", path)])?;
    }
    let limits = args.limits.limits();
    let allow = |pixels: u64, memory: u64| limits.check_image(pixels, memory);
    let read = |path| Image::read_where(path, &allow);
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    if (a.width(), a.height()) != (b.width(), b.height()) {
        say(format_args!(
            "identical        no: {} x {} and {} x {} pixels",
            a.width(),
            a.height(),
            b.width(),
            b.height()
        ))?;
        return Ok(1);
    }
    let (c, heatmap) = compare(&a, &b, args.display)?;
    if let Some(path) = &args.heatmap {
        heatmap.write(path, Transfer::Srgb, &Metadata::default())?;
    }
    let scale = match args.display {
        None => "linear",
        Some(Transfer::Srgb) => "as displayed, sRGB",
        Some(Transfer::Gamma2) => "as displayed, gamma 2",
    };
    let (x, y) = c.largest_at;
    say(format_args!("identical        {}", if c.identical { "yes" } else { "no" }))?;
    say(format_args!("values           {scale}"))?;
    say(format_args!("mse              {:.6e}", c.mse))?;
    say(format_args!("relative mse     {:.6e}", c.relative_mse))?;
    say(format_args!("psnr             {:.2} dB", c.psnr))?;
    say(format_args!("largest          {:.6e} at pixel ({x}, {y})", c.largest))?;
    say(format_args!("ratio of means   {:.6}", c.ratio_of_means))?;
    Ok(u8::from(!c.identical))
}
