//! `ptfast figures`: the six figures of the report, and a page that shows them.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::console::{advise_on_build, say, suppress_notices};
use super::progress::ProgressMode;
use super::{folder, progress};
use crate::engine::Layers;
use crate::error::{Error, Result};
use crate::image::{Metadata, layer_path};
use crate::isa::Isa;
use crate::limits::MAX_THREADS;
use crate::measure::figures::{self, FIGURE, FIGURES};
use crate::output::{check_writable, write_atomically};
use crate::scene::Scene;

#[derive(Debug, Args)]
pub(crate) struct FiguresArgs {
    /// Folder for the six pictures and index.html; created if missing
    #[arg(short, long, visible_alias = "out", value_name = "DIR")]
    output: PathBuf,
    /// Use a tenth of the report's samples per pixel
    #[arg(long)]
    quick: bool,
    /// Also write these layers, as in `ptfast render`, beside each picture
    #[arg(long, value_name = "LIST", default_value = "color", hide_default_value = true)]
    layers: Layers,
    /// Worker threads [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    threads: Option<u32>,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

const PAGE: &str = "index.html";

pub(crate) fn run(args: &FiguresArgs) -> Result<()> {
    if args.quiet {
        suppress_notices();
    }
    let pictures = FIGURES.iter().map(|figure| args.output.join(figure.file()));
    let pictures = pictures.flat_map(|picture| {
        // The layers beside an earlier picture are ours as well.
        let layers = args.layers.iter().filter(|_| !picture.exists());
        let layers = layers.map(|layer| layer_path(&picture, layer.name()));
        layers.chain([picture.clone()]).collect::<Vec<_>>()
    });
    let files: Vec<PathBuf> = pictures.chain([args.output.join(PAGE)]).collect();
    folder::check_unrelated(&files, is_figure)?;
    fs::create_dir_all(&args.output).map_err(Error::io(&args.output, "create the folder"))?;
    let page = args.output.join(PAGE);
    check_writable(&page)?;
    advise_on_build(Isa::Avx2);
    let mode = if args.quiet { ProgressMode::None } else { ProgressMode::Auto };
    let mut rendered = Vec::new();
    for figure in &FIGURES {
        let scene = Scene::load(figure.scene)?;
        let spp = if args.quick { (figure.spp / 10).max(1) } else { figure.spp };
        let size = (spp, args.threads.unwrap_or(0));
        let result =
            figures::render(figure, &scene, size, &args.layers, &args.output, |session| {
                progress::render(session, &format!("figure {}", figure.number), mode)
            })?;
        if args.quiet {
            rendered.push(result);
            continue;
        }
        say(format_args!(
            "figure {}  {:<9} {:>3} spp  {:<5}  {:>7.2} s  {}",
            figure.number,
            figure.scene,
            spp,
            figure.sampling.name(),
            result.seconds,
            args.output.join(figure.file()).display()
        ))?;
        rendered.push(result);
    }
    write_atomically(&page, |file| {
        file.write_all(figures::html(&rendered, args.threads.unwrap_or(0)).as_bytes())
    })?;
    if args.quiet { Ok(()) } else { say(format_args!("page      {}", page.display())) }
}

/// Whether `figures` wrote this file. Pictures are recognised by their metadata, and the page by
/// its title.
fn is_figure(file: &Path) -> bool {
    if file.ends_with(PAGE) {
        return folder::contains(file, "<title>The report's figures by ptfast</title>");
    }
    Metadata::read(file).is_ok_and(|metadata| metadata.get(FIGURE).is_some())
}
