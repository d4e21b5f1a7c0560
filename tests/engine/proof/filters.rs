//! Pixel filters: the image of an edge is the step response of the filter.

use std::f64::consts::PI;

use ptfast::{Engine, ImageSettings, Renderer, Scene};
use statrs::function::erf::erf;

/// Half of the view emits light, and the edge is 0.6 pixels from the left edge of pixel 12. The
/// wall is parallel to the image, so that distances in it are distances in the image.
const EDGE: &str = "(
    camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vfov: 53.130102, filter: FILTER),
    render: (width: 24, height: 4, depth: 1, sampling: bsdf),
    materials: {\"lamp\": light(radiance: (1, 1, 1))},
    primitives: [quad(q: (0.15, -90, -1), u: (900, 0, 0), v: (0, 180, 0), material: \"lamp\")],
)";

fn edge(filter: &str, engine: Engine, spp: u32) -> ptfast::Image {
    let scene = Scene::from_ron(&EDGE.replace("FILTER", filter)).unwrap();
    let settings = ImageSettings { spp, ..ImageSettings::of(&scene) };
    Renderer::new(&scene, settings, engine).unwrap().render().unwrap().image
}

/// The integral of the Mitchell filter with b = c = 1/3 and radius 2 from 0 to `x`, in [0, 2].
fn mitchell(x: f64) -> f64 {
    let inner = |x: f64| (7.0 / 4.0 * x.powi(4) - 4.0 * x.powi(3) + 16.0 / 3.0 * x) / 6.0;
    let outer = |x: f64| {
        (-7.0 / 12.0 * x.powi(4) + 4.0 * x.powi(3) - 10.0 * x.powi(2) + 32.0 / 3.0 * x) / 6.0
    };
    if x < 1.0 { inner(x) } else { inner(1.0) + outer(x) - outer(1.0) }
}

type Function<'a> = &'a dyn Fn(f64) -> f64;

#[test]
fn edges_show_the_step_response() {
    let gauss = |x: f64| {
        let end = (-0.5 * 9.0f64).exp();
        0.5 * (PI / 2.0).sqrt() * erf(x / (0.5 * 2f64.sqrt())) - end * x
    };
    let harris = |x: f64| {
        let sin = |k: f64| (k * PI * x / 1.5).sin() * 1.5 / (k * PI);
        0.35875 * x + 0.48829 * sin(1.0) + 0.14128 * sin(2.0) + 0.01168 * sin(3.0)
    };
    // The integral of each filter from 0 to a distance, up to a factor, and the radius.
    let filters: [(&str, f64, Function<'_>); 5] = [
        ("box", 0.5, &|x| x),
        ("triangle()", 1.0, &|x| x - 0.5 * x * x),
        ("gaussian()", 1.5, &gauss),
        ("mitchell()", 2.0, &mitchell),
        ("blackman_harris()", 1.5, &harris),
    ];
    for (filter, radius, integral) in filters {
        let image = edge(filter, Engine::Wavefront, 4096);
        let mut least = 0.0;
        for column in 0..24u32 {
            let distance = f64::from(column) + 0.5 - 12.6;
            let half = integral(distance.abs().min(radius)) / integral(radius) / 2.0;
            let want = 0.5 + half.copysign(distance);
            let at = |row: u32| f64::from(image.pixels()[(row * 24 + column) as usize][1]);
            let mean = (0..4).map(at).sum::<f64>() / 4.0;
            assert!((mean - want).abs() < 2e-3, "{filter}, column {column}: {mean}, not {want}");
            least = mean.min(least);
        }
        assert_eq!(least < -0.01, filter == "mitchell()", "{filter}: {least}");
        let (few, same) = (edge(filter, Engine::Wavefront, 5), edge(filter, Engine::Scalar, 5));
        assert_eq!(few.hash(), same.hash(), "{filter}");
    }
}
