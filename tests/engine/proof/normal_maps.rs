//! Surfaces with a normal map whose normal is (0.2, −0.2, 1) everywhere.

use super::{Known, compare};

/// A square of this material at the origin, whose normal map is tilted, seen along −z under a sky of
/// radiance y + 1.
fn seen_from_above(name: &str, material: &str, radiance: f64) -> Known {
    let text = format!(
        r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 0.02),
            background: gradient(bottom: (0, 0, 0), top: (2, 2, 2)),
            textures: {{"tilted": image(file: "tests/data/tilted.png", encoding: linear)}},
            materials: {{"m": {material}}}, primitives: [{SQUARE}])"#
    );
    Known::new(name, &text, radiance)
}

/// Light that passes a square of glass stays inside.
#[test]
fn glass_refracts_as_its_map_says() {
    let (ior, cos) = (1.5, 1.0 / 1.08_f64.sqrt());
    let inside = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    let across = (cos - ior * inside) / (cos + ior * inside);
    let along = (ior * cos - inside) / (ior * cos + inside);
    let reflectance = (across * across + along * along) / 2.0;
    // The heights of the two directions: those of −z mirrored and refracted at (0.2, −0.2, 1)/√1.08.
    let height = -0.2 * cos;
    let (reflected, refracted) = (2.0 * cos * height, (cos / ior - inside) * height);
    let radiance = 1.0 + reflectance * reflected + (1.0 - reflectance) * refracted;
    compare(
        "glass with a normal map",
        &[
            seen_from_above(
                "smooth",
                r#"dielectric(ior: 1.5, fresnel: exact, normal: "tilted")"#,
                radiance,
            ),
            seen_from_above(
                "frosted",
                r#"rough_dielectric(ior: 1.5, alpha: 0.002, normal: "tilted")"#,
                radiance,
            ),
        ],
    );
}

/// A primitive at the origin, seen along −z or, from behind, along z, under a sky of radiance y + 1.
fn mirror(name: &str, from: f32, primitives: &str, y: f64) -> Known {
    let text = format!(
        r#"(camera: (look_from: (0, 0, {from}), look_at: (0, 0, 0), vfov: 0.02),
            background: gradient(bottom: (0, 0, 0), top: (2, 2, 2)),
            textures: {{"tilted": image(file: "tests/data/tilted.png", encoding: linear)}},
            materials: {{"m": metal(albedo: (1, 1, 1), normal: "tilted")}},
            meshes: {{"square": [{SQUARE}]}},
            primitives: [{primitives}])"#
    );
    Known::new(name, &text, 1.0 + y)
}

/// A square in the plane z = 0, whose u grows along x and v along y.
const SQUARE: &str = r#"triangles(
    vertices: [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], indices: [(0, 1, 2), (0, 2, 3)],
    uvs: [(0, 0), (1, 0), (1, 1), (0, 1)], material: "m")"#;

#[test]
fn mirrors_turn_as_their_maps_say() {
    // Reflects z at the normal (0.2, −0.2, 1)/√1.08.
    let down = -2.0 * 0.2 / 1.08;
    let smooth = "normals: [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)], material";
    let with = |field: &str| SQUARE.replace("material", field);
    let turned = with("tangents: [(0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0)], material");
    let mirrored = SQUARE.replace("uvs: [(0, 0), (1, 0), (1, 1), (0, 1)]", {
        "uvs: [(0, 1), (1, 1), (1, 0), (0, 0)]"
    });
    let instance = |rows: &str| format!(r#"instance(mesh: "square", matrix: ({rows}))"#);
    let quad =
        |q: &str, u: &str, v: &str| format!(r#"quad(q: ({q}), u: ({u}), v: ({v}), material: "m")"#);
    let across = quad("-1, -1, 0", "2, 0, 0", "0, 2, 0");
    compare(
        "mirrors",
        &[
            mirror("quad", 5.0, &across, down),
            mirror("quad from behind", -5.0, &across, -down),
            mirror("upright quad", 5.0, &quad("1, -1, 0", "0, 2, 0", "-2, 0, 0"), -down),
            mirror("slanted quad", 5.0, &quad("-2, -1, 0", "2, 0, 0", "2, 2, 0"), down),
            mirror("flat triangles", 5.0, SQUARE, down),
            mirror("smooth triangles", 5.0, &with(smooth), down),
            mirror("mirrored coordinates", 5.0, &mirrored, -down),
            mirror("mirrored and smooth", 5.0, &mirrored.replace("material", smooth), -down),
            mirror("given tangents", 5.0, &turned, -down),
            mirror("instance", 5.0, &instance("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)"), down),
            mirror(
                "turned and stretched instance",
                5.0,
                &instance("(0, -3, 0, 0), (0.5, 0, 0, 0), (0, 0, 1, 0)"),
                -down,
            ),
            mirror(
                "mirrored instance",
                5.0,
                &instance("(1, 0, 0, 0), (0, -1, 0, 0), (0, 0, 1, 0)"),
                -down,
            ),
            mirror("sphere", 9.0, r#"sphere(center: (0, 0, 0), radius: 4, material: "m")"#, down),
            mirror(
                "moving sphere",
                9.0,
                r#"moving_sphere(center: (0, 0, 0), center1: (0, 0, 0.1), radius: 4, material: "m")"#,
                down,
            ),
        ],
    );
}

/// A coat mirrors as its own map says, or as the surface without a map, whatever the map of the layers below it.
#[test]
fn coats_turn_as_their_own_maps_say() {
    // Schlick's reflectance, and the height of z reflected at (0.2, −0.2, 1)/√1.08.
    let reflectance = |cos: f64| 0.04 + 0.96 * (1.0 - cos).powi(5);
    let down = -2.0 * 0.2 / 1.08;
    let coat = |map: &str| {
        format!(
            "principled(base_color: (0, 0, 0), specular: 0, coat: 1, coat_roughness: 0.05, {map}: \"tilted\")"
        )
    };
    let tilted = reflectance(1.0 / 1.08_f64.sqrt()) * (1.0 + down);
    compare(
        "coats",
        &[
            seen_from_above("own map", &coat("coat_normal"), tilted),
            seen_from_above("map of the base", &coat("normal"), reflectance(1.0)),
        ],
    );
}

/// Light from below the surface but above the horizon of the turned normal is lost: a share of
/// (1 − cos θ)/2. Seen from near the horizon, the mirrored direction is below the surface, which must not
/// matter to diffuse scattering.
#[test]
fn matte_surfaces_gain_no_light() {
    let scene = |name: &str, material: &str, from: &str| {
        let text = format!(
            r#"(camera: (look_from: ({from}), look_at: (0, 0, 0), vfov: 0.02),
                textures: {{"tilted": image(file: "tests/data/tilted.png", encoding: linear)}},
                materials: {{"m": {material}, "wall": light(radiance: (3, 3, 3))}},
                primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall"), {}])"#,
            SQUARE.replace(
                "material",
                "normals: [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)], soft_terminator: false, material"
            )
        );
        let cos = 1.0 / 1.08_f64.sqrt();
        Known::new(name, &text, 3.0 * 0.8 * (1.0 + cos) / 2.0)
    };
    let lambertian = r#"lambertian(albedo: (0.8, 0.8, 0.8), normal: "tilted")"#;
    let principled =
        r#"principled(base_color: (0.8, 0.8, 0.8), specular: 0, roughness: 0.1, normal: "tilted")"#;
    compare(
        "matte",
        &[
            scene("lambertian", lambertian, "0, 0.6, 0.8"),
            scene("lambertian from the side", lambertian, "0, 0.95, 0.31"),
            scene("principled", principled, "0, 0.6, 0.8"),
            scene("principled from the side", principled, "0, 0.95, 0.31"),
        ],
    );
}
