//! Collects what is known about the errors of a picture.

use trochoid_graph::{Bound, Kind, NodeId, REFERENCE};
use trochoid_image::{Rgb, Window};

/// Histogram of error bounds over samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Number of samples by size of their bound; see [`bucket`].
    counts: Vec<u64>,
    total: u64,
    max: f64,
    /// Limit that no error can exceed, whatever its bound.
    limit: f64,
}

/// Shift that keeps a number's leading bits, which sort like the number: the exponent and four more bits, so 16
/// buckets per octave.
const SHIFT: u32 = 48;
/// Leading bits of the smallest and largest numbers that are distinguished, 2⁻⁶⁰ and 2⁶⁰.
const LEAST: u64 = (1023 - 60) << 4;
const GREATEST: u64 = (1023 + 60) << 4;
/// Number of buckets; bucket 0 holds 0.
const BUCKETS: usize = (GREATEST - LEAST) as usize + 2;

fn bucket(size: f64) -> usize {
    if size <= 0.0 { 0 } else { ((size.to_bits() >> SHIFT).clamp(LEAST, GREATEST) - LEAST) as usize + 1 }
}

/// Returns the upper limit of the numbers in a bucket.
fn top(bucket: usize) -> f64 {
    if bucket == 0 { 0.0 } else { f64::from_bits((bucket as u64 + LEAST) << SHIFT) }
}

impl Default for Distribution {
    fn default() -> Self {
        Self { counts: vec![0; BUCKETS], total: 0, max: 0.0, limit: f64::INFINITY }
    }
}

impl Distribution {
    fn add(&mut self, size: f64) {
        self.counts[bucket(size)] += 1;
        self.total += 1;
        self.max = self.max.max(size);
    }

    fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(all, own)| *all += own);
        self.total += other.total;
        self.max = self.max.max(other.max);
    }

    /// Returns the number of samples.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Returns the largest bound.
    pub fn max(&self) -> f64 {
        self.max.min(self.limit)
    }

    /// Returns the size that this share of the bounds does not exceed, too large by at most a sixteenth of an octave.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut left = (share.clamp(0.0, 1.0) * self.total as f64).ceil() as u64;
        for (bucket, count) in self.counts.iter().enumerate() {
            left = left.saturating_sub(*count);
            if left == 0 {
                return top(bucket).min(self.max());
            }
        }
        self.max()
    }

    /// Returns the number of bounds above a size; it may include bounds up to a sixteenth of an octave below it.
    pub fn above(&self, size: f64) -> u64 {
        if self.max() <= size { 0 } else { self.counts[bucket(size)..].iter().sum() }
    }
}

/// Certified errors of one output; the error of a sample is that of its largest channel.
#[derive(Clone, Debug)]
pub struct Certified {
    /// The output's index in the graph.
    pub output: usize,
    /// The output's kind.
    pub kind: Kind,
    /// Pixels that are certified.
    pub window: Window,
    /// Bounds of samples that are not in doubt.
    pub clear: Distribution,
    /// Bounds of samples where the side of a threshold, or the visible surface, is not certain. These bounds hold as
    /// well.
    pub unclear: Distribution,
    /// Pixel of the sample that has the largest bound of those not in doubt; `None` if all are 0.
    pub worst: Option<[i64; 2]>,
    /// Bound on the error of each pixel, by channel and row by row.
    pub errors: Vec<Vec<f32>>,
    /// Whether each pixel is infinite, like its reference, by channel and row by row; empty for kinds that are always
    /// finite. The error of such a pixel is 0.
    pub infinite: Vec<Vec<bool>>,
    /// Share of each pixel's samples that is in doubt.
    pub doubt: Vec<f32>,
    /// Vertices of the hull of all control colors that a color output may be mixed from; no branch counts as left
    /// out.
    pub palette: Vec<Rgb>,
    /// Margin of rounding around that hull.
    pub margin: f64,
    /// Stages upstream that do not know a bound everywhere, and why.
    pub unbounded: Vec<(NodeId, &'static str)>,
}

impl Certified {
    pub(super) fn new(output: usize, kind: Kind, window: Window) -> Self {
        Self {
            output,
            kind,
            window,
            clear: Distribution::default(),
            unclear: Distribution::default(),
            worst: None,
            errors: vec![vec![0.0; window.area()]; kind.channels()],
            infinite: vec![vec![false; window.area()]; if kind.is_finite() { 0 } else { kind.channels() }],
            doubt: vec![0.0; window.area()],
            palette: Vec::new(),
            margin: 0.0,
            unbounded: Vec::new(),
        }
    }

    /// Returns the bounds of all samples.
    pub fn all(&self) -> Distribution {
        let mut all = self.clear.clone();
        all.merge(&self.unclear);
        all
    }

    /// Returns the share of samples that are in doubt and whose bound exceeds a tolerance.
    pub fn in_doubt(&self, tolerance: f64) -> f64 {
        self.unclear.above(tolerance) as f64 / (self.clear.total + self.unclear.total).max(1) as f64
    }

    /// Adds one sample of every pixel, given its encoded bounds by channel and its share of the pixel.
    fn sample(&mut self, channels: &[Vec<f32>], share: f64) {
        for pixel in 0..self.window.area() {
            let mut sample = Bound::EXACT;
            for (bounds, errors) in channels.iter().zip(&mut self.errors) {
                let bound = Bound::decode(bounds[pixel]);
                sample = Bound { size: sample.size.max(bound.size), clear: sample.clear && bound.clear };
                errors[pixel] = Bound::of(f64::from(errors[pixel]) + share * bound.size).encode();
            }
            if sample.clear {
                if sample.size > self.clear.max {
                    let [x, y] = [pixel % self.window.width(), pixel / self.window.width()].map(|along| along as i64);
                    self.worst = Some([self.window.x0 + x, self.window.y0 + y]);
                }
                self.clear.add(sample.size);
            } else {
                self.unclear.add(sample.size);
                self.doubt[pixel] += share as f32;
            }
        }
    }

    /// Sets the limit that no error can exceed, because picture and reference both lie within it.
    pub(super) fn cap(&mut self, limit: f64) {
        self.clear.limit = limit;
        self.unclear.limit = limit;
        let most = Bound::of(limit).encode();
        self.errors.iter_mut().flatten().for_each(|error| *error = error.min(most));
    }

    /// Adds a tile of the picture.
    pub(super) fn add(&mut self, part: &Self) {
        if part.clear.max > self.clear.max {
            self.worst = part.worst;
        }
        self.clear.merge(&part.clear);
        self.unclear.merge(&part.unclear);
        let (all, own) = (self.window, part.window);
        let planes = self.errors.iter_mut().zip(&part.errors).chain([(&mut self.doubt, &part.doubt)]);
        planes.for_each(|(to, from)| paste(from, own, to, all));
        self.infinite.iter_mut().zip(&part.infinite).for_each(|(to, from)| paste(from, own, to, all));
    }
}

/// Copies a plane over a window into one over a larger window.
fn paste<T: Copy>(from: &[T], own: Window, to: &mut [T], all: Window) {
    for (y, row) in (own.y0..own.y1).zip(from.chunks_exact(own.width())) {
        let start = (y - all.y0) as usize * all.width() + (own.x0 - all.x0) as usize;
        to[start..start + row.len()].copy_from_slice(row);
    }
}

/// A tile of an output: its bounds, and the picture's own values.
#[derive(Debug)]
pub(super) struct CertifiedTile {
    pub(super) bounds: Certified,
    /// Sums of the samples by channel, then their means; the picture stores these rounded to f32.
    pub(super) values: Vec<Vec<f64>>,
}

impl CertifiedTile {
    pub(super) fn new(output: usize, kind: Kind, tile: Window) -> Self {
        let values = vec![vec![0.0; tile.area()]; kind.channels()];
        Self { bounds: Certified::new(output, kind, tile), values }
    }

    /// Adds one sample of every pixel, given its values and encoded bounds by channel and its share of the pixel.
    pub(super) fn sample(&mut self, values: &[Vec<f32>], bounds: &[Vec<f32>], share: f64) {
        self.bounds.sample(bounds, share);
        for (sums, values) in self.values.iter_mut().zip(values) {
            // A single sample keeps the sign of its 0.
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum = if share == 1.0 { f64::from(*value) } else { *sum + f64::from(*value) };
            }
        }
    }

    /// Averages the samples like the picture does, and adds the rounding errors of that.
    pub(super) fn average(&mut self, share: f64) {
        let Certified { errors, infinite, .. } = &mut self.bounds;
        for (channel, (values, errors)) in self.values.iter_mut().zip(errors).enumerate() {
            for (pixel, (value, error)) in values.iter_mut().zip(errors).enumerate() {
                *value *= share;
                if value.is_infinite() && error.is_finite() {
                    // The reference of an infinite sample within a finite bound is the same infinity, and so is the
                    // mean with finite samples: these have finite references.
                    *error = 0.0;
                    if let Some(infinite) = infinite.get_mut(channel) {
                        infinite[pixel] = true;
                    }
                    continue;
                }
                let rounded = (f64::from(*value as f32) - *value).abs() + value.abs() * REFERENCE;
                *error = Bound::of(f64::from(*error) + rounded).encode();
            }
        }
    }
}
