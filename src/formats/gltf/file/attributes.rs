//! The attributes and the triangles of a part of a mesh, which may be compressed by Draco
//! (KHR_draco_mesh_compression).

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

use super::Gltf;
use super::document::{DracoMesh, Primitive};

/// The attributes of one part.
pub(crate) struct Attributes<'g, 'a> {
    gltf: &'g Gltf<'a>,
    primitive: &'g Primitive,
    draco: Option<(Mesh, &'g DracoMesh)>,
}

impl<'g, 'a> Attributes<'g, 'a> {
    /// Decompresses a part if necessary.
    pub(crate) fn new(gltf: &'g Gltf<'a>, primitive: &'g Primitive) -> Result<Self, String> {
        let draco = primitive.extensions.draco.as_ref();
        let draco =
            draco.map(|draco| Ok::<_, String>((decoded(gltf, draco)?, draco))).transpose()?;
        Ok(Self { gltf, primitive, draco })
    }

    /// The vectors of an attribute of N numbers each; `None` if the part lacks it.
    pub(crate) fn vectors<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<Vec<[f32; N]>>, String> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        let compressed = self.draco.as_ref().and_then(|(mesh, draco)| {
            Some((mesh, mesh.attribute_by_unique_id(*draco.attributes.get(name)?)?))
        });
        let Some((mesh, attribute)) = compressed else {
            return self.gltf.vectors(accessor).map(Some);
        };
        self.gltf.budget.hold(8 * N as u64 * mesh.num_points() as u64)?;
        let scale = self.gltf.scale(accessor)?;
        let numbers = attribute.read_f32s(mesh.num_points(), N);
        let (vectors, _) = numbers.as_chunks::<N>();
        let vectors: Vec<_> =
            vectors.iter().map(|vector| vector.map(|number| number * scale)).collect();
        match vectors.as_flattened().iter().all(|number| number.is_finite()) {
            true => Ok(Some(vectors)),
            false => Err(format!("{name} has numbers that are not finite")),
        }
    }

    /// Four unsigned integers of each vertex; `None` if the part lacks them.
    pub(crate) fn integers(&self, name: &str) -> Result<Option<Vec<[u32; 4]>>, String> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        let compressed =
            self.draco.as_ref().is_some_and(|(_, draco)| draco.attributes.contains_key(name));
        if compressed {
            let numbers = self.vectors::<4>(name)?.unwrap_or_default();
            return Ok(Some(
                numbers.into_iter().map(|all| all.map(|number| number as u32)).collect(),
            ));
        }
        self.gltf.integers(accessor).map(Some)
    }

    /// The indices of vertices and how they form triangles, the `mode` of the part. Without indices,
    /// there are those of all vertices up to `count`.
    pub(crate) fn indices(&self, count: usize) -> Result<(Vec<u32>, u32), String> {
        if let Some((mesh, _)) = &self.draco {
            self.gltf.budget.hold(24 * mesh.num_faces() as u64)?;
            let faces = mesh.faces().iter().flat_map(|face| face.iter().map(|corner| corner.0));
            return Ok((faces.collect(), 4));
        }
        let indices = match self.primitive.indices {
            None => (0..count as u32).collect(),
            Some(accessor) => {
                self.gltf.integers::<1>(accessor)?.into_iter().map(|[index]| index).collect()
            }
        };
        Ok((indices, self.primitive.mode.unwrap_or(4)))
    }
}

/// Decompresses a mesh.
fn decoded(gltf: &Gltf<'_>, draco: &DracoMesh) -> Result<Mesh, String> {
    let (bytes, _) = gltf.view(draco.buffer_view)?;
    // A decoder holds up to about four copies.
    let most = gltf.budget.room() / 4;
    let limits = DecodeLimits::default()
        .with_max_points(most / 12)
        .with_max_faces(most / 12)
        .with_max_decoded_bytes(most);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
    decoded.map_err(|error| format!("cannot decompress: {error}"))?;
    gltf.budget.hold(100 * mesh.num_points() as u64 + 12 * mesh.num_faces() as u64)?;
    Ok(mesh)
}
