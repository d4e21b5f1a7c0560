//! The arguments that name a scene, and how it is read.

use std::path::{Path, PathBuf};

use clap::Args;

use super::IMAGE;
use super::named::named;
use crate::formats::{ImportOptions, LightUnits, Missing};
use crate::measure::settings::quoted;

const IMPORT: &str = "Scenes of other programs";

/// A scene, with or without `--scene` before it.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneArg {
    /// Built-in scene (spheres, spacetime, checker, cornell, garden, cloud:N, mesh:N, forest:N), a scene file (.ron,
    /// .json, .gltf, .glb, .pbrt), a mesh (.obj, .ply), or - for a scene on standard input. --scene SCENE is the same
    #[arg(value_name = "SCENE", required_unless_present = "scene", conflicts_with = "scene")]
    positional: Option<String>,
    /// The same as SCENE
    #[arg(long, value_name = "SCENE", hide = true)]
    scene: Option<String>,
    /// Environment map instead of the scene's background: a latitude-longitude image (.hdr, .exr, ...)
    #[arg(long, value_name = "FILE", help_heading = IMAGE)]
    env: Option<PathBuf>,
    /// Turn the map of --env about the y-axis, counterclockwise as seen from above [default: the middle of the map is
    /// at +x in glTF, OBJ and PLY files, and at -z in others]
    #[arg(long, value_name = "DEGREES", help_heading = IMAGE, requires = "env", allow_hyphen_values = true, value_parser = degrees)]
    env_rotation: Option<f32>,
    /// Set a field of a material, as in scene files: --set 'wall.base_color=(1, 0.5, 0)'. May be repeated
    #[arg(long, value_name = "MATERIAL.FIELD=VALUE", help_heading = IMAGE)]
    set: Vec<String>,
    /// What to do if a texture or mesh of a scene of another program is missing; grey: render without it
    #[arg(long, value_name = "HOW", help_heading = IMPORT, default_value = Missing::default().name(), value_parser = named(&Missing::ALL, Missing::name))]
    missing: Missing,
    /// Reject scenes of other programs that ask for something that ptfast lacks
    #[arg(long, help_heading = IMPORT)]
    strict: bool,
    /// Pose a glTF scene by the animation of this name or number
    #[arg(long, value_name = "NAME", help_heading = IMPORT)]
    animation: Option<String>,
    /// Time of the animation
    #[arg(long, value_name = "SECONDS", help_heading = IMPORT, default_value_t = 0.0, requires = "animation")]
    at: f64,
    /// Units of the lights of a glTF scene; blender: divide them by 683, because Blender exports lamps 683 times as
    /// strong as emission
    #[arg(long, value_name = "UNITS", help_heading = IMPORT, default_value = LightUnits::default().name(), value_parser = named(&LightUnits::ALL, LightUnits::name))]
    light_units: LightUnits,
    /// Turn the z-axis of a glTF, OBJ or PLY file up, instead of the y-axis
    #[arg(long, help_heading = IMPORT)]
    z_up: bool,
    /// Show a file without camera and light without a ground
    #[arg(long, help_heading = IMPORT)]
    no_ground: bool,
    /// Choose the variant of this name of the materials of a glTF scene
    #[arg(long, value_name = "NAME", help_heading = IMPORT)]
    variant: Option<String>,
}

fn degrees(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|degrees: &f32| degrees.abs() <= 360.0);
    degrees.ok_or_else(|| "must be a number from -360 to 360".to_owned())
}

impl SceneArg {
    #[cfg(test)]
    pub(crate) fn of(name: &str) -> Self {
        Self {
            positional: Some(name.to_owned()),
            scene: None,
            env: None,
            env_rotation: None,
            set: Vec::new(),
            missing: Missing::default(),
            strict: false,
            animation: None,
            at: 0.0,
            variant: None,
            light_units: LightUnits::default(),
            z_up: false,
            no_ground: false,
        }
    }

    /// The scene as the user named it.
    pub(crate) fn name(&self) -> &str {
        self.positional.as_deref().or(self.scene.as_deref()).expect("clap requires one")
    }

    /// Whether the scene is posed by an animation.
    pub(crate) fn is_animated(&self) -> bool {
        self.animation.is_some()
    }

    /// Poses the scene at another time of its animation, in seconds.
    pub(crate) fn pose_at(&mut self, time: f64) {
        self.at = time;
    }

    /// The environment map that replaces the background, and by how many degrees it is turned.
    pub(crate) fn env(&self) -> Option<(&Path, f32)> {
        Some((self.env.as_deref()?, self.env_rotation.unwrap_or(0.0)))
    }

    /// The changes of materials.
    pub(crate) fn edits(&self) -> &[String] {
        &self.set
    }

    /// How scenes of other programs are read.
    /// `size` is that of the picture, if the user chooses it.
    pub(crate) fn import(&self, size: Option<(u32, u32)>) -> ImportOptions {
        let Self { missing, strict, ref animation, at, ref variant, light_units, .. } = *self;
        ImportOptions {
            missing,
            strict,
            animation: animation.clone(),
            at,
            variant: variant.clone(),
            light_units,
            environment: self.env.is_some(),
            z_up: self.z_up,
            no_ground: self.no_ground,
            size,
        }
    }

    /// These arguments on a command line.
    pub(crate) fn words(&self) -> String {
        let missing = match self.missing {
            Missing::Error => String::new(),
            other => format!(" --missing {}", other.name()),
        };
        let env = self.env.iter().map(|path| format!(" --env {}", quoted(&path.to_string_lossy())));
        let turn = self.env_rotation.iter().map(|degrees| format!(" --env-rotation {degrees}"));
        let named = |option: &str, name: &Option<String>| {
            name.as_ref().map_or(String::new(), |name| format!(" --{option} {}", quoted(name)))
        };
        let animation = named("animation", &self.animation);
        let at =
            if self.animation.is_some() { format!(" --at {}", self.at) } else { String::new() };
        let variant = named("variant", &self.variant);
        let units = match self.light_units {
            LightUnits::File => String::new(),
            other => format!(" --light-units {}", other.name()),
        };
        let edits = self.set.iter().map(|edit| format!(" --set {}", quoted(edit)));
        let flag =
            |name: &str, given: bool| if given { format!(" --{name}") } else { String::new() };
        let flags = flag("z-up", self.z_up) + &flag("no-ground", self.no_ground);
        let (env, turn, edits) = (env.collect(), turn.collect(), edits.collect());
        let words = [env, turn, edits, missing, animation, at, variant, units, flags];
        quoted(self.name()) + &words.concat()
    }
}
