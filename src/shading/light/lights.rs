//! The lights of a scene, and how they are chosen.

use super::LightTables;
use super::alias::AliasTable;
use super::tree::LightTree;
use crate::math::Row;

/// Data of every light: (radiance, flags) and (chance of being chosen, index in the table of its
/// kind, primitive, 0). The radiance of lights that vary is the mean.
pub(super) type LightRows = [Row; 2];

/// Flag of lights that emit on their front side only.
pub(super) const FRONT_ONLY: u32 = 1;
/// Flag of lights that only light samples find.
pub(super) const UNSEEN: u32 = 2;
/// Flag of lights whose radiance varies, by a texture or by holes.
pub(super) const VARIES: u32 = 4;
/// The kind is in the bits above the flags.
pub(super) const KIND_SHIFT: u32 = 3;

/// The lights of a scene: those of primitives in their order, then those of the list of lights, then
/// the environment map.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    pub(super) rows: Vec<LightRows>,
    pub(super) tables: LightTables,
    pub(super) choice: Choice,
    /// Index of the environment map.
    pub(super) environment: Option<u32>,
    pub(super) has_unseen: bool,
    pub(super) has_varied: bool,
}

/// How a light is chosen.
#[derive(Debug, Default)]
pub(super) enum Choice {
    /// There is at most one light.
    #[default]
    Only,
    /// In proportion to the power.
    Power(AliasTable),
    /// With a tree over the lights inside the scene. Each of the others, whose indices follow, is as
    /// probable as the whole tree.
    Tree(LightTree, Vec<u32>),
}

impl Lights {
    /// Whether the scene has no lights.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of lights.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are lights whose radiance varies.
    #[inline(always)]
    pub(crate) fn has_varied(&self) -> bool {
        self.has_varied
    }

    /// Whether there are lights that only light samples find.
    #[inline(always)]
    pub(crate) fn has_unseen(&self) -> bool {
        self.has_unseen
    }
}
