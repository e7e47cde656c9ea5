//! Ranges of a height field over its cells, by which rays skip what they pass above or below.

use crate::GridSurface;
use crate::grid_values::Number;

/// Number of cells along each side of a block.
pub(crate) const BLOCK: usize = 16;
/// Share of the range of its neighbors by which a cell's interpolation may exceed it: Catmull–Rom weights sum to 1 with at
/// most ⅛ below 0 along each axis.
const BEYOND: f64 = 0.5625;
/// Rounding of heights in a ray's coordinates, relative to their size.
const ROUNDING: f64 = 1e-9;

/// Least and greatest heights over a level, in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
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

/// Ranges of all cells, and of blocks of cells.
#[derive(Debug)]
pub(crate) struct Ranges {
    columns: usize,
    cells: Vec<Range>,
    blocks: Vec<Range>,
}

impl Ranges {
    pub(crate) fn new<T: Number>(grid: &GridSurface<T>) -> Self {
        let [columns, rows] = grid.size().map(|count| count - 1);
        let range = |[i, j]: [usize; 2]| {
            let heights = grid.neighbors([i, j]);
            let all = heights.as_flattened().iter();
            let Range { low, high } = all.fold(Range::NONE, |all, &at| all.union(Range { low: at, high: at }));
            let beyond = BEYOND * (high - low) + ROUNDING * (low.abs() + high.abs());
            Range { low: low - beyond, high: high + beyond }
        };
        let cells: Vec<Range> = (0..rows).flat_map(|j| (0..columns).map(move |i| range([i, j]))).collect();
        let (across, down) = (columns.div_ceil(BLOCK), rows.div_ceil(BLOCK));
        let mut blocks = vec![Range::NONE; across * down];
        for (index, cell) in cells.iter().enumerate() {
            let block = &mut blocks[index / columns / BLOCK * across + index % columns / BLOCK];
            *block = block.union(*cell);
        }
        Self { columns, cells, blocks }
    }

    /// Returns the range of a cell.
    pub(crate) fn cell(&self, [i, j]: [usize; 2]) -> Range {
        self.cells[j * self.columns + i]
    }

    /// Returns the range of the block that contains a cell.
    pub(crate) fn block(&self, [i, j]: [usize; 2]) -> Range {
        self.blocks[j / BLOCK * self.columns.div_ceil(BLOCK) + i / BLOCK]
    }
}
