//! Reads records from files and checks them.

use std::path::Path;

use super::record::{Record, SCHEMA};
use super::run::{Block, Ratio, Run};
use crate::error::{Error, Result};
use crate::input::read_json;
use crate::limits::MAX_JSON;
use crate::measure::statistics::Estimate;

/// The path of an invalid field in a record, and a message that says what would be valid.
type Wrong = (String, String);

impl Record {
    /// Reads a record from a file.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a bench record.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let record: Self = read_json(path, "a bench record", MAX_JSON)?;
        record
            .check()
            .map_err(|(place, message)| Error::input(path.display().to_string(), place, message))?;
        Ok(record)
    }

    fn check(&self) -> Result<(), Wrong> {
        if self.schema != SCHEMA {
            let message = format!("version {} is not supported, it must be {SCHEMA}", self.schema);
            return Err(("schema".to_owned(), message));
        }
        for (number, run) in self.runs.iter().enumerate() {
            check_run(run, &format!("runs[{number}]"))?;
        }
        for (number, Ratio { speed, .. }) in self.ratios.iter().enumerate() {
            check_estimate(speed, format!("ratios[{number}]"))?;
        }
        Ok(())
    }
}

/// Maximum number of blocks of a run.
const MOST_BLOCKS: usize = 20_000;

fn check_run(run: &Run, place: &str) -> Result<(), Wrong> {
    run.work.settings.check_ranges().map_err(|message| (place.to_owned(), message))?;
    let blocks = Estimate::LEAST..=MOST_BLOCKS;
    if !blocks.contains(&run.blocks.len()) {
        let message = format!("a run must have {} to {MOST_BLOCKS} blocks", Estimate::LEAST);
        return Err((format!("{place}.blocks"), message));
    }
    if let Some(number) = run.blocks.iter().position(|block| !can_be(block)) {
        let message = "seconds, rays, clock, load or interference is out of range".to_owned();
        return Err((format!("{place}.blocks[{number}]"), message));
    }
    check_estimate(&run.mrays_per_s, format!("{place}.mrays_per_s"))?;
    check_estimate(&run.msamples_per_s, format!("{place}.msamples_per_s"))?;
    match run.stages.iter().find(|(_, seconds)| !(0.0..1e12).contains(*seconds)) {
        None => Ok(()),
        Some((stage, _)) => {
            Err((format!("{place}.stages.{stage}"), "must be seconds, 0 to 1e12".to_owned()))
        }
    }
}

/// Whether the numbers of `block` are possible measurements. Sums and quotients of possible
/// measurements are finite.
fn can_be(block: &Block) -> bool {
    let rays = [block.rays.primary, block.rays.bounce, block.rays.shadow];
    let taken = block.interference.unwrap_or_default();
    (1e-9..1e9).contains(&block.seconds)
        && rays.iter().all(|&rays| rays < 1 << 53)
        && block.rays.primary > 0
        && (block.clock == 0.0 || (0.01..100.0).contains(&block.clock))
        && block.load.is_none_or(|load| (0.0..=1.0).contains(&load))
        && (0.0..1e12).contains(&taken.stolen)
        && (0.0..1e12).contains(&taken.waited)
}

fn check_estimate(Estimate { median, lo, hi }: &Estimate, place: String) -> Result<(), Wrong> {
    if 0.0 < *lo && lo <= median && median <= hi && hi.is_finite() {
        return Ok(());
    }
    Err((place, "must be finite, with 0 < lo <= median <= hi".to_owned()))
}
