//! The hash that identifies a scene by its content, regardless of how its file expresses it.

use std::io::{BufWriter, Write};

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use crate::shading::{Camera, Material, Medium, TextureRef, World};

/// BLAKE3 over the camera, the background, the lights that are not primitives, the primitives with their
/// materials, and the media, in a canonical form: JSON of the parameters after names are resolved, and the
/// bytes of coordinates.
pub(crate) fn hash(world: &World, camera: &Camera, origin: DVec3) -> String {
    let mut hasher = Hasher::new();
    // The layer of positions depends on it.
    if origin != DVec3::ZERO {
        hasher.value(json!({ "origin": origin.to_array() }));
    }
    hasher.text("camera");
    for number in camera.numbers() {
        // Adding 0 turns −0 into 0, so that both have the same hash.
        hasher.bytes(&(number + 0.0).to_le_bytes());
    }
    // Without the box, hashes are those of files from before there were filters.
    if !camera.filter.is_box() {
        hasher.value(json!({ "filter": camera.filter }));
    }
    hasher.value(world.background.identity());
    if !world.lights.is_empty() {
        hasher.value(json!(world.lights));
    }
    let materials: Vec<_> =
        world.materials.iter().map(|material| blake3::hash(&identity(material))).collect();
    for index in 0..world.geometry.len() as u32 {
        let material = world.material_map.get(index);
        let primitive = world.geometry.get(index);
        hasher.vectors(primitive.name(), &primitive.identity());
        hasher.attributes(world.geometry.attributes(index));
        hasher.bytes(materials[material as usize].as_bytes());
    }
    let instances = &world.geometry.instances;
    let first = world.geometry.len() as u32;
    for mesh in 0..instances.meshes() {
        hasher.text("mesh");
        for triangle in instances.range(mesh) {
            let vertices = instances.triangles().triangles.vertices(triangle as usize);
            hasher.vectors("triangle", &vertices);
            hasher.attributes(instances.triangles().attributes(triangle));
            let material = world.material_map.get(first + triangle);
            hasher.bytes(materials[material as usize].as_bytes());
        }
    }
    for instance in instances.list() {
        hasher.text(&format!("instance {}", instance.mesh()));
        hasher.numbers(&instance.identity());
    }
    for Medium { volume, density, albedo } in &world.media {
        let (name, vectors) = volume.identity();
        hasher.vectors(name, &vectors);
        hasher.vectors("medium", &[Vec3::splat(*density), *albedo]);
    }
    hasher.finish()
}

/// The parameters of a material. The content of its textures replaces their names and files.
fn identity(material: &Material) -> Vec<u8> {
    let mut material = material.clone();
    for reference in material.textures() {
        let texture = canonical(reference.get().model().identity());
        *reference = TextureRef::Named(String::from_utf8(texture).expect("JSON is UTF-8"));
    }
    canonical(json!(material))
}

/// BLAKE3 behind a buffer, because it is fast on long runs of bytes alone.
struct Hasher(BufWriter<blake3::Hasher>);

impl Hasher {
    fn new() -> Self {
        Self(BufWriter::with_capacity(1 << 16, blake3::Hasher::new()))
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).expect("a hasher takes all bytes");
    }

    fn finish(self) -> String {
        let hasher = self.0.into_inner().expect("a hasher takes all bytes");
        hasher.finalize().to_hex().to_string()
    }

    fn text(&mut self, text: &str) {
        self.bytes(&(text.len() as u64).to_le_bytes());
        self.bytes(text.as_bytes());
    }

    fn value(&mut self, value: Value) {
        self.bytes(&canonical(value));
    }

    fn vectors(&mut self, name: &str, vectors: &[Vec3]) {
        self.text(name);
        // Few vectors are copied at a time, since each call of the hasher takes some time.
        for few in vectors.chunks(8) {
            let mut numbers = [[0.0; 3]; 8];
            for (numbers, vector) in numbers.iter_mut().zip(few) {
                *numbers = vector.to_array();
            }
            self.numbers(numbers[..few.len()].as_flattened());
        }
    }

    /// The flags of a triangle, and the attributes of its vertices.
    fn attributes(&mut self, attributes: Option<(u32, Vec<f32>)>) {
        if let Some((flags, numbers)) = attributes {
            self.text(&format!("vertices {flags}"));
            self.numbers(&numbers);
        }
    }

    fn numbers(&mut self, numbers: &[f32]) {
        for few in numbers.chunks(32) {
            let mut bytes = [[0; 4]; 32];
            for (bytes, number) in bytes.iter_mut().zip(few) {
                *bytes = (number + 0.0).to_le_bytes();
            }
            self.bytes(bytes[..few.len()].as_flattened());
        }
    }
}

/// JSON with sorted keys, in which −0 is replaced by 0.
fn canonical(mut value: Value) -> Vec<u8> {
    fn without_signs(value: &mut Value) {
        match value {
            Value::Number(number) if number.as_f64() == Some(0.0) => *value = json!(0),
            Value::Array(values) => values.iter_mut().for_each(without_signs),
            Value::Object(fields) => fields.values_mut().for_each(without_signs),
            _ => {}
        }
    }
    without_signs(&mut value);
    value.to_string().into_bytes()
}
