//! Numbers that may be animated over frames.

use crate::segment::{CurveHandle, Segment};

/// Interpolation of a value between its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Linear interpolation.
    #[default]
    Linear,
    /// Each key holds until the next.
    Hold,
    /// Monotone cubic: smooth, and never outside of the range of the two keys.
    Monotone,
}

impl Interpolation {
    /// Words in documents.
    pub const NAMES: [&str; 3] = ["linear", "hold", "monotone"];

    /// Returns its word in documents.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Returns the interpolation with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "linear" => Some(Self::Linear),
            "hold" => Some(Self::Hold),
            "monotone" => Some(Self::Monotone),
            _ => None,
        }
    }
}

/// A key of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveKey {
    /// Its frame.
    pub frame: f64,
    /// Value of each component.
    pub value: Vec<f64>,
    /// Handles before and after the key.
    pub handles: [Option<CurveHandle>; 2],
    /// Interpolation from this key to the next, if it is not that of the curve.
    pub interpolation: Option<Interpolation>,
}

impl CurveKey {
    /// Makes a key without handles.
    pub fn plain(frame: f64, value: Vec<f64>) -> Self {
        Self { frame, value, handles: [None, None], interpolation: None }
    }

    /// Returns whether its handles change as many numbers as it has.
    fn is_even(&self) -> bool {
        self.handles.iter().flatten().all(|handle| handle.change.len() == self.value.len())
    }
}

/// One or more numbers, constant or keyed over frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Animated {
    /// At least one key; frames in strictly ascending order; all values and handles of one length.
    keys: Vec<CurveKey>,
    interpolation: Interpolation,
}

impl Animated {
    /// Makes numbers that are constant over all frames.
    pub fn constant(values: Vec<f64>) -> Self {
        Self { keys: vec![CurveKey::plain(0.0, values)], interpolation: Interpolation::Hold }
    }

    /// Makes numbers keyed over frames; `None` unless there are keys, in strictly ascending order, with values and handles of
    /// one length.
    pub fn keyed(keys: Vec<CurveKey>, interpolation: Interpolation) -> Option<Self> {
        let follows = |a: &CurveKey, b: &CurveKey| a.frame < b.frame && a.value.len() == b.value.len();
        let is_sound = keys.iter().all(CurveKey::is_even) && keys.windows(2).all(|pair| follows(&pair[0], &pair[1]));
        (!keys.is_empty() && is_sound).then_some(Self { keys, interpolation })
    }

    /// Lets each key hold until the next; `None` if another interpolation was explicitly `chosen`, or a key has its own, or
    /// handles.
    pub(crate) fn held(mut self, chosen: bool) -> Option<Self> {
        let is_plain = |key: &CurveKey| {
            key.handles == [None, None] && key.interpolation.is_none_or(|word| word == Interpolation::Hold)
        };
        let interpolation = std::mem::replace(&mut self.interpolation, Interpolation::Hold);
        let holds = (!chosen || interpolation == Interpolation::Hold) && self.keys.iter().all(is_plain);
        holds.then_some(self)
    }

    /// Returns the frames of the keys; empty for a constant.
    pub fn frames(&self) -> impl Iterator<Item = f64> {
        self.keys.iter().map(|key| key.frame).filter(|_| self.keys.len() > 1)
    }

    /// Returns the value of every key.
    pub fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.keys.iter().map(|key| key.value.as_slice())
    }

    /// Replaces the value of each key, and that at the ends of its handles: what is between them stays between.
    pub fn map(&self, f: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let key = |key: &CurveKey| {
            let value = f(&key.value);
            let handle = |handle: &CurveHandle| {
                let end: Vec<f64> = key.value.iter().zip(&handle.change).map(|(from, by)| from + by).collect();
                let change = f(&end).iter().zip(&value).map(|(to, from)| to - from).collect();
                CurveHandle { frames: handle.frames, change }
            };
            let handles = key.handles.each_ref().map(|written| written.as_ref().map(handle));
            CurveKey { frame: key.frame, value, handles, interpolation: key.interpolation }
        };
        Self { keys: self.keys.iter().map(key).collect(), interpolation: self.interpolation }
    }

    /// Returns the interpolation from a key to the next.
    fn interpolation(&self, key: usize) -> Interpolation {
        self.keys[key].interpolation.unwrap_or(self.interpolation)
    }

    /// Returns whether the curve from a key to the next follows handles.
    fn has_handles(&self, key: usize) -> bool {
        let next = self.keys.get(key + 1).is_some_and(|next| next.handles[0].is_some());
        next || self.keys[key].handles[1].is_some()
    }

    /// Returns the frames of handles that have no effect, since the value holds there.
    pub(crate) fn idle_handles(&self) -> impl Iterator<Item = f64> {
        let held = |key: &usize| self.interpolation(*key) == Interpolation::Hold;
        let idle = (0..self.keys.len() - 1).filter(held).filter(|key| self.has_handles(*key));
        idle.map(|key| self.keys[if self.keys[key].handles[1].is_some() { key } else { key + 1 }].frame)
    }

    /// Returns where components turn between keys because of handles: frame and value.
    pub fn turns(&self) -> Vec<(f64, f64)> {
        let curved = (0..self.keys.len() - 1).filter(|key| self.has_handles(*key));
        let segments: Vec<Segment> = curved.filter_map(|key| self.segment(key)).collect();
        let of = |segment: &Segment| -> Vec<_> {
            (0..segment.values.len()).flat_map(|component| segment.turns(component)).collect()
        };
        segments.iter().flat_map(of).collect()
    }

    /// Returns the curve from a key to the next, where a missing handle reaches a third of the way, with the slope of the
    /// interpolation; `None` after the last key, and where the value holds.
    pub fn segment(&self, key: usize) -> Option<Segment> {
        let (one, two) = (&self.keys[key], self.keys.get(key + 1)?);
        let interpolation = self.interpolation(key);
        if interpolation == Interpolation::Hold {
            return None;
        }
        let width = two.frame - one.frame;
        let handle = |key: usize, written: &Option<CurveHandle>, sign: f64| match written {
            Some(handle) => handle.within(width),
            None => {
                let slope = |component: usize| match interpolation {
                    Interpolation::Monotone => self.slope(key, component),
                    _ => (two.value[component] - one.value[component]) / width,
                };
                let change = (0..one.value.len()).map(|component| sign * slope(component) * width / 3.0);
                CurveHandle { frames: width / 3.0, change: change.collect() }
            }
        };
        let (after, before) = (handle(key, &one.handles[1], 1.0), handle(key + 1, &two.handles[0], -1.0));
        let values = (0..one.value.len()).map(|component| {
            let [from, to] = [one, two].map(|key| key.value[component]);
            [from, from + after.change[component], to + before.change[component], to]
        });
        let reach = [one.frame + after.frames, two.frame - before.frames];
        Some(Segment { frames: [one.frame, two.frame], reach, values: values.collect() })
    }

    /// Returns the numbers at a frame; before the first and after the last key they hold.
    ///
    /// Monotone cubic after Fritsch and Carlson, *Monotone Piecewise Cubic Interpolation*, 1980, with the
    /// harmonic mean as slope, so that no value lies beyond its two keys.
    pub fn at(&self, frame: f64) -> Vec<f64> {
        let next = self.keys.partition_point(|key| key.frame <= frame);
        if next == 0 {
            return self.keys[0].value.clone();
        }
        let CurveKey { frame: start, value: from, .. } = &self.keys[next - 1];
        let Some(CurveKey { frame: end, value: to, .. }) = self.keys.get(next) else { return from.clone() };
        if self.has_handles(next - 1)
            && let Some(segment) = self.segment(next - 1)
        {
            return segment.at(frame);
        }
        let t = (frame - start) / (end - start);
        (0..from.len())
            .map(|i| match self.interpolation(next - 1) {
                Interpolation::Hold => from[i],
                Interpolation::Linear => (1.0 - t) * from[i] + t * to[i],
                Interpolation::Monotone => {
                    let width = end - start;
                    let (m0, m1) = (self.slope(next - 1, i) * width, self.slope(next, i) * width);
                    let (t2, t3) = (t * t, t * t * t);
                    let value = (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                        + (t3 - 2.0 * t2 + t) * m0
                        + (3.0 * t2 - 2.0 * t3) * to[i]
                        + (t3 - t2) * m1;
                    value.clamp(from[i].min(to[i]), from[i].max(to[i]))
                }
            })
            .collect()
    }

    /// Returns the slope of the monotone cubic at a key: 0 at ends and turning points.
    fn slope(&self, key: usize, component: usize) -> f64 {
        if key == 0 || key + 1 == self.keys.len() {
            return 0.0;
        }
        let secant = |a: usize, b: usize| {
            (self.keys[b].value[component] - self.keys[a].value[component]) / (self.keys[b].frame - self.keys[a].frame)
        };
        let (before, after) = (secant(key - 1, key), secant(key, key + 1));
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(interpolation: Interpolation) -> Animated {
        let keys = [(1.0, 0.0), (11.0, 1.0), (21.0, 1.0), (31.0, -2.0)];
        let keys = keys.map(|(frame, value)| CurveKey::plain(frame, vec![value]));
        Animated::keyed(keys.into(), interpolation).expect("ascending")
    }

    #[test]
    fn keys_are_met_and_ends_hold() {
        for interpolation in [Interpolation::Linear, Interpolation::Hold, Interpolation::Monotone] {
            let curve = ramp(interpolation);
            for (frame, value) in [(-5.0, 0.0), (1.0, 0.0), (11.0, 1.0), (21.0, 1.0), (31.0, -2.0), (99.0, -2.0)] {
                assert_eq!(curve.at(frame), [value], "{interpolation:?} at {frame}");
            }
        }
    }

    #[test]
    fn monotone_never_overshoots() {
        let curve = ramp(Interpolation::Monotone);
        let mut last = 1.0;
        for step in 0..=200 {
            let value = curve.at(21.0 + f64::from(step) * 0.05)[0];
            assert!(value <= last && value >= -2.0);
            last = value;
        }
        assert!((0..100).all(|i| curve.at(11.0 + f64::from(i) * 0.1) == [1.0]), "flat stays flat");
    }

    #[test]
    fn disordered_keys_are_refused() {
        let keys = [0.0, 1.0].map(|value| CurveKey::plain(3.0, vec![value]));
        assert!(Animated::keyed(keys.into(), Interpolation::Linear).is_none());
        assert!(Animated::keyed(Vec::new(), Interpolation::Linear).is_none());
    }

    fn handle(frames: f64, change: f64) -> Option<CurveHandle> {
        Some(CurveHandle { frames, change: vec![change] })
    }

    #[test]
    fn handles_of_a_third_with_the_slopes_of_an_interpolation_change_nothing() {
        for interpolation in [Interpolation::Linear, Interpolation::Monotone] {
            let plain = ramp(interpolation);
            for key in 0..3 {
                let segment = plain.segment(key).expect("it does not hold");
                for step in 0..=40 {
                    let frame = segment.frames[0] + f64::from(step) * 0.25;
                    assert!((segment.at(frame)[0] - plain.at(frame)[0]).abs() < 1e-12, "{interpolation:?} at {frame}");
                }
            }
        }
    }

    #[test]
    fn a_handle_longer_than_the_way_keeps_its_slope() {
        let mut long = ramp(Interpolation::Linear);
        long.keys[0].handles[1] = handle(25.0, 5.0);
        let mut short = ramp(Interpolation::Linear);
        short.keys[0].handles[1] = handle(10.0, 2.0);
        for frame in 1..=11 {
            assert_eq!(long.at(f64::from(frame)), short.at(f64::from(frame)));
        }
        assert!(long.at(6.0)[0] > ramp(Interpolation::Linear).at(6.0)[0] + 0.1);
        assert_eq!(long.at(12.0), [1.0], "other segments stay");
    }

    #[test]
    fn a_key_with_an_interpolation_of_its_own_has_it_until_the_next() {
        let mut curve = ramp(Interpolation::Linear);
        curve.keys[0].interpolation = Some(Interpolation::Hold);
        assert_eq!([1.0, 10.9, 11.0, 26.0].map(|frame| curve.at(frame)[0]), [0.0, 0.0, 1.0, -0.5]);
        curve.keys[1].handles[0] = handle(2.0, 0.0);
        assert_eq!(curve.idle_handles().collect::<Vec<_>>(), [11.0]);
        assert_eq!(curve.at(6.0), [0.0], "what holds has no handles");
    }
}
