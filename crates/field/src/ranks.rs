//! Shares of many numbers that lie below another one.

/// Sorted numbers, with a table that tells where to search.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranks {
    sorted: Vec<f32>,
    /// For each of `PARTS` even parts of the range, the number of numbers before it; last, the number of all.
    before: Vec<u32>,
    /// Parts per unit.
    parts: f64,
}

/// Even parts of the range in which numbers are searched.
const PARTS: usize = 1024;

impl Ranks {
    /// Sorts numbers, most of which are from 0 to `most`; that must be above 0.
    pub fn new(mut numbers: Vec<f32>, most: f64) -> Self {
        numbers.sort_by(f32::total_cmp);
        let mut ranks = Self { sorted: numbers, before: Vec::new(), parts: PARTS as f64 / most };
        let first = |part: usize| ranks.sorted.partition_point(|number| ranks.part(f64::from(*number)) < part) as u32;
        ranks.before = (0..PARTS).map(first).chain([ranks.sorted.len() as u32]).collect();
        ranks
    }

    /// Returns the part that holds a number; the first for all below 0, the last for all beyond the range.
    fn part(&self, number: f64) -> usize {
        ((number * self.parts) as usize).min(PARTS - 1)
    }

    /// Returns the share of the numbers that lie below another one; 0 for NaN.
    #[inline]
    pub fn share_below(&self, limit: f64) -> f64 {
        // All numbers of earlier parts lie below it, and none of later parts does.
        let part = self.part(limit);
        let (start, end) = (self.before[part] as usize, self.before[part + 1] as usize);
        let below = self.sorted[start..end].partition_point(|number| f64::from(*number) < limit);
        (start + below) as f64 / self.sorted.len() as f64
    }

    /// Returns the memory that the numbers and the table take, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.sorted[..]) + size_of_val(&self.before[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::mix;

    #[test]
    fn the_table_changes_no_share() {
        // Clustered near 0, with repeats, and some beyond the range.
        let number = |index: u32| {
            let t = f64::from(mix(index) >> 12) / f64::from(1 << 20);
            (0.5 * t * t * t * 1.01) as f32
        };
        let numbers: Vec<f32> = (0..5000).map(number).chain([0.0, -0.0, 0.25, 0.25, 0.5, 7.0]).collect();
        let mut sorted = numbers.clone();
        sorted.sort_by(f32::total_cmp);
        let ranks = Ranks::new(numbers, 0.5);
        let hostile = [0.0, -0.0, -1.0, 5e-324, 0.5, 0.25, 1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let steps = (0..4000).map(|step| f64::from(step) / 7500.0);
        let own = sorted.iter().flat_map(|number| {
            let number = f64::from(*number);
            [number.next_down(), number, number.next_up()]
        });
        for limit in steps.chain(own).chain(hostile) {
            let below = sorted.partition_point(|number| f64::from(*number) < limit);
            assert_eq!(ranks.share_below(limit), below as f64 / sorted.len() as f64, "{limit}");
        }
    }
}
