use trochoid_image::Plane;

/// Statistics of a plane's samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Smallest finite value; `None` if there is none.
    pub min: Option<f32>,
    /// Largest finite value; `None` if there is none.
    pub max: Option<f32>,
    /// Mean of the finite values; `None` if there is none.
    pub mean: Option<f64>,
    /// Number of finite values.
    pub finite: u64,
    /// Number of NaN.
    pub nan: u64,
    /// Number of +∞.
    pub positive_infinite: u64,
    /// Number of −∞.
    pub negative_infinite: u64,
}

/// Counts and measures the samples of a plane.
///
/// ```
/// use trochoid_image::{Plane, Window};
/// let plane = Plane::new(Window::sized(4, 1), vec![1.0, 3.0, f32::NAN, f32::INFINITY])?;
/// let found = trochoid_io::statistics(&plane);
/// assert_eq!((found.min, found.max, found.mean), (Some(1.0), Some(3.0), Some(2.0)));
/// assert_eq!((found.finite, found.nan, found.positive_infinite), (2, 1, 1));
/// # Ok::<(), trochoid_image::PlaneError>(())
/// ```
pub fn statistics(plane: &Plane) -> Statistics {
    let (mut min, mut max, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0_f64);
    let (mut finite, mut nan, mut positive_infinite, mut negative_infinite) = (0, 0, 0, 0);
    for &value in plane.samples() {
        if value.is_finite() {
            min = min.min(value);
            max = max.max(value);
            sum += f64::from(value);
            finite += 1;
        } else if value.is_nan() {
            nan += 1;
        } else if value > 0.0 {
            positive_infinite += 1;
        } else {
            negative_infinite += 1;
        }
    }
    let any = finite > 0;
    Statistics {
        min: any.then_some(min),
        max: any.then_some(max),
        mean: any.then(|| sum / finite as f64),
        finite,
        nan,
        positive_infinite,
        negative_infinite,
    }
}

#[cfg(test)]
mod tests {
    use trochoid_image::Window;

    use super::*;

    #[test]
    fn nothing_finite_has_no_range() {
        let plane = Plane::new(Window::sized(2, 1), vec![f32::NEG_INFINITY, f32::NAN]).expect("two samples");
        let found = statistics(&plane);
        assert_eq!((found.min, found.max, found.mean), (None, None, None));
        assert_eq!((found.finite, found.nan, found.negative_infinite), (0, 1, 1));
    }
}
