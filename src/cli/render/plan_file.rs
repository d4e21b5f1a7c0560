//! Plans of the wavefront engine: read from files, and described in a line.

use std::path::Path;

use crate::cli::console::notice;
use crate::engine::{Plan, SegmentPlan};
use crate::error::{Error, Result};
use crate::input::read_json;
use crate::limits::MAX_PLAN;
use crate::scene::Scene;
use crate::shading::Camera;

/// Reads a plan from a file that contains just the plan, or the record of a render. Prints a notice
/// if the record is of another scene or camera.
pub(crate) fn read(path: &Path, scene: &Scene, camera: &Camera) -> Result<Plan> {
    let bad = |message| Error::input(path.display().to_string(), "plan", message);
    let record: serde_json::Value = read_json(path, "a plan", MAX_PLAN)?;
    let plan = record.get("plan").unwrap_or(&record);
    if plan.is_null() {
        return Err(bad("the record has no plan: it is of the scalar engine".to_owned()));
    }
    if plan.get("wave_size").is_none() {
        return Err(bad("must be a plan or the record of a render".to_owned()));
    }
    let plan: Plan =
        serde_json::from_value(plan.clone()).map_err(|error| bad(error.to_string()))?;
    plan.check().map_err(bad)?;
    if record.get("scene_hash").is_some_and(|hash| *hash != *scene.hash_with(camera)) {
        notice(format_args!(
            "{}: the plan is of another scene or camera and may be slow for this one",
            path.display()
        ));
    }
    Ok(plan)
}

/// The plan in one line.
pub(crate) fn describe(plan: &Plan) -> String {
    let segment = |(number, plan): (usize, &SegmentPlan)| {
        format!("{}: {}, shadows {}", number + 1, plan.closest_by(), plan.occluded_by())
    };
    let segments: Vec<String> = plan.segments.iter().enumerate().map(segment).collect();
    format!("plan: waves of {}; segment {}", plan.wave_size, segments.join("; "))
}
