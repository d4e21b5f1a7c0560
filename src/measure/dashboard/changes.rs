//! Finds change points: the records at which a series becomes faster or slower.
//!
//! The records from one change point to the next form a *level*.

use serde::Serialize;

use crate::measure::bench::{Outcome, decide};
use crate::measure::statistics::{Estimate, middle, sorted};

/// Smallest change of speed that counts: 1%.
const THRESHOLD: f64 = 0.01;

/// A change of speed that begins at a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Change {
    /// Speed ratio of the record to the level before it.
    pub(super) ratio: Estimate,
    /// Whether the next record shows the same change; `false` if there is no next record yet.
    pub(super) confirmed: bool,
}

/// Maximum number of records of a level that a record is compared with, namely the latest ones.
const LEVEL: usize = 8;

/// Deviations of records from their level that are assumed before any is measured: four of 0.5%.
const OFF_AT_FIRST: [f64; 4] = [0.005; 4];

/// Finds the change points of a series. `records` holds the speeds of each record's blocks, and an
/// empty list for records that do not take part.
///
/// A record begins a new level if its speed differs from the blocks of the current level by more than the
/// threshold, even after allowing for the deviations of earlier records from their levels. The next
/// record, if there is one, must differ in the same direction, so that a single busy hour is not
/// reported as a change.
pub(super) fn changes(records: &[&[f64]]) -> Vec<Option<Change>> {
    let mut changes = vec![None; records.len()];
    let mut level: Vec<&[f64]> = Vec::new();
    let mut off = OFF_AT_FIRST.to_vec();
    let known: Vec<usize> = (0..records.len()).filter(|&i| !records[i].is_empty()).collect();
    for (index, &number) in known.iter().enumerate() {
        let blocks = records[number];
        if !level.is_empty() {
            let recent = level[level.len().saturating_sub(LEVEL)..].concat();
            let next = known.get(index + 1).map(|&next| records[next]);
            changes[number] = change(&recent, blocks, next, spread(&off));
            let ratio = Estimate::of_ratio(blocks, &recent).median;
            if changes[number].is_none() {
                off.push(ratio.max(1.0 / ratio) - 1.0);
            }
        }
        if changes[number].is_some() {
            level.clear();
        }
        level.push(blocks);
    }
    changes
}

fn change(level: &[f64], blocks: &[f64], next: Option<&[f64]>, spread: f64) -> Option<Change> {
    let beside = |blocks: &[f64]| {
        let Estimate { median, lo, hi } = Estimate::of_ratio(blocks, level);
        Estimate { median, lo: lo / spread, hi: hi * spread }
    };
    let ratio = beside(blocks);
    let outcome = decide(&ratio, THRESHOLD);
    if outcome == Outcome::Same {
        return None;
    }
    match next {
        None => Some(Change { ratio, confirmed: false }),
        Some(next) if decide(&beside(next), THRESHOLD) == outcome => {
            Some(Change { ratio, confirmed: true })
        }
        Some(_) => None,
    }
}

/// Factor by which a record may deviate from its level by chance: three standard deviations of the
/// earlier deviations `off`. The standard deviation is estimated from the median of `off`, which a
/// single bad record hardly moves.
fn spread(off: &[f64]) -> f64 {
    1.0 + 3.0 * 1.4826 * middle(&sorted(off.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    /// Creates records with these speeds, each of ten blocks with one percent of noise.
    fn history(random: &mut Stream, speeds: &[f64]) -> Vec<Vec<f64>> {
        let mut block = |speed: f64| speed * f64::from(random.between(0.99, 1.01));
        speeds.iter().map(|&speed| (0..10).map(|_| block(speed)).collect()).collect()
    }

    #[test]
    fn records_without_blocks_are_skipped() {
        let mut random = Stream::new(5);
        let mut records = history(&mut random, &[100.0, 1.0, 100.0, 90.0, 1.0, 90.0]);
        records[1].clear();
        records[4].clear();
        let found = found(&records);
        let indices: Vec<usize> = (0..6).filter(|&i| found[i].is_some()).collect();
        assert_eq!(indices, [3]);
        assert!(found[3].unwrap().confirmed);
    }

    fn found(records: &[Vec<f64>]) -> Vec<Option<Change>> {
        changes(&records.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    #[test]
    fn steps_are_found_and_one_bad_record_is_ignored() {
        let mut random = Stream::new(3);
        let speeds = [100.0, 100.0, 100.0, 95.0, 95.0, 95.0, 80.0, 95.0, 110.0];
        let found = found(&history(&mut random, &speeds));
        let indices: Vec<usize> = (0..speeds.len()).filter(|&i| found[i].is_some()).collect();
        assert_eq!(indices, [3, 8], "{found:?}");
        let down = found[3].unwrap();
        assert!(down.confirmed && (down.ratio.median - 0.95).abs() < 0.01, "{down:?}");
        assert!(!found[8].unwrap().confirmed);
    }

    /// Whole records vary with a standard deviation of 1%, which rarely counts as a change; a step of 8%
    /// is still found.
    #[test]
    fn noise_between_records_is_no_change() {
        const SERIES: usize = 200;
        let mut random = Stream::new(6);
        // The sum of twelve uniform numbers has a variance of 1.
        let mut normal = move || (0..12).map(|_| f64::from(random.uniform())).sum::<f64>() - 6.0;
        let (mut alarms, mut missed) = (0, 0);
        let mut random = Stream::new(7);
        for _ in 0..SERIES {
            let mut speeds: Vec<f64> = (0..40).map(|_| 50.0 * (1.0 + 0.01 * normal())).collect();
            alarms += found(&history(&mut random, &speeds)).iter().flatten().count();
            speeds[20..].iter_mut().for_each(|speed| *speed *= 0.92);
            missed += usize::from(found(&history(&mut random, &speeds))[20].is_none());
        }
        assert!(alarms <= SERIES / 10, "{alarms} in {SERIES} series of 40 records");
        assert!(missed <= SERIES / 20, "{missed} of {SERIES}");
    }

    /// A 95% interval misses the true value in 2.5% of the cases on either side, but a change must
    /// also exceed the threshold. Hence a steady series has no changes.
    #[test]
    fn steady_series_have_no_changes() {
        let mut random = Stream::new(4);
        let alarms = (0..1000)
            .flat_map(|_| found(&history(&mut random, &[50.0; 8])))
            .filter(Option::is_some)
            .count();
        assert_eq!(alarms, 0);
    }
}
