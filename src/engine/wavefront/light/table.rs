//! A scene's lights as vectors read them: rows of quads, and the cells by which they are chosen.

use super::Chosen;
use crate::engine::dimension::{Dimension, Randoms};
use crate::scene::{Cell, Light, LightShape, Lights, Sides};
use crate::simd::random::PathKeys;
use crate::simd::{
    Float, Indices, Int, LANES, Lanes, Mask, Quad, Vec3x, gather_quads, quad, splat_quad,
};

/// The lights.
#[derive(Debug, Default)]
pub(in crate::engine::wavefront) struct LightTable {
    pub(super) rows: Vec<Row>,
    pub(super) ends: Ends,
    /// [`AliasTable::cells`](crate::scene::AliasTable::cells).
    cells: Vec<Quad>,
    rest: u32,
}

/// The number after that of the last light of a shape.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ends {
    pub(super) spheres: u32,
    pub(super) quads: u32,
}

/// What there is to know of a light:
///
/// | | sphere | quad | triangle |
/// |---|---|---|---|
/// | 0 | emission, flags | emission, flags | emission, flags |
/// | 1 | centre, chance | corner, chance | vertex, chance |
/// | 2 | motion, radius | unit edge, width | vertex, – |
/// | 3 | – | unit edge, height | vertex, – |
/// | 4 | – | normal, area | normal, area |
pub(super) type Row = [Quad; 5];

/// Flags: shines on its front only; is a rectangle.
pub(super) const FRONT_ONLY: u32 = 1;
pub(super) const RECTANGLE: u32 = 2;

impl LightTable {
    pub(in crate::engine::wavefront) fn new(lights: &Lights) -> Self {
        let Some(table) = lights.table() else { return Self::default() };
        let number = |is: fn(&LightShape) -> bool| {
            lights.all().iter().filter(|light| is(&light.shape)).count() as u32
        };
        let spheres = number(|shape| matches!(shape, LightShape::Sphere(_)));
        let quads = spheres + number(|shape| matches!(shape, LightShape::Quad(_)));
        let (cells, rest) = table.cells();
        let words = |&Cell { first, entry, alias }: &Cell| [first, entry, alias, 0];
        let rows = lights.all().iter().map(row).collect();
        Self { rows, ends: Ends { spheres, quads }, cells: cells.iter().map(words).collect(), rest }
    }

    /// [`Lights::choose`] a lane.
    #[inline(always)]
    pub(in crate::engine::wavefront) fn choose(&self, randoms: &Randoms<PathKeys>) -> Chosen<'_> {
        if self.rows.len() == 1 {
            return Chosen { table: self, lights: [0; LANES], same: Some(0) };
        }
        let bits = randoms.bits(Dimension::LIGHT_CHOICE);
        let cells = Indices::new(bits.shifted_down(self.rest), self.cells.len());
        let (words, _) = cells.gather(&self.cells, |cell| cell);
        let [first, entry, alias] = words.0.map(|word| word.to_bits());
        let place = bits & Int::splat((1 << self.rest) - 1);
        let is_first = (place + Int::splat(1)).le(first);
        self.chosen(Int::select(is_first, entry, alias))
    }

    /// The lights that `primitives` are, and which of them are.
    #[inline(always)]
    pub(in crate::engine::wavefront) fn of(
        &self,
        lights: &Lights,
        primitives: &Lanes<u32>,
    ) -> (Chosen<'_>, Mask) {
        let of = lights.of_primitives();
        let found = Int::new(Indices::new(Int::new(*primitives), of.len()).pick(of));
        let none = found.eq(Int::splat(Lights::NONE));
        (self.chosen(Int::select(none, Int::ZERO, found)), !none)
    }

    /// These.
    #[inline(always)]
    pub(super) fn chosen(&self, lights: Int) -> Chosen<'_> {
        let numbers = lights.to_array();
        let all_same = (!lights.eq(Int::splat(numbers[0]))).bits() == 0;
        Chosen { table: self, lights: numbers, same: all_same.then_some(numbers[0]) }
    }
}

impl Chosen<'_> {
    /// Quad `place` of the rows of all lanes.
    #[inline(always)]
    pub(super) fn row(&self, place: usize) -> (Vec3x, Float) {
        let rows = &self.table.rows;
        // One light for all is what there mostly is.
        match self.same {
            Some(light) => splat_quad(&rows[light as usize][place]),
            None => gather_quads(&self.lights, |light| &rows[light as usize][place]),
        }
    }
}

fn row(light: &Light) -> Row {
    let one_sided = if light.emission.sides == Sides::Front { FRONT_ONLY } else { 0 };
    let rectangle = matches!(&light.shape, LightShape::Quad(quad) if quad.rectangle);
    let flags = one_sided | if rectangle { RECTANGLE } else { 0 };
    let emission = quad(light.emission.radiance, f32::from_bits(flags));
    let [a, b, c, d] = match &light.shape {
        LightShape::Sphere(sphere) => [
            quad(sphere.center, light.chance),
            quad(sphere.motion(), sphere.radius),
            [0; 4],
            [0; 4],
        ],
        LightShape::Quad(light_quad) => {
            let ([x, y, normal], (width, height)) = (light_quad.axes, light_quad.size);
            [
                quad(light_quad.corner, light.chance),
                quad(x, width),
                quad(y, height),
                quad(normal, light_quad.area),
            ]
        }
        LightShape::Triangle(triangle) => {
            let [p, q, r] = triangle.vertices;
            [
                quad(p, light.chance),
                quad(q, 0.0),
                quad(r, 0.0),
                quad(triangle.normal, triangle.area),
            ]
        }
    };
    [emission, a, b, c, d]
}
