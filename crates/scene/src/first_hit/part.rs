//! Parts of cells on their way along a ray.

use super::bernstein::{Net, evaluate, split};
use super::cells::{Cell, SeaCells};
use crate::surface::OneSheet;
use fearless_simd::Simd;
use glam::{DMat2, DVec2};

/// Most steps of Newton's method on a patch before those on the sea itself, and the size of a step, relative to the part,
/// that is the last one.
const ON_PATCH: usize = 8;
const LAST: f64 = 1e-6;

/// A part of a cell, in a ray's coordinates.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Offsets aside of the ray, by its two directions.
    pub(super) aside: [Net; 2],
    /// Start and size in the cell's unit square.
    pub(super) start: [f64; 2],
    pub(super) size: [f64; 2],
    pub(super) halvings: u32,
}

impl Part {
    /// Leaves the farther half in its place, and returns the nearer one; `grows` says whether distances grow along the side
    /// that is halved.
    #[inline(always)]
    pub(super) fn halve<S: Simd>(&mut self, simd: S, along_s: bool, grows: bool) -> Self {
        let [p, q] = &mut self.aside;
        let aside = [split(simd, p, along_s, grows), split(simd, q, along_s, grows)];
        let axis = usize::from(!along_s);
        self.size[axis] *= 0.5;
        self.halvings -= 1;
        let mut start = self.start;
        let upper = if grows { &mut self.start } else { &mut start };
        upper[axis] += self.size[axis];
        Self { aside, start, size: self.size, halvings: self.halvings }
    }

    /// Returns the patch's point on the ray by Newton's method from a guess, or a place near it on the part's border. A
    /// step on the patch costs much less than one on the sea.
    #[inline(always)]
    pub(super) fn on_patch(&self, guess: [f64; 2]) -> DVec2 {
        let mut start = DVec2::from(guess).clamp(DVec2::ZERO, DVec2::ONE);
        for _ in 0..ON_PATCH {
            let [(p, by_p), (q, by_q)] = evaluate(&self.aside, start.to_array());
            let ways = DMat2::from_cols(DVec2::new(by_p[0], by_q[0]), DVec2::new(by_p[1], by_q[1]));
            let to = start - ways.inverse() * DVec2::new(p, q);
            if !to.is_finite() {
                break;
            }
            let to = to.clamp(DVec2::ZERO, DVec2::ONE);
            let moved = (to - start).abs().max_element();
            start = to;
            if moved <= LAST {
                break;
            }
        }
        start
    }

    /// Returns the place in the cell's unit square of a place in the part's.
    pub(super) fn whole(&self, local: DVec2) -> [f64; 2] {
        (DVec2::from(self.start) + DVec2::from(self.size) * local).to_array()
    }

    /// Returns the place in the part's unit square of a place in the cell's.
    pub(super) fn local(&self, whole: [f64; 2]) -> DVec2 {
        (DVec2::from(whole) - DVec2::from(self.start)) / DVec2::from(self.size)
    }

    /// Returns the part's rest points in the world.
    pub(super) fn sheet(&self, cell: &Cell, cells: &SeaCells) -> OneSheet {
        let middle = cells.axes.rest(cell.rest(self.whole(DVec2::splat(0.5))));
        OneSheet { middle, heading: cells.axes.heading, half: self.size.map(|size| cell.half * size) }
    }
}
