//! The camera and the light of glTF files that have none.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::mem::{replace, take};

use glam::DAffine3;

use super::{Placement, Reader, pose};
use crate::error::Result;
use crate::formats::import::{Import, ImportOptions};
use crate::formats::view::Extent;
use crate::geometry::Bounds;
use crate::shading::Background;

/// The light of scenes without any: a bright sky above a grey ground.
const SKY: Background = Background::Gradient { bottom: [0.4; 3], top: [1.2; 3] };

impl Reader<'_, '_, '_> {
    /// Sets what the file leaves open.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        let chosen = !self.has_camera && self.extent.bounds != Bounds::EMPTY;
        if chosen {
            self.cover_animation()?;
            self.scene.camera = self.extent.camera();
        }
        // Displays and tail lights light no scene, so surfaces that emit light do not count.
        if self.scene.lights.is_empty() {
            self.scene.background = SKY;
            if chosen && !self.import.options.environment {
                self.extent.add_stage(&mut self.scene, !self.import.options.no_ground);
            }
            if !self.import.options.environment {
                self.import.note(
                    "has no KHR_lights_punctual lights, so a sky lights it; `--env` sets an environment map",
                );
            }
        }
        self.scene.render.spp = 64;
        Ok(())
    }

    /// Replaces the extent by that at some times of the animation, so that all frames have one camera.
    fn cover_animation(&mut self) -> Result<(), String> {
        let Some(times) = pose::times(self.gltf, self.import)? else { return Ok(()) };
        self.extent = Extent::new(self.import.options.aspect());
        for at in times {
            let options = ImportOptions { at, ..self.import.options.clone() };
            let budget = self.import.budget;
            let held = budget.held();
            let mut import = Import::new(self.import.folder, &options, budget);
            import.origin = self.import.origin;
            let mut frame = Reader::new(&mut import, self.gltf, String::new())?;
            frame.extent = self.extent;
            frame.nodes()?;
            let mut boxes: HashMap<usize, Bounds> = HashMap::new();
            for Placement { node, mesh, map } in take(&mut frame.placements) {
                if frame.is_deformed(node, mesh) {
                    frame.reach(node, mesh, &map)?;
                    continue;
                }
                let own = match boxes.entry(mesh) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(unknown) => {
                        let before = frame.extent;
                        frame.extent = Extent::new(options.aspect());
                        frame.reach(node, mesh, &DAffine3::IDENTITY)?;
                        *unknown.insert(replace(&mut frame.extent, before).bounds)
                    }
                };
                if own != Bounds::EMPTY {
                    frame.cover(own, &map);
                }
            }
            self.extent = frame.extent;
            budget.release(budget.held() - held);
        }
        Ok(())
    }
}
