//! Chooses the plan of a render: the usual one for its kind of scene, or in large renders the fastest one in a
//! measurement.

mod fastest;
mod trial;
mod usual;

use std::sync::Arc;

use fastest::{PLANNED, fastest, fastest_segment};
use trial::{Effort, try_all};
use usual::usual_plan;

use crate::accel::Kernel;
use crate::engine::{ComputeSettings, Plan, PlanChoice, Planning, Pool, SegmentPlan, View};

/// Wave sizes to try.
const SIZES: [u32; 3] = [1 << 12, 1 << 13, 1 << 14];

/// Effort to compare ways of tracing, that is, kernels with and without sorted rays. Their times
/// differ by large factors.
const WAYS_EFFORT: Effort = Effort { share: 32, rounds: [3, 12], first: 4 };
/// Effort to compare wave sizes. Their times differ by a few percent, which is less than the
/// differences between parts of an image.
const SIZES_EFFORT: Effort = Effort { share: 48, rounds: [6, 12], first: 1 };

/// Returns the fastest plan for waves from all over the image, or the usual plan on request or if the render
/// has too few `paths` for trials. Also returns whether the plan was measured.
pub(super) fn find_plan(view: &View, paths: u64, pool: &Pool) -> (Plan, Planning) {
    // Counting would slow down the trials.
    let compute = ComputeSettings { count: false, ..view.compute.clone() };
    let (view, settings) = (&Arc::new(View { compute, ..view.clone() }), &view.settings);
    // Only these kernels trace instances, whatever their number.
    let instanced = view.prepared.accelerator().has_instances();
    let primitives = if instanced { usize::MAX } else { view.scene().geometry().len() };
    let (bounds, camera) = (view.prepared.accelerator().bounds(), view.camera.origin);
    let inside = camera.cmpge(bounds.min).all() && camera.cmple(bounds.max).all();
    let sampled = settings.samples_lights(view.scene());
    let lights = if sampled { view.prepared.tables().lights.len() } else { 0 };
    let usual =
        usual_plan(primitives, inside, lights, paths, pool.threads(), view.compute.wave_size);
    if view.compute.plan == PlanChoice::Usual {
        return (usual, Planning::Usual);
    }

    let ways = each_way(view, &usual);
    let tried = try_all(view, paths, pool, &ways, WAYS_EFFORT);
    let ways_tried = !tried.is_empty();
    let planned = 1..=settings.depth.min(PLANNED);
    let segment = |number| fastest_segment(&tried, number, usual.segment(number));
    let plan = match tried.as_slice() {
        [] => usual,
        _ => Plan { segments: planned.map(segment).collect(), ..usual },
    };

    let sizes = each_size(&view.compute, &plan);
    let tried = try_all(view, paths, pool, &sizes, SIZES_EFFORT);
    let planning =
        if ways_tried || !tried.is_empty() { Planning::Measured } else { Planning::Usual };
    (fastest(&tried).map_or(plan, |size| size.plan.clone()), planning)
}

/// Returns `plan` with each wave size to try. The list is empty if the settings set the size.
fn each_size(settings: &ComputeSettings, plan: &Plan) -> Vec<Plan> {
    let sizes = SIZES.map(|wave_size| Plan { wave_size, ..plan.clone() });
    sizes.into_iter().filter(|_| settings.wave_size == 0).collect()
}

/// Returns a plan for each way of tracing that might be fastest. Each plan applies to all segments.
fn each_way(view: &View, usual: &Plan) -> Vec<Plan> {
    let kernels = Kernel::ALL.into_iter().filter(|&k| view.prepared.accelerator().may_win(k));
    let has_shadows = view.settings.samples_lights(view.scene());
    let ways = kernels.flat_map(|kernel| {
        // Sorted shadow rays take equally long in any order of the others.
        let orders = [(false, false), (true, false), (true, true)];
        let orders = orders.into_iter().filter(|(_, of_shadows)| has_shadows || !of_shadows);
        orders.map(move |(ordered, shadows_ordered)| SegmentPlan {
            ordered,
            closest: kernel,
            occluded: kernel,
            shadows_ordered,
        })
    });
    ways.map(|way| Plan { segments: vec![way], ..usual.clone() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_tried_unless_one_is_set() {
        let plan = usual_plan(1, false, 0, 1 << 30, 1, 0);
        let sizes = |wave_size: u32| -> Vec<u32> {
            let settings = ComputeSettings { wave_size, ..ComputeSettings::default() };
            each_size(&settings, &plan).iter().map(|plan| plan.wave_size).collect()
        };
        assert_eq!(sizes(0), SIZES);
        assert!(sizes(5000).is_empty());
    }
}
