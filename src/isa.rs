//! The instruction set that the program was compiled for, and the best one of the CPU.
//!
//! `wide` chooses its registers at compile time, so a build for one CPU can be slow on a better one
//! and cannot run on a lesser one. `is_x86_feature_detected!` does not help, because it is folded
//! to `true` for features that are compiled in. This module reads CPUID directly.

use std::fmt;

/// The instruction sets that ptfast distinguishes, from narrow to wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Isa {
    /// Not x86-64: the compiler chooses the instructions.
    Portable,
    /// x86-64 without AVX2 and FMA: 4 lanes per register.
    Sse2,
    /// AVX2 and FMA (x86-64-v3): 8 lanes.
    Avx2,
    /// AVX-512 F, BW, CD, DQ, VL (x86-64-v4): 16 lanes.
    Avx512,
}

impl Isa {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => std::env::consts::ARCH,
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The instruction set that this build uses.
///
/// A crate that depends on ptfast uses SSE2, unless it is itself built with `-C target-cpu=native`
/// or a similar flag. Check this value if that matters.
pub const fn compiled_isa() -> Isa {
    if cfg!(all(
        target_feature = "avx512f",
        target_feature = "avx512bw",
        target_feature = "avx512cd",
        target_feature = "avx512dq",
        target_feature = "avx512vl"
    )) {
        Isa::Avx512
    } else if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        Isa::Avx2
    } else if cfg!(target_arch = "x86_64") {
        Isa::Sse2
    } else {
        Isa::Portable
    }
}

/// The best instruction set that this CPU and operating system offer.
pub fn detected_isa() -> Isa {
    #[cfg(target_arch = "x86_64")]
    return x86::Cpu::read().isa();
    #[cfg(not(target_arch = "x86_64"))]
    Isa::Portable
}

/// A feature that this build uses and the CPU lacks, if any.
///
/// Must be called first in `main`: any later line may be an illegal instruction.
#[inline(never)]
pub fn missing_feature() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    return x86::Cpu::read().missing_feature();
    #[cfg(not(target_arch = "x86_64"))]
    None
}

/// The name that the CPU reports.
pub(crate) fn cpu_name() -> String {
    #[cfg(target_arch = "x86_64")]
    return x86::brand();
    #[cfg(not(target_arch = "x86_64"))]
    std::env::consts::ARCH.to_owned()
}

/// Family, model and stepping of the CPU, which distinguish CPUs that a hypervisor gives the same
/// name. Empty unless the CPU is x86-64.
pub(crate) fn cpu_model() -> String {
    #[cfg(target_arch = "x86_64")]
    return x86::model();
    #[cfg(not(target_arch = "x86_64"))]
    String::new()
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__cpuid, __cpuid_count};

    use super::Isa;

    /// The CPUID registers that list features (Intel SDM vol. 2A, CPUID).
    pub(super) struct Cpu {
        ecx1: u32,
        edx1: u32,
        ebx7: u32,
        ecx7: u32,
        edx7: u32,
        eax7_1: u32,
        ecx_ext: u32,
        /// The registers that the operating system saves when it switches threads.
        saved: Saved,
    }

    /// The register sets that the operating system has enabled, derived from the size of the area
    /// in which it saves them (SDM vol. 1, 13.4 and 13.5; AMD's APM vol. 2, 11.5). XGETBV would
    /// report them, but needs `unsafe`. If a system has disabled AVX-512 or AVX but enabled a
    /// component that is stored after it in that area (protection keys, AMX tiles), the size does
    /// not reveal this.
    #[derive(Clone, Copy, Default)]
    struct Saved {
        avx: bool,
        avx512: bool,
    }

    impl Saved {
        fn read() -> Self {
            let area = __cpuid_count(0xD, 0).ebx;
            let has = |component| {
                let part = __cpuid_count(0xD, component);
                is_within(area, part.eax, part.ebx)
            };
            Self { avx: has(2), avx512: has(7) }
        }
    }

    /// Whether a part of `size` bytes at `offset` lies within an area of `area` bytes. A CPU
    /// chooses the offsets, and reports 0 bytes for components that it lacks.
    pub(super) fn is_within(area: u32, size: u32, offset: u32) -> bool {
        size > 0 && offset.saturating_add(size) <= area
    }

    /// Whether a bit is set, tested with instructions that every CPU has. Without the black box,
    /// the compiler uses a BMI1 instruction in builds for Zen, and old CPUs lack BMI1.
    fn is_set(register: u32, bit: u32) -> bool {
        std::hint::black_box(register & (1 << bit)) != 0
    }

    /// `Some(name)` for the first feature that is compiled in and whose bit is 0.
    macro_rules! first_missing {
        ($($feature:tt: $register:expr, $bit:literal;)*) => {
            $(if cfg!(target_feature = $feature) && !is_set($register, $bit) {
                return Some($feature);
            })*
        };
    }

    impl Cpu {
        pub(super) fn read() -> Self {
            let highest = __cpuid(0).eax;
            let leaf1 = __cpuid(1);
            let leaf7 = (highest >= 7).then(|| __cpuid_count(7, 0));
            let leaf7_1 = leaf7.filter(|leaf| leaf.eax >= 1).map(|_| __cpuid_count(7, 1));
            let extended = (__cpuid(0x8000_0000).eax >= 0x8000_0001).then(|| __cpuid(0x8000_0001));
            // OSXSAVE: the operating system has enabled XSAVE.
            let xsave = highest >= 0xD && is_set(leaf1.ecx, 27);
            Self {
                ecx1: leaf1.ecx,
                edx1: leaf1.edx,
                ebx7: leaf7.map_or(0, |leaf| leaf.ebx),
                ecx7: leaf7.map_or(0, |leaf| leaf.ecx),
                edx7: leaf7.map_or(0, |leaf| leaf.edx),
                eax7_1: leaf7_1.map_or(0, |leaf| leaf.eax),
                ecx_ext: extended.map_or(0, |leaf| leaf.ecx),
                saved: if xsave { Saved::read() } else { Saved::default() },
            }
        }

        pub(super) fn isa(&self) -> Isa {
            let has = |register: u32, bits: &[u32]| bits.iter().all(|&bit| is_set(register, bit));
            if !self.saved.avx || !has(self.ebx7, &[5]) || !has(self.ecx1, &[12, 28]) {
                Isa::Sse2
            } else if !self.saved.avx512 || !has(self.ebx7, &[16, 17, 28, 30, 31]) {
                Isa::Avx2
            } else {
                Isa::Avx512
            }
        }

        pub(super) fn missing_feature(&self) -> Option<&'static str> {
            let Self { ecx1, edx1, ebx7, ecx7, edx7, eax7_1, ecx_ext, .. } = *self;
            first_missing! {
                "avx512f": ebx7, 16;
                "avx512dq": ebx7, 17;
                "avx512ifma": ebx7, 21;
                "avx512cd": ebx7, 28;
                "avx512bw": ebx7, 30;
                "avx512vl": ebx7, 31;
                "avx512vbmi": ecx7, 1;
                "avx512vbmi2": ecx7, 6;
                "avx512vnni": ecx7, 11;
                "avx512bitalg": ecx7, 12;
                "avx512vpopcntdq": ecx7, 14;
                "avx512fp16": edx7, 23;
                "avx512bf16": eax7_1, 5;
                "avxvnni": eax7_1, 4;
                "avx": ecx1, 28;
                "avx2": ebx7, 5;
                "fma": ecx1, 12;
                "f16c": ecx1, 29;
                "gfni": ecx7, 8;
                "vaes": ecx7, 9;
                "vpclmulqdq": ecx7, 10;
                "bmi1": ebx7, 3;
                "bmi2": ebx7, 8;
                "adx": ebx7, 19;
                "sha": ebx7, 29;
                "lzcnt": ecx_ext, 5;
                "sse3": ecx1, 0;
                "pclmulqdq": ecx1, 1;
                "ssse3": ecx1, 9;
                "cmpxchg16b": ecx1, 13;
                "sse4.1": ecx1, 19;
                "sse4.2": ecx1, 20;
                "sse4a": ecx_ext, 6;
                "tbm": ecx_ext, 21;
                "movbe": ecx1, 22;
                "popcnt": ecx1, 23;
                "aes": ecx1, 25;
                "sse2": edx1, 26;
            }
            if cfg!(target_feature = "avx512f") && !self.saved.avx512 {
                return Some("avx512f enabled by the operating system");
            }
            if cfg!(target_feature = "avx") && !self.saved.avx {
                return Some("avx enabled by the operating system");
            }
            None
        }
    }

    /// Decodes leaf 1 (SDM vol. 2A, CPUID, figure 3-6). Families from 15 on and the upper half of a
    /// model number are in separate bits.
    pub(super) fn model() -> String {
        let signature = __cpuid(1).eax;
        let bits = |first: u32, count: u32| signature >> first & ((1 << count) - 1);
        let family = bits(8, 4) + if bits(8, 4) == 15 { bits(20, 8) } else { 0 };
        let model = bits(4, 4) + if matches!(bits(8, 4), 6 | 15) { bits(16, 4) << 4 } else { 0 };
        format!("family {family} model {model} stepping {}", bits(0, 4))
    }

    pub(super) fn brand() -> String {
        if __cpuid(0x8000_0000).eax < 0x8000_0004 {
            return "unknown x86-64".to_owned();
        }
        let bytes: Vec<u8> = (0x8000_0002..=0x8000_0004)
            .map(__cpuid)
            .flat_map(|leaf| [leaf.eax, leaf.ebx, leaf.ecx, leaf.edx])
            .flat_map(u32::to_le_bytes)
            .take_while(|&byte| byte != 0)
            .collect();
        String::from_utf8_lossy(&bytes).trim().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_that_runs_lacks_no_feature() {
        assert_eq!(missing_feature(), None);
        assert!(detected_isa() >= compiled_isa(), "{} {}", detected_isa(), compiled_isa());
        assert!(!cpu_name().is_empty());
    }

    /// Uses the offsets of AVX-512 that Sapphire Rapids (which leaves the area of MPX free) and Zen
    /// 5 report.
    #[test]
    #[cfg(target_arch = "x86_64")]
    fn saved_registers_are_found_where_each_cpu_puts_them() {
        use x86::is_within;
        for (offset, with_avx512, with_more) in [(1664, 2688, 11_008), (1408, 2432, 2440)] {
            assert!(is_within(with_avx512, 1024, offset) && is_within(with_more, 1024, offset));
            assert!(!is_within(832, 1024, offset));
        }
        assert!(!is_within(2696, 0, 0) && !is_within(0, 256, 576));
    }

    /// std folds the detection of features that are compiled in to `true`, so only a build for SSE2
    /// tests every feature.
    #[test]
    #[cfg(target_arch = "x86_64")]
    fn detection_agrees_with_std() {
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512cd")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        assert_eq!(detected_isa() >= Isa::Avx2, avx2);
        assert_eq!(detected_isa() == Isa::Avx512, avx512);
    }
}
