//! Moves a description to another folder: its paths keep their files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{SceneDescription, builtin};
use crate::error::{Error, Result};
use crate::scene::{NamedMesh, PrimitiveFile, SceneFile};
use crate::shading::{Background, Material, TextureRef};

impl SceneDescription {
    /// Makes all paths relative to `folder`, where the scene will be saved. Built-in scenes keep those of the images that
    /// are compiled into the program.
    ///
    /// # Errors
    /// If there is no such folder.
    pub fn relocate(&mut self, folder: &Path) -> Result<()> {
        let is_builtin = self.has_builtin_images();
        let here = real(folder).map_err(Error::io(folder, "read"))?;
        let stays = is_builtin || real(&self.folder).is_ok_and(|there| there == here);
        for file in paths(&mut self.file) {
            let path = self.folder.join(&*file);
            if stays && Path::new(&*file).is_relative() {
                continue;
            }
            if let (Some(name), Some(Ok(within))) = (path.file_name(), path.parent().map(real)) {
                *file = relative(&within.join(name), &here);
            }
        }
        if !is_builtin {
            folder.clone_into(&mut self.folder);
        }
        Ok(())
    }

    /// Whether it is a built-in scene, whose images are in no folder.
    pub(crate) fn has_builtin_images(&self) -> bool {
        self.folder == Path::new(builtin::FOLDER)
    }
}

/// The absolute path of a folder without links.
fn real(folder: &Path) -> std::io::Result<PathBuf> {
    let current = folder.as_os_str().is_empty();
    if current { Path::new(".") } else { folder }.canonicalize()
}

/// All paths of files in a description.
fn paths(scene: &mut SceneFile) -> impl Iterator<Item = &mut String> {
    let map = match &mut scene.background {
        Background::Image(map) => Some(&mut map.file),
        _ => None,
    };
    let textures = scene.textures.0.iter_mut().filter_map(|(_, texture)| texture.file_mut());
    let meshes = scene.meshes.0.iter_mut().flat_map(|(_, mesh)| of_mesh(mesh));
    let materials = scene.materials.0.iter_mut().flat_map(|(_, material)| of_material(material));
    let primitives = scene.primitives.iter_mut().filter_map(of_part);
    meshes.chain(primitives).chain(textures).chain(materials).chain(map)
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

/// The paths of its textures without names.
fn of_material(material: &mut Material) -> Vec<&mut String> {
    let own = material.textures().into_iter().filter_map(|reference| match reference {
        TextureRef::Texture(texture) => Arc::make_mut(texture).file_mut(),
        TextureRef::Named(_) => None,
    });
    own.collect()
}

/// The path from `folder` to `file`, which are both absolute, with slashes. If they are on different drives, the
/// absolute path.
fn relative(file: &Path, folder: &Path) -> String {
    let [file_parts, folder_parts] =
        [file, folder].map(|path| path.components().collect::<Vec<_>>());
    let same = file_parts.iter().zip(&folder_parts).take_while(|(a, b)| a == b).count();
    if same == 0 {
        return file.to_string_lossy().into_owned();
    }
    let up = folder_parts[same..].iter().map(|_| "..".to_owned());
    let down = &file_parts[same..];
    let down = down.iter().map(|part| part.as_os_str().to_string_lossy().into_owned());
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
