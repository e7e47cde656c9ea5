//! What a new window offers: templates, recent documents, and a new one.

pub(crate) mod templates;

use crate::evaluate::Screen;
use egui::{Rect, TextureHandle};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use templates::Template;

/// Something that can be chosen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Choice {
    New,
    Open,
    Recent(PathBuf),
    Template(&'static Template),
}

/// The open welcome.
pub(crate) struct Welcome {
    /// All choices, in reading order.
    pub(crate) choices: Vec<Choice>,
    /// Recent documents that are gone.
    pub(crate) gone: Vec<PathBuf>,
    /// Index of the marked choice.
    pub(crate) chosen: usize,
    /// Where the choices were drawn last.
    pub(crate) places: Vec<Rect>,
    pub(crate) pictures: HashMap<&'static str, TextureHandle>,
    /// Pictures of recent documents.
    pub(crate) seen: HashMap<PathBuf, Seen>,
}

/// The picture of a recent document.
pub(crate) enum Seen {
    Read(Screen),
    Shown(TextureHandle),
}

impl Welcome {
    /// Creates a welcome with these recent documents, whose pictures are in the folder for the program's data.
    pub(crate) fn new(recent: &[PathBuf], data: Option<&Path>) -> Self {
        let (there, gone): (Vec<PathBuf>, Vec<PathBuf>) = recent.iter().cloned().partition(|file| file.is_file());
        let picture = |file: &PathBuf| Some((file.clone(), Seen::Read(crate::recent::picture_of(data?, file)?)));
        let seen = there.iter().filter_map(picture).collect();
        let mut choices = vec![Choice::New, Choice::Open];
        choices.extend(there.into_iter().map(Choice::Recent));
        choices.extend(templates::offered().map(Choice::Template));
        Self { choices, gone, chosen: 0, places: Vec::new(), pictures: HashMap::new(), seen }
    }

    /// Marks the nearest choice in a direction, if there is one.
    pub(crate) fn step(&mut self, towards: egui::Vec2) {
        let Some(own) = self.places.get(self.chosen).map(Rect::center) else { return };
        let distance = |place: &Rect| {
            let way = place.center() - own;
            let along = way.dot(towards);
            // Whatever lies aside counts twice, so that the next one in the row or column is taken.
            (along > 1.0).then(|| along + 2.0 * (way - along * towards).length())
        };
        let near = self.places.iter().enumerate().filter_map(|(index, place)| Some((index, distance(place)?)));
        if let Some((index, _)) = near.min_by(|a, b| a.1.total_cmp(&b.1)) {
            self.chosen = index;
        }
    }
}
