//! `ptfast scenes`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;

use clap::{Args, Subcommand};

use super::arguments::{SceneArg, SceneLimitArgs};
use super::console::{notice, say, say_lines};
use super::files;
use crate::error::{Error, Result};
use crate::formats::BUILTIN_NAMES;
use crate::output::write_atomically;
use crate::scene::Scene;
use crate::shading::Background;

#[derive(Debug, Args)]
pub(crate) struct ScenesArgs {
    #[command(subcommand)]
    pub(crate) command: Option<ScenesCommand>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ScenesCommand {
    /// List the built-in scenes [default]
    List,
    /// Print a scene as RON or JSON
    Show {
        #[command(flatten)]
        scene: SceneArg,
        /// Print JSON instead of RON
        #[arg(long)]
        json: bool,
        /// Write into this file (.ron, .json) instead of standard output. Its paths are relative to its folder, or
        /// else to the current one
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
        #[command(flatten)]
        limits: SceneLimitArgs,
    },
    /// Check a scene, count its elements, and warn if its picture would be black
    Check {
        #[command(flatten)]
        scene: SceneArg,
        #[command(flatten)]
        limits: SceneLimitArgs,
    },
}

pub(crate) fn run(command: &ScenesCommand) -> Result<()> {
    match command {
        ScenesCommand::List => BUILTIN_NAMES
            .iter()
            .try_for_each(|name| say(format_args!("{}", summary(&Scene::load(name)?)))),
        ScenesCommand::Show { scene, json, output, limits } => {
            let json = match output {
                Some(file) => names_json(file, *json)?,
                None => *json,
            };
            let mut description = limits.read(scene)?;
            let checked = description.resolve()?;
            if description.has_builtin_images()
                && checked.files().next().is_none()
                && checked.world().texture_bytes() > 0
            {
                notice(format_args!(
                    "its images are compiled into the program, so the scene cannot be read from a file"
                ));
            }
            description.shorten();
            let folder = output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
            description.relocate(folder)?;
            let text = if json { description.to_json() } else { description.to_ron() };
            let Some(output) = output else { return say_lines(text.trim_end()) };
            files::check(&files::of_scene(scene.name(), &checked), &[("the scene", output)])?;
            write_atomically(output, |file| file.write_all(text.as_bytes()))
        }
        ScenesCommand::Check { scene, limits } => {
            let scene = limits.read(scene)?.resolve()?;
            scene.warnings().iter().for_each(|warning| notice(format_args!("{warning}")));
            say(format_args!("{}", summary(&scene)))?;
            contents(&scene)
                .iter()
                .try_for_each(|(name, content)| say(format_args!("  {name:<11}{content}")))
        }
    }
}

/// Whether a file that will be written is in JSON. No part of a scene of another program has one of the extensions.
///
/// # Errors
/// If its extension is that of neither form, or of RON although `--json` is given.
fn names_json(file: &Path, json: bool) -> Result<bool> {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match &*extension {
        "json" => Ok(true),
        "ron" if !json => Ok(false),
        _ => {
            let forms = if json { ".json" } else { ".ron or .json" };
            Err(Error::Usage(format!("--output {}: must end in {forms}", file.display())))
        }
    }
}

/// What is in a scene, by section.
fn contents(scene: &Scene) -> Vec<(&'static str, String)> {
    let count = |names: &mut dyn Iterator<Item = String>| {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        names.for_each(|name| *counts.entry(name).or_default() += 1);
        let counts = counts.iter().map(|(name, count)| format!("{count} {name}"));
        counts.collect::<Vec<_>>().join(", ")
    };
    let extension = |file: &Path| {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        format!(".{extension}")
    };
    let names: Vec<_> = scene.cameras().names().take(8).collect();
    let more = if scene.cameras().0.len() > names.len() { ", ..." } else { "" };
    let background = match scene.background() {
        Background::Constant { radiance: [0.0, 0.0, 0.0] } => "black",
        Background::Image(_) => "an environment map",
        _ => "a sky",
    };
    let textures = ByteSize::b(scene.world().texture_bytes()).display().iec();
    let rows = [
        ("cameras", names.join(", ") + more),
        ("files", count(&mut scene.files().map(extension))),
        (
            "textures",
            if scene.world().texture_bytes() > 0 { textures.to_string() } else { String::new() },
        ),
        (
            "materials",
            count(&mut scene.materials().iter().map(|material| material.name().to_owned())),
        ),
        ("background", background.to_owned()),
        (
            "media",
            if scene.media().is_empty() { String::new() } else { scene.media().len().to_string() },
        ),
    ];
    rows.into_iter().filter(|(_, content)| !content.is_empty()).collect()
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
