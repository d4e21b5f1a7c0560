//! The tables of a scene that both engines read.

use super::light::{Lights, LightsBuilder};
use super::material::MaterialTables;
use super::{Background, Interaction, Looks, Media, TextureTables, World, smooth_normal};
use crate::geometry::{Hit, Ray, ShadingNormal, Shape, Surfaces};
use crate::math::{Real, face_forward};

/// The surfaces, materials, textures, lights and media of a scene, in tables.
#[derive(Debug)]
pub(crate) struct SceneTables {
    pub(crate) surfaces: Surfaces,
    pub(crate) looks: Looks,
    pub(crate) materials: MaterialTables,
    pub(crate) textures: TextureTables,
    pub(crate) lights: Lights,
    pub(crate) media: Media,
}

impl SceneTables {
    pub(crate) fn new(world: &World) -> Self {
        let geometry = &world.geometry;
        let (mut materials, mut textures) = Default::default();
        let mut lights = LightsBuilder::default();
        let emit = |primitive, emission| lights.push(geometry.get(primitive), emission);
        let looks = Looks::new(world, &mut materials, &mut textures, emit);
        world.lights.iter().for_each(|light| lights.push_free(light));
        if let Background::Image(map) = &world.background {
            lights.push_environment(map);
        }
        let media = Media::new(&world.media, looks.first_medium());
        let surfaces = Surfaces::new(geometry);
        Self { surfaces, looks, materials, textures, lights: lights.finish(), media }
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
        let shading = smooth_normal::<R>(shading, smooth, normal, ray.direction, glossy);
        Interaction {
            surfaces,
            textures,
            ray,
            shape,
            hit,
            surface,
            normal,
            shading,
            smooth,
            soft,
            front,
        }
    }
}
