//! Tests of scattering by surfaces and media: samples, values and densities agree.

use std::sync::Arc;

use glam::Vec3;

use super::{Cone, SAMPLES, Table, randoms};
use crate::geometry::{Geometry, Hit, Quad, Ray, Shape, Surface, Surfaces};
use crate::math::vector::orthonormal_basis;
use crate::math::{Frame, Stream, dot, normalize, reflect};
use crate::sampler::{Dimension, Randoms};
use crate::shading::material::{
    Bsdf, CoatedDiffuse, Conductor, Diffuse, DiffuseTransmission, Lambertian, MaterialModel,
    MaterialTable, MaterialTables, MaterialVisitor, Metal, Principled, RoughDielectric, Scatter,
};
use crate::shading::{Color, Interaction, Isotropic, Material, Number, ScatterNormals};

/// Scattering by a surface or a medium, with the type of its BSDF erased.
struct Scattering {
    sample: Sample,
    evaluate: Evaluate,
}

type Sample = Box<dyn Fn(&Randoms) -> Scatter<f32>>;
type Evaluate = Box<dyn Fn(Vec3) -> (Vec3, f32)>;

impl Scattering {
    fn new<B: Bsdf<f32> + 'static>(bsdf: B) -> Self {
        let bsdf = std::rc::Rc::new(bsdf);
        let same = std::rc::Rc::clone(&bsdf);
        Self {
            sample: Box::new(move |randoms| bsdf.sample(randoms)),
            evaluate: Box::new(move |direction| same.evaluate(direction)),
        }
    }

    fn sample(&self, randoms: &Randoms) -> Option<Scatter<f32>> {
        Some((self.sample)(randoms)).filter(|scatter| scatter.scattered)
    }

    fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        (self.evaluate)(direction)
    }
}

/// Returns the scattering by `material` at a point that a path reaches along `direction`. The
/// `normal` is on the side where the path arrives.
fn scattering(material: &Material, direction: Vec3, normal: Vec3, front: bool) -> Scattering {
    struct Visitor<'a>(Interaction<'a, f32>);

    impl MaterialVisitor for Visitor<'_> {
        type Output = Scattering;

        fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Scattering {
            Scattering::new(M::bsdf::<f32>(&table.entries, 0, &self.0))
        }
    }

    // A quad with texture coordinates, which give the directions of anisotropy.
    let (s, t) = orthonormal_basis(normal);
    let quads = vec![Quad::new(Vec3::ZERO, s, t).expect("a quad")];
    let at = Interaction {
        surfaces: &Surfaces::new(&Arc::new(Geometry { quads, ..Geometry::default() })),
        textures: None,
        ray: Ray { origin: Vec3::ZERO, direction, time: 0.0 },
        shape: Shape::Quad,
        hit: Hit::of(0, 1.0),
        surface: Surface::flat(direction, normal, 0.0),
        normal,
        normals: ScatterNormals { shading: normal, mirror: normal },
        smooth: false,
        soft: false,
        front,
    };
    let mut materials = MaterialTables::default();
    materials.push(material, &mut Default::default(), &mut Default::default());
    materials.visit(material.kind(), Visitor(at))
}

/// A surface or a medium, and the direction from which a path arrives.
struct Case {
    name: String,
    bsdf: Scattering,
    /// Surface normal on the side where the path arrives; `None` in media.
    normal: Option<Vec3>,
    /// Direction around which the chi-square cells ([`Cone`]) are smaller.
    middle: Vec3,
}

const ALBEDO: [f32; 3] = [0.9, 0.6, 0.3];

fn conductor(alpha: f32) -> Material {
    Conductor::new([0.2, 0.9, 1.4], [3.9, 2.4, 1.6], alpha).into()
}

fn cases() -> Vec<Case> {
    let metal = |fuzz| (format!("metal {fuzz}"), Metal::new(ALBEDO, fuzz).into());
    let frosted = |ior, alpha| {
        (format!("rough_dielectric {ior} {alpha}"), RoughDielectric::new(ior, alpha).into())
    };
    let principled = |name: &str, edit: fn(&mut Principled)| {
        let mut material = Principled { base_color: ALBEDO.into(), ..Principled::default() };
        edit(&mut material);
        (format!("principled {name}"), material.into())
    };
    let materials: [(String, Material); 27] = [
        ("diffuse".to_owned(), Diffuse { albedo: ALBEDO.into() }.into()),
        ("lambertian".to_owned(), Lambertian::new(ALBEDO).into()),
        metal(0.1),
        metal(0.5),
        metal(1.0),
        ("conductor 0.1".to_owned(), conductor(0.1)),
        ("conductor 0.4".to_owned(), conductor(0.4)),
        ("conductor 1".to_owned(), conductor(1.0)),
        frosted(1.5, 0.15),
        frosted(1.5, 0.5),
        frosted(1.5, 1.0),
        frosted(0.7, 0.3),
        (
            "diffuse_transmission".to_owned(),
            DiffuseTransmission::new([0.5, 0.3, 0.2], [0.3, 0.6, 0.1]).into(),
        ),
        ("coated_diffuse 0.2".to_owned(), CoatedDiffuse::new(ALBEDO, 0.2).into()),
        ("coated_diffuse 0.7".to_owned(), CoatedDiffuse::new(ALBEDO, 0.7).into()),
        principled("plastic", |_| ()),
        principled("rough plastic", |p| p.roughness = 1.0.into()),
        principled("metal", |p| (p.metalness, p.roughness) = (1.0.into(), 0.4.into())),
        principled("half metal", |p| (p.metalness, p.specular) = (0.5.into(), 0.3.into())),
        principled("coated", |p| {
            (p.coat, p.coat_roughness, p.coat_color) = (0.8.into(), 0.4.into(), [0.9, 0.8, 0.7]);
            p.roughness = 0.8.into();
        }),
        principled("glass", |p| p.transmission = 1.0.into()),
        principled("dim glass", |p| {
            (p.transmission, p.specular, p.roughness) = (1.0.into(), 0.5.into(), 0.7.into());
        }),
        principled("velvet", |p| {
            (p.sheen_color, p.sheen_roughness) = ([0.9, 0.3, 0.5].into(), 0.4.into());
        }),
        principled("leaf", |p| {
            p.diffuse_transmission = 0.6.into();
            p.diffuse_transmission_color = [0.3, 0.9, 0.2].into();
        }),
        principled("brushed", |p| {
            (p.metalness, p.roughness, p.anisotropy) = (1.0.into(), 0.4.into(), 0.8);
            p.anisotropy_rotation = 30.0;
        }),
        principled("thin glass", |p| (p.transmission, p.thin) = (1.0.into(), true)),
        principled("milky, coated glass", |p| {
            (p.transmission, p.coat, p.coat_roughness) = (0.5.into(), 0.5.into(), 0.5.into());
            (p.attenuation_color, p.attenuation_distance) = ([0.5, 0.6, 0.9], 2.0);
        }),
    ];
    let normal = normalize(Vec3::new(0.3, -0.8, 0.5));
    let mut cases = Vec::new();
    for (name, material) in materials {
        for cos in [0.99f32, 0.6, 0.15] {
            let sin = (1.0 - cos * cos).sqrt();
            let direction = -Frame::new(normal).world(Vec3::new(0.6 * sin, 0.8 * sin, cos));
            let glass = material.model().transmits();
            for front in [true, false] {
                if !front && !glass {
                    continue;
                }
                let bsdf = scattering(&material, direction, normal, front);
                let side = if front { "" } else { " inside" };
                let name = format!("{name} {cos}{side}");
                let middle = reflect(direction, normal);
                cases.push(Case { name, bsdf, normal: Some(normal), middle });
            }
        }
    }
    let phase = Scattering::new(Isotropic { albedo: Vec3::from(ALBEDO) });
    cases.push(Case { name: "phase".to_owned(), bsdf: phase, normal: None, middle: Vec3::Y });
    cases
}

#[test]
fn samples_have_their_density() {
    let mut table = Table::new("scattered directions");
    for (index, Case { name, bsdf, middle, .. }) in cases().into_iter().enumerate() {
        let sample = |sample| Some(bsdf.sample(&randoms(index, sample))?.direction);
        let pdf = |direction| f64::from(bsdf.evaluate(direction).1);
        table.directions(&name, &Cone::all(middle), sample, pdf);
    }
    table.check();
}

/// The weight of a sample is f·|cos θ|/pdf, its density is the pdf of its direction, and it
/// is marked as transmitted if its direction is on the other side of the surface.
#[test]
fn samples_are_as_evaluated() {
    for (index, Case { name, bsdf, normal, .. }) in cases().into_iter().enumerate() {
        let samples: Vec<_> =
            (0..20_000).filter_map(|sample| bsdf.sample(&randoms(index, sample))).collect();
        for scatter in samples {
            let (f_cos, pdf) = bsdf.evaluate(scatter.direction);
            // Rounding a direction changes the normal of the microfacets that scatter into it and,
            // at grazing angles, their shadowing.
            let cos = normal.map_or(1.0, |normal| dot(normal, scatter.direction));
            let near =
                |a: f32, b: f32| (a - b).abs() <= (1e-2 + f32::EPSILON / cos.abs()) * b.abs();
            assert!(near(pdf, scatter.pdf), "{name}: {pdf} {}", scatter.pdf);
            for (f, weight) in f_cos.to_array().into_iter().zip(scatter.weight.to_array()) {
                assert!(near(f, weight * scatter.pdf), "{name}: {f} {weight} {pdf}");
            }
            let outside = if scatter.transmitted { cos <= 0.0 } else { cos >= 0.0 };
            assert!(outside, "{name}");
        }
    }
}

/// The mean weight of samples is the integral of f·|cos θ|: the share of uniform light that is
/// scattered.
#[test]
fn weights_are_what_is_scattered() {
    for (index, Case { name, bsdf, middle, .. }) in cases().into_iter().enumerate() {
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

/// Scattering is reciprocal: f is symmetric, except for a factor of η² in transmission through
/// glass. Coats, sheens and rough glass of `principled` are not: what they leave to other lobes, or add to them,
/// depends on the viewer's side alone.
#[test]
fn scattering_is_reciprocal() {
    let normal = normalize(Vec3::new(0.3, -0.8, 0.5));
    let frame = Frame::new(normal);
    for alpha in [0.1f32, 0.4, 1.0] {
        let roughness: Number = alpha.sqrt().into();
        let base_color = Color::from(ALBEDO);
        let plastic = Principled { roughness, base_color, ..Principled::default() };
        let glass = RoughDielectric::new(1.5, alpha);
        for (material, transmits) in
            [(conductor(alpha), false), (plastic.into(), false), (glass.into(), true)]
        {
            let f = |from: Vec3, to: Vec3, front: bool| {
                let normal = if front { normal } else { -normal };
                let bsdf = scattering(&material, -from, normal, front);
                bsdf.evaluate(to).0.y / dot(to, normal).abs()
            };
            for i in 0..200 {
                let (u, v) = randoms(i, 0).two(Dimension::SCATTER);
                let (s, t) = randoms(i, 1).two(Dimension::SCATTER);
                let upwards =
                    |u, v| frame.world(crate::math::warp::cosine_hemisphere(Vec3::Z, u, v).0);
                let (a, b) = (upwards(u, v), upwards(s, t));
                let (there, back) = (f(a, b, true), f(b, a, true));
                assert!((there - back).abs() < 1e-3 * (there + back) + 1e-6, "{there} {back}");
                if transmits {
                    // Radiance is not scaled, so f of a path that enters the glass from above is η²
                    // times f of the reversed path.
                    let (down, up) = (f(a, -b, true), f(-b, a, false));
                    assert!((down - up * 2.25).abs() < 2e-3 * (down + up) + 1e-5, "{down} {up}");
                }
            }
        }
    }
}

/// Follows light at random through a coat to a diffuse base and back, as pbrt does, and compares the
/// share of the light that comes back with that of `coated_diffuse`. At rough coats, the walk loses
/// light between microfacets, which `coated_diffuse` does not.
#[test]
fn coats_scatter_about_as_much_as_a_random_walk() {
    const WALKS: u32 = 20_000;
    let mut worst = 0.0;
    println!("\nroughness  rho  cosine    walk  coated");
    for roughness in [0.1f32, 0.4, 0.7] {
        let glass: Material = RoughDielectric::new(1.5, roughness * roughness).into();
        for rho in [0.2f32, 0.5, 0.9] {
            let coated: Material = CoatedDiffuse::new([rho; 3], roughness).into();
            for cos in [0.95f32, 0.6, 0.3] {
                let down = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
                let walk = |sample: u32| {
                    let (mut direction, mut weight, mut outside) = (down, 1.0, true);
                    for step in 0..100 {
                        let normal = if outside { Vec3::Z } else { -Vec3::Z };
                        let bsdf = scattering(&glass, direction, normal, outside);
                        let randoms = randoms(step, sample);
                        let Some(scatter) = bsdf.sample(&randoms) else { return 0.0 };
                        weight *= scatter.weight.y;
                        if scatter.direction.z > 0.0 {
                            return weight;
                        }
                        weight *= rho;
                        let (u, v) = randoms.two(Dimension::LIGHT);
                        direction = crate::math::warp::cosine_hemisphere(Vec3::Z, u, v).0;
                        outside = false;
                    }
                    0.0
                };
                let albedo = |sample: u32| {
                    let bsdf = scattering(&coated, down, Vec3::Z, true);
                    bsdf.sample(&randoms(0, sample)).map_or(0.0, |scatter| scatter.weight.y)
                };
                let mean = |f: &dyn Fn(u32) -> f32| {
                    (0..WALKS).map(|sample| f64::from(f(sample))).sum::<f64>() / f64::from(WALKS)
                };
                let (walked, modelled) = (mean(&walk), mean(&albedo));
                println!("{roughness:>9}{rho:>5}{cos:>8}{walked:>8.3}{modelled:>8.3}");
                assert!(modelled > walked - 0.02, "{roughness} {rho} {cos}: {walked} {modelled}");
                if roughness < 0.2 {
                    worst = f64::max(worst, (walked - modelled).abs());
                }
            }
        }
    }
    assert!(worst < 0.02, "{worst}");
}

/// Glass reflects all light that arrives from inside at a grazing angle, whatever reflects outside.
#[test]
fn principled_glass_reflects_totally() {
    for (index, specular) in (0..).zip([0.0, 0.1, 1.0]) {
        for coat in [0.0, 0.6] {
            let mut material = Principled { base_color: [1.0; 3].into(), ..Principled::default() };
            (material.roughness, material.transmission) = (0.0.into(), 1.0.into());
            (material.specular, material.coat) = (specular.into(), coat.into());
            let direction = Vec3::new(0.8, 0.0, -0.6);
            let bsdf = scattering(&material.into(), direction, Vec3::Z, false);
            let weights = (0..1000)
                .map(|sample| bsdf.sample(&randoms(index, sample)).map_or(0.0, |s| s.weight.y));
            let weights: Vec<f32> = weights.collect();
            let mean = weights.iter().sum::<f32>() / 1000.0;
            let most = weights.iter().copied().fold(0.0, f32::max);
            let expected = if coat > 0.0 { 0.8..1.01 } else { 0.999..1.001 };
            assert!(expected.contains(&mean) && most < 2.0, "{specular} {coat}: {mean}, {most}");
        }
    }
}

/// White `principled` surfaces never scatter more light than arrives, from outside or inside, beyond the errors of the
/// tables.
#[test]
fn principled_gains_no_light() {
    let mut random = Stream::new(4);
    for index in 0..300 {
        let mut one_of = |values: &[f32]| values[random.bits() as usize % values.len()];
        let mut material = Principled { base_color: [1.0; 3].into(), ..Principled::default() };
        material.roughness = one_of(&[0.0, 0.2, 0.5, 1.0]).into();
        material.metalness = one_of(&[0.0, 0.0, 0.5, 1.0]).into();
        material.transmission = one_of(&[0.0, 0.3, 0.7, 1.0]).into();
        material.specular = one_of(&[0.0, 0.3, 1.0]).into();
        material.coat = one_of(&[0.0, 0.0, 0.6]).into();
        material.coat_roughness = one_of(&[0.0, 0.5]).into();
        material.sheen_color = [one_of(&[0.0, 0.0, 1.0]); 3].into();
        material.sheen_roughness = one_of(&[0.1, 0.5, 1.0]).into();
        material.diffuse_transmission = one_of(&[0.0, 0.0, 0.4]).into();
        material.anisotropy = one_of(&[0.0, 0.0, 0.8]);
        material.ior = one_of(&[1.1, 1.5, 2.5]);
        material.thin = one_of(&[0.0, 1.0]) > 0.5;
        let cos = one_of(&[0.97, 0.7, 0.5, 0.2, 0.05]);
        let direction = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
        for front in [true, false] {
            let bsdf = scattering(&material.clone().into(), direction, Vec3::Z, front);
            let (mut sum, mut squares) = (0.0, 0.0);
            const COUNT: u32 = 4000;
            for sample in 0..COUNT {
                let weight = bsdf.sample(&randoms(index, sample)).map_or(0.0, |s| s.weight.y);
                (sum, squares) =
                    (sum + f64::from(weight), squares + f64::from(weight) * f64::from(weight));
            }
            let mean = sum / f64::from(COUNT);
            let variance = (squares / f64::from(COUNT) - mean * mean).max(0.0);
            let error = (variance / f64::from(COUNT)).sqrt();
            // The table of what rough glass keeps is coarser than the others, and the light that brushed metal
            // reflects more than once is that of a mean.
            let most = match (material.transmission.is_zero(), material.anisotropy == 0.0) {
                (_, false) => 1.05,
                (false, _) => 1.015,
                _ => 1.005,
            };
            assert!(mean < most + 4.0 * error, "{material:?} {cos} {front}: {mean} ± {error}");
        }
    }
}
