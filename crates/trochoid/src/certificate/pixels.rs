//! Checks of one output: of what is said about all of its pixels, and of single ones.

use super::bounds::{PictureBounds, groups, of_channels};
use super::color::Coding;
use super::counts::{Palette, counts, stored};
use super::failed_claim::FailedClaim;
use super::image::{StoredChannel, StoredImage};
use super::make::{controls_of, stored_channels, unbounded_of};
use super::*;
use trochoid_engine::{CertifiedPixels, Hull, ReferencePixel};
use trochoid_graph::{CheckedGraph, Kind, LITERAL};
use trochoid_image::{Rgb, Window};
use trochoid_io::FileKind;

/// Maximum number of pixels that are named for each kind of failure.
const NAMED: u64 = 5;
/// Tolerance for f64 sums of weights.
const SUM: f64 = 1e-9;

/// Output of a certificate with consistent numbers, whose pixels are to be checked.
pub(super) struct OutputCheck<'c> {
    written: &'c CertifiedOutput,
    graph: &'c CheckedGraph,
    kind: Kind,
    window: Window,
    /// Bounds that the certificate states.
    stated: PictureBounds,
    channels: Vec<&'c StoredChannel>,
    coding: Coding,
    /// Hull of the controls, if all colors are said to lie in it.
    palette: Option<Palette>,
    /// Words after bounds that this version derives, if another one is said to have made the certificate.
    other_version: String,
    findings: Findings,
    /// By kind.
    faults: [PixelFaults; 6],
}

/// Kinds of failures at pixels.
#[derive(Clone, Copy)]
enum Fault {
    Ambiguity,
    Bound,
    Value,
    Error,
    Weights,
    Hull,
}

impl Fault {
    /// Names of the kinds, as places in a certificate.
    const NAMES: [&str; 6] = ["error.ambiguous", "error.channels", "values", "error", "weights", "hull"];
}

/// Failures of one kind: the first few with their pixels, the others as a count.
#[derive(Default)]
struct PixelFaults {
    named: Vec<FailedClaim>,
    count: u64,
}

impl<'c> OutputCheck<'c> {
    /// Checks that what is said about all pixels follows from the maps of bounds and from the image; `None` if the
    /// pixels cannot be checked.
    pub(super) fn new(
        found: &mut Verification,
        certificate: &'c Certificate,
        written: &'c CertifiedOutput,
        graph: &'c CheckedGraph,
        index: usize,
        image: &'c StoredImage,
    ) -> Option<Self> {
        let spec = &graph.outputs()[index];
        let place = |field: &str| format!("output \"{}\", {field}", written.name);
        let window = graph.format().window();
        let bounds = match PictureBounds::decode(&written.error, spec.kind, window) {
            Ok(bounds) => bounds,
            Err(why) => {
                let (pixels, maps) = (window.area(), groups(spec.kind).len());
                found.fail(place("error"), why, format!("{maps} maps of {pixels} pixels, in base64"));
                return None;
            }
        };
        // Missing channels have been reported already, and no pixels are checked then.
        let channels = stored_channels(image, &written.channels)?;
        if channels.len() != spec.kind.channels() || image.window != window {
            return None;
        }
        let coding = Coding::new(spec.kind, graph.space(), image.kind == FileKind::Png);
        let error = &written.error;
        let expected = bounds.described(spec, graph.space(), coding, &channels);
        found.same(place("error.unit"), &error.unit, &expected.unit);
        found.same(place("error.ambiguous.pixels"), &error.ambiguous.pixels, &expected.ambiguous.pixels);
        for (index, (written, expected)) in error.channels.iter().zip(&expected.channels).enumerate() {
            let place = |field: &str| place(&format!("error.channels[{index}].{field}"));
            found.same(place("names"), &written.names, &expected.names);
            found.same(place("all"), &written.all, &expected.all);
            found.same(place("clear"), &written.clear, &expected.clear);
        }
        let parts = |display: &Option<DisplayBounds>| {
            let DisplayBounds { all, clear, unit } = display.clone()?;
            Some((all, clear, unit))
        };
        let [now, then] = [&error.display, &expected.display].map(parts);
        found.same(place("error.display.all"), &now.as_ref().map(|d| d.0), &then.as_ref().map(|d| d.0));
        found.same(place("error.display.clear"), &now.as_ref().map(|d| d.1), &then.as_ref().map(|d| d.1));
        found.same(place("error.display.unit"), &now.map(|d| d.2), &then.map(|d| d.2));
        let other_version = match &certificate.trochoid {
            version if version == crate::VERSION => String::new(),
            version => format!(
                ", as Trochoid {} derives it; the certificate says that Trochoid {version} made it: check it with that \
                 version, or make it anew",
                crate::VERSION
            ),
        };
        let findings = Findings {
            output: written.name.clone(),
            looked_at: 0,
            pixels: window.area() as u64,
            ambiguous: 0,
            given_up: 0,
            hull: false,
            distance: 0.0,
            distance_ambiguous: 0.0,
            weight_min: f64::INFINITY,
            weight_sum_max_deviation: 0.0,
        };
        Some(Self {
            written,
            graph,
            kind: spec.kind,
            window,
            stated: bounds,
            channels,
            coding,
            palette: None,
            other_version,
            findings,
            faults: Default::default(),
        })
    }

    pub(super) fn name(&self) -> &'c str {
        &self.written.name
    }

    /// Returns the pixels that the certificate names.
    pub(super) fn named(&self) -> Vec<usize> {
        let error = &self.written.error;
        let channels = error.channels.iter().flat_map(|channel| [channel.all, channel.clear]);
        let display = error.display.iter().flat_map(|display| [display.all, display.clear]);
        let named = channels.chain(display).flat_map(|summary| [summary.max, summary.p999]).flatten();
        // They lie in the picture, since they were found to be those that follow from the maps.
        let index = |at: BoundAt| {
            let [x, y] = [at.pixel[0] - self.window.x0, at.pixel[1] - self.window.y0];
            y as usize * self.window.width() + x as usize
        };
        named.map(index).collect()
    }

    /// Checks what holds for all pixels: control colors, by what a certification and by what the references found, stages
    /// without bounds, and counts.
    pub(super) fn whole(&mut self, found: &mut Verification, derived: &CertifiedPixels, controls: &[Rgb]) {
        let place = |field: &str| format!("output \"{}\", {field}", self.written.name);
        let unbounded = unbounded_of(self.graph, &derived.unbounded);
        found.same(place("unbounded"), &self.written.unbounded, &unbounded);
        let is_color = self.kind == Kind::Color;
        let palette = is_color.then(|| Palette::new(&derived.palette, derived.margin));
        let hull = Hull::new(controls);
        for corners in [&derived.palette[..], hull.vertices()] {
            let expected = is_color.then(|| controls_of(corners, derived.margin));
            found.same(place("controls"), &self.written.controls, &expected);
        }
        let counts = counts(self.kind, self.coding, &self.channels, palette.as_ref());
        found.same(place("counts"), &self.written.counts, &counts);
        let is_held = self.written.guarantee.as_ref().is_some_and(|guarantee| guarantee.held.is_some());
        self.palette = palette.filter(|_| is_held);
        self.findings.hull = self.palette.is_some();
    }

    /// Checks a pixel, given what was derived of it, at an index, and its reference, unless that was given up.
    pub(super) fn pixel(
        &mut self,
        pixel: usize,
        index: usize,
        derived: &CertifiedPixels,
        reference: Option<&ReferencePixel>,
    ) {
        let ambiguous = derived.doubt[index] > 0.0;
        self.findings.ambiguous += u64::from(ambiguous);
        if ambiguous != self.stated.is_ambiguous(pixel) {
            let words = |ambiguous: bool| if ambiguous { "ambiguous" } else { "not ambiguous" };
            self.fail(Fault::Ambiguity, pixel, |check| {
                [words(!ambiguous).into(), format!("{}{}", words(ambiguous), check.other_version)]
            });
        }
        let errors: Vec<f64> = derived.errors.iter().map(|channel| f64::from(channel[index])).collect();
        self.bounds(pixel, index, derived);
        let values: Vec<f32> = derived.values.iter().map(|channel| channel[index]).collect();
        self.value(pixel, &values, reference);
        self.hull(pixel, &values, reference);
        match reference {
            Some(reference) => {
                self.error(pixel, &errors, ambiguous, reference);
                self.weights(pixel, reference);
            }
            None if ambiguous => self.findings.given_up += 1,
            None => self.fail(Fault::Error, pixel, |_| {
                ["a surface too rough for its reference".into(), "a reference, because it is not ambiguous".into()]
            }),
        }
    }

    /// Adds what all pixels together failed at, and returns what was found.
    pub(super) fn conclude(self, found: &mut Verification, looked_at: usize) -> Findings {
        for (PixelFaults { named, count }, of) in self.faults.into_iter().zip(Fault::NAMES) {
            found.failures.extend(named);
            if count > NAMED {
                let place = format!("output \"{}\", {of}", self.written.name);
                found.fail(place, format!("{} more pixels that fail in this way", count - NAMED), "none");
            }
        }
        Findings { looked_at: looked_at as u64, ..self.findings }
    }

    /// Adds a failure at a pixel: what was found, and what was expected.
    fn fail(&mut self, kind: Fault, pixel: usize, words: impl FnOnce(&Self) -> [String; 2]) {
        self.faults[kind as usize].count += 1;
        if self.faults[kind as usize].count <= NAMED {
            let [found, expected] = words(self);
            let width = self.window.width();
            let (x, y) = (self.window.x0 + (pixel % width) as i64, self.window.y0 + (pixel / width) as i64);
            let place = format!("output \"{}\", pixel ({x}, {y})", self.written.name);
            self.faults[kind as usize].named.push(FailedClaim { place, found, expected });
        }
    }

    /// Returns the stored samples of a pixel, for messages.
    fn samples(&self, pixel: usize) -> Vec<f32> {
        self.channels.iter().map(|channel| channel.plane.samples()[pixel]).collect()
    }

    /// Returns whether a stored pixel is the rounded form of values whose channels lie within these errors.
    fn is_within(&self, pixel: usize, values: &[f64], errors: &[f64]) -> bool {
        let ends = self.coding.ends(values, errors);
        // False for NaN.
        let mut pairs = stored(&self.channels, pixel).into_iter().zip(ends);
        pairs.all(|((low, high), (least, largest))| least <= high && low <= largest)
    }

    /// Checks the stated bounds of a pixel: neither smaller nor larger than they are.
    fn bounds(&mut self, pixel: usize, index: usize, derived: &CertifiedPixels) {
        for (map, group) in groups(self.kind).into_iter().enumerate() {
            let infinite = derived.infinite.get(group.clone()).unwrap_or_default();
            let bound = of_channels(&derived.errors[group], infinite, index);
            let (stated, expected) = (self.stated.maps()[map].at(pixel), self.stated.maps()[map].rounded(bound));
            if stated != expected {
                self.fail(Fault::Bound, pixel, |check| {
                    [stated.to_string(), format!("{expected}{}", check.other_version)]
                });
            }
        }
    }

    /// Checks that the file holds the picture's own value, or that of the reference.
    fn value(&mut self, pixel: usize, values: &[f32], reference: Option<&ReferencePixel>) {
        let exact = vec![0.0; values.len()];
        let own: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        // A picture may have been rendered by the references.
        let rounded = |reference: &ReferencePixel| -> Vec<f64> {
            reference.value.iter().map(|value| f64::from(*value as f32)).collect()
        };
        let is_reference = || reference.is_some_and(|known| self.is_within(pixel, &rounded(known), &exact));
        if !self.is_within(pixel, &own, &exact) && !is_reference() {
            self.fail(Fault::Value, pixel, |check| {
                let expected = format!("{:?}, the rounded form of {values:?}", check.middle(&own));
                [format!("{:?}", check.samples(pixel)), format!("{expected}{}", check.other_version)]
            });
        }
    }

    /// Returns the middle of the ranges in which a file stores values.
    fn middle(&self, values: &[f64]) -> Vec<f64> {
        let ends = self.coding.ends(values, &vec![0.0; values.len()]);
        ends.iter().map(|(low, high)| if low == high { *low } else { 0.5 * (low + high) }).collect()
    }

    /// Compares a pixel with its reference.
    fn error(&mut self, pixel: usize, errors: &[f64], ambiguous: bool, reference: &ReferencePixel) {
        if !self.is_within(pixel, &reference.value, errors) {
            self.fail(Fault::Error, pixel, |check| {
                let expected = check.middle(&reference.value);
                let most = errors.iter().copied().fold(0.0, f64::max);
                [
                    format!("{:?}", check.samples(pixel)),
                    format!("{expected:?} by the references, within the certified {most:e}"),
                ]
            });
        }
        let exact = self.coding.ends(&reference.value, &vec![0.0; errors.len()]);
        let apart = stored(&self.channels, pixel).into_iter().zip(exact).map(|((low, high), (least, largest))| {
            // The difference of infinities is undefined: they must be equal.
            if low == least && high == largest { 0.0 } else { (low - largest).max(least - high).max(0.0) }
        });
        let distance = apart.fold(0.0, f64::max);
        let findings = &mut self.findings;
        let largest = if ambiguous { &mut findings.distance_ambiguous } else { &mut findings.distance };
        *largest = largest.max(distance);
    }

    /// Checks the weights of all nodes in the references; those in the file are counted.
    fn weights(&mut self, pixel: usize, reference: &ReferencePixel) {
        let (least, off) = (reference.weight_min, reference.weight_sum_max_deviation);
        self.findings.weight_min = self.findings.weight_min.min(least);
        self.findings.weight_sum_max_deviation = self.findings.weight_sum_max_deviation.max(off);
        if least < -SUM || off > SUM {
            let found = format!("a weight of {least:e}, and a sum off by {off:e}, in the references");
            self.fail(Fault::Weights, pixel, |_| [found, "weights of 0 or more that sum to 1".into()]);
        }
    }

    /// Checks that a color lies in the hull, and so does its reference; colors in the file are counted.
    fn hull(&mut self, pixel: usize, values: &[f32], reference: Option<&ReferencePixel>) {
        let Some(Palette { hull, margin }) = &self.palette else { return };
        let [r, g, b] = values else { return };
        if let Some(distance) = hull.exit(&[*r, *g, *b], *margin) {
            let found = format!("{values:?}, {distance:e} outside the hull");
            self.fail(Fault::Hull, pixel, |_| [found, "no color outside the hull".into()]);
            return;
        }
        let Some(ReferencePixel { value, .. }) = reference else { return };
        let [x, y, z] = value[..] else { return };
        // Literals are rounded in the hull, but not in the references.
        let largest = hull.vertices().iter().flatten().fold(0.0, |most: f64, v| most.max(f64::from(v.abs())));
        let distance = hull.signed_distance([x, y, z]);
        if distance > margin + 4.0 * LITERAL * largest {
            let found = format!("the reference {value:?}, {distance:e} outside the hull");
            self.fail(Fault::Hull, pixel, |_| [found, "no color outside the hull".into()]);
        }
    }
}
