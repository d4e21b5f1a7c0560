//! Reads the report's scenes in the flat form of `tests/data`, which has one record per line and which other
//! programs read, too:
//!
//! ```text
//! size W H
//! camera  fx fy fz  ax ay az  ux uy uz  vfov_deg  defocus_deg  focus  t0 t1
//! background r g b
//! mat lambert r g b
//! mat metal r g b fuzz
//! mat dielectric ior
//! mat emissive r g b
//! mat checker or og ob  er eg eb  scale
//! sphere x0 y0 z0  x1 y1 z1  radius mat     (x1.. = centre at time 1)
//! quad   qx qy qz  ux uy uz  vx vy vz  mat
//! ```
//!
//! Materials are numbered from 0 in the order in which they appear.

use std::str::SplitWhitespace;

use ptfast::SceneFile;
use serde_json::{Map, Value, json};

/// The rest of the words of a record.
struct Words<'a>(SplitWhitespace<'a>);

impl Words<'_> {
    fn number(&mut self) -> f32 {
        self.0.next().unwrap().parse().unwrap()
    }

    fn integer(&mut self) -> u32 {
        self.0.next().unwrap().parse().unwrap()
    }

    fn vector(&mut self) -> [f32; 3] {
        [self.number(), self.number(), self.number()]
    }

    fn material_name(&mut self) -> String {
        format!("m{}", self.integer())
    }

    /// A material. Textures get the name of their material.
    fn material(&mut self, name: &str, textures: &mut Map<String, Value>) -> Value {
        match self.0.next().unwrap() {
            "lambert" => json!({ "lambertian": { "albedo": self.vector() } }),
            "metal" => json!({ "metal": { "albedo": self.vector(), "fuzz": self.number() } }),
            "dielectric" => json!({ "dielectric": { "ior": self.number(), "fresnel": "schlick" } }),
            "emissive" => json!({ "light": { "radiance": self.vector(), "sides": "both" } }),
            "checker" => {
                let (odd, even, scale) = (self.vector(), self.vector(), self.number());
                let checker = json!({ "checker": { "odd": odd, "even": even, "scale": scale } });
                textures.insert(name.to_owned(), checker);
                json!({ "lambertian": { "albedo": name } })
            }
            other => panic!("unknown material {other}"),
        }
    }

    fn sphere(&mut self) -> Value {
        let (center, center1, radius) = (self.vector(), self.vector(), self.number());
        let material = self.material_name();
        if center == center1 {
            return json!({ "sphere": { "center": center, "radius": radius, "material": material } });
        }
        json!({ "moving_sphere": {
            "center": center, "center1": center1, "radius": radius, "material": material
        } })
    }
}

/// The scene with this text.
pub(crate) fn parse(text: &str) -> SceneFile {
    let mut scene = Map::new();
    let (mut textures, mut materials, mut primitives) = (Map::new(), Map::new(), Vec::new());
    for line in text.lines() {
        let mut words = Words(line.split_whitespace());
        let w = &mut words;
        match w.0.next().unwrap_or("#") {
            "#" => {}
            "size" => {
                let size = json!({ "width": w.integer(), "height": w.integer() });
                scene.insert("render".to_owned(), size);
            }
            "camera" => {
                let camera = json!({
                    "look_from": w.vector(), "look_at": w.vector(), "up": w.vector(),
                    "vfov": w.number(), "defocus_angle": w.number(),
                    "focus_distance": w.number(), "shutter": [w.number(), w.number()],
                });
                scene.insert("camera".to_owned(), camera);
            }
            "background" => {
                let background = json!({ "constant": { "radiance": w.vector() } });
                scene.insert("background".to_owned(), background);
            }
            "mat" => {
                let name = format!("m{}", materials.len());
                let material = w.material(&name, &mut textures);
                materials.insert(name, material);
            }
            "sphere" => primitives.push(w.sphere()),
            "quad" => {
                let (q, u, v) = (w.vector(), w.vector(), w.vector());
                primitives.push(json!({
                    "quad": { "q": q, "u": u, "v": v, "material": w.material_name() }
                }));
            }
            other => panic!("unknown record {other}"),
        }
        assert_eq!(words.0.next(), None, "too many words: {line}");
    }
    scene.insert("textures".to_owned(), textures.into());
    scene.insert("materials".to_owned(), materials.into());
    scene.insert("primitives".to_owned(), primitives.into());
    serde_json::from_value(scene.into()).unwrap()
}
