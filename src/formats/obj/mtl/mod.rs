//! Materials of Wavefront OBJ files, in MTL files (Wavefront, *Advanced Visualizer Manual*, appendix B),
//! with the parameters for physically based materials that most exporters write.

mod map;
mod material;
mod section;

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

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
    let (mut files, mut seen) = (Vec::new(), HashSet::new());
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
        add_materials(&mut import, &file, scene)?;
    }
    import.into_warnings(name)
}

/// Adds the materials of the OBJ file `obj`, relative to the folder, to `scene`, except for those whose
/// names it already has.
///
/// # Errors
/// If a material file cannot be read or has wrong content.
fn add_materials(import: &mut Import<'_>, obj: &str, scene: &mut SceneFile) -> Result<()> {
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

/// Largest number of material files of an OBJ file.
const MAX_LIBRARIES: usize = 100;

/// The material files that an OBJ file names (`mtllib`), relative to its folder. A line names several, or
/// one whose name contains blanks.
fn libraries(obj: &Path) -> io::Result<Vec<String>> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut file = BufReader::new(File::open(obj)?);
    let (mut found, mut line) = (Vec::new(), Vec::new());
    while file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)? > 0 {
        let names = line.trim_ascii().strip_prefix(b"mtllib").unwrap_or_default();
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
