//! Change points: where a series begins to be faster or slower.

use serde::Serialize;

use crate::bench::{Outcome, decide};
use crate::statistics::{Estimate, middle, sorted};

/// A change of speed that counts: 1%.
const THRESHOLD: f64 = 0.01;

/// A series changed at a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Change {
    /// How many times as fast it has been from there on.
    pub(super) ratio: Estimate,
    /// Whether the next record says the same; the last has none yet.
    pub(super) confirmed: bool,
}

/// Records that a level is made of, at most: the last ones.
const LEVEL: usize = 8;

/// How far records are off their level before any is known: four of half a percent.
const OFF_AT_FIRST: [f64; 4] = [0.005; 4];

/// Where speeds change: `records` holds those of each record's blocks, none where it does not take part.
/// A record begins another level where it is beyond the threshold beside the blocks of the level so
/// far, by more than records have been off their levels before, and so is the next, the same way: a busy
/// hour alone does not.
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

/// By how much a record may be off its level, as a factor: three standard deviations of how far others
/// were, which follow from their median, so that one bad record is not what decides.
fn spread(off: &[f64]) -> f64 {
    1.0 + 3.0 * 1.4826 * middle(&sorted(off.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    /// Ten blocks a record, with noise of a percent, at these speeds.
    fn history(random: &mut Stream, speeds: &[f64]) -> Vec<Vec<f64>> {
        let mut block = |speed: f64| speed * f64::from(random.between(0.99, 1.01));
        speeds.iter().map(|&speed| (0..10).map(|_| block(speed)).collect()).collect()
    }

    #[test]
    fn records_that_say_nothing_are_passed_over() {
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
    fn steps_are_found_and_one_bad_record_is_none() {
        let mut random = Stream::new(3);
        let speeds = [100.0, 100.0, 100.0, 95.0, 95.0, 95.0, 80.0, 95.0, 110.0];
        let found = found(&history(&mut random, &speeds));
        let indices: Vec<usize> = (0..speeds.len()).filter(|&i| found[i].is_some()).collect();
        assert_eq!(indices, [3, 8], "{found:?}");
        let down = found[3].unwrap();
        assert!(down.confirmed && (down.ratio.median - 0.95).abs() < 0.01, "{down:?}");
        assert!(!found[8].unwrap().confirmed);
    }

    /// Hours differ by a standard deviation of 1%, all blocks of a record alike; a step of 8% is found
    /// nevertheless.
    #[test]
    fn records_that_differ_among_each_other_are_no_changes() {
        const SERIES: usize = 200;
        let mut random = Stream::new(6);
        // Twelve uniform numbers have a variance of 1.
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

    /// Without a change none is found, but for 2.5% either way: it has to be beyond the threshold, too.
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
