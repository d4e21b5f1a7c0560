//! Compares floors lit by environment maps, and by lights that no path can hit, with closed forms.

use std::f64::consts::PI;

use ptfast::internals::Source;
use ptfast::{Limits, Sampling};

use super::{Known, compare, compare_in};

/// A small floor at height −1. The camera looks at its middle from above.
fn floor(material: &str, light: &str) -> String {
    format!(
        r#"(camera: (look_from: (0, 0, 0), look_at: (0, -1, 0), up: (0.1, 1, 0.2), vfov: 0.02),
            materials: {{"floor": {material}(albedo: (0.6, 0.6, 0.6))}},
            primitives: [quad(q: (-0.1, -1, -0.1), u: (0, 0, 0.2), v: (0.2, 0, 0), material: "floor")],
            {light})"#
    )
}

/// Writes a latitude-longitude map of `width × height` pixels in which `texel` gives the radiance.
fn write(name: &str, [width, height]: [u32; 2], texel: impl Fn(u32, u32) -> f32) -> String {
    let path = std::env::temp_dir().join(format!("ptfast-{}-{name}.pfm", std::process::id()));
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for y in (0..height).rev() {
        for x in 0..width {
            (0..3).for_each(|_| bytes.extend(texel(x, y).to_le_bytes()));
        }
    }
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

/// ∫ radiance · cos θ over the upper hemisphere, for a map that is interpolated bilinearly between
/// the centres of texels, of which one has the radiance 1: by the midpoint rule in f64.
fn irradiance_of_texel([width, height]: [u32; 2], [x, y]: [u32; 2], power: i32) -> f64 {
    const STEPS: u32 = 400;
    let tent = |at: f64, center: u32| (1.0 - (at - f64::from(center) - 0.5).abs()).max(0.0);
    let mut sum = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let step = |k: u32, center: u32| {
                f64::from(center) - 0.5 + 2.0 * (f64::from(k) + 0.5) / f64::from(STEPS)
            };
            let (u, v) = (step(i, x), step(j, y));
            let theta = PI * v / f64::from(height);
            sum += tent(u, x) * tent(v, y) * theta.cos().powi(power) * theta.sin();
        }
    }
    let (du, dv) = (2.0 * PI / f64::from(width), PI / f64::from(height));
    sum * du * dv * (2.0 / f64::from(STEPS)) * (2.0 / f64::from(STEPS))
}

#[test]
fn floors_under_environment_maps_are_lit_as_they_should() {
    let size = [16, 8];
    let sun = write("sun", size, |x, y| if [x, y] == [5, 1] { 500.0 } else { 0.0 });
    let sky = write("sky", size, |_, y| if y < 4 { 2.0 } else { 0.0 });
    let both = write("both", size, |x, y| if [x, y] == [5, 1] { 501.0 } else { 1.0 });
    let map = |file: &str, more: &str| format!(r#"background: image(file: "{file}"{more})"#);
    let texel = |power: i32| 500.0 * irradiance_of_texel(size, [5, 1], power);
    // The maps are outside the folder of the scene.
    let limits = Limits::default().with_outside_files(true);
    let known = |name: &str, material: &str, light: &str, want: f64| {
        let text = floor(material, light);
        let parsed = Source::from_reader(text.as_bytes(), &limits).unwrap().read(&limits).unwrap();
        Known { name: name.to_owned(), scene: parsed.resolve().unwrap(), want }
    };
    let compensated = map(&both, ", compensated: true");
    // The radiance falls from 2 to 0 between the centres of the last row of the sky and the first row
    // below it.
    let step = 1e-4;
    let sky_irradiance: f64 = (0..40_000)
        .map(|i| {
            let v = (f64::from(i) + 0.5) * step;
            let radiance = 2.0 * (4.5 - v).min(1.0);
            let theta = PI * v / 8.0;
            radiance * theta.cos() * theta.sin() * 2.0 * PI * (PI / 8.0) * step
        })
        .sum();
    compare(
        "floors under environment maps",
        &[
            known("one texel, lambertian", "lambertian", &map(&sun, ""), 0.6 / PI * texel(1)),
            known("one texel, diffuse", "diffuse", &map(&sun, ""), 0.3 / PI * texel(0)),
            known("half a sky", "lambertian", &map(&sky, ""), 0.6 / PI * sky_irradiance),
            known("sun and sky", "lambertian", &map(&both, ""), 0.6 + 0.6 / PI * texel(1)),
            known("compensated", "lambertian", &compensated, 0.6 + 0.6 / PI * texel(1)),
            known(
                "turned",
                "lambertian",
                &map(&sun, ", rotation: (0, 77, 0), scale: 0.5"),
                0.3 / PI * texel(1),
            ),
        ],
    );
    for file in [sun, sky, both] {
        std::fs::remove_file(file).unwrap();
    }
}

/// Irradiances of lights that only light samples find.
#[test]
fn floors_under_distant_lights_and_points_are_lit_as_they_should() {
    let lights = |list: &str| format!("lights: [{list}]");
    // 4 above the floor and 3 aside: cos θ = 0.8 at a distance of 5.
    let point = "point(position: (3, 3, 0), intensity: (50, 50, 50))";
    let point_irradiance = 50.0 / 25.0 * 0.8;
    // The floor is 60° from the axis, at 3/7 of the way from a cosine of 0.2 to one of 0.9.
    let (inner, outer) = (0.9f64.acos().to_degrees(), 0.2f64.acos().to_degrees());
    let spot = format!(
        "spot(position: (0, 3, 0), look_at: (3.4641016, 1, 0), intensity: (48, 48, 48), inner: {inner}, outer: {outer})"
    );
    let x = 3.0 / 7.0;
    let spot_irradiance = 48.0 / 16.0 * x * x * (3.0 - 2.0 * x);
    // The reference code of KHR_lights_punctual squares x.
    let square = spot.replace("inner:", "falloff: square, inner:");
    let square_irradiance = 48.0 / 16.0 * x * x;
    let sun = "distant(direction: (-0.6, -0.8, 0), irradiance: (4, 4, 4))";
    let disk = "distant(direction: (-6, -8, 0), irradiance: (4, 4, 4), angle: 30)";
    let all = format!("{point}, {spot}, {sun}");
    let lamp = r#"background: constant(radiance: (0.5, 0.5, 0.5)), "#.to_owned();
    let known = |name: &str, material: &str, light: &str, want: f64| {
        Known::new(name, &floor(material, light), want)
    };
    let lambert = 0.6 / PI;
    compare_in(
        &[Sampling::Light, Sampling::Mis],
        "floors under lights that paths cannot hit",
        &[
            known("point", "lambertian", &lights(point), lambert * point_irradiance),
            known("point, diffuse", "diffuse", &lights(point), 0.3 / PI * point_irradiance / 0.8),
            known("spot", "lambertian", &lights(&spot), lambert * spot_irradiance),
            known("spot of glTF", "lambertian", &lights(&square), lambert * square_irradiance),
            known("parallel light", "lambertian", &lights(sun), lambert * 4.0 * 0.8),
            known("disk", "lambertian", &lights(disk), lambert * 4.0 * 0.8),
            known(
                "all of them, and a sky",
                "lambertian",
                &format!("{lamp}{}", lights(&all)),
                0.3 + lambert * (point_irradiance + spot_irradiance + 3.2),
            ),
        ],
    );
}
