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
/// refract. `alpha` is the roughness towards the light that is seen, and across.
fn microfacets([ax, ay]: [f64; 2], reflectance: impl Fn(f64) -> f64, eta: Option<f64>) -> f64 {
    let smith = |w: [f64; 3]| {
        let slope2 = ((ax * w[0]).powi(2) + (ay * w[1]).powi(2)) / (w[2] * w[2]);
        (-1.0 + (1.0 + slope2).sqrt()) / 2.0
    };
    let wo = [(1.0 - COS * COS).sqrt(), 0.0, COS];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (rows, columns) = (1500, 1500);
    let mut sum = 0.0;
    for i in 0..rows {
        // With slopes of the length √(1 − w²)/w, times the roughness along each axis, D(m) cos θ is uniform in
        // 1 − w². Equal steps of w, with the weight 2w, sample grazing normals more finely than equal steps of
        // 1 − w².
        let w = (f64::from(i) + 0.5) / f64::from(rows);
        let slope = (1.0 - w * w).sqrt() / w;
        for j in 0..columns {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns);
            let slopes = [ax * slope * phi.cos(), ay * slope * phi.sin()];
            let cos = 1.0 / (1.0 + slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
            let m = [slopes[0] * cos, slopes[1] * cos, cos];
            let before = dot(wo, m);
            if before <= 0.0 {
                continue;
            }
            // The area visible from wo without masking: D (wo·m)/(cos θo) over D cos θ.
            let visible = before / (COS * cos) * 2.0 * w;
            let share = reflectance(before);
            let mirrored = [0, 1, 2].map(|i| 2.0 * before * m[i] - wo[i]);
            if mirrored[2] > 0.0 {
                sum += visible * share / (1.0 + smith(wo) + smith(mirrored));
            }
            if let Some(eta) = eta {
                let sin2 = (1.0 - before * before) / (eta * eta);
                let along = before / eta - (1.0 - sin2).max(0.0).sqrt();
                let refracted = [0, 1, 2].map(|i| along * m[i] - wo[i] / eta);
                if refracted[2] < 0.0 && sin2 < 1.0 {
                    sum += visible * (1.0 - share) / ((1.0 + smith(wo)) * (1.0 + smith(refracted)));
                }
            }
        }
    }
    sum / f64::from(rows * columns)
}

/// The share of uniform light that white fibres reflect, by the distribution of Estevez and Kulla (2017) and the
/// shadowing of Neubelt and Pettineo (2013), as `KHR_materials_sheen` gives them.
fn fibres(roughness: f64) -> f64 {
    let (alpha, steps) = (roughness * roughness, 2000);
    let mut sum = 0.0;
    for i in 0..steps {
        let z = (f64::from(i) + 0.5) / f64::from(steps);
        for j in 0..steps {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(steps);
            let across = (1.0 - z * z).sqrt();
            let half = [0.8 + across * phi.cos(), across * phi.sin(), COS + z];
            let sin2 = (half[0] * half[0] + half[1] * half[1])
                / (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
            let density = (2.0 + 1.0 / alpha) * sin2.powf(0.5 / alpha) / (2.0 * PI);
            sum += density * z / (4.0 * (z + COS - z * COS));
        }
    }
    sum * 2.0 * PI / f64::from(steps * steps)
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
    // α is 0.3 across the direction of the anisotropy, and 0.3 + 0.7 · 0.5 along it.
    let brushed = |degrees: u32| {
        format!(
            "principled(base_color: (0, 0, 0), roughness: 0.54772256, specular_color: (10, 10, 10),
                        anisotropy: 0.70710678, anisotropy_rotation: {degrees})"
        )
    };
    let plastic = |cos: f64| 0.4 + 0.6 * (1.0 - cos).powi(5);
    compare(
        "furnace",
        &[
            known("diffuse(albedo: (0.8, 0.8, 0.8))", 0.8),
            known(
                "diffuse_transmission(reflectance: (0.5, 0.5, 0.5), transmittance: (0.2, 0.2, 0.2))",
                0.7,
            ),
            known("diffuse_transmission(reflectance: \"white\", transmittance: \"white\")", 1.0),
            known(thin, microfacets([0.36; 2], |_| 1.0, None)),
            known("lambertian(albedo: (0.8, 0.8, 0.8))", 0.8),
            known("metal(albedo: (0.9, 0.9, 0.9))", 0.9),
            // Whatever the microfacets of plastic do not reflect, a white base scatters, and white
            // metal loses nothing between microfacets.
            known("principled(base_color: (1, 1, 1), roughness: 0.3)", 1.0),
            known("coated_diffuse(reflectance: (1, 1, 1), roughness: 0.5)", 1.0),
            known("principled(base_color: (1, 1, 1), roughness: 0.9, ior: 2)", 1.0),
            known("principled(base_color: (1, 1, 1), metalness: 1, roughness: 0.7)", 1.0),
            // A coat and a sheen leave to the layers below what they do not reflect themselves.
            known(
                "principled(base_color: (0.5, 0.5, 0.5), specular: 0, coat: 1, coat_roughness: 0.5)",
                0.5 + 0.5 * microfacets([0.25; 2], |cos| 0.04 + 0.96 * (1.0 - cos).powi(5), None),
            ),
            known(
                "principled(base_color: (1, 1, 1), metalness: 1, roughness: 0.7, coat: 1, coat_roughness: 0.5)",
                1.0,
            ),
            known("principled(base_color: (1, 1, 1), coat: 0.7, coat_roughness: 0.6)", 1.0),
            known(
                "principled(base_color: (0, 0, 0), specular: 0, sheen_color: (0.7, 0.7, 0.7), sheen_roughness: 0.6)",
                0.7 * fibres(0.6),
            ),
            known(
                "principled(base_color: (1, 1, 1), sheen_color: \"white\", sheen_roughness: 0.8)",
                1.0,
            ),
            known(
                "principled(base_color: (0.8, 0.8, 0.8), specular: 0, diffuse_transmission: 0.75,
                            diffuse_transmission_color: (0.4, 0.4, 0.4))",
                0.5,
            ),
            known(
                "principled(base_color: (0, 0, 0), specular: 0.5, specular_color: (5, 5, 5))",
                microfacets([0.25; 2], |cos| 0.5 * (0.2 + 0.8 * (1.0 - cos).powi(5)), None),
            ),
            known(
                "principled(base_color: (0, 0, 0), specular_color: (50, 50, 50))",
                microfacets([0.25; 2], |_| 1.0, None),
            ),
            // The root of (n − 1)/(n + 1) is 5/11 of its largest value, a node of the table, as is the roughness, and
            // the cosine nearly so.
            known(
                "principled(base_color: (1, 1, 1), roughness: 0.6, transmission: 1, ior: 1.2304147)",
                1.0,
            ),
            known(
                "principled(base_color: (1, 1, 1), roughness: 0.6, transmission: 0.5, ior: 1.2304147)",
                1.0,
            ),
            known(&brushed(0), microfacets([0.65, 0.3], plastic, None)),
            known(&brushed(90), microfacets([0.3, 0.65], plastic, None)),
            known("metal(albedo: (0.9, 0.9, 0.9), fuzz: 0.5)", 0.9),
            known("metal(albedo: (0.9, 0.9, 0.9), fuzz: 0.9)", 0.9 * (1.0 - cap)),
            known("dielectric(ior: 1.5)", 1.0),
            known("dielectric(ior: 1.5, fresnel: exact)", 1.0),
            known(&metal("0"), gold(COS)),
            known(&metal("0.3"), microfacets([0.3; 2], gold, None)),
            known(&metal("0.8"), microfacets([0.8; 2], gold, None)),
            known(
                "rough_dielectric(ior: 1.5, alpha: 0.3)",
                microfacets([0.3; 2], glass, Some(1.5)),
            ),
            known(
                "rough_dielectric(ior: 1.5, alpha: 0.8)",
                microfacets([0.8; 2], glass, Some(1.5)),
            ),
            known("rough_dielectric(ior: 0.7, alpha: 0.5)", {
                microfacets([0.5; 2], |cos| dielectric(cos, 0.7), Some(0.7))
            }),
            Known::new("reflection by Schlick", &reflection("schlick"), 3.0 * schlick),
            Known::new("reflection by Fresnel", &reflection("exact"), 3.0 * glass(COS)),
        ],
    );
}
