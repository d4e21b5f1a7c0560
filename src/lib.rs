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
//! # A scene in code, a view of it, and a render that can be stopped
//!
//! A [`Renderer`] owns all that it needs and can live beside an application's own data. The trees of a
//! [`PreparedScene`] serve any camera, image size, seed and number of samples.
//!
//! ```
//! use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
//!
//! use ptfast::engine::{Observer, Progress, Stop};
//! use ptfast::scene::material::{Lambertian, Light, Sides};
//! use ptfast::scene::{Background, CameraFile, PrimitiveFile, SceneFile};
//! use ptfast::{RenderSettings, Renderer, Scene};
//!
//! # fn main() -> ptfast::Result<()> {
//! let mut file = SceneFile::new(CameraFile::new([0.0, 1.0, 5.0], [0.0, 0.5, 0.0], 40.0));
//! file.background = Background::Constant { radiance: [0.2, 0.3, 0.5] };
//! file.add_material("grey", Lambertian { albedo: [0.7; 3].into() });
//! file.add_material("lamp", Light { radiance: [5.0; 3], sides: Sides::Both });
//! file.primitives.push(PrimitiveFile::Sphere {
//!     center: [0.0, 3.0, 0.0],
//!     radius: 0.5,
//!     material: "lamp".to_owned(),
//! });
//! file.primitives.push(PrimitiveFile::Triangles {
//!     vertices: vec![[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [0.0, 0.0, -4.0], [0.0, 2.0, 0.0]],
//!     indices: vec![[0, 1, 2], [0, 1, 3]],
//!     material: "grey".to_owned(),
//! });
//! let scene = Scene::from_file(&file)?;
//!
//! /// Counts samples, and stops the render after so many.
//! struct Most(u64, AtomicU64);
//!
//! impl Observer for Most {
//!     fn progressed(&self, progress: Progress) {
//!         self.1.fetch_max(progress.samples, Relaxed);
//!     }
//!
//!     fn stop(&self) -> Stop {
//!         if self.1.load(Relaxed) < self.0 { Stop::No } else { Stop::Now }
//!     }
//! }
//!
//! let settings = RenderSettings { width: 64, height: 48, spp: 256, ..RenderSettings::of(&scene) };
//! let mut renderer = Renderer::new(&scene, settings.clone())?;
//! let mut rendering = renderer.begin()?;
//! renderer.advance(&mut rendering, &Most(20_000, AtomicU64::new(0)))?;
//! let done = rendering.progress().samples;
//! assert!((20_000..64 * 48 * 256).contains(&done));
//! let image = rendering.image()?; // the means of the samples so far
//! let pixels: &[[f32; 3]] = image.pixels();
//! assert_eq!(pixels.len(), 64 * 48);
//!
//! // It can go on, to the bits of a render that was never stopped ...
//! renderer.advance_to(&mut rendering, 32, &())?;
//! // ... or make way for another view of the same trees.
//! renderer.set(RenderSettings { spp: 1, seed: 2, ..settings })?;
//! renderer.render()?;
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
