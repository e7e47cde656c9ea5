//! Pictures painted from recipes: while a color is dragged, a palette is compared, or a color is looked for.

use super::Editor;
use crate::actions::Tint;
use crate::document::swatches;
use crate::evaluate::{Mixture, Painted, Painting, Result, SharedRecipe};

use std::sync::Arc;

/// State of the last requests that concern recipes.
#[derive(Default)]
pub(super) struct LastPainting {
    /// Whether the recipe is needed, since the last request.
    pub(super) weighs: bool,
    /// Generation of the picture whose recipe was requested.
    pub(super) mixed: Option<u64>,
    /// The requested painting.
    what: Option<Painting>,
    /// The painting that the viewer shows.
    shown: Option<Painting>,
    /// Whether the document is being changed by the present drag, because the picture had no recipe when it began.
    writes: bool,
    /// Revision of a text whose painting stays until there is its picture.
    left: Option<u64>,
    /// Generation of the picture of which it is not known yet whether it has the recipe of an earlier text.
    sought: Option<u64>,
}

impl Editor {
    /// Requests the recipe of the viewed picture while something needs it.
    pub(super) fn ask_mixture(&mut self) {
        let generation = self.asked.generation;
        let seen = &mut self.state.evaluated;
        if seen.mixture.as_ref().is_some_and(|mixture| mixture.generation != generation) {
            seen.mixture = None;
        }
        if self.asked.what.is_some()
            && self.painting.mixed != Some(generation)
            && let Some(subject) = self.subject()
            && self.weighs()
        {
            self.worker.mix(self.job(subject, generation, self.state.frame, false));
        }
        self.painting.weighs = false;
    }

    /// Returns whether the recipe is needed of the picture that is requested now. If so, the caller requests it.
    pub(super) fn weighs(&mut self) -> bool {
        let weighs = self.painting.weighs && !self.state.playing;
        if weighs {
            self.painting.mixed = Some(self.asked.generation);
            self.painting.sought = Some(self.asked.generation);
            (self.state.evaluated.mixing, self.state.evaluated.unmixed) = (Some(0.0), None);
        }
        weighs
    }

    /// Receives the recipe of the viewed picture.
    pub(super) fn take_mixture(&mut self, mixture: Mixture) {
        self.take_unknown(mixture.generation);
        if mixture.generation == self.asked.generation {
            self.state.evaluated.mixing = None;
            self.state.evaluated.mixture = Some(Arc::new(mixture));
        }
    }

    /// Learns that the recipe of a picture must be evaluated.
    pub(super) fn take_unknown(&mut self, generation: u64) {
        if self.painting.sought == Some(generation) {
            self.painting.sought = None;
        }
    }

    /// Receives the reason that a picture has no recipe.
    pub(super) fn take_unmixed(&mut self, generation: u64, why: String) {
        if generation == self.asked.generation {
            self.state.evaluated.mixing = None;
            self.state.evaluated.unmixed = Some(why);
        }
    }

    /// Requests the painting that the viewer should show instead of the picture.
    pub(super) fn ask_painting(&mut self) {
        let wanted = self.wanted_painting();
        if wanted.is_none() && !self.is_left() {
            self.state.evaluated.painted = None;
        }
        if self.painting.what != wanted {
            self.painting.what.clone_from(&wanted);
            if let Some(painting) = wanted {
                self.painter.paint(painting);
            }
        }
    }

    /// Returns whether the viewer shows the requested painting.
    #[cfg(test)]
    pub(crate) fn is_painted(&self) -> bool {
        self.painting.what.is_some() && self.painting.what == self.painting.shown
    }

    /// Returns whether the viewer still shows what was painted before the last change: until there is the picture, or
    /// until it is known whether the picture can be painted.
    fn is_left(&self) -> bool {
        let is_left = self.painting.left == Some(self.state.session.revision());
        let is_sought = self.painting.sought == Some(self.asked.generation);
        (is_left || is_sought) && self.state.evaluated.progress.is_some()
    }

    fn wanted_painting(&self) -> Option<Painting> {
        let (seen, colors) = (&self.state.evaluated, &self.state.colors);
        let mixture = seen.mixture.as_ref().filter(|mixture| mixture.generation == self.asked.generation)?;
        let spot = colors.spot.then(|| self.state.chosen_controls()).flatten();
        let spot = spot.map(|controls| mixture.members(&controls));
        let mixed = match (&colors.tint, &colors.compared) {
            (Some(tint), _) if !self.painting.writes => mixture.with(&tint.controls, self.working(tint.color)),
            (None, Some(other)) => {
                let space = swatches::space(self.state.sheet());
                let names = mixture.names.iter().zip(&mixture.colors);
                let color = |(name, own): (&String, &[f64; 3])| {
                    let entry = other.entries.iter().find(|(other, _)| other == name);
                    entry
                        .and_then(|(_, value)| swatches::working(value, space, self.state.frame as f64))
                        .unwrap_or(*own)
                };
                names.map(color).collect()
            }
            _ if seen.progress.is_some() || spot.is_some() => mixture.colors.clone(),
            _ => return None,
        };
        Some(Painting {
            generation: mixture.generation,
            recipe: SharedRecipe(mixture.recipe.clone()),
            colors: mixed,
            spot,
            display: self.state.look.display.clone(),
        })
    }

    /// Returns a displayed color in the working space, rounded as documents store it.
    fn working(&self, color: [f32; 3]) -> [f64; 3] {
        let text = crate::document::color::hex(color).into();
        swatches::working(&text, swatches::space(self.state.sheet()), 0.0).unwrap_or_default()
    }

    /// Receives painted pictures.
    pub(super) fn hear_paintings(&mut self) {
        for Painted { painting, screen, ready } in self.painter.news() {
            let is_current = painting.generation == self.asked.generation && self.painting.what.is_some();
            let window = painting.recipe.0.window();
            let seen = &mut self.state.evaluated;
            let of_same_pixels = |result: &&Arc<Result>| result.frame == self.state.frame && result.window == window;
            if let Some(whole) = seen.whole.as_ref().filter(of_same_pixels).filter(|_| is_current) {
                seen.painted =
                    Some(Arc::new(Result { screen, display: painting.display.clone(), ..Result::clone(whole) }));
                seen.painted_at = Some(ready);
                self.painting.shown = Some(painting);
            }
        }
    }

    /// Shows a color while it is dragged: painted from the recipe, or if the picture has none, by changing the document.
    /// `None` ends the drag; what it wrote is taken back unless an edit has sealed it.
    pub(super) fn tint(&mut self, tint: Option<Tint>) {
        match tint {
            Some(tint) => {
                let is_first = self.state.colors.tint.is_none();
                if is_first {
                    let seen = &self.state.evaluated;
                    let has_recipe = |mixture: &Arc<Mixture>| {
                        mixture.generation == self.asked.generation && mixture.share(&tint.controls).is_some()
                    };
                    self.painting.writes = !seen.mixture.as_ref().is_some_and(has_recipe);
                    self.painting.left = None;
                    self.state.session.seal();
                }
                if self.painting.writes {
                    self.edit(tint.edit.clone());
                }
                self.state.colors.tint = Some(tint);
            }
            None => {
                if self.state.colors.tint.take().is_some() && std::mem::take(&mut self.painting.writes) {
                    self.take_back();
                }
            }
        }
    }

    /// Makes the edit with which a drag ends, as one step of undo.
    pub(super) fn settle_tint(&mut self, edit: crate::document::Edit) {
        let painted = self.state.colors.tint.take().is_some() && !std::mem::take(&mut self.painting.writes);
        self.edit(edit);
        self.state.session.seal();
        if painted {
            self.leave_painting();
        }
    }

    /// Keeps what is painted until there is another picture of the document as it is now.
    pub(super) fn leave_painting(&mut self) {
        self.painting.left = Some(self.state.session.revision());
    }

    /// Takes back what a cancelled drag has written.
    pub(super) fn take_back(&mut self) {
        if self.state.session.history().is_open() && self.state.session.undo().is_some() {
            self.changed();
        }
    }
}
