//! Tests of media: scattering media lose no energy, and absorption follows Beer's law.

use super::{Known, compare};

/// A ball of radius 1 in a hollow sphere of radiance 3, seen through its middle.
fn ball(medium: &str) -> String {
    format!(
        r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 0.02),
            materials: {{"wall": light(radiance: (3, 3, 3))}},
            primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall")],
            media: [{medium}])"#
    )
}

/// A floor, a ball lamp of radius 2 whose centre is 6 above it, and a slab of fog between them.
fn slab(density: f64) -> String {
    format!(
        r#"(camera: (look_from: (0, 0.1, 0), look_at: (0, -1, 0), up: (0.1, 1, 0.2), vfov: 0.02),
            materials: {{"floor": lambertian(albedo: (0.6, 0.6, 0.6)), "lamp": light(radiance: (8, 8, 8))}},
            primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"),
                         sphere(center: (0, 5, 0), radius: 2, material: "lamp")],
            media: [box(min: (-9, 1, -9), max: (9, 2.5, 9), density: {density}, albedo: (0, 0, 0))])"#
    )
}

#[test]
fn media_take_what_they_should() {
    let sphere = |density: f64, albedo: f64| {
        let albedo = format!("({albedo}, {albedo}, {albedo})");
        ball(&format!("sphere(center: (0, 0, 0), radius: 1, density: {density}, albedo: {albedo})"))
    };
    let turned = "box(min: (-1, -1, -1), max: (1, 1, 1), rotation: (0, 0, 45), density: 0.8, albedo: (1, 1, 1))";
    let two = "box(min: (-1, -1, -1), max: (1, 1, 0), density: 0.5, albedo: (0, 0, 0)), \
               sphere(center: (0, 0, 2), radius: 1, density: 0.3, albedo: (0, 0, 0))";
    // The floor's radiance: 2ρL ∫ cos θ e^(−σd/cos θ) sin θ dθ over the angles θ at which it sees
    // the lamp. The variable of the numerical integration is cos θ.
    let lit = |density: f64| {
        let (rim, steps) = ((1.0f64 - 1.0 / 9.0).sqrt(), 10_000);
        let cosines =
            (0..steps).map(|i| rim + (1.0 - rim) * (f64::from(i) + 0.5) / f64::from(steps));
        let sum: f64 = cosines.map(|cos| cos * (-1.5 * density / cos).exp()).sum();
        2.0 * 0.6 * 8.0 * sum * (1.0 - rim) / f64::from(steps)
    };
    compare(
        "media",
        &[
            Known::new("white fog in a furnace", &sphere(1.5, 1.0), 3.0),
            Known::new("white fog in a turned box", &ball(turned), 3.0),
            Known::new("black fog", &sphere(0.7, 0.0), 3.0 * (-1.4f64).exp()),
            Known::new("two black fogs", &ball(two), 3.0 * (-1.1f64).exp()),
            Known::new("light through a slab", &slab(0.4), lit(0.4)),
        ],
    );
}
