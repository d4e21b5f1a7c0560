//! Lists of triangles, and the disks and spheres that become such lists.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Params;
use crate::math::precise::sin_cos_degrees;

/// A list of triangles before the transform of the scene.
#[derive(Default)]
pub(super) struct List {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    pub(super) uvs: Vec<DVec2>,
    pub(super) indices: Vec<[u32; 3]>,
}

/// The vertices of a mesh.
pub(super) fn vertices(params: &Params) -> Result<List, String> {
    let positions = params.tuples::<3>("P")?.ok_or("a mesh needs the positions `P`")?;
    let normals = params.tuples::<3>("N")?.unwrap_or_default();
    let uvs = match params.tuples::<2>("uv")? {
        None => params.tuples::<2>("st")?,
        uvs => uvs,
    };
    Ok(List {
        positions: positions.into_iter().map(DVec3::from).collect(),
        normals: normals.into_iter().map(DVec3::from).collect(),
        uvs: uvs.unwrap_or_default().into_iter().map(DVec2::from).collect(),
        indices: Vec::new(),
    })
}

/// The corners of a face as indices.
pub(super) fn corners<const N: usize>(numbers: [f64; N]) -> Result<[u32; N], String> {
    let ok =
        |&number: &f64| number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0;
    match numbers.iter().find(|number| !ok(number)) {
        Some(number) => {
            Err(format!("`indices` must be whole numbers of 0 or more, one is {number}"))
        }
        None => Ok(numbers.map(|number| number as u32)),
    }
}

/// Number of sides of disks and globes.
const SIDES: u32 = 64;

/// A disk around the z-axis, with its front towards +z.
pub(super) fn disk(height: f64, radius: f64) -> List {
    let mut list = List::default();
    for i in 0..SIDES {
        let (sin, cos) = sin_cos_degrees(360.0 * f64::from(i) / f64::from(SIDES));
        list.positions.push(DVec3::new(radius * cos, radius * sin, height));
        list.uvs.push(DVec2::new(f64::from(i) / f64::from(SIDES), 0.0));
    }
    // As large as the disk.
    let (sin, _) = sin_cos_degrees(360.0 / f64::from(SIDES));
    let grown = (TAU / (f64::from(SIDES) * sin)).sqrt();
    list.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * grown, p.y * grown, p.z));
    list.positions.push(DVec3::new(0.0, 0.0, height));
    list.uvs.push(DVec2::new(0.5, 1.0));
    list.indices = (0..SIDES).map(|i| [SIDES, i, (i + 1) % SIDES]).collect();
    list
}

/// A sphere around the origin, with its poles on the z-axis.
pub(super) fn globe(radius: f64) -> List {
    let mut list = List::default();
    for row in 0..=SIDES {
        let (sin, cos) = sin_cos_degrees(180.0 * f64::from(row) / f64::from(SIDES));
        for column in 0..=SIDES {
            let (y, x) = sin_cos_degrees(360.0 * f64::from(column) / f64::from(SIDES));
            let normal = DVec3::new(sin * x, sin * y, -cos);
            list.positions.push(normal * radius);
            list.normals.push(normal);
            let uv = DVec2::new(f64::from(column), f64::from(row)) / f64::from(SIDES);
            list.uvs.push(uv);
        }
    }
    let at = |row: u32, column: u32| row * (SIDES + 1) + column;
    for row in 0..SIDES {
        for column in 0..SIDES {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            list.indices.extend([[a, b, d], [a, d, c]]);
        }
    }
    list
}
