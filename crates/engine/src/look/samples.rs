//! Batches in slices with strides.

use super::batch::Batch;
use super::error::ShadeError;
use super::points::Points;
use std::borrow::Cow;
use std::ops::Range;
use trochoid_kernel::Block;

/// Samples of one channel that a batch reads.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    samples: &'a [f32],
    stride: usize,
}

impl<'a> Samples<'a> {
    /// Returns samples that follow one another.
    pub fn new(samples: &'a [f32]) -> Self {
        Self { samples, stride: 1 }
    }

    /// Returns every `stride`-th sample, beginning with the first: the red of `&rgb` is at stride 3, the green of
    /// `&rgb[1..]`.
    pub fn strided(samples: &'a [f32], stride: usize) -> Self {
        Self { samples, stride }
    }

    /// Returns one value for all samples.
    pub fn uniform(value: &'a f32) -> Self {
        Self { samples: std::slice::from_ref(value), stride: 0 }
    }

    #[inline]
    fn read(&self, start: usize, to: &mut [f32]) {
        let Self { samples, stride } = *self;
        match stride {
            0 => to.fill(samples[0]),
            1 => to.copy_from_slice(&samples[start..start + to.len()]),
            _ => {
                let samples = &samples[start * stride..];
                to.iter_mut().zip(samples.iter().step_by(stride)).for_each(|(to, from)| *to = *from);
            }
        }
    }

    /// Whether the samples lie one after another.
    pub(super) fn is_plane(&self) -> bool {
        self.stride == 1
    }

    /// Returns the first `count` samples one after the other: in place if they are, or as a copy.
    pub(super) fn plane(&self, count: usize) -> Cow<'a, [f32]> {
        match self.stride {
            0 => vec![self.samples[0]; count].into(),
            1 => self.samples[..count].into(),
            stride => self.samples.iter().copied().step_by(stride).take(count).collect(),
        }
    }
}

impl<'a> From<&'a [f32]> for Samples<'a> {
    fn from(samples: &'a [f32]) -> Self {
        Self::new(samples)
    }
}

/// Samples of one channel that a batch writes.
#[derive(Debug)]
pub struct SamplesMut<'a> {
    samples: &'a mut [f32],
    stride: usize,
}

impl<'a> SamplesMut<'a> {
    /// Returns samples that follow one another.
    pub fn new(samples: &'a mut [f32]) -> Self {
        Self { samples, stride: 1 }
    }

    /// Returns every `stride`-th sample, beginning with the first. What lies between them is left alone.
    ///
    /// # Panics
    /// The stride is 0.
    pub fn strided(samples: &'a mut [f32], stride: usize) -> Self {
        assert!(stride > 0, "samples that are written have places of their own");
        Self { samples, stride }
    }
}

/// Slices with a stride.
pub(super) trait Strided {
    /// Returns the length of the slice and the stride.
    fn extent(&self) -> [usize; 2];

    /// Returns the number of samples.
    fn count(&self) -> usize {
        match self.extent() {
            [0, _] => 0,
            [_, 0] => usize::MAX,
            [length, stride] => length.div_ceil(stride),
        }
    }

    /// Whether there are at least `count` samples. Told without a division, which would take as long as five samples.
    fn holds(&self, count: usize) -> bool {
        let [length, stride] = self.extent();
        count == 0 || (count - 1).checked_mul(stride).is_some_and(|last| last < length)
    }
}

impl Strided for Samples<'_> {
    fn extent(&self) -> [usize; 2] {
        [self.samples.len(), self.stride]
    }
}

impl Strided for SamplesMut<'_> {
    fn extent(&self) -> [usize; 2] {
        [self.samples.len(), self.stride]
    }
}

/// Checks that there are as many channels as expected, and in those that are used as many samples.
pub(super) fn checked<S: Strided>(
    what: &'static str,
    channels: &[S],
    is_used: impl Fn(usize) -> bool,
    expected: usize,
    count: usize,
) -> Result<(), ShadeError> {
    if channels.len() != expected {
        return Err(ShadeError::Channels { what, found: channels.len(), expected });
    }
    for (channel, samples) in channels.iter().enumerate() {
        if !samples.holds(count) && is_used(channel) {
            return Err(ShadeError::Short { what, channel, found: samples.count(), expected: count });
        }
    }
    Ok(())
}

/// A batch in slices.
#[derive(Debug)]
pub(super) struct Slices<'b, 'i, 'o> {
    inputs: &'b [Samples<'i>],
    outputs: &'b mut [SamplesMut<'o>],
}

impl<'b, 'i, 'o> Slices<'b, 'i, 'o> {
    /// Checks that there are as many channels and samples as a batch needs. Channels of unused inputs may be empty.
    pub(super) fn new(
        inputs: &'b [Samples<'i>],
        is_used: impl Fn(usize) -> bool,
        outputs: &'b mut [SamplesMut<'o>],
        expected: [usize; 2],
        count: usize,
    ) -> Result<Self, ShadeError> {
        checked("inputs", inputs, is_used, expected[0], count)?;
        checked("outputs", outputs, |_| true, expected[1], count)?;
        Ok(Self { inputs, outputs })
    }
}

impl Slices<'_, '_, '_> {
    /// Whether the samples of each plane, and of each result in the program's order, follow one another, or are the same.
    pub(super) fn are_rows(&self, points: &Points) -> bool {
        let in_order = points.outputs.iter().enumerate().all(|(at, output)| at == *output);
        in_order
            && points.inputs.iter().all(|(input, _)| self.inputs[*input].stride <= 1)
            && self.outputs.iter().all(|output| output.stride == 1)
    }

    /// Returns the value of an input that is the same for all samples.
    pub(super) fn uniform(&self, input: usize) -> Option<f32> {
        let Samples { samples, stride } = self.inputs[input];
        (stride == 0).then(|| samples[0])
    }

    /// Returns some samples of each plane of the program, those of uniform inputs from blocks, and the places of the
    /// results.
    pub(super) fn rows<'s>(
        &'s mut self,
        points: &'s Points,
        range: Range<usize>,
        uniform: &'s [Block],
    ) -> (impl Iterator<Item = &'s [f32]>, impl Iterator<Item = &'s mut [f32]>) {
        let Self { inputs, outputs } = self;
        let of = range.clone();
        let inputs = points.inputs.iter().zip(uniform).map(move |((input, _), block)| {
            let Samples { samples, stride } = inputs[*input];
            if stride == 0 { &block.0[..of.len()] } else { &samples[of.clone()] }
        });
        (inputs, outputs.iter_mut().map(move |output| &mut output.samples[range.clone()]))
    }
}

impl Batch for Slices<'_, '_, '_> {
    #[inline]
    fn read(&mut self, channel: usize, start: usize, to: &mut [f32]) {
        self.inputs[channel].read(start, to);
    }

    #[inline]
    fn write(&mut self, channel: usize, start: usize, from: &[f32]) {
        let SamplesMut { samples, stride } = &mut self.outputs[channel];
        if *stride == 1 {
            samples[start..start + from.len()].copy_from_slice(from);
        } else {
            let samples = &mut samples[start * *stride..];
            samples.iter_mut().step_by(*stride).zip(from).for_each(|(to, from)| *to = *from);
        }
    }
}

/// A batch whose results are pixels: the channels of a sample side by side.
#[derive(Debug)]
pub(super) struct Pixels<'b, 'i> {
    inputs: &'b [Samples<'i>],
    pixels: &'b mut [f32],
    stride: usize,
}

impl<'b, 'i> Pixels<'b, 'i> {
    /// Checks that there are as many channels and samples as a batch needs, and that pixels do not overlap.
    pub(super) fn new(
        inputs: &'b [Samples<'i>],
        is_used: impl Fn(usize) -> bool,
        pixels: &'b mut [f32],
        stride: usize,
        [ins, outs]: [usize; 2],
        count: usize,
    ) -> Result<Self, ShadeError> {
        checked("inputs", inputs, is_used, ins, count)?;
        if stride < outs {
            return Err(ShadeError::Channels { what: "outputs", found: stride, expected: outs });
        }
        // The last pixel needs no padding.
        let found = (pixels.len() + stride - outs) / stride;
        if found < count {
            return Err(ShadeError::Short { what: "outputs", channel: 0, found, expected: count });
        }
        Ok(Self { inputs, pixels, stride })
    }
}

impl Batch for Pixels<'_, '_> {
    #[inline]
    fn read(&mut self, channel: usize, start: usize, to: &mut [f32]) {
        self.inputs[channel].read(start, to);
    }

    #[inline]
    fn write(&mut self, channel: usize, start: usize, from: &[f32]) {
        let pixels = &mut self.pixels[start * self.stride + channel..];
        pixels.iter_mut().step_by(self.stride).zip(from).for_each(|(to, from)| *to = *from);
    }
}
