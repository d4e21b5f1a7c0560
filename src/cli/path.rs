//! `ptfast path`: prints each ray of one sample.

use clap::Args;
use glam::{DVec3, Vec3};

use super::arguments::camera::CameraArgs;
use super::arguments::limits::SceneLimitArgs;
use super::arguments::sample::SampleArgs;
use super::arguments::scene::SceneArg;
use super::console::say;
use crate::engine::{ImageSettings, PathRecorder, RayKind, TracedPath, TracedRay};
use crate::error::{Error, Result};
use crate::geometry::Hit;
use crate::limits::MAX_SPP;
use crate::measure::settings;
use crate::scene::Scene;

#[derive(Debug, Args)]
pub(crate) struct PathArgs {
    #[command(flatten)]
    of: SampleArgs,
    /// Column and row of the pixel, from the top left
    #[arg(long, allow_hyphen_values = true, value_name = "X,Y", value_parser = pixel)]
    pixel: (u32, u32),
    /// Number of the sample, from 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..i64::from(MAX_SPP)))]
    sample: u32,
    #[command(flatten)]
    limits: SceneLimitArgs,
}

fn pixel(text: &str) -> std::result::Result<(u32, u32), String> {
    let parsed = text.split_once(',').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
    parsed.ok_or_else(|| {
        format!("must be two whole numbers with a comma between them, such as 17,4, not `{text}`")
    })
}

/// The command that traces this sample again.
pub(crate) fn command(
    scene: &SceneArg,
    camera: &CameraArgs,
    image: &ImageSettings,
    (x, y): (u32, u32),
    sample: u32,
) -> String {
    // `path` lacks the flags of settings that do not change the rays of a sample.
    let path = PathArgs::augment_args(clap::Command::new("path"));
    let has = |flag: &str| path.get_arguments().any(|known| known.get_long() == Some(flag));
    let flags = settings::flags(image, has);
    let (scene, camera) = (scene.words(), camera.words());
    format!("ptfast path {scene}{camera} {flags} --pixel {x},{y} --sample {sample}")
}

pub(crate) fn run(args: &PathArgs) -> Result<()> {
    let scene = args.limits.read_for(&args.of.scene, args.of.size())?.resolve()?;
    let settings = args.of.settings(&scene)?;
    let ((x, y), sample) = (args.pixel, args.sample);
    if x >= settings.width || y >= settings.height {
        return Err(Error::Usage(format!(
            "--pixel must be within {} x {}, is {x},{y}",
            settings.width, settings.height
        )));
    }
    let recorder = PathRecorder::new(&scene, ImageSettings { spp: sample + 1, ..settings })?;
    let TracedPath { rays, radiance } = recorder.trace(x, y, sample);
    for ray in &rays {
        say(format_args!("{}", describe(&scene, ray)))?;
    }
    say(format_args!("{}", arriving(radiance)))
}

/// A line about the radiance of a path.
pub(super) fn arriving(radiance: Vec3) -> String {
    let [r, g, b] = radiance.to_array();
    let odd = if radiance.is_finite() { "" } else { ", not finite: it counts as black" };
    format!("radiance ({r}, {g}, {b}){odd}")
}

/// A line about a ray.
pub(super) fn describe(scene: &Scene, traced: &TracedRay) -> String {
    let TracedRay { kind, segment, ray, t_max, hit, collision } = traced;
    let (o, d) = (in_file(scene, ray.origin), ray.direction);
    let hits = match (kind, collision, hit) {
        (_, Some(t), _) => format!("is scattered by a medium at {t}"),
        (RayKind::Shadow, _, Some(_)) => "occluded".to_owned(),
        (RayKind::Shadow, _, None) => {
            let media = if scene.media().is_empty() { "" } else { ", apart from media" };
            format!("free up to {t_max}{media}")
        }
        (_, _, None) => "leaves the scene".to_owned(),
        (_, _, Some(hit)) => {
            let primitive = scene.geometry().name(hit);
            let kind = scene.material(hit.primitive).name();
            let name = scene.material_name(hit.primitive);
            let is_instanced = hit.primitive as usize >= scene.geometry().len();
            let instance =
                if is_instanced { format!(" in instance {}", hit.instance) } else { String::new() };
            let Hit { primitive: number, t, .. } = hit;
            format!("hits primitive {number}, a {primitive} of {kind} `{name}`{instance}, at {t}")
        }
    };
    let kind = match kind {
        RayKind::Primary => "camera ",
        RayKind::Bounce => "bounce ",
        RayKind::Shadow => "shadow ",
    };
    format!("{segment:>3} {kind} from ({o}) along ({}, {}, {}): {hits}", d.x, d.y, d.z)
}

/// A point of the scene in the coordinates of its file.
fn in_file(scene: &Scene, point: Vec3) -> String {
    let (Vec3 { x, y, z }, origin) = (point, scene.origin());
    if origin == DVec3::ZERO {
        return format!("{x}, {y}, {z}");
    }
    let DVec3 { x, y, z } = origin + point.as_dvec3();
    format!("{x}, {y}, {z}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_accepted() {
        use clap::Parser;
        let scene = Scene::load("cornell").unwrap();
        let (clamp, transparent) = (Some(2.0), true);
        let settings = ImageSettings { seed: 7, clamp, transparent, ..ImageSettings::of(&scene) };
        let command = |of| command(&SceneArg::of(of), &CameraArgs::default(), &settings, (3, 4), 5);
        let words = "--width 400 --height 400 --depth 50 --seed 7 --sampling mis --sampler sobol --roulette 5";
        let pasted = format!("ptfast path cornell {words} --pixel 3,4 --sample 5");
        assert_eq!(command("cornell"), pasted);
        let parsed = crate::cli::args::Cli::try_parse_from(pasted.split(' '));
        assert!(parsed.is_ok(), "{parsed:?}");
        assert!(command("it's.ron").starts_with(r"ptfast path 'it'\''s.ron' --width"));
        assert_eq!(
            (pixel("3,4"), pixel("3").is_err(), pixel("a,4").is_err()),
            (Ok((3, 4)), true, true)
        );
    }
}
