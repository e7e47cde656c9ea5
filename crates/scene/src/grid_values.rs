//! Values in the cells of a grid: their numbers, their interpolation, and trails that are computed on request.

use std::sync::{Arc, LazyLock};

/// A number of a grid: f32 in pictures, f64 in references.
pub trait Number: Copy + Default + Into<f64> + Send + Sync + std::fmt::Debug + 'static {}

impl Number for f32 {}
impl Number for f64 {}

/// Largest distances of the values in the cells of a grid from those of their definition.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridDoubt {
    /// Of heights, in meters.
    pub height: f64,
    /// Of [`Channel::TRAILS`](crate::Channel::TRAILS).
    pub trails: f64,
    /// Largest absolute value of a trail in a cell.
    pub largest_trail: f64,
}

/// A value that is computed when it is first needed.
pub(crate) type Lazy<T> = Arc<LazyLock<T, Box<dyn FnOnce() -> T + Send>>>;

/// Traces that bursts left behind, cell by cell: the rift, and the other five. Each may be empty.
#[derive(Clone)]
pub(crate) struct Trails<T> {
    pub(crate) rift: Lazy<Vec<T>>,
    pub(crate) drift: Lazy<[Vec<T>; 5]>,
}

impl<T> Trails<T> {
    pub(crate) fn new(
        rift: impl FnOnce() -> Vec<T> + Send + 'static,
        drift: impl FnOnce() -> [Vec<T>; 5] + Send + 'static,
    ) -> Self {
        Self { rift: Arc::new(LazyLock::new(Box::new(rift))), drift: Arc::new(LazyLock::new(Box::new(drift))) }
    }

    /// Returns the values of [`Channel::TRAILS`]`[index]`.
    pub(crate) fn values(&self, index: usize) -> &[T] {
        if let Some(index) = index.checked_sub(1) { &self.drift[index] } else { &self.rift }
    }
}

/// Catmull–Rom weights of four neighbors at t in 0…1 between the inner two, and their derivatives.
pub(crate) type Weights = ([f64; 4], [f64; 4]);

pub(crate) fn weights(t: f64) -> Weights {
    let (t2, t3) = (t * t, t * t * t);
    let value = [-t + 2.0 * t2 - t3, 2.0 - 5.0 * t2 + 3.0 * t3, t + 4.0 * t2 - 3.0 * t3, t3 - t2];
    let slope = [-1.0 + 4.0 * t - 3.0 * t2, 9.0 * t2 - 10.0 * t, 1.0 + 8.0 * t - 9.0 * t2, 3.0 * t2 - 2.0 * t];
    (value.map(|w| w / 2.0), slope.map(|w| w / 2.0))
}

/// Returns a second difference.
pub(crate) fn second<T: Number>(before: T, here: T, after: T) -> f64 {
    before.into() - 2.0 * here.into() + after.into()
}

pub(crate) fn square(value: f64) -> f64 {
    value * value
}
