//! The clock that cores run at, told without hardware counters.

use std::hint::black_box;
use std::thread;
use std::time::Instant;

use crate::statistics::Estimate;

/// Steps of a slice: about a fifth of a millisecond.
const STEPS: u32 = 1 << 17;
/// Slices, of which the one in the middle counts: interrupts disturb a few, and clocks change within
/// milliseconds.
const SLICES: usize = 24;
/// Operations of a step that wait for each other, of a cycle each.
const OPERATIONS: f64 = 6.0;
/// Any odd number.
const ADDEND: u64 = 0x9e37_79b9_7f4a_7c15;

/// Cycles a nanosecond of cores, when so many threads are busy. It takes some 5 ms.
pub(super) fn gigahertz(threads: usize) -> f64 {
    let sum: f64 = thread::scope(|scope| {
        let running: Vec<_> = (1..threads).map(|_| scope.spawn(one_core)).collect();
        let own = one_core();
        running.into_iter().map(|thread| thread.join().unwrap_or(own)).sum::<f64>() + own
    });
    sum / threads.max(1) as f64
}

/// Of the core that this thread is on.
fn one_core() -> f64 {
    let mut state = black_box(1);
    let slice = |_: usize| {
        let start = Instant::now();
        for _ in 0..STEPS {
            state = step(state);
        }
        state = black_box(state);
        f64::from(STEPS) * OPERATIONS / start.elapsed().as_secs_f64() * 1e-9
    };
    Estimate::of((0..SLICES).map(slice)).median
}

/// Three rotations and three sums, one after the other: in place, without a copy, so that every CPU of
/// today takes a cycle for each, and no compiler knows fewer operations.
#[inline(always)]
fn step(mut state: u64) -> u64 {
    for bits in [7, 17, 39] {
        state = state.rotate_left(bits).wrapping_add(ADDEND);
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No core is as fast as a shortened loop would seem.
    #[test]
    fn clocks_are_possible() {
        for threads in [1, 3] {
            let clock = gigahertz(threads);
            assert!(clock > 0.0 && clock < 15.0, "{clock} GHz");
        }
    }
}
