//! The six figures of the report, and a page that shows them.

use std::fmt::Write as _;
use std::path::Path;

use super::machine::Machine;
use crate::checkpoint::Identity;
use crate::engine::{ComputeSettings, ImageSettings, Layers, Pin, Render, Session};
use crate::error::Result;
use crate::image::Transfer;
use crate::scene::{Sampling, Scene};

/// A figure of the report.
pub(crate) struct Figure {
    pub(crate) number: u32,
    pub(crate) scene: &'static str,
    pub(crate) sampling: Sampling,
    pub(crate) spp: u32,
    /// The caption in the report.
    caption: &'static str,
    /// The time in the report, on 8 cores of an Apple M1.
    report_time: &'static str,
}

pub(crate) const FIGURES: [Figure; 6] = [
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
pub(crate) struct Rendered<'a> {
    figure: &'a Figure,
    settings: ImageSettings,
    file: String,
    pub(crate) seconds: f64,
    rays: u64,
    hash: String,
}

/// The key of the figure's number in the metadata of its picture.
pub(crate) const FIGURE: &str = "ptfast:figure";

impl Figure {
    /// The name of its picture.
    pub(crate) fn file(&self) -> String {
        format!("figure-{}.png", self.number)
    }
}

/// Renders `figure` of `scene` with `spp` samples per pixel, and writes its picture and its layers to `folder`. `render`
/// runs the session.
///
/// # Errors
/// If the render fails, or the picture cannot be written.
pub(crate) fn render<'a>(
    figure: &'a Figure,
    scene: &Scene,
    (spp, threads): (u32, u32),
    layers: &Layers,
    folder: &Path,
    render: impl FnOnce(&Session) -> Result<Render>,
) -> Result<Rendered<'a>> {
    let (sampling, layers) = (figure.sampling, layers.clone());
    let settings = ImageSettings { spp, sampling, layers, ..ImageSettings::of(scene) };
    let compute = ComputeSettings { threads, pin: Pin::Auto, ..ComputeSettings::default() };
    let render = render(&Session::new(scene, settings.clone(), compute)?)?;
    let hash = render.image.hash();
    let whole = settings.image();
    let file = figure.file();
    render.image.write(
        &folder.join(&file),
        Transfer::Gamma2,
        &Identity::new(scene, &settings, whole).metadata(&hash).with(FIGURE, figure.number),
    )?;
    let seconds = render.seconds.render;
    Ok(Rendered { figure, settings, file, seconds, rays: render.tally.rays.total(), hash })
}

/// A page without scripts or files from other sites. The pictures are beside it.
pub(crate) fn html(rendered: &[Rendered<'_>], threads: u32) -> String {
    let machine = Machine::this();
    let threads = if threads == 0 { machine.cores } else { threads as usize };
    let mut figures = String::new();
    for Rendered { figure, settings, file, seconds, rays, hash } in rendered {
        let ImageSettings { width, height, spp, .. } = settings;
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
        include_str!("page.html"),
        cpu = machine.cpu,
        isa = machine.isa,
        threads = threads,
        figures = figures,
        version = env!("CARGO_PKG_VERSION"),
    )
}
