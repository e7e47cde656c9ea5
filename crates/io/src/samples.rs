use trochoid_image::{Plane, Rgb};

/// Borrowed samples of one channel for writing: row by row, with a fixed step between neighbors.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    values: &'a [f32],
    step: usize,
}

impl<'a> Samples<'a> {
    /// Creates samples from contiguous values, row by row.
    pub fn contiguous(values: &'a [f32]) -> Self {
        Self { values, step: 1 }
    }

    /// Returns all samples of a plane.
    pub fn plane(plane: &'a Plane) -> Self {
        Self::contiguous(plane.samples())
    }

    /// Creates samples from every `step`-th value starting at `first`: one channel of interleaved pixels. A `step` of 0
    /// counts as 1.
    ///
    /// ```
    /// let pixels = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    /// let green = trochoid_io::Samples::interleaved(&pixels, 1, 3);
    /// assert_eq!(green.len(), 2);
    /// assert_eq!(green.get(1), Some(0.5));
    /// ```
    pub fn interleaved(values: &'a [f32], first: usize, step: usize) -> Self {
        Self { values: values.get(first..).unwrap_or(&[]), step: step.max(1) }
    }

    /// Returns the red, green and blue samples of RGB pixels.
    pub fn rgb(pixels: &'a [Rgb]) -> [Self; 3] {
        [0, 1, 2].map(|component| Self::interleaved(pixels.as_flattened(), component, 3))
    }

    /// Returns the number of samples.
    pub fn len(self) -> usize {
        self.values.len().div_ceil(self.step)
    }

    /// Returns whether there are no samples.
    pub fn is_empty(self) -> bool {
        self.values.is_empty()
    }

    /// Returns the sample at `index`, counted row by row.
    pub fn get(self, index: usize) -> Option<f32> {
        self.values.get(index.checked_mul(self.step)?).copied()
    }

    /// Returns the samples `start .. start + count`; fewer at the end of the data.
    pub(crate) fn range(self, start: usize, count: usize) -> impl Iterator<Item = f32> + 'a {
        let tail = self.values.get(start.saturating_mul(self.step)..).unwrap_or(&[]);
        tail.iter().step_by(self.step).take(count).copied()
    }

    /// Returns the same samples as a contiguous slice, gathered in `buffer` if necessary.
    pub(crate) fn row<'b>(self, start: usize, count: usize, buffer: &'b mut Vec<f32>) -> &'b [f32]
    where
        'a: 'b,
    {
        if self.step == 1 {
            let tail = self.values.get(start..).unwrap_or(&[]);
            return tail.get(..count).unwrap_or(tail);
        }
        buffer.clear();
        buffer.extend(self.range(start, count));
        buffer
    }
}
