//! `ptfast scenes`.

use super::args::ScenesCommand;
use super::console::{notice, say, say_lines};
use crate::error::Result;
use crate::scene::{BUILTIN_NAMES, Scene};

pub(super) fn run(command: &ScenesCommand) -> Result<()> {
    match command {
        ScenesCommand::List => BUILTIN_NAMES
            .iter()
            .try_for_each(|name| say(format_args!("{}", summary(&Scene::load(name)?)))),
        ScenesCommand::Show { scene, json, limits } => {
            let parsed = limits.read(scene)?;
            parsed.resolve()?;
            let text = if *json { parsed.to_json() } else { parsed.to_ron() };
            say_lines(text.trim_end())
        }
        ScenesCommand::Check { scene, limits } => {
            let scene = limits.read(scene)?.resolve()?;
            scene.warnings().iter().for_each(|warning| notice(format_args!("{warning}")));
            say(format_args!("{}", summary(&scene)))
        }
    }
}

fn summary(scene: &Scene) -> String {
    let geometry = scene.geometry();
    let defaults = scene.defaults();
    let instances = match &geometry.instances {
        none if none.is_empty() => String::new(),
        some => format!(" {} instances of {} triangles,", some.len(), some.triangle_count()),
    };
    format!(
        "{:<10} {} x {}, {} spp, {}: {} spheres, {} quads, {} triangles,{instances} {} materials, {} lights",
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
