//! The surface or medium that a path meets first, for both engines.

use crate::geometry::{Hit, Ray, Shape};
use crate::math::{Real, Vector, Word};
use crate::scene::Scene;
use crate::shading::material::{Bsdf, MaterialModel, MaterialTable};
use crate::shading::{CameraFrame, Interaction, SceneTables};

/// The first hit of a path, or one per lane.
pub(super) struct FirstHit<'a, R: Real> {
    /// Whether there is one.
    pub(super) exists: bool,
    /// Whether the camera ray meets something.
    pub(super) covers: bool,
    /// The point of a surface, with the scene that its material belongs to.
    pub(super) at: Option<Interaction<'a, R>>,
    scene: Option<&'a Scene>,
    pub(super) position: R::Vec3,
    /// Distance from the camera along the direction of view.
    pub(super) depth: R,
    /// Shading normal.
    pub(super) normal: R::Vec3,
    pub(super) albedo: R::Vec3,
    /// Number of the instance, from 1; 0 if there is none.
    pub(super) instance: R::Word,
}

impl<'a, R: Real> FirstHit<'a, R> {
    /// That of a path whose segment number `segment` leaves the scene.
    pub(super) fn none(segment: u32) -> Self {
        let (position, depth, zero) = (R::Vec3::zero(), R::ZERO, R::Vec3::zero());
        let instance = R::Word::splat(0);
        let (at, scene) = (None, None);
        Self {
            exists: false,
            covers: segment > 1,
            at,
            scene,
            position,
            depth,
            normal: zero,
            albedo: zero,
            instance,
        }
    }

    /// One of which nothing else is needed.
    pub(super) fn anything() -> Self {
        Self { exists: true, covers: true, ..Self::none(1) }
    }

    /// That of a path that collides at `position` in a medium.
    pub(super) fn in_medium(camera: &CameraFrame, position: R::Vec3, albedo: R::Vec3) -> Self {
        let depth = camera.depth::<R>(position);
        Self { position, depth, albedo, ..Self::anything() }
    }

    /// That of a ray with this hit of a surface whose material is in `table`. Also returns whether the material
    /// is a smooth mirror or clear glass there. Without `needs_bsdf`, the albedo is 0 and nothing is specular.
    #[inline(always)]
    pub(super) fn on_surface<M: MaterialModel>(
        (scene, tables, camera): (&'a Scene, &'a SceneTables, &CameraFrame),
        (shape, ray, hit): (Shape, Ray<R>, Hit<R>),
        table: &MaterialTable<M::Entry>,
        needs_bsdf: bool,
    ) -> (Self, R::Mask) {
        let instanced = shape == Shape::Instance;
        let mut at = tables.interaction::<R>(shape, ray, hit, table.textured, M::GLOSSY, instanced);
        let entry = tables.looks.entries::<R>(shape, hit.primitive, table.entries.len());
        if M::TEXTURED && table.textured {
            at.map_normals(table, entry, M::GLOSSY);
        }
        let (albedo, specular) = match needs_bsdf {
            true => {
                let bsdf = M::bsdf::<R>(&table.entries, entry, &at);
                (bsdf.albedo(), bsdf.specular())
            }
            false => (R::Vec3::zero(), R::ZERO.lt(R::ZERO)),
        };
        let least = |c: R| c.least(R::ONE);
        let position = at.surface.point;
        let first = R::Word::splat(u32::from(instanced));
        let found = Self {
            exists: true,
            covers: true,
            at: Some(at),
            scene: Some(scene),
            position,
            depth: camera.depth::<R>(position),
            normal: at.shading,
            albedo: R::Vec3::new(least(albedo[0]), least(albedo[1]), least(albedo[2])),
            instance: if instanced { hit.instance.wrapping_add(first) } else { first },
        };
        (found, specular)
    }

    /// Number of the material, from 1; 0 if there is none.
    pub(super) fn material(&self) -> R::Word {
        let (Some(at), Some(scene)) = (&self.at, self.scene) else { return R::Word::splat(0) };
        R::each_word(at.hit.primitive, |primitive| scene.material_number(primitive) + 1)
    }
}
