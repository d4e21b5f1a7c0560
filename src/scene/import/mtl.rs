//! Materials of Wavefront OBJ files, in MTL files (Wavefront, *Advanced Visualizer Manual*, appendix B),
//! with the parameters for physically based materials that most exporters write.

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::{Import, Missing};
use crate::error::{Error, Result};
use crate::image::Encoding;
use crate::input::{length, read_bytes};
use crate::limits::Limit;
use crate::scene::description::SceneFile;
use crate::scene::emission::Sides;
use crate::scene::material::{Dielectric, Fresnel, Lambertian, Light, Material, Principled};
use crate::scene::opacity::Opacity;
use crate::scene::texture::{Channel, Color, Image, Number, TextureRef, Wrap};

/// Adds the materials of the OBJ file `obj`, relative to the folder, to `scene`, except for those whose
/// names it already has.
///
/// # Errors
/// If a material file cannot be read or has wrong content.
pub(in crate::scene) fn add_materials(
    import: &mut Import<'_>,
    obj: &str,
    scene: &mut SceneFile,
) -> Result<()> {
    let mut known: HashSet<String> = scene.materials.names().map(str::to_owned).collect();
    let beside = Path::new(obj).parent().unwrap_or(Path::new("")).to_owned();
    // The reader of meshes reports files that cannot be read.
    let Ok(path) = import.path_within(obj) else { return Ok(()) };
    if length(&path).is_err() {
        return Ok(());
    }
    for library in libraries(&path).map_err(Error::io(&path, "read"))? {
        let library = beside.join(library).to_string_lossy().into_owned();
        if !import.folder.join(&library).exists() {
            if import.options.missing == Missing::Error {
                return Err(Error::io(&import.folder.join(&library), "read")(
                    io::ErrorKind::NotFound.into(),
                ));
            }
            import.warn(format!("{library} is missing, so its materials are unknown"));
            continue;
        }
        let path = import.path_within(&library)?;
        let limits = &import.budget.limits;
        let bytes = read_bytes(&path, |length| limits.check(Limit::SceneBytes, length))?;
        let bad = |place: String, message| Error::input(path.display().to_string(), place, message);
        import
            .budget
            .hold_text(bytes.len() as u64)
            .map_err(|message| bad(String::new(), message))?;
        // Names and paths of other encodings are read as they are shown.
        let text = String::from_utf8_lossy(&bytes);
        for section in sections(&text).map_err(|(line, message)| bad(line.to_string(), message))? {
            if known.insert(section.name.clone()) {
                let material = section.material(import, &beside);
                let material =
                    material.map_err(|(line, message)| bad(line.to_string(), message))?;
                scene.add_material(section.name, material);
            }
        }
    }
    Ok(())
}

/// Longest line with the name of a material file.
const MAX_LINE: u64 = 1 << 12;

/// The material files that an OBJ file names (`mtllib`). Their names may contain blanks.
fn libraries(obj: &Path) -> io::Result<Vec<String>> {
    let mut file = BufReader::new(File::open(obj)?);
    let (mut found, mut line) = (Vec::new(), Vec::new());
    while file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)? > 0 {
        if let Some(name) = line.trim_ascii().strip_prefix(b"mtllib ") {
            let name = String::from_utf8_lossy(name.trim_ascii()).replace('\\', "/");
            if !found.contains(&name) && found.len() < 100 {
                found.push(name);
            }
        }
        line.clear();
    }
    Ok(found)
}

/// The lines of one material, by keyword: the line number and what follows.
struct Section<'a> {
    name: String,
    lines: HashMap<String, (usize, &'a str)>,
}

type Wrong = (usize, String);

fn sections(text: &str) -> Result<Vec<Section<'_>>, Wrong> {
    let mut sections: Vec<Section<'_>> = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let content = content.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = content.split_once([' ', '\t']).unwrap_or((content, ""));
        match (keyword, sections.last_mut()) {
            ("", _) => {}
            ("newmtl", _) => {
                sections.push(Section { name: rest.trim().to_owned(), lines: HashMap::new() })
            }
            (_, None) => return Err((line + 1, format!("`{keyword}` comes before `newmtl`"))),
            (_, Some(section)) => {
                section.lines.insert(keyword.to_lowercase(), (line + 1, rest.trim()));
            }
        }
    }
    Ok(sections)
}

impl Section<'_> {
    fn numbers<const N: usize>(&self, keyword: &str) -> Result<Option<[f32; N]>, Wrong> {
        let Some(&(line, text)) = self.lines.get(keyword) else { return Ok(None) };
        let numbers: Option<Vec<f32>> =
            text.split_ascii_whitespace().take(N).map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
        match numbers.as_deref() {
            // A single number is grey.
            Some([one]) => Ok(Some([*one; N])),
            Some(numbers) if numbers.len() == N => Ok(numbers.try_into().ok()),
            _ => Err((line, format!("`{keyword}` must be {N} finite numbers, is `{text}`"))),
        }
    }

    fn color(&self, keyword: &str) -> Result<Option<[f32; 3]>, Wrong> {
        let color = self.numbers::<3>(keyword);
        // Spectral files are not numbers.
        let spectral =
            self.lines.get(keyword).is_some_and(|(_, text)| text.starts_with("spectral"));
        if spectral { Ok(None) } else { color }
    }

    fn number(&self, keyword: &str) -> Result<Option<f32>, Wrong> {
        Ok(self.numbers::<1>(keyword)?.map(|[number]| number))
    }

    /// The texture of a map, if it has one that can be used.
    fn texture(
        &self,
        keywords: &[&str],
        encoding: Encoding,
        import: &mut Import<'_>,
        folder: &Path,
    ) -> Option<TextureRef> {
        let &(_, text) = keywords.iter().find_map(|keyword| self.lines.get(*keyword))?;
        let (mut image, file) = options(text);
        let file = folder.join(file).to_string_lossy().into_owned();
        if !import.is_usable(&file, "so it is left out") {
            return None;
        }
        (image.file, image.encoding) = (file, encoding);
        Some(image.into())
    }

    fn material(&self, import: &mut Import<'_>, folder: &Path) -> Result<Material, Wrong> {
        for (keyword, what) in
            [("map_bump", "bump maps"), ("bump", "bump maps"), ("disp", "displacement")]
        {
            if self.lines.contains_key(keyword) {
                import.warn(format!("{what} are not supported, so surfaces stay flat"));
            }
        }
        for keyword in ["map_ks", "map_ns", "ps", "map_ps", "aniso", "anisor", "refl"] {
            if self.lines.contains_key(keyword) {
                import.warn(format!("`{keyword}` is not supported, so it has no effect"));
            }
        }
        let share = |color: [f32; 3]| color.map(|c| c.clamp(0.0, 1.0));
        let diffuse = share(self.color("kd")?.unwrap_or([0.8; 3]));
        let specular = share(self.color("ks")?.unwrap_or([0.0; 3]));
        let emission = self.color("ke")?.unwrap_or([0.0; 3]).map(|c| c.clamp(0.0, 1e30));
        let ior = self.number("ni")?.unwrap_or(1.5);
        let model = self.number("illum")?.unwrap_or(2.0);
        let opaque = match self.number("tr")? {
            Some(transparent) => 1.0 - transparent,
            None => self.number("d")?.unwrap_or(1.0),
        };
        let opaque = opaque.clamp(0.0, 1.0);
        let (rough, metal) = (self.number("pr")?, self.number("pm")?);
        let mut map =
            |keywords: &[&str], encoding| self.texture(keywords, encoding, import, folder);
        let normal = map(&["norm", "map_kn"], Encoding::Linear);
        let base_color = match map(&["map_kd"], Encoding::Auto) {
            Some(texture) => Color::Texture { texture, factor: [1.0; 3] },
            None => Color::Rgb(diffuse),
        };
        let emission_color = match map(&["map_ke"], Encoding::Auto) {
            Some(texture) => Color::Texture {
                texture,
                factor: if emission == [0.0; 3] { [1.0; 3] } else { emission },
            },
            None => Color::Rgb(emission),
        };
        let number = |texture: Option<TextureRef>, value: f32| match texture {
            Some(texture) => Number::Texture { texture, channel: Channel::R, factor: 1.0 },
            None => Number::Value(value.clamp(0.0, 1.0)),
        };
        let rough_map = map(&["map_pr"], Encoding::Linear);
        let metal_map = map(&["map_pm"], Encoding::Linear);
        let opacity = match map(&["map_d"], Encoding::Linear) {
            Some(texture) => Some(Opacity::Blend {
                alpha: Number::Texture { texture, channel: Channel::R, factor: opaque },
            }),
            None if opaque < 1.0 => Some(Opacity::Blend { alpha: Number::Value(opaque) }),
            None => None,
        };
        let is_pbr =
            rough.is_some() || metal.is_some() || rough_map.is_some() || metal_map.is_some();
        // Models 4, 6, 7 and 9 are glass.
        if [4.0, 6.0, 7.0, 9.0].contains(&model) && (opaque < 1.0 || self.lines.contains_key("tf"))
        {
            let tint = share(self.color("tf")?.unwrap_or([1.0; 3]));
            if tint != [1.0; 3] {
                return Ok(Principled {
                    base_color: Color::Rgb(tint),
                    roughness: 0.0.into(),
                    ior: ior.clamp(1.01, 10.0),
                    transmission: 1.0.into(),
                    ..Principled::default()
                }
                .into());
            }
            return Ok(Dielectric { ior: ior.clamp(0.01, 100.0), fresnel: Fresnel::Exact }.into());
        }
        if let (Color::Rgb(radiance), true) = (&emission_color, diffuse == [0.0; 3])
            && *radiance != [0.0; 3]
        {
            return Ok(Light { radiance: *radiance, sides: Sides::Both }.into());
        }
        let dark = emission_color == Color::Rgb([0.0; 3]);
        let shiny = specular != [0.0; 3] && model >= 2.0;
        if !is_pbr && !shiny && dark {
            return Ok(Lambertian { normal, opacity, ..Lambertian::new(base_color) }.into());
        }
        // Phong's exponent as a GGX roughness (Walter et al. 2007, section 5.2).
        let exponent = self.number("ns")?.unwrap_or(0.0).clamp(0.0, 1e6);
        let alpha = (2.0 / (exponent + 2.0)).sqrt();
        let mean = (specular[0] + specular[1] + specular[2]) / 3.0;
        // A mirror without a diffuse part is metal.
        let mirror = !is_pbr && shiny && base_color == Color::Rgb([0.0; 3]);
        let opacity =
            if dark || matches!(emission_color, Color::Texture { .. }) { opacity } else { None };
        Ok(Principled {
            base_color: if mirror { Color::Rgb(specular) } else { base_color },
            metalness: number(metal_map, metal.unwrap_or(if mirror { 1.0 } else { 0.0 })),
            roughness: number(rough_map, rough.unwrap_or_else(|| alpha.sqrt())),
            specular: Number::Value(if is_pbr {
                1.0
            } else if shiny {
                (mean / 0.04).clamp(0.0, 1.0)
            } else {
                0.0
            }),
            ior: ior.clamp(1.01, 10.0),
            coat: Number::Value(self.number("pc")?.unwrap_or(0.0).clamp(0.0, 1.0)),
            coat_roughness: Number::Value(self.number("pcr")?.unwrap_or(0.0).clamp(0.0, 1.0)),
            emission: emission_color,
            normal,
            opacity,
            ..Principled::default()
        }
        .into())
    }
}

/// The options of a map and its file, whose name may contain blanks.
fn options(text: &str) -> (Image, String) {
    let mut image = Image::from_file("");
    let mut rest = text.trim();
    while rest.starts_with('-') {
        let (option, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let most = match option {
            "-s" | "-o" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        let (mut values, mut after) = (Vec::new(), after.trim_start());
        while values.len() < most {
            let (word, next) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
            // `-s` and `-o` may have fewer than three numbers.
            if most > 1 && word.parse::<f32>().is_err() {
                break;
            }
            values.push(word);
            after = next.trim_start();
        }
        let number = |i: usize, usual: f32| {
            let number = values.get(i).and_then(|word| word.parse().ok());
            number.filter(|number: &f32| number.abs() <= 1e6).unwrap_or(usual)
        };
        match option {
            "-s" => image.scale = (number(0, 1.0), number(1, 1.0)),
            "-o" => image.offset = (number(0, 0.0), number(1, 0.0)),
            "-clamp" if values.first() == Some(&"on") => {
                (image.wrap_u, image.wrap_v) = (Wrap::Clamp, Wrap::Clamp);
            }
            _ => {}
        }
        rest = after;
    }
    (image, rest.replace('\\', "/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_options_and_names_with_blanks() {
        let (image, file) = options("-s 2 3 -o 0.5 0.25 0 -clamp on -bm 0.3 my folder\\a b.png");
        assert_eq!(file, "my folder/a b.png");
        assert_eq!((image.scale, image.offset), ((2.0, 3.0), (0.5, 0.25)));
        assert_eq!(image.wrap_u, Wrap::Clamp);
        assert_eq!(options("a.png").1, "a.png");
    }
}
