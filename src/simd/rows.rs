//! Gathers rows of four words, one row for each lane, from anywhere in a table into columns, and
//! turns columns back into rows.
//!
//! With the vector instructions below, whole renders of spheres and cornell are 1.5 and 1.4 times
//! as fast as with plain arrays (measured with AVX-512).
#![allow(unsafe_code)]

use std::mem::transmute;

use super::{Float, LANES, Lanes, Vec3x};
use crate::math::{Real, Row};

/// Returns one row in all lanes, as a vector and a number.
#[inline(always)]
pub(crate) fn splat_row(row: &Row) -> (Vec3x, Float) {
    let [x, y, z, number] = row.map(|word| Float::splat(f32::from_bits(word)));
    (Vec3x([x, y, z]), number)
}

/// Reads the rows that `row` returns for `indices`, as vectors and numbers.
#[inline(always)]
pub(crate) fn gather_rows<'a>(
    indices: &Lanes<u32>,
    row: impl Fn(u32) -> &'a Row,
) -> (Vec3x, Float) {
    let mut registers = [register::joined([&[0; 4]; PARTS]); 4];
    for (column, register) in registers.iter_mut().enumerate() {
        // Four rows that are transposed together lie in the same part of the four registers.
        let mut rows = [&[0; 4]; PARTS];
        for (part, found) in rows.iter_mut().enumerate() {
            *found = row(indices[4 * part + column]);
        }
        *register = register::joined(rows);
    }
    let [x, y, z, number] = register::turned(registers).map(to_float);
    (Vec3x([x, y, z]), number)
}

/// Returns the row of each lane's vector and number.
#[inline(always)]
pub(crate) fn rows_of((Vec3x([x, y, z]), number): (Vec3x, Float)) -> [Row; LANES] {
    let registers = register::turned([x, y, z, number].map(of_float));
    let mut rows = [[0; 4]; LANES];
    for (column, register) in registers.into_iter().enumerate() {
        // SAFETY: both types consist of the same number of words.
        let parts = unsafe { transmute::<register::Register, [Row; PARTS]>(register) };
        for (part, row) in parts.into_iter().enumerate() {
            rows[4 * part + column] = row;
        }
    }
    rows
}

/// Number of rows in a register.
const PARTS: usize = LANES / 4;

#[inline(always)]
fn to_float(register: register::Register) -> Float {
    // SAFETY: both types hold one 32-bit word for each lane.
    Float(unsafe { transmute::<register::Register, super::Register>(register) })
}

#[inline(always)]
fn of_float(float: Float) -> register::Register {
    // SAFETY: both types hold one 32-bit word for each lane.
    unsafe { transmute::<super::Register, register::Register>(float.0) }
}

/// Registers of four rows. The same part of four registers forms a 4 × 4 matrix, and all four
/// matrices are transposed at once.
#[cfg(target_feature = "avx512f")]
mod register {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use crate::math::Row;

    pub(super) type Register = __m512i;

    #[inline(always)]
    pub(super) fn joined([a, b, c, d]: [&Row; 4]) -> Register {
        // SAFETY: this is compiled only for CPUs that have the instructions, and the transmuted
        // types consist of the same words.
        unsafe {
            let [a, b, c, d] = [*a, *b, *c, *d].map(|row| transmute::<Row, __m128i>(row));
            let ab = _mm512_inserti32x4::<1>(_mm512_castsi128_si512(a), b);
            _mm512_inserti32x4::<3>(_mm512_inserti32x4::<2>(ab, c), d)
        }
    }

    #[inline(always)]
    pub(super) fn turned([a, b, c, d]: [Register; 4]) -> [Register; 4] {
        // SAFETY: this is compiled only for CPUs that have the instructions.
        unsafe {
            let (ab, ab2) = (_mm512_unpacklo_epi32(a, b), _mm512_unpackhi_epi32(a, b));
            let (cd, cd2) = (_mm512_unpacklo_epi32(c, d), _mm512_unpackhi_epi32(c, d));
            [
                _mm512_unpacklo_epi64(ab, cd),
                _mm512_unpackhi_epi64(ab, cd),
                _mm512_unpacklo_epi64(ab2, cd2),
                _mm512_unpackhi_epi64(ab2, cd2),
            ]
        }
    }
}

/// Registers of two rows, with AVX.
#[cfg(all(target_feature = "avx", not(target_feature = "avx512f")))]
mod register {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use crate::math::Row;

    pub(super) type Register = __m256;

    #[inline(always)]
    pub(super) fn joined([a, b]: [&Row; 2]) -> Register {
        // SAFETY: this is compiled only for CPUs that have the instructions, and the transmuted
        // types consist of the same words.
        unsafe {
            let (a, b) = (transmute::<Row, __m128>(*a), transmute::<Row, __m128>(*b));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(a), b)
        }
    }

    #[inline(always)]
    pub(super) fn turned([a, b, c, d]: [Register; 4]) -> [Register; 4] {
        // SAFETY: this is compiled only for CPUs that have the instructions.
        unsafe {
            let pd = |words: Register| _mm256_castps_pd(words);
            let (ab, ab2) = (pd(_mm256_unpacklo_ps(a, b)), pd(_mm256_unpackhi_ps(a, b)));
            let (cd, cd2) = (pd(_mm256_unpacklo_ps(c, d)), pd(_mm256_unpackhi_ps(c, d)));
            [
                _mm256_castpd_ps(_mm256_unpacklo_pd(ab, cd)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(ab, cd)),
                _mm256_castpd_ps(_mm256_unpacklo_pd(ab2, cd2)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(ab2, cd2)),
            ]
        }
    }
}

/// Registers of two rows, as plain arrays of words.
#[cfg(not(target_feature = "avx"))]
mod register {
    use super::{LANES, Lanes};
    use crate::math::Row;

    pub(super) type Register = Lanes<u32>;

    #[inline(always)]
    pub(super) fn joined([a, b]: [&Row; 2]) -> Register {
        let ([a, b, c, d], [e, f, g, h]) = (*a, *b);
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    pub(super) fn turned(rows: [Register; 4]) -> [Register; 4] {
        let mut columns = [[0; LANES]; 4];
        for (column, lanes) in columns.iter_mut().enumerate() {
            for (lane, word) in lanes.iter_mut().enumerate() {
                *word = rows[lane % 4][lane / 4 * 4 + column];
            }
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn rows_become_columns_and_rows() {
        let mut random = Stream::new(5);
        let table: Vec<Row> =
            (0..50).map(|_| std::array::from_fn(|_| random.bits() as u32)).collect();
        for _ in 0..1000 {
            let indices: Lanes<u32> = std::array::from_fn(|_| (random.bits() % 50) as u32);
            let (Vec3x([x, y, z]), number) = gather_rows(&indices, |index| &table[index as usize]);
            for (column, values) in [x, y, z, number].into_iter().enumerate() {
                let want = indices.map(|index| table[index as usize][column]);
                assert_eq!(values.to_bits().to_array(), want);
            }
            let rows = rows_of((Vec3x([x, y, z]), number));
            assert_eq!(rows, indices.map(|index| table[index as usize]));
        }
    }
}
