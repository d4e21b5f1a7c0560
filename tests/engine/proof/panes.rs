//! Panes: thin, smooth glass, which rays pass without a vertex.

use std::f64::consts::PI;

use ptfast::Sampling;

use super::{Known, compare, compare_in};

/// A matte floor at y = 0, seen at (0, 0, 0) from (0, 3, 4), below these panes, lights and walls.
fn floor(name: &str, panes: &str, light: &str, walls: &str, depth: u32, radiance: f64) -> Known {
    let glass = "transmission: 1, roughness: 0, thin: true";
    let text = format!(
        r#"(camera: (look_from: (0, 3, 4), look_at: (0, 0, 0), vfov: 0.02), render: (depth: {depth}),
            materials: {{
                "floor": lambertian(albedo: (0.6, 0.6, 0.6)),
                "wall": light(radiance: (3, 3, 3)),
                "tint": principled(base_color: (0.8, 0.8, 0.8), specular: 0, {glass}),
                "clear": principled(base_color: (1, 1, 1), ior: 1.5, {glass})}},
            lights: [{light}],
            meshes: {{"tint": [{}]}},
            primitives: [quad(q: (-9, 0, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"), {walls} {panes}])"#,
        triangles(0.0, "tint")
    );
    Known::new(name, &text, radiance)
}

fn quad(y: f64, material: &str) -> String {
    format!("quad(q: (-2e4, {y}, -2e4), u: (4e4, 0, 0), v: (0, 0, 4e4), material: \"{material}\"),")
}

fn triangles(y: f64, material: &str) -> String {
    format!(
        "triangles(vertices: [(-5e4, {y}, -5e4), (5e4, {y}, -5e4), (0, {y}, 9e4)], indices: [(0, 1, 2)], \
         material: \"{material}\"),"
    )
}

fn instance(y: f64) -> String {
    format!("instance(mesh: \"tint\", matrix: ((1, 0, 0, 0), (0, 1, 0, {y}), (0, 0, 1, 0))),")
}

const WALLS: &str = r#"sphere(center: (0, 0, 0), radius: 1e4, material: "wall"),"#;

/// Light samples and paths find the same light, which counts once in every mode.
#[test]
fn panes_let_their_share_of_light_through() {
    let reflected = 0.6 * 3.0;
    let known = |name: &str, panes: &[String], share: f64| {
        floor(name, &panes.concat(), "", WALLS, 2, reflected * share)
    };
    compare(
        "panes below walls of light",
        &[
            known("quad", &[quad(5.0, "tint")], 0.8),
            known("triangles", &[triangles(5.0, "tint")], 0.8),
            known("instance", &[instance(5.0)], 0.8),
            known("three", &[quad(5.0, "tint"), triangles(4.0, "tint"), instance(6.0)], 0.512),
            // The camera looks through this one, too.
            known("before the camera", &[quad(2.0, "tint")], 0.64),
        ],
    );
}

/// Lights that no path hits need shadow rays that pass.
#[test]
fn shadow_rays_pass_panes() {
    let sun = "distant(direction: (-0.6, -0.8, 0), irradiance: (4, 4, 4))";
    let lamp = "point(position: (3, 4, 0), intensity: (50, 50, 50))";
    let (sunlit, lit) = (0.6 / PI * 3.2, 0.6 / PI * 1.6);
    let passes = |cos: f64| 1.0 - (0.04 + 0.96 * (1.0 - cos).powi(5));
    let known = |name: &str, panes: &[String], light: &str, want: f64| {
        floor(name, &panes.concat(), light, "", 2, want)
    };
    let clear = |y| quad(y, "clear");
    compare_in(
        &[Sampling::Light, Sampling::Mis],
        "panes below lights",
        &[
            known("sun", &[clear(5.0)], sun, sunlit * passes(0.8)),
            known("lamp above", &[clear(3.9)], lamp, lit * passes(0.8)),
            known("camera above", &[clear(2.0)], lamp, lit * passes(0.8) * passes(0.6)),
            known("lamp below", &[clear(4.5)], lamp, lit),
            known("tint", &[quad(5.0, "tint"), clear(6.0)], sun, 0.8 * sunlit * passes(0.8)),
        ],
    );
}

/// A lamp is seen through panes on the first segment of a path.
#[test]
fn panes_count_no_segment() {
    let seen = |name: &str, panes: &[String], share: f64| {
        let all = panes.concat() + &quad(0.1, "wall");
        floor(name, &all, "", "", 1, 3.0 * share)
    };
    let stack: Vec<_> = (1..=4).map(|i| quad(0.2 + f64::from(i) / 20.0, "tint")).collect();
    compare_in(
        &[Sampling::Bsdf],
        "lamps behind panes",
        &[
            seen("one", &stack[..1], 0.8),
            seen("four", &stack[..4], 0.4096),
            seen("clear", &[quad(1.0, "clear")], 1.0 - (0.04 + 0.96 * 0.4_f64.powi(5))),
        ],
    );
}
