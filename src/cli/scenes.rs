//! `ptfast scenes`.

use super::args::ScenesCommand;
use super::say;
use crate::error::Result;
use crate::scene::{BUILTIN_NAMES, Scene, Source};

pub(super) fn run(command: &ScenesCommand) -> Result<()> {
    match command {
        ScenesCommand::List => BUILTIN_NAMES
            .iter()
            .try_for_each(|name| say(format_args!("{}", summary(&Scene::load(name)?)))),
        ScenesCommand::Show { scene, json, limits } => {
            let parsed = Source::find(scene)?.read(&limits.limits())?;
            parsed.resolve()?;
            let text = if *json { parsed.to_json() } else { parsed.to_ron() };
            say(format_args!("{}", text.trim_end()))
        }
        ScenesCommand::Check { scene, limits } => {
            say(format_args!("{}", summary(&limits.load(scene)?)))
        }
    }
}

fn summary(scene: &Scene) -> String {
    let geometry = scene.geometry();
    let defaults = scene.defaults();
    format!(
        "{:<10} {} x {}, {} spp, {}: {} spheres, {} quads, {} triangles, {} materials, {} lights",
        scene.name(),
        defaults.width,
        defaults.height,
        defaults.spp,
        scene.default_sampling().name(),
        geometry.spheres.len(),
        geometry.quads.len(),
        geometry.triangles.len(),
        scene.materials().len(),
        scene.lights(),
    )
}
