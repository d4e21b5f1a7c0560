//! The JSON of glTF 2.0 files, as far as ptfast reads it (Khronos, *glTF 2.0 Specification*, chapter 5).
//!
//! Indices are checked where they are used.

use std::collections::HashMap;

use serde::Deserialize;

/// The whole document.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Document {
    pub(crate) asset: Asset,
    pub(crate) scene: Option<usize>,
    pub(crate) scenes: Vec<SceneNodes>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) images: Vec<Image>,
    pub(crate) samplers: Vec<Sampler>,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) skins: Vec<Skin>,
    pub(crate) animations: Vec<Animation>,
    pub(crate) accessors: Vec<Accessor>,
    pub(crate) buffer_views: Vec<BufferView>,
    pub(crate) buffers: Vec<Buffer>,
    pub(crate) extensions_required: Vec<String>,
    pub(crate) extensions_used: Vec<String>,
    pub(crate) extensions: Extensions,
}

/// What the document says of itself.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Asset {
    pub(crate) version: String,
    pub(crate) generator: Option<String>,
}

/// The extensions of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Extensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) lights: Lights,
    #[serde(rename = "KHR_materials_variants")]
    pub(crate) variants: Variants,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Lights {
    pub(crate) lights: Vec<Light>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Variants {
    pub(crate) variants: Vec<Variant>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Variant {
    pub(crate) name: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct SceneNodes {
    pub(crate) nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Node {
    pub(crate) name: Option<String>,
    pub(crate) children: Vec<usize>,
    pub(crate) mesh: Option<usize>,
    pub(crate) camera: Option<usize>,
    pub(crate) skin: Option<usize>,
    pub(crate) matrix: Option<[f64; 16]>,
    pub(crate) translation: Option<[f64; 3]>,
    /// A quaternion with the scalar last.
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    pub(crate) weights: Option<Vec<f64>>,
    pub(crate) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(crate) instances: Option<NodeInstances>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct NodeLight {
    pub(crate) light: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct NodeInstances {
    pub(crate) attributes: HashMap<String, usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Mesh {
    pub(crate) name: Option<String>,
    pub(crate) primitives: Vec<Primitive>,
    pub(crate) weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Primitive {
    pub(crate) attributes: HashMap<String, usize>,
    pub(crate) indices: Option<usize>,
    pub(crate) material: Option<usize>,
    pub(crate) mode: Option<u32>,
    #[serde(default)]
    pub(crate) targets: Vec<HashMap<String, usize>>,
    #[serde(default)]
    pub(crate) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct PrimitiveExtensions {
    #[serde(rename = "KHR_materials_variants")]
    pub(crate) variants: VariantMappings,
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(crate) draco: Option<DracoMesh>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct DracoMesh {
    pub(crate) buffer_view: usize,
    /// The ids of attributes in the compressed mesh.
    pub(crate) attributes: HashMap<String, u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct VariantMappings {
    pub(crate) mappings: Vec<VariantMapping>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct VariantMapping {
    pub(crate) material: usize,
    pub(crate) variants: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub(crate) name: Option<String>,
    pub(crate) pbr_metallic_roughness: MetallicRoughness,
    pub(crate) normal_texture: Option<TextureInfo>,
    pub(crate) emissive_texture: Option<TextureInfo>,
    pub(crate) emissive_factor: [f64; 3],
    alpha_mode: Option<String>,
    pub(crate) alpha_cutoff: Option<f64>,
    pub(crate) extensions: MaterialExtensions,
}

impl Material {
    /// `OPAQUE`, `MASK` or `BLEND`.
    pub(crate) fn alpha_mode(&self) -> &str {
        self.alpha_mode.as_deref().unwrap_or("OPAQUE")
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct MetallicRoughness {
    pub(crate) base_color_factor: Option<[f64; 4]>,
    pub(crate) base_color_texture: Option<TextureInfo>,
    pub(crate) metallic_factor: Option<f64>,
    pub(crate) roughness_factor: Option<f64>,
    pub(crate) metallic_roughness_texture: Option<TextureInfo>,
}

/// A texture of a material. Normal maps may have a `scale`.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: usize,
    #[serde(default)]
    pub(crate) tex_coord: u32,
    pub(crate) scale: Option<f64>,
    #[serde(default)]
    pub(crate) extensions: TextureInfoExtensions,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(crate) transform: Option<TextureTransform>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub(crate) offset: [f64; 2],
    /// In radians.
    pub(crate) rotation: f64,
    pub(crate) scale: Option<[f64; 2]>,
    pub(crate) tex_coord: Option<u32>,
}

/// The extensions of materials that ptfast supports. Names are those of the extensions without
/// `KHR_materials_`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: EmissiveStrength,
    #[serde(rename = "KHR_materials_transmission")]
    pub(crate) transmission: Transmission,
    #[serde(rename = "KHR_materials_ior")]
    pub(crate) ior: Ior,
    #[serde(rename = "KHR_materials_volume")]
    pub(crate) volume: Volume,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(crate) clearcoat: Clearcoat,
    #[serde(rename = "KHR_materials_specular")]
    pub(crate) specular: Specular,
    #[serde(rename = "KHR_materials_sheen")]
    pub(crate) sheen: Sheen,
    #[serde(rename = "KHR_materials_anisotropy")]
    pub(crate) anisotropy: Anisotropy,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    pub(crate) diffuse_transmission: DiffuseTransmission,
    #[serde(rename = "KHR_materials_unlit")]
    pub(crate) unlit: Option<Present>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(crate) specular_glossiness: Option<Present>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct EmissiveStrength {
    pub(crate) emissive_strength: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Transmission {
    pub(crate) transmission_factor: f64,
    pub(crate) transmission_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Ior {
    pub(crate) ior: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Volume {
    pub(crate) thickness_factor: f64,
    pub(crate) attenuation_distance: Option<f64>,
    pub(crate) attenuation_color: Option<[f64; 3]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Clearcoat {
    pub(crate) clearcoat_factor: f64,
    pub(crate) clearcoat_texture: Option<TextureInfo>,
    pub(crate) clearcoat_roughness_factor: f64,
    pub(crate) clearcoat_roughness_texture: Option<TextureInfo>,
    pub(crate) clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Specular {
    pub(crate) specular_factor: Option<f64>,
    pub(crate) specular_texture: Option<TextureInfo>,
    pub(crate) specular_color_factor: Option<[f64; 3]>,
    pub(crate) specular_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Sheen {
    pub(crate) sheen_color_factor: [f64; 3],
    pub(crate) sheen_color_texture: Option<TextureInfo>,
    pub(crate) sheen_roughness_factor: f64,
    pub(crate) sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Anisotropy {
    pub(crate) anisotropy_strength: f64,
    /// In radians.
    pub(crate) anisotropy_rotation: f64,
    pub(crate) anisotropy_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct DiffuseTransmission {
    pub(crate) diffuse_transmission_factor: f64,
    pub(crate) diffuse_transmission_texture: Option<TextureInfo>,
    pub(crate) diffuse_transmission_color_factor: Option<[f64; 3]>,
    pub(crate) diffuse_transmission_color_texture: Option<TextureInfo>,
}

/// An extension whose content does not matter.
#[derive(Debug, Deserialize)]
pub(crate) struct Present {}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Texture {
    source: Option<usize>,
    pub(crate) sampler: Option<usize>,
    extensions: TextureExtensions,
}

/// Images in other formats, which replace that of the texture.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: TextureSource,
    #[serde(rename = "KHR_texture_basisu")]
    ktx2: TextureSource,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct TextureSource {
    source: Option<usize>,
}

impl Texture {
    /// The number of the image that ptfast can read.
    pub(crate) fn image(&self) -> Option<usize> {
        // Beside an image in KTX2, a PNG or JPEG file has lost less.
        self.extensions.webp.source.or(self.source).or(self.extensions.ktx2.source)
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Image {
    pub(crate) uri: Option<String>,
    pub(crate) buffer_view: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Sampler {
    pub(crate) mag_filter: Option<u32>,
    pub(crate) wrap_s: Option<u32>,
    pub(crate) wrap_t: Option<u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Camera {
    pub(crate) name: Option<String>,
    pub(crate) perspective: Option<Perspective>,
    pub(crate) orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Perspective {
    /// Full vertical angle of view in radians.
    pub(crate) yfov: f64,
    pub(crate) aspect_ratio: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Orthographic {
    /// Half the width.
    pub(crate) xmag: f64,
    /// Half the height.
    pub(crate) ymag: f64,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Light {
    #[serde(rename = "type")]
    pub(crate) kind: String,
    #[serde(default = "white")]
    pub(crate) color: [f64; 3],
    #[serde(default = "one")]
    pub(crate) intensity: f64,
    #[serde(default)]
    pub(crate) spot: Spot,
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Spot {
    pub(crate) inner_cone_angle: f64,
    pub(crate) outer_cone_angle: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Skin {
    pub(crate) joints: Vec<usize>,
    pub(crate) inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Animation {
    pub(crate) name: Option<String>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Channel {
    pub(crate) sampler: usize,
    pub(crate) target: Target,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Target {
    pub(crate) node: Option<usize>,
    pub(crate) path: String,
}

#[derive(Debug, Deserialize)]
pub(crate) struct AnimationSampler {
    pub(crate) input: usize,
    pub(crate) output: usize,
    pub(crate) interpolation: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) buffer_view: Option<usize>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) component_type: u32,
    #[serde(default)]
    pub(crate) normalized: bool,
    pub(crate) count: u64,
    #[serde(rename = "type")]
    pub(crate) kind: String,
    pub(crate) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Sparse {
    pub(crate) count: u64,
    pub(crate) indices: SparsePart,
    pub(crate) values: SparsePart,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparsePart {
    pub(crate) buffer_view: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    /// The type of the numbers; only `indices` have it.
    #[serde(default)]
    pub(crate) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub(crate) buffer: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) byte_length: u64,
    pub(crate) byte_stride: Option<u64>,
    #[serde(default)]
    pub(crate) extensions: BufferViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(crate) meshopt: Option<MeshoptView>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct MeshoptView {
    pub(crate) buffer: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) byte_length: u64,
    pub(crate) byte_stride: u64,
    pub(crate) count: u64,
    pub(crate) mode: String,
    pub(crate) filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub(crate) uri: Option<String>,
    pub(crate) byte_length: u64,
}
