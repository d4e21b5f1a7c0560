//! Changes of a scene that keep its shapes: materials, lights and the background.

use std::path::Path;
use std::sync::Arc;

use super::{Named, Scene, SceneData};
use crate::checks::Location;
use crate::error::{Error, Result};
use crate::limits::Budget;
use crate::shading::light::LightFile;
use crate::shading::{
    Background, ImageContainer, ImageFiles, Images, Material, Texture, TextureRef, World,
};

/// What can change in a scene while its shapes stay as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The materials.
    pub materials: Named<Material>,
    /// The lights that are not primitives.
    pub lights: Vec<LightFile>,
    /// The light that comes from outside.
    pub background: Background,
}

/// Textures that are new must not name files.
struct NoFiles;

impl ImageFiles for NoFiles {
    fn embedded(&self, _: &Path) -> Option<&'static [u8]> {
        None
    }

    fn open<'b>(&self, path: &Path, _: &'b Budget) -> Result<Box<dyn ImageContainer + 'b>> {
        Err(Error::Usage(format!(
            "{}: a new image needs the scene to be loaded again",
            path.display()
        )))
    }
}

impl Scene {
    /// The materials, lights and background.
    pub fn look(&self) -> Look {
        let World { materials, lights, background, .. } = self.world();
        let materials = self.0.material_names.iter().cloned().zip(materials.iter().cloned());
        let (lights, background) = (lights.clone(), background.clone());
        Look { materials: Named(materials.collect()), lights, background }
    }

    /// The scene with the materials, lights and background of `look`, and with the same shapes.
    ///
    /// # Errors
    /// If a value is out of its range, returns [`Error::Input`]. Also if something else would change: the names of the
    /// materials, the opacity or normal map of a material or whether it emits light, the number of lights, or an image.
    pub fn with_look(&self, look: Look) -> Result<Self> {
        let data = &*self.0;
        let world = self.world();
        let element = |place: String, kind| Location { file: &data.name, place, kind };
        let e = element(String::new(), "look");
        if !look.materials.names().eq(data.material_names.iter().map(String::as_str)) {
            return Err(e.error("materials can change, but not be added, removed or renamed"));
        }
        let budget = Budget::new(&data.limits, 0);
        let mut images = Images::new(Path::new(""), &budget, &NoFiles);
        let mut old: Vec<Material> = world.materials.clone();
        let known: Vec<Arc<Texture>> = old
            .iter_mut()
            .flat_map(Material::textures)
            .map(|texture| Arc::clone(texture.get()))
            .collect();
        let has_colors = world.materials.iter().any(Material::uses_vertex_colors);
        let mut materials = Vec::new();
        for ((name, mut material), old) in look.materials.0.into_iter().zip(&world.materials) {
            let e = element(format!("materials.{name}"), "material");
            for reference in material.textures() {
                if let TextureRef::Named(name) = reference {
                    return Err(e.error(format!(
                        "the texture `{name}` must be given directly, not by name"
                    )));
                }
                let texture = reference.get();
                if known.iter().any(|known| Arc::ptr_eq(known, texture)) {
                    continue;
                }
                if texture.model().file().is_some() {
                    return Err(e.error("a new image needs the scene to be loaded again"));
                }
                let mut texture = Texture::clone(texture);
                texture.model_mut().load(&e, &mut images)?;
                *reference = TextureRef::Texture(Arc::new(texture));
            }
            material.check(&e)?;
            let role = |material: &Material| {
                (material.emits(), material.model().varied_emission().is_some())
            };
            // Trees and meshes depend on these.
            let kept = [
                ("opacity", material.model().opacity() == old.model().opacity()),
                ("normal map", material.model().normal() == old.model().normal()),
                ("need of tangents", {
                    material.model().needs_tangents() == old.model().needs_tangents()
                }),
                ("role as a light", role(&material) == role(old)),
                ("use of vertex colours", has_colors || !material.uses_vertex_colors()),
            ];
            if let Some((what, _)) = kept.iter().find(|(_, kept)| !kept) {
                return Err(
                    e.error(format!("its {what} cannot change without loading the scene again"))
                );
            }
            materials.push(material);
        }
        let background = look.background;
        match (&background, &world.background) {
            (Background::Image(new), Background::Image(old)) if new == old => {}
            (Background::Image(_), _) => {
                return Err(e.error("a new image needs the scene to be loaded again"));
            }
            (constant, _) => constant.clone().load(&e, &mut images)?,
        }
        for (index, light) in look.lights.iter().enumerate() {
            light.check(&element(format!("lights[{index}]"), light.name()))?;
        }
        let world = World { background, materials, lights: look.lights, ..world.clone() };
        if world.light_count() != data.lights {
            return Err(e.error(format!(
                "{} lights instead of {}: lights cannot be added or removed without loading the scene again",
                world.light_count(), data.lights
            )));
        }
        Ok(Self(Arc::new(SceneData { world, ..data.clone() })))
    }
}
