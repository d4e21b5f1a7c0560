//! Measures the clock rate of the cores without hardware counters.

use std::hint::black_box;
use std::thread;
use std::time::Instant;

use crate::measure::statistics::Estimate;

/// Steps per slice, which takes about a fifth of a millisecond.
const STEPS: u32 = 1 << 17;
/// Number of slices. The result is their median, since interrupts disturb a few slices and clocks
/// change within milliseconds.
const SLICES: usize = 24;
/// Operations per step. Each depends on the one before and takes one cycle.
const OPERATIONS: f64 = 6.0;
/// An arbitrary odd number.
const ADDEND: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mean clock of the cores in GHz while `threads` threads are busy. The measurement takes about 5 ms.
pub(super) fn gigahertz(threads: usize) -> f64 {
    let sum: f64 = thread::scope(|scope| {
        let running: Vec<_> = (1..threads).map(|_| scope.spawn(one_core)).collect();
        let own = one_core();
        running.into_iter().map(|thread| thread.join().unwrap_or(own)).sum::<f64>() + own
    });
    sum / threads.max(1) as f64
}

/// Clock in GHz of the core that runs this thread.
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

/// Does three rotations and three additions, each of which depends on the one before. They update the
/// state in place, without a copy, so that each takes one cycle on every current CPU. No compiler can
/// combine them into fewer operations.
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

    /// If a compiler shortened the loop, the core would seem impossibly fast.
    #[test]
    fn clocks_are_possible() {
        for threads in [1, 3] {
            let clock = gigahertz(threads);
            assert!(clock > 0.0 && clock < 15.0, "{clock} GHz");
        }
    }
}
