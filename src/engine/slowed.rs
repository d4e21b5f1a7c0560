//! A deliberate slowdown to test `ptfast bench`. In builds with the feature `slowed`, each unit of
//! work takes longer by the percentage in the environment variable `PTFAST_SLOWED`.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Keeps the core busy for the set percentage of the duration `work`.
pub(super) fn dawdle(work: Duration) {
    static SHARE: OnceLock<f64> = OnceLock::new();
    let share = *SHARE.get_or_init(|| {
        let percent = std::env::var("PTFAST_SLOWED").unwrap_or_else(|_| "0".to_owned());
        let percent = percent.parse::<f64>().ok().filter(|percent| (0.0..1e6).contains(percent));
        percent.expect("PTFAST_SLOWED must be a percentage, 0 or more and below 1e6") / 100.0
    });
    let (start, wait) = (Instant::now(), work.as_secs_f64() * share);
    while start.elapsed().as_secs_f64() < wait {}
}
