//! Groups of pixels of a part of a block: those that count, and those that strokes may cover.

use super::brush::Rows;
use super::planes::index;
use super::{Brush, LANES};
use std::ops::Range;
use trochoid_graph::Block;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Width and height of the parts into which a block is split, so that the sums stay in the cache; results do not depend
/// on where parts end.
pub(crate) const PART: (usize, usize) = (128, 64);

/// Groups of pixels of a row of a part, one bit each.
type Groups = u16;

/// Number of groups of a row.
pub(super) const GROUPS: usize = PART.0 / LANES;

/// Groups of a row that are listed without asking how many there are.
const FEW: usize = 4;

/// The rows and columns of a part that a stroke may cover.
#[derive(Clone, Copy)]
pub(crate) struct Spot {
    /// Index of the stroke.
    pub(crate) stroke: u32,
    /// First row and number of rows.
    rows: [u8; 2],
    groups: Groups,
}

/// Of each row of a part, the groups with pixels that count.
#[derive(Default)]
pub(crate) struct Counted {
    part: Window,
    rows: Scratch<Groups>,
}

/// Some rows of a stroke, of which the first is this row of the part.
struct Batch {
    rows: Rows,
    first: usize,
    count: usize,
}

/// A group of pixels that a stroke may cover.
#[derive(Clone, Copy, Default)]
struct Listed {
    /// Index of the batch, and the row within it.
    batch: u16,
    row: u8,
    /// Place of the group in the part.
    place: u16,
}

/// Groups of pixels that strokes may cover. They are listed for some strokes before they are painted: where a row ends is
/// known late, and to wait for it at each row would take longer than the painting.
#[derive(Default)]
pub(crate) struct Outlines {
    batches: Scratch<Batch>,
    listed: Scratch<Listed>,
    /// Of each stroke, the end of its batches, then of its groups.
    ends: Scratch<usize>,
}

/// Returns the parts that a window of a block overlaps, by row and column of parts.
pub(crate) fn parts_in(window: Window, block: Window) -> [Range<usize>; 2] {
    let range = |first: i64, end: i64, side: usize| first as usize / side..(end - 1) as usize / side + 1;
    [
        range(window.y0 - block.y0, window.y1 - block.y0, PART.1),
        range(window.x0 - block.x0, window.x1 - block.x0, PART.0),
    ]
}

/// Returns the groups from the first to the last.
#[inline(always)]
fn between(first: usize, last: usize) -> Groups {
    (Groups::MAX << first) & (Groups::MAX >> (GROUPS - 1 - last))
}

/// Lists groups.
#[inline(always)]
fn each(mut groups: Groups) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let group = groups.trailing_zeros() as usize;
            groups &= groups.wrapping_sub(1);
            (group < GROUPS).then_some(group)
        },
    )
}

impl Spot {
    /// Returns the spot of a stroke with these bounds, which overlap a part.
    pub(crate) fn of(stroke: u32, bounds: Window, part: Window) -> Self {
        let bounds = bounds.intersect(part);
        let [first, last] = [bounds.x0, bounds.x1 - 1].map(|x| (x - part.x0) as usize / LANES);
        Self { stroke, rows: [(bounds.y0 - part.y0) as u8, bounds.height() as u8], groups: between(first, last) }
    }
}

impl Counted {
    /// Finds the groups of another part that count; the memory stays.
    pub(crate) fn find(&mut self, part: Window, block: &Block<'_>) {
        self.part = part;
        self.rows.clear();
        for y in part.y0..part.y1 {
            let all = between(0, part.width().div_ceil(LANES) - 1);
            let start = index(block.window, part.x0, y);
            self.rows.push(block.only.map_or(all, |only| counted_in(&only[start..start + part.width()])));
        }
    }

    pub(crate) fn part(&self) -> Window {
        self.part
    }

    /// Returns whether any pixel counts.
    pub(crate) fn any(&self) -> bool {
        self.rows.iter().any(|groups| *groups != 0)
    }

    /// Returns whether a pixel of a spot counts.
    pub(crate) fn shows(&self, spot: Spot) -> bool {
        let [first, count] = spot.rows.map(usize::from);
        self.rows[first..first + count].iter().any(|groups| groups & spot.groups != 0)
    }

    /// Returns the rows with pixels that count, by their number from the first one.
    #[inline(always)]
    pub(crate) fn rows(&self) -> impl Iterator<Item = usize> {
        (0..self.rows.len()).filter(|row| self.rows[*row] != 0)
    }

    /// Lists the groups of a row that count.
    #[inline(always)]
    pub(crate) fn groups(&self, row: usize) -> impl Iterator<Item = usize> + use<> {
        each(self.rows[row])
    }
}

/// Returns the groups of a row with pixels that count.
fn counted_in(only: &[bool]) -> Groups {
    only.chunks(LANES).enumerate().fold(0, |groups, (group, only)| {
        groups | Groups::from(only.iter().fold(false, |any, counts| any | counts)) << group
    })
}

impl Outlines {
    /// Forgets all strokes; the memory stays.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.batches.clear();
        self.listed.clear();
        self.ends.clear();
    }

    /// Adds a stroke, given its spot and its center.
    #[inline(always)]
    pub(crate) fn push(&mut self, spot: Spot, brush: &Brush, at: [f64; 2], counted: &Counted) {
        let part = counted.part;
        let [first, count] = spot.rows.map(usize::from);
        for start in (first..first + count).step_by(LANES) {
            let count = LANES.min(first + count - start);
            let mut any = 0;
            for groups in &counted.rows[start..start + count] {
                any |= groups & spot.groups;
            }
            if any != 0 {
                let rows = brush.rows(at, part.y0 + start as i64, part.x0, part.width());
                self.batches.push(Batch { rows, first: start, count });
            }
        }
        self.ends.push(self.batches.len());
    }

    /// Lists the groups of all strokes that were added.
    #[inline(always)]
    pub(crate) fn list(&mut self, counted: &Counted) {
        let (mut batch, mut length) = (0, 0);
        for end in self.ends.iter_mut() {
            while batch < *end {
                let Batch { rows, first, count } = &self.batches[batch];
                // Room for all groups, and for those of which none was asked for.
                self.listed.resize(length + count * GROUPS + FEW, Listed::default());
                for row in 0..*count {
                    let (from, to) = (rows.from[row] as usize, rows.to[row] as usize);
                    let groups = if from < to { between(from / LANES, (to - 1) / LANES) } else { 0 };
                    let mut groups = groups & counted.rows[first + row];
                    let listed = |groups: Groups| {
                        let group = groups.trailing_zeros() as usize;
                        Listed { batch: batch as u16, row: row as u8, place: ((first + row) * GROUPS + group) as u16 }
                    };
                    let all = groups.count_ones() as usize;
                    for place in &mut self.listed[length..length + FEW] {
                        *place = listed(groups);
                        groups &= groups.wrapping_sub(1);
                    }
                    for place in FEW..all {
                        self.listed[length + place] = listed(groups);
                        groups &= groups.wrapping_sub(1);
                    }
                    length += all;
                }
                batch += 1;
            }
            *end = length;
        }
    }

    /// Returns the groups of a stroke, as places in the part and what covers them.
    #[inline(always)]
    pub(crate) fn of(&self, stroke: usize) -> impl Iterator<Item = (usize, &Rows, usize)> {
        let start = stroke.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.listed[start..self.ends[stroke]].iter().map(
            #[inline(always)]
            |listed| {
                (usize::from(listed.place), &self.batches[usize::from(listed.batch)].rows, usize::from(listed.row))
            },
        )
    }
}
