//! Materials of Wavefront OBJ files, in MTL files (Wavefront, *Advanced Visualizer Manual*, appendix B),
//! with the parameters for physically based materials that most exporters write.

mod images;
mod map;
mod material;
mod section;

use std::borrow::Cow;
use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use self::images::Images;
use self::section::sections;
use crate::error::{Error, Result};
use crate::formats::import::{Import, ImportOptions};
use crate::input::{length, read_bytes};
use crate::limits::{Budget, Limit};
use crate::scene::{MeshFile, NamedMesh, PrimitiveFile, SceneFile};

/// Adds the materials that OBJ files name to the scene called `name`, for meshes without a material.
/// Returns the warnings.
///
/// # Errors
/// If a file cannot be read or its content is wrong.
pub(crate) fn add_materials_of_meshes(
    name: &str,
    folder: &Path,
    options: &ImportOptions,
    budget: &Budget,
    scene: &mut SceneFile,
) -> Result<Vec<String>> {
    let mut import = Import::new(folder, options, budget);
    let (mut files, mut seen, mut images) = (Vec::new(), HashSet::new(), Images::default());
    let parts = scene.meshes.0.iter().flat_map(|(_, mesh)| match mesh {
        NamedMesh::File(_) => &[],
        NamedMesh::Parts(parts) => &parts[..],
    });
    for primitive in scene.primitives.iter().chain(parts) {
        if let PrimitiveFile::Mesh(MeshFile { file, material: None, .. }) = primitive
            && file.to_lowercase().ends_with(".obj")
            && seen.insert(file.clone())
        {
            files.push(file.clone());
        }
    }
    for file in files {
        add_materials(&mut import, &mut images, &file, scene)?;
    }
    import.into_warnings(name)
}

/// Adds the materials of the OBJ file `obj`, relative to the folder, to `scene`, except for those whose
/// names it already has.
///
/// # Errors
/// If a material file cannot be read or has wrong content.
fn add_materials(
    import: &mut Import<'_>,
    images: &mut Images,
    obj: &str,
    scene: &mut SceneFile,
) -> Result<()> {
    let mut invisible = Vec::new();
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
            import.require(&import.folder.join(&library))?;
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
        let text = joined(text.strip_prefix('\u{feff}').unwrap_or(&text));
        for section in sections(&text).map_err(|(line, message)| bad(line.to_string(), message))? {
            if known.insert(section.name.clone()) {
                let material = section.material(import, images, &beside);
                let material =
                    material.map_err(|(line, message)| bad(line.to_string(), message))?;
                if material.is_invisible() {
                    invisible.push(format!("`{}`", section.name));
                }
                scene.add_material(section.name, material);
            }
        }
    }
    if !invisible.is_empty() {
        let (count, more) =
            (invisible.len(), if invisible.len() > MOST_NAMED { ", ..." } else { "" });
        invisible.truncate(MOST_NAMED);
        let (names, s) = (invisible.join(", "), if count == 1 { "" } else { "s" });
        import.note(format!(
            "has {count} invisible material{s}, with `d 0` or `Tr 1`: {names}{more}"
        ));
    }
    Ok(())
}

/// The text with each line that ends in a backslash joined to the next one. The line breaks follow, so that
/// later lines keep their numbers. Comments do not continue.
fn joined(text: &str) -> Cow<'_, str> {
    let continues = |line: &str| line.trim_end().ends_with('\\');
    if !text.lines().any(continues) {
        return Cow::Borrowed(text);
    }
    let (mut joined, mut breaks) = (String::with_capacity(text.len()), 0);
    for line in text.lines() {
        let is_comment = breaks == 0 && line.trim_start().starts_with('#');
        breaks += 1;
        if continues(line) && !is_comment {
            joined.push_str(line.trim_end().trim_end_matches('\\'));
            joined.push(' ');
        } else {
            joined.push_str(line);
            joined.extend(std::iter::repeat_n('\n', breaks));
            breaks = 0;
        }
    }
    Cow::Owned(joined)
}

/// Largest number of invisible materials that a notice names.
const MOST_NAMED: usize = 4;

/// Longest line with the name of a material file.
const MAX_LINE: u64 = 1 << 12;

/// Largest number of material files of an OBJ file.
const MAX_LIBRARIES: usize = 100;

/// The material files that an OBJ file names (`mtllib`), relative to its folder. A line names several, or
/// one whose name contains blanks.
fn libraries(obj: &Path) -> io::Result<Vec<String>> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut file = BufReader::new(File::open(obj)?);
    let (mut found, mut line) = (Vec::new(), Vec::new());
    let mut is_first = true;
    while file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)? > 0 {
        if std::mem::take(&mut is_first) && line.starts_with("\u{feff}".as_bytes()) {
            line.drain(.."\u{feff}".len());
        }
        let names = line.trim_ascii().strip_prefix(b"mtllib").unwrap_or_default();
        if names.ends_with(b"\\") && line.len() < MAX_LINE as usize {
            line.truncate(line.trim_ascii_end().len() - 1);
            continue;
        }
        if names.first().is_some_and(u8::is_ascii_whitespace) {
            let names = String::from_utf8_lossy(names.trim_ascii()).replace('\\', "/");
            let words: Vec<_> = names.split_ascii_whitespace().map(str::to_owned).collect();
            let all_exist = words.iter().all(|name| folder.join(name).exists());
            let several = all_exist && !folder.join(&names).exists();
            for name in if several { words } else { vec![names] } {
                if !found.contains(&name) && found.len() < MAX_LIBRARIES {
                    found.push(name);
                }
            }
        }
        line.clear();
    }
    Ok(found)
}
