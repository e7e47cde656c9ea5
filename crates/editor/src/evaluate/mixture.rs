//! Recipes of viewed pictures: the weights of their colors, which stay the same when colors change.

use super::lens::Lens;
use super::subject::Subject;
use crate::document::Path;
use crate::document::swatches::{SwatchKey, swatches};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::Arc;
use trochoid::{CheckedGraph, Kind, PackedRecipe, PaletteColor};

/// Maximum memory of a recipe, in bytes.
pub(super) const LIMIT: usize = 1 << 28;

/// The recipe of a viewed picture, with the colors of a text of the document.
#[derive(Clone, Debug)]
pub struct Mixture {
    /// Generation number of the picture.
    pub generation: u64,
    /// The weights. The recipe may be that of an earlier text, whose names and colors were others.
    pub recipe: Arc<PackedRecipe>,
    /// The names that the document has for the colors of the recipe.
    pub names: Vec<String>,
    /// The document's colors at the frame, one for each name, in the working space.
    pub colors: Vec<[f64; 3]>,
}

impl Mixture {
    /// Returns which weights of the recipe belong to these colors.
    pub fn members(&self, controls: &[String]) -> Vec<bool> {
        let names = self.names.iter().map(|name| controls.contains(name));
        names.chain(self.recipe.info().has_images.then_some(false)).collect()
    }

    /// Returns the mean weight of these colors in the picture, from 0 to 1; `None` if it has none of them.
    pub fn share(&self, controls: &[String]) -> Option<f64> {
        let members = self.members(controls);
        let own = || self.recipe.shares().iter().zip(&members).filter(|(_, is_own)| **is_own);
        own().next()?;
        Some(own().map(|(share, _)| share).sum())
    }

    /// Returns the mean weight of each color in the picture, and its weight in a pixel, by its name in the recipe.
    pub fn weights(&self, pixel: Option<[i64; 2]>) -> HashMap<&str, [f64; 2]> {
        let names = self.names.iter().map(String::as_str);
        let mut weights: Vec<[f64; 2]> = self.recipe.shares().iter().map(|share| [*share, 0.0]).collect();
        for (place, weight) in pixel.map(|[x, y]| self.recipe.at(x, y)).unwrap_or_default() {
            weights[place][1] = f64::from(weight);
        }
        names.zip(weights).collect()
    }

    /// Returns the document's colors, with others for these.
    pub fn with(&self, controls: &[String], color: [f64; 3]) -> Vec<[f64; 3]> {
        let names = self.names.iter().zip(&self.colors);
        names.map(|(name, own)| if controls.contains(name) { color } else { *own }).collect()
    }
}

/// Recipe that was made last, and what it is of.
pub(super) struct KnownRecipe {
    of: String,
    recipe: Arc<PackedRecipe>,
}

impl KnownRecipe {
    pub(super) fn new(subject: &Subject, lens: &Lens, place: &impl std::fmt::Debug, recipe: Arc<PackedRecipe>) -> Self {
        let of = structure(subject, lens, place, &recipe.info().names);
        Self { of, recipe }
    }

    pub(super) fn bytes(&self) -> usize {
        self.recipe.bytes()
    }

    /// Returns the recipe for the picture of a document whose weights are the same; `None` if they may be others.
    pub(super) fn mixture(
        &self,
        generation: u64,
        subject: &Subject,
        lens: &Lens,
        frame: i64,
        place: &impl std::fmt::Debug,
    ) -> Option<Mixture> {
        let info = PackedRecipe::describe(&lens.graph, 0, frame).ok()?;
        let is_same = info.names.len() == self.recipe.info().names.len()
            && self.of == structure(subject, lens, place, &info.names);
        is_same.then(|| Mixture { generation, recipe: self.recipe.clone(), names: info.names, colors: info.colors })
    }
}

/// Returns everything on which the weights of a picture depend: its lens without the colors that the recipe names, and
/// without what the palette calls them. `place` is the frame and the part of the picture.
fn structure(subject: &Subject, lens: &Lens, place: &impl std::fmt::Debug, names: &[String]) -> String {
    let mut value: Value = serde_json::from_str(&lens.text).unwrap_or_default();
    let used: Vec<_> = lens.graph.palette().iter().filter(|named| !named.uses.is_empty()).collect();
    for swatch in swatches(&subject.root, None, 0) {
        let known = match &swatch.key {
            SwatchKey::Named(name) => used.iter().position(|named| named.name == *name).map(Value::from),
            SwatchKey::Literal(_) => Some(Value::Null),
        };
        for (place, control) in swatch.uses.iter().zip(swatch.controls().iter().cycle()) {
            if let Some(known) = known.as_ref().filter(|known| !known.is_null() || names.contains(control))
                && let Some(color) = find(&mut value, place)
            {
                color.clone_from(known);
            }
        }
    }
    if let Some(palette) = value.get_mut("palette") {
        *palette = used.iter().map(|named| own_use(named, &lens.graph)).collect();
    }
    format!("{place:?} {value}")
}

/// Returns a color of the palette on which weights depend, because a node that makes no color has its own use for it;
/// of others nothing.
fn own_use(named: &PaletteColor, graph: &CheckedGraph) -> Value {
    let is_color = |kind: &Kind| matches!(kind, Kind::Color | Kind::Layers(_));
    let weighs = named.uses.iter().any(|used| !graph.node(used.node).kinds.iter().any(is_color));
    if weighs { json!(named.color.values().collect::<Vec<_>>()) } else { Value::Null }
}

fn find<'v>(value: &'v mut Value, path: &Path) -> Option<&'v mut Value> {
    use crate::document::Step;
    path.0.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key),
        Step::Index(index) => value.get_mut(index),
    })
}
