//! Sample buffers, aligned to cache lines.

use super::pages::{LARGE_PAGE, large_pages};
use std::ops::{Deref, DerefMut};

/// Samples in a cache line.
const LINE: usize = 16;
/// Difference between the offsets of consecutive buffers within a page, in lines: buffers of a picture start at
/// different offsets, so that their rows do not compete for the same cache sets.
const STAGGER: usize = 5;
/// Lines per small page; systems with larger ones are asked more often than necessary.
const PAGE_LINES: usize = 64;

/// Samples that start on a cache line, on large pages if the system has them.
///
/// Buffers are equal if their samples are.
#[derive(Debug, Default)]
pub struct Buffer {
    samples: Vec<f32>,
    /// Number of samples before the first aligned line.
    start: usize,
    length: usize,
}

impl Buffer {
    /// Makes a buffer of `length` zeros. `index` is the number of the buffer among those that are used together, such
    /// as the channels of a picture.
    ///
    /// # Errors
    /// The memory cannot be allocated.
    ///
    /// ```
    /// let buffer = trochoid_memory::Buffer::zeroed(1000, 1).unwrap();
    /// assert_eq!(buffer.len(), 1000);
    /// assert_eq!(buffer.as_ptr() as usize % 64, 0);
    /// ```
    pub fn zeroed(length: usize, index: usize) -> Result<Self, std::collections::TryReserveError> {
        let offset = (index * STAGGER) % PAGE_LINES * LINE;
        let mut samples: Vec<f32> = Vec::new();
        crate::fallible(|| samples.try_reserve_exact(length.saturating_add(offset + LINE)))?;
        advise(&samples);
        let start = samples.as_ptr().align_offset(4 * LINE).min(LINE) + offset;
        samples.resize(start + length, 0.0);
        Ok(Self { samples, start, length })
    }
}

impl From<Vec<f32>> for Buffer {
    /// Takes the samples without moving or aligning them.
    fn from(samples: Vec<f32>) -> Self {
        let length = samples.len();
        Self { samples, start: 0, length }
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        Self::from(self.to_vec())
    }
}

impl PartialEq for Buffer {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.samples[self.start..self.start + self.length]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.samples[self.start..self.start + self.length]
    }
}

/// Returns a vector of zeros, on large pages if the system has them. They are mapped already, so that the first writer does
/// not wait for them.
///
/// ```
/// assert_eq!(trochoid_memory::zeros(1000), vec![0.0; 1000]);
/// ```
pub fn zeros(length: usize) -> Vec<f32> {
    let mut samples = vec![0.0; length];
    advise(&samples);
    // Hidden from the compiler, which knows that these are zeros.
    let mapped = std::hint::black_box(&mut samples[..]);
    mapped.iter_mut().step_by(PAGE_LINES * LINE).for_each(|sample| *sample = 0.0);
    samples
}

/// Asks for large pages for the memory that a vector has reserved.
fn advise(samples: &Vec<f32>) {
    let bytes = samples.capacity() * size_of::<f32>();
    if bytes >= LARGE_PAGE {
        let from = samples.as_ptr() as usize;
        #[allow(unsafe_code)]
        // SAFETY: these bytes lie within one allocation of this process, which is mapped for as long as it is borrowed here.
        unsafe {
            large_pages(from, from + bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_buffer_begins_on_a_line_and_is_all_zeros() {
        for length in [0, 1, 15, 16, 17, 1000, 1 << 20] {
            for index in [0, 1, 7, 100] {
                let mut buffer = Buffer::zeroed(length, index).unwrap();
                assert_eq!((buffer.len(), buffer.as_ptr() as usize % 64), (length, 0));
                assert!(buffer.iter().all(|v| *v == 0.0));
                buffer.iter_mut().for_each(|v| *v = 1.0);
                assert_eq!(buffer, Buffer::from(vec![1.0; length]));
                assert_eq!(buffer.clone(), buffer);
            }
        }
    }

    #[test]
    fn neighbors_begin_at_different_places_of_a_page() {
        let places: Vec<usize> = (0..8).map(|i| Buffer::zeroed(1 << 20, i).unwrap().as_ptr() as usize % 4096).collect();
        let mut distinct = places.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), 8, "{places:?}");
    }

    #[test]
    fn too_much_memory_is_an_error() {
        assert!(Buffer::zeroed(usize::MAX / 2, 0).is_err());
        assert!(Buffer::zeroed(usize::MAX, 3).is_err());
    }
}
