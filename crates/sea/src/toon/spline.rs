/// Number of pieces in the table of arc lengths; lengths are linear between its entries.
const PIECES: usize = 256;

/// A cubic Bézier curve in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spline(pub(crate) [[f64; 2]; 4]);

impl Spline {
    /// Returns the point at t in 0…1: Σ Bᵢ(t)·Pᵢ.
    pub(crate) fn point(&self, t: f64) -> [f64; 2] {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        self.sum(weights)
    }

    /// Returns the unit direction of travel at t; +X if the curve is a single point without direction.
    pub(crate) fn heading(&self, t: f64) -> [f64; 2] {
        let s = 1.0 - t;
        let first = self.sum([-s * s, s * (s - 2.0 * t), t * (2.0 * s - t), t * t]);
        // Where the first derivative vanishes, as with doubled end points, the curve leaves along the second
        // derivative.
        let second = self.sum([s, t - 2.0 * s, s - 2.0 * t, t]);
        let sign = if t > 0.5 { -1.0 } else { 1.0 };
        let size = self.0.iter().flatten().fold(0.0, |size: f64, value| size.max(value.abs()));
        for ([x, z], sign) in [(first, 1.0), (second, sign)] {
            let length = libm::sqrt(x * x + z * z);
            if length > 1e-9 * size {
                return [sign * x / length, sign * z / length];
            }
        }
        let [x, z] = [self.0[3][0] - self.0[0][0], self.0[3][1] - self.0[0][1]];
        let length = libm::sqrt(x * x + z * z);
        if length > 0.0 { [x / length, z / length] } else { [1.0, 0.0] }
    }

    fn sum(&self, weights: [f64; 4]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let [a, b, c, d] = self.0.map(|point| point[axis]);
            weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d
        })
    }

    /// Returns the length of the curve from its start to t = i/256, for each i.
    pub(crate) fn lengths(&self) -> Vec<f64> {
        let mut lengths = Vec::with_capacity(PIECES + 1);
        let (mut sum, mut last) = (0.0, self.point(0.0));
        lengths.push(0.0);
        for piece in 1..=PIECES {
            let next = self.point(piece as f64 / PIECES as f64);
            sum += libm::hypot(next[0] - last[0], next[1] - last[1]);
            lengths.push(sum);
            last = next;
        }
        lengths
    }
}

/// Returns the length up to t from a curve's table.
pub(crate) fn length_at(lengths: &[f64], t: f64) -> f64 {
    let place = t * PIECES as f64;
    let index = (place as usize).min(PIECES - 1);
    lengths[index] + (lengths[index + 1] - lengths[index]) * (place - index as f64)
}
