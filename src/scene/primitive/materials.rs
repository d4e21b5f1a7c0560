//! The materials of a scene while its primitives are expanded.

use std::collections::HashMap;

use crate::checks::Location;
use crate::error::{Result, suggestion};
use crate::shading::Material;

/// The materials of a scene, by name.
pub(crate) struct Materials<'a> {
    names: HashMap<&'a str, u32>,
    /// Whether each of them emits a constant light, so that its triangles become lights wherever instances place
    /// them. Light that varies is found by paths alone there, since each light takes much memory.
    pub(super) emits: Vec<bool>,
    /// Whether smooth meshes need tangents for any of them.
    pub(super) need_tangents: bool,
    /// Whether any of them uses the colours of vertices. Otherwise, they are not stored, and are not
    /// part of the scene's hash.
    pub(super) vertex_colors: bool,
}

impl<'a> Materials<'a> {
    /// `names` are the names of `materials`.
    pub(crate) fn new(names: impl Iterator<Item = &'a str>, materials: &[Material]) -> Self {
        Self {
            names: names.zip(0..).collect(),
            emits: materials
                .iter()
                .map(|material| material.emission().is_some_and(|emission| emission.emits()))
                .collect(),
            need_tangents: materials.iter().any(|material| material.model().needs_tangents()),
            vertex_colors: materials.iter().any(Material::uses_vertex_colors),
        }
    }

    /// Returns the index of the material called `name`.
    pub(crate) fn find(&self, e: &Location<'_>, name: &str) -> Result<u32> {
        self.names.get(name).copied().ok_or_else(|| {
            let known = suggestion(name, self.names.keys().copied());
            e.error(format!("unknown material `{name}`{known}"))
        })
    }
}

/// Ranges of triangles with the same material: one past the last triangle, and the material.
#[derive(Debug, Default)]
pub(crate) struct Ranges(pub(crate) Vec<(u32, u32)>);

impl Ranges {
    /// Sets the material of the triangles from the end of the last range up to `end`.
    pub(crate) fn cover(&mut self, end: usize, material: u32) {
        let (end, begin) = (end as u32, self.0.last().map_or(0, |&(end, _)| end));
        match self.0.last_mut() {
            Some((last, same)) if *same == material => *last = end,
            _ if end > begin => self.0.push((end, material)),
            _ => {}
        }
    }
}
