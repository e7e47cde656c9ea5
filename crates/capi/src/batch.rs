//! Samples of C.

use trochoid::Look;
use trochoid_foreign::{Input, Output};

/// Where the samples of an input channel are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trochoid_in {
    /// The first sample. It need not be aligned.
    pub samples: *const f32,
    /// Distance from one sample to the next in bytes: 4 if they follow one another, the size of your
    /// structure if they are within one, 0 for one value for all samples. It may be negative.
    pub stride: isize,
}

/// Where the samples of an output channel go.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trochoid_out {
    /// The first sample. It need not be aligned.
    pub samples: *mut f32,
    /// Distance from one sample to the next in bytes, not 0.
    pub stride: isize,
}

impl From<trochoid_in> for Input {
    fn from(trochoid_in { samples, stride }: trochoid_in) -> Self {
        Self { samples, stride }
    }
}

impl From<trochoid_out> for Output {
    fn from(trochoid_out { samples, stride }: trochoid_out) -> Self {
        Self { samples, stride }
    }
}

/// Whether all channels that are read or written lead to samples, and no two results to one place.
pub(crate) fn are_there(look: &Look, inputs: &[Input], outputs: &[Output]) -> bool {
    let used = look.slots().iter().filter(|slot| slot.is_used);
    let mut read = used.flat_map(|slot| &inputs[slot.first..slot.first + slot.channels()]);
    read.all(|input| !input.samples.is_null())
        && outputs.iter().all(|output| !output.samples.is_null() && output.stride != 0)
}
