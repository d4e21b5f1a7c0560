//! Observers watch the progress of a render and may stop it.

use super::Progress;

/// Watches the progress of a render, and may stop it.
pub trait Observer: Sync {
    /// Reports progress. Reports of several threads may arrive out of order.
    fn progressed(&self, progress: Progress);

    /// Returns whether the render must stop. The workers call this often, from any thread.
    fn stop(&self) -> Stop {
        Stop::No
    }
}

/// Whether, and how fast, a render must stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// The render continues.
    #[default]
    No,
    /// Workers finish their current unit of work, a few thousand paths.
    Soon,
    /// Workers abandon their current unit of work.
    Now,
}

/// Watches nothing and never stops a render.
impl Observer for () {
    fn progressed(&self, _: Progress) {}
}
