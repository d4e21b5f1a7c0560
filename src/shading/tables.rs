//! The tables of a scene that both engines read.

use super::glow::mean_radiance;
use super::light::{Lights, LightsBuilder};
use super::looks::{Emitter, Glow};
use super::material::MaterialTables;
use super::{
    Background, Bodies, Emission, Interaction, Looks, Media, ScatterNormals, TextureTables, World,
};
use crate::geometry::{Hit, Ray, ShadingNormal, Shape, Surfaces};
use crate::math::{Real, face_forward};

/// The surfaces, materials, textures, lights, media and bodies of a scene, in tables.
#[derive(Debug)]
pub(crate) struct SceneTables {
    pub(crate) surfaces: Surfaces,
    pub(crate) looks: Looks,
    pub(crate) materials: MaterialTables,
    pub(crate) textures: TextureTables,
    pub(crate) lights: Lights,
    pub(crate) media: Media,
    pub(crate) bodies: Bodies,
}

impl SceneTables {
    pub(crate) fn new(world: &World) -> Self {
        let geometry = &world.geometry;
        let (mut materials, mut textures, mut bodies) = Default::default();
        let mut lights = LightsBuilder::default();
        let surfaces = Surfaces::new(geometry);
        let varied = world.varied_lights();
        let emit = |Emitter { shape, primitive: number, glow }: Emitter,
                    textures: &TextureTables| {
            let primitive = geometry.get(number);
            let (emission, textured) = match glow {
                Glow::Constant(emission) => (emission, false),
                Glow::Varied(row, largest, sides) => {
                    let (tables, place) = ((&surfaces, textures), (shape, number, primitive));
                    let radiance = mean_radiance(tables, place, (row, largest), varied);
                    (Emission { radiance, sides }, true)
                }
            };
            lights.push(number, primitive, emission, textured);
        };
        let looks = Looks::new(world, &mut materials, &mut textures, &mut bodies, emit);
        world.lights.iter().for_each(|light| lights.push_free(light));
        if let Background::Image(map) = &world.background {
            lights.push_environment(map);
        }
        let media = Media::new(&world.media, looks.first_medium());
        Self { surfaces, looks, materials, textures, lights: lights.finish(), media, bodies }
    }

    /// Returns the points where `ray` has these hits of primitives of one shape. `textured` states
    /// whether the table of their materials contains any textures, and `glossy` whether they reflect
    /// light like a mirror, sharp or blurred. `instanced` is set for [`Shape::Instance`].
    #[inline(always)]
    pub(crate) fn interaction<R: Real>(
        &self,
        shape: Shape,
        ray: Ray<R>,
        hit: Hit<R>,
        textured: bool,
        glossy: bool,
        instanced: bool,
    ) -> Interaction<'_, R> {
        let surface = self.surfaces.find(shape, &ray, hit, instanced);
        let (normal, front) = face_forward(surface.normal, ray.direction);
        let textures = textured.then_some(&self.textures);
        let surfaces = &self.surfaces;
        let ShadingNormal { normal: shading, smooth, soft } = surface.shading;
        let normals = ScatterNormals::new(shading, smooth, normal, ray.direction, glossy);
        Interaction {
            surfaces,
            textures,
            ray,
            shape,
            hit,
            surface,
            normal,
            normals,
            smooth,
            soft,
            front,
        }
    }
}
