//! Engines render a scene to an image. All engines return bit-identical images.

mod alpha;
mod backdrop;
mod compute_settings;
mod contract;
mod image_settings;
mod memory;
mod observer;
mod output;
mod path_recorder;
mod plan;
mod pool;
mod prepared;
#[cfg(test)]
mod proof;
mod renderer;
mod roulette;
mod scalar;
#[cfg(feature = "slowed")]
mod slowed;
mod stage;
mod state;
mod stats;
mod tally;
mod timeline;
mod unit;
mod wavefront;

pub use compute_settings::{ComputeSettings, Engine};
pub use contract::BITS;
pub use image_settings::ImageSettings;
pub use observer::{Observer, Stop};
pub use output::{Render, Seconds};
pub(crate) use path_recorder::{PathRecorder, RayKind, TracedPath, TracedRay};
pub use plan::{Plan, Planning, SegmentPlan};
pub use pool::{Pin, Pinned};
pub use prepared::PreparedScene;
pub use renderer::Renderer;
pub use roulette::Roulette;
pub use stage::Stage;
pub(crate) use state::MOST_EVENTS;
pub use state::{Progress, RenderState};
pub(crate) use stats::{SegmentWork, StageWork, WaveStats};
pub use tally::{Endings, NonFinite, RayCounts, Tally};
pub(crate) use timeline::{Activity, Event};
