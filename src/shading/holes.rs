//! Marks the triangles of a scene that may have holes, and finds the holes.

use std::any::Any;
use std::sync::Arc;

use glam::Vec3;

use super::{Material, MaterialMap, Opacity, TexturePoint, TextureTables};
use crate::geometry::{Geometry, HoleTest, Holes, Ray, Triangles};
use crate::math::mix32;
use crate::math::random::unit_interval;

/// The opacity of a material, in the form of tables.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The words of alpha.
    alpha: [f32; 2],
    /// The threshold of a mask, or `None` for a blend.
    threshold: Option<f32>,
}

/// The opacities of a scene's materials.
#[derive(Debug)]
struct MaterialHoles {
    /// One for each material.
    opacities: Vec<Option<Opacity>>,
    /// The tables of the opacities.
    entries: Vec<Option<Entry>>,
    textures: TextureTables,
    map: Arc<MaterialMap>,
    /// The number of the first triangle.
    first: u32,
}

impl MaterialHoles {
    fn new(materials: &[Material], map: &Arc<MaterialMap>, first: u32) -> Self {
        let mut textures = TextureTables::default();
        let mut entry = |opacity: &Opacity| Entry {
            alpha: textures.number(opacity.alpha()).map(f32::from_bits),
            threshold: match *opacity {
                Opacity::Mask { threshold, .. } => Some(threshold),
                Opacity::Blend { .. } => None,
            },
        };
        let opacities = || materials.iter().map(|material| material.model().opacity());
        let entries = opacities().map(|opacity| opacity.map(&mut entry)).collect();
        let opacities = opacities().map(Option::<&Opacity>::cloned).collect();
        Self { opacities, entries, textures, map: Arc::clone(map), first }
    }

    /// The opacity of a triangle's material.
    fn entry(&self, triangle: u32) -> Option<Entry> {
        self.entries[self.map.get(self.first + triangle) as usize]
    }
}

/// Marks the triangles of `geometry` whose materials have holes.
pub(crate) fn mark_holes(geometry: &mut Geometry, materials: &[Material], map: &MaterialMap) {
    if materials.iter().all(|material| material.model().opacity().is_none()) {
        return;
    }
    let map = Arc::new(map.clone());
    let holes = |first: usize, count: usize| {
        let test = Arc::new(MaterialHoles::new(materials, &map, first as u32));
        let has_holes = |triangle: usize| test.entry(triangle as u32).is_some();
        Holes::new(count, has_holes, Arc::clone(&test) as Arc<dyn HoleTest>)
    };
    let (first, own, all) = (geometry.first_triangle(), geometry.triangles.len(), geometry.len());
    geometry.holes = holes(first, own);
    let placed = geometry.instances.triangle_count();
    geometry.instances.set_holes(holes(all, placed));
}

/// A point of a triangle.
#[derive(Clone, Copy)]
struct Point<'a> {
    triangles: &'a Triangles,
    triangle: u32,
    ray: &'a Ray,
    t: f32,
}

impl TexturePoint<f32> for Point<'_> {
    fn point(&self) -> Vec3 {
        self.ray.origin + self.ray.direction * self.t
    }

    fn uv(&self) -> (f32, f32) {
        self.triangles.uv(self.triangle, self.ray, self.t)
    }

    fn second_uv(&self) -> (f32, f32) {
        self.triangles.second_uv(self.triangle, self.ray, self.t)
    }

    fn vertex_color(&self) -> Vec3 {
        self.triangles.color(self.triangle, self.ray, self.t)
    }
}

impl HoleTest for MaterialHoles {
    fn is_hole(
        &self,
        triangles: &Triangles,
        triangle: u32,
        instance: u32,
        ray: &Ray,
        t: f32,
    ) -> bool {
        let Some(Entry { alpha, threshold }) = self.entry(triangle) else { return false };
        let point = Point { triangles, triangle, ray, t };
        let alpha = self.textures.number_at::<f32>(alpha, &point);
        match threshold {
            Some(threshold) => alpha < threshold,
            None => chance(ray, instance, triangle) >= alpha,
        }
    }

    fn equals(&self, other: &dyn HoleTest) -> bool {
        let Some(other) = (other as &dyn Any).downcast_ref::<Self>() else { return false };
        // The tables follow from the opacities.
        let Self { opacities, entries: _, textures: _, map, first } = self;
        (opacities, map, first) == (&other.opacities, &other.map, &other.first)
    }
}

/// A random number in [0, 1) for a ray and a triangle. It is a hash of the ray, so that replayed rays
/// have the same hits.
fn chance(ray: &Ray, instance: u32, triangle: u32) -> f32 {
    let numbers = [ray.origin, ray.direction].map(|v| v.to_array().map(f32::to_bits));
    let words = numbers.as_flattened().iter().chain([&instance, &triangle]);
    unit_interval(words.fold(0, |hash: u32, &word| mix32(hash.wrapping_add(word))))
}
