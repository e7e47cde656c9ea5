//! What makes the channels of an output of stored samples, a piece of a row at a time.

use super::color::Conversion;
use super::reading::Sums;
use std::sync::{Mutex, PoisonError};
use trochoid_graph::NodeError;

/// From legal stored samples to the values of an output.
pub(crate) trait Recipe: Send + Sync {
    /// Converts the pixels from `at` on in place: first a line for each stored channel, afterward one for each of the
    /// output. Returns how many values were repaired.
    ///
    /// # Errors
    /// Values that mean nothing together.
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError>;
}

/// Weights divided by their sum.
pub(crate) struct Normalized(pub(crate) Sums);

impl Recipe for Normalized {
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let repaired = self.0.normalize(at, lines)?;
        if let [first, second] = lines {
            // A mask is written as the weight of its second control.
            first.copy_from_slice(second);
        }
        Ok(repaired)
    }
}

/// Colors of the working space; of one stored channel a gray.
pub(crate) struct Colors {
    pub(crate) gray: bool,
    /// Conversions that no thread uses at the moment; never without the first.
    conversions: Mutex<Vec<Conversion>>,
}

impl Colors {
    pub(crate) fn new(gray: bool, conversion: Conversion) -> Self {
        Self { gray, conversions: Mutex::new(vec![conversion]) }
    }
}

impl Recipe for Colors {
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let [r, g, b] = lines else { unreachable!("colors have three channels") };
        if self.gray {
            g.copy_from_slice(r);
            b.copy_from_slice(r);
        }
        let taken = {
            let mut conversions = self.conversions.lock().unwrap_or_else(PoisonError::into_inner);
            match &conversions[..] {
                [only] => only.clone(),
                _ => conversions.swap_remove(1),
            }
        };
        let mut conversion = taken;
        let result = conversion.row(at, [r, g, b]);
        self.conversions.lock().unwrap_or_else(PoisonError::into_inner).push(conversion);
        result
    }
}
