//! Planes: single channels of images.

use crate::Window;
use trochoid_memory::Buffer;

/// One channel of an image: a rectangle of f32 samples, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    window: Window,
    samples: Buffer,
}

/// Error: the samples of a plane do not fill its window.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a plane over {window} needs {} samples, found {found}: pass width × height of them", window.area())]
pub struct PlaneError {
    window: Window,
    found: usize,
}

impl Plane {
    /// Wraps samples that fill the window row by row.
    ///
    /// # Errors
    /// The number of samples is not the window's area.
    pub fn new(window: Window, samples: Vec<f32>) -> Result<Self, PlaneError> {
        if samples.len() == window.area() {
            Ok(Self { window, samples: samples.into() })
        } else {
            Err(PlaneError { window, found: samples.len() })
        }
    }

    /// Makes a plane with one value everywhere.
    pub fn filled(window: Window, value: f32) -> Self {
        Self { window, samples: vec![value; window.area()].into() }
    }

    /// Makes a large plane of zeros, aligned to cache lines, on large pages if the system has them. `index` is the
    /// number of the plane among those that are used together.
    ///
    /// # Errors
    /// The memory cannot be allocated.
    pub fn zeroed(window: Window, index: usize) -> Result<Self, std::collections::TryReserveError> {
        Ok(Self { window, samples: Buffer::zeroed(window.area(), index)? })
    }

    /// Returns the window that the samples fill.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Returns all samples, row by row.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// Returns all samples, for writing.
    pub fn samples_mut(&mut self) -> &mut [f32] {
        &mut self.samples
    }

    /// Returns the samples of row `y`, or `None` outside of the window.
    pub fn row(&self, y: i64) -> Option<&[f32]> {
        if y < self.window.y0 || y >= self.window.y1 {
            return None;
        }
        let width = self.window.width();
        let start = (y - self.window.y0) as usize * width;
        self.samples.get(start..start + width)
    }

    /// Returns the sample at (x, y), or the nearest one outside of the window; 0 if the plane is empty.
    pub fn nearest(&self, x: i64, y: i64) -> f32 {
        if self.window.is_empty() {
            return 0.0;
        }
        let column = (x.clamp(self.window.x0, self.window.x1 - 1) - self.window.x0) as usize;
        let row = (y.clamp(self.window.y0, self.window.y1 - 1) - self.window.y0) as usize;
        self.samples[row * self.window.width() + column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_repeats_the_edge() {
        let plane = Plane::new(Window::new(-1, -1, 1, 1), vec![1.0, 2.0, 3.0, 4.0]).expect("four samples");
        assert_eq!(plane.nearest(-9, -9), 1.0);
        assert_eq!(plane.nearest(50, -1), 2.0);
        assert_eq!(plane.nearest(0, 7), 4.0);
        assert_eq!(plane.row(0), Some(&[3.0, 4.0][..]));
        assert_eq!(plane.row(1), None);
    }

    #[test]
    fn samples_must_fill_the_window() {
        assert!(Plane::new(Window::sized(2, 2), vec![0.0; 3]).is_err());
    }
}
