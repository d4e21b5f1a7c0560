//! `ptfast figures`: the six figures of the report, and a page that shows them.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::console::{advise_on_build, say, suppress_notices};
use super::progress::ProgressMode;
use super::{folder, progress};
use crate::checkpoint::Identity;
use crate::engine::{Pin, RenderSettings, Renderer};
use crate::error::{Error, Result};
use crate::image::{Metadata, Transfer};
use crate::isa::Isa;
use crate::limits::MAX_THREADS;
use crate::machine::Machine;
use crate::output::{check_writable, write_atomically};
use crate::scene::{Sampling, Scene};

/// A figure of the report.
struct Figure {
    number: u32,
    scene: &'static str,
    sampling: Sampling,
    spp: u32,
    /// The caption in the report.
    caption: &'static str,
    /// The time in the report, on 8 cores of an Apple M1.
    report_time: &'static str,
}

const FIGURES: [Figure; 6] = [
    Figure {
        number: 1,
        scene: "spheres",
        sampling: Sampling::Bsdf,
        spp: 100,
        caption: "Path traced scene with diffuse, metallic and glass spheres",
        report_time: "about 3 minutes",
    },
    Figure {
        number: 2,
        scene: "spacetime",
        sampling: Sampling::Bsdf,
        spp: 100,
        caption: "Space-Time path traced scene with bouncing diffuse and stationary metallic and glass spheres",
        report_time: "about 5 minutes",
    },
    Figure {
        number: 3,
        scene: "checker",
        sampling: Sampling::Bsdf,
        spp: 100,
        caption: "Path traced scene with checker textured diffuse spheres and a spherical light source",
        report_time: "about 1.5 minutes",
    },
    Figure {
        number: 4,
        scene: "cornell",
        sampling: Sampling::Bsdf,
        spp: 200,
        caption: "Path traced scene similar to Cornell Box, Lambertian materials with Cosine Distribution",
        report_time: "not given",
    },
    Figure {
        number: 5,
        scene: "cornell",
        sampling: Sampling::Light,
        spp: 10,
        caption: "Path traced scene similar to Cornell Box, Importance sampling for the light source",
        report_time: "not given",
    },
    Figure {
        number: 6,
        scene: "cornell",
        sampling: Sampling::Light,
        spp: 200,
        caption: "Path traced scene similar to Cornell Box, Importance sampling for the light source",
        report_time: "not given",
    },
];

/// A figure that was rendered.
struct Rendered<'a> {
    figure: &'a Figure,
    settings: RenderSettings,
    file: String,
    seconds: f64,
    rays: u64,
    hash: String,
}

#[derive(Debug, Args)]
pub(super) struct FiguresArgs {
    /// Folder for the six pictures and index.html; created if missing
    #[arg(short, long, visible_alias = "out", value_name = "DIR")]
    output: PathBuf,
    /// Use a tenth of the report's samples per pixel
    #[arg(long)]
    quick: bool,
    /// Worker threads [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    threads: Option<u32>,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

const PAGE: &str = "index.html";
/// The key of the figure's number in the metadata of its picture.
const FIGURE: &str = "ptfast:figure";

pub(super) fn run(args: &FiguresArgs) -> Result<()> {
    if args.quiet {
        suppress_notices();
    }
    let pictures = FIGURES.iter().map(|figure| args.output.join(figure.file()));
    let files: Vec<PathBuf> = pictures.chain([args.output.join(PAGE)]).collect();
    folder::check_unrelated(&files, is_figure)?;
    fs::create_dir_all(&args.output).map_err(Error::io(&args.output, "create the folder"))?;
    let page = args.output.join(PAGE);
    check_writable(&page)?;
    advise_on_build(Isa::Avx2);
    let mut rendered = Vec::new();
    for figure in &FIGURES {
        let result = render(figure, args)?;
        if args.quiet {
            rendered.push(result);
            continue;
        }
        say(format_args!(
            "figure {}  {:<9} {:>3} spp  {:<5}  {:>7.2} s  {}",
            figure.number,
            figure.scene,
            result.settings.spp,
            figure.sampling.name(),
            result.seconds,
            args.output.join(figure.file()).display()
        ))?;
        rendered.push(result);
    }
    write_atomically(&page, |file| file.write_all(html(&rendered).as_bytes()))?;
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

impl Figure {
    fn file(&self) -> String {
        format!("figure-{}.png", self.number)
    }
}

fn render<'a>(figure: &'a Figure, args: &FiguresArgs) -> Result<Rendered<'a>> {
    let scene = Scene::load(figure.scene)?;
    let spp = if args.quick { (figure.spp / 10).max(1) } else { figure.spp };
    let settings = RenderSettings {
        spp,
        sampling: figure.sampling,
        threads: args.threads.unwrap_or(0),
        pin: Pin::Auto,
        ..RenderSettings::of(&scene)
    };
    let renderer = Renderer::new(&scene, settings.clone())?;
    let title = format!("figure {}", figure.number);
    let mode = if args.quiet { ProgressMode::None } else { ProgressMode::Auto };
    let render = progress::render(&renderer, &title, mode)?;
    let hash = render.image.hash();
    let whole = settings.image();
    let file = figure.file();
    let path = args.output.join(&file);
    render.image.write(
        &path,
        Transfer::Gamma2,
        &Identity::new(&scene, &settings, whole).metadata(&hash).with(FIGURE, figure.number),
    )?;
    let seconds = render.seconds.render;
    Ok(Rendered { figure, settings, file, seconds, rays: render.tally.rays.total(), hash })
}

/// A page without scripts or files from other sites. The pictures are beside it.
fn html(rendered: &[Rendered<'_>]) -> String {
    let machine = Machine::this();
    let threads = rendered.first().map_or(0, |r| r.settings.threads);
    let threads = if threads == 0 { machine.cores } else { threads as usize };
    let mut figures = String::new();
    for Rendered { figure, settings, file, seconds, rays, hash } in rendered {
        let RenderSettings { width, height, spp, .. } = settings;
        // Writing to a string cannot fail.
        let _ = write!(
            figures,
            r#"<figure id="figure-{n}">
<a href="{file}"><img src="{file}" width="{width}" height="{height}" alt="{caption}"></a>
<figcaption>
<b>Figure {n}.</b> {caption} ({spp} sample rays per pixel).
<table>
<tr><th>here<td>{seconds:.2} s, {msamples:.2} Msamples/s, {mrays:.2} Mrays/s
<tr><th>report<td>{report}{report_note}
<tr><th>settings<td>{width} × {height}, {spp} samples per pixel, <code>--sampling {sampling}</code>
<tr><th>repeat<td><code>ptfast render {scene} --spp {spp} --sampling {sampling} --gamma 2</code>
<tr><th>hash<td><code>{hash}</code>
</table>
</figcaption>
</figure>
"#,
            n = figure.number,
            caption = figure.caption,
            msamples = settings.paths() as f64 / seconds * 1e-6,
            mrays = *rays as f64 / seconds * 1e-6,
            report = figure.report_time,
            report_note = if figure.spp == *spp {
                String::new()
            } else {
                format!(" for {} samples per pixel", figure.spp)
            },
            scene = figure.scene,
            sampling = figure.sampling.name(),
        );
    }
    format!(
        include_str!("figures.html"),
        cpu = machine.cpu,
        isa = machine.isa,
        threads = threads,
        figures = figures,
        version = env!("CARGO_PKG_VERSION"),
    )
}
