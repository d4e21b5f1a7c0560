//! A CPU path tracer with reproducible images: the linear image is a pure function of scene,
//! settings and seed, to the last bit, for any number of threads and any instruction set.
//!
//! # A first render
//!
//! ```
//! use ptfast::{Engine, ImageSettings, Metadata, Renderer, Scene, Transfer};
//!
//! # fn main() -> ptfast::Result<()> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("spheres.png");
//! let scene = Scene::load("spheres")?; // or the path of a scene file
//! let settings = ImageSettings { width: 64, height: 36, spp: 4, ..ImageSettings::of(&scene) };
//! let render = Renderer::new(&scene, settings, Engine::Wavefront)?.render()?;
//! println!("{} rays, image {}", render.tally.rays.total(), render.image.hash());
//! render.image.write(&path, Transfer::Srgb, &Metadata::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! # A scene in code, and a render that can be stopped
//!
//! A [`Renderer`] owns all its data, so an application can store it in its own structs. The trees
//! of a [`PreparedScene`] serve any camera, image size, seed and number of samples.
//!
//! ```
//! use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
//!
//! use ptfast::material::{Lambertian, Light, Sides};
//! use ptfast::{Background, CameraFile, Engine, ImageSettings, Observer, Progress, Renderer, Scene};
//! use ptfast::{SceneFile, Stop};
//!
//! # fn main() -> ptfast::Result<()> {
//! let mut file = SceneFile::new(CameraFile::new([0.0, 1.0, 5.0], [0.0, 0.5, 0.0], 40.0));
//! file.background = Background::Constant { radiance: [0.2, 0.3, 0.5] };
//! file.add_material("grey", Lambertian::new([0.7; 3]));
//! file.add_material("lamp", Light { radiance: [5.0; 3], sides: Sides::Both });
//! file.add_sphere([0.0, 3.0, 0.0], 0.5, "lamp");
//! let vertices = [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [0.0, 0.0, -4.0], [0.0, 2.0, 0.0]];
//! file.add_mesh(&vertices, &[[0, 1, 2], [0, 1, 3]], "grey");
//! let scene = Scene::from_file(&file)?;
//!
//! /// Counts samples, and stops the render after a given number.
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
//! let settings = ImageSettings { width: 64, height: 48, spp: 256, ..ImageSettings::of(&scene) };
//! let mut renderer = Renderer::new(&scene, settings.clone(), Engine::Wavefront)?;
//! let mut rendering = renderer.begin()?;
//! renderer.advance(&mut rendering, &Most(20_000, AtomicU64::new(0)))?;
//! let done = rendering.progress().samples;
//! assert!((20_000..64 * 48 * 256).contains(&done));
//! let image = rendering.image()?; // the means of the samples so far
//! let pixels: &[[f32; 3]] = image.pixels();
//! assert_eq!(pixels.len(), 64 * 48);
//!
//! // The render can continue. Its image has the same bits as if it had never been stopped.
//! renderer.advance_to(&mut rendering, 32, &())?;
//! // The renderer can also switch to another view of the same trees.
//! let camera = (&CameraFile::new([4.0, 2.0, 3.0], [0.0, 0.5, 0.0], 40.0)).try_into()?;
//! renderer.set(ImageSettings { camera: Some(camera), spp: 1, seed: 2, ..settings }, Engine::Wavefront)?;
//! renderer.render()?;
//! # Ok(())
//! # }
//! ```
//!
//! # Build for your CPU
//!
//! The vector instruction set is chosen at compile time, and cargo's default for x86-64 is SSE2. A
//! crate that depends on ptfast chooses a wider one in its own `.cargo/config.toml`:
//!
//! ```toml
//! [target.'cfg(target_arch = "x86_64")']
//! rustflags = ["-C", "target-cpu=native"]
//! ```
//!
//! or in `RUSTFLAGS`, for example `-C target-cpu=x86-64-v3` for every CPU with AVX2.
//! [`compiled_isa`] returns the instruction set of the build, and [`detected_isa`] the best one of
//! the CPU. The images are the same for all of them.
//!
//! # Features
//!
//! `cli` (default) adds the program `ptfast` with its benches, checkpoints and tables. If you only
//! need the renderer, disable it: `ptfast = { version = "…", default-features = false }`.

// The library alone does not use everything that the program needs.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

/// Checks that the README's example compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[macro_use]
mod names;

mod accel;
#[cfg(feature = "cli")]
mod checkpoint;
mod checks;
#[cfg(feature = "cli")]
mod cli;
mod denoise;
mod engine;
mod error;
mod film;
mod formats;
mod geometry;
mod huge_pages;
mod image;
mod input;
#[cfg(feature = "cli")]
mod interrupt;
mod isa;
mod limits;
#[cfg(feature = "cli")]
mod live;
mod math;
#[cfg(feature = "cli")]
mod measure;
mod output;
mod sampler;
mod scene;
mod shading;
mod simd;

pub use accel::{Kernel, TreeQuality};
pub use denoise::Denoise;
pub use engine::{
    ComputeSettings, Endings, Engine, FirstHits, ImageSettings, Layer, Layers, NonFinite, Observer,
    Pin, Pinned, Plan, PlanChoice, Planning, PreparedScene, Progress, RayCounts, Render,
    RenderState, Renderer, Seconds, SegmentPlan, Session, Stop, Tally, Until,
};
pub use error::{Error, Result};
pub use formats::{BUILTIN_NAMES, ImportOptions, LightUnits, Missing, SceneDescription};
pub use glam;
pub use image::{Display, Exposure, Image, ImageLayer, Metadata, ToneMap, Transfer};
pub use isa::{Isa, compiled_isa, detected_isa};
pub use limits::{Limit, Limits, Refused};
pub use sampler::Sampler;
pub use scene::{
    Look, Named, NamedMesh, PrimitiveFile, RenderDefaults, Roulette, Sampling, Scene, SceneFile,
    primitive,
};
pub use shading::{
    Background, Camera, CameraFile, MediumFile, PixelFilter, light, material, texture,
};

/// Items for the program, the benches, the tests and the fuzz targets of this package. They are not
/// part of the library: anything here may change at any time.
#[doc(hidden)]
pub mod internals {
    pub use crate::accel::{Accelerator, Bvh2, Counters, HitBatch, RayBatch};
    #[cfg(feature = "cli")]
    pub use crate::checkpoint::{Checkpoint, Identity, Part};
    #[cfg(feature = "cli")]
    pub use crate::cli::run;
    pub use crate::engine::{BITS, Stage};
    pub use crate::film::{Film, Tile};
    pub use crate::formats::Source;
    pub use crate::geometry::{
        Bounds, Geometry, Hit, HoleTest, Holes, Instance, Instances, Quad, Ray, Sphere, Triangle,
        Triangles, Vertices,
    };
    pub use crate::isa::missing_feature;
    pub use crate::math::warp::uniform_sphere;
    pub use crate::math::{Stream, cross, dot, length, min, normalize};
    #[cfg(feature = "cli")]
    pub use crate::measure::rayset::{Query, RaySet, record};

    /// Checks that a file is the record of a bench.
    ///
    /// # Errors
    /// If the file cannot be read, or is not such a record.
    #[cfg(feature = "cli")]
    pub fn check_record(path: &std::path::Path) -> crate::Result<()> {
        crate::measure::bench::Record::read(path).map(drop)
    }
}
