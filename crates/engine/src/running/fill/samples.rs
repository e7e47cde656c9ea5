//! Samples of one channel, as a stage reads them.

use std::ops::Deref;
use trochoid_memory::Scratch;

/// Samples in the planes where they are, or copied from there.
pub(super) enum Samples<'a> {
    InPlace(&'a [f32]),
    Copied(Scratch<f32>),
}

impl Deref for Samples<'_> {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        match self {
            Self::InPlace(samples) => samples,
            Self::Copied(samples) => samples,
        }
    }
}

/// Samples by port, connection and channel; `None` where not requested.
pub(super) type PortSamples<'a> = Scratch<Scratch<Scratch<Option<Samples<'a>>>>>;
