//! The arguments that raise limits.

use bytesize::ByteSize;
use clap::Args;

use crate::error::Result;
use crate::limits::{Limit, Limits, Refused};
use crate::scene::Scene;

const HEADING: &str = "Limits";

#[derive(Debug, Args)]
// Not `next_help_heading`: what comes after these in other commands would have it, too.
pub(super) struct LimitArgs {
    /// Allow more (or less) than usual: scene-bytes, nesting, primitives, mesh-bytes, texture-bytes or pixels;
    /// N may be such as 2GiB
    #[arg(help_heading = HEADING, long = "limit", value_name = "NAME=N", value_parser = limit)]
    limits: Vec<(Limit, u64)>,
    /// Refuse what would take more memory, by estimate, such as 4GiB [default: what the machine and the process have]
    #[arg(help_heading = HEADING, long, value_name = "SIZE", value_parser = size)]
    memory_limit: Option<u64>,
    /// Let a scene read textures and meshes from outside its folder
    #[arg(help_heading = HEADING, long)]
    outside_files: bool,
}

impl LimitArgs {
    pub(super) fn limits(&self) -> Limits {
        let memory = self.memory_limit.map(|size| (Limit::Memory, size));
        let usual = Limits::default().with_outside_files(self.outside_files).with_advice(advice);
        let given = self.limits.iter().copied().chain(memory);
        given.fold(usual, |limits, (limit, value)| limits.with(limit, value))
    }

    /// The arguments again, for another process.
    pub(super) fn arguments(&self) -> Vec<String> {
        let limits =
            self.limits.iter().map(|(limit, value)| format!("--limit={}={value}", limit.name()));
        let memory = self.memory_limit.map(|size| format!("--memory-limit={size}"));
        let outside = self.outside_files.then(|| "--outside-files".to_owned());
        limits.chain(memory).chain(outside).collect()
    }

    /// As [`Scene::load_within`].
    pub(super) fn load(&self, name_or_path: &str) -> Result<Scene> {
        Scene::load_within(name_or_path, &self.limits())
    }
}

/// The flag that allows what was refused.
fn advice(refused: Refused) -> String {
    match refused {
        Refused::Beyond(Limit::Memory, value) => format!("--memory-limit {value} raises it"),
        Refused::Beyond(limit, value) => format!("--limit {}={value} raises it", limit.name()),
        Refused::OutsideFile => "--outside-files allows it".to_owned(),
    }
}

fn size(text: &str) -> Result<u64, String> {
    let size = text.parse::<ByteSize>().map(|size| size.as_u64());
    size.ok().filter(|&size| size > 0).ok_or_else(|| "a size such as 500MB or 4GiB".to_owned())
}

fn limit(text: &str) -> Result<(Limit, u64), String> {
    // Memory has a flag of its own.
    let mut known = Limit::ALL.into_iter().filter(|&limit| limit != Limit::Memory);
    let (name, value) = text.split_once('=').ok_or("NAME=N, such as mesh-bytes=8GiB")?;
    let Some(limit) = known.clone().find(|limit| limit.name() == name) else {
        let names: Vec<_> = known.by_ref().map(Limit::name).collect();
        return Err(format!("one of {}", names.join(", ")));
    };
    let value = size(value)?;
    match value <= limit.most() {
        true => Ok((limit, value)),
        false => Err(format!("{name} can be {} at most", limit.most())),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        limits: LimitArgs,
    }

    #[test]
    fn arguments_say_the_same_again() {
        let given = ["--limit", "pixels=100", "--limit", "nesting=7", "--memory-limit", "1MiB"];
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
        for wrong in ["", "mesh-bytes", "mesh-bytes=", "mesh-bytes=0", "memory=1", "nesting=-1"] {
            assert!(limit(wrong).is_err(), "{wrong}");
        }
        assert_eq!(limit("nesting=128"), Err("nesting can be 127 at most".to_owned()));
        assert!(limit("meshes=1").unwrap_err().starts_with("one of scene-bytes, nesting"));
        assert_eq!(size("1.5 KiB"), Ok(1536));
    }
}
