//! Panes: thin, smooth glass, through which rays pass without a vertex.

use glam::Vec3;

use super::material::{MaterialModel, MaterialTable, MaterialVisitor};
use super::{Key, SceneTables};
use crate::geometry::{Hit, Ray, Shape};
use crate::math::{dot, max_element};

/// Most panes that a segment or a shadow ray passes. Beyond them, panes let no light through.
pub(crate) const MOST_PANES: u32 = 32;

/// A pane that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pane {
    /// The share of light that passes.
    pub(crate) transmittance: Vec3,
    /// Where the ray begins again beyond it.
    pub(crate) beyond: Vec3,
}

impl Pane {
    /// The probability with which paths pass. Those that do not are scattered by what else the surface does.
    pub(crate) fn chance(&self) -> f32 {
        max_element(self.transmittance)
    }
}

/// The part of a ray beyond the panes that it has passed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beyond {
    pub(crate) ray: Ray,
    /// Distance of its origin along the whole ray.
    pub(crate) begins: f32,
}

impl Beyond {
    /// All of a ray.
    pub(crate) fn all(ray: Ray) -> Self {
        Self { ray, begins: 0.0 }
    }

    /// The part of `whole` beyond a pane.
    pub(crate) fn new(whole: &Ray, pane: &Pane) -> Self {
        let ray = Ray { origin: pane.beyond, ..*whole };
        Self { ray, begins: dot(pane.beyond - whole.origin, whole.direction) }
    }

    /// The hit of the whole ray.
    pub(crate) fn whole(&self, hit: Hit) -> Hit {
        Hit { t: self.begins + hit.t, ..hit }
    }
}

/// Finds the pane that a ray meets.
struct Meet<'a>(&'a SceneTables, Shape, Ray, Hit);

impl MaterialVisitor for Meet<'_> {
    type Output = Pane;

    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Pane {
        let Self(tables, shape, ray, hit) = self;
        let instanced = shape == Shape::Instance;
        let mut at =
            tables.interaction::<f32>(shape, ray, hit, table.textured, M::GLOSSY, instanced);
        let entry = tables.looks.entries::<f32>(shape, hit.primitive, table.entries.len());
        if M::TEXTURED && table.textured {
            at.map_normals(table, entry, M::GLOSSY);
        }
        let transmittance = M::passes(&table.entries, entry, &at);
        Pane { transmittance, beyond: at.surface.spawn(-at.normal) }
    }
}

impl SceneTables {
    /// The pane at this hit of `ray`, if it is one.
    pub(crate) fn pane(&self, ray: &Ray, hit: Hit) -> Option<Pane> {
        let key = self.looks.keys()[usize::from(self.looks.key(hit.primitive))];
        let Key::Surface { shape, kind, pane: true, .. } = key else { return None };
        Some(self.materials.visit(kind, Meet(self, shape, *ray, hit)))
    }
}
