//! `ptfast denoise`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::denoise::{DenoiseArgs, Denoised, layers_of};
use super::arguments::{DisplayArgs, LimitArgs, named};
use super::console::{notice, say};
use super::files;
use super::render::target::Target;
use crate::denoise::Denoise;
use crate::engine::Layers;
use crate::error::{Error, Result};
use crate::image::{Channels, Image, ImageLayer, Metadata, other_channels, split_layer};

/// The layers that denoising knows, what Blender calls them, and the names of their channels.
const LAYERS: [(&str, Option<&str>, &[&str]); 9] = [
    ("noisy", Some("Noisy Image"), &["R", "G", "B"]),
    ("color_even", None, &["R", "G", "B"]),
    ("color_odd", None, &["R", "G", "B"]),
    ("albedo", Some("Denoising Albedo"), &["R", "G", "B"]),
    ("albedo_even", None, &["R", "G", "B"]),
    ("normal", Some("Denoising Normal"), &["X", "Y", "Z"]),
    ("normal_even", None, &["X", "Y", "Z"]),
    ("depth", Some("Denoising Depth"), &["Z"]),
    ("depth_even", None, &["Z"]),
];

#[derive(Debug, Args)]
pub(crate) struct DenoiseCommand {
    /// Image to denoise: an .exr with layers of `ptfast render --layers` or of Blender, or any other image. Alpha is
    /// dropped
    image: PathBuf,
    /// Output file (.png, .exr, .hdr, .pfm). An .exr keeps the noisy picture as the layer `noisy`
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    /// Quality: good needs the layers color_even and color_odd, oidn an installed Open Image Denoise 2 [default: good
    /// if it can be, else fast]
    #[arg(long, value_name = "QUALITY", value_parser = named(&Denoise::ALL, Denoise::name))]
    quality: Option<Denoise>,
    /// Threads. The image does not depend on them [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    limits: LimitArgs,
}

pub(crate) fn run(args: &DenoiseCommand) -> Result<()> {
    let output = Target::of_path(args.output.clone())?;
    let (Target::Image(path), input) = (&output, args.image.as_path()) else {
        return Err(Error::Usage(format!("{output}: denoise writes images to files")));
    };
    let file = input.to_str().map_or(input, |input| Path::new(split_layer(input).0));
    files::check(&[("the noisy image", file)], &[("the image", path)])?;
    if let Some(quality) = args.quality {
        quality.library()?;
    }
    let limits = args.limits.limits();
    let allow = |pixels: u64, memory: u64| limits.check_image(pixels, memory);
    let image = Image::read_where(input, &allow)?;
    let mut image = with_layers(image, &other_channels(input, &allow)?);
    let has_halves = ["color_even", "color_odd"].iter().all(|name| image.layer(name).is_some());
    let best = if has_halves { Denoise::Good } else { Denoise::Fast };
    let quality = args.quality.unwrap_or(best);
    // Open Image Denoise needs no halves.
    let used = layers_of(quality).iter().filter(|l| quality != Denoise::Oidn || !l.is_half());
    let names = used.map(|layer| layer.name());
    let lacking: Vec<&str> = names.filter(|name| image.layer(name).is_none()).collect();
    if !lacking.is_empty() {
        notice(format_args!(
            "{}: lacks the layers {}, with which the picture would be better",
            input.display(),
            lacking.join(", ")
        ));
    }
    let denoise = DenoiseArgs { denoise: Some(quality) };
    let threads = args.threads.unwrap_or(0);
    let denoised = denoise.apply(&mut image, threads, &Layers::default(), output.is_exr());
    let Some(denoised) = denoised.map_err(|error| in_file(input, error))? else { return Ok(()) };
    let metadata = Denoised::noted(Some(&denoised), Metadata::of_program());
    image.write(path, args.display.display(), &metadata)?;
    say(format_args!("time    {:.2} s", denoised.seconds))?;
    if let Some(hash) = &denoised.hash {
        say(format_args!("denoised {hash}"))?;
    }
    say(format_args!("file    {output}"))
}

/// `error` of the file `path`, if it is its fault.
fn in_file(path: &Path, error: Error) -> Error {
    match error {
        Error::Usage(message) => Error::Usage(format!("{}: {message}", path.display())),
        error => error,
    }
}

/// The image with those of the `channels` that denoising knows as layers. If it was denoised before, its colour is what
/// it was before that.
fn with_layers(mut image: Image, channels: &Channels) -> Image {
    let pixels = image.pixels().len();
    let mut layers = Vec::new();
    for (name, of_blender, letters) in LAYERS {
        let is_it = |layer: &&str| {
            let own = layer.rsplit('.').next().unwrap_or(layer);
            own == name || Some(own) == of_blender
        };
        // All channels must be of one layer.
        let found =
            channels.keys().filter_map(|full| full.rsplit_once('.').map(|(layer, _)| layer));
        let planes = found.filter(is_it).find_map(|layer| -> Option<Vec<&Vec<f32>>> {
            let channel = |letter: &&str| channels.get(&format!("{layer}.{letter}"));
            letters.iter().map(channel).map(|plane| plane.filter(|p| p.len() == pixels)).collect()
        });
        let Some(planes) = planes else { continue };
        let values = (0..pixels).map(|pixel| {
            let mut value = [0.0; 3];
            value.iter_mut().zip(&planes).for_each(|(value, plane)| *value = plane[pixel]);
            value
        });
        layers.push(ImageLayer {
            name,
            channels: letters,
            numbers: false,
            values: values.collect(),
        });
    }
    if let Some(noisy) = layers.iter().position(|layer| layer.name == "noisy") {
        image = Image::from_pixels(image.width(), image.height(), layers.remove(noisy).values);
    }
    image.with_layers(layers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_of_ptfast_and_of_blender_are_found() {
        let channels = |names: &[&str]| -> Channels {
            names.iter().enumerate().map(|(k, name)| ((*name).to_owned(), vec![k as f32])).collect()
        };
        let image = || Image::from_pixels(1, 1, vec![[9.0; 3]]);
        let own = channels(&["albedo.R", "albedo.G", "albedo.B", "depth.Z", "uv.U", "normal.X"]);
        let found = with_layers(image(), &own);
        assert_eq!(found.layer("albedo").unwrap().values(), [[0.0, 1.0, 2.0]]);
        assert_eq!(found.layer("depth").unwrap().values(), [[3.0, 0.0, 0.0]]);
        // A layer without all its channels, or of several layers, is none.
        assert_eq!(found.layers().len(), 2);
        let mixed = channels(&["a.albedo.R", "a.albedo.G", "b.albedo.B", ".R", ".G", ".B"]);
        assert!(with_layers(image(), &mixed).layers().is_empty());
        let of_blender = channels(&[
            "View Layer.Denoising Normal.X",
            "View Layer.Denoising Normal.Y",
            "View Layer.Denoising Normal.Z",
            "View Layer.Noisy Image.R",
            "View Layer.Noisy Image.G",
            "View Layer.Noisy Image.B",
        ]);
        let found = with_layers(image(), &of_blender);
        assert_eq!(found.layer("normal").unwrap().values(), [[0.0, 1.0, 2.0]]);
        assert_eq!(found.pixels(), [[3.0, 4.0, 5.0]]);
    }
}
