//! Rows and columns of a sea that a part of the picture sees.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use trochoid_image::Window;

use super::{Layout, Rows, Scratch};
use crate::patches::MORE_CELLS;
use crate::project::{PictureOfPart, SIDES};

/// Number of pairs of rows that one task looks at.
const PAIRS: usize = 32;
/// Number of rows and columns that are made beyond those that are seen: a ray goes on by some cells from the one that its
/// triangle names, and mixed derivatives take one more.
const BEYOND: usize = MORE_CELLS as usize + 3;

/// The parts of a row, from 0 at its first end to 1 at its second, that waves may move to where they are not beyond a side
/// of the picture, by side.
type Parts = [Option<[f64; 2]>; SIDES];

impl<L: Layout> Rows<'_, L> {
    /// Returns the rows and columns that a part of the picture needs: those between which it sees a cell, and some beyond;
    /// none if it sees nothing. `None` soon after `stop` says so.
    pub(super) fn seen_in(&self, part: Window, stop: &(dyn Fn() -> bool + Sync)) -> Option<[Range<usize>; 2]> {
        let picture = PictureOfPart::new(self.projector, part);
        let parts: Vec<Parts> = (0..self.rows).map(|row| self.parts(row, &picture)).collect();
        let tasks = (self.rows - 1).div_ceil(PAIRS);
        // The rows between the first and the last ones that are seen need no look.
        let first = (0..tasks).into_par_iter().find_map_first(|task| match stop() {
            true => Some(None),
            false => self.seen(task, &picture, &parts).next().map(Some),
        });
        let Some(first) = first else { return Some([0..0, 0..0]) };
        // From the end, so that a single thread does not look at all of them.
        let last = (0..tasks).into_par_iter().rev().find_map_first(|task| match stop() {
            true => Some(None),
            false => self.seen(task, &picture, &parts).last().map(Some),
        });
        let (first, last) = (first?, last??);
        let rows = first.saturating_sub(BEYOND)..(last + 2 + BEYOND).min(self.rows);
        Some([rows, self.columns_in(&parts[first..last + 2])])
    }

    /// Returns the parts of a row; all of it if it is not straight.
    fn parts(&self, row: usize, picture: &PictureOfPart<'_>) -> Parts {
        let eye = self.projector.position;
        let Some(ends) = self.layout.ends(row) else { return [Some([0.0, 1.0]); SIDES] };
        let spread = DVec3::new(self.sea.drift, self.sea.summit, self.sea.drift);
        picture.parts(ends.map(|[x, z]| DVec3::new(x, self.sea.level, z) - eye), spread)
    }

    /// Returns the columns that are needed of some rows: those that no side of the picture excludes in all of them, and
    /// some beyond.
    fn columns_in(&self, rows: &[Parts]) -> Range<usize> {
        let [mut from, mut to] = [0.0_f64, 1.0_f64];
        for side in 0..SIDES {
            let parts = rows.iter().filter_map(|row| row[side]);
            let [first, last] = parts.fold([1.0_f64, 0.0_f64], |all, part| [all[0].min(part[0]), all[1].max(part[1])]);
            (from, to) = (from.max(first), to.min(last));
        }
        let last = (self.columns - 1) as f64;
        let (from, to) = ((from * last).floor() as usize, (to * last).ceil() as usize);
        from.saturating_sub(BEYOND)..(to + 1 + BEYOND).min(self.columns)
    }

    /// Returns the rows of a task between which and the next ones a part of the picture sees a cell.
    fn seen(&self, task: usize, picture: &PictureOfPart<'_>, parts: &[Parts]) -> impl Iterator<Item = usize> {
        let mut scratch = Scratch::default();
        let mut known = None;
        (task * PAIRS..((task + 1) * PAIRS).min(self.rows - 1)).filter(move |&row| {
            // No wave is so high or so wide that it would be seen.
            if parts[row].iter().zip(&parts[row + 1]).any(|(above, below)| above.is_none() && below.is_none()) {
                known = None;
                return false;
            }
            let above = known.take().unwrap_or_else(|| picture.row(&self.positions(row, &mut scratch)));
            let below = picture.row(&self.positions(row + 1, &mut scratch));
            let sees = picture.sees(&above, &below);
            known = Some(below);
            sees
        })
    }
}
