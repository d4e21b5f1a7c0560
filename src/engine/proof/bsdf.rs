//! How surfaces and media scatter light: samples, values and densities agree.

use glam::Vec3;

use super::{Cone, SAMPLES, Table, randoms};
use crate::engine::scalar::bsdf::{Arrival, Bsdf};
use crate::math::{Frame, dot, normalize, reflect};
use crate::scene::Material;

/// What a path arrives at, and how.
struct Case {
    name: String,
    bsdf: Bsdf,
    /// About which cells are finer.
    middle: Vec3,
}

fn cases() -> Vec<Case> {
    let (eta, k) = (Vec3::new(0.2, 0.9, 1.4), Vec3::new(3.9, 2.4, 1.6));
    let conductor = |alpha| (format!("conductor {alpha}"), Material::Conductor { eta, k, alpha });
    let metal = |fuzz| (format!("metal {fuzz}"), Material::Metal { albedo: 0, fuzz });
    let frosted = |ior, alpha| {
        (format!("rough_dielectric {ior} {alpha}"), Material::RoughDielectric { ior, alpha })
    };
    let materials = [
        ("diffuse".to_owned(), Material::Diffuse { albedo: 0 }),
        ("lambertian".to_owned(), Material::Lambertian { albedo: 0 }),
        metal(0.1),
        metal(0.5),
        metal(1.0),
        conductor(0.1),
        conductor(0.4),
        conductor(1.0),
        frosted(1.5, 0.15),
        frosted(1.5, 0.5),
        frosted(1.5, 1.0),
        frosted(0.7, 0.3),
    ];
    let normal = normalize(Vec3::new(0.3, -0.8, 0.5));
    let mut cases = Vec::new();
    for (name, material) in materials {
        for cos in [0.99f32, 0.6, 0.15] {
            let sin = (1.0 - cos * cos).sqrt();
            let direction = -Frame::new(normal).world(Vec3::new(0.6 * sin, 0.8 * sin, cos));
            let glass = matches!(material, Material::RoughDielectric { .. });
            for front in [true, false] {
                if !front && !glass {
                    continue;
                }
                let arrival = Arrival { direction, normal, front };
                let bsdf = Bsdf::new(&material, arrival, |_| Vec3::new(0.9, 0.6, 0.3));
                let side = if front { "" } else { " inside" };
                let name = format!("{name} {cos}{side}");
                cases.push(Case { name, bsdf, middle: reflect(direction, normal) });
            }
        }
    }
    let albedo = Vec3::new(0.9, 0.6, 0.3);
    cases.push(Case { name: "phase".to_owned(), bsdf: Bsdf::phase(albedo), middle: Vec3::Y });
    cases
}

#[test]
fn samples_have_their_density() {
    let mut table = Table::new("scattered directions");
    for (index, Case { name, bsdf, middle }) in cases().into_iter().enumerate() {
        let sample = |sample| Some(bsdf.sample(&randoms(index, sample))?.direction);
        let pdf = |direction| f64::from(bsdf.evaluate(direction).1);
        table.directions(&name, &Cone::all(middle), sample, pdf);
    }
    table.check();
}

/// The weight of a sample is f·|cos θ|/pdf, its density that of its direction, its side that on which
/// it leaves.
#[test]
fn samples_are_as_evaluated() {
    for (index, Case { name, bsdf, .. }) in cases().into_iter().enumerate() {
        let samples: Vec<_> =
            (0..20_000).filter_map(|sample| bsdf.sample(&randoms(index, sample))).collect();
        for scatter in samples {
            let (f_cos, pdf) = bsdf.evaluate(scatter.direction);
            // Rounded directions see other microfacets, and other shadows where they graze.
            let cos = dot(scatter.side, scatter.direction).abs();
            let near = |a: f32, b: f32| (a - b).abs() <= (1e-2 + f32::EPSILON / cos) * b.abs();
            assert!(near(pdf, scatter.pdf), "{name}: {pdf} {}", scatter.pdf);
            for (f, weight) in f_cos.to_array().into_iter().zip(scatter.weight.to_array()) {
                assert!(near(f, weight * scatter.pdf), "{name}: {f} {weight} {pdf}");
            }
            assert!(!(dot(scatter.side, scatter.direction) < 0.0), "{name}");
        }
    }
}

/// The mean weight of samples is the integral of f·|cos θ|: what of even light is scattered.
#[test]
fn weights_are_what_is_scattered() {
    for (index, Case { name, bsdf, middle }) in cases().into_iter().enumerate() {
        let (mut sum, mut squares) = (0.0, 0.0);
        for sample in 0..SAMPLES {
            let weight =
                bsdf.sample(&randoms(index, sample)).map_or(0.0, |s| f64::from(s.weight.y));
            (sum, squares) = (sum + weight, squares + weight * weight);
        }
        let n = f64::from(SAMPLES);
        let mean = sum / n;
        let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
        let f = |direction| f64::from(bsdf.evaluate(direction).0.y);
        let (cells, off) = Cone::all(middle).integrate(f);
        let (whole, bound) = (cells.iter().sum::<f64>(), 5.0 * error + off);
        assert!(off < 3e-3 && (mean - whole).abs() < bound, "{name}: {mean} ± {error}, {whole}");
    }
}

/// Light goes both ways alike: f is symmetric, which glass has to the other side but for η².
#[test]
fn scattering_is_reciprocal() {
    let normal = normalize(Vec3::new(0.3, -0.8, 0.5));
    let frame = Frame::new(normal);
    let (eta, k) = (Vec3::new(0.2, 0.9, 1.4), Vec3::new(3.9, 2.4, 1.6));
    for alpha in [0.1, 0.4, 1.0] {
        for material in
            [Material::Conductor { eta, k, alpha }, Material::RoughDielectric { ior: 1.5, alpha }]
        {
            let f = |from: Vec3, to: Vec3, front: bool| {
                let normal = if front { normal } else { -normal };
                let arrival = Arrival { direction: -from, normal, front };
                let bsdf = Bsdf::new(&material, arrival, |_| Vec3::ONE);
                bsdf.evaluate(to).0.y / dot(to, normal).abs()
            };
            for i in 0..200 {
                let (u, v) = randoms(i, 0).two(crate::engine::dimension::Dimension::SCATTER);
                let (s, t) = randoms(i, 1).two(crate::engine::dimension::Dimension::SCATTER);
                let upwards =
                    |u, v| frame.world(crate::math::warp::cosine_hemisphere(Vec3::Z, u, v).0);
                let (a, b) = (upwards(u, v), upwards(s, t));
                let (there, back) = (f(a, b, true), f(b, a, true));
                assert!((there - back).abs() < 1e-3 * (there + back) + 1e-6, "{there} {back}");
                if matches!(material, Material::RoughDielectric { .. }) {
                    // Without the scaling of radiance f from below is η² times that from above.
                    let (down, up) = (f(a, -b, true), f(-b, a, false));
                    assert!((down - up * 2.25).abs() < 2e-3 * (down + up) + 1e-5, "{down} {up}");
                }
            }
        }
    }
}
