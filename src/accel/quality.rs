//! How much work goes into the trees.

use crate::geometry::Geometry;

/// How much work goes into the trees. It never changes the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TreeQuality {
    /// Trees are built in a fraction of the time, and rays take longer.
    Fast,
    /// Rays are as fast as possible.
    #[default]
    Best,
}

names! { pub TreeQuality: Fast = "fast", Best = "best" }

/// Number of paths per primitive above which the best trees save more time than they cost.
const PATHS_PER_PRIMITIVE: u64 = 5;

impl TreeQuality {
    /// The quality with which a render of `paths` paths through `geometry` is ready first.
    pub(crate) fn for_paths(paths: u64, geometry: &Geometry) -> Self {
        if paths < PATHS_PER_PRIMITIVE * geometry.all_primitives() {
            Self::Fast
        } else {
            Self::Best
        }
    }
}
