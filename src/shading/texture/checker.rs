//! A 3-D checker of cubic cells in two colours.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TextureParameters, TexturePoint};
use crate::checks::Location;
use crate::error::Result;
use crate::math::{Mask, Real, Row, row};
use crate::shading::Images;

/// A 3-D checker: `odd` where sin(sx)·sin(sy)·sin(sz) < 0 with s = `scale`, else `even`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checker {
    /// Colour of odd cells in linear RGB, each channel in [0, 1].
    pub odd: [f32; 3],
    /// Colour of even cells in linear RGB, each channel in [0, 1].
    pub even: [f32; 3],
    /// Scale, above 0 and at most 1e6. Cells have the side π/scale.
    pub scale: f32,
}

impl TextureParameters for Checker {
    fn load(&mut self, e: &Location<'_>, _: &mut Images<'_>) -> Result<()> {
        let ok = self.scale > 0.0 && self.scale <= 1e6;
        e.check(ok, "scale", "above 0 and at most 1e6", self.scale)?;
        e.color("odd", self.odd, 1.0)?;
        e.color("even", self.even, 1.0).map(|_| ())
    }

    fn identity(&self) -> Value {
        json!({ "checker": self })
    }
}

impl TextureModel for Checker {
    /// (`odd`, cells per unit of length), (`even`, 0).
    type Entry = [Row; 2];

    fn entry(&self) -> [Row; 2] {
        let frequency = (f64::from(self.scale) / PI) as f32;
        [row(self.odd.into(), frequency), row(self.even.into(), 0.0)]
    }

    /// The product of sines is negative exactly if the sum of the cell's three integer coordinates
    /// is odd.
    #[inline(always)]
    fn value<R: Real>(table: &[[Row; 2]], index: R::Word, at: &impl TexturePoint<R>) -> Rgba<R> {
        let index = R::index_of_few(index, table.len());
        let (odd_color, frequency) = R::gather(table, index, |entry| &entry[0]);
        let (even_color, _) = R::gather(table, index, |entry| &entry[1]);
        let odd = |x: R| {
            let cell = (x * frequency).floor();
            !(cell - (cell * 0.5).floor() * 2.0).eq(R::ZERO)
        };
        let point = at.point();
        let is_odd = odd(point[0]) ^ odd(point[1]) ^ odd(point[2]);
        (is_odd.select(odd_color, even_color), R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::Stream;

    #[derive(Clone, Copy)]
    struct Point(Vec3);

    impl TexturePoint<f32> for Point {
        fn point(&self) -> Vec3 {
            self.0
        }

        fn uv(&self) -> (f32, f32) {
            unreachable!("a checker does not use texture coordinates")
        }

        fn second_uv(&self) -> (f32, f32) {
            self.uv()
        }

        fn vertex_color(&self) -> Vec3 {
            unreachable!("a checker does not use the colours of vertices")
        }
    }

    #[test]
    #[allow(clippy::disallowed_methods)] // the definition uses sines
    fn checker_is_the_sign_of_the_product_of_sines() {
        let checker = Checker { odd: [1.0, 0.0, 0.0], even: [0.0, 1.0, 0.0], scale: 10.0 };
        let table = [checker.entry()];
        let mut random = Stream::new(2);
        for _ in 0..100_000 {
            let p = Vec3::from_array(std::array::from_fn(|_| random.between(-30.0, 30.0)));
            let sines = p.to_array().map(|x| (10.0 * f64::from(x)).sin());
            if sines.iter().any(|s| s.abs() < 1e-4) {
                continue;
            }
            let want = if sines.iter().product::<f64>() < 0.0 { checker.odd } else { checker.even };
            assert_eq!(Checker::value::<f32>(&table, 0, &Point(p)).0.to_array(), want, "{p}");
        }
    }
}
