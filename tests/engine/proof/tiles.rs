//! Tests that sampling modes agree in every tile of a picture.
//!
//! Differences must match the noise, and p-values must be uniform.

use ptfast::{Engine, ImageSettings, Renderer, Sampler, Sampling, Scene};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use super::{ALARM, farthest, first_seed};

/// Number of tiles along each side.
const TILES: u32 = 8;
/// Number of independent pictures per mode.
const PICTURES: u64 = 24;

/// For each tile and channel, the mean over pictures and the variance of that mean.
pub(crate) struct Tiles {
    pub(crate) tiles: Vec<(f64, f64)>,
    pub(crate) pictures: u64,
}

impl Tiles {
    /// Renders `scene` at its own size, which the number of tiles must divide. Uses Sobol' points if
    /// lights are sampled, and independent numbers for scattering alone.
    pub(crate) fn render(name: &str, scene: &Scene, sampling: Sampling, spp: u32) -> Self {
        let first = first_seed(&format!("{name}{sampling:?} tiles"));
        let sampler =
            if sampling == Sampling::Bsdf { Sampler::Independent } else { Sampler::Sobol };
        let base = ImageSettings { spp, sampling, sampler, ..ImageSettings::of(scene) };
        let (across, down) = (base.width / TILES, base.height / TILES);
        let picture = |index: u64| {
            let settings = ImageSettings { seed: first.wrapping_add(index), ..base.clone() };
            let render =
                Renderer::new(scene, settings, Engine::Wavefront).unwrap().render().unwrap();
            assert_eq!(render.tally.non_finite.count, 0, "{name}");
            let mut sums = vec![0.0f64; (TILES * TILES * 3) as usize];
            for (place, pixel) in (0..).zip(render.image.pixels()) {
                let tile = place / base.width / down * TILES + place % base.width / across;
                for (channel, value) in (0..).zip(pixel) {
                    sums[(3 * tile + channel) as usize] += f64::from(*value);
                }
            }
            sums
        };
        let pictures: Vec<Vec<f64>> = (0..PICTURES).map(picture).collect();
        let n = PICTURES as f64;
        let of = |tile: usize| {
            let values = pictures.iter().map(|sums| sums[tile] / f64::from(across * down));
            let mean = values.clone().sum::<f64>() / n;
            let squares = values.map(|value| (value - mean) * (value - mean)).sum::<f64>();
            (mean, squares / (n - 1.0) / n)
        };
        Self { tiles: (0..(TILES * TILES * 3) as usize).map(of).collect(), pictures: PICTURES }
    }
}

/// Whether the noise of a tile exceeds rounding errors.
fn noisy(&(mean, variance): &(f64, f64)) -> bool {
    variance.sqrt() > 1e-6 * mean
}

/// The differences of tiles in units of their noise, as normal deviates: Student's t with Welch's
/// degrees of freedom, transformed to a normal distribution. Tiles without noise are left out.
fn deviations(a: &Tiles, b: &Tiles) -> Vec<f64> {
    let tiles = a.tiles.iter().zip(&b.tiles).filter(|(a, b)| noisy(a) || noisy(b));
    tiles
        .map(|(&(mean, variance), &(other_mean, other_variance))| {
            let sum = variance + other_variance;
            let part = |variance: f64, pictures: u64| variance * variance / (pictures as f64 - 1.0);
            let degrees =
                sum * sum / (part(variance, a.pictures) + part(other_variance, b.pictures));
            let t = (mean - other_mean) / sum.sqrt();
            // Use the lower tail by symmetry: in the far upper tail, 1 − p would be 0.
            let student = StudentsT::new(0.0, 1.0, degrees).expect("degrees above 0");
            let p = student.cdf(-t.abs()).max(1e-300);
            -Normal::standard().inverse_cdf(p) * t.signum()
        })
        .collect()
}

/// The Kolmogorov-Smirnov statistic of the deviations' p-values: their largest distance from a uniform
/// distribution, times √n.
fn unevenness(deviations: &[f64]) -> f64 {
    let normal = Normal::standard();
    let mut p: Vec<f64> = deviations.iter().map(|&z| normal.cdf(z)).collect();
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    let off = |(i, p): (usize, &f64)| (p - i as f64 / n).abs().max((p - (i + 1) as f64 / n).abs());
    p.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt()
}

/// Prints the table of a test, and collects the comparisons that differ by more than chance.
pub(crate) struct Disagreement {
    comparisons: usize,
    wrong: Vec<String>,
}

impl Disagreement {
    pub(crate) fn new(of: &str, comparisons: usize) -> Self {
        println!(
            "\n{of:<26}{:>14}{:>7}{:>9}{:>9}{:>9}",
            "", "tiles", "chi² p", "uneven", "worst z"
        );
        Self { comparisons, wrong: Vec::new() }
    }

    /// Compares two pictures, tile by tile.
    pub(crate) fn compare(&mut self, name: &str, what: &str, a: &Tiles, b: &Tiles) {
        // Tiles without noise are equal, except that sums are rounded, and that Mitsuba's means are
        // read from files with six digits.
        for (a, b) in a.tiles.iter().zip(&b.tiles).filter(|(a, b)| !noisy(a) && !noisy(b)) {
            let off = (a.0 - b.0).abs();
            assert!(off <= 2e-5 * a.0, "{name} {what}: {} and {} differ without noise", a.0, b.0);
        }
        let deviations = deviations(a, b);
        let tiles = deviations.len();
        // The three channels of a tile share their paths, so only a third of the deviations is
        // independent.
        let independent = (tiles / 3) as f64;
        let mean_square = deviations.iter().map(|z| z * z).sum::<f64>() / tiles as f64;
        let chi = ChiSquared::new(independent).unwrap().sf(mean_square * independent);
        let uneven = unevenness(&deviations) / 3.0f64.sqrt();
        let worst = deviations.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
        println!("{name:<26}{what:>14}{tiles:>7}{chi:>9.4}{uneven:>9.2}{worst:>9.2}");
        // By Kolmogorov's distribution, the probability of a value above x is about 2 e^(−2x²).
        let even = 2.0 * (-2.0 * uneven * uneven).exp();
        let share = ALARM / (3 * self.comparisons) as f64;
        if chi < share
            || even < share
            || worst > farthest(3 * self.comparisons * tiles, &Normal::standard())
        {
            let p = format!("chi² p {chi:e}, even p {even:e}, worst {worst}");
            self.wrong.push(format!("{name} {what}: {p}"));
        }
    }

    pub(crate) fn check(self) {
        assert!(self.wrong.is_empty(), "{:#?}", self.wrong);
    }
}

fn scene(primitives: &str, background: &str, media: &str) -> Scene {
    let text = format!(
        r#"(camera: (look_from: (0, 2, 7), look_at: (0, 0.6, 0), vfov: 45),
            background: {background},
            render: (width: 48, height: 48, depth: 8),
            textures: {{"bars": uv_checker(odd: (0.9, 0.9, 0.9), even: (0.2, 0.2, 0.2), scale: (6, 2)),
                "tilted": image(file: "tests/data/tilted.png", encoding: linear)}},
            materials: {{
                "floor": lambertian(albedo: (0.5, 0.6, 0.7)),
                "ideal": diffuse(albedo: (0.7, 0.6, 0.5)),
                "gold": conductor(eta: (0.143, 0.375, 1.442), k: (3.983, 2.386, 1.603), alpha: 0.3),
                "frosted": rough_dielectric(ior: 1.5, alpha: 0.4),
                "glass": dielectric(ior: 1.5, fresnel: exact),
                "fence": lambertian(albedo: (0.3, 0.5, 0.2), opacity: blend(alpha: (texture: "bars", channel: r))),
                "brushed": metal(albedo: (0.8, 0.8, 0.9), fuzz: 0.4),
                "pane": principled(base_color: (0.9, 0.7, 0.5), specular: 0, transmission: 1, roughness: 0, thin: true),
                "amber": principled(base_color: (1, 1, 1), transmission: 1, roughness: 0.5,
                    attenuation_color: (0.9, 0.5, 0.2), attenuation_distance: 0.4),
                "velvet": principled(base_color: (0.3, 0.1, 0.1), sheen_color: (0.9, 0.8, 0.7), sheen_roughness: 0.5,
                    diffuse_transmission: 0.4),
                "pan": principled(metalness: 1, roughness: 0.5, anisotropy: 0.7, anisotropy_rotation: 20),
                "shell": principled(base_color: (0.1, 0.1, 0.1), specular: 0, coat: 1, coat_roughness: 0.8,
                    coat_normal: "tilted"),
                "lamp": light(radiance: (4, 5, 6)),
                "glow": principled(base_color: (0.2, 0.2, 0.2), emission: (texture: "bars", factor: (9, 7, 5))),
                "front": light(radiance: (9, 7, 5), sides: front),
            }},
            primitives: [quad(q: (-9, 0, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"), {primitives}],
            media: [{media}])"#
    );
    Scene::from_ron(&text).unwrap()
}

const LAMPS: &str = r#"
    sphere(center: (-3, 3.5, 1), radius: 0.8, material: "lamp"),
    quad(q: (1, 4, -2), u: (3, 0, 0), v: (0, 0, 2), material: "front"),
    quad(q: (-1, 5, 2), u: (2, 1, 0), v: (0, 0.5, 1), material: "lamp"),
    triangles(vertices: [(-4, 0.2, -3), (-2, 0.2, -3), (-3, 2.5, -2.5)], indices: [(0, 1, 2)], material: "lamp")"#;

#[test]
fn modes_agree_in_every_tile() {
    let things = format!(
        r#"sphere(center: (-2, 0.7, 0), radius: 0.7, material: "gold"),
           sphere(center: (0, 0.7, 0), radius: 0.7, material: "frosted"),
           sphere(center: (2, 0.7, 0), radius: 0.7, material: "brushed"),
           sphere(center: (1, 0.4, 1.5), radius: 0.4, material: "glass"),
           box(min: (-1.4, 0, 1), max: (-0.6, 0.5, 1.8), rotation: (0, 30, 0), material: "ideal"), {LAMPS}"#
    );
    let fog = "sphere(center: (-1, 1, 0), radius: 1.5, density: 0.4, albedo: (0.9, 0.8, 0.7)), \
               box(min: (1, 0.1, -1), max: (3, 2, 1), rotation: (0, 20, 0), density: 0.6, albedo: (0.5, 0.7, 0.9))";
    let dark = "constant(radiance: (0, 0, 0))";
    let sky = "gradient(bottom: (0.1, 0.1, 0.1), top: (0.3, 0.5, 0.9))";
    // 90 lamps, chosen by a light tree, behind holes.
    let lamps = (0..90).map(|i| {
        let (x, y, z) = (f64::from(i % 10) - 4.5, 0.5 + f64::from(i % 7) / 2.0, f64::from(i / 10) - 6.0);
        format!(
            r#"triangles(vertices: [({x}, {y}, {z}), ({}, {y}, {z}), ({x}, {}, {z})], indices: [(0, 1, 2)], material: "lamp")"#,
            x + 0.2,
            y + 0.2
        )
    });
    let fence = r#"triangles(vertices: [(-3, 0, 1), (3, 0, 1), (-3, 2, 0), (3, 2, 0)], indices: [(0, 1, 2), (1, 3, 2)],
        uvs: [(0, 0), (1, 0), (0, 1), (1, 1)], material: "fence")"#;
    let many = lamps.chain([fence.to_owned()]).collect::<Vec<_>>().join(", ");
    let glass = format!(
        r#"sphere(center: (0, 1, 0), radius: 1, material: "amber"),
           sphere(center: (-2.2, 0.5, 1), radius: 0.5, material: "velvet"),
           sphere(center: (2.2, 0.5, 1), radius: 0.5, material: "pan"),
           sphere(center: (1.2, 0.4, 2.2), radius: 0.4, material: "shell"),
           sphere(center: (0, 1, 0), radius: 0.4, material: "brushed"),
           quad(q: (-3, 0, 1.5), u: (2, 0, 0.5), v: (0, 3, 0), material: "pane"),
           triangles(vertices: [(1.5, 0, -1), (1.5, 0, 2), (1.5, 3, 0)], indices: [(0, 1, 2)], material: "pane"),
           quad(q: (-4, 3, -3), u: (7, 0, 0), v: (0, 0.2, 6), material: "pane"), {LAMPS}"#
    );
    let glow = r#"sphere(center: (-3, 3.5, 1), radius: 0.8, material: "glow"),
        sphere(center: (0, 0.7, 0), radius: 0.7, material: "frosted"),
        quad(q: (1, 4, -2), u: (3, 0, 0), v: (0, 0, 2), material: "glow"),
        quad(q: (-1, 5, 2), u: (2, 1, 0), v: (0, 0.5, 1), material: "lamp"),
        triangles(vertices: [(-4, 0.2, -3), (-2, 0.2, -3), (-3, 2.5, -2.5)], indices: [(0, 1, 2)], material: "glow")"#;
    let scenes = [
        ("textured lamps", scene(glow, dark, ""), 60),
        ("panes, and glass that absorbs, in fog", scene(&glass, sky, fog), 60),
        ("many lamps and holes", scene(&many, dark, ""), 60),
        ("environment map", Scene::load("tests/data/environment.ron").unwrap(), 60),
        ("materials and lamps", scene(&things, dark, ""), 120),
        ("the same under a sky", scene(&things, sky, ""), 120),
        ("the same in fog", scene(&things, sky, fog), 120),
        ("cornell", Scene::load("tests/data/mitsuba/cornell.ron").unwrap(), 60),
    ];
    let pairs = [
        (Sampling::Bsdf, Sampling::Light),
        (Sampling::Bsdf, Sampling::Mis),
        (Sampling::Light, Sampling::Mis),
    ];
    let mut disagreement = Disagreement::new("tiles", scenes.len() * pairs.len());
    for (name, scene, spp) in &scenes {
        let [bsdf, light, mis] =
            [(Sampling::Bsdf, 4 * spp), (Sampling::Light, *spp), (Sampling::Mis, *spp)]
                .map(|(sampling, spp)| Tiles::render(name, scene, sampling, spp));
        let of = |sampling| match sampling {
            Sampling::Bsdf => &bsdf,
            Sampling::Light => &light,
            Sampling::Mis => &mis,
        };
        for (a, b) in pairs {
            let modes = format!("{} {}", a.name(), b.name());
            disagreement.compare(name, &modes, of(a), of(b));
        }
    }
    disagreement.check();
}
