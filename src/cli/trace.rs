//! `ptfast trace`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::arguments::named;
use super::console::{advise_on_build, notice, say};
use super::files;
use crate::accel::{Accelerator, Kernel, Layout};
use crate::error::Result;
use crate::isa::Isa;
use crate::measure::machine::Machine;
use crate::measure::rayset;
use crate::measure::rayset::{RaySet, Replay};
use crate::output::write_atomically;

#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// Folder with a ray set, from `ptfast rays`
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Replay through this kernel only [default: the kernels that suit the scene's size, and
    /// scalar]
    #[arg(long, value_name = "KERNEL", value_parser = named(&Kernel::ALL, Kernel::name))]
    kernel: Option<Kernel>,
    /// Number of repetitions; the median is printed
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    reps: u32,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(crate) fn run(args: &TraceArgs) -> Result<u8> {
    let record = args.json.as_deref().map(|file| ("the record", file));
    let of_sets = rayset::files(&args.dir);
    let read: Vec<_> = of_sets.iter().map(|file| ("a part of the ray set", &**file)).collect();
    files::check(&read, record.as_slice())?;
    let sets = rayset::read(&args.dir)?;
    advise_on_build(Isa::Avx512);
    let name = &sets.scene;
    say(format_args!("scene   {name}, {} primitives", sets.geometry.len()))?;
    // Describe the machine now: once the process is pinned, it sees only one core.
    let record = args.json.as_ref().map(|path| (path, Machine::this()));
    pin_to_one_core();
    let accelerator = Accelerator::new(sets.geometry.clone());
    let (mut rows, mut different, mut built) = (Vec::new(), 0, Vec::new());
    for set in &sets.sets {
        let kernels = kernels(args.kernel, &accelerator);
        for &kernel in kernels.iter().filter(|kernel| !built.contains(*kernel)) {
            say_build(&accelerator, kernel, sets.geometry.len())?;
        }
        built.extend(&kernels);
        for replay in rayset::replay(&accelerator, set, &kernels, args.reps) {
            say_replay(set, &replay)?;
            different += replay.different;
            rows.push(json!({
                "set": set.name,
                "kernel": replay.kernel.name(),
                "rays": set.rays.len(),
                "mrays_per_s": replay.mrays_per_s,
                "different": replay.different,
                "counters": replay.counters,
            }));
        }
    }
    if let Some((path, machine)) = record {
        let record = json!({
            "schema": 1, "machine": machine, "scene": sets.scene, "kernels": rows
        });
        write_atomically(path, |file| writeln!(file, "{record:#}"))?;
    }
    if different > 0 {
        notice(format_args!(
            "{}: {different} hits differ from those of the ray set",
            args.dir.display()
        ));
        return Ok(1);
    }
    Ok(0)
}

/// Pins the process, so that all speeds are measured on one core.
fn pin_to_one_core() {
    let core = core_affinity::get_core_ids().and_then(|cores| cores.into_iter().next());
    if !core.is_some_and(core_affinity::set_for_current) {
        notice(format_args!("cannot pin to one core: the speeds may vary more"));
    }
}

/// The chosen kernel; by default, all kernels that may be the fastest, and the reference.
fn kernels(choice: Option<Kernel>, accelerator: &Accelerator) -> Vec<Kernel> {
    let suits = |kernel: &Kernel| *kernel == Kernel::Scalar || accelerator.may_win(*kernel);
    choice.map_or_else(|| Kernel::ALL.into_iter().filter(suits).collect(), |kernel| vec![kernel])
}

fn say_build(accelerator: &Accelerator, kernel: Kernel, primitives: usize) -> Result<()> {
    let Layout { bytes, seconds } = accelerator.prepare(kernel, 1);
    let (name, each) = (kernel.name(), bytes as f64 / primitives.max(1) as f64);
    say(format_args!("build   {name:<8}{seconds:.3} s, {each:.1} bytes per primitive"))
}

fn say_replay(set: &RaySet, replay: &Replay) -> Result<()> {
    let (rays, counters) = (set.rays.len(), &replay.counters);
    let a_ray = |count: u64| count as f64 / rays as f64;
    let active = 100.0 * counters.lanes_active as f64 / counters.lanes_issued.max(1) as f64;
    let work = if counters.lanes_issued == 0 {
        String::new()
    } else {
        format!(
            "  per ray: {:.2} nodes, {:.2} leaf tests, {active:.0}% of lanes active",
            a_ray(counters.node_visits),
            a_ray(counters.leaf_tests),
        )
    };
    let left = match counters.scalar_rays {
        left if left > 0 && replay.kernel != Kernel::Scalar => {
            format!(", {left} rays traced by scalar")
        }
        _ => String::new(),
    };
    say(format_args!(
        "{:<8}{:<8}{:>8.2} Mrays/s  {rays} rays  {} different{work}{left}",
        set.name,
        replay.kernel.name(),
        replay.mrays_per_s,
        replay.different,
    ))
}
