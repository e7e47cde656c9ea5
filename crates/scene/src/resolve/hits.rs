//! Sorts samples by the surfaces that they see.

use std::ops::Range;

use super::{BLOCK, Lanes};
use crate::project::Layer;
use crate::raster::{NOTHING, Row, SeenTriangle};
use crate::surface::{Between, Topology};
use crate::{ChannelSet, Targets, Visible};

/// Adjacent samples that are sorted at once if they see the same surface.
const TOGETHER: usize = 8;

/// Samples that see triangles of one surface.
pub(super) struct Hits {
    pub(super) count: usize,
    /// Indices of the samples in the planes, in ascending order.
    pub(super) places: [u32; BLOCK],
    /// Vertices of the triangles, by corner.
    pub(super) corners: [[u32; BLOCK]; 3],
    /// Cells of a grid, and which of their triangles are seen, also if they were clipped.
    pub(super) rows: [u32; BLOCK],
    pub(super) columns: [u32; BLOCK],
    pub(super) parts: [u32; BLOCK],
    /// Positions within the picture.
    pub(super) x: Lanes,
    pub(super) y: Lanes,
}

impl Default for Hits {
    fn default() -> Self {
        let (none, nowhere) = ([0; BLOCK], [0.0; BLOCK]);
        Self {
            count: 0,
            places: none,
            corners: [none; 3],
            rows: none,
            columns: none,
            parts: none,
            x: nowhere,
            y: nowhere,
        }
    }
}

/// Sorts samples by the surfaces that they see.
pub(super) struct Sorter<'a, 's, R> {
    visible: &'a Visible,
    rows: R,
    offset: [f64; 2],
    /// The row that is being sorted, and its next sample.
    row: Option<Row<'s>>,
    column: usize,
    /// The surface that the last sample saw, and its primitives.
    surface: usize,
    primitives: Range<u32>,
    /// If these are cells of a grid: its number of columns of vertices, and packed triangles of cells that were not clipped.
    cells: Option<(u32, Range<u64>)>,
}

/// Returns the number of columns of vertices of a grid, and a range of packed triangles: those of its whole cells.
fn whole_cells(layer: &Layer, first: u32) -> Option<(u32, Range<u64>)> {
    let &Topology::Grid { columns, .. } = &layer.mesh.topology else { return None };
    let start = |primitive: u32| SeenTriangle { primitive, part: 0, row: 0 }.pack();
    Some((columns as u32, start(first)..start(first + layer.primitives as u32)))
}

impl Hits {
    /// Returns the samples if they are adjacent.
    #[inline(always)]
    pub(super) fn run(&self) -> Option<Range<usize>> {
        let (first, last) = (self.places[0] as usize, self.places[self.count - 1] as usize);
        (last - first == self.count - 1).then_some(first..last + 1)
    }

    /// Adds [`TOGETHER`] adjacent samples that see whole cells of a grid, given the packed triangles, the first primitive of
    /// their layer, and the number of columns of vertices: what [`push`](Self::push) does one by one.
    #[inline(always)]
    fn push_cells(&mut self, place: usize, [x, y]: [f64; 2], numbers: &[u64; TOGETHER], first: u32, columns: u32) {
        let lanes = self.count..self.count + TOGETHER;
        self.count += TOGETHER;
        let [mut places, mut rows, mut in_columns, mut parts] = [[0; TOGETHER]; 4];
        let mut corners = [[0; TOGETHER]; 3];
        let mut across = [0.0; TOGETHER];
        for lane in 0..TOGETHER {
            let SeenTriangle { primitive, part, row } = SeenTriangle::unpack(numbers[lane]);
            let column = primitive - first - row * (columns - 1);
            let a = row * columns + column;
            places[lane] = (place + lane) as u32;
            (rows[lane], in_columns[lane], parts[lane]) = (row, column, part);
            corners[0][lane] = a + part;
            corners[1][lane] = a + 1 + part * columns;
            corners[2][lane] = a + columns;
            across[lane] = x + lane as f64;
        }
        self.places[lanes.clone()].copy_from_slice(&places);
        self.rows[lanes.clone()].copy_from_slice(&rows);
        self.columns[lanes.clone()].copy_from_slice(&in_columns);
        self.parts[lanes.clone()].copy_from_slice(&parts);
        for corner in 0..3 {
            self.corners[corner][lanes.clone()].copy_from_slice(&corners[corner]);
        }
        self.x[lanes.clone()].copy_from_slice(&across);
        self.y[lanes].fill(y);
    }

    /// Adds a sample that sees a triangle of a layer.
    #[inline(always)]
    fn push(&mut self, place: usize, pixel: [f64; 2], layer: &Layer, local: usize, seen: SeenTriangle) {
        let lane = self.count;
        self.count += 1;
        self.places[lane] = place as u32;
        [self.x[lane], self.y[lane]] = pixel;
        let is_whole = local < layer.primitives;
        let corners = match &layer.mesh.topology {
            Topology::Triangles(triangles) if is_whole => triangles[local],
            &Topology::Grid { columns, .. } if is_whole || matches!(layer.mesh.between, Between::Patches(_)) => {
                let cells = columns as u32 - 1;
                // A patch is met from the whole triangle: its cell is that of the triangle's corners.
                let (row, column, part) = if is_whole {
                    (seen.row, local as u32 - seen.row * cells, seen.part)
                } else {
                    let (primitive, part) = layer.origin(local);
                    (primitive / cells, primitive % cells, part)
                };
                (self.rows[lane], self.columns[lane], self.parts[lane]) = (row, column, part);
                let (a, columns) = (row * columns as u32 + column, columns as u32);
                // As in `cell_corners`; an index into what was just written would wait for it.
                [a + part, a + 1 + part * columns, a + columns]
            }
            _ => layer.clipped[local - layer.primitives],
        };
        for corner in 0..3 {
            self.corners[corner][lane] = corners[corner];
        }
    }
}

impl<'a, 's, R: Iterator<Item = Row<'s>>> Sorter<'a, 's, R> {
    pub(super) fn new(visible: &'a Visible, rows: R, offset: [f64; 2]) -> Self {
        Self { visible, rows, offset, row: None, column: 0, surface: 0, primitives: 0..0, cells: None }
    }

    /// Sorts samples until there are enough hits of one surface for a block, and returns this surface; in the end, any
    /// surface of which some hits are left. Writes the background where there is no triangle.
    #[inline(always)]
    pub(super) fn next(&mut self, waiting: &mut [Hits], wanted: ChannelSet, out: &mut Targets<'_>) -> Option<usize> {
        loop {
            if self.row.as_ref().is_none_or(|row| self.column == row.len) {
                (self.row, self.column) = (self.rows.next(), 0);
            }
            let Some(row) = &self.row else {
                return waiting.iter().position(|hits| hits.count > 0);
            };
            let y = row.y as f64 + self.offset[1];
            while self.column < row.len {
                if let Some((columns, ref cells)) = self.cells
                    && let hits = &mut waiting[self.surface]
                    && hits.count + TOGETHER <= BLOCK
                    && let Some(numbers) = row.adjacent::<TOGETHER>(self.column)
                    && numbers.iter().fold(true, |all, number| all & cells.contains(number))
                {
                    let pixel = [row.x(self.column) as f64 + self.offset[0], y];
                    hits.push_cells(row.first + self.column, pixel, &numbers, self.primitives.start, columns);
                    self.column += TOGETHER;
                    if hits.count == BLOCK {
                        return Some(self.surface);
                    }
                    continue;
                }
                let (column, number) = (self.column, row.triangle(self.column));
                if number == NOTHING {
                    let end = (column..row.len).find(|column| row.triangle(*column) != NOTHING);
                    self.column = end.unwrap_or(row.len);
                    for channel in wanted.iter() {
                        out.all(channel)[row.first + column..row.first + self.column].fill(channel.background());
                    }
                    continue;
                }
                self.column += 1;
                let seen = SeenTriangle::unpack(number);
                if !self.primitives.contains(&seen.primitive) {
                    self.surface = self.visible.layer(seen.primitive);
                    let firsts = &self.visible.firsts[self.surface..];
                    self.primitives = firsts[0]..firsts.get(1).copied().unwrap_or(u32::MAX);
                    self.cells = whole_cells(&self.visible.layers[self.surface], self.primitives.start);
                }
                let pixel = [row.x(column) as f64 + self.offset[0], y];
                let (hits, layer) = (&mut waiting[self.surface], &self.visible.layers[self.surface]);
                let local = (seen.primitive - self.primitives.start) as usize;
                hits.push(row.first + column, pixel, layer, local, seen);
                if hits.count == BLOCK {
                    return Some(self.surface);
                }
            }
        }
    }
}
