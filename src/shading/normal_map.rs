//! Normal maps: textures that turn the shading normal.

use super::material::MaterialTable;
use super::{Interaction, LEAST_COSINE, ScatterNormals};
use crate::geometry::Partials;
use crate::math::{Mask, Real, Word, cross, dot, normalize};

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

    /// A map contains (n + 1) / 2, where the components of n are along the tangent, along the
    /// bitangent, and along the shading normal without the map. These three are unit vectors,
    /// perpendicular to each other, while the reference shader of MikkTSpace (Mikkelsen 2008,
    /// "Simulation of Wrinkled Surfaces Revisited") leaves them as interpolated. On the back, the
    /// normal is reversed. A normal that would face into the surface is bent to its horizon.
    #[inline(never)]
    fn turn(&mut self, code: R::Word, mapped: R::Mask, glossy: bool) {
        let &mut Self { surfaces, shape, surface, normal, normals, smooth, .. } = self;
        let Some(textures) = self.textures else { return };
        let Partials { u, v, tangent } = surfaces.partials(shape, &self.ray, self.hit, &surface);
        let up = surface.shading.normal;
        let tangent = normalize(tangent - up * dot(up, tangent));
        let across = cross(up, tangent);
        let mirrored = dot(cross(up, u), v).lt(R::ZERO);
        let bitangent = mirrored.select(-across, across);
        let [x, y, z] = {
            let color = textures.normal(code, self);
            [color[0], color[1], color[2]].map(|c| c * 2.0 - R::ONE)
        };
        let turned = normalize(tangent * x + bitangent * y + up * z);
        // Where texture coordinates define no tangent, the surface stays as it is.
        let length2 = dot(turned, turned);
        let mapped = mapped & length2.gt(R::splat(0.5)) & length2.lt(R::splat(2.0));
        let turned = dot(up, normal).lt(R::ZERO).select(-turned, turned);
        let cos = dot(turned, normal);
        let least = R::splat(LEAST_COSINE);
        let below = cos.lt(least);
        let turned = below.select(normalize(turned + normal * (least - cos)), turned);
        let bent = ScatterNormals::<R>::new(turned, mapped, normal, self.ray.direction, glossy);
        self.normals = ScatterNormals {
            shading: mapped.select(bent.shading, normals.shading),
            mirror: mapped.select(bent.mirror, normals.mirror),
        };
        self.soft = self.soft | (mapped & !smooth);
        self.smooth = smooth | mapped;
    }
}
