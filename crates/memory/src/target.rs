//! Targets: rows that are written through or around the cache.

use crate::Scratch;
use fearless_simd::{Simd, SimdBase, f32x16};

/// A row that is written but not read, around the cache if requested.
#[derive(Debug)]
pub struct Target<'a> {
    samples: &'a mut [f32],
    around: bool,
}

impl<'a> Target<'a> {
    /// Makes a target that is written through the cache.
    pub fn new(samples: &'a mut [f32]) -> Self {
        Self { samples, around: false }
    }

    /// Returns the number of samples.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether the target has no samples.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Returns the part of `length` samples from `start` on.
    ///
    /// # Panics
    /// The part extends beyond the end.
    #[inline(always)]
    pub fn part(&mut self, start: usize, length: usize) -> Target<'_> {
        Target { samples: &mut self.samples[start..start + length], around: self.around }
    }

    /// Writes 16 samples at `index`.
    ///
    /// # Panics
    /// The samples do not fit.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, index: usize, value: f32x16<S>) {
        let Some(to) = self.samples[index..].first_chunk_mut::<16>() else { panic!("16 samples at {index}") };
        value.store_slice(to);
    }

    /// Returns the address of some of the samples, for machine code that writes them. It may write around the cache
    /// only if [`Target::is_lines`].
    ///
    /// # Panics
    /// The samples do not fit.
    pub fn pointer(&mut self, start: usize, length: usize) -> *mut f32 {
        self.samples[start..start + length].as_mut_ptr()
    }

    /// Whether some of the samples are to be written around the cache and consist of whole cache lines.
    ///
    /// # Panics
    /// The samples do not fit.
    pub fn is_lines(&self, start: usize, length: usize) -> bool {
        let samples = &self.samples[start..start + length];
        self.around && length.is_multiple_of(16) && samples.as_ptr().addr().is_multiple_of(64)
    }

    /// Returns the target as cache lines if it is to be written around the cache and consists of whole lines.
    #[inline(always)]
    pub fn lines(&mut self) -> Option<Lines<'_>> {
        let whole = self.is_lines(0, self.len());
        whole.then_some(Lines(self.samples.as_chunks_mut::<16>().0))
    }

    /// Writes samples at `index`.
    ///
    /// # Panics
    /// The samples do not fit.
    pub fn copy(&mut self, index: usize, values: &[f32]) {
        self.samples[index..index + values.len()].copy_from_slice(values);
    }
}

/// Lends slices as targets that are written around the cache: for results larger than the cache, which would only
/// evict data that is still needed.
///
/// During `write` no code can read the slices; afterwards any thread can read all of them.
///
/// ```
/// let mut row = vec![0.0; 64];
/// trochoid_memory::write_around(&mut [&mut row[..]], |targets| targets[0].copy(3, &[1.0, 2.0]));
/// assert_eq!(row[3..5], [1.0, 2.0]);
/// ```
///
/// A target cannot outlive the call, so nothing is read before the stores are ordered:
///
/// ```compile_fail
/// let mut row = vec![0.0; 64];
/// let mut kept = None;
/// trochoid_memory::write_around(&mut [&mut row[..]], |targets| kept = targets.iter_mut().next());
/// ```
pub fn write_around<R>(slices: &mut [&mut [f32]], write: impl for<'t> FnOnce(&mut [Target<'t>]) -> R) -> R {
    // Dropped even if `write` panics.
    let _fence = Fence;
    let mut targets: Scratch<Target<'_>> = slices.iter_mut().map(|samples| Target { samples, around: true }).collect();
    write(&mut targets)
}

/// Orders all streaming stores of this thread before later accesses, when dropped.
struct Fence;

impl Drop for Fence {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: SSE is part of every x86-64; the fence has no other effect.
        unsafe {
            core::arch::x86_64::_mm_sfence();
        }
    }
}

/// Cache lines that are written around the cache, within a call of [`write_around`]. Only targets make them.
#[derive(Debug)]
pub struct Lines<'a>(&'a mut [[f32; 16]]);

impl Lines<'_> {
    /// Writes line `index`.
    ///
    /// # Panics
    /// The line does not exist.
    #[inline(always)]
    pub fn store<S: Stream>(&mut self, index: usize, value: f32x16<S>) {
        S::stream(value, Line(&mut self.0[index]));
    }
}

/// 16 samples that start on a cache line. Only [`Lines`] make them.
#[derive(Debug)]
pub struct Line<'a>(&'a mut [f32; 16]);

/// Store around the cache of an instruction set.
pub trait Stream: Simd {
    /// Whether the instruction set has a fused multiply–add, without which mixing is slow in any form.
    const FUSED: bool = false;

    /// Writes a whole line; through the cache if the instruction set has no such store.
    #[inline(always)]
    fn stream(value: f32x16<Self>, line: Line<'_>) {
        value.store_slice(line.0);
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Stream for fearless_simd::Fallback {}

#[cfg(target_arch = "aarch64")]
impl Stream for fearless_simd::aarch64::Neon {
    const FUSED: bool = true;
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Line, Stream};
    use core::arch::x86_64::{__m256, __m512, _mm256_stream_ps, _mm512_stream_ps};
    use fearless_simd::x86::{Avx2, Avx512, Sse2};
    use fearless_simd::{Simd, f32x16};

    impl Stream for Sse2 {}

    impl Stream for Avx2 {
        const FUSED: bool = true;

        #[inline(always)]
        #[allow(unsafe_code)]
        fn stream(value: f32x16<Self>, line: Line<'_>) {
            let (low, high) = value.simd.split_f32x16(value);
            let (low, high): (__m256, __m256) = (low.into(), high.into());
            let to = line.0.as_mut_ptr();
            // SAFETY: the value holds the proof of AVX2; a line is 16 samples, aligned to 64 bytes, borrowed for
            // writing; `write_around` fences before any code can read them.
            unsafe {
                _mm256_stream_ps(to, low);
                _mm256_stream_ps(to.add(8), high);
            }
        }
    }

    impl Stream for Avx512 {
        const FUSED: bool = true;

        #[inline(always)]
        #[allow(unsafe_code)]
        fn stream(value: f32x16<Self>, line: Line<'_>) {
            let value: __m512 = value.into();
            // SAFETY: the value holds the proof of AVX-512; a line is 16 samples, aligned to 64 bytes, borrowed for
            // writing; `write_around` fences before any code can read them.
            unsafe { _mm512_stream_ps(line.0.as_mut_ptr(), value) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instructions, Kernel, dispatch};

    /// Stores the line's number in every line.
    struct Number<'t, 'a>(&'t mut Target<'a>, f32);

    impl Kernel for Number<'_, '_> {
        type Output = ();

        #[inline(always)]
        fn run<S: Stream>(self, simd: S) {
            let value = |i: usize| f32x16::from_slice(simd, &[i as f32 + self.1; 16]);
            let count = self.0.len() / 16;
            match self.0.lines() {
                Some(mut lines) => (0..count).for_each(|i| lines.store(i, value(i))),
                None => (0..count).for_each(|i| self.0.store(16 * i, value(i))),
            }
        }
    }

    /// Writes exactly the intended samples, at every alignment and with every instruction set.
    #[test]
    fn stores_land_where_they_should_at_any_alignment() {
        for instructions in [Instructions::Best, Instructions::Avx2, Instructions::Baseline] {
            for start in 0..33 {
                let mut memory = vec![-1.0f32; 128];
                write_around(&mut [&mut memory[start..start + 48]], |targets| {
                    dispatch(instructions.level(), Number(&mut targets[0], 0.0));
                });
                for (i, v) in memory.iter().enumerate() {
                    let inside = i.wrapping_sub(start);
                    assert_eq!(*v, if inside < 48 { (inside / 16) as f32 } else { -1.0 }, "{start} {i}");
                }
            }
        }
    }

    #[test]
    fn only_whole_lines_are_written_around_the_cache() {
        let mut buffer = crate::Buffer::zeroed(100, 0).unwrap();
        assert!(Target::new(&mut buffer[..64]).lines().is_none(), "nobody asked for it");
        for (range, whole) in [(0..64, true), (16..32, true), (0..60, false), (1..65, false), (8..24, false)] {
            write_around(&mut [&mut buffer[range.clone()]], |targets| {
                assert_eq!(targets[0].lines().is_some(), whole, "{range:?}");
            });
        }
    }

    #[test]
    #[should_panic(expected = "16 samples")]
    fn stores_beyond_the_end_are_refused() {
        struct Beyond<'t, 'a>(&'t mut Target<'a>);
        impl Kernel for Beyond<'_, '_> {
            type Output = ();
            fn run<S: Stream>(self, simd: S) {
                self.0.store(5, f32x16::from_slice(simd, &[0.0; 16]));
            }
        }
        let mut memory = vec![0.0f32; 20];
        dispatch(Instructions::Best.level(), Beyond(&mut Target::new(&mut memory)));
    }

    #[test]
    fn another_thread_reads_what_was_written_around_the_cache() {
        let mut memory = crate::Buffer::zeroed(1 << 16, 0).unwrap();
        for round in 1..20 {
            let value = round as f32;
            std::thread::scope(|scope| {
                let writer = scope.spawn(|| {
                    write_around(&mut [&mut memory[..]], |targets| {
                        dispatch(Instructions::Best.level(), Number(&mut targets[0], value));
                    });
                });
                writer.join().unwrap();
            });
            assert!(memory.iter().enumerate().all(|(i, v)| *v == (i / 16) as f32 + value));
        }
    }
}
