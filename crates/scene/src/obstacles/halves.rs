//! Groups of neighboring parts, divided where rays are expected to do the least work.

use super::bounds::Bounds;
use super::facets::Part;
use super::tree::CHILDREN;
use rayon::prelude::*;

/// Number of bins along each axis.
const BINS: usize = 16;
/// Number of parts from which on they are counted on all cores.
const MANY: usize = 1 << 14;

/// Parts that lie next to each other in their list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) start: usize,
    pub(super) end: usize,
    /// Number of triangles.
    pub(super) count: u32,
    pub(super) bounds: Bounds,
}

/// Parts whose middles lie between two planes.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

/// Bins along each axis.
type Bins = [[Bin; BINS]; 3];

/// A place between two bins.
struct Cut {
    axis: usize,
    /// Number of bins before it.
    bins: usize,
    halves: [Bin; 2],
}

/// Turns the middle of a part into its bins.
struct Ruler {
    low: [f32; 3],
    scale: [f32; 3],
}

impl Group {
    pub(super) fn of(parts: &[Part]) -> Self {
        let Bin { bounds, count } = parts.iter().fold(Bin::EMPTY, |bin, part| bin.with(Bin::of(part)));
        Self { start: 0, end: parts.len(), count, bounds }
    }

    /// Divides the group in two, and sorts its parts so. Divides it in the middle of the list if `evenly`, or if no plane
    /// separates its parts.
    ///
    /// # Panics
    /// It has less than two parts.
    pub(super) fn halves(&self, parts: &mut [Part], evenly: bool) -> [Self; 2] {
        let own = &mut parts[self.start..self.end];
        let ruler = Ruler::of(own);
        let cut = if evenly { None } else { cheapest(&ruler.bins(own)) };
        let [first, second] = match cut {
            Some(cut) => {
                let mut before = 0;
                for index in 0..own.len() {
                    if ruler.places(&own[index])[cut.axis] < cut.bins {
                        own.swap(index, before);
                        before += 1;
                    }
                }
                let middle = self.start + before;
                let [a, b] = cut.halves;
                [(self.start, middle, a), (middle, self.end, b)]
            }
            None => {
                let (a, b) = own.split_at(own.len() / 2);
                let middle = self.start + a.len();
                let all = |parts: &[Part]| parts.iter().fold(Bin::EMPTY, |bin, part| bin.with(Bin::of(part)));
                [(self.start, middle, all(a)), (middle, self.end, all(b))]
            }
        };
        [first, second].map(|(start, end, Bin { bounds, count })| Self { start, end, count, bounds })
    }
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::NOTHING, count: 0 };

    fn of(part: &Part) -> Self {
        Self { bounds: part.bounds, count: part.count }
    }

    fn with(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// Returns the expected work of rays that are equally likely to come from anywhere: they meet a box in proportion to
    /// its surface, and then look at as many nodes as its triangles fill.
    fn cost(&self) -> f64 {
        self.bounds.area() * f64::from(self.count.div_ceil(CHILDREN as u32))
    }
}

impl Ruler {
    fn of(parts: &[Part]) -> Self {
        let middles = |parts: &[Part]| Bounds::of(parts.iter().map(|part| part.bounds.middle()));
        let all = if parts.len() < MANY {
            middles(parts)
        } else {
            parts.par_chunks(MANY / 2).map(middles).reduce(|| Bounds::NOTHING, Bounds::union)
        };
        let scale = (all.high - all.low).map(|size| if size > 0.0 { BINS as f32 / size } else { 0.0 });
        Self { low: all.low.to_array(), scale: scale.to_array() }
    }

    /// Returns the bins of a part along each axis.
    #[inline(always)]
    fn places(&self, part: &Part) -> [usize; 3] {
        let middle = part.bounds.middle().to_array();
        // What is not a number, because a scale overflows, becomes 0.
        std::array::from_fn(|axis| (((middle[axis] - self.low[axis]) * self.scale[axis]) as usize).min(BINS - 1))
    }

    fn bins(&self, parts: &[Part]) -> Bins {
        const EMPTY: Bins = [[Bin::EMPTY; BINS]; 3];
        let count = |parts: &[Part]| {
            let mut bins = EMPTY;
            for part in parts {
                for (bins, place) in bins.iter_mut().zip(self.places(part)) {
                    bins[place] = bins[place].with(Bin::of(part));
                }
            }
            bins
        };
        if parts.len() < MANY {
            return count(parts);
        }
        // Minima, maxima and sums of whole numbers are the same in any order.
        parts.par_chunks(MANY / 2).map(count).reduce(
            || EMPTY,
            |mut a, b| {
                a.as_flattened_mut().iter_mut().zip(b.as_flattened()).for_each(|(a, b)| *a = a.with(*b));
                a
            },
        )
    }
}

/// Returns the cut with the least expected work; `None` if all parts are in one bin.
fn cheapest(bins: &Bins) -> Option<Cut> {
    let mut best: Option<(f64, Cut)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut after = [Bin::EMPTY; BINS];
        for place in (1..BINS).rev() {
            after[place - 1] = bins[place].with(after[place]);
        }
        let mut before = Bin::EMPTY;
        for place in 0..BINS - 1 {
            before = before.with(bins[place]);
            let halves = [before, after[place]];
            if halves.iter().any(|half| half.count == 0) {
                continue;
            }
            let cost = halves[0].cost() + halves[1].cost();
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, Cut { axis, bins: place + 1, halves }));
            }
        }
    }
    best.map(|(_, cut)| cut)
}
