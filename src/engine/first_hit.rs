//! The surface or medium that a path meets first, for both engines.

use glam::DVec3;

use crate::geometry::Shape;
use crate::math::{Real, Vector, Word};
use crate::scene::Scene;
use crate::shading::material::Bsdf;
use crate::shading::{CameraFrame, Interaction};

/// The first hit of a path, or one per lane.
pub(super) struct FirstHit<'a, R: Real> {
    /// Whether there is one.
    pub(super) exists: bool,
    /// Whether the camera ray meets something.
    pub(super) covers: bool,
    /// The point of a surface, with the scene that its material belongs to.
    pub(super) at: Option<&'a Interaction<'a, R>>,
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
    pub(super) fn in_medium(
        scene: &Scene,
        camera: &CameraFrame,
        point: R::Vec3,
        albedo: R::Vec3,
    ) -> Self {
        let depth = camera.depth::<R>(point);
        Self { position: in_file(scene, point), depth, albedo, ..Self::anything() }
    }

    /// That of a path that meets a surface at this point, where it has this BSDF.
    #[inline(always)]
    pub(super) fn on_surface(
        scene: &'a Scene,
        camera: &CameraFrame,
        at: &'a Interaction<'a, R>,
        bsdf: &impl Bsdf<R>,
    ) -> Self {
        let point = at.surface.point;
        let albedo = bsdf.albedo();
        let least = |i: usize| albedo[i].least(R::ONE);
        let number = |instance: R::Word| instance.wrapping_add(R::Word::splat(1));
        Self {
            at: Some(at),
            scene: Some(scene),
            position: in_file(scene, point),
            depth: camera.depth::<R>(point),
            normal: at.normals.shading,
            albedo: R::Vec3::new(least(0), least(1), least(2)),
            instance: match at.shape {
                Shape::Instance => number(at.hit.instance),
                _ => R::Word::splat(0),
            },
            ..Self::anything()
        }
    }

    /// Number of the material, from 1; 0 if there is none.
    pub(super) fn material(&self) -> R::Word {
        let (Some(at), Some(scene)) = (self.at, self.scene) else { return R::Word::splat(0) };
        R::each_word(at.hit.primitive, |primitive| scene.material_number(primitive) + 1)
    }
}

/// A point of the scene in the coordinates of its file.
#[inline(always)]
fn in_file<V: Vector>(scene: &Scene, point: V) -> V {
    let origin = scene.origin();
    if origin == DVec3::ZERO {
        return point;
    }
    let [x, y, z] = origin.as_vec3().to_array().map(V::Real::splat);
    point + V::new(x, y, z)
}
