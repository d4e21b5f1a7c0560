//! Reads the flat text form of scenes, which has one record per line.
//!
//! Other programs read this form as well:
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
//! Materials are numbered from 0 in the order in which they appear. Empty lines and lines
//! that begin with `#` are skipped. Each record is converted to the JSON form of scene files.

use std::str::SplitWhitespace;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::description::SceneFile;
use super::named::Named;
use super::place::Places;
use crate::error::{Error, Result, suggestion};

const RECORDS: [&str; 6] = ["size", "camera", "background", "mat", "sphere", "quad"];
const MATERIALS: [&str; 5] = ["lambert", "metal", "dielectric", "emissive", "checker"];

/// Reads the flat form. The returned places are the line numbers of sections, materials and
/// primitives.
pub(super) fn from_flat(file: &str, text: &str) -> Result<(SceneFile, Places)> {
    let (mut camera, mut background, mut size) = (None, None, None);
    let (mut textures, mut materials) = (Named::default(), Named::default());
    let mut primitives = Vec::new();
    let mut places = Places::lines();
    let mut uses = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let Some(record) = words.next().filter(|word| !word.starts_with('#')) else { continue };
        let mut record_words = Words { file, line: number + 1, words };
        let w = &mut record_words;
        match record {
            "size" => {
                w.only_once(record, &mut places.render)?;
                let (width, height) = (w.integer()?, w.integer()?);
                size = Some(w.parsed(json!({ "width": width, "height": height }))?);
            }
            "camera" => {
                w.only_once(record, &mut places.camera)?;
                let value = json!({
                    "look_from": w.vector()?,
                    "look_at": w.vector()?,
                    "up": w.vector()?,
                    "vfov": w.number()?,
                    "defocus_angle": w.number()?,
                    "focus_distance": w.number()?,
                    "shutter": [w.number()?, w.number()?],
                });
                camera = Some(w.parsed(value)?);
            }
            "background" => {
                w.only_once(record, &mut places.background)?;
                let value = json!({ "constant": { "radiance": w.vector()? } });
                background = Some(w.parsed(value)?);
            }
            "mat" => {
                let name = format!("m{}", materials.0.len());
                let (material, texture) = w.material(&name)?;
                if let Some(texture) = texture {
                    textures.0.push((name.clone(), w.parsed(texture)?));
                }
                materials.0.push((name, w.parsed(material)?));
                places.materials.push(w.line);
            }
            "sphere" => {
                let (center, center1, radius) = (w.vector()?, w.vector()?, w.number()?);
                let material = w.material_use(&mut uses)?;
                let value = if center == center1 {
                    json!({ "sphere": { "center": center, "radius": radius, "material": material } })
                } else {
                    json!({ "moving_sphere": {
                        "center": center, "center1": center1, "radius": radius, "material": material
                    } })
                };
                primitives.push(w.parsed(value)?);
                places.primitives.push(w.line);
            }
            "quad" => {
                let (q, u, v) = (w.vector()?, w.vector()?, w.vector()?);
                let material = w.material_use(&mut uses)?;
                let value = json!({ "quad": { "q": q, "u": u, "v": v, "material": material } });
                primitives.push(w.parsed(value)?);
                places.primitives.push(w.line);
            }
            other => {
                return Err(
                    w.error(format!("unknown record `{other}`{}", suggestion(other, RECORDS)))
                );
            }
        }
        if let Some(extra) = w.words.next() {
            return Err(w.error(format!("`{extra}` is one value too many for `{record}`")));
        }
    }
    let defined = materials.0.len();
    if let Some((line, index)) = uses.into_iter().find(|&(_, index)| index as usize >= defined) {
        let message =
            format!("unknown material {index}, the file defines {defined}, counted from 0");
        return Err(Error::input(file, line.to_string(), message));
    }
    let camera = camera.ok_or_else(|| Error::input(file, "", "the record `camera` is missing"))?;
    let mut scene = SceneFile::new(camera);
    (scene.textures, scene.materials, scene.primitives) = (textures, materials, primitives);
    scene.background = background.unwrap_or_default();
    scene.render = size.unwrap_or_default();
    Ok((scene, places))
}

/// The words of one record that have not been read yet.
struct Words<'a> {
    file: &'a str,
    line: usize,
    words: SplitWhitespace<'a>,
}

impl Words<'_> {
    fn error(&self, message: String) -> Error {
        Error::input(self.file, self.line.to_string(), message)
    }

    /// Parses `value`, which is in the JSON form of scene files.
    fn parsed<T: DeserializeOwned>(&self, value: Value) -> Result<T> {
        serde_json::from_value(value).map_err(|error| self.error(error.to_string()))
    }

    /// Stores the record's line number in `line`, or returns an error if an earlier record has done
    /// so.
    fn only_once(&self, record: &str, line: &mut usize) -> Result<()> {
        if *line != 0 {
            return Err(self.error(format!("a second `{record}`, the first is in line {line}")));
        }
        *line = self.line;
        Ok(())
    }

    fn word(&mut self, what: &str) -> Result<&str> {
        match self.words.next() {
            Some(word) => Ok(word),
            None => Err(self.error(format!("expected {what}, but the line ends"))),
        }
    }

    fn number(&mut self) -> Result<f32> {
        let word = self.word("a number")?;
        match word.parse::<f32>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                let message = format!("`{word}` is not a finite number");
                Err(self.error(message))
            }
        }
    }

    fn vector(&mut self) -> Result<[f32; 3]> {
        Ok([self.number()?, self.number()?, self.number()?])
    }

    fn integer(&mut self) -> Result<u32> {
        let word = self.word("a whole number")?;
        match word.parse() {
            Ok(number) => Ok(number),
            Err(_) => {
                let message = format!("`{word}` is not a whole number from 0 to 2^32 − 1");
                Err(self.error(message))
            }
        }
    }

    /// Reads a reference to a material and returns the material's name. The material may be defined
    /// on a later line, so `uses` collects the references to check at the end.
    fn material_use(&mut self, uses: &mut Vec<(usize, u32)>) -> Result<String> {
        let index = self.integer()?;
        uses.push((self.line, index));
        Ok(format!("m{index}"))
    }

    /// Reads a material. The checker also has a texture, which is given the same name.
    fn material(&mut self, name: &str) -> Result<(Value, Option<Value>)> {
        let kind = self.word("a kind of material")?.to_owned();
        let mut texture = None;
        let material = match kind.as_str() {
            "lambert" => json!({ "lambertian": { "albedo": self.vector()? } }),
            "metal" => json!({ "metal": { "albedo": self.vector()?, "fuzz": self.number()? } }),
            "dielectric" => {
                json!({ "dielectric": { "ior": self.number()?, "fresnel": "schlick" } })
            }
            "emissive" => json!({ "light": { "radiance": self.vector()?, "sides": "both" } }),
            "checker" => {
                let (odd, even, scale) = (self.vector()?, self.vector()?, self.number()?);
                texture = Some(json!({ "checker": { "odd": odd, "even": even, "scale": scale } }));
                json!({ "lambertian": { "albedo": name } })
            }
            other => {
                let message = format!("unknown material `{other}`{}", suggestion(other, MATERIALS));
                return Err(self.error(message));
            }
        };
        Ok((material, texture))
    }
}
