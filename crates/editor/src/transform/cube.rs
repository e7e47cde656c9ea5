//! Tables of colors, and how values between their entries are found.

/// Curves for each channel, a lattice of colors, or both, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Cube {
    pub(super) curves: Option<Table>,
    pub(super) lattice: Option<Table>,
}

/// Entries at equal distances, and the values of the first and the last one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    /// Number of entries along a side.
    pub(super) size: usize,
    /// The smallest and the largest value of each channel; values beyond them count as these.
    pub(super) domain: [[f32; 2]; 3],
    /// The entries; in a lattice, red changes fastest and blue slowest.
    pub(super) entries: Vec<[f32; 3]>,
}

impl Table {
    /// Returns the index of the entry before a value, and how far the value is on the way to the next one, from 0 to 1.
    fn place(&self, channel: usize, value: f32) -> (usize, f32) {
        let [low, high] = self.domain[channel];
        // The difference of the ends may not be a number that f32 holds.
        let share = (f64::from(value.clamp(low, high)) - f64::from(low)) / (f64::from(high) - f64::from(low));
        let at = (share * (self.size - 1) as f64) as f32;
        let index = (at as usize).min(self.size - 2);
        (index, (at - index as f32).clamp(0.0, 1.0))
    }

    fn curve(&self, channel: usize, value: f32) -> f32 {
        let (index, share) = self.place(channel, value);
        let (low, high) = (self.entries[index][channel], self.entries[index + 1][channel]);
        low * (1.0 - share) + high * share
    }

    /// Interpolates within the tetrahedron of the lattice that has the color.
    fn lattice(&self, color: [f32; 3]) -> [f32; 3] {
        let steps = [1, self.size, self.size * self.size];
        let places: [(usize, f32); 3] = std::array::from_fn(|channel| self.place(channel, color[channel]));
        let mut corner: usize = (0..3).map(|channel| places[channel].0 * steps[channel]).sum();
        // From the nearest corner to the farthest one, first along the channel that is farthest on its way.
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|a, b| places[*b].1.total_cmp(&places[*a].1));
        let mut rest = 1.0;
        let mut sum = [0.0; 3];
        for channel in order {
            let share = places[channel].1;
            add(&mut sum, self.entries[corner], rest - share);
            rest = share;
            corner += steps[channel];
        }
        add(&mut sum, self.entries[corner], rest);
        sum
    }
}

fn add(sum: &mut [f32; 3], entry: [f32; 3], weight: f32) {
    sum.iter_mut().zip(entry).for_each(|(sum, value)| *sum += weight * value);
}

impl Cube {
    /// Returns the color for a color, of which each value is a number.
    pub fn of(&self, color: [f32; 3]) -> [f32; 3] {
        let color = match &self.curves {
            Some(curves) => std::array::from_fn(|channel| curves.curve(channel, color[channel])),
            None => color,
        };
        self.lattice.as_ref().map_or(color, |lattice| lattice.lattice(color))
    }
}
