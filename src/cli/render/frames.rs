//! `ptfast render --frames`: the pictures of an animation, one after the other.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::RenderArgs;
use super::job::{Loaded, RenderJob};
use super::target::{Target, stem};
use crate::cli::console::{self, complain, say};
use crate::error::{Error, Result};
use crate::image::Format;
use crate::interrupt;
use crate::live::Move;

/// Numbers of frames have at least so many digits.
const DIGITS: usize = 4;

/// Renders the frames `frames`. One that fails does not stop the others.
pub(super) fn run(args: &RenderArgs, frames: Range<u32>) -> Result<()> {
    let moves = args.sample.scene.is_animated();
    if !moves && args.frame.orbit.is_none() {
        let message =
            "--frames: nothing moves, name an --animation of a glTF scene or an angle to --orbit";
        return Err(Error::Usage(message.to_owned()));
    }
    let shard = args.part.shard()?;
    let mine = |frame: &u32| shard.is_none_or(|shard| frame % shard.count == shard.index);
    let mine = || frames.clone().filter(mine);
    // While only the camera moves, all frames have the same trees.
    let mut still: Option<Loaded> = None;
    let mut failed = Vec::new();
    for number in mine() {
        let start = Instant::now();
        interrupt::leave_at_once(true);
        let framed = frame(args, number)?;
        let loaded = match still.take() {
            Some(loaded) => Ok(loaded),
            None => Loaded::new(&framed),
        };
        let turn = f64::from(number - frames.start) / frames.len() as f64;
        match loaded.and_then(|loaded| {
            if !moves {
                still = Some(loaded.clone());
            }
            render(framed, loaded, turn, start)
        }) {
            Ok(()) if args.quiet => {}
            Ok(()) => {
                say(format_args!("frame   {number}, {:.2} s", start.elapsed().as_secs_f64()))?
            }
            // All frames would fail in the same way, or the user has seen enough.
            Err(error @ (Error::Usage(_) | Error::Interrupted(_) | Error::Stopped { .. })) => {
                return Err(error);
            }
            Err(error) => {
                complain(&format!("frame {number}: {error}"), error.exit_code());
                failed.push(number);
            }
        }
        // The first frame has said what is to be said.
        console::suppress_notices();
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Error::Resource(format!(
            "{} of {} frames failed, which the same command renders again: {failed:?}",
            failed.len(),
            mine().count()
        ))),
    }
}

/// Renders a frame, whose camera has made this share of its turn.
fn render(mut args: RenderArgs, loaded: Loaded, turn: f64, start: Instant) -> Result<()> {
    let turned = args.frame.orbit.map(|degrees| degrees * turn);
    if let Some(right) = turned.filter(|degrees| *degrees != 0.0) {
        let by = Move::Orbit { right, up: 0.0 };
        let camera = by.apply(&args.sample.camera.file(&loaded.scene)?)?;
        args.sample.camera = args.sample.camera.moved(&loaded.scene, &camera);
    }
    let mut job = RenderJob::of(&args, loaded, start)?;
    if args.skip_complete && job.is_complete()? {
        return job.report_complete();
    }
    job.run()
}

/// The arguments of frame number `number`.
fn frame(args: &RenderArgs, number: u32) -> Result<RenderArgs> {
    let mut framed = args.clone();
    let name = args.sample.scene.name();
    let output = args.output.clone().unwrap_or_else(|| format!("{}.png", stem(name)).into());
    if output.as_os_str() == "-" {
        let message = "--frames: standard output gets one picture, use -o FILE";
        return Err(Error::Usage(message.to_owned()));
    }
    let is_kept = match Target::of_path(output.clone())? {
        Target::Film(_) => true,
        _ => Format::of_path(&output)?.has_metadata(),
    };
    framed.skip_complete |= is_kept;
    framed.output = Some(numbered(&output, number));
    for report in [&mut framed.json, &mut framed.trace].into_iter().flatten() {
        *report = numbered(report, number);
    }
    framed.sample.scene.pose_at(f64::from(number) / args.frame.fps);
    framed.part.unshard();
    framed.quiet = true;
    Ok(framed)
}

/// `path` with a number before its extension.
fn numbered(path: &Path, number: u32) -> PathBuf {
    match path.extension() {
        Some(extension) => {
            path.with_extension(format!("{number:0DIGITS$}.{}", extension.to_string_lossy()))
        }
        None => path.with_extension(format!("{number:0DIGITS$}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_numbers_of_equal_length() {
        assert_eq!(numbered(Path::new("b/a.x.exr"), 7), Path::new("b/a.x.0007.exr"));
        assert_eq!(numbered(Path::new("record"), 7), Path::new("record.0007"));
        assert_eq!(numbered(Path::new("a.png"), 12345), Path::new("a.12345.png"));
    }
}
