//! Prepared scenes: trees and tables, made once for all views.

use std::sync::{Arc, OnceLock};

use super::settings::RenderSettings;
use crate::accel::Accelerator;
use crate::scene::{CameraFrame, Scene, SceneTables};

/// A scene with the trees and tables that engines render it by.
///
/// They do not depend on the camera or the settings, and each is made when it is first needed. Clones
/// share everything, also between threads.
#[derive(Clone, Debug)]
pub struct PreparedScene(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    scene: Scene,
    accelerator: Accelerator,
    tables: OnceLock<SceneTables>,
}

impl PreparedScene {
    /// Prepares `scene`. The first renderer makes the trees.
    pub fn new(scene: Scene) -> Self {
        let accelerator = Accelerator::new(Arc::clone(scene.geometry()));
        Self(Arc::new(Inner { scene, accelerator, tables: OnceLock::new() }))
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.0.scene
    }

    pub(super) fn accelerator(&self) -> &Accelerator {
        &self.0.accelerator
    }

    pub(super) fn tables(&self) -> &SceneTables {
        self.0.tables.get_or_init(|| SceneTables::new(&self.0.scene))
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

/// A prepared scene as one camera sees it: what the workers of a render share.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) prepared: PreparedScene,
    pub(super) settings: RenderSettings,
    pub(super) camera: CameraFrame,
}

impl View {
    pub(super) fn new(prepared: PreparedScene, settings: RenderSettings) -> Self {
        let camera = settings.camera.frame(settings.width, settings.height);
        Self { prepared, settings, camera }
    }

    pub(super) fn scene(&self) -> &Scene {
        self.prepared.scene()
    }
}
