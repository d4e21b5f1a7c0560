//! Moves a description to another folder: its paths keep their files.

use std::path::{Component, Path, PathBuf};

use super::{SceneDescription, builtin};
use crate::scene::{NamedMesh, PrimitiveFile, SceneFile};
use crate::shading::Background;

impl SceneDescription {
    /// Makes all paths relative to `folder`, where the scene will be saved.
    pub fn relocate(&mut self, folder: &Path) {
        let from = std::mem::replace(&mut self.folder, folder.to_owned());
        // The images of built-in scenes are in no folder.
        let (Some(there), Some(here)) = (real(&from), real(folder)) else { return };
        if from == Path::new(builtin::FOLDER) || there == here {
            return;
        }
        for file in paths(&mut self.file) {
            let path = from.join(&*file);
            if let (Some(name), Some(within)) = (path.file_name(), path.parent().and_then(real)) {
                *file = relative(&within.join(name), &here);
            }
        }
    }
}

/// The absolute path of a folder without links, if it exists.
fn real(folder: &Path) -> Option<PathBuf> {
    let current = folder.as_os_str().is_empty();
    if current { Path::new(".") } else { folder }.canonicalize().ok()
}

/// All paths of files in a description.
fn paths(scene: &mut SceneFile) -> impl Iterator<Item = &mut String> {
    let map = match &mut scene.background {
        Background::Image(map) => Some(&mut map.file),
        _ => None,
    };
    let textures = scene.textures.0.iter_mut().filter_map(|(_, texture)| texture.file_mut());
    let meshes = scene.meshes.0.iter_mut().flat_map(|(_, mesh)| of_mesh(mesh));
    meshes.chain(scene.primitives.iter_mut().filter_map(of_part)).chain(textures).chain(map)
}

fn of_mesh(mesh: &mut NamedMesh) -> Vec<&mut String> {
    match mesh {
        NamedMesh::File(file) => vec![file],
        NamedMesh::Parts(parts) => parts.iter_mut().filter_map(of_part).collect(),
    }
}

fn of_part(part: &mut PrimitiveFile) -> Option<&mut String> {
    match part {
        PrimitiveFile::Mesh(mesh) => Some(&mut mesh.file),
        _ => None,
    }
}

/// The path from `folder` to `file`, which are both absolute, with slashes. If they are on different drives, the
/// absolute path.
fn relative(file: &Path, folder: &Path) -> String {
    let (file_parts, folder_parts): (Vec<_>, Vec<_>) =
        (file.components().collect(), folder.components().collect());
    let same = file_parts.iter().zip(&folder_parts).take_while(|(a, b)| a == b).count();
    if same == 0 {
        return file.to_string_lossy().into_owned();
    }
    let up = folder_parts[same..].iter().map(|_| "..".to_owned());
    let down = file_parts[same..].iter().map(|part: &Component<'_>| {
        let part: &Path = part.as_ref();
        part.to_string_lossy().into_owned()
    });
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_from_one_folder_to_another() {
        let path = |file: &str, folder: &str| relative(Path::new(file), Path::new(folder));
        assert_eq!(path("/a/b/c.png", "/a/b"), "c.png");
        assert_eq!(path("/a/b/c.png", "/a"), "b/c.png");
        assert_eq!(path("/a/b/c.png", "/a/d/e"), "../../b/c.png");
    }
}
