//! Prefetching.

/// Prefetches the cache lines of item `index` of a slice; `index` may be beyond its end. A hint: nothing is read.
#[inline(always)]
#[allow(unsafe_code)]
pub fn prefetch<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = items.as_ptr().wrapping_add(index).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(LINE) {
            // SAFETY: a prefetch accesses no memory in the sense of the language, and never faults, whatever the address;
            // SSE is part of every x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(address.wrapping_add(line * LINE)) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, index);
}

/// Size of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

#[cfg(test)]
mod tests {
    #[test]
    fn any_address_is_harmless() {
        for index in [0, 1, 1 << 20, usize::MAX / 8, usize::MAX] {
            super::prefetch(&[1.0], index);
            super::prefetch::<f32>(&[], index);
            super::prefetch(&[[0u64; 24]], index);
        }
    }
}
