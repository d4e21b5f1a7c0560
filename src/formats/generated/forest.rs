//! `forest:N`, instances of smooth-shaded meshes on hills.

use glam::{DVec3, Vec2, Vec3};

use super::icosphere::icosphere;
use crate::geometry::Vertices;
use crate::math::precise::sin_cos_degrees;
use crate::math::{Stream, max, min, mix32};
use crate::scene::mesh::add_normals;
use crate::scene::{InstanceFile, Roulette, SceneFile, TrianglesFile};
use crate::shading::material::Lambertian;
use crate::shading::{Background, CameraFile};

/// Largest number of triangles of the ground and of the meshes.
pub(super) const TRIANGLES: u32 = 600_000;
/// Mean distance of neighbouring instances.
const PITCH: f32 = 4.0;
/// Materials: name and albedo.
const COLORS: [(&str, [f32; 3]); 6] = [
    ("ground", [0.21, 0.19, 0.10]),
    ("bark", [0.16, 0.10, 0.06]),
    ("needles", [0.05, 0.14, 0.06]),
    ("leaves", [0.13, 0.26, 0.05]),
    ("shrub", [0.22, 0.24, 0.08]),
    ("stone", [0.36, 0.35, 0.33]),
];

/// Firs, broad-leaved trees, bushes and rocks on a jittered grid, turned, scaled and sometimes
/// mirrored at random. The ground has up to 2^19 triangles.
pub(super) fn scene(count: u32) -> SceneFile {
    let side = (1..).find(|side: &u32| u64::from(*side).pow(2) >= u64::from(count));
    let side = side.expect("a large enough square exists");
    let extent = side as f32 * PITCH;
    let mut scene = SceneFile::new(camera(extent));
    scene.render.roulette = Roulette::From(5);
    scene.background = Background::Gradient { bottom: [0.95, 0.95, 0.9], top: [0.35, 0.55, 1.0] };
    for (name, albedo) in COLORS {
        scene.add_material(name, Lambertian::new(albedo));
    }
    let part = |part: TrianglesFile| part.into();
    scene.add_named_mesh("fir", fir().map(part).to_vec());
    scene.add_named_mesh("tree", tree().map(part).to_vec());
    scene.add_named_mesh("bush", blob(4, Vec3::new(0.0, 0.5, 0.0), 0.9, 0.35, "shrub"));
    scene.add_named_mesh("rock", blob(3, Vec3::new(0.0, 0.1, 0.0), 0.7, 0.5, "stone"));
    scene.add(ground(side.clamp(16, 512), extent + 8.0 * PITCH));
    let mut random = Stream::new(2026);
    for cell in 0..count {
        let mut at = |cell: u32| {
            let jitter = random.between(0.1, 0.9);
            (cell as f32 + jitter) * PITCH - 0.5 * extent
        };
        let place = Vec2::new(at(cell % side), at(cell / side));
        let mesh = match random.uniform() {
            kind if kind < 0.45 => "fir",
            kind if kind < 0.75 => "tree",
            kind if kind < 0.9 => "bush",
            _ => "rock",
        };
        scene.add(InstanceFile::new(mesh, matrix(&mut random, place)));
    }
    scene
}

/// A camera above the ground that looks over the forest.
fn camera(extent: f32) -> CameraFile {
    let away = min(0.6 * extent + 6.0, 90.0);
    let from = Vec2::new(0.3 * away, away);
    let above = height(from) + 0.16 * away + 6.0;
    let mut camera =
        CameraFile::new([from.x, above, from.y], [0.0, height(Vec2::ZERO) + 2.0, 0.0], 45.0);
    camera.focus_distance = away;
    camera
}

/// A random turn about the vertical axis, size and reflection, at a place on the ground.
fn matrix(random: &mut Stream, place: Vec2) -> [[f32; 4]; 3] {
    let (sin, cos) = sin_cos_degrees(f64::from(random.between(0.0, 360.0)));
    let (sin, cos) = (sin as f32, cos as f32);
    let width = random.between(0.7, 1.3);
    let tall = width * random.between(0.8, 1.3);
    let mirror = if random.uniform() < 0.25 { -width } else { width };
    [
        [cos * mirror, 0.0, sin * width, place.x],
        [0.0, tall, 0.0, height(place)],
        [-sin * mirror, 0.0, cos * width, place.y],
    ]
}

/// Smooth noise between −1 and 1, one value per unit.
fn noise(at: Vec3, salt: u32) -> f32 {
    let cell = Vec3::new(at.x.floor(), at.y.floor(), at.z.floor());
    let f = at - cell;
    let ease = f * f * (Vec3::splat(3.0) - f * 2.0);
    let value = |x: i32, y: i32, z: i32| {
        let key = |c: f32, offset: i32| (c as i32 + offset) as u32;
        let hash = mix32(key(cell.x, x) ^ mix32(key(cell.y, y) ^ mix32(key(cell.z, z) ^ salt)));
        (hash >> 8) as f32 * (2.0 / (1 << 24) as f32) - 1.0
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |y, z| mix(value(0, y, z), value(1, y, z), ease.x);
    mix(mix(row(0, 0), row(1, 0), ease.y), mix(row(0, 1), row(1, 1), ease.y), ease.z)
}

/// The height of the ground.
fn height(at: Vec2) -> f32 {
    let octave = |length: f32| noise(Vec3::new(at.x / length, 0.0, at.y / length), 7);
    9.0 * octave(90.0) + 2.5 * octave(27.0) + 0.3 * octave(6.0)
}

/// Triangles with a smooth normal at each vertex.
fn smooth(positions: Vec<Vec3>, indices: Vec<[u32; 3]>, material: &str) -> TrianglesFile {
    let mut vertices = Vertices { positions, ..Vertices::default() };
    add_normals(&mut vertices, &indices);
    let arrays = |vectors: Vec<Vec3>| vectors.into_iter().map(|v| v.to_array()).collect();
    let mut triangles = TrianglesFile::new(arrays(vertices.positions), indices, material);
    triangles.normals = arrays(vertices.normals);
    triangles
}

/// A square of ground with `cells` squares along each side.
fn ground(cells: u32, extent: f32) -> TrianglesFile {
    let at = |i: u32| (i as f32 / cells as f32 - 0.5) * extent;
    let row = cells + 1;
    let positions = (0..row * row).map(|i| Vec2::new(at(i % row), at(i / row)));
    let positions = positions.map(|p| Vec3::new(p.x, height(p), p.y)).collect();
    let faces = (0..cells * cells).flat_map(|i| {
        let a = i / cells * row + i % cells;
        let (b, c, d) = (a + 1, a + row, a + row + 1);
        [[a, c, b], [b, c, d]]
    });
    smooth(positions, faces.collect(), "ground")
}

/// A surface of revolution about the vertical axis through these points (radius, height), with
/// waves of relative depth `wave` around it.
fn lathe(profile: &[(f32, f32)], sides: u32, wave: f32, material: &str) -> TrianglesFile {
    let mut positions = Vec::new();
    for &(radius, height) in profile {
        for side in 0..sides {
            let degrees = 360.0 * f64::from(side) / f64::from(sides);
            let (sin, cos) = sin_cos_degrees(degrees);
            let (ripple, _) = sin_cos_degrees(7.0 * degrees + 40.0 * f64::from(height));
            let radius = f64::from(radius) * (1.0 + f64::from(wave) * ripple);
            let point = DVec3::new(radius * cos, f64::from(height), radius * sin);
            positions.push(point.as_vec3());
        }
    }
    let rings = profile.len() as u32 - 1;
    let faces = (0..rings * sides).flat_map(|i| {
        let (ring, side) = (i / sides, i % sides);
        let next = (side + 1) % sides;
        let (a, b) = (ring * sides + side, ring * sides + next);
        [[a, a + sides, b], [b, a + sides, b + sides]]
    });
    smooth(positions, faces.collect(), material)
}

/// A fir: a trunk, and skirts of needles.
fn fir() -> [TrianglesFile; 2] {
    let trunk = lathe(&[(0.16, -0.5), (0.14, 0.5), (0.02, 5.6)], 12, 0.05, "bark");
    let mut profile = Vec::new();
    for skirt in 0..7 {
        let low = 0.7 + 0.72 * skirt as f32;
        let radius = 1.35 - 0.16 * skirt as f32;
        profile.extend([(0.25 * radius, low + 0.15), (radius, low), (0.6 * radius, low + 0.5)]);
    }
    profile.push((0.02, 6.2));
    [trunk, lathe(&profile, 40, 0.12, "needles")]
}

/// A broad-leaved tree: a trunk, and a crown.
fn tree() -> [TrianglesFile; 2] {
    let trunk = lathe(&[(0.22, -0.5), (0.17, 0.6), (0.12, 2.6)], 12, 0.08, "bark");
    [trunk, blob(5, Vec3::new(0.0, 3.4, 0.0), 1.7, 0.45, "leaves")]
}

/// A lumpy ball.
fn blob(levels: u32, center: Vec3, radius: f32, lumps: f32, material: &str) -> TrianglesFile {
    let (sphere, faces) = icosphere(levels);
    let positions = sphere.into_iter().map(|v| {
        let coarse = noise(v * 2.3 + Vec3::splat(50.0), 11);
        let fine = noise(v * 6.1 + Vec3::splat(50.0), 12);
        center + v * (radius * max(1.0 + lumps * (0.7 * coarse + 0.4 * fine), 0.3))
    });
    smooth(positions.collect(), faces, material)
}
