//! Recipes: conversions of stored samples to the channels of an output, one piece of a row at a time.

use super::color::Conversion;
use super::reading::{SumNormalizer, parts};
use std::sync::{Mutex, PoisonError};
use trochoid_graph::NodeError;

/// Conversion from legal stored samples to the values of an output.
pub(crate) trait Recipe: Send + Sync {
    /// Converts the pixels from `at` on in place: one line for each stored channel before, one for each channel of the
    /// output afterward. Returns the number of repaired values.
    ///
    /// # Errors
    /// Values are inconsistent with each other.
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError>;

    /// Returns what `apply` rounds to f32, for recipes of which the references take that: one line for each channel of
    /// the output, from one for each stored channel. The references of other recipes take what `apply` gives.
    fn exact(&self) -> Option<ExactLines<'_>> {
        None
    }
}

/// Function from lines of legal stored samples, and the position of their first pixel, to lines of an output.
pub(crate) type ExactLines<'a> = Box<dyn Fn([i64; 2], &[&[f32]]) -> Vec<Vec<f64>> + 'a>;

/// Divides weights by their sum; two weights make a mask, which is the second.
pub(crate) struct Normalized(pub(crate) SumNormalizer);

impl Recipe for Normalized {
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let repaired = self.0.normalize(at, lines)?;
        if let [first, second] = lines {
            // A mask is written as the weight of its second control.
            first.copy_from_slice(second);
        }
        Ok(repaired)
    }

    fn exact(&self) -> Option<ExactLines<'_>> {
        Some(Box::new(|_, lines| parts(lines)))
    }
}

/// Converts to colors of the working space; a single stored channel gives gray.
pub(crate) struct Colors {
    pub(crate) gray: bool,
    /// Conversions not in use by any thread; the first one is never taken.
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
