//! Furnace tests: the radiance of surfaces under uniform light from all sides.
//!
//! Divided by the radiance of the light, it is the share of light that the surface scatters. Closed
//! forms or numerical integrals of textbook formulas give the expected share.

use std::f64::consts::PI;

use super::{Known, compare};

/// A quad at the origin, seen at an angle of cosine 0.6, in a hollow sphere of radiance 3.
fn room(material: &str) -> String {
    format!(
        r#"(camera: (look_from: (0, 0.6, 0.8), look_at: (0, 0, 0), up: (1, 0, 0), vfov: 0.02),
            textures: {{"white": uv_checker(odd: (1, 1, 1), even: (1, 1, 1), scale: (1, 1))}},
            materials: {{"m": {material}, "wall": light(radiance: (3, 3, 3))}},
            primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall"),
                         quad(q: (-5, 0, -5), u: (0, 0, 10), v: (10, 0, 0), material: "m")])"#
    )
}

const COS: f64 = 0.6;

/// Fresnel reflectance of a dielectric.
fn dielectric(cos: f64, eta: f64) -> f64 {
    let sin2 = (1.0 - cos * cos) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let refracted = (1.0 - sin2).sqrt();
    let across = (cos - eta * refracted) / (cos + eta * refracted);
    let parallel = (eta * cos - refracted) / (eta * cos + refracted);
    0.5 * (across * across + parallel * parallel)
}

/// Fresnel reflectance of a conductor.
fn conductor(cos: f64, n: f64, k: f64) -> f64 {
    // (a + bi)² = (n + ki)² − sin²: a + bi is the index times the complex cosine of refraction.
    let (p, q) = (n * n - k * k - (1.0 - cos * cos), 2.0 * n * k);
    let length = (p * p + q * q).sqrt();
    let (a2, b2) = (0.5 * (length + p), 0.5 * (length - p));
    let across = ((cos - a2.sqrt()).powi(2) + b2) / ((cos + a2.sqrt()).powi(2) + b2);
    let tangent = (1.0 - cos * cos).sqrt() * (1.0 - cos * cos).sqrt() / cos;
    let parallel =
        across * ((a2.sqrt() - tangent).powi(2) + b2) / ((a2.sqrt() + tangent).powi(2) + b2);
    0.5 * (across + parallel)
}

/// The share of uniform light that microfacets scatter (Walter et al. 2007).
///
/// Integrates over the normals of the microfacets: the visible area of the microfacets with a
/// normal, times the share of light that they reflect or, with an index of refraction `eta`,
/// refract.
fn microfacets(alpha: f64, reflectance: impl Fn(f64) -> f64, eta: Option<f64>) -> f64 {
    let smith = |z: f64| (-1.0 + (1.0 + alpha * alpha * (1.0 - z * z) / (z * z)).sqrt()) / 2.0;
    let wo = [(1.0 - COS * COS).sqrt(), 0.0, COS];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (rows, columns) = (1500, 1500);
    let mut sum = 0.0;
    for i in 0..rows {
        // With tan²θ = α² (1 − w²)/w², D(m) cos θ is uniform in 1 − w². Equal steps of w, with the
        // weight 2w, sample grazing normals more finely than equal steps of 1 − w².
        let w = (f64::from(i) + 0.5) / f64::from(rows);
        let cos = 1.0 / (1.0 + alpha * alpha * (1.0 - w * w) / (w * w)).sqrt();
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..columns {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns);
            let m = [sin * phi.cos(), sin * phi.sin(), cos];
            let before = dot(wo, m);
            if before <= 0.0 {
                continue;
            }
            // The area visible from wo without masking: D (wo·m)/(cos θo) over D cos θ.
            let visible = before / (COS * cos) * 2.0 * w;
            let share = reflectance(before);
            let up = 2.0 * before * m[2] - COS;
            if up > 0.0 {
                sum += visible * share / (1.0 + smith(COS) + smith(up));
            }
            if let Some(eta) = eta {
                let sin2 = (1.0 - before * before) / (eta * eta);
                let along = before / eta - (1.0 - sin2).max(0.0).sqrt();
                let down = along * m[2] - COS / eta;
                if down < 0.0 && sin2 < 1.0 {
                    sum += visible * (1.0 - share) / ((1.0 + smith(COS)) * (1.0 + smith(-down)));
                }
            }
        }
    }
    sum / f64::from(rows * columns)
}

/// Glass in front of a black wall, so that only the reflected light is seen.
fn reflection(fresnel: &str) -> String {
    format!(
        r#"(camera: (look_from: (0, 0.6, 0.8), look_at: (0, 0, 0), up: (1, 0, 0), vfov: 0.02),
            materials: {{"m": dielectric(ior: 1.5, fresnel: {fresnel}), "wall": light(radiance: (3, 3, 3)),
                         "black": lambertian(albedo: (0, 0, 0))}},
            primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall"),
                         quad(q: (-9, -0.1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "black"),
                         quad(q: (-5, 0, -5), u: (0, 0, 10), v: (10, 0, 0), material: "m")])"#
    )
}

#[test]
fn materials_scatter_what_they_should() {
    let known = |material: &str, share: f64| Known::new(material, &room(material), 3.0 * share);
    // The blurred directions fill a ball. Its cap below the surface is lost.
    let height = COS / 0.9;
    let cap = (1.0 - height) * (1.0 - height) * (2.0 + height) / 4.0;
    let metal =
        |alpha: &str| format!("conductor(eta: (1, 0.9, 1), k: (3, 2.4, 3), alpha: {alpha})");
    let gold = |cos| conductor(cos, 0.9, 2.4);
    let glass = |cos| dielectric(cos, 1.5);
    let schlick = 0.04 + 0.96 * (1.0 - COS).powi(5);
    let thin = "principled(base_color: (1, 1, 1), transmission: 1, thin: true, roughness: 0.6)";
    compare(
        "furnace",
        &[
            known("diffuse(albedo: (0.8, 0.8, 0.8))", 0.8),
            known(
                "diffuse_transmission(reflectance: (0.5, 0.5, 0.5), transmittance: (0.2, 0.2, 0.2))",
                0.7,
            ),
            known("diffuse_transmission(reflectance: \"white\", transmittance: \"white\")", 1.0),
            known(thin, microfacets(0.36, |_| 1.0, None)),
            known("lambertian(albedo: (0.8, 0.8, 0.8))", 0.8),
            known("metal(albedo: (0.9, 0.9, 0.9))", 0.9),
            // Whatever the microfacets of plastic do not reflect, a white base scatters, and white
            // metal loses nothing between microfacets.
            known("principled(base_color: (1, 1, 1), roughness: 0.3)", 1.0),
            known("coated_diffuse(reflectance: (1, 1, 1), roughness: 0.5)", 1.0),
            known("principled(base_color: (1, 1, 1), roughness: 0.9, ior: 2)", 1.0),
            known("principled(base_color: (1, 1, 1), metalness: 1, roughness: 0.7)", 1.0),
            known("metal(albedo: (0.9, 0.9, 0.9), fuzz: 0.5)", 0.9),
            known("metal(albedo: (0.9, 0.9, 0.9), fuzz: 0.9)", 0.9 * (1.0 - cap)),
            known("dielectric(ior: 1.5)", 1.0),
            known("dielectric(ior: 1.5, fresnel: exact)", 1.0),
            known(&metal("0"), gold(COS)),
            known(&metal("0.3"), microfacets(0.3, gold, None)),
            known(&metal("0.8"), microfacets(0.8, gold, None)),
            known("rough_dielectric(ior: 1.5, alpha: 0.3)", microfacets(0.3, glass, Some(1.5))),
            known("rough_dielectric(ior: 1.5, alpha: 0.8)", microfacets(0.8, glass, Some(1.5))),
            known("rough_dielectric(ior: 0.7, alpha: 0.5)", {
                microfacets(0.5, |cos| dielectric(cos, 0.7), Some(0.7))
            }),
            Known::new("reflection by Schlick", &reflection("schlick"), 3.0 * schlick),
            Known::new("reflection by Fresnel", &reflection("exact"), 3.0 * glass(COS)),
        ],
    );
}
