//! The built-in scenes, compiled into the program with their images.

use std::path::Path;

/// Names of the built-in scenes. In the report, the first three are figures 1 to 3, and the fourth
/// is figures 4 to 6.
pub const BUILTIN_NAMES: [&str; 5] = ["spheres", "spacetime", "checker", "cornell", "garden"];

/// Stands for the folder of the built-in scenes. No folder can have this name.
pub(crate) const FOLDER: &str = "\0";

/// RON text of a built-in scene.
pub(crate) fn text(name: &str) -> Option<&'static str> {
    Some(match name {
        "spheres" => include_str!("../../scenes/spheres.ron"),
        "spacetime" => include_str!("../../scenes/spacetime.ron"),
        "checker" => include_str!("../../scenes/checker.ron"),
        "cornell" => include_str!("../../scenes/cornell.ron"),
        "garden" => include_str!("../../scenes/garden.ron"),
        _ => return None,
    })
}

/// The content of an image of a built-in scene, if `path` is one.
pub(crate) fn image(path: &Path) -> Option<&'static [u8]> {
    Some(match path.strip_prefix(FOLDER).ok()?.to_str()? {
        "garden/leaf.png" => include_bytes!("../../scenes/garden/leaf.png"),
        "garden/sky.hdr" => include_bytes!("../../scenes/garden/sky.hdr"),
        "garden/soil.png" => include_bytes!("../../scenes/garden/soil.png"),
        "garden/stone.png" => include_bytes!("../../scenes/garden/stone.png"),
        _ => return None,
    })
}
