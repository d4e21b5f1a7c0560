//! A 2-D checker of texture coordinates in two colours.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TextureParameters, TexturePoint};
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::Result;
use crate::math::{Mask, Real, Row, row};
use crate::shading::Images;

/// A 2-D checker: `even` where the sum of the integer parts of the scaled texture coordinates is even,
/// else `odd`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UvChecker {
    /// Colour of odd cells in linear RGB, each channel in [0, 1].
    pub odd: [f32; 3],
    /// Colour of even cells in linear RGB, each channel in [0, 1].
    pub even: [f32; 3],
    /// Factors of the texture coordinates, within ±1e9: numbers of cells.
    pub scale: (f32, f32),
    /// Added to the scaled texture coordinates, within ±1e9.
    #[serde(default)]
    pub offset: (f32, f32),
}

impl TextureParameters for UvChecker {
    fn load(&mut self, e: &Location<'_>, _: &mut Images<'_>) -> Result<()> {
        let within = |(u, v): (f32, f32)| u.abs() <= MAX_COORDINATE && v.abs() <= MAX_COORDINATE;
        e.check(within(self.scale), "scale", "within ±1e9", self.scale)?;
        e.check(within(self.offset), "offset", "within ±1e9", self.offset)?;
        e.color("odd", self.odd, 1.0)?;
        e.color("even", self.even, 1.0).map(|_| ())
    }

    fn identity(&self) -> Value {
        json!({ "uv_checker": self })
    }
}

impl TextureModel for UvChecker {
    /// (`odd`, factor of u), (`even`, factor of v), (offsets, 0, 0).
    type Entry = [Row; 3];

    fn entry(&self) -> [Row; 3] {
        let offset = [self.offset.0, self.offset.1, 0.0];
        [
            row(self.odd.into(), self.scale.0),
            row(self.even.into(), self.scale.1),
            row(offset.into(), 0.0),
        ]
    }

    /// A call, because every copy in the loops over paths takes time to compile.
    #[inline(never)]
    fn value<R: Real>(table: &[[Row; 3]], index: R::Word, at: &impl TexturePoint<R>) -> Rgba<R> {
        let index = R::index_of_few(index, table.len());
        let (odd_color, across) = R::gather(table, index, |entry| &entry[0]);
        let (even_color, up) = R::gather(table, index, |entry| &entry[1]);
        let (offset, _) = R::gather(table, index, |entry| &entry[2]);
        let odd = |x: R| {
            let cell = x.floor();
            !(cell - (cell * 0.5).floor() * 2.0).eq(R::ZERO)
        };
        let (u, v) = at.uv();
        let is_odd = odd(u * across + offset[0]) ^ odd(v * up + offset[1]);
        (is_odd.select(odd_color, even_color), R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[derive(Clone, Copy)]
    struct Point(f32, f32);

    impl TexturePoint<f32> for Point {
        fn point(&self) -> Vec3 {
            unreachable!("the checker depends on texture coordinates only")
        }

        fn uv(&self) -> (f32, f32) {
            (self.0, self.1)
        }

        fn second_uv(&self) -> (f32, f32) {
            unreachable!("the checker uses the first set")
        }

        fn vertex_color(&self) -> Vec3 {
            self.point()
        }
    }

    #[test]
    fn cells_alternate() {
        let (odd, even) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let checker = UvChecker { odd, even, scale: (2.0, 4.0), offset: (0.5, 1.0) };
        let table = [checker.entry()];
        let color = |u, v| UvChecker::value::<f32>(&table, 0, &Point(u, v)).0.to_array();
        // The cells (0, 1), (1, 1), (1, 2), (-1, 1) and (0, 0).
        for (u, v, want) in [
            (0.1, 0.1, odd),
            (0.3, 0.1, even),
            (0.3, 0.3, odd),
            (-0.3, 0.1, even),
            (0.1, -0.1, even),
        ] {
            assert_eq!(color(u, v), want, "{u}, {v}");
        }
    }
}
