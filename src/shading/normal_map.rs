//! Normal maps: textures that turn the shading normal.

use super::material::MaterialTable;
use super::{Interaction, LEAST_COSINE, ScatterNormals};
use crate::geometry::{Partials, ShadingNormal};
use crate::math::{Mask, Real, Vector, Word, cross, dot, normalize};

impl<R: Real> Interaction<'_, R> {
    /// Turns the shading normals as the normal maps of the materials at `index` of `table` say.
    #[inline(always)]
    pub(crate) fn map_normals<E>(
        &mut self,
        table: &MaterialTable<E>,
        index: R::Index,
        glossy: bool,
    ) {
        if table.normals.is_empty() {
            return;
        }
        let code = R::pick(&table.normals, index);
        let mapped = !code.eq(R::Word::splat(0));
        if mapped.any() {
            self.turn(code, mapped, glossy);
        }
    }

    #[inline(never)]
    fn turn(&mut self, code: R::Word, mapped: R::Mask, glossy: bool) {
        let (bent, mapped) = self.turned(code, mapped, glossy);
        self.normals = ScatterNormals {
            shading: mapped.select(bent.shading, self.normals.shading),
            mirror: mapped.select(bent.mirror, self.normals.mirror),
        };
        self.soft = self.soft | (mapped & !self.smooth);
        self.smooth = self.smooth | mapped;
    }

    /// The shading normals with the maps of these codes only, whatever map turned the normals before, for
    /// lobes that reflect like a mirror. Code 0 stands for no map.
    #[inline(never)]
    pub(crate) fn other_mirror_normals(&self, code: R::Word) -> R::Vec3 {
        let ShadingNormal { normal: shading, smooth, .. } = self.surface.shading;
        let plain =
            ScatterNormals::<R>::new(shading, smooth, self.normal, self.ray.direction, true);
        let mapped = !code.eq(R::Word::splat(0));
        if !mapped.any() {
            return plain.mirror;
        }
        let (bent, mapped) = self.turned(code, mapped, true);
        mapped.select(bent.mirror, plain.mirror)
    }

    /// The unit tangent and bitangent, which are perpendicular to the shading normal without a map. They are
    /// not finite where texture coordinates define no tangent.
    #[inline(always)]
    fn tangents(&self) -> (R::Vec3, R::Vec3) {
        let Partials { u, v, tangent } =
            self.surfaces.partials(self.shape, &self.ray, self.hit, &self.surface);
        let up = self.surface.shading.normal;
        let tangent = normalize(tangent - up * dot(up, tangent));
        let across = cross(up, tangent);
        let mirrored = dot(cross(up, u), v).lt(R::ZERO);
        (tangent, mirrored.select(-across, across))
    }

    /// The direction along which `along` = (x, y) points on the surface, with x along the tangent and y along
    /// the bitangent. Not finite where texture coordinates define no tangent.
    #[inline(never)]
    pub(crate) fn on_surface(&self, along: [R; 2]) -> R::Vec3 {
        let (tangent, bitangent) = self.tangents();
        tangent * along[0] + bitangent * along[1]
    }

    /// A map contains (n + 1) / 2, where the components of n are along the tangent, along the
    /// bitangent, and along the shading normal without the map. These three are unit vectors,
    /// perpendicular to each other, while the reference shader of MikkTSpace (Mikkelsen 2008,
    /// "Simulation of Wrinkled Surfaces Revisited") leaves them as interpolated. On the back, the
    /// normal is reversed. A normal that would face into the surface is bent to its horizon. Also returns
    /// which lanes are mapped: where texture coordinates define no tangent, the surface stays as it is.
    #[inline(always)]
    fn turned(&self, code: R::Word, mapped: R::Mask, glossy: bool) -> (ScatterNormals<R>, R::Mask) {
        let (up, normal) = (self.surface.shading.normal, self.normal);
        let (tangent, bitangent) = self.tangents();
        let color = self
            .textures
            .map_or(R::Vec3::gray(R::splat(0.5)), |textures| textures.normal(code, self));
        let [x, y, z] = [color[0], color[1], color[2]].map(|c| c * 2.0 - R::ONE);
        let turned = normalize(tangent * x + bitangent * y + up * z);
        let length2 = dot(turned, turned);
        let mapped = mapped & length2.gt(R::splat(0.5)) & length2.lt(R::splat(2.0));
        let turned = dot(up, normal).lt(R::ZERO).select(-turned, turned);
        let cos = dot(turned, normal);
        let least = R::splat(LEAST_COSINE);
        let below = cos.lt(least);
        let turned = below.select(normalize(turned + normal * (least - cos)), turned);
        let bent = ScatterNormals::new(turned, mapped, normal, self.ray.direction, glossy);
        (bent, mapped)
    }
}
