//! The scenes of the report, compiled into the program.

/// Names of the built-in scenes. In the report, the first three are figures 1 to 3, and the last
/// one is figures 4 to 6.
pub const BUILTIN_NAMES: [&str; 4] = ["spheres", "spacetime", "checker", "cornell"];

/// RON text of a built-in scene.
pub(super) fn text(name: &str) -> Option<&'static str> {
    Some(match name {
        "spheres" => include_str!("../../scenes/spheres.ron"),
        "spacetime" => include_str!("../../scenes/spacetime.ron"),
        "checker" => include_str!("../../scenes/checker.ron"),
        "cornell" => include_str!("../../scenes/cornell.ron"),
        _ => return None,
    })
}
