//! The JSON of glTF 2.0 files, as far as ptfast reads it (Khronos, *glTF 2.0 Specification*, chapter 5).
//!
//! Indices are checked where they are used.

use std::collections::HashMap;

use serde::Deserialize;

/// The whole document.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Document {
    pub(super) asset: Asset,
    pub(in crate::scene) scene: Option<usize>,
    pub(in crate::scene) scenes: Vec<SceneNodes>,
    pub(in crate::scene) nodes: Vec<Node>,
    pub(in crate::scene) meshes: Vec<Mesh>,
    pub(in crate::scene) materials: Vec<Material>,
    pub(in crate::scene) textures: Vec<Texture>,
    pub(in crate::scene) images: Vec<Image>,
    pub(in crate::scene) samplers: Vec<Sampler>,
    pub(in crate::scene) cameras: Vec<Camera>,
    pub(in crate::scene) skins: Vec<Skin>,
    pub(in crate::scene) animations: Vec<Animation>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<BufferView>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) extensions_required: Vec<String>,
    pub(in crate::scene) extensions_used: Vec<String>,
    pub(in crate::scene) extensions: Extensions,
}

/// What the document says of itself.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Asset {
    pub(super) version: String,
}

/// The extensions of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Extensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(in crate::scene) lights: Lights,
    #[serde(rename = "KHR_materials_variants")]
    pub(in crate::scene) variants: Variants,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Lights {
    pub(in crate::scene) lights: Vec<Light>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Variants {
    pub(in crate::scene) variants: Vec<Variant>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Variant {
    pub(in crate::scene) name: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct SceneNodes {
    pub(in crate::scene) nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Node {
    pub(in crate::scene) name: Option<String>,
    pub(in crate::scene) children: Vec<usize>,
    pub(in crate::scene) mesh: Option<usize>,
    pub(in crate::scene) camera: Option<usize>,
    pub(in crate::scene) skin: Option<usize>,
    pub(in crate::scene) matrix: Option<[f64; 16]>,
    pub(in crate::scene) translation: Option<[f64; 3]>,
    /// A quaternion with the scalar last.
    pub(in crate::scene) rotation: Option<[f64; 4]>,
    pub(in crate::scene) scale: Option<[f64; 3]>,
    pub(in crate::scene) weights: Option<Vec<f64>>,
    pub(in crate::scene) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(in crate::scene) light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(in crate::scene) instances: Option<NodeInstances>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct NodeLight {
    pub(in crate::scene) light: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct NodeInstances {
    pub(in crate::scene) attributes: HashMap<String, usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Mesh {
    pub(in crate::scene) name: Option<String>,
    pub(in crate::scene) primitives: Vec<Primitive>,
    pub(in crate::scene) weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Primitive {
    pub(in crate::scene) attributes: HashMap<String, usize>,
    pub(in crate::scene) indices: Option<usize>,
    pub(in crate::scene) material: Option<usize>,
    pub(in crate::scene) mode: Option<u32>,
    #[serde(default)]
    pub(in crate::scene) targets: Vec<HashMap<String, usize>>,
    #[serde(default)]
    pub(in crate::scene) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct PrimitiveExtensions {
    #[serde(rename = "KHR_materials_variants")]
    pub(in crate::scene) variants: VariantMappings,
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<DracoMesh>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DracoMesh {
    pub(super) buffer_view: usize,
    /// The ids of attributes in the compressed mesh.
    pub(super) attributes: HashMap<String, u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct VariantMappings {
    pub(in crate::scene) mappings: Vec<VariantMapping>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct VariantMapping {
    pub(in crate::scene) material: usize,
    pub(in crate::scene) variants: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Material {
    pub(in crate::scene) name: Option<String>,
    pub(in crate::scene) pbr_metallic_roughness: MetallicRoughness,
    pub(in crate::scene) normal_texture: Option<TextureInfo>,
    pub(in crate::scene) emissive_texture: Option<TextureInfo>,
    pub(in crate::scene) emissive_factor: [f64; 3],
    alpha_mode: Option<String>,
    pub(in crate::scene) alpha_cutoff: Option<f64>,
    pub(in crate::scene) extensions: MaterialExtensions,
}

impl Material {
    /// `OPAQUE`, `MASK` or `BLEND`.
    pub(in crate::scene) fn alpha_mode(&self) -> &str {
        self.alpha_mode.as_deref().unwrap_or("OPAQUE")
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct MetallicRoughness {
    pub(in crate::scene) base_color_factor: Option<[f64; 4]>,
    pub(in crate::scene) base_color_texture: Option<TextureInfo>,
    pub(in crate::scene) metallic_factor: Option<f64>,
    pub(in crate::scene) roughness_factor: Option<f64>,
    pub(in crate::scene) metallic_roughness_texture: Option<TextureInfo>,
}

/// A texture of a material. Normal maps may have a `scale`.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::scene) struct TextureInfo {
    pub(in crate::scene) index: usize,
    #[serde(default)]
    pub(in crate::scene) tex_coord: u32,
    pub(in crate::scene) scale: Option<f64>,
    #[serde(default)]
    pub(in crate::scene) extensions: TextureInfoExtensions,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(in crate::scene) transform: Option<TextureTransform>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct TextureTransform {
    pub(in crate::scene) offset: [f64; 2],
    /// In radians.
    pub(in crate::scene) rotation: f64,
    pub(in crate::scene) scale: Option<[f64; 2]>,
    pub(in crate::scene) tex_coord: Option<u32>,
}

/// The extensions of materials that ptfast supports. Names are those of the extensions without
/// `KHR_materials_`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(in crate::scene) emissive_strength: EmissiveStrength,
    #[serde(rename = "KHR_materials_transmission")]
    pub(in crate::scene) transmission: Transmission,
    #[serde(rename = "KHR_materials_ior")]
    pub(in crate::scene) ior: Ior,
    #[serde(rename = "KHR_materials_volume")]
    pub(in crate::scene) volume: Volume,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(in crate::scene) clearcoat: Clearcoat,
    #[serde(rename = "KHR_materials_specular")]
    pub(in crate::scene) specular: Specular,
    #[serde(rename = "KHR_materials_unlit")]
    pub(in crate::scene) unlit: Option<Present>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(in crate::scene) specular_glossiness: Option<Present>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct EmissiveStrength {
    pub(in crate::scene) emissive_strength: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Transmission {
    pub(in crate::scene) transmission_factor: f64,
    pub(in crate::scene) transmission_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Ior {
    pub(in crate::scene) ior: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Volume {
    pub(in crate::scene) thickness_factor: f64,
    pub(in crate::scene) attenuation_distance: Option<f64>,
    pub(in crate::scene) attenuation_color: Option<[f64; 3]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Clearcoat {
    pub(in crate::scene) clearcoat_factor: f64,
    pub(in crate::scene) clearcoat_texture: Option<TextureInfo>,
    pub(in crate::scene) clearcoat_roughness_factor: f64,
    pub(in crate::scene) clearcoat_roughness_texture: Option<TextureInfo>,
    pub(in crate::scene) clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Specular {
    pub(in crate::scene) specular_factor: Option<f64>,
    pub(in crate::scene) specular_texture: Option<TextureInfo>,
    pub(in crate::scene) specular_color_factor: Option<[f64; 3]>,
    pub(in crate::scene) specular_color_texture: Option<TextureInfo>,
}

/// An extension whose content does not matter.
#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Present {}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Texture {
    pub(in crate::scene) source: Option<usize>,
    pub(in crate::scene) sampler: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Image {
    pub(in crate::scene) uri: Option<String>,
    pub(in crate::scene) buffer_view: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Sampler {
    pub(in crate::scene) mag_filter: Option<u32>,
    pub(in crate::scene) wrap_s: Option<u32>,
    pub(in crate::scene) wrap_t: Option<u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Camera {
    pub(in crate::scene) name: Option<String>,
    pub(in crate::scene) perspective: Option<Perspective>,
    pub(in crate::scene) orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::scene) struct Perspective {
    /// Full vertical angle of view in radians.
    pub(in crate::scene) yfov: f64,
    pub(in crate::scene) aspect_ratio: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Orthographic {
    /// Half the width.
    pub(in crate::scene) xmag: f64,
    /// Half the height.
    pub(in crate::scene) ymag: f64,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Light {
    #[serde(rename = "type")]
    pub(in crate::scene) kind: String,
    #[serde(default = "white")]
    pub(in crate::scene) color: [f64; 3],
    #[serde(default = "one")]
    pub(in crate::scene) intensity: f64,
    #[serde(default)]
    pub(in crate::scene) spot: Spot,
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Spot {
    pub(in crate::scene) inner_cone_angle: f64,
    pub(in crate::scene) outer_cone_angle: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::scene) struct Skin {
    pub(in crate::scene) joints: Vec<usize>,
    pub(in crate::scene) inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::scene) struct Animation {
    pub(in crate::scene) name: Option<String>,
    pub(in crate::scene) channels: Vec<Channel>,
    pub(in crate::scene) samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Channel {
    pub(in crate::scene) sampler: usize,
    pub(in crate::scene) target: Target,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct Target {
    pub(in crate::scene) node: Option<usize>,
    pub(in crate::scene) path: String,
}

#[derive(Debug, Deserialize)]
pub(in crate::scene) struct AnimationSampler {
    pub(in crate::scene) input: usize,
    pub(in crate::scene) output: usize,
    pub(in crate::scene) interpolation: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    /// The type of the numbers; only `indices` have it.
    #[serde(default)]
    pub(super) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
    #[serde(default)]
    pub(super) extensions: BufferViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<MeshoptView>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MeshoptView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: u64,
    pub(super) count: u64,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: u64,
}
