//! The colours of meshes.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TexturePoint};
use crate::checks::Location;
use crate::error::Result;
use crate::math::Real;
use crate::shading::images::Images;

/// The colours at the vertices of a mesh, interpolated. Surfaces without colours are white.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexColor {}

impl TextureModel for VertexColor {
    type Entry = ();

    const USES_VERTEX_COLORS: bool = true;

    fn load(&mut self, _: &Location<'_>, _: &mut Images<'_>) -> Result<()> {
        Ok(())
    }

    fn identity(&self) -> Value {
        json!({ "vertex_color": {} })
    }

    fn entry(&self) {}

    #[inline(never)]
    fn value<R: Real>(_: &[()], _: R::Word, at: &impl TexturePoint<R>) -> Rgba<R> {
        (at.vertex_color(), R::ONE)
    }
}
