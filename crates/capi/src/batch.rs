//! Samples of C.

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
