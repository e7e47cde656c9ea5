//! Finds the several nearest triangles at each sample, by the raster's own rules.

use crate::edges::Edges;
use crate::project::BIN;
use crate::{Projector, Visible};
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// A triangle that a sample's ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheet {
    /// Primitive and index of its triangle, packed.
    number: u64,
    key: f64,
}

/// The nearest sheets, sorted from near to far.
pub(crate) type Sheets = [Option<Sheet>; 3];

impl Sheet {
    pub(crate) fn primitive(&self) -> u32 {
        (self.number / 2) as u32
    }

    /// Returns which of the primitive's triangles it is.
    pub(crate) fn part(&self) -> usize {
        (self.number % 2) as usize
    }

    /// Returns the planar depth, in meters.
    pub(crate) fn depth(&self, projector: &Projector) -> f64 {
        if projector.orthographic { -self.key } else { 1.0 / self.key }
    }

    /// Returns whether it is seen before another sheet; sheets at equal depth are ordered by number.
    fn precedes(&self, other: &Self) -> bool {
        self.key > other.key || (self.key == other.key && self.number < other.number)
    }
}

/// Sheets at one sample of each pixel of a window.
pub(crate) struct Field {
    window: Window,
    sheets: Scratch<Sheets>,
}

impl Field {
    pub(crate) fn at(&self, [x, y]: [i64; 2]) -> Sheets {
        let row = (y - self.window.y0) as usize * self.window.width();
        self.sheets[row + (x - self.window.x0) as usize]
    }
}

impl Visible {
    /// Finds the nearest triangles at the samples of a window, at `offset` in their pixels.
    pub(crate) fn nearest_sheets(&self, window: Window, offset: [f64; 2]) -> Field {
        let mut field = Field { window, sheets: Scratch::of([None; 3], window.area()) };
        let inside = window.intersect(Window::sized(self.projector.size[0] as u32, self.projector.size[1] as u32));
        if inside.is_empty() {
            return field;
        }
        let shift = offset.map(|part| self.raster.fix(part));
        for bin_y in inside.y0.div_euclid(BIN[1])..=(inside.y1 - 1).div_euclid(BIN[1]) {
            for bin_x in inside.x0.div_euclid(BIN[0])..=(inside.x1 - 1).div_euclid(BIN[0]) {
                let (x0, y0) = (bin_x * BIN[0], bin_y * BIN[1]);
                let part = inside.intersect(Window::new(x0, y0, x0 + BIN[0], y0 + BIN[1]));
                let bin = (bin_y * self.bins[0] + bin_x) as usize;
                for &primitive in &self.binned[self.starts[bin] as usize..self.starts[bin + 1] as usize] {
                    self.meet_all(primitive, part, shift, &mut field);
                }
            }
        }
        field
    }

    fn meet_all(&self, primitive: u32, part: Window, shift: [i64; 2], field: &mut Field) {
        let index = self.layer(primitive);
        let layer = &self.layers[index];
        let bits = self.raster.bits;
        let triangles = layer.triangles((primitive - self.firsts[index]) as usize);
        for (which, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|vertex| layer.screen[vertex as usize]);
            let range = |of: [i32; 3], shift: i64, low: i64, high: i64| {
                let [least, most] = [of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2])].map(i64::from);
                ((least - shift) >> bits).max(low)..(((most - shift) >> bits) + 1).min(high)
            };
            let columns = range(corners.map(|corner| corner.x), shift[0], part.x0, part.x1);
            let rows = range(corners.map(|corner| corner.y), shift[1], part.y0, part.y1);
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            let Some(edges) = Edges::<i64>::new(corners, [columns.start, rows.start].map(|at| at << bits)) else {
                continue;
            };
            for y in rows.clone() {
                for x in columns.clone() {
                    let from = |at: i64, start: i64, shift: i64| ((at - start) << bits) + shift;
                    let change = edges.change(from(x, columns.start, shift[0]), from(y, rows.start, shift[1]));
                    let at = [0, 1, 2].map(|edge| edges.first[edge] + change[edge]);
                    if Edges::inside(at) < 0 {
                        continue;
                    }
                    let sheet = Sheet { number: u64::from(primitive) * 2 + which as u64, key: edges.key(at) };
                    let place = (y - field.window.y0) as usize * field.window.width() + (x - field.window.x0) as usize;
                    let sheets = &mut field.sheets[place];
                    let behind = |other: &Option<Sheet>| other.is_none_or(|other| sheet.precedes(&other));
                    if let Some(at) = sheets.iter().position(behind) {
                        sheets[at..].rotate_right(1);
                        sheets[at] = Some(sheet);
                    }
                }
            }
        }
    }
}
