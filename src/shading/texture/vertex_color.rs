//! The colours of meshes.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TextureParameters, TexturePoint};
use crate::checks::Location;
use crate::error::Result;
use crate::math::Real;
use crate::shading::Images;

/// The colours at the vertices of a mesh, interpolated. Surfaces without colours are white.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexColor {}

impl TextureParameters for VertexColor {
    fn uses_vertex_colors(&self) -> bool {
        true
    }

    fn load(&mut self, _: &Location<'_>, _: &mut Images<'_>) -> Result<()> {
        Ok(())
    }

    fn identity(&self) -> Value {
        json!({ "vertex_color": {} })
    }
}

impl TextureModel for VertexColor {
    type Entry = ();

    fn entry(&self) {}

    #[inline(never)]
    fn value<R: Real>(_: &[()], _: R::Word, at: &impl TexturePoint<R>) -> Rgba<R> {
        (at.vertex_color(), R::ONE)
    }
}
