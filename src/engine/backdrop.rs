//! What the camera sees behind the scene.

/// What camera rays see that meet no surface and no medium. The light of the background on the
/// scene does not depend on it, nor do mirror images and views through glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Backdrop {
    /// The background.
    Shown,
    /// Black.
    Hidden,
    /// White, nothing else emits light, and all samples of a pixel count equally: with a depth of 1, the image
    /// is 1 - alpha.
    Alone,
}

impl Backdrop {
    /// The radiance along camera rays that leave the scene; `None` for that of the background.
    pub(super) fn radiance(self) -> Option<f32> {
        match self {
            Self::Shown => None,
            Self::Hidden => Some(0.0),
            Self::Alone => Some(1.0),
        }
    }
}
