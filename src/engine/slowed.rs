//! A fault for trying out `ptfast bench`: builds with the feature `slowed` are slower by as many
//! percent as `PTFAST_SLOWED` says.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Keeps the core busy for a share of the time that `work` took.
pub(super) fn dawdle(work: Duration) {
    static SHARE: OnceLock<f64> = OnceLock::new();
    let share = *SHARE.get_or_init(|| {
        let percent = std::env::var("PTFAST_SLOWED").unwrap_or_else(|_| "0".to_owned());
        let percent = percent.parse::<f64>().ok().filter(|percent| (0.0..1e6).contains(percent));
        percent.expect("PTFAST_SLOWED is a percentage, 0 or more") / 100.0
    });
    let (start, wait) = (Instant::now(), work.as_secs_f64() * share);
    while start.elapsed().as_secs_f64() < wait {}
}
