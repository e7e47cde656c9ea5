//! Averages of a picture over rectangles, however large, in a few steps.

/// How a picture continues beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, trochoid_graph::Choice)]
pub(super) enum Wrap {
    Repeat,
    Clamp,
    Mirror,
}

impl Wrap {
    /// Returns the pixel in a row of `count` that stands at an index.
    pub(super) fn pixel(self, at: i64, count: i64) -> i64 {
        match self {
            Self::Repeat => at.rem_euclid(count),
            Self::Clamp => at.clamp(0, count - 1),
            Self::Mirror => {
                let within = at.rem_euclid(2 * count);
                within.min(2 * count - 1 - within)
            }
        }
    }
}

/// An integral over an interval of an axis, as a sum of integrals from the start of the row: each with its factor and its
/// number of pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Interval {
    terms: [(f64, usize); 8],
    count: usize,
}

impl Interval {
    /// Makes the integral from one place to another, in pixels, in a row of `count` pixels.
    pub(super) fn new(wrap: Wrap, [from, to]: [f64; 2], count: usize) -> Self {
        let mut interval = Self::default();
        interval.add(wrap, to, count, 1.0);
        interval.add(wrap, from, count, -1.0);
        interval
    }

    fn push(&mut self, factor: f64, pixels: usize) {
        if factor != 0.0 && pixels > 0 {
            self.terms[self.count] = (factor, pixels);
            self.count += 1;
        }
    }

    /// Adds the integral from 0 to a place within the row.
    fn within(&mut self, at: f64, count: usize, sign: f64) {
        let whole = (at.floor().max(0.0) as usize).min(count - 1);
        let part = at - whole as f64;
        self.push(sign * (1.0 - part), whole);
        self.push(sign * part, whole + 1);
    }

    /// Adds the integral from 0 to any place.
    fn add(&mut self, wrap: Wrap, at: f64, count: usize, sign: f64) {
        let side = count as f64;
        match wrap {
            Wrap::Repeat => {
                let times = (at / side).floor();
                self.push(sign * times, count);
                self.within((at - times * side).clamp(0.0, side), count, sign);
            }
            Wrap::Clamp if at < 0.0 => self.push(sign * at, 1),
            Wrap::Clamp if at > side => {
                // The last pixel goes on.
                self.push(sign * (1.0 + at - side), count);
                self.push(sign * (side - at), count - 1);
            }
            Wrap::Clamp => self.within(at, count, sign),
            Wrap::Mirror => {
                let times = (at / (2.0 * side)).floor();
                let rest = (at - times * 2.0 * side).clamp(0.0, 2.0 * side);
                let back = rest > side;
                self.push(sign * 2.0 * (times + f64::from(u8::from(back))), count);
                self.within(if back { 2.0 * side - rest } else { rest }, count, if back { -sign } else { sign });
            }
        }
    }

    fn terms(&self) -> &[(f64, usize)] {
        &self.terms[..self.count]
    }
}

/// Sums of a plane over the rectangles that begin at its upper left corner.
pub(super) struct Sums {
    /// Number of sums in a row: one more than there are pixels.
    stride: usize,
    sums: Vec<f64>,
}

impl Sums {
    /// Makes the sums of a plane of this size.
    pub(super) fn new([columns, rows]: [usize; 2], pixel: impl Fn(usize, usize) -> f64) -> Self {
        let stride = columns + 1;
        let mut sums = vec![0.0; stride * (rows + 1)];
        for row in 0..rows {
            let mut along = 0.0;
            for column in 0..columns {
                along += pixel(column, row);
                sums[(row + 1) * stride + column + 1] = sums[row * stride + column + 1] + along;
            }
        }
        Self { stride, sums }
    }

    /// Returns the integral over a rectangle.
    pub(super) fn over(&self, across: &Interval, down: &Interval) -> f64 {
        let row = |down: usize| {
            let sum = |(factor, pixels): &(f64, usize)| factor * self.sums[down * self.stride + pixels];
            across.terms().iter().map(sum).sum::<f64>()
        };
        down.terms().iter().map(|(factor, pixels)| factor * row(*pixels)).sum()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.sums[..])
    }
}

/// Returns how much of each pixel of a row an interval covers, pixel by pixel.
pub(super) fn covered(wrap: Wrap, [from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let mut covered = vec![0.0; count];
    for pixel in from.floor() as i64..to.ceil() as i64 {
        let length = (pixel as f64 + 1.0).min(to) - (pixel as f64).max(from);
        covered[wrap.pixel(pixel, count as i64) as usize] += length.max(0.0);
    }
    covered
}
