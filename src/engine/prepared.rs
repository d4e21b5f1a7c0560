//! Prepared scenes: a scene with its trees and tables, which are built once for all views.

use std::sync::{Arc, OnceLock};

use super::{ComputeSettings, Engine, ImageSettings, Survival, pool};
use crate::accel::{Accelerator, Kernel};
use crate::scene::Scene;
use crate::shading::{CameraFrame, SceneTables};

/// Number of primitives above which any plan needs the same trees.
const LARGE: u64 = 1 << 16;

/// A scene with the trees and tables from which engines render it.
///
/// Trees and tables do not depend on the camera or the settings. Each is built on first use. Clones
/// share them, even across threads.
#[derive(Clone, Debug)]
pub struct PreparedScene(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    scene: Scene,
    accelerator: Arc<Accelerator>,
    tables: OnceLock<SceneTables>,
}

impl PreparedScene {
    /// Prepares `scene`. Its first renderer builds the trees.
    pub fn new(scene: Scene) -> Self {
        let accelerator = Arc::new(Accelerator::new(Arc::clone(scene.geometry())));
        Self(Arc::new(Inner { scene, accelerator, tables: OnceLock::new() }))
    }

    /// Prepares `scene`, which has the same shapes, with the same trees.
    pub(super) fn with_scene(&self, scene: Scene) -> Self {
        let accelerator = Arc::clone(&self.0.accelerator);
        Self(Arc::new(Inner { scene, accelerator, tables: OnceLock::new() }))
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.0.scene
    }

    /// Whether any plan needs the same trees.
    pub(crate) fn is_large(&self) -> bool {
        self.scene().geometry().all_primitives() > LARGE
    }

    /// Builds the trees of a large scene, before its renderer does.
    pub(crate) fn build(&self, compute: &ComputeSettings) {
        self.accelerator().set_quality(compute.trees);
        let kernel = match compute.engine {
            Engine::Wavefront => Kernel::Stream,
            Engine::Scalar => Kernel::Scalar,
        };
        if self.is_large() {
            self.accelerator().prepare(kernel, pool::threads_for(compute.threads));
        }
    }

    pub(super) fn accelerator(&self) -> &Accelerator {
        &self.0.accelerator
    }

    pub(super) fn tables(&self) -> &SceneTables {
        self.0.tables.get_or_init(|| SceneTables::new(self.0.scene.world()))
    }
}

impl From<Scene> for PreparedScene {
    fn from(scene: Scene) -> Self {
        Self::new(scene)
    }
}

impl From<&Scene> for PreparedScene {
    fn from(scene: &Scene) -> Self {
        Self::new(scene.clone())
    }
}

impl From<&PreparedScene> for PreparedScene {
    fn from(prepared: &PreparedScene) -> Self {
        prepared.clone()
    }
}

/// A prepared scene as seen by one camera, shared by the workers of a render.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) prepared: PreparedScene,
    pub(super) settings: ImageSettings,
    pub(super) compute: ComputeSettings,
    pub(super) camera: CameraFrame,
    /// Which paths must survive Russian roulette: none, before [`View::with_survival`].
    pub(super) survival: Survival,
}

impl View {
    pub(super) fn new(
        prepared: PreparedScene,
        settings: ImageSettings,
        compute: ComputeSettings,
    ) -> Self {
        // The scene's own camera is the same view whether the settings name it or not.
        let camera = settings.camera(prepared.scene()).clone();
        let settings = ImageSettings { camera: Some(camera.clone()), ..settings };
        let camera = camera.frame(settings.width, settings.height);
        Self { prepared, settings, compute, camera, survival: Survival::ALWAYS }
    }

    pub(super) fn scene(&self) -> &Scene {
        self.prepared.scene()
    }
}
