//! Glass that absorbs light, hardly bends it and does not reflect it. Beer's law gives the radiance.
//!
//! Mitsuba 3.9.1 (volpath) gives 0.553, 0.318 and 0.183 where the law gives 0.551, 0.317 and 0.182 for a lamp in
//! a ball of glass with an index of 1.5.

use ptfast::Sampling;

use super::{Known, compare, compare_in};

/// Primitives seen along −z from a height of `from`, between walls of radiance 3 at a distance of 10. `glass`
/// absorbs `e^(−t/2)`, and `clear` nothing.
fn scene(name: &str, from: f32, primitives: &str, absorbed: f64) -> Known {
    let glass = "base_color: (1, 1, 1), transmission: 1, roughness: 0, ior: 1.01, specular: 0";
    let half = (-0.5_f64).exp() as f32;
    let text = format!(
        r#"(camera: (look_from: (0, 0, {from}), look_at: (0, 0, -99), vfov: 0.02),
            materials: {{
                "wall": light(radiance: (3, 3, 3)),
                "matte": lambertian(albedo: (0.8, 0.8, 0.8)),
                "glass": principled({glass}, attenuation_color: ({half}, {half}, {half}), attenuation_distance: 1),
                "weak": principled({glass}, attenuation_color: ({half}, {half}, {half}), attenuation_distance: 5),
                "clear": principled({glass})}},
            primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall"), {primitives}])"#
    );
    Known::new(name, &text, 3.0 * (-absorbed).exp())
}

fn ball(z: f32, radius: f32, material: &str) -> String {
    format!("sphere(center: (0, 0, {z}), radius: {radius}, material: \"{material}\"),")
}

#[test]
fn segments_absorb_whatever_ends_them() {
    let balls = |balls: &[String]| balls.concat();
    let glass = ball(0.0, 1.0, "glass");
    // Light samples rarely fit the narrow lobe.
    compare_in(
        &[Sampling::Bsdf],
        "absorption",
        &[
            scene("through a ball", 5.0, &glass, 1.0),
            scene("weak", 5.0, &ball(0.0, 1.0, "weak"), 0.2),
            scene("lamp in a ball", 5.0, &balls(&[glass.clone(), ball(0.0, 0.4, "wall")]), 0.3),
            scene("bubble", 5.0, &balls(&[glass.clone(), ball(0.0, 0.5, "clear")]), 0.5),
            scene("nested", 5.0, &balls(&[glass.clone(), ball(0.0, 0.5, "weak")]), 0.5 + 0.1),
            // The ray enters the weak glass at z = 2 and the strong one at z = 1, which counts to its end.
            scene("overlapping", 5.0, &balls(&[glass.clone(), ball(1.0, 1.0, "weak")]), 0.1 + 1.0),
            scene("camera in glass", 0.0, &glass, 0.5),
            scene("camera in two", 0.0, &balls(&[glass, ball(0.0, 0.5, "weak")]), 0.05 + 0.25),
        ],
    );
}

/// The camera, the surface and the walls are all in the glass, so that shadow rays cross it.
#[test]
fn shadow_rays_are_absorbed() {
    let inside = |name: &str, primitives: &str, absorbed: f64| {
        let all = format!("{} {primitives}", ball(0.0, 20.0, "weak"));
        let Known { scene, want, name } = scene(name, 3.0, &all, absorbed);
        Known { scene, name, want: 0.8 * want }
    };
    let tile = r#"quad(q: (-0.05, -0.05, 0), u: (0.1, 0, 0), v: (0, 0.1, 0), material: "matte")"#;
    compare("absorption of direct light", &[inside("tile", tile, 1.3)]);
}
