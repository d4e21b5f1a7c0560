//! The normals about which surfaces scatter light.

use crate::math::{Mask, Real, dot, normalize, reflect};

/// Least cosine between a shading normal and the direction to the viewer, and between a geometric
/// normal and a mirrored direction.
pub(crate) const LEAST_COSINE: f32 = 1e-3;

/// The normals about which light is scattered at points that rays of this direction hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScatterNormals<R: Real> {
    /// The shading normal. It is bent where it would face away from the viewer, as near silhouettes.
    pub(crate) shading: R::Vec3,
    /// The shading normal for lobes that reflect like a mirror, sharp or blurred. On glossy materials, it
    /// is bent where the mirrored direction would be inside the surface, which would leave black fringes
    /// (Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", section on
    /// shading normals).
    pub(crate) mirror: R::Vec3,
}

impl<R: Real> ScatterNormals<R> {
    /// Those of points with the normals `shading` where they are `smooth`. `normal` is the geometric normal
    /// on the side that was hit. The results are on the same side.
    #[inline(always)]
    pub(crate) fn new(
        shading: R::Vec3,
        smooth: R::Mask,
        normal: R::Vec3,
        direction: R::Vec3,
        glossy: bool,
    ) -> Self {
        if !smooth.any() {
            return Self { shading: normal, mirror: normal };
        }
        let least = R::splat(LEAST_COSINE);
        let given = dot(shading, normal).lt(R::ZERO).select(-shading, shading);
        let given = smooth.select(given, normal);
        let (mut shading, mut mirror) = (given, given);
        let cos = -dot(given, direction);
        let away = smooth & cos.lt(least);
        if away.any() {
            shading = away.select(normalize(given - direction * (least - cos)), shading);
        }
        if !glossy {
            return Self { shading, mirror: shading };
        }
        let mirrored = reflect(direction, given);
        let cos = dot(mirrored, normal);
        let inside = smooth & cos.lt(least);
        if inside.any() {
            let raised = normalize(mirrored + normal * (least - cos));
            mirror = inside.select(normalize(raised - direction), mirror);
        }
        Self { shading, mirror }
    }
}
