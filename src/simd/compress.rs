//! Compression: moving selected lanes to the front of a vector.
#![allow(unsafe_code)]

use super::Int;

/// Returns the positions of the set bits in ascending order, followed by arbitrary valid positions.
///
/// With these positions, [`Float::shuffled`](super::Float::shuffled) moves the selected lanes to
/// the front.
#[inline(always)]
pub(crate) fn set_lanes(bits: u32) -> Int {
    // This function is used often: in each segment, it moves all paths into queues, and the
    // survivors to the paths that continue.
    // SAFETY: this is compiled only for CPUs that have the instruction, and both types are
    // registers of 16 u32.
    #[cfg(target_feature = "avx512f")]
    return unsafe {
        use std::arch::x86_64::{__m512i, _mm512_maskz_compress_epi32};
        use std::mem::transmute;
        let lanes = transmute::<super::UintRegister, __m512i>(Int::LANE.0);
        let set_lanes = _mm512_maskz_compress_epi32(bits as u16, lanes);
        Int(transmute::<__m512i, super::UintRegister>(set_lanes))
    };
    #[cfg(not(target_feature = "avx512f"))]
    Int::new(PLACES[bits as usize & 255].map(u32::from))
}

/// For each mask of 8 bits, the positions of its set bits in ascending order.
#[cfg(not(target_feature = "avx512f"))]
static PLACES: [[u8; 8]; 256] = {
    let (mut set_lanes, mut bits) = ([[0; 8]; 256], 0);
    while bits < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                set_lanes[bits][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    set_lanes
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Bits, Float, LANES, Lanes, first_bits};

    #[test]
    fn set_lanes_come_first() {
        let values: Lanes = std::array::from_fn(|lane| lane as f32 + 0.5);
        for bits in 0..=first_bits(LANES) {
            let packed = Float::new(values).shuffled(set_lanes(bits)).to_array();
            let wanted: Vec<f32> = Bits(bits).map(|lane| values[lane]).collect();
            assert_eq!(packed[..wanted.len()], wanted);
        }
    }
}
