//! Onion skin: the frames before and after the shown one, mixed over it.

use super::picture::{Image, part, place};
use crate::evaluate::Result;
use crate::state::State;
use egui::{Color32, Context, Painter, Rect};
use std::sync::Arc;

/// Strengths of the frame before and the frame after. What stays the same over the frames looks the same.
const STRENGTHS: [u8; 2] = [85, 75];

/// What is shown if there is no other frame.
pub(super) const NONE: &str = "Onion skin: no other frame is ready. Step through frames, or play.";

/// Textures of both frames.
#[derive(Default)]
pub(super) struct Onion {
    images: [Image; 2],
}

/// Returns the nearest frames before and after the shown one that are ready, as they are looked at now.
fn beside(state: &State, shown: &Result) -> [Option<Arc<Result>>; 2] {
    let frames = &state.evaluated.frames;
    let is_alike = |other: &&Arc<Result>| other.display == shown.display && other.picture.kind == shown.picture.kind;
    let before = frames.range(..shown.frame).next_back().map(|(_, other)| other);
    let after = frames.range(shown.frame + 1..).next().map(|(_, other)| other);
    [before, after].map(|other| other.filter(is_alike).cloned())
}

impl Onion {
    /// Draws the frames over the picture, which lies at `rect`; returns whether there are any. `scale` is the number of
    /// screen pixels per picture pixel.
    pub(super) fn paint(
        &mut self,
        context: &Context,
        painter: &Painter,
        rect: Rect,
        scale: f32,
        state: &State,
        shown: &Result,
    ) -> bool {
        let mut any = false;
        for ((image, other), strength) in self.images.iter_mut().zip(beside(state, shown)).zip(STRENGTHS) {
            let Some(other) = other else { continue };
            any = true;
            image.upload(context, &other.screen, scale);
            let own = part(&other);
            let area = Rect::from_min_max(place(rect, own.min), place(rect, own.max));
            image.paint_tinted(painter, area, Color32::from_white_alpha(strength));
        }
        any
    }
}
