//! `ptfast compare`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::{LimitArgs, named};
use super::console::say;
use super::files;
use crate::error::Result;
use crate::image::{
    Channels, Format, Image, Metadata, Transfer, compare, other_channels, split_layer,
};

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// First image; FILE.exr:LAYER is a layer of it
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

/// Returns exit code 0 if the images and all their layers are identical, else 1.
pub(crate) fn run(args: &CompareArgs) -> Result<u8> {
    if let Some(path) = &args.heatmap {
        Format::of_path(path)?;
        let file = |path: &'_ Path| {
            let own = path.to_str().map(|path| split_layer(path).0);
            own.map_or(path.to_owned(), PathBuf::from)
        };
        let (a, b) = (file(&args.a), file(&args.b));
        let read = [("an image that is compared", &*a), ("an image that is compared", &*b)];
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
    let others = |path| other_channels(path, &allow);
    let layers = layers(others(&args.a)?, others(&args.b)?, a.width());
    say(format_args!("identical        {}", if c.identical { "yes" } else { "no" }))?;
    say(format_args!("values           {scale}"))?;
    say(format_args!("mse              {:.6e}", c.mse))?;
    say(format_args!("relative mse     {:.6e}", c.relative_mse))?;
    say(format_args!("psnr             {:.2} dB", c.psnr))?;
    say(format_args!("largest          {:.6e} at pixel ({x}, {y})", c.largest))?;
    say(format_args!("ratio of means   {:.6}", c.ratio_of_means))?;
    for (name, difference) in &layers {
        let difference = difference.as_deref().unwrap_or("identical");
        say(format_args!("{:<16} {difference}", format!("layer {name}")))?;
    }
    Ok(u8::from(!c.identical || layers.values().any(Option::is_some)))
}

/// How each layer differs in two images of width `width`; `None` if it does not. The name of a layer is that of its
/// channels up to the last dot.
fn layers(a: Channels, mut b: Channels, width: u32) -> BTreeMap<String, Option<String>> {
    let mut largest = BTreeMap::<String, Option<(f64, usize)>>::new();
    let mut alone = BTreeMap::new();
    let layer =
        |channel: &str| channel.rsplit_once('.').map_or(channel, |(layer, _)| layer).to_owned();
    for (channel, a) in a {
        let Some(b) = b.remove(&channel) else {
            alone.insert(layer(&channel), Some("only in the first image".to_owned()));
            continue;
        };
        if a.len() != b.len() {
            alone.insert(layer(&channel), Some("of different size".to_owned()));
            continue;
        }
        let most = largest.entry(layer(&channel)).or_default();
        for (pixel, (a, b)) in
            a.into_iter().zip(b).enumerate().filter(|(_, (a, b))| a.to_bits() != b.to_bits())
        {
            let difference = (f64::from(a) - f64::from(b)).abs();
            if most.is_none_or(|(most, _)| difference > most) {
                *most = Some((difference, pixel));
            }
        }
    }
    alone.extend(
        b.keys().map(|channel| (layer(channel), Some("only in the second image".to_owned()))),
    );
    let shared = largest.into_iter().map(|(name, most)| {
        let place = |pixel: usize| (pixel % width as usize, pixel / width as usize);
        let differs =
            |(most, pixel)| format!("differs, most by {most:.6e} at pixel {:?}", place(pixel));
        (name, most.map(differs))
    });
    shared.chain(alone).collect()
}
