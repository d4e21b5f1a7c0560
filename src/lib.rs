//! A CPU path tracer that proves what it says: the linear image is a pure function of scene,
//! settings and seed, to the last bit, whatever the number of threads or the instruction set.
//!
//! # In ten lines
//!
//! ```
//! use ptfast::{Metadata, RenderSettings, Renderer, Scene, Transfer};
//!
//! # fn main() -> ptfast::Result<()> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("spheres.png");
//! let scene = Scene::load("spheres")?; // or the path of a .ron, .json or .txt file
//! let settings = RenderSettings { width: 64, height: 36, spp: 4, ..RenderSettings::of(&scene) };
//! let render = Renderer::new(&scene, settings)?.render()?;
//! println!("{} rays, image {}", render.tally.rays.total(), render.image.hash());
//! render.image.write(&path, Transfer::Srgb, &Metadata::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! # Build for your CPU
//!
//! Registers are chosen at compile time, and cargo's default for x86-64 is SSE2. A crate
//! that depends on ptfast asks for more in its own `.cargo/config.toml`:
//!
//! ```toml
//! [target.'cfg(target_arch = "x86_64")']
//! rustflags = ["-C", "target-cpu=native"]
//! ```
//!
//! or in `RUSTFLAGS`, for example `-C target-cpu=x86-64-v3` for every CPU with AVX2.
//! [`compiled_isa`] tells what it came to, [`detected_isa`] what the CPU has. The images are
//! the same.
//!
//! # Where to find what
//!
//! Data flows one way: scene file → [`scene`] → [`accel`] → [`engine`] → [`film`] →
//! [`image`](mod@image). ARCHITECTURE.md has the table of files.

/// The README's example compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod accel;
mod bench;
pub mod checkpoint;
pub mod cli;
mod converge;
mod dashboard;
pub mod engine;
pub mod error;
pub mod film;
pub mod geometry;
pub mod image;
mod input;
pub mod interrupt;
pub mod isa;
pub mod limits;
pub mod machine;
pub mod math;
pub mod output;
pub mod rayset;
mod sampler;
pub mod scene;
mod simd;
mod statistics;

pub use engine::{Engine, PreparedScene, Render, RenderSettings, Renderer};
pub use error::{Error, Result};
pub use image::{Image, Metadata, Transfer};
pub use isa::{Isa, compiled_isa, detected_isa};
pub use sampler::Sampler;
pub use scene::{Sampling, Scene};

/// Reads the record of a bench, for fuzzing.
///
/// # Errors
/// Where it is none.
#[doc(hidden)]
pub fn check_record(path: &std::path::Path) -> Result<()> {
    bench::Record::read(path).map(drop)
}
