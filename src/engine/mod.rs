//! Engines render a scene to an image. All engines return bit-identical images.

mod alpha;
mod backdrop;
mod contract;
mod memory;
mod observer;
mod plan;
mod pool;
mod prepared;
#[cfg(test)]
mod proof;
mod recording;
mod render;
mod renderer;
mod rendering;
mod scalar;
mod settings;
#[cfg(feature = "slowed")]
mod slowed;
mod stage;
mod stats;
mod tally;
mod timeline;
mod unit;
mod wavefront;

pub use backdrop::Backdrop;
pub use contract::BITS;
pub use observer::{Observer, Stop};
pub use plan::{Plan, Planning, SegmentPlan};
pub use pool::{Pin, Pinned};
pub use prepared::PreparedScene;
pub(crate) use recording::{PathRecorder, RayKind, TracedPath, TracedRay};
pub use render::{Render, Seconds};
pub use renderer::Renderer;
pub(crate) use rendering::MOST_EVENTS;
pub use rendering::{Progress, Rendering};
pub use settings::{Engine, RenderSettings};
pub use stage::Stage;
pub(crate) use stats::{SegmentWork, StageWork, WaveStats};
pub use tally::{Endings, NonFinite, RayCounts, Tally};
pub(crate) use timeline::{Activity, Event};
