//! The table of the materials of one kind, and operations on it.

use super::MaterialModel;
use crate::math::Row;
use crate::shading::TextureTables;

/// The materials of one kind.
#[derive(Debug)]
pub(crate) struct MaterialTable<E> {
    pub(crate) entries: Vec<E>,
    /// Whether any of them has a texture.
    pub(crate) textured: bool,
    /// For each of them, the code of its normal map; empty if none has one.
    pub(crate) normals: Vec<u32>,
    /// For each of them, the row of the texture of its light; empty if none has one.
    pub(crate) emission_rows: Vec<Row>,
}

impl<E> Default for MaterialTable<E> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            textured: false,
            normals: Vec::new(),
            emission_rows: Vec::new(),
        }
    }
}

impl<E> MaterialTable<E> {
    /// Adds a material and returns its index.
    pub(super) fn push<M: MaterialModel<Entry = E>>(
        &mut self,
        material: &M,
        textures: &mut TextureTables,
    ) -> u32 {
        let before = textures.uses();
        let index = self.entries.len();
        self.entries.push(material.entry(textures));
        let normal = textures.normal_code(material.normal());
        if normal != 0 || !self.normals.is_empty() {
            self.normals.resize(index, 0);
            self.normals.push(normal);
        }
        let emission = material.emission_texture();
        if emission.is_some() || !self.emission_rows.is_empty() {
            self.emission_rows.resize(index, [0; 4]);
            self.emission_rows.push(emission.map_or([0; 4], |texture| textures.row(texture)));
        }
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
