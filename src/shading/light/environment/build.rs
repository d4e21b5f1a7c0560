//! Prepares environment maps for sampling.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::mapping::{Mapping, neighbor};
use super::patch::{BLACK, line};
use super::table::CellTable;
use super::{Environment, EnvironmentMap};
use crate::image::Texels;
use crate::math::Row;
use crate::math::precise::sin_cos_degrees;
use crate::shading::luminance;

impl Environment {
    /// Creates the light of a map, whose image is loaded. Returns `None` if the map is black.
    pub(in crate::shading::light) fn new(map: &EnvironmentMap) -> Option<Self> {
        let texels = Arc::clone(map.texels());
        let size @ [width, height] = [texels.width(), texels.height()];
        let bands: Vec<BandOfSphere> = match map.mapping {
            Mapping::LatLong => (0..=height).map(|row| BandOfSphere::new(row, height)).collect(),
            Mapping::EqualArea => vec![BandOfSphere::whole()],
        };
        // The solid angle of a patch of whole width, and in equal-area maps of whole height.
        let whole = |row: u32| match map.mapping {
            Mapping::LatLong => bands[row as usize].solid_angle() / f64::from(width),
            Mapping::EqualArea => 4.0 * PI / (f64::from(width) * f64::from(height)),
        };
        let tall = |row: u32| match map.mapping {
            Mapping::LatLong => 1.0,
            Mapping::EqualArea => line(row + 1, height).0 - line(row, height).0,
        };
        let luminances = luminances(&texels);
        // For each patch of a row, the mean luminance and the solid angle.
        let patches = |row: u32| {
            let corners = |number: u32| corners(&luminances, map.mapping, size, number);
            let (upper, lower, angle) = (corners(row), corners(row + 1), whole(row) * tall(row));
            (0..=width as usize).map(move |i| {
                let wide = line(i as u32 + 1, width).0 - line(i as u32, width).0;
                ((upper[i] + upper[i + 1] + lower[i] + lower[i + 1]) / 4.0, wide * angle)
            })
        };
        let mut less = 0.0;
        if map.compensated {
            let sum = |row: u32| patches(row).map(|(mean, angle)| mean * angle).sum::<f64>();
            less = (0..=height).map(sum).sum::<f64>() / (4.0 * PI);
        }
        let table = |less: f64| {
            let weight = |(mean, angle): (f64, f64)| {
                // Twice, because the mean is computed with other roundings in patches.
                let emits = mean > less && mean > 2.0 * f64::from(BLACK);
                if emits { (mean - less) * angle } else { 0.0 }
            };
            CellTable::new(width + 1, height + 1, |row| patches(row).map(weight).collect())
        };
        // A map of one colour has nothing left after compensation.
        let table = table(less).or_else(|| table(0.0))?;
        let rows = (0..bands.len() as u32).map(|row| bands[row as usize].row(whole(row)));
        Some(Self {
            mapping: map.mapping,
            axes: map.axes().map(|axis| axis.as_vec3()),
            table,
            rows: rows.collect(),
            texels,
        })
    }
}

/// The part of the sphere between two latitudes.
struct BandOfSphere {
    /// 1 − |cos θ| at the first and the last latitude. In the band across the equator, it exceeds 1 on one side.
    down: [f64; 2],
    /// Sign of cos θ.
    sign: f64,
}

impl BandOfSphere {
    /// The part that row `row` of patches shows, in a map of `height` texels.
    fn new(row: u32, height: u32) -> Self {
        let middle = f64::from(height) / 2.0;
        let above = f64::from(row) <= middle;
        // 1 − cos θ = 2 sin² θ/2, without the cancellation.
        let down = |number: u32| {
            let y = line(number, height).0;
            let y = if above { y } else { f64::from(height) - y };
            let (sin, _) = sin_cos_degrees(90.0 * y / f64::from(height));
            2.0 * sin * sin
        };
        Self { down: [down(row), down(row + 1)], sign: if above { 1.0 } else { -1.0 } }
    }

    fn whole() -> Self {
        Self { down: [0.0, 2.0], sign: 1.0 }
    }

    fn solid_angle(&self) -> f64 {
        2.0 * PI * (self.down[1] - self.down[0]).abs()
    }

    /// The row of [`Environment::rows`] for patches of this solid angle.
    fn row(&self, patch: f64) -> Row {
        let [begin, end] = self.down;
        [begin, end - begin, self.sign, 1.0 / patch].map(|value| (value as f32).to_bits())
    }
}

/// The luminance of each texel, by its index.
fn luminances(texels: &Texels) -> Vec<f32> {
    let of = |index: usize| {
        let [r, g, b, _] = texels.at(index as u32);
        luminance(Vec3::new(r, g, b)) as f32
    };
    (0..texels.len()).into_par_iter().map(of).collect()
}

/// The luminance at the corners of patches on line number `number` of the grid, from left to right.
fn corners(luminances: &[f32], mapping: Mapping, size: [u32; 2], number: u32) -> Vec<f64> {
    let [width, height] = size;
    let at = |x: i32, y: i32| {
        let texel = neighbor(mapping, [x, y], size);
        f64::from(luminances[Texels::index::<f32>(texel, size) as usize])
    };
    let (_, [above, below]) = line(number, height);
    let corner = |column: u32| {
        let (_, [left, right]) = line(column, width);
        (at(left, above) + at(right, above) + at(left, below) + at(right, below)) / 4.0
    };
    (0..width + 2).map(corner).collect()
}
