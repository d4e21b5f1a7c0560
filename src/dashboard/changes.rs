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

/// Where speeds change: `records` holds those of each record's blocks, none where it does not take part.
/// A record begins another level where it is beyond the threshold beside the blocks of the level so
/// far, by more than the level's records differ among each other, and so is the next, the same way: a
/// busy hour alone does not.
pub(super) fn changes(records: &[&[f64]]) -> Vec<Option<Change>> {
    let mut changes = vec![None; records.len()];
    let mut level: Vec<&[f64]> = Vec::new();
    let known: Vec<usize> = (0..records.len()).filter(|&i| !records[i].is_empty()).collect();
    for (place, &number) in known.iter().enumerate() {
        let blocks = records[number];
        if !level.is_empty() {
            let next = known.get(place + 1).map(|&next| records[next]);
            changes[number] = change(&level[level.len().saturating_sub(LEVEL)..], blocks, next);
        }
        if changes[number].is_some() {
            level.clear();
        }
        level.push(blocks);
    }
    changes
}

fn change(level: &[&[f64]], blocks: &[f64], next: Option<&[f64]>) -> Option<Change> {
    let (all, spread) = (level.concat(), spread(level));
    let beside = |blocks: &[f64]| {
        let Estimate { median, lo, hi } = Estimate::of_ratio(blocks, &all);
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

/// By how much a record may be off its level, as a factor: three standard deviations of the medians of
/// the level's records, where there are enough to tell. They follow from the median absolute deviation, so
/// that one bad record is not what decides.
fn spread(level: &[&[f64]]) -> f64 {
    if level.len() < 4 {
        return 1.0;
    }
    let medians = sorted(level.iter().map(|blocks| middle(&sorted(blocks.iter().copied()))));
    let center = middle(&medians);
    let off = sorted(medians.iter().map(|median| (median / center - 1.0).abs()));
    1.0 + 3.0 * 1.4826 * middle(&off)
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
        let places: Vec<usize> = (0..6).filter(|&i| found[i].is_some()).collect();
        assert_eq!(places, [3]);
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
        let places: Vec<usize> = (0..speeds.len()).filter(|&i| found[i].is_some()).collect();
        assert_eq!(places, [3, 8], "{found:?}");
        let down = found[3].unwrap();
        assert!(down.confirmed && (down.ratio.median - 0.95).abs() < 0.01, "{down:?}");
        assert!(!found[8].unwrap().confirmed);
    }

    /// Hours differ by a percent, all blocks of a record alike; a step of 8% is found nevertheless.
    #[test]
    fn records_that_differ_among_each_other_are_no_changes() {
        let mut random = Stream::new(6);
        let mut alarms = 0;
        for _ in 0..1000 {
            let mut speeds: Vec<f64> =
                (0..12).map(|_| 50.0 * f64::from(random.between(0.99, 1.01))).collect();
            // The first four tell how much they differ.
            alarms += found(&history(&mut random, &speeds))[4..].iter().flatten().count();
            speeds[8..].iter_mut().for_each(|speed| *speed *= 0.92);
            assert!(found(&history(&mut random, &speeds))[8].is_some());
        }
        // Of 8000.
        assert!(alarms <= 8, "{alarms}");
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
