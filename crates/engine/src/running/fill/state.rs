//! A stage of a pass, with its planes over the current tile.

use super::runner::Runner;
use super::shared::ReplacedValues;
use super::tapped::Tapped;
use crate::planning::plan::Fill;
use std::cell::Cell;
use trochoid_graph::{NoBound, SharedResult, Stage, Variance};
use trochoid_image::Window;

/// A fill with its planes over the current tile.
pub(super) struct FillState<'p> {
    pub(super) fill: &'p Fill,
    /// `None` where a buffer of the caller replaces the stage.
    pub(super) stage: Option<&'p dyn Stage>,
    pub(super) taps: Option<Runner<'p>>,
    /// Planes by output and channel; empty where not wanted.
    pub(super) planes: Vec<Vec<Vec<f32>>>,
    /// The same over a part of the tile, where only that is filled.
    pub(super) part: Vec<Vec<Vec<f32>>>,
    pub(super) one_row: bool,
    /// Columns and offset for which a single row was filled last.
    pub(super) columns: Option<(i64, i64, [f64; 2])>,
    /// By port and connection: how far the image extends, and the region of it that the current tile needs.
    pub(super) images: Vec<Vec<Image>>,
    /// Pixels that the planes hold; planes of a single row hold only its columns.
    pub(super) window: Window,
    /// Pixels that the program before the stage runs over.
    pub(super) tap_window: Window,
    /// Planes of that program, if it runs again only where samples differ.
    pub(super) tapped: Tapped,
    /// Results of the first sample at the pixels where the current sample does not share them.
    pub(super) replaced: ReplacedValues,
    /// What the stage found at the first sample, for use at all samples.
    pub(super) found: Option<SharedResult>,
    /// Window needed for the current sample: everything that the planes hold, except for what was shared.
    pub(super) need: Window,
    /// Pixels of the window that count; all of them if it is empty.
    pub(super) only: Vec<bool>,
    /// Why the stage knows no bound, if it was asked for one and has none.
    pub(super) unbounded: Cell<Option<NoBound>>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Image {
    pub(super) extent: Window,
    pub(super) region: Window,
}

impl FillState<'_> {
    /// Returns the pixels that the stage itself fills: a single row or column if it does not vary along that axis.
    pub(super) fn own_window(&self, window: Window) -> Window {
        match self.fill.variance {
            Variance::Constant | Variance::Column => Window { y1: window.y0 + 1, ..window },
            Variance::Row => Window { x1: window.x0 + 1, ..window },
            Variance::Pixel => window,
        }
    }
}
