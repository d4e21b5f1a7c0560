//! SIMD types: vectors of [`LANES`] numbers in structure-of-arrays form.
//!
//! Every kernel is written once over [`Float`]. It uses 16 lanes if compiled for AVX-512, and 8
//! otherwise (one AVX register or two SSE2 registers). This module is built on the crate `wide`,
//! which no other module names.
//!
//! Operators, [`Float::min`], [`Float::max`] and the methods of [`Real`](crate::math::Real) are
//! contract arithmetic: each lane equals the result of the scalar operation of the same name in
//! [`crate::math`], bit for bit. [`Float::free_mul_add`] and
//! [`Float::free_mul_sub`] are not contract arithmetic: use them only to decide where to look for
//! hits, and for decisions that hold despite any rounding.

mod compress;
mod float;
mod indices;
mod int;
mod mask;
mod prefetch;
mod real;
mod rows;
mod vec3x;

pub(crate) use compress::set_lanes;
pub(crate) use float::Float;
pub(crate) use indices::Indices;
pub(crate) use int::Int;
pub(crate) use mask::{Bits, Mask, first_bits};
pub(crate) use prefetch::prefetch;
pub(crate) use rows::{gather_rows, rows_of, splat_row};
pub(crate) use vec3x::{Vec3x, axes};

#[cfg(not(target_feature = "avx512f"))]
use wide::{f32x8 as Register, u32x8 as UintRegister};
#[cfg(target_feature = "avx512f")]
use wide::{f32x16 as Register, u32x16 as UintRegister};

/// Number of lanes in a vector.
pub(crate) const LANES: usize = if cfg!(target_feature = "avx512f") { 16 } else { 8 };

/// One number for each lane, as stored in memory.
pub(crate) type Lanes<T = f32> = [T; LANES];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{self, Real, Stream, Vector, Word};

    /// Random numbers of every kind: arbitrary bits, special values and ordinary numbers.
    fn numbers(random: &mut Stream) -> Lanes {
        const SPECIAL: [f32; 8] =
            [0.0, -0.0, 1.0, -1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-40];
        std::array::from_fn(|_| match random.bits() % 3 {
            0 => SPECIAL[(random.bits() % 8) as usize],
            1 => f32::from_bits(random.bits() as u32),
            _ => random.between(-4.0, 4.0),
        })
    }

    /// Asserts that each lane has the same bits as the scalar, or that both are NaN, whose bits are
    /// unspecified.
    #[track_caller]
    fn same(vector: Float, scalar: impl Fn(usize) -> f32) {
        for (lane, value) in vector.to_array().into_iter().enumerate() {
            let want = scalar(lane);
            assert!(value.to_bits() == want.to_bits() || (value.is_nan() && want.is_nan()));
        }
    }

    #[test]
    fn operations_match_scalars() {
        let mut random = Stream::new(1);
        for _ in 0..20_000 {
            let (a, b) = (numbers(&mut random), numbers(&mut random));
            let (x, y) = (Float::new(a), Float::new(b));
            same(x + y, |i| a[i] + b[i]);
            same(x - y, |i| a[i] - b[i]);
            same(x * y, |i| a[i] * b[i]);
            same(x / y, |i| a[i] / b[i]);
            same(-x, |i| -a[i]);
            same(x.sqrt(), |i| a[i].sqrt());
            same(x.abs(), |i| a[i].abs());
            same(x.floor(), |i| a[i].floor());
            same(x.copysign(y), |i| a[i].copysign(b[i]));
            same(x.min(y), |i| math::min(a[i], b[i]));
            same(x.max(y), |i| math::max(a[i], b[i]));
            let c = numbers(&mut random);
            let either = Float::new(c);
            let mut memory = [7.0; LANES + 1];
            Float::load(&c).store(&mut memory);
            same(Float::load(&memory), |i| c[i]);
            assert_eq!(memory[LANES], 7.0, "wrote beyond the vector");
            same(Float::splat(a[0]), |_| a[0]);
            let from: Lanes<u32> = std::array::from_fn(|i| (i as u32 * 7 + 3) % LANES as u32);
            same(x.shuffled(Int::new(from)), |i| a[from[i] as usize]);
            same(x.lt(y).select(x, y), |i| if a[i] < b[i] { a[i] } else { b[i] });
            type Compare = fn(&f32, &f32) -> bool;
            let comparisons: [(Mask, Compare); 5] = [
                (x.lt(y), PartialOrd::lt),
                (x.le(y), PartialOrd::le),
                (x.gt(y), PartialOrd::gt),
                (x.ge(y), PartialOrd::ge),
                (x.eq(y), PartialEq::eq),
            ];
            for (mask, scalar) in comparisons {
                let bits = (0..LANES).map(|i| u32::from(scalar(&a[i], &b[i])) << i).sum();
                assert_eq!(mask.bits(), bits);
                assert_eq!(Mask::from_bits(bits).bits(), bits);
                assert_eq!((!mask).bits(), bits ^ first_bits(LANES));
                let other = x.lt(either);
                assert_eq!((mask & other).bits(), bits & other.bits());
                assert_eq!((mask | other).bits(), bits | other.bits());
                assert_eq!(mask.any(), bits != 0);
                assert_eq!(Bits(bits).map(|lane| 1 << lane).sum::<u32>(), bits);
            }
        }
    }

    /// For ordinary numbers, the result is either the nearly exact f64 result, rounded once to f32,
    /// or the f32 result, rounded twice.
    #[test]
    fn free_operations_round_once_or_twice() {
        let mut random = Stream::new(3);
        for _ in 0..20_000 {
            let [a, b, c] = [(); 3].map(|()| numbers(&mut random));
            let [x, y, z] = [a, b, c].map(Float::new);
            let wide = |i: usize, sign: f32| {
                (f64::from(a[i]) * f64::from(b[i]) + f64::from(sign * c[i])) as f32
            };
            let ordinary =
                |i: usize| [a[i], b[i], c[i]].iter().all(|x| (1e-3..4.0).contains(&x.abs()));
            for (sum, sign) in [(x.free_mul_add(y, z), 1.0), (x.free_mul_sub(y, z), -1.0)] {
                for (i, value) in
                    sum.to_array().into_iter().enumerate().filter(|&(i, _)| ordinary(i))
                {
                    let (one, two) = (wide(i, sign), a[i] * b[i] + sign * c[i]);
                    let near = (value - one).abs() <= one.abs() * f32::EPSILON;
                    assert!(near || value == two, "{value} {one} {two}");
                }
            }
        }
    }

    #[test]
    fn vectors_match_scalars() {
        let mut random = Stream::new(4);
        for _ in 0..20_000 {
            let [a, b, c] = [(); 3].map(|()| numbers(&mut random));
            let [x, y, z] = [a, b, c].map(Float::new);
            let (u, v) = (Vec3x([x, y, z]), Vec3x([y, z, x]));
            let at =
                |i: usize| (glam::Vec3::new(a[i], b[i], c[i]), glam::Vec3::new(b[i], c[i], a[i]));
            for axis in 0..3 {
                same((u + v)[axis], |i| (at(i).0 + at(i).1)[axis]);
                same((u - v)[axis], |i| (at(i).0 - at(i).1)[axis]);
                same((u * y)[axis], |i| (at(i).0 * b[i])[axis]);
                let splat = Vec3x::splat_lane(&[a, b, c], 1);
                same(splat[axis], |_| [a, b, c][axis][1]);
                same(Vec3x::of_lanes(&[a, b, c])[axis], |i| [a, b, c][axis][i]);
            }
            same(u.dot(v), |i| math::dot(at(i).0, at(i).1));
            let (turned, front) = math::face_forward(u, v);
            for axis in 0..3 {
                same((u * v)[axis], |i| (at(i).0 * at(i).1)[axis]);
                same((-u)[axis], |i| -at(i).0[axis]);
                same(math::cross(u, v)[axis], |i| math::cross(at(i).0, at(i).1)[axis]);
                same(math::reflect(u, v)[axis], |i| math::reflect(at(i).0, at(i).1)[axis]);
                same(math::normalize(u)[axis], |i| math::normalize(at(i).0)[axis]);
                same(turned[axis], |i| math::face_forward(at(i).0, at(i).1).0[axis]);
                same(<Vec3x as Vector>::splat(at(0).0)[axis], |_| at(0).0[axis]);
                same(front.select(u, v)[axis], |i| {
                    if front.bits() >> i & 1 == 1 { at(i).0[axis] } else { at(i).1[axis] }
                });
            }
            same(math::max_element(u), |i| math::max_element(at(i).0));
            let fronts: u32 =
                (0..LANES).map(|i| u32::from(math::face_forward(at(i).0, at(i).1).1) << i).sum();
            assert_eq!(front.bits(), fronts);
        }
    }

    #[test]
    fn reads_and_calls_match_scalars() {
        let mut random = Stream::new(5);
        for len in [1, 2, 7, 1000] {
            let words = |random: &mut Stream| random.bits() as u32;
            let table: Vec<math::Row> =
                (0..len).map(|_| [(); 4].map(|()| words(&mut random))).collect();
            let column: Vec<u32> = (0..len).map(|_| words(&mut random)).collect();
            let entries: Lanes<u32> = std::array::from_fn(|_| words(&mut random) % len as u32);
            let lanes = Int::new(entries);
            for index in [Float::index(lanes, len), Float::index_of_few(lanes, len)] {
                let (Vec3x([x, y, z]), number) = Float::gather(&table, index, |row| row);
                for (at, vector) in [x, y, z, number].into_iter().enumerate() {
                    let want = entries.map(|entry| table[entry as usize][at]);
                    assert_eq!(vector.to_bits().to_array(), want);
                }
                let picked = Float::pick(&column, index).to_array();
                assert_eq!(picked, entries.map(|entry| column[entry as usize]));
            }
            let double = Float::each_word(lanes, |word| 2 * word).to_array();
            assert_eq!(double, entries.map(|entry| 2 * entry));
            let number = numbers(&mut random);
            let f = |word: u32, [x]: [f32; 1]| [x * word as f32, x];
            let [product, same_number] = Float::each_lane(lanes, [Float::new(number)], f);
            same(product, |i| number[i] * entries[i] as f32);
            same(same_number, |i| number[i]);
        }
    }

    #[test]
    fn reductions_and_integers() {
        let mut random = Stream::new(2);
        for _ in 0..1000 {
            let a: Lanes = std::array::from_fn(|_| random.between(-1.0, 1.0));
            let least = a.into_iter().fold(f32::INFINITY, math::min);
            let most = a.into_iter().fold(f32::NEG_INFINITY, math::max);
            same(Float::new(a).least_lane(), |_| least);
            same(Float::new(a).largest_lane(), |_| most);
            let (p, q): (Lanes<u32>, Lanes<u32>) = (
                std::array::from_fn(|_| random.bits() as u32 % 3),
                std::array::from_fn(|_| random.bits() as u32 % 3),
            );
            let equal = Int::new(p).eq(Int::new(q));
            let x: Lanes<u32> = std::array::from_fn(|_| random.bits() as u32);
            let y: Lanes<u32> = std::array::from_fn(|_| random.bits() as u32);
            let (v, w, by) = (Int::new(x), Int::new(y), y[0] % 32);
            type Scalar<'a> = &'a dyn Fn(usize) -> u32;
            let operations: [(Int, Scalar); 12] = [
                (Word::reverse_bits(v), &|i| x[i].reverse_bits()),
                (v - w, &|i| x[i].wrapping_sub(y[i])),
                (v + w, &|i| x[i].wrapping_add(y[i])),
                (v * w, &|i| x[i].wrapping_mul(y[i])),
                (v & w, &|i| x[i] & y[i]),
                (v | w, &|i| x[i] | y[i]),
                (v ^ w, &|i| x[i] ^ y[i]),
                (v.max(w), &|i| x[i].max(y[i])),
                (v >> by, &|i| x[i] >> by),
                (v << by, &|i| x[i] << by),
                (Float::from_bits(v).to_bits(), &|i| x[i]),
                (Int::splat(x[1]), &|_| x[1]),
            ];
            for (vector, scalar) in operations {
                for (i, value) in vector.to_array().into_iter().enumerate() {
                    assert_eq!(value, scalar(i));
                }
            }
            same((v >> 1).to_float(), |i| (x[i] >> 1) as f32);
            let mut memory = [7; LANES + 1];
            Int::load(&x).store(&mut memory);
            assert_eq!((&memory[..LANES], memory[LANES]), (&x[..], 7), "wrote beyond the vector");
            let turned = v.shuffled(Int::new(y.map(|lane| lane % LANES as u32)));
            assert_eq!(turned.to_array(), y.map(|lane| x[lane as usize % LANES]));
            let chosen = equal.select(Int::splat(9), Int::new(q)).to_array();
            for i in 0..LANES {
                assert_eq!(v.le(w).bits() >> i & 1 == 1, x[i] <= y[i]);
                assert_eq!(Int::new(p).le(Int::new(q)).bits() >> i & 1 == 1, p[i] <= q[i]);
                assert_eq!(equal.bits() >> i & 1 == 1, p[i] == q[i]);
                assert_eq!(chosen[i], if p[i] == q[i] { 9 } else { q[i] });
            }
        }
        assert_eq!((first_bits(0), first_bits(3), first_bits(99)), (0, 7, u32::MAX));
    }
}
