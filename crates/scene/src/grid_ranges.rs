//! Ranges of a height field over its cells, by which rays skip what they pass above or below.

use crate::GridSurface;
use crate::grid_values::Number;

/// Numbers of cells along each side of a block, from large to small blocks.
pub(crate) const SIZES: [usize; 2] = [16, 4];
/// Rounding of heights in a ray's coordinates, and of control points, relative to their size.
const ROUNDING: f64 = 1e-9;

/// Least and greatest heights over a level, in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// The same, rounded outward: half the memory.
#[derive(Clone, Copy, Debug)]
struct Stored([f32; 2]);

impl Stored {
    fn of(range: Range) -> Self {
        Self([(range.low as f32).next_down(), (range.high as f32).next_up()])
    }

    #[inline]
    fn range(self) -> Range {
        let [low, high] = self.0.map(f64::from);
        Range { low, high }
    }
}

impl Range {
    const NONE: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns whether all heights from one to the other are beyond the range.
    pub(crate) fn misses(self, [from, to]: [f64; 2]) -> bool {
        from.min(to) > self.high || from.max(to) < self.low
    }
}

/// Returns the Bézier control points of the Catmull–Rom interpolation between the inner two of four neighbors.
#[inline]
fn controls([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [b, b + (c - a) / 6.0, c - (d - b) / 6.0, c]
}

/// Ranges of all cells, and of blocks of cells of each of the [`SIZES`].
#[derive(Debug)]
pub(crate) struct Ranges {
    columns: usize,
    cells: Vec<Stored>,
    blocks: [Vec<Stored>; SIZES.len()],
}

impl Ranges {
    pub(crate) fn new<T: Number>(grid: &GridSurface<T>) -> Self {
        let [columns, rows] = grid.size().map(|count| count - 1);
        let range = |[i, j]: [usize; 2]| {
            // A polynomial lies within the range of its control points.
            let [a, b, c, d] = grid.neighbors([i, j]).map(controls);
            let mut all = Range::NONE;
            for (((a, b), c), d) in a.into_iter().zip(b).zip(c).zip(d) {
                for at in controls([a, b, c, d]) {
                    all = all.union(Range { low: at, high: at });
                }
            }
            let Range { low, high } = all;
            let beyond = ROUNDING * (low.abs() + high.abs());
            Range { low: low - beyond, high: high + beyond }
        };
        let cells: Vec<Range> = (0..rows).flat_map(|j| (0..columns).map(move |i| range([i, j]))).collect();
        let blocks = SIZES.map(|size| {
            let across = columns.div_ceil(size);
            let mut blocks = vec![Range::NONE; across * rows.div_ceil(size)];
            for (j, row) in cells.chunks_exact(columns).enumerate() {
                for (i, cell) in row.iter().enumerate() {
                    let block = &mut blocks[j / size * across + i / size];
                    *block = block.union(*cell);
                }
            }
            blocks.into_iter().map(Stored::of).collect()
        });
        let cells = cells.into_iter().map(Stored::of).collect();
        Self { columns, cells, blocks }
    }

    /// Returns the range of a cell.
    pub(crate) fn cell(&self, [i, j]: [usize; 2]) -> Range {
        self.cells[j * self.columns + i].range()
    }

    /// Returns the range of the block of the given one of the [`SIZES`] that contains a cell.
    #[inline]
    pub(crate) fn block(&self, level: usize, [i, j]: [usize; 2]) -> Range {
        let size = SIZES[level];
        self.blocks[level][j / size * self.columns.div_ceil(size) + i / size].range()
    }
}
