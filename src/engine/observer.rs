//! Observers: they see how far a render is, and may stop it.

use super::rendering::Progress;

/// Is told how far a render is, and may stop it.
pub trait Observer: Sync {
    /// `progress` is the state now; reports of several threads may arrive out of order.
    fn progressed(&self, progress: Progress);

    /// Whether the render is to go on. Is asked often, from any thread.
    fn stop(&self) -> Stop {
        Stop::No
    }
}

/// Whether a render is to go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// It is.
    #[default]
    No,
    /// Workers finish what they are at, a few thousand paths.
    Soon,
    /// Workers leave what they are at.
    Now,
}

/// Nobody watches.
impl Observer for () {
    fn progressed(&self, _: Progress) {}
}
