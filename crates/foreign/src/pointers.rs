//! Samples wherever another language keeps them.

use trochoid::Batch;

/// Where the samples of an input channel are.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// The first sample; it need not be aligned.
    pub samples: *const f32,
    /// Distance from one sample to the next, in bytes; 0 for one value for all.
    pub stride: isize,
}

/// Where the samples of an output channel go.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// The first sample; it need not be aligned.
    pub samples: *mut f32,
    /// Distance from one sample to the next, in bytes.
    pub stride: isize,
}

/// Stride of samples that follow one another.
pub(crate) const PACKED: isize = size_of::<f32>() as isize;

/// A batch of pointers. Results may lie where inputs are, sample by sample, since no references are made.
pub(crate) struct Pointers<'b> {
    inputs: &'b [Input],
    outputs: &'b [Output],
}

impl<'b> Pointers<'b> {
    /// # Safety
    /// Each input that the look uses leads to as many samples as the batch has, at its stride, and each output to as many
    /// places. Nothing else writes to them meanwhile.
    #[allow(unsafe_code)]
    pub(crate) unsafe fn new(inputs: &'b [Input], outputs: &'b [Output]) -> Self {
        Self { inputs, outputs }
    }
}

#[allow(unsafe_code)]
impl Batch for Pointers<'_> {
    fn read(&mut self, channel: usize, start: usize, to: &mut [f32]) {
        let Input { samples, stride } = self.inputs[channel];
        let at = |index: usize| samples.wrapping_byte_offset(stride.wrapping_mul((start + index) as isize));
        if stride == 0 {
            // SAFETY: there is one sample, by the promise of `new`.
            to.fill(unsafe { samples.read_unaligned() });
        } else if stride == PACKED {
            // SAFETY: as many samples follow one another, by the promise of `new`; `to` is the library's own memory.
            unsafe { std::ptr::copy_nonoverlapping(at(0).cast::<u8>(), to.as_mut_ptr().cast(), size_of_val(to)) };
        } else {
            for (index, sample) in to.iter_mut().enumerate() {
                // SAFETY: a sample of the batch, by the promise of `new`.
                *sample = unsafe { at(index).read_unaligned() };
            }
        }
    }

    fn write(&mut self, channel: usize, start: usize, from: &[f32]) {
        let Output { samples, stride } = self.outputs[channel];
        let at = |index: usize| samples.wrapping_byte_offset(stride.wrapping_mul((start + index) as isize));
        if stride == PACKED {
            // SAFETY: as many places follow one another, by the promise of `new`; `from` is the library's own memory.
            unsafe { std::ptr::copy_nonoverlapping(from.as_ptr().cast::<u8>(), at(0).cast(), size_of_val(from)) };
        } else {
            for (index, sample) in from.iter().enumerate() {
                // SAFETY: a place of the batch, by the promise of `new`.
                unsafe { at(index).write_unaligned(*sample) };
            }
        }
    }
}

impl Input {
    /// Copies `count` samples.
    ///
    /// # Safety
    /// There are as many.
    #[allow(unsafe_code)]
    pub unsafe fn copied(self, count: usize) -> Vec<f32> {
        let mut samples = vec![0.0; count];
        if count > 0 {
            let all = [self];
            // SAFETY: one channel, which is read as far as the caller says.
            unsafe { Pointers::new(&all, &[]) }.read(0, 0, &mut samples);
        }
        samples
    }
}

impl Output {
    /// Writes samples.
    ///
    /// # Safety
    /// There are as many places, and nothing else writes to them meanwhile.
    #[allow(unsafe_code)]
    pub unsafe fn take(self, samples: &[f32]) {
        let all = [self];
        // SAFETY: one channel, which is written as far as the caller says.
        unsafe { Pointers::new(&[], &all) }.write(0, 0, samples);
    }
}
