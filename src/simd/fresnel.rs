//! How much smooth surfaces reflect, over lanes: [`crate::math::fresnel`] to the bit.

use super::{Float, Vec3x, axes};

/// [`schlick`](crate::math::fresnel::schlick).
#[inline(always)]
pub(crate) fn schlick(cos: Float, ior: Float) -> Float {
    let one = Float::splat(1.0);
    let r = (one - ior) / (one + ior);
    let r0 = r * r;
    let x = one - cos;
    let x2 = x * x;
    r0 + (one - r0) * (x2 * x2 * x)
}

/// [`dielectric`](crate::math::fresnel::dielectric).
#[inline(always)]
pub(crate) fn dielectric(cos: Float, eta: Float) -> Float {
    let one = Float::splat(1.0);
    let sin2 = (one - cos * cos) / (eta * eta);
    let refracted = Float::ZERO.max(one - sin2).sqrt();
    let parallel = (eta * cos - refracted) / (eta * cos + refracted);
    let across = (cos - eta * refracted) / (cos + eta * refracted);
    let partial = Float::splat(0.5) * (parallel * parallel + across * across);
    sin2.gt(one).select(one, partial)
}

/// [`conductor`](crate::math::fresnel::conductor).
#[inline(always)]
pub(crate) fn conductor(cos: Float, eta: Vec3x, k: Vec3x) -> Vec3x {
    Vec3x(axes(|axis| channel(cos, eta[axis], k[axis])))
}

#[inline(always)]
fn channel(cos: Float, eta: Float, k: Float) -> Float {
    let number = Float::splat;
    let cos2 = cos * cos;
    let sin2 = number(1.0) - cos2;
    let (n2, k2) = (eta * eta, k * k);
    let difference = n2 - k2 - sin2;
    let modulus = (difference * difference + number(4.0) * n2 * k2).sqrt();
    let real = Float::ZERO.max(number(0.5) * (modulus + difference)).sqrt();
    let cross = number(2.0) * real * cos;
    let across = ((modulus + cos2) - cross) / ((modulus + cos2) + cross);
    let (sum, part) = (cos2 * modulus + sin2 * sin2, cross * sin2);
    let parallel = across * ((sum - part) / (sum + part));
    number(0.5) * (across + parallel)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::fresnel;
    use crate::math::random::Stream;
    use crate::simd::{LANES, Lanes};

    #[test]
    fn lanes_are_the_scalar_functions() {
        let mut random = Stream::new(12);
        for _ in 0..50_000 {
            let cos: Lanes = std::array::from_fn(|_| match random.bits() % 16 {
                0 => 0.0,
                1 => 1.0,
                _ => random.uniform(),
            });
            let mut numbers = || -> Lanes { std::array::from_fn(|_| random.between(0.1, 4.0)) };
            let (eta, k) = ([numbers(), numbers(), numbers()], [numbers(), numbers(), numbers()]);
            let (by_schlick, exact) = (
                schlick(Float::new(cos), Float::new(eta[0])).to_array(),
                dielectric(Float::new(cos), Float::new(eta[0])).to_array(),
            );
            let metal = conductor(Float::new(cos), Vec3x::new(&eta), Vec3x::new(&k));
            for lane in 0..LANES {
                let at = |v: &[Lanes; 3]| Vec3::from_array(v.map(|axis| axis[lane]));
                let bits = f32::to_bits;
                let (cos, n) = (cos[lane], eta[0][lane]);
                assert_eq!(bits(by_schlick[lane]), bits(fresnel::schlick(cos, n)));
                assert_eq!(bits(exact[lane]), bits(fresnel::dielectric(cos, n)), "{cos} {n}");
                let want = fresnel::conductor(cos, at(&eta), at(&k)).to_array();
                assert_eq!(metal.0.map(|c| bits(c.to_array()[lane])), want.map(bits));
            }
        }
    }
}
