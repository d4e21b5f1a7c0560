//! Images of the light that reaches a scene from all directions, sampled by their luminance.

mod build;
mod file;
mod mapping;
mod patch;
mod table;

use std::f32::consts::PI;
use std::sync::Arc;

pub use file::EnvironmentMap;
use glam::Vec3;
pub use mapping::Mapping;

use self::mapping::neighbor;
use self::patch::{Patch, Span};
use self::table::{Cell, CellTable};
use super::LightModel;
use super::sample::LightSample;
use crate::geometry::Ray;
use crate::image::Texels;
use crate::math::{
    Mask, Real, Row, Vector, Word, atan2, clamp, dot, normalize, sin_cos_turns, whole,
};

/// The light of an environment map. Its radiance is interpolated between the centres of texels.
///
/// Samples are drawn from a grid of patches, whose corners are the centres of texels, or on the edges of the map.
/// A table gives the patch, and the bilinear function of the luminance at its corners gives the place in it
/// (Pharr et al., *Physically Based Rendering*, 4th ed., section 2.4.2). So the density is nearly proportional to
/// the luminance, also around a sun of one texel, where a constant density in each texel doubles the variance.
#[derive(Debug)]
pub(crate) struct Environment {
    texels: Arc<Texels>,
    mapping: Mapping,
    /// The axes of the map's frame in the scene.
    axes: [Vec3; 3],
    table: CellTable,
    /// For each row of patches of a latitude-longitude map: 1 − |cos θ| where it begins and how much that
    /// grows to its end, the sign of cos θ, and the reciprocal of the solid angle of a patch of whole width.
    /// Equal-area maps have only the last, for a patch of whole size, in a single row.
    rows: Vec<Row>,
}

impl Environment {
    /// The radiance that the map shows in `direction`, and the density with which
    /// [`LightModel::sample`] draws it.
    #[inline(always)]
    pub(crate) fn look<R: Real>(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let along = |axis: usize| dot(R::Vec3::splat(self.axes[axis]), direction);
        let local = R::Vec3::new(along(0), along(1), along(2));
        let (u, v) = self.mapping.place::<R>(local);
        let place = |u: R, size: u32| clamp(u * size as f32, R::ZERO, R::splat(size as f32));
        let (x, y) = (place(u, self.texels.width()), place(v, self.texels.height()));
        let (column, row) = (whole(x + 0.5), whole(y + 0.5));
        let patch = self.patch::<R>(row, column);
        let (band, per_angle) = self.row::<R>(row);
        let (across, mut down) = patch.place(x, y);
        if self.mapping == Mapping::LatLong {
            // 1 − |cos θ|, without the cancellation.
            let squared = local[0] * local[0] + local[2] * local[2];
            let begun = squared / (R::ONE + local[1] * band[2]) - band[0];
            down = clamp(begun / band[1], R::ZERO, R::ONE);
        }
        let density = patch.density(across, down) * per_angle;
        (patch.radiance(x, y), self.table.probability::<R>(row, column) * density)
    }

    #[inline(always)]
    fn row<R: Real>(&self, row: R::Word) -> (R::Vec3, R) {
        let row = if self.rows.len() == 1 { R::Word::splat(0) } else { row };
        R::gather(&self.rows, R::index(row, self.rows.len()), |row| row)
    }

    /// The patch in this row and column of the grid.
    #[inline(always)]
    fn patch<R: Real>(&self, row: R::Word, column: R::Word) -> Patch<R> {
        let size = [self.texels.width(), self.texels.height()];
        let fetch = |_, [x, y]: [f32; 2]| {
            let (x, y) = (x as i32, y as i32);
            let texel = |x, y| {
                let [x, y] = neighbor(self.mapping, [x, y], size);
                self.texels.get(x, y)
            };
            let taps = [texel(x - 1, y - 1), texel(x, y - 1), texel(x - 1, y), texel(x, y)];
            std::array::from_fn::<f32, 12, _>(|i| taps[i / 3][i % 3])
        };
        let (x, y) = (R::from_word(column), R::from_word(row));
        let taps = R::each_lane(R::Word::splat(0), [x, y], fetch);
        let down = Span::new(y, size[1]);
        // The solid angles of the rows of a latitude-longitude map contain their heights.
        let tall = if self.mapping == Mapping::LatLong { R::ONE } else { down.len() };
        Patch::new(&taps, [Span::new(x, size[0]), down], tall)
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
        let Cell { row, column, position } = map.table.choose(uv);
        let patch = map.patch::<R>(row, column);
        let (across, down) = patch.sample(position);
        let (band, per_angle) = map.row::<R>(row);
        let (x, mut y) = patch.at(across, down);
        let (width, height) = (map.texels.width() as f32, map.texels.height() as f32);
        let u = x * (1.0 / width);
        let local = match map.mapping {
            Mapping::LatLong => {
                let down = band[0] + band[1] * down;
                let sin = (down * (R::splat(2.0) - down)).sqrt();
                let cos = (R::ONE - down) * band[2];
                y = patch.clamp_down(atan2(sin, cos) * (height / PI));
                let (sin_turn, cos_turn) = sin_cos_turns(u - R::splat(0.5));
                R::Vec3::new(sin * sin_turn, cos, -(sin * cos_turn))
            }
            Mapping::EqualArea => Mapping::equal_area_direction(u, y * (1.0 / height)),
        };
        let [ax, ay, az] = map.axes.map(R::Vec3::splat);
        let direction = normalize(ax * local[0] + ay * local[1] + az * local[2]);
        let density = patch.density(across, down) * per_angle;
        LightSample {
            direction,
            distance: R::INFINITY,
            pdf: map.table.probability::<R>(row, column) * density,
            tint: patch.radiance(x, y),
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

#[cfg(test)]
mod tests {
    use std::f64;

    use super::*;
    use crate::math::warp::uniform_sphere;
    use crate::math::{Stream, length, max};
    use crate::shading::luminance;

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

    /// The sun makes the estimate hardly noisier than a map of one colour, in maps of any size.
    #[test]
    fn samples_follow_the_luminance() {
        for (mapping, width, height) in [
            (Mapping::LatLong, 64, 32),
            (Mapping::LatLong, 33, 17),
            (Mapping::LatLong, 1, 9),
            (Mapping::LatLong, 7, 1),
            (Mapping::EqualArea, 32, 32),
            (Mapping::EqualArea, 5, 5),
            (Mapping::EqualArea, 1, 1),
        ] {
            let mut random = Stream::new(10);
            let mut texels: Vec<[f32; 4]> =
                (0..width * height).map(|_| [random.uniform(); 4]).collect();
            texels[(width * (height / 3) + width / 3) as usize] = [400.0; 4];
            let mut map = EnvironmentMap::from_file("");
            map.mapping = mapping;
            map.set_texels(Texels::from_floats(width, height, texels));
            let map = Environment::new(&map).unwrap();
            let (mut sum, mut squares, mut measure) = (0.0, 0.0, 0.0);
            const COUNT: u32 = 100_000;
            for _ in 0..COUNT {
                let sample = sample(&map, (random.uniform(), random.uniform()));
                let estimate = luminance(sample.tint) / f64::from(sample.pdf);
                (sum, squares) = (sum + estimate, squares + estimate * estimate);
                let (x, y) = (random.uniform(), random.uniform());
                let (radiance, pdf) = map.look::<f32>(uniform_sphere(x, y));
                assert!(radiance.min_element() >= 0.0);
                measure += f64::from(pdf) * 4.0 * f64::consts::PI;
            }
            let (mean, count) = (sum / f64::from(COUNT), f64::from(COUNT));
            let variance = squares / count / (mean * mean) - 1.0;
            assert!(variance < 0.1, "{mapping:?} {width} {height}: {variance}");
            // The sun makes this integral noisy.
            assert!((measure / count - 1.0).abs() < 0.3, "{mapping:?} {width} {height}: {measure}");
        }
    }

    #[test]
    fn black_maps_are_no_lights() {
        let mut map = EnvironmentMap::from_file("");
        map.set_texels(Texels::from_floats(2, 2, vec![[0.0; 4]; 4]));
        assert!(Environment::new(&map).is_none());
        map.set_texels(Texels::from_floats(2, 2, vec![[1e-38; 4]; 4]));
        assert!(Environment::new(&map).is_none());
        map.set_texels(Texels::from_floats(2, 2, vec![[3.0; 4]; 4]));
        map.compensated = true;
        let gray = Environment::new(&map).unwrap();
        let (radiance, pdf) = gray.look::<f32>(Vec3::X);
        assert_eq!(radiance, Vec3::splat(3.0));
        assert!((pdf - 0.25 / PI).abs() < 1e-6, "uniform: {pdf}");
    }
}
