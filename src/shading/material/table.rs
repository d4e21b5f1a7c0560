//! The table of the materials of one kind, and operations on it.

use super::MaterialModel;
use crate::math::Row;
use crate::shading::{Bodies, TextureTables};

/// The materials of one kind.
#[derive(Debug)]
pub(crate) struct MaterialTable<E> {
    pub(crate) entries: Vec<E>,
    /// Whether any of them has a texture.
    pub(crate) textured: bool,
    /// For each of them, the code of its normal map; empty if none has one.
    pub(crate) normals: Vec<u32>,
    /// For each of them, the row of its light, if that varies; empty if no light does.
    pub(crate) emission_rows: Vec<Row>,
    /// For each of them, the code of the body that it encloses, or 0.
    pub(crate) bodies: Vec<u32>,
}

impl<E> Default for MaterialTable<E> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            textured: false,
            normals: Vec::new(),
            emission_rows: Vec::new(),
            bodies: Vec::new(),
        }
    }
}

impl<E> MaterialTable<E> {
    /// Adds a material and returns its index.
    pub(super) fn push<M: MaterialModel<Entry = E>>(
        &mut self,
        material: &M,
        textures: &mut TextureTables,
        bodies: &mut Bodies,
    ) -> u32 {
        let before = textures.uses();
        let index = self.entries.len();
        self.entries.push(material.entry(textures));
        let normal = textures.normal_code(material.normal());
        if normal != 0 || !self.normals.is_empty() {
            self.normals.resize(index, 0);
            self.normals.push(normal);
        }
        let emission = material.varied_emission().map(|(color, _)| color);
        if emission.is_some() || !self.emission_rows.is_empty() {
            self.emission_rows.resize(index, [0; 4]);
            self.emission_rows.push(emission.map_or([0; 4], |color| textures.row(color)));
        }
        self.bodies.push(bodies.code(material.absorption()));
        self.textured |= textures.uses() > before;
        assert!(
            M::TEXTURED || !self.textured,
            "a kind of material with a texture must set TEXTURED"
        );
        index as u32
    }
}

/// An operation on the table of any kind of material.
pub(crate) trait MaterialVisitor {
    /// Result of the operation.
    type Output;

    /// Runs the operation on the table of the kind `M`.
    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Self::Output;
}
