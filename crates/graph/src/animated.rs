//! Numbers that may be animated over frames.

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

/// One or more numbers, constant or keyed over frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Animated {
    /// At least one key; frames in strictly ascending order; all values of one length.
    keys: Vec<(f64, Vec<f64>)>,
    interpolation: Interpolation,
}

impl Animated {
    /// Makes numbers that are constant over all frames.
    pub fn constant(values: Vec<f64>) -> Self {
        Self { keys: vec![(0.0, values)], interpolation: Interpolation::Hold }
    }

    /// Makes numbers keyed over frames; `None` unless there are keys, in strictly ascending order, with values of one
    /// length.
    pub fn keyed(keys: Vec<(f64, Vec<f64>)>, interpolation: Interpolation) -> Option<Self> {
        let ascending = keys.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1.len() == pair[1].1.len());
        (!keys.is_empty() && ascending).then_some(Self { keys, interpolation })
    }

    /// Lets each key hold until the next; `None` if another interpolation was explicitly `chosen`.
    pub(crate) fn held(mut self, chosen: bool) -> Option<Self> {
        let interpolation = std::mem::replace(&mut self.interpolation, Interpolation::Hold);
        (!chosen || interpolation == Interpolation::Hold).then_some(self)
    }

    /// Returns the frames of the keys; empty for a constant.
    pub fn frames(&self) -> impl Iterator<Item = f64> {
        self.keys.iter().map(|key| key.0).filter(|_| self.keys.len() > 1)
    }

    /// Returns the value of every key.
    pub fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.keys.iter().map(|key| key.1.as_slice())
    }

    /// Replaces the value of each key.
    pub fn map(&self, f: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        Self {
            keys: self.keys.iter().map(|(frame, value)| (*frame, f(value))).collect(),
            interpolation: self.interpolation,
        }
    }

    /// Returns the numbers at a frame; before the first and after the last key they hold.
    ///
    /// Monotone cubic after Fritsch and Carlson, *Monotone Piecewise Cubic Interpolation*, 1980, with the
    /// harmonic mean as slope, so that no value lies beyond its two keys.
    pub fn at(&self, frame: f64) -> Vec<f64> {
        let next = self.keys.partition_point(|key| key.0 <= frame);
        if next == 0 {
            return self.keys[0].1.clone();
        }
        let (start, from) = &self.keys[next - 1];
        let Some((end, to)) = self.keys.get(next) else { return from.clone() };
        let t = (frame - start) / (end - start);
        (0..from.len())
            .map(|i| match self.interpolation {
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
            (self.keys[b].1[component] - self.keys[a].1[component]) / (self.keys[b].0 - self.keys[a].0)
        };
        let (before, after) = (secant(key - 1, key), secant(key, key + 1));
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(interpolation: Interpolation) -> Animated {
        let keys = vec![(1.0, vec![0.0]), (11.0, vec![1.0]), (21.0, vec![1.0]), (31.0, vec![-2.0])];
        Animated::keyed(keys, interpolation).expect("ascending")
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
        let keys = vec![(3.0, vec![0.0]), (3.0, vec![1.0])];
        assert!(Animated::keyed(keys, Interpolation::Linear).is_none());
        assert!(Animated::keyed(Vec::new(), Interpolation::Linear).is_none());
    }
}
