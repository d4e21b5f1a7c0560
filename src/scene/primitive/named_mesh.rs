//! Meshes that instances place.

use std::fmt;

use serde::de::value::{SeqAccessDeserializer, StrDeserializer};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{InstanceFile, MeshFile, PrimitiveFile, TrianglesFile};

/// A mesh with a name: the path of a file, or a list of parts.
///
/// A part is `triangles`, `mesh`, or an `instance` of another named mesh. Instances of a file must name
/// a material, unless it is an OBJ file that names materials of the scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NamedMesh {
    /// Path of an OBJ or PLY file, or of a part of a glTF or pbrt file, as in
    /// [`MeshFile::file`](super::MeshFile::file).
    File(String),
    /// The parts.
    Parts(Vec<PrimitiveFile>),
}

impl From<String> for NamedMesh {
    fn from(file: String) -> Self {
        Self::File(file)
    }
}

impl From<&str> for NamedMesh {
    fn from(file: &str) -> Self {
        Self::File(file.to_owned())
    }
}

impl From<Vec<PrimitiveFile>> for NamedMesh {
    fn from(parts: Vec<PrimitiveFile>) -> Self {
        Self::Parts(parts)
    }
}

macro_rules! from_part {
    ($($part:ident,)*) => {
        $(impl From<$part> for NamedMesh {
            fn from(part: $part) -> Self {
                Self::Parts(vec![part.into()])
            }
        })*
    };
}

from_part! { TrianglesFile, MeshFile, InstanceFile, }

impl Serialize for NamedMesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(file) => file.serialize(serializer),
            Self::Parts(parts) => parts.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for NamedMesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FileOrParts;

        impl<'de> Visitor<'de> for FileOrParts {
            type Value = NamedMesh;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the path of a mesh file, or a list of parts")
            }

            fn visit_str<E: Error>(self, file: &str) -> Result<NamedMesh, E> {
                String::deserialize(StrDeserializer::new(file)).map(NamedMesh::File)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, parts: A) -> Result<NamedMesh, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(parts)).map(NamedMesh::Parts)
            }
        }

        deserializer.deserialize_any(FileOrParts)
    }
}
