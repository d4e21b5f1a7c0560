//! The flat text form: one record a line, as other programs read it too.
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
//! that begin with `#` are skipped.

use std::str::SplitWhitespace;

use super::background::Background;
use super::description::{CameraFile, PrimitiveFile, SceneFile};
use super::material::{Dielectric, Fresnel, Lambertian, Light, Material, Metal, Sides};
use super::named::Named;
use super::place::Places;
use super::texture::{Checker, Color, Texture};
use crate::error::{Error, Result, suggestion};

const RECORDS: [&str; 6] = ["size", "camera", "background", "mat", "sphere", "quad"];
const MATERIALS: [&str; 5] = ["lambert", "metal", "dielectric", "emissive", "checker"];

/// Reads the flat form; the places are the lines of materials and primitives.
pub(super) fn from_flat(file: &str, text: &str) -> Result<(SceneFile, Places)> {
    let mut camera = None;
    let mut background = Background::default();
    let mut render = super::RenderDefaults::default();
    let mut textures = Named::default();
    let mut materials = Named::default();
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
                (render.width, render.height) = (w.integer()?, w.integer()?);
            }
            "camera" => {
                w.only_once(record, &mut places.camera)?;
                camera = Some(CameraFile {
                    look_from: w.vector()?,
                    look_at: w.vector()?,
                    up: w.vector()?,
                    vfov: w.number()?,
                    defocus_angle: w.number()?,
                    focus_distance: w.number()?,
                    shutter: (w.number()?, w.number()?),
                });
            }
            "background" => {
                w.only_once(record, &mut places.background)?;
                background = Background::Constant { radiance: w.vector()? };
            }
            "mat" => {
                let name = format!("m{}", materials.0.len());
                let (material, texture) = w.material(&name)?;
                textures.0.extend(texture.map(|texture| (name.clone(), texture)));
                materials.0.push((name, material));
                places.materials.push(w.line);
            }
            "sphere" => {
                let (center, center1, radius) = (w.vector()?, w.vector()?, w.number()?);
                let material = w.material_use(&mut uses)?;
                primitives.push(if center == center1 {
                    PrimitiveFile::Sphere { center, radius, material }
                } else {
                    PrimitiveFile::MovingSphere { center, center1, radius, material }
                });
                places.primitives.push(w.line);
            }
            "quad" => {
                let (q, u, v) = (w.vector()?, w.vector()?, w.vector()?);
                let material = w.material_use(&mut uses)?;
                primitives.push(PrimitiveFile::Quad { q, u, v, material });
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
        let message = format!("unknown material {index}, the file defines {defined} from 0 on");
        return Err(Error::input(file, line.to_string(), message));
    }
    let camera = camera.ok_or_else(|| Error::input(file, "", "the record `camera` is missing"))?;
    let media = Vec::new();
    Ok((SceneFile { camera, background, render, textures, materials, primitives, media }, places))
}

/// The values of one record.
struct Words<'a> {
    file: &'a str,
    line: usize,
    words: SplitWhitespace<'a>,
}

impl Words<'_> {
    fn error(&self, message: String) -> Error {
        Error::input(self.file, self.line.to_string(), message)
    }

    /// Notes the record's line, or refuses it where `line` says that there was one before.
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
            None => Err(self.error(format!("the line ends where {what} should follow"))),
        }
    }

    fn number(&mut self) -> Result<f32> {
        let word = self.word("a number")?;
        match word.parse() {
            Ok(number) => Ok(number),
            Err(_) => {
                let message = format!("`{word}` is not a number");
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
                let message = format!("`{word}` is not a whole number of 0 to 2^32 − 1");
                Err(self.error(message))
            }
        }
    }

    /// The name of a material that is used here, defined before or after.
    fn material_use(&mut self, uses: &mut Vec<(usize, u32)>) -> Result<String> {
        let index = self.integer()?;
        uses.push((self.line, index));
        Ok(format!("m{index}"))
    }

    /// A material and, for the checker, its texture, which gets the same name.
    fn material(&mut self, name: &str) -> Result<(Material, Option<Texture>)> {
        let kind = self.word("a kind of material")?.to_owned();
        let mut texture = None;
        let material = match kind.as_str() {
            "lambert" => Lambertian { albedo: self.vector()?.into() }.into(),
            "metal" => Metal { albedo: self.vector()?.into(), fuzz: self.number()? }.into(),
            "dielectric" => Dielectric { ior: self.number()?, fresnel: Fresnel::Schlick }.into(),
            "emissive" => Light { radiance: self.vector()?, sides: Sides::Both }.into(),
            "checker" => {
                let (odd, even, scale) = (self.vector()?, self.vector()?, self.number()?);
                texture = Some(Checker { odd, even, scale }.into());
                Lambertian { albedo: Color::Named(name.to_owned()) }.into()
            }
            other => {
                let message = format!("unknown material `{other}`{}", suggestion(other, MATERIALS));
                return Err(self.error(message));
            }
        };
        Ok((material, texture))
    }
}
