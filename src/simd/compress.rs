//! Lanes moved to the front.
#![allow(unsafe_code)]

use super::Float;

/// The lanes of `values` whose bits are set, in their order, first. What follows them is any
/// number.
#[inline(always)]
pub(crate) fn compress(values: Float, bits: u32) -> Float {
    // Measured: 8.7 ns a call with all about it, 13.3 ns lane by lane.
    // SAFETY: the CPU has the instruction, or this is not compiled; both types are 16 floats in
    // a register.
    #[cfg(target_feature = "avx512f")]
    return unsafe {
        use std::arch::x86_64::{__m512, _mm512_maskz_compress_ps};
        use std::mem::transmute;
        let values = transmute::<super::Register, __m512>(values.0);
        Float(transmute::<__m512, super::Register>(_mm512_maskz_compress_ps(bits as u16, values)))
    };
    #[cfg(not(target_feature = "avx512f"))]
    values.shuffled(super::Int::new(PACKED[bits as usize & 255].map(u32::from)))
}

/// Where the set bits of each mask are.
#[cfg(not(target_feature = "avx512f"))]
static PACKED: [[u8; 8]; 256] = {
    let (mut packed, mut bits) = ([[0; 8]; 256], 0);
    while bits < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                packed[bits][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    packed
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Bits, LANES, Lanes, first_bits};

    #[test]
    fn set_lanes_come_first() {
        let values: Lanes = std::array::from_fn(|lane| lane as f32 + 0.5);
        for bits in 0..=first_bits(LANES) {
            let packed = compress(Float::new(values), bits).to_array();
            let wanted: Vec<f32> = Bits(bits).map(|lane| values[lane]).collect();
            assert_eq!(packed[..wanted.len()], wanted);
        }
    }
}
