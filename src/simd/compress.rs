//! Lanes moved to the front.
#![allow(unsafe_code)]

use super::Int;

/// The places of the set bits, ascending; what follows them is the place of any lane.
///
/// [`Float::shuffled`](super::Float::shuffled) by them moves these lanes to the front.
#[inline(always)]
pub(crate) fn set_lanes(bits: u32) -> Int {
    // Every path is moved by it once a stage, to a queue or to those that go on.
    // SAFETY: the CPU has the instruction, or this is not compiled; both types are 16 u32 in a
    // register.
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

/// Where the set bits of each mask are.
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
