//! The allocator's memory, of which each frame frees as much as the next one takes.
#![allow(unsafe_code)]

/// From now on, the allocator keeps what is freed. Otherwise it gives large blocks back to the system, which must clear
/// them again for the next frame. Only the allocator of glibc can be asked for that.
pub(crate) fn keep_what_is_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (parameter, value) in [
        (libc::M_MMAP_THRESHOLD, 1 << 30),
        (libc::M_TRIM_THRESHOLD, i32::MAX),
        (libc::M_TOP_PAD, 64 << 20),
    ] {
        // SAFETY: these parameters take any number, and calls may come at any time. A refusal changes nothing.
        unsafe { libc::mallopt(parameter, value) };
    }
}
