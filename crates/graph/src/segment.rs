//! The stretch of a curve between two keys that have handles: a Bézier curve in time and value.

/// Where a curve heads to at one side of a key, relative to the key.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveHandle {
    /// Frames from the key, without sign.
    pub frames: f64,
    /// Change of each component.
    pub change: Vec<f64>,
}

impl CurveHandle {
    /// Returns the handle, or a shorter one of the same slope that reaches over at most these frames.
    pub(crate) fn within(&self, frames: f64) -> Self {
        if self.frames <= frames {
            return self.clone();
        }
        let share = frames / self.frames;
        Self { frames, change: self.change.iter().map(|change| share * change).collect() }
    }
}

/// A Bézier curve from one key to the next. It is a function of time, because its handles end between the keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Frames of the keys.
    pub frames: [f64; 2],
    /// Frames of the ends of the handles, between those of the keys.
    pub reach: [f64; 2],
    /// For each component: its value at the first key, at the ends of both handles, and at the second key.
    pub values: Vec<[f64; 4]>,
}

/// Steps of the search for a time. Every second one halves the interval, so these are more than f64 has bits.
const STEPS: usize = 128;

impl Segment {
    /// Returns the frames of the four points, as fractions of the way.
    fn times(&self) -> [f64; 4] {
        let [start, end] = self.frames;
        let [a, b] = self.reach.map(|frame| ((frame - start) / (end - start)).clamp(0.0, 1.0));
        [0.0, a, b, 1.0]
    }

    /// Returns the parameter of the curve at a frame: by Newton's method, in an interval that contains the solution.
    pub fn parameter(&self, frame: f64) -> f64 {
        let times = self.times();
        let time = ((frame - self.frames[0]) / (self.frames[1] - self.frames[0])).clamp(0.0, 1.0);
        let (mut low, mut high, mut at) = (0.0, 1.0, time);
        for step in 0..STEPS {
            let off = cubic(times, at) - time;
            if off.abs() <= f64::EPSILON {
                break;
            }
            (low, high) = if off < 0.0 { (at, high) } else { (low, at) };
            let newton = at - off / slope(times, at);
            let is_inside = low < newton && newton < high;
            at = if is_inside && step % 2 == 0 { newton } else { low + 0.5 * (high - low) };
        }
        at
    }

    /// Returns the value of each component at a frame.
    pub fn at(&self, frame: f64) -> Vec<f64> {
        let parameter = self.parameter(frame);
        self.values
            .iter()
            .map(|values| {
                // Rounding must not lead beyond the values that are checked.
                let [low, high] = range(*values);
                cubic(*values, parameter).clamp(low, high)
            })
            .collect()
    }

    /// Returns where a component turns between the keys: frame and value.
    pub fn turns(&self, component: usize) -> impl Iterator<Item = (f64, f64)> {
        let (times, values) = (self.times(), self.values[component]);
        let [start, end] = self.frames;
        turns(values).map(move |at| (start + (end - start) * cubic(times, at), cubic(values, at)))
    }

    /// Returns the two parts of the segment that meet at a frame between its keys.
    pub fn split(&self, frame: f64) -> [Self; 2] {
        let at = self.parameter(frame);
        let [start, end] = self.frames;
        let halves = |points: [f64; 4]| {
            let mix = |a: f64, b: f64| a + at * (b - a);
            let [a, b, c] = [0, 1, 2].map(|index| mix(points[index], points[index + 1]));
            let (left, right) = (mix(a, b), mix(b, c));
            let middle = mix(left, right);
            [[points[0], a, left, middle], [middle, right, c, points[3]]]
        };
        let times = halves([start, self.reach[0], self.reach[1], end]);
        let values: Vec<[[f64; 4]; 2]> = self.values.iter().map(|values| halves(*values)).collect();
        [0, 1].map(|side| {
            let frames = if side == 0 { [start, frame] } else { [frame, end] };
            let reach = [times[side][1], times[side][2]].map(|reach| reach.clamp(frames[0], frames[1]));
            Self { frames, reach, values: values.iter().map(|halves| halves[side]).collect() }
        })
    }
}

/// Returns a cubic in the form of Bernstein.
fn cubic([a, b, c, d]: [f64; 4], at: f64) -> f64 {
    let rest = 1.0 - at;
    rest * rest * rest * a + 3.0 * rest * rest * at * b + 3.0 * rest * at * at * c + at * at * at * d
}

/// Returns its derivative.
fn slope([a, b, c, d]: [f64; 4], at: f64) -> f64 {
    let rest = 1.0 - at;
    3.0 * (rest * rest * (b - a) + 2.0 * rest * at * (c - b) + at * at * (d - c))
}

/// Returns the parameters inside at which the derivative is 0.
fn turns([a, b, c, d]: [f64; 4]) -> impl Iterator<Item = f64> {
    let (first, second, third) = (b - a, c - b, d - c);
    let [square, linear, constant] = [first - 2.0 * second + third, 2.0 * (second - first), first];
    let root = (linear * linear - 4.0 * square * constant).max(0.0).sqrt();
    // The form without cancellation.
    let sum = -0.5 * (linear + root.copysign(linear));
    [sum / square, constant / sum].into_iter().filter(|at| 0.0 < *at && *at < 1.0)
}

/// Returns the least and the greatest value.
fn range(values: [f64; 4]) -> [f64; 2] {
    let ends = [values[0], values[3]];
    let all = turns(values).map(|at| cubic(values, at)).chain(ends);
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::seq::IndexedRandom;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// A fraction of the way, often one that is hard.
    fn hostile(random: &mut Pcg64Mcg) -> f64 {
        match random.random_range(0..8) {
            0 => 0.0,
            1 => 1.0,
            2 => 1e-12,
            3 => 1.0 - 1e-12,
            _ => random.random(),
        }
    }

    fn segment(random: &mut Pcg64Mcg) -> Segment {
        let mut pick = |of: &[f64]| *of.choose(random).expect("a choice");
        let (far, width, size) = (pick(&[1.0, 2e3, 2e7]), pick(&[1e-3, 1.0, 40.0, 1e7]), pick(&[1e-6, 1.0, 1e30]));
        let start = random.random_range(-0.5..0.5) * far;
        let end = start + width;
        let reach = [hostile(random), hostile(random)].map(|share| start + share * (end - start));
        let values = [0; 4].map(|_| size * [0.0, 1.0, random.random_range(-1.0..1.0)][random.random_range(0..3)]);
        Segment { frames: [start, end], reach, values: vec![values] }
    }

    /// The value by its definition: bisection for the parameter, then the points between points between points. Rounding may
    /// give a time to many parameters; these are the values of the first and the last of them.
    fn reference(segment: &Segment, time: f64) -> [f64; 2] {
        let between = |points: [f64; 4], at: f64| {
            let mut points = points.to_vec();
            while points.len() > 1 {
                points = points.windows(2).map(|pair| (1.0 - at) * pair[0] + at * pair[1]).collect();
            }
            points[0]
        };
        let [start, end] = segment.frames;
        let [a, b] = segment.reach.map(|reach| (reach - start) / (end - start));
        [false, true].map(|is_last| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                let at = between([0.0, a, b, 1.0], middle);
                let is_before = at < time || is_last && at == time;
                (low, high) = if is_before { (middle, high) } else { (low, middle) };
            }
            between(segment.values[0], 0.5 * (low + high))
        })
    }

    #[test]
    fn the_fast_value_is_that_of_the_definition_at_a_time_within_rounding() {
        let mut random = Pcg64Mcg::seed_from_u64(26);
        for case in 0..20_000 {
            let segment = segment(&mut random);
            let [start, end] = segment.frames;
            let frame = (start + hostile(&mut random) * (end - start)).min(end);
            let time = (frame - start) / (end - start);
            let value = segment.at(frame)[0];
            // The values within a tiny time around: a curve may be steep without a limit.
            let near = [-1e-11, -1e-12, -1e-14, 0.0, 1e-14, 1e-12, 1e-11].map(|off| (time + off).clamp(0.0, 1.0));
            let near = near.map(|time| reference(&segment, time)).concat();
            let size = segment.values[0].iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let low = near.iter().copied().fold(f64::INFINITY, f64::min) - 1e-10 * size;
            let high = near.iter().copied().fold(f64::NEG_INFINITY, f64::max) + 1e-10 * size;
            assert!(
                (low..=high).contains(&value),
                "{case}: {value} outside of {low} to {high}; {segment:?} at {frame}"
            );
        }
    }

    #[test]
    fn no_value_lies_beyond_the_ends_and_the_turns() {
        let mut random = Pcg64Mcg::seed_from_u64(27);
        let mut turned = 0;
        for _ in 0..2_000 {
            let segment = segment(&mut random);
            let [start, end] = segment.frames;
            let turns: Vec<f64> = segment.turns(0).map(|turn| turn.1).collect();
            turned += turns.len();
            let all = || turns.iter().chain([&segment.values[0][0], &segment.values[0][3]]).copied();
            let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            for step in 0..=100 {
                let value = segment.at(start + (end - start) * f64::from(step) / 100.0)[0];
                assert!((low..=high).contains(&value), "{value} outside of {low} to {high}; {segment:?}");
            }
        }
        assert!(turned > 500, "only {turned} turns");
    }

    #[test]
    fn the_parts_of_a_segment_are_the_segment() {
        let mut random = Pcg64Mcg::seed_from_u64(28);
        for _ in 0..500 {
            let reach = [0; 2].map(|_| random.random_range(8.0..32.0));
            let values = vec![[0; 4].map(|_| random.random())];
            let whole = Segment { frames: [0.0, 40.0], reach, values };
            let [left, right] = whole.split(13.0);
            for step in 0..=40 {
                let frame = f64::from(step);
                let part = if frame < 13.0 { &left } else { &right };
                assert!((part.at(frame)[0] - whole.at(frame)[0]).abs() < 1e-6, "{whole:?} at {frame}");
            }
        }
    }
}
