//! The microfacets of rough surfaces over lanes: [`crate::math::microfacet`] to the bit.

use std::f32::consts::PI;

use super::trig::sin_cos_turns;
use super::{Float, Vec3x};

/// [`Ggx`](crate::math::microfacet::Ggx) a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GgxLanes {
    pub(crate) alpha: Float,
}

impl GgxLanes {
    #[inline(always)]
    pub(crate) fn density(self, m: Vec3x) -> Float {
        let a2 = self.alpha * self.alpha;
        let d = (m[0] * m[0] + m[1] * m[1]) + a2 * (m[2] * m[2]);
        a2 / (Float::splat(PI) * d * d)
    }

    #[inline(always)]
    pub(crate) fn length(self, w: Vec3x) -> Float {
        let a2 = self.alpha * self.alpha;
        (a2 * (w[0] * w[0] + w[1] * w[1]) + w[2] * w[2]).sqrt()
    }

    #[inline(always)]
    pub(crate) fn bound(self, wo: Vec3x) -> Float {
        let (one, a2) = (Float::splat(1.0), self.alpha * self.alpha);
        let s = one + (wo[0] * wo[0] + wo[1] * wo[1]).sqrt();
        let s2 = s * s;
        (one - a2) * s2 / (s2 + a2 * (wo[2] * wo[2]))
    }

    #[inline(always)]
    pub(crate) fn sample(self, wo: Vec3x, share: Float, u: Float, v: Float) -> Vec3x {
        let (one, alpha) = (Float::splat(1.0), self.alpha);
        let stretched = Vec3x([alpha * wo[0], alpha * wo[1], wo[2]]) / self.length(wo);
        let lowest = share * stretched[2];
        let z = (one - u) * (one + lowest) - lowest;
        let radius = Float::ZERO.max(one - z * z).sqrt();
        let (sin, cos) = sin_cos_turns(v);
        let half = stretched + Vec3x([radius * cos, radius * sin, z]);
        Vec3x([alpha * half[0], alpha * half[1], half[2]]).normalize()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::microfacet::Ggx;
    use crate::math::random::Stream;
    use crate::math::warp::uniform_hemisphere;
    use crate::simd::{LANES, Lanes, axes};

    #[test]
    fn lanes_are_the_scalar_functions() {
        let mut random = Stream::new(13);
        for _ in 0..50_000 {
            let alpha: Lanes = std::array::from_fn(|_| match random.bits() % 8 {
                0 => 0.0,
                1 => 1.0,
                _ => random.between(0.001, 1.0),
            });
            let mut direction =
                || uniform_hemisphere(Vec3::Z, random.uniform(), random.uniform()).0;
            let wo: Lanes<Vec3> = std::array::from_fn(|_| direction());
            let [u, v]: [Lanes; 2] = [(); 2].map(|()| std::array::from_fn(|_| random.uniform()));
            let w = Vec3x(axes(|axis| Float::new(wo.map(|w| w[axis]))));
            let lanes = GgxLanes { alpha: Float::new(alpha) };
            let bound = lanes.bound(w);
            let m = lanes.sample(w, bound, Float::new(u), Float::new(v));
            let found = [bound, lanes.length(w), lanes.density(m), m[0], m[1], m[2]];
            for lane in 0..LANES {
                let one = Ggx { alpha: alpha[lane] };
                let bound = one.bound(wo[lane]);
                let m = one.sample(wo[lane], bound, u[lane], v[lane]);
                let want = [bound, one.length(wo[lane]), one.density(m), m.x, m.y, m.z];
                for (found, want) in found.map(|v| v.to_array()[lane]).into_iter().zip(want) {
                    let same = found.to_bits() == want.to_bits();
                    assert!(same || found.is_nan() && want.is_nan(), "{found} {want}");
                }
            }
        }
    }
}
