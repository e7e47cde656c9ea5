//! The values of nodes at places of the picture, with "Shading by the pixel" of the definitions.

use super::camera::Place;
use super::document::{Document, list};
use super::view::{Seen, View};
use serde_json::Value as Json;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// Evaluates a document from the manuals.
pub(super) struct Evaluator<'d> {
    pub(super) document: &'d Document,
    views: RefCell<HashMap<usize, Rc<View>>>,
    /// Values that are known, each with whether it is near a jump.
    known: RefCell<HashMap<Asked, (Vec<f64>, bool)>>,
    sights: RefCell<HashMap<(usize, Place), Seen>>,
    smooth: RefCell<HashMap<usize, Option<Vec<usize>>>>,
    /// Whether a value on the way was near a jump: a contour, a threshold, the edge of a stroke.
    is_near_jump: Cell<bool>,
    pub(super) counts: Counts,
}

/// A node, the word behind the dot, and a place.
type Asked = (usize, String, Place);

/// How often what the tests are about has occurred.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Samples that see something, and those of them that see an overturned part of a sea.
    pub(super) sights: Cell<u64>,
    pub(super) overturned: Cell<u64>,
    /// Values taken from first samples, and values that differ too much.
    pub(super) shared: Cell<u64>,
    pub(super) unshared: Cell<u64>,
    /// Strokes that cover a sample.
    pub(super) strokes: Cell<u64>,
}

pub(super) fn count(counter: &Cell<u64>) {
    counter.set(counter.get() + 1);
}

/// Differences that count as the same, at thresholds.
const CLOSE: f64 = 1e-6;

/// Nodes that share the value of a pixel's first sample, if their inputs are smooth.
const SHARING: [&str; 16] = [
    "Depth",
    "Height",
    "Normal",
    "Position",
    "Rest",
    "RestDistance",
    "Rift",
    "UV",
    "ObjectMask",
    "NonSpecular",
    "Specular",
    "Fresnel",
    "Sky",
    "CrestFoam",
    "FoldFoam",
    "FieldMath",
];

/// Nodes with a value of their own at each sample, from which nothing that comes from them shares.
const OWN: [&str; 6] = ["Blur", "Warp", "Strokes", "Shape", "Silhouette", "Curvature"];

impl<'d> Evaluator<'d> {
    pub(super) fn new(document: &'d Document) -> Self {
        Self {
            document,
            views: RefCell::default(),
            known: RefCell::default(),
            sights: RefCell::default(),
            smooth: RefCell::default(),
            is_near_jump: Cell::new(false),
            counts: Counts::default(),
        }
    }

    /// Returns an output at a pixel, and whether it is near a jump.
    pub(super) fn pixel(&self, output: &str, x: i64, y: i64) -> (Vec<f64>, bool) {
        let source = self.document.output(output);
        self.is_near_jump.set(false);
        let at = |sample| self.value(&source, Place { x, y, sample });
        let samples = self.document.samples;
        let mean = if self.is_field(&source) {
            at(None)
        } else {
            let all: Vec<Vec<f64>> = (0..samples).map(|sample| at(Some(sample))).collect();
            (0..all[0].len()).map(|i| all.iter().map(|value| value[i]).sum::<f64>() / samples as f64).collect()
        };
        (mean, self.is_near_jump.get())
    }

    /// Returns the first sample of an output at a pixel, and whether the pixel keeps it; `None` without adaptive sampling, or
    /// near a jump or its tolerance.
    pub(super) fn adaptive(&self, output: &str, x: i64, y: i64) -> Option<(Vec<f64>, bool)> {
        let source = self.document.output(output);
        let tolerance = self.document.adaptive.filter(|_| self.document.samples > 1 && !self.is_field(&source))?;
        self.is_near_jump.set(false);
        let first = |x: i64, y: i64| self.value(&source, Place { x, y, sample: Some(0) });
        let (own, mut farthest) = (first(x, y), 0.0_f64);
        let around: Vec<Vec<f64>> = (y - 1..=y + 1)
            .flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)))
            .filter(|(x, y)| (0..self.document.width).contains(x) && (0..self.document.height).contains(y))
            .map(|(x, y)| first(x, y).iter().map(|v| v.abs().sqrt().copysign(*v)).collect())
            .collect();
        for channel in 0..own.len() {
            let roots = || around.iter().map(|roots| roots[channel]);
            farthest = farthest.max(roots().fold(f64::MIN, f64::max) - roots().fold(f64::MAX, f64::min));
        }
        // Passes of surfaces are off by some thousandths, and thresholds enlarge that.
        let is_clear = (farthest - tolerance).abs() > 0.03 && !self.is_near_jump.get();
        is_clear.then_some((own, farthest <= tolerance))
    }

    /// Returns whether a wire carries a Field, rather than a color, a mask or Weights.
    fn is_field(&self, source: &Json) -> bool {
        const FIELDS: [&str; 10] =
            ["FieldMath", "Depth", "Position", "Normal", "Height", "Rest", "RestDistance", "Rift", "UV", "Curvature"];
        let Some((index, _)) = self.document.wire(source) else { return false };
        let node = self.document.node(index);
        match node["type"].as_str().unwrap() {
            "Blur" | "Warp" | "Strokes" => self.is_field(&node["image"]),
            kind => FIELDS.contains(&kind),
        }
    }

    /// Remembers a distance from a threshold.
    pub(super) fn threshold(&self, distance: f64) {
        self.jump(distance.abs() < CLOSE);
    }

    pub(super) fn jump(&self, is_near: bool) {
        self.is_near_jump.set(self.is_near_jump.get() | is_near);
    }

    /// Returns the numbers of a wire or literal.
    pub(super) fn value(&self, source: &Json, place: Place) -> Vec<f64> {
        let Some((index, output)) = self.document.wire(source) else { return self.document.literal(source) };
        let place = if self.shares(index, place) { place.first() } else { place };
        let key = (index, output.to_owned(), place);
        if let Some((value, is_near)) = self.known.borrow().get(&key) {
            self.jump(*is_near);
            return value.clone();
        }
        let before = self.is_near_jump.replace(false);
        let node = self.document.node(index);
        let value = self
            .pass(index, place, output)
            .or_else(|| self.filtered(node, place))
            .unwrap_or_else(|| self.mixed(node, place));
        let is_near = self.is_near_jump.replace(before);
        self.jump(is_near);
        self.known.borrow_mut().insert(key, (value.clone(), is_near));
        value
    }

    /// Returns a mask, or a field of one component: of two shares, the second is the mask.
    pub(super) fn scalar(&self, source: &Json, place: Place) -> f64 {
        *self.value(source, place).last().unwrap()
    }

    /// Returns an optional input.
    pub(super) fn scalar_or(&self, source: &Json, place: Place, default: f64) -> f64 {
        if source.is_null() { default } else { self.scalar(source, place) }
    }

    pub(super) fn view(&self, source: &Json) -> Rc<View> {
        let (index, _) = self.document.wire(source).unwrap();
        let make = || Rc::new(View::new(self.document.node(index), self.document));
        self.views.borrow_mut().entry(index).or_insert_with(make).clone()
    }

    /// Returns what a view's place sees, or the nearest place in the picture.
    pub(super) fn seen(&self, source: &Json, place: Place) -> Seen {
        let (index, _) = self.document.wire(source).unwrap();
        let place = self.document.nearest(place);
        let known = self.sights.borrow().get(&(index, place)).copied();
        let seen = known.unwrap_or_else(|| {
            let seen = self.view(source).see(self.document, place);
            if seen.is_something() {
                count(&self.counts.sights);
            }
            if seen.jacobian < 0.0 {
                count(&self.counts.overturned);
            }
            seen
        });
        self.sights.borrow_mut().insert((index, place), seen);
        self.jump(seen.is_near_contour);
        seen
    }

    /// Returns whether a sample takes a node's value from the first sample of its pixel.
    fn shares(&self, node: usize, place: Place) -> bool {
        if !self.document.shades_pixels || self.document.samples == 1 || place.sample.is_none_or(|sample| sample == 0) {
            return false;
        }
        let kind = self.document.node(node)["type"].as_str().unwrap();
        if !SHARING.contains(&kind) {
            return false;
        }
        let Some(views) = self.smooth(node) else { return false };
        let shares = views.into_iter().all(|view| self.shares_in(view, place));
        count(if shares { &self.counts.shared } else { &self.counts.unshared });
        shares
    }

    /// Returns whether a sample sees, in a view, the same surface as the first one, at nearly the same depth.
    fn shares_in(&self, view: usize, place: Place) -> bool {
        let source = Json::from(self.document.name(view));
        let [first, own] = [place.first(), place].map(|place| self.seen(&source, place));
        if own.surface != first.surface {
            return false;
        }
        if !own.is_something() {
            return true;
        }
        let excess = (own.depth - first.depth).abs() - first.depth / 64.0;
        self.threshold(excess);
        excess <= 0.0
    }

    /// Returns the views whose surfaces a node varies smoothly over; `None` if it does not.
    fn smooth(&self, index: usize) -> Option<Vec<usize>> {
        if let Some(known) = self.smooth.borrow().get(&index) {
            return known.clone();
        }
        let node = self.document.node(index);
        let views = match node["type"].as_str().unwrap() {
            "Render" => Some(vec![index]),
            kind if OWN.contains(&kind) => None,
            "Camera" | "Light" | "ScreenX" | "ScreenY" => Some(Vec::new()),
            kind => {
                let mut wires = Vec::new();
                match kind {
                    "Switch" => wires.extend(list(node, "inputs").get(node["which"].as_u64().unwrap_or(0) as usize)),
                    _ => node.as_object().unwrap().iter().filter(|(key, _)| *key != "type").for_each(|(key, value)| {
                        self.wires(key, value, &mut wires);
                    }),
                }
                let inputs = wires.into_iter().filter_map(|wire| self.document.wire(wire));
                inputs.map(|(input, _)| self.smooth(input)).collect::<Option<Vec<_>>>().map(|all| all.concat())
            }
        };
        self.smooth.borrow_mut().insert(index, views.clone());
        views
    }

    /// Collects the wires among a node's keys: texts that name a node.
    fn wires<'j>(&self, key: &str, value: &'j Json, found: &mut Vec<&'j Json>) {
        const WORDS: [&str; 6] = ["combine", "model", "cosine", "expression", "interpolation", "filter"];
        match value {
            Json::String(_) if !WORDS.contains(&key) => found.push(value),
            Json::Array(items) => items.iter().for_each(|item| self.wires(key, item, found)),
            Json::Object(items) => items.iter().for_each(|(key, item)| self.wires(key, item, found)),
            _ => {}
        }
    }
}
