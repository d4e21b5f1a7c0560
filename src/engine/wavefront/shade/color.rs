//! Colours of surfaces.

use glam::Vec3;

use super::Shading;
use super::vertex::Vertex;
use crate::engine::wavefront::materials::{Pattern, texture};
use crate::geometry::{Ray, Surface};
use crate::simd::{Float, Indices, Int, LANES, Lanes, Mask, Vec3x, axes, gather_quads};

impl Shading<'_> {
    /// The albedo at each vertex, and the materials' number.
    #[inline(always)]
    pub(super) fn albedo(&self, pattern: Pattern, vertex: &Vertex) -> (Vec3x, Float) {
        let (color, number) = self.solid(&vertex.primitive);
        let color = match pattern {
            Pattern::Solid => color,
            Pattern::Checker => self.checker(vertex),
            Pattern::Image => self.image(vertex),
        };
        (color, number)
    }

    /// One colour of the primitives' materials, and their number.
    #[inline(always)]
    pub(super) fn solid(&self, primitives: &Lanes<u32>) -> (Vec3x, Float) {
        let Self { scene, materials, .. } = self;
        let table = scene.material_indices();
        let material = Indices::new(Int::new(*primitives), table.len()).pick(table);
        gather_quads(&material, |material| &materials.solid[material as usize])
    }

    /// Quad `place` of [`Materials::more`](crate::engine::wavefront::materials::Materials::more).
    #[inline(always)]
    pub(super) fn more(&self, place: usize, primitives: &Lanes<u32>) -> (Vec3x, Float) {
        let Self { scene, materials, .. } = self;
        gather_quads(primitives, |primitive| {
            &materials.more[scene.material_index(primitive) as usize][place]
        })
    }

    /// [`Checker`](crate::scene::Checker) a lane.
    #[inline(always)]
    fn checker(&self, vertex: &Vertex) -> Vec3x {
        let (odd_color, frequency) = self.more(0, &vertex.primitive);
        let (even_color, _) = self.more(1, &vertex.primitive);
        let odd = |axis: usize| {
            let cell = (vertex.surface.point[axis] * frequency).floor();
            let even = cell - Float::splat(2.0) * (cell * Float::splat(0.5)).floor();
            (!even.eq(Float::ZERO)).bits()
        };
        let odd = Mask::from_bits(odd(0) ^ odd(1) ^ odd(2));
        Vec3x::select(odd, odd_color, even_color)
    }

    /// Pictures, lane by lane.
    fn image(&self, vertex: &Vertex) -> Vec3x {
        let segment = &vertex.segment;
        let vectors =
            [segment.origin, segment.direction, vertex.surface.point, vertex.surface.normal];
        let [origin, direction, point, normal] = vectors.map(|v| axes(|axis| v[axis].to_array()));
        let (t, time) = (vertex.t.to_array(), segment.time.to_array());
        let primitive = &vertex.primitive;
        let mut colors = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let at = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let ray = Ray { origin: at(&origin), direction: at(&direction), time: time[lane] };
            let surface = Surface { point: at(&point), normal: at(&normal), offset: 0.0 };
            let uv = || self.scene.geometry().get(primitive[lane]).uv(&ray, &surface, t[lane]);
            let texture = texture(self.scene, self.scene.material(primitive[lane]));
            let texture = texture.expect("what scatters by its colour has one");
            let color = texture.color(surface.point, uv);
            for axis in 0..3 {
                colors[axis][lane] = color[axis];
            }
        }
        Vec3x::new(&colors)
    }
}
