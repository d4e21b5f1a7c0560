//! `ptfast trace`.

use std::io::Write;

use serde_json::json;

use super::args::TraceArgs;
use super::{advise_on_build, files, notice, printable, say};
use crate::accel::{Accelerator, Kernel};
use crate::error::Result;
use crate::isa::Isa;
use crate::machine::Machine;
use crate::output::write_atomically;
use crate::rayset::{self, RaySet, Replay};

pub(super) fn run(args: &TraceArgs) -> Result<u8> {
    let record = args.json.as_deref().map(|file| ("the record", file));
    let of_sets = rayset::files(&args.dir);
    let read: Vec<_> = of_sets.iter().map(|file| ("a part of the ray set", &**file)).collect();
    files::check(&read, record.as_slice())?;
    let sets = rayset::read(&args.dir)?;
    advise_on_build(Isa::Avx512);
    let name = printable(&sets.scene);
    say(format_args!("scene   {name}, {} primitives", sets.geometry.len()))?;
    // Pinned, the process sees one core.
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
        notice(format_args!("{}: {different} hits differ from the set's", args.dir.display()));
        return Ok(1);
    }
    Ok(0)
}

/// Speed is told of one core: not of two in turn.
fn pin_to_one_core() {
    let core = core_affinity::get_core_ids().and_then(|cores| cores.into_iter().next());
    if !core.is_some_and(core_affinity::set_for_current) {
        notice(format_args!("cannot pin to one core, the speeds may vary more"));
    }
}

/// The kernels that are asked for: by default all that may be fastest, and the reference.
fn kernels(choice: Option<Kernel>, accelerator: &Accelerator) -> Vec<Kernel> {
    let suits = |kernel: &Kernel| *kernel == Kernel::Scalar || accelerator.may_win(*kernel);
    choice.map_or_else(|| Kernel::ALL.into_iter().filter(suits).collect(), |kernel| vec![kernel])
}

fn say_build(accelerator: &Accelerator, kernel: Kernel, primitives: usize) -> Result<()> {
    let (tree, layout, name) = (accelerator.tree(), accelerator.prepare(kernel), kernel.name());
    let each = |bytes: usize| bytes as f64 / primitives.max(1) as f64;
    // The reference has a tree of its own, over all primitives; one kernel has none.
    let (tree, kept) = match kernel {
        Kernel::Scalar | Kernel::Flat => (0.0, String::new()),
        _ => (tree.seconds, format!(" + {:.1} of the tree", each(tree.bytes))),
    };
    say(format_args!(
        "build   {name:<8}{:.3} s = tree {tree:.3} + layout {:.3}, {:.1} bytes a primitive{kept}",
        tree + layout.seconds,
        layout.seconds,
        each(layout.bytes),
    ))
}

fn say_replay(set: &RaySet, replay: &Replay) -> Result<()> {
    let (rays, counters) = (set.rays.len(), &replay.counters);
    let a_ray = |count: u64| count as f64 / rays as f64;
    let active = 100.0 * counters.lanes_active as f64 / counters.lanes_issued.max(1) as f64;
    let work = if counters.lanes_issued == 0 {
        String::new()
    } else {
        format!(
            "  a ray: {:.2} nodes, {:.2} leaf tests, {active:.0}% of lanes active",
            a_ray(counters.node_visits),
            a_ray(counters.leaf_tests),
        )
    };
    let left = match counters.scalar_rays {
        left if left > 0 && replay.kernel != Kernel::Scalar => {
            format!(", {left} rays left to scalar")
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
