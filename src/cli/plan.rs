//! Plans of the wavefront engine: read from files, told in a line.

use std::path::Path;

use super::notice;
use crate::engine::{Plan, SegmentPlan};
use crate::error::{Error, Result};
use crate::input::read_json;
use crate::limits::MAX_PLAN;
use crate::scene::Scene;

/// The plan in a file, which is a plan or the record of a render. Says so where that was of another
/// scene, unless `quiet`.
pub(super) fn read(path: &Path, scene: &Scene, quiet: bool) -> Result<Plan> {
    let bad = |message| Error::input(path.display().to_string(), "plan", message);
    let record: serde_json::Value = read_json(path, "a plan", MAX_PLAN)?;
    let plan = record.get("plan").unwrap_or(&record);
    if plan.is_null() {
        return Err(bad("the record has none: the scalar engine needs no plan".to_owned()));
    }
    if plan.get("wave_size").is_none() {
        return Err(bad("neither a plan nor the record of a render".to_owned()));
    }
    let plan: Plan =
        serde_json::from_value(plan.clone()).map_err(|error| bad(error.to_string()))?;
    plan.check().map_err(bad)?;
    // A hash goes over the whole scene.
    if !quiet && record.get("scene_hash").is_some_and(|hash| *hash != *scene.hash()) {
        notice(format_args!(
            "{}: the plan is of another scene, it may be slow here",
            path.display()
        ));
    }
    Ok(plan)
}

/// A plan in a line.
pub(super) fn describe(plan: &Plan) -> String {
    let segment = |(number, plan): (usize, &SegmentPlan)| {
        format!("{}: {}, shadows {}", number + 1, plan.closest_by(), plan.occluded.name())
    };
    let segments: Vec<String> = plan.segments.iter().enumerate().map(segment).collect();
    format!("plan: waves of {}; segment {}", plan.wave_size, segments.join("; "))
}
