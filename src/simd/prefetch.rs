//! Prefetching memory before it is needed.
#![allow(unsafe_code)]

/// Prefetches the cache lines of `value`. This is only a hint, which neither reads nor writes
/// memory.
///
/// Measured: it speeds up bounces of `mesh:1000000` from 3.25 to 3.63 Mrays/s (`profiling/`).
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(value).cast::<i8>();
        // SAFETY: the address lies within `value`; a prefetch does not access memory in the
        // sense of the language, and never faults.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(line)) };
    }
}
