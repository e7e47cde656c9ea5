//! Selection of the instruction set at run time.

use crate::Stream;
use fearless_simd::Level;

/// Code that is compiled for each instruction set and runs on the one of the processor.
pub trait Kernel {
    /// Result of the kernel.
    type Output;

    /// Runs with the instructions that `simd` proves to be available. Mark implementations `#[inline(always)]`.
    fn run<S: Stream>(self, simd: S) -> Self::Output;
}

/// Instruction sets that may be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instructions {
    /// The best one of the processor.
    #[default]
    Best,
    /// At most AVX2, even if the processor has AVX-512.
    Avx2,
    /// Only the instructions that every processor of the architecture has.
    Baseline,
}

impl Instructions {
    /// Returns the instruction set to use on this processor.
    pub fn level(self) -> Level {
        let best = Level::new();
        match self {
            Self::Best => best,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => best.as_avx2().map_or(best, Level::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Baseline => best.as_sse2().map_or(best, Level::Sse2),
            #[cfg(not(target_arch = "x86_64"))]
            _ => best,
        }
    }
}

/// Runs a kernel compiled for an instruction set.
#[inline]
pub fn dispatch<K: Kernel>(level: Level, kernel: K) -> K::Output {
    macro_rules! with {
        ($simd:expr) => {{
            let simd = $simd;
            fearless_simd::Simd::vectorize(
                simd,
                #[inline(always)]
                || kernel.run(simd),
            )
        }};
    }
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(simd) => with!(simd),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(simd) => with!(simd),
        // Without fused multiply–add, nothing beyond SSE2 makes kernels faster.
        #[cfg(target_arch = "x86_64")]
        Level::Sse4_2(simd) => match fearless_simd::Simd::level(simd).as_sse2() {
            Some(simd) => with!(simd),
            None => unreachable!("SSE4.2 holds SSE2"),
        },
        #[cfg(target_arch = "x86_64")]
        Level::Sse2(simd) => with!(simd),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(simd) => with!(simd),
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        Level::Fallback(simd) => with!(simd),
        _ => unreachable!("every level of this architecture is named"),
    }
}
