//! A shader over pointers.

use crate::pointers::{Input, Output, PACKED, Pointers};
use trochoid::{Look, Samples, SamplesMut, ShadeError, Shader, emptied};

/// Number of samples from which looking for overlaps takes less time than copying.
const FEW: usize = 128;

/// What one thread needs to shade samples in memory of another language.
#[derive(Debug)]
pub struct ForeignShader {
    shader: Shader,
    /// Memory of lists.
    inputs: Vec<Samples<'static>>,
    outputs: Vec<SamplesMut<'static>>,
}

impl ForeignShader {
    /// Makes it of a shader.
    pub fn new(shader: Shader) -> Self {
        let (inputs, outputs) = (shader.look().inputs(), shader.look().channels());
        Self { shader, inputs: Vec::with_capacity(inputs), outputs: Vec::with_capacity(outputs) }
    }

    /// Returns the look.
    pub fn look(&self) -> &Look {
        self.shader.look()
    }

    /// Shades `count` samples: one input for each channel of each slot, one output for each channel of the look's output.
    /// Allocates nothing after the first batch. Results may lie where inputs are, sample by sample.
    ///
    /// # Errors
    /// Channels are missing, or a sample is illegal.
    ///
    /// # Safety
    /// Each input that the look uses leads to as many samples, at its stride, and each output to as many places. Nothing
    /// else writes to them meanwhile.
    #[allow(unsafe_code)]
    pub unsafe fn shade(&mut self, count: usize, inputs: &[Input], outputs: &[Output]) -> Result<(), ShadeError> {
        let look = self.look();
        for (what, found, expected) in
            [("inputs", inputs.len(), look.inputs()), ("outputs", outputs.len(), look.channels())]
        {
            if found != expected {
                return Err(ShadeError::Channels { what, found, expected });
            }
        }
        // SAFETY: the caller's promise.
        unsafe {
            match self.slices(count, inputs, outputs) {
                Some(done) => done,
                None => self.shader.run(count, &mut Pointers::new(inputs, outputs)),
            }
        }
    }

    /// Shades samples where they are, if there are many, each channel's follow one another, and nothing overlaps what is
    /// written; `None` if that is not so.
    ///
    /// # Safety
    /// As for [`shade`](Self::shade), with as many channels as the look has.
    #[allow(unsafe_code)]
    unsafe fn slices(&mut self, count: usize, inputs: &[Input], outputs: &[Output]) -> Option<Result<(), ShadeError>> {
        // Few are copied sooner than it is seen whether they overlap.
        if count < FEW || !outputs.iter().all(|out| out.stride == PACKED && is_row(out.samples)) {
            return None;
        }
        let written = || outputs.iter().map(|out| bytes(out.samples, count));
        if written().enumerate().any(|(at, a)| written().skip(at + 1).any(|b| overlap(a, b))) {
            return None;
        }
        let is_used = |channel: usize| {
            let slots = self.shader.look().slots();
            slots.iter().any(|slot| slot.is_used && slot.has(channel))
        };
        let fits = |(channel, input): (usize, &Input)| {
            let length = if input.stride == 0 { 1 } else { count };
            let is_plain = matches!(input.stride, 0 | PACKED) && is_row(input.samples);
            !is_used(channel) || is_plain && !written().any(|out| overlap(bytes(input.samples, length), out))
        };
        if !inputs.iter().enumerate().all(fits) {
            return None;
        }
        let mut rows: Vec<Samples<'_>> = emptied(std::mem::take(&mut self.inputs));
        rows.extend(inputs.iter().enumerate().map(|(channel, input)| {
            if !is_used(channel) {
                return Samples::new(&[]);
            }
            let length = if input.stride == 0 { 1 } else { count };
            // SAFETY: as many samples, aligned, by the caller's promise; nothing is written among them, as was just found,
            // and they stay until the call ends.
            let row: &[f32] = unsafe { std::slice::from_raw_parts(input.samples, length) };
            if input.stride == 0 { Samples::uniform(&row[0]) } else { Samples::new(row) }
        }));
        let mut targets: Vec<SamplesMut<'_>> = emptied(std::mem::take(&mut self.outputs));
        targets.extend(outputs.iter().map(|out| {
            // SAFETY: as many places, aligned, by the caller's promise; they overlap nothing else, as was just found.
            SamplesMut::new(unsafe { std::slice::from_raw_parts_mut(out.samples, count) })
        }));
        let done = self.shader.shade(count, &rows, &mut targets);
        (self.inputs, self.outputs) = (emptied(rows), emptied(targets));
        Some(done)
    }
}

fn is_row(start: *const f32) -> bool {
    start.is_aligned() && !start.is_null()
}

/// Returns the addresses of `count` samples: the first, and the one behind the last.
fn bytes(start: *const f32, count: usize) -> (usize, usize) {
    (start.addr(), start.addr().saturating_add(count.saturating_mul(size_of::<f32>())))
}

fn overlap(a: (usize, usize), b: (usize, usize)) -> bool {
    a.0 < b.1 && b.0 < a.1
}
