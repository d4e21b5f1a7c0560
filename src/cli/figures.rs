//! `ptfast figures`: the report's six pictures and a page that shows them.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;

use super::args::FiguresArgs;
use super::progress::{self, Telling};
use super::{advise_on_build, say};
use crate::checkpoint::Identity;
use crate::engine::{Pin, RenderSettings, Renderer};
use crate::error::{Error, Result};
use crate::image::Transfer;
use crate::isa::Isa;
use crate::machine::Machine;
use crate::output::{check_writable, write_atomically};
use crate::scene::{Sampling, Scene};

/// A figure of the report.
struct Figure {
    number: u32,
    scene: &'static str,
    sampling: Sampling,
    spp: u32,
    /// The report's.
    caption: &'static str,
    /// What the report says of its time, on 8 cores of an Apple M1.
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

/// A figure as rendered here.
struct Rendered<'a> {
    figure: &'a Figure,
    settings: RenderSettings,
    file: String,
    seconds: f64,
    rays: u64,
    hash: String,
}

pub(super) fn run(args: &FiguresArgs) -> Result<()> {
    fs::create_dir_all(&args.out).map_err(Error::io(&args.out, "make the folder"))?;
    let page = args.out.join("index.html");
    check_writable(&page)?;
    if !args.quiet {
        advise_on_build(Isa::Avx2);
    }
    let mut rendered = Vec::new();
    for figure in &FIGURES {
        let result = render(figure, args)?;
        say(format_args!(
            "figure {}  {:<9} {:>3} spp  {:<5}  {:>7.2} s  {}",
            figure.number,
            figure.scene,
            result.settings.spp,
            figure.sampling.name(),
            result.seconds,
            args.out.join(&result.file).display()
        ))?;
        rendered.push(result);
    }
    write_atomically(&page, |file| file.write_all(html(&rendered).as_bytes()))?;
    say(format_args!("page      {}", page.display()))
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
    let telling = if args.quiet { Telling::None } else { Telling::Auto };
    let render = progress::render(&renderer, &title, telling)?;
    let hash = render.image.hash();
    let whole = settings.image();
    let file = format!("figure-{}.png", figure.number);
    let path = args.out.join(&file);
    render.image.write(
        &path,
        Transfer::Gamma2,
        &Identity::new(&scene, &settings, whole).metadata(&hash),
    )?;
    let seconds = render.seconds.render;
    Ok(Rendered { figure, settings, file, seconds, rays: render.tally.rays.total(), hash })
}

/// One page without scripts or files from elsewhere; pictures are beside it.
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
<tr><th>settings<td>{width} × {height}, {spp} samples a pixel, <code>--sampling {sampling}</code>
<tr><th>repeat<td><code>ptfast render --scene {scene} --spp {spp} --sampling {sampling} --gamma 2</code>
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
                format!(" for {} samples a pixel", figure.spp)
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
