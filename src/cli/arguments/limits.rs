//! The arguments that raise limits.

use bytesize::ByteSize;
use clap::Args;

use super::SceneArg;
use crate::error::Result;
use crate::formats::{SceneDescription, Source};
use crate::limits::{Limit, Limits, Refused};
use crate::scene::Scene;

const HEADING: &str = "Limits";

/// Limits for any input.
#[derive(Clone, Debug, Args)]
// Each argument has its own `help_heading`, because `next_help_heading` would also apply to the
// arguments after these.
pub(crate) struct LimitArgs {
    /// Change a limit: scene-bytes, primitives, mesh-bytes, texture-bytes or pixels. N can have a unit, such as
    /// 2GiB
    #[arg(help_heading = HEADING, long = "limit", value_name = "NAME=N", value_parser = limit)]
    limits: Vec<(Limit, u64)>,
    /// Reject input whose estimated memory exceeds SIZE, such as 4GiB [default: the machine's
    /// memory, or a lower limit of the process]
    #[arg(help_heading = HEADING, long, value_name = "SIZE", value_parser = size)]
    memory_limit: Option<u64>,
}

/// Limits for scenes.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneLimitArgs {
    #[command(flatten)]
    limits: LimitArgs,
    /// Allow a scene to read textures and meshes from outside its folder
    #[arg(help_heading = HEADING, long)]
    outside_files: bool,
}

impl LimitArgs {
    pub(crate) fn limits(&self) -> Limits {
        let memory = self.memory_limit.map(|size| (Limit::Memory, size));
        let usual = Limits::default().with_advice(advice);
        let given = self.limits.iter().copied().chain(memory);
        given.fold(usual, |limits, (limit, value)| limits.with(limit, value))
    }
}

impl SceneLimitArgs {
    pub(crate) fn limits(&self) -> Limits {
        self.limits.limits().with_outside_files(self.outside_files)
    }

    /// The same arguments as strings, for a child process.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let LimitArgs { limits, memory_limit } = &self.limits;
        let limits =
            limits.iter().map(|(limit, value)| format!("--limit={}={value}", limit.name()));
        let memory = memory_limit.map(|size| format!("--memory-limit={size}"));
        let outside = self.outside_files.then(|| "--outside-files".to_owned());
        limits.chain(memory).chain(outside).collect()
    }

    /// The source that `name` stands for; `-` is standard input, which is read here.
    pub(crate) fn source(&self, name: &str) -> Result<Source> {
        match name {
            "-" => Source::from_reader(std::io::stdin().lock(), &self.limits()),
            _ => Source::find(name),
        }
    }

    /// Loads the scene `name` within these limits.
    pub(crate) fn load(&self, name: &str) -> Result<Scene> {
        self.source(name)?.read(&self.limits())?.resolve()
    }

    /// Reads the scene that these arguments name.
    pub(crate) fn read(&self, scene: &SceneArg) -> Result<SceneDescription> {
        self.read_for(scene, None)
    }

    /// As [`read`](Self::read), for a picture of this size, if it is not the scene's.
    pub(crate) fn read_for(
        &self,
        scene: &SceneArg,
        size: Option<(u32, u32)>,
    ) -> Result<SceneDescription> {
        let description =
            self.source(scene.name())?.read_with(&self.limits(), &scene.import(size))?;
        let mut description = match scene.env() {
            Some((path, degrees)) => description.with_environment(path, degrees)?,
            None => description,
        };
        scene.edits().iter().try_for_each(|edit| description.set(edit))?;
        Ok(description)
    }
}

/// Names the flag that allows the rejected input.
fn advice(refused: Refused) -> String {
    match refused {
        Refused::Beyond(Limit::Memory, value) => {
            // In whole MiB, rounded up.
            format!("--memory-limit {}MiB raises it", value.div_ceil(1 << 20))
        }
        Refused::Beyond(limit, value) => format!("--limit {}={value} raises it", limit.name()),
        Refused::OutsideFile => "--outside-files allows it".to_owned(),
    }
}

fn size(text: &str) -> Result<u64, String> {
    let size = text.parse::<ByteSize>().map(|size| size.as_u64());
    size.ok()
        .filter(|&size| size > 0)
        .ok_or_else(|| "must be a size above 0, such as 500MB or 4GiB".to_owned())
}

fn limit(text: &str) -> Result<(Limit, u64), String> {
    // Memory has a flag of its own.
    let mut known = Limit::ALL.into_iter().filter(|&limit| limit != Limit::Memory);
    let (name, value) = text.split_once('=').ok_or("must be NAME=N, such as mesh-bytes=8GiB")?;
    let Some(limit) = known.clone().find(|limit| limit.name() == name) else {
        let names: Vec<_> = known.by_ref().map(Limit::name).collect();
        return Err(format!("NAME must be one of {}", names.join(", ")));
    };
    let value = size(value)?;
    match value <= limit.most() {
        true => Ok((limit, value)),
        false => Err(format!("{name} must be at most {}", limit.most())),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        limits: SceneLimitArgs,
    }

    #[test]
    fn arguments_survive_a_round_trip() {
        let given = ["--limit", "pixels=100", "--memory-limit", "1MiB"];
        let args = Command::parse_from(["a"].iter().chain(&given).chain(&["--outside-files"]));
        let arguments = args.limits.arguments();
        let again = Command::parse_from(std::iter::once("a".to_owned()).chain(arguments));
        assert_eq!(again.limits.limits(), args.limits.limits());
        assert_eq!(again.limits.limits().get(Limit::Memory), 1 << 20);
    }

    #[test]
    fn limits_are_read() {
        assert_eq!(limit("mesh-bytes=8GiB"), Ok((Limit::MeshBytes, 8 << 30)));
        assert_eq!(limit("primitives=1000"), Ok((Limit::Primitives, 1000)));
        for wrong in ["", "mesh-bytes", "mesh-bytes=", "mesh-bytes=0", "memory=1", "pixels=-1"] {
            assert!(limit(wrong).is_err(), "{wrong}");
        }
        let message = "primitives must be at most 33554432";
        assert_eq!(limit("primitives=4000000000"), Err(message.to_owned()));
        assert!(limit("meshes=1").unwrap_err().contains("one of scene-bytes, primitives"));
        assert_eq!(size("1.5 KiB"), Ok(1536));
    }
}
