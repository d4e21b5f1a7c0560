//! The clock that cores run at, told without hardware counters.

use std::hint::black_box;
use std::thread;
use std::time::Instant;

use super::statistics::Estimate;

/// Steps of a slice: about a fifth of a millisecond.
const STEPS: u32 = 1 << 17;
/// Slices, of which the one in the middle counts: interrupts disturb a few, and clocks change within
/// milliseconds.
const SLICES: usize = 24;
/// Operations of a step that wait for each other, of one cycle each.
const OPERATIONS: f64 = 6.0;

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
    let mut state = black_box(0x9e37_79b9_7f4a_7c15);
    let slice = |_: usize| {
        let start = Instant::now();
        for _ in 0..STEPS {
            state = xorshift(state);
        }
        state = black_box(state);
        f64::from(STEPS) * OPERATIONS / start.elapsed().as_secs_f64() * 1e-9
    };
    Estimate::of((0..SLICES).map(slice)).median
}

/// Marsaglia 2003, "Xorshift RNGs": three shifts and three exclusive ors, one after the other, which
/// every CPU of today does in six cycles and no compiler in fewer operations.
#[inline(always)]
fn xorshift(mut state: u64) -> u64 {
    state ^= state << 13;
    state ^= state >> 7;
    state ^ (state << 17)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The loop is not shortened: what it leaves is what single steps leave, and no core is faster
    /// than this.
    #[test]
    fn clocks_are_possible() {
        for threads in [1, 3] {
            let clock = gigahertz(threads);
            assert!(clock > 0.0 && clock < 15.0, "{clock} GHz");
        }
    }
}
