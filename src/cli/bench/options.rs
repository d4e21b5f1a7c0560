//! The measurements that the arguments of `ptfast bench` ask for.

use std::path::{Path, PathBuf};

use super::args::BenchArgs;
use crate::cli::files;
use crate::engine::{Engine, ImageSettings};
use crate::error::{Error, Result, suggestion};
use crate::formats::BUILTIN_NAMES;
use crate::limits::Limit;
use crate::measure::bench::{Format, Options};

/// Default values of arguments.
struct Usual {
    /// Approximate number of pixels of an image.
    pixels: u32,
    blocks: u32,
}
const USUAL: Usual = Usual { pixels: 640 * 360, blocks: 12 };
const QUICK: Usual = Usual { pixels: 320 * 180, blocks: 6 };

/// Number of blocks.
pub(crate) fn blocks(args: &BenchArgs) -> usize {
    args.blocks.unwrap_or(usual(args).blocks) as usize
}

fn usual(args: &BenchArgs) -> Usual {
    if args.quick { QUICK } else { USUAL }
}

/// The generated scenes that are measured by default, because real scenes consist of triangles and
/// instances.
const GENERATED: [&str; 2] = ["mesh:100000", "forest:10000"];

/// The options of the bench, and the files that its scenes were read from.
///
/// # Errors
/// If arguments contradict each other, or a scene cannot be read.
pub(crate) fn options(args: &BenchArgs) -> Result<(Options, Vec<PathBuf>)> {
    if args.gate && args.baseline.is_none() && args.against.is_none() {
        return Err(Error::Usage(
            "--gate needs --baseline or --against to compare with".to_owned(),
        ));
    }
    if !(args.threshold > 0.0 && args.threshold < 100.0) {
        let message = format!("--threshold must be between 0 and 100, not {}", args.threshold);
        return Err(Error::Usage(message));
    }
    let scenes: Vec<String> = match &args.scenes[..] {
        [] => BUILTIN_NAMES.into_iter().chain(GENERATED).map(str::to_owned).collect(),
        some => without_repeats(some),
    };
    let mut read = Vec::new();
    let with_size = |name: String| {
        if name == "-" {
            let message = "--scene -: bench reads each scene several times, so it needs a file";
            return Err(Error::Usage(message.to_owned()));
        }
        let scene = args.limits.load(&name)?;
        read.extend(files::of_scene(&name, &scene).into_iter().map(|(_, file)| file.to_owned()));
        let defaults = ImageSettings::of(&scene);
        let proportion = f64::from(defaults.width) / f64::from(defaults.height);
        let usual = (f64::from(usual(args).pixels) * proportion).sqrt().round().max(1.0) as u32;
        let settings = defaults.with_size(args.width.or(Some(usual)), None);
        let settings = ImageSettings { spp: args.spp, ..settings };
        let (pixels, most) = (settings.image().pixels(), scene.limits().get(Limit::Pixels));
        if pixels > most {
            let message = format!("an image of {pixels} pixels exceeds the limit of {most}");
            return Err(Error::Usage(message));
        }
        settings.check(scene.limits())?;
        Ok((name, (settings.width, settings.height)))
    };
    let engines = match &args.engines[..] {
        // The scalar engine comes first, because the others are compared with it.
        [] => vec![Engine::Scalar, Engine::Wavefront],
        some => without_repeats(some),
    };
    let threads = match &args.threads[..] {
        [] => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            without_repeats(&[1, cores])
        }
        some => without_repeats(some).into_iter().map(|threads| threads as usize).collect(),
    };
    let this = || std::env::current_exe().map_err(Error::io(Path::new("ptfast"), "find"));
    let options = Options {
        program: args.program.clone().map_or_else(this, Ok)?,
        against: args.against.clone(),
        scenes: scenes.into_iter().map(with_size).collect::<Result<_>>()?,
        engines,
        threads,
        spp: args.spp,
        seed: args.seed,
        arguments: args.limits.arguments(),
    };
    Ok((options, read))
}

fn without_repeats<T: Clone + PartialEq>(values: &[T]) -> Vec<T> {
    let mut unique = Vec::new();
    for value in values {
        if !unique.contains(value) {
            unique.push(value.clone());
        }
    }
    unique
}

/// The formats and folders of the exports.
///
/// # Errors
/// If a format is unknown.
pub(crate) fn exports(args: &BenchArgs) -> Result<Vec<(Format, PathBuf)>> {
    let pair = |pair: &[String]| {
        let format = Format::ALL.into_iter().find(|format| format.name() == pair[0]);
        let format = format.ok_or_else(|| {
            let hint = suggestion(&pair[0], Format::ALL.map(Format::name));
            Error::Usage(format!("--export: unknown format `{}`{hint}", pair[0]))
        })?;
        Ok((format, PathBuf::from(&pair[1])))
    };
    args.export.chunks_exact(2).map(pair).collect()
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        bench: BenchArgs,
    }

    fn parse(arguments: &[&str]) -> BenchArgs {
        Command::parse_from([&["bench"], arguments].concat()).bench
    }

    #[test]
    fn defaults_cover_all_scenes_and_engines() {
        let args = parse(&[]);
        let (options, _) = options(&args).unwrap();
        let names: Vec<&str> = options.scenes.iter().map(|(name, _)| &**name).collect();
        assert_eq!(
            names,
            ["spheres", "spacetime", "checker", "cornell", "garden", "mesh:100000", "forest:10000"]
        );
        // The scenes have the proportions of 1280 x 720 and of 1 x 1.
        assert_eq!(options.scenes[0].1, (640, 360));
        assert_eq!(options.scenes[3].1, (480, 480));
        assert_eq!(options.engines, [Engine::Scalar, Engine::Wavefront]);
        assert_eq!(options.threads[0], 1);
        let cores = std::thread::available_parallelism().unwrap().get();
        assert_eq!(options.threads.last(), Some(&cores));
        assert_eq!((options.spp, options.seed, blocks(&args)), (16, 1, 12));
        assert_eq!(options.runs().len(), 14 * options.threads.len());
    }

    #[test]
    fn repeated_arguments_count_once() {
        let args = parse(&[
            "--quick",
            "--scene",
            "cornell",
            "--scene",
            "cornell",
            "--engine",
            "wavefront",
            "--threads",
            "3",
            "--threads",
            "1",
            "--threads",
            "3",
        ]);
        let (options, _) = options(&args).unwrap();
        assert_eq!(options.scenes, [("cornell".to_owned(), (240, 240))]);
        assert_eq!(
            options.runs(),
            [("cornell", Engine::Wavefront, 3), ("cornell", Engine::Wavefront, 1)]
        );
        assert_eq!(blocks(&args), 6);
        let wide = parse(&["--scene", "spheres", "--width", "160", "--blocks", "9"]);
        let (wide_options, _) = self::options(&wide).unwrap();
        assert_eq!(wide_options.scenes[0].1, (160, 90));
        assert!(wide_options.arguments.is_empty());
        assert_eq!(blocks(&wide), 9);
    }
}
