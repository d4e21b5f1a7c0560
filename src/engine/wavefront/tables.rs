//! A scene in the tables that vectors read.

use super::cells::Cells;
use super::light::LightTable;
use super::materials::Materials;
use crate::accel::Accelerator;
use crate::geometry::lanes::Surfaces;
use crate::scene::Scene;

/// The tables of a scene.
#[derive(Debug)]
pub(in crate::engine) struct Tables {
    pub(super) materials: Materials,
    pub(super) lights: LightTable,
    pub(super) surfaces: Surfaces,
    pub(super) cells: Cells,
}

impl Tables {
    pub(in crate::engine) fn new(scene: &Scene, accelerator: &Accelerator) -> Self {
        Self {
            materials: Materials::new(scene),
            lights: LightTable::new(scene.lights()),
            surfaces: Surfaces::new(scene.geometry()),
            cells: Cells::new(&accelerator.bounds()),
        }
    }
}
