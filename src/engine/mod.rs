//! Engines render a scene to an image. All engines return bit-identical images.

mod compute_settings;
mod contract;
mod first_hit;
mod image_settings;
mod layers;
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
use contract::{ROULETTE_MAX, SHADOW_REACH, counted, emission_weight, power_heuristic, scale};
use first_hit::FirstHit;
pub use image_settings::ImageSettings;
use layers::{Combine, LightParts, finite};
pub use layers::{FirstHits, Layer, Layers};
pub(crate) use layers::{Totals, develop};
pub(crate) use memory::FilmOf;
pub use observer::{Observer, Stop};
pub use output::{Render, Seconds};
pub(crate) use path_recorder::{PathRecorder, RayKind, TracedPath, TracedRay};
pub use plan::{Plan, Planning, SegmentPlan};
use pool::Pool;
pub use pool::{Pin, Pinned};
pub use prepared::PreparedScene;
use prepared::View;
pub use renderer::Renderer;
pub use roulette::Roulette;
pub use stage::Stage;
pub(crate) use state::MOST_EVENTS;
use state::Shared;
pub use state::{Progress, RenderState};
use stats::Stopwatch;
pub(crate) use stats::{SegmentWork, StageWork, WaveStats};
pub use tally::{Endings, NonFinite, RayCounts, Tally};
use timeline::Lap;
pub(crate) use timeline::{Activity, Event};
use unit::{Taken, Task, UnitEngine, UnitWorker};
