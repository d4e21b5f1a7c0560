//! Images of the light that reaches a scene from all directions, sampled by their luminance.

mod file;
mod mapping;
mod table;

use std::f32::consts::PI;
use std::f64;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

pub use file::EnvironmentMap;
pub use mapping::Mapping;

use self::mapping::neighbor;
use self::table::{Cell, CellTable};
use super::LightModel;
use super::sample::LightSample;
use crate::geometry::Ray;
use crate::image::Texels;
use crate::math::precise::sin_cos_degrees;
use crate::math::trig::{atan2, sin_cos_turns};
use crate::math::{Mask, Real, Row, Vector, Word, clamp, dot, normalize, whole};
use crate::scene::emission::luminance;

/// The light of an environment map. Its radiance is interpolated between the centres of texels, and
/// the density of samples is constant in each texel.
#[derive(Debug)]
pub(crate) struct Environment {
    texels: Arc<Texels>,
    mapping: Mapping,
    /// The axes of the map's frame in the scene.
    axes: [Vec3; 3],
    table: CellTable,
    /// For each row of a latitude-longitude map: 1 − |cos θ| where it begins and how much that grows
    /// to its end, the sign of cos θ, and the reciprocal of a texel's solid angle. Equal-area maps
    /// have only the last, in a single row.
    rows: Vec<Row>,
}

impl Environment {
    /// Creates the light of a map, whose image is loaded. Returns `None` if the map is black.
    pub(super) fn new(map: &EnvironmentMap) -> Option<Self> {
        let texels = Arc::clone(map.texels());
        let (width, height) = (texels.width(), texels.height());
        let rows: Vec<BandOfSphere> = match map.mapping {
            Mapping::LatLong => (0..height).map(|row| BandOfSphere::new(row, height)).collect(),
            Mapping::EqualArea => vec![BandOfSphere::whole()],
        };
        let texel_angle = |row: u32| match map.mapping {
            Mapping::LatLong => rows[row as usize].solid_angle() / f64::from(width),
            Mapping::EqualArea => 4.0 * f64::consts::PI / (f64::from(width) * f64::from(height)),
        };
        let luminances = luminances(&texels);
        let means = |row: u32| means(&luminances, map.mapping, [width, height], row);
        let mut less = 0.0;
        if map.compensated {
            let sum = |row: u32| texel_angle(row) * means(row).sum::<f64>();
            less = (0..height).map(sum).sum::<f64>() / (4.0 * f64::consts::PI);
        }
        let table = |less: f64| {
            let weight = |row: u32| {
                let angle = texel_angle(row);
                let weight = |mean: f64| if mean > less { (mean - less) * angle } else { 0.0 };
                means(row).map(weight).collect()
            };
            CellTable::new(width, height, weight)
        };
        // A map of one colour has nothing left after compensation.
        let table = table(less).or_else(|| table(0.0))?;
        let rows = (0..rows.len() as u32).map(|row| rows[row as usize].row(texel_angle(row)));
        Some(Self {
            mapping: map.mapping,
            axes: map.axes().map(|axis| axis.as_vec3()),
            table,
            rows: rows.collect(),
            texels,
        })
    }

    /// The radiance that the map shows in `direction`, and the density with which
    /// [`LightModel::sample`] draws it.
    #[inline(always)]
    pub(crate) fn look<R: Real>(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let along = |axis: Vec3| dot(R::Vec3::splat(axis), direction);
        let [x, y, z] = self.axes.map(along);
        let (u, v) = self.mapping.place::<R>(R::Vec3::new(x, y, z));
        let size = [self.texels.width(), self.texels.height()];
        let (x, y) = (u * size[0] as f32, v * size[1] as f32);
        let cell = |x: R, size: u32| whole(clamp(x, R::ZERO, R::splat(size as f32 - 0.5)));
        let (row, column) = (cell(y, size[1]), cell(x, size[0]));
        (self.radiance(x, y), self.pdf_of(row, column))
    }

    /// The density of the samples in a texel per unit solid angle.
    #[inline(always)]
    fn pdf_of<R: Real>(&self, row: R::Word, column: R::Word) -> R {
        let (_, per_angle) = self.row::<R>(row);
        self.table.probability::<R>(row, column) * per_angle
    }

    #[inline(always)]
    fn row<R: Real>(&self, row: R::Word) -> (R::Vec3, R) {
        let row = if self.rows.len() == 1 { R::Word::splat(0) } else { row };
        R::gather(&self.rows, R::index(row, self.rows.len()), |row| row)
    }

    /// The radiance at the position (x, y) in texels from the upper left corner.
    #[inline(always)]
    fn radiance<R: Real>(&self, x: R, y: R) -> R::Vec3 {
        let (x, y) = (x - R::splat(0.5), y - R::splat(0.5));
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let fetch = |_, [x, y]: [f32; 2]| {
            let (x, y) = (x as i32, y as i32);
            let size = [self.texels.width(), self.texels.height()];
            let texel = |x, y| {
                let [x, y] = neighbor(self.mapping, [x, y], size);
                self.texels.get(x, y)
            };
            let taps = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
            std::array::from_fn::<f32, 12, _>(|i| taps[i / 3][i % 3])
        };
        let taps = R::each_lane(R::Word::splat(0), [x0, y0], fetch);
        let tap = |i: usize| R::Vec3::new(taps[3 * i], taps[3 * i + 1], taps[3 * i + 2]);
        let row = |i: usize| tap(i) * (R::ONE - fx) + tap(i + 1) * fx;
        row(0) * (R::ONE - fy) + row(2) * fy
    }
}

impl LightModel for Environment {
    #[inline(never)]
    fn sample<R: Real>(
        table: &[Self],
        _: R::Index,
        _: R::Vec3,
        _: R,
        uv: (R, R),
    ) -> LightSample<R> {
        let [map] = table else { unreachable!("a scene has at most one environment") };
        let Cell { row, column, position: (fx, fy) } = map.table.choose(uv);
        let (band, per_angle) = map.row::<R>(row);
        let x = R::from_word(column) + fx;
        let (width, height) = (map.texels.width() as f32, map.texels.height() as f32);
        let (local, y) = match map.mapping {
            Mapping::LatLong => {
                let down = band[0] + band[1] * fy;
                let across = (down * (R::splat(2.0) - down)).sqrt();
                let cos = (R::ONE - down) * band[2];
                let (sin_turn, cos_turn) = sin_cos_turns(x * (1.0 / width) - R::splat(0.5));
                let local = R::Vec3::new(across * sin_turn, cos, -(across * cos_turn));
                (local, atan2(across, cos) * (height / PI))
            }
            Mapping::EqualArea => {
                let y = R::from_word(row) + fy;
                let (u, v) = (x * (1.0 / width), y * (1.0 / height));
                (Mapping::equal_area_direction(u, v), y)
            }
        };
        let [ax, ay, az] = map.axes.map(R::Vec3::splat);
        let direction = normalize(ax * local[0] + ay * local[1] + az * local[2]);
        LightSample {
            direction,
            distance: R::INFINITY,
            pdf: map.table.probability::<R>(row, column) * per_angle,
            tint: map.radiance(x, y),
            front: R::Mask::ALL,
            visible: R::Mask::ALL,
        }
    }

    #[inline(always)]
    fn pdf<R: Real>(table: &[Self], _: R::Index, ray: &Ray<R>, _: R) -> R {
        let [map] = table else { unreachable!("a scene has at most one environment") };
        map.look(ray.direction).1
    }
}

/// The part of the sphere between two latitudes.
struct BandOfSphere {
    /// 1 − |cos θ| at the first and the last latitude.
    down: [f64; 2],
    /// Sign of cos θ.
    sign: f64,
}

impl BandOfSphere {
    /// The part that row `row` of `height` shows.
    fn new(row: u32, height: u32) -> Self {
        // 1 − cos θ = 2 sin² θ/2, without the cancellation.
        let down = |row: u32| {
            let (sin, _) = sin_cos_degrees(90.0 * f64::from(row) / f64::from(height));
            2.0 * sin * sin
        };
        match 2 * row < height {
            true => Self { down: [down(row), down(row + 1)], sign: 1.0 },
            false => Self { down: [down(height - row), down(height - row - 1)], sign: -1.0 },
        }
    }

    fn whole() -> Self {
        Self { down: [0.0, 2.0], sign: 1.0 }
    }

    fn solid_angle(&self) -> f64 {
        2.0 * f64::consts::PI * (self.down[1] - self.down[0]).abs()
    }

    /// The row of [`Environment::rows`] for texels of this solid angle.
    fn row(&self, texel: f64) -> Row {
        let [begin, end] = self.down;
        [begin, end - begin, self.sign, 1.0 / texel].map(|value| (value as f32).to_bits())
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

/// The mean luminance of the texels of a row, interpolated as [`Environment::radiance`] does.
fn means(
    luminances: &[f32],
    mapping: Mapping,
    size: [u32; 2],
    row: u32,
) -> impl Iterator<Item = f64> {
    const WEIGHTS: [(i32, f64); 3] = [(-1, 0.125), (0, 0.75), (1, 0.125)];
    (0..size[0] as i32).map(move |x| {
        let mut sum = 0.0;
        for (dy, weight_y) in WEIGHTS {
            for (dx, weight_x) in WEIGHTS {
                let texel = neighbor(mapping, [x + dx, row as i32 + dy], size);
                let luminance = luminances[Texels::index::<f32>(texel, size) as usize];
                sum += weight_x * weight_y * f64::from(luminance);
            }
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::math::{length, max};

    /// A map with a dark sky, a sun and a few coloured texels.
    fn map(mapping: Mapping, compensated: bool) -> Environment {
        let (width, height) = if mapping == Mapping::LatLong { (16, 9) } else { (12, 12) };
        let mut random = Stream::new(6);
        let mut texels: Vec<[f32; 4]> = (0..width * height)
            .map(|_| [random.uniform(), random.uniform(), random.uniform(), 1.0])
            .collect();
        texels[21] = [400.0, 300.0, 200.0, 1.0];
        texels[60..64].fill([0.0; 4]);
        texels[76..80].fill([0.0; 4]);
        let mut map = EnvironmentMap::from_file("");
        (map.mapping, map.compensated, map.rotation) = (mapping, compensated, [20.0, 140.0, -30.0]);
        map.set_texels(Texels::from_floats(width, height, texels));
        Environment::new(&map).unwrap()
    }

    fn sample(map: &Environment, uv: (f32, f32)) -> LightSample<f32> {
        Environment::sample::<f32>(std::slice::from_ref(map), 0, Vec3::ZERO, 0.0, uv)
    }

    #[test]
    fn samples_have_the_radiance_and_density_of_their_direction() {
        for mapping in [Mapping::LatLong, Mapping::EqualArea] {
            for compensated in [false, true] {
                let map = map(mapping, compensated);
                let mut random = Stream::new(8);
                let mut differ = 0;
                for _ in 0..100_000 {
                    let sample = sample(&map, (random.uniform(), random.uniform()));
                    assert!((length(sample.direction) - 1.0).abs() < 1e-6);
                    let (radiance, pdf) = map.look::<f32>(sample.direction);
                    let off = length(radiance - sample.tint);
                    assert!(off < 2e-3 * max(length(radiance), 1.0), "{radiance} {}", sample.tint);
                    // Rounding moves a few directions to the next texel.
                    differ += u32::from((pdf - sample.pdf).abs() > 1e-4 * pdf);
                }
                assert!(differ < 20, "{differ}");
            }
        }
    }

    /// Compares with the integral over directions, by the midpoint rule.
    #[test]
    fn estimates_of_the_irradiance_agree_with_integrals() {
        for mapping in [Mapping::LatLong, Mapping::EqualArea] {
            let map = map(mapping, false);
            let (mut integral, mut measure) = (0.0, 0.0);
            const ROWS: u32 = 1000;
            for row in 0..ROWS {
                let z = (row as f32 + 0.5) / ROWS as f32 * 2.0 - 1.0;
                for column in 0..2 * ROWS {
                    let turn = column as f32 / (2 * ROWS) as f32;
                    let (sin, cos) = sin_cos_turns(turn);
                    let across = (1.0 - z * z).sqrt();
                    let (radiance, pdf) = map.look::<f32>(Vec3::new(across * cos, across * sin, z));
                    let angle = 4.0 * f64::consts::PI / f64::from(ROWS * 2 * ROWS);
                    integral += luminance(radiance) * angle;
                    measure += f64::from(pdf) * angle;
                }
            }
            assert!((measure - 1.0).abs() < 2e-3, "{measure}");
            let mut random = Stream::new(9);
            let (mut sum, count) = (0.0, 400_000);
            for _ in 0..count {
                let sample = sample(&map, (random.uniform(), random.uniform()));
                sum += luminance(sample.tint) / f64::from(sample.pdf);
            }
            let estimate = sum / f64::from(count);
            assert!((estimate / integral - 1.0).abs() < 4e-3, "{estimate} {integral}");
        }
    }

    #[test]
    fn black_maps_are_no_lights() {
        let mut map = EnvironmentMap::from_file("");
        map.set_texels(Texels::from_floats(2, 2, vec![[0.0; 4]; 4]));
        assert!(Environment::new(&map).is_none());
        map.set_texels(Texels::from_floats(2, 2, vec![[3.0; 4]; 4]));
        map.compensated = true;
        let gray = Environment::new(&map).unwrap();
        let (radiance, pdf) = gray.look::<f32>(Vec3::X);
        assert_eq!(radiance, Vec3::splat(3.0));
        assert!((pdf - 0.25 / PI).abs() < 1e-6, "uniform: {pdf}");
    }
}
