//! Files of glTF 2.0: the document, its buffers and the images in them (Khronos, *glTF 2.0
//! Specification*).

mod accessor;
mod attributes;
mod document;
mod meshopt;

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

pub(crate) use self::attributes::Attributes;
pub(crate) use self::document::{
    Animation, Camera, Document, Light, Material, Node, Primitive, TextureInfo,
};
use crate::error::{Error, Result};
use crate::input::{path_within, read_bytes};
use crate::limits::{Budget, Limit};

/// Bytes of memory for each object of the JSON: the largest, while a list of them grows.
const OBJECT: u64 = 2 * size_of::<Material>() as u64;
/// Bytes of memory for each byte of JSON, for text and numbers.
const JSON: u64 = 8;

/// The extensions that ptfast supports.
pub(crate) const SUPPORTED: [&str; 20] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// A file whose document is parsed and whose buffers are read.
#[derive(Debug)]
pub(crate) struct Gltf<'a> {
    pub(crate) document: Document,
    buffers: Vec<Vec<u8>>,
    /// The buffer views that were compressed.
    decoded: HashMap<usize, Vec<u8>>,
    pub(crate) budget: &'a Budget,
}

impl<'a> Gltf<'a> {
    /// Reads the document and the buffers of the file at `path`.
    ///
    /// # Errors
    /// If a file cannot be read, its content is wrong, an extension is required that ptfast lacks, or
    /// a limit is exceeded.
    pub(crate) fn read(path: &Path, budget: &'a Budget) -> Result<Self> {
        let name = path.display().to_string();
        let bad = |message: String| Error::input(&*name, "", message);
        let allow = |length| budget.check_file(Limit::MeshBytes, length);
        let bytes = read_bytes(path, allow)?;
        let (json, binary) = chunks(&bytes).map_err(bad)?;
        // Lists may stand for objects.
        let objects = memchr::memchr2_iter(b'{', b'[', json).count() as u64;
        let memory = OBJECT * objects + JSON * json.len() as u64;
        budget.hold(memory).map_err(bad)?;
        let json = json.strip_prefix("\u{feff}".as_bytes()).unwrap_or(json);
        let document: Document = serde_json::from_slice(json).map_err(|error| {
            let place = format!("{}:{}", error.line(), error.column());
            let message = error.to_string();
            Error::input(&*name, place, message.split(" at line ").next().unwrap_or_default())
        })?;
        if !document.asset.version.starts_with("2.") {
            let version = &document.asset.version;
            return Err(bad(format!("`asset.version` must be 2.0 or a later 2.x, is `{version}`")));
        }
        let known = |name: &str| SUPPORTED.contains(&name);
        let lacking = document.extensions_required.iter().find(|name| !known(name));
        if let Some(extension) = lacking {
            return Err(bad(format!(
                "requires the extension {extension}, which ptfast does not support"
            )));
        }
        let (buffers, decoded) = Default::default();
        let mut gltf = Self { document, buffers, decoded, budget };
        for i in 0..gltf.document.buffers.len() {
            let buffer = gltf.buffer(i, path, binary)?;
            let length = buffer.as_ref().map_or(0, |buffer| buffer.len() as u64);
            if buffer.is_some() && length < gltf.document.buffers[i].byte_length {
                return Err(bad(format!(
                    "the buffer {i} has {length} bytes, fewer than its byteLength"
                )));
            }
            budget.hold(length).map_err(bad)?;
            gltf.buffers.push(buffer.unwrap_or_default());
        }
        Ok(gltf)
    }

    /// Decompresses the buffer views of meshes. The reader of images does not need it.
    pub(crate) fn decompress(&mut self) -> Result<(), String> {
        for (i, view) in self.document.buffer_views.iter().enumerate() {
            if let Some(compressed) = &view.extensions.meshopt {
                let view = meshopt::decoded(self, compressed);
                let view = view.map_err(|message| format!("the buffer view {i}: {message}"))?;
                self.decoded.insert(i, view);
            }
        }
        Ok(())
    }

    /// The content of a buffer of the file at `path`. `None` for one without content, which only
    /// compressed views can use.
    fn buffer(&self, index: usize, path: &Path, binary: Option<&[u8]>) -> Result<Option<Vec<u8>>> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let place = format!("buffers[{index}]");
        let bad = |message: String| Error::input(path.display().to_string(), &*place, message);
        let budget = &self.budget;
        let allow = |length| budget.check_file(Limit::MeshBytes, length);
        match &self.document.buffers[index].uri {
            None => match binary {
                Some(binary) if index == 0 => {
                    allow(binary.len() as u64).map_err(bad)?;
                    Ok(Some(binary.to_vec()))
                }
                _ => Ok(None),
            },
            Some(uri) => match data(uri) {
                Some(data) => data.map(Some).map_err(bad),
                None => {
                    let path = path_within(folder, &unescaped(uri), &budget.limits)?;
                    read_bytes(&path, allow).map(Some)
                }
            },
        }
    }

    /// The file of the image with this number; `None` if it is within this file.
    pub(crate) fn image_file(&self, index: usize) -> Result<Option<String>, String> {
        let image = self.document.images.get(index);
        let image = image.ok_or_else(|| format!("unknown image {index}"))?;
        let external = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
        Ok(external.map(|uri| unescaped(uri)))
    }

    /// The content of the image with this number, which is within this file.
    pub(crate) fn image(&self, index: usize) -> Result<Cow<'_, [u8]>, String> {
        if let Some(file) = self.image_file(index)? {
            return Err(format!("image {index} is in the file {file}"));
        }
        let image = &self.document.images[index];
        match (image.uri.as_deref().and_then(data), image.buffer_view) {
            (Some(data), _) => data.map(Cow::Owned),
            (None, Some(view)) => Ok(self.view(view)?.0.into()),
            (None, None) => Err(format!("the image {index} has neither data nor a buffer view")),
        }
    }
}

/// The JSON and the binary chunk of a file in either of the two forms.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let number = |bytes: &[u8], at: usize| {
        let number = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(number.try_into().ok()?))
    };
    if number(rest, 0) != Some(2) {
        return Err("the version of the container must be 2".to_owned());
    }
    let mut rest = rest.get(8..).unwrap_or_default();
    let (mut json, mut binary) = (None, None);
    while let (Some(length), Some(kind)) = (number(rest, 0), number(rest, 4)) {
        let end = 8usize.checked_add(length as usize);
        let chunk = end.and_then(|end| rest.get(8..end));
        let chunk = chunk.ok_or("a chunk exceeds the file")?;
        match &kind.to_le_bytes() {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => binary = binary.or(Some(chunk)),
            _ => {}
        }
        rest = &rest[8 + chunk.len()..];
    }
    json.map(|json| (json, binary)).ok_or_else(|| "the file has no JSON chunk".to_owned())
}

/// The data in a data URI; `None` if `uri` is another one.
fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let (_, text) = uri.strip_prefix("data:")?.split_once(";base64,")?;
    // Some exporters leave out the padding.
    let padding =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let decoded = GeneralPurpose::new(&STANDARD, padding).decode(text);
    Some(decoded.map_err(|error| format!("wrong base64 data: {error}")))
}

/// A relative URI as a path: `%20` becomes a blank.
fn unescaped(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        let code =
            code.filter(|_| *first == b'%').and_then(|code| u8::from_str_radix(code, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_owned())
}
