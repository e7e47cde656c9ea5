//! Reads everything outside of `palette`, `nodes` and `outputs`: version, format, working space, frames, tolerance.

use super::{Checker, FaultLocation};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Severity, Tolerance};
use trochoid_image::{Format, FormatError, MAX_PIXELS, MAX_SIDE, Shading, WorkingSpace};

/// Settings at the top of a document.
pub(super) struct Top {
    pub(super) format: Option<Format>,
    pub(super) first: i64,
    pub(super) last: i64,
    pub(super) fps: f64,
    pub(super) tolerance: Option<Tolerance>,
}

/// Version of the document format; the only one so far.
pub const FORMAT_VERSION: u32 = 1;

pub(super) const KEYS: [&str; 13] = [
    "trochoid",
    "format",
    "working_space",
    "frames",
    "tolerance",
    "palette",
    "include",
    "knobs",
    "groups",
    "nodes",
    "outputs",
    "ui",
    "notes",
];
/// Largest absolute frame number, so that times stay exact.
const MAX_FRAME: f64 = 1e7;

impl<'a> Checker<'a> {
    pub(super) fn top(&mut self, root: &[&'a Entry]) -> Top {
        let mut top = Top { format: None, first: 1, last: 1, fps: 24.0, tolerance: None };
        let mut versioned = false;
        for entry in root {
            let place = FaultLocation::top(entry.value.offset, &entry.key);
            match entry.key.as_str() {
                "trochoid" => {
                    versioned = true;
                    self.version(&entry.value, place);
                }
                "format" => top.format = self.format(&entry.value),
                "working_space" => self.working_space(&entry.value),
                "frames" => self.frames(&entry.value, &mut top),
                "tolerance" => top.tolerance = self.tolerance(&entry.value),
                "include" => self.include(&entry.value, place),
                "palette" | "nodes" | "outputs" | "ui" | "notes" => {}
                key => self.unknown_key(FaultLocation::top(entry.offset, key), key, &KEYS),
            }
        }
        if !versioned {
            let place = FaultLocation::top(0, "trochoid");
            self.error(place, "no \"trochoid\"", "the version of the document format", "add \"trochoid\": 1");
        }
        if !root.iter().any(|entry| entry.key == "format") {
            let remedy = "add \"format\": { \"width\": 1920, \"height\": 1080 }";
            self.error(FaultLocation::top(0, "format"), "no \"format\"", "the size of the pictures", remedy);
        }
        top
    }

    /// Checks the list of included documents, which are read by now.
    fn include(&mut self, value: &'a Spanned, place: FaultLocation<'a>) {
        let (expected, remedy) = ("a list of documents with groups", "write [\"lib/boats.json\"]");
        match &value.json {
            Json::Array(items) => {
                for item in items.iter().filter(|item| !matches!(&item.json, Json::String(path) if !path.is_empty())) {
                    self.error(place.at(item.offset), item.brief(), "the path of a document", remedy);
                }
            }
            _ => self.error(place, value.brief(), expected, remedy),
        }
        if let Some(unread) = self.document.next_include() {
            let found = format!("\"{}\", which was not read", shorten(unread));
            self.error(place, found, "its groups", "read it before the document is checked");
        }
    }

    fn version(&mut self, value: &'a Spanned, place: FaultLocation<'a>) {
        match value.json {
            Json::Number(version) if version == f64::from(FORMAT_VERSION) => {}
            // The document uses a format that is unknown here; another number would not help.
            Json::Number(version) if version > f64::from(FORMAT_VERSION) => {
                let found = format!("{}, a newer version of the document format", value.brief());
                let expected = format!("{FORMAT_VERSION}, the newest version that this Trochoid reads");
                self.error(place, found, expected, "open it with a newer Trochoid");
            }
            _ => {
                let expected = format!("{FORMAT_VERSION}, the version of the document format");
                self.error(place, value.brief(), expected, "write \"trochoid\": 1");
            }
        }
    }

    fn format(&mut self, value: &'a Spanned) -> Option<Format> {
        let place = FaultLocation::top(value.offset, "format");
        let entries = self.object(value, place, "an object with \"width\" and \"height\"")?;
        let (mut width, mut height, mut samples, mut shading) = (None, None, Some(1), Shading::default());
        let mut adaptive = None;
        for entry in entries {
            let slot = match entry.key.as_str() {
                "width" => &mut width,
                "height" => &mut height,
                "samples" => &mut samples,
                "shading" => {
                    shading = self.shading(entry)?;
                    continue;
                }
                "adaptive" => {
                    adaptive = Some(self.adaptive(entry)?);
                    continue;
                }
                key => {
                    let keys = ["width", "height", "samples", "shading", "adaptive"];
                    self.unknown_key(FaultLocation::top(entry.offset, "format"), key, &keys);
                    continue;
                }
            };
            *slot = match entry.value.json {
                // `Format` checks its own limits; here numbers only have to fit.
                Json::Number(n) if n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&n) => Some(n as u32),
                _ => {
                    let place = FaultLocation::top(entry.value.offset, &entry.key);
                    self.error(
                        place,
                        entry.value.brief(),
                        "a whole number of pixels or samples",
                        "write a whole number of at least 1 and at most 1048576",
                    );
                    return None;
                }
            };
        }
        let (Some(width), Some(height), Some(samples)) = (width, height, samples) else {
            self.error(place, "a format without \"width\" or \"height\"", "both", "add the missing one");
            return None;
        };
        Format::new(width, height, samples)
            .map(|format| format.with_shading(shading).with_adaptive(adaptive))
            .map_err(|error| {
                let (found, expected, remedy) = match error {
                    FormatError::Side { .. } => (
                        format!("{width} × {height} pixels"),
                        format!("a width and a height from 1 to {MAX_SIDE} pixels"),
                        "choose a size within the limits",
                    ),
                    FormatError::Area { .. } => (
                        format!("{width} × {height} = {} pixels", u64::from(width) * u64::from(height)),
                        format!("at most {MAX_PIXELS} pixels in total"),
                        "choose a size within the limits",
                    ),
                    FormatError::Samples { .. } => {
                        (format!("{samples} samples per pixel"), "1, 4 or 16".into(), "choose one of them")
                    }
                };
                self.error(place, found, expected, remedy);
            })
            .ok()
    }

    fn shading(&mut self, entry: &'a Entry) -> Option<Shading> {
        let found = match &entry.value.json {
            Json::String(name) => Shading::from_name(name),
            _ => None,
        };
        if found.is_none() {
            let place = FaultLocation::top(entry.value.offset, &entry.key);
            let remedy = "\"pixel\" evaluates smoothly varying passes once per pixel and surface; \"sample\" at each \
                          sample";
            let names = Shading::ALL.map(Shading::name);
            self.error(place, entry.value.brief(), format!("one of {}", names.join(", ")), remedy);
        }
        found
    }

    /// Returns the tolerance of adaptive sampling.
    fn adaptive(&mut self, entry: &'a Entry) -> Option<f32> {
        let found = match entry.value.json {
            Json::Number(n) if (0.0..=1.0).contains(&n) => Some(n as f32),
            _ => None,
        };
        if found.is_none() {
            let place = FaultLocation::top(entry.value.offset, &entry.key);
            let remedy =
                "write the largest difference that counts as none, such as 0.01; leave it out to take every sample";
            self.error(place, entry.value.brief(), "a number from 0 to 1", remedy);
        }
        found
    }

    fn working_space(&mut self, value: &'a Spanned) {
        let names = WorkingSpace::ALL.map(WorkingSpace::name);
        match &value.json {
            Json::String(name) if names.contains(&name.as_str()) => {
                self.space = WorkingSpace::from_name(name).unwrap_or_default();
            }
            _ => {
                let place = FaultLocation::top(value.offset, "working_space");
                self.error(place, value.brief(), format!("one of {}", names.join(", ")), "choose one of them");
            }
        }
    }

    fn tolerance(&mut self, value: &'a Spanned) -> Option<Tolerance> {
        let tolerance = match &value.json {
            Json::Number(error) => Tolerance::error(*error),
            Json::String(text) => Tolerance::parse(text),
            _ => None,
        };
        if tolerance.is_none() {
            let place = FaultLocation::top(value.offset, "tolerance");
            self.error(place, value.brief(), Tolerance::EXPECTED, "write the largest error that a pixel may have");
        }
        if matches!(tolerance, Some(Tolerance::Error(error)) if error < Tolerance::CERTIFIABLE) {
            let place = FaultLocation::top(value.offset, "tolerance");
            let remedy = "ask for 1/512, which is invisible on an 8-bit display, unless the picture is processed \
                          further";
            let expected = "an error of 1/4096 or more: smaller ones take very long to certify";
            self.report(Severity::Warning, place, value.brief(), expected.into(), remedy.into());
        }
        tolerance
    }

    fn frames(&mut self, value: &'a Spanned, top: &mut Top) {
        let place = FaultLocation::top(value.offset, "frames");
        let Some(entries) = self.object(value, place, "an object with \"first\", \"last\" and \"fps\"") else { return };
        let mut last = None;
        for entry in entries {
            let place = FaultLocation::top(entry.value.offset, &entry.key);
            match (entry.key.as_str(), &entry.value.json) {
                ("first", Json::Number(n)) if n.fract() == 0.0 && n.abs() <= MAX_FRAME => top.first = *n as i64,
                ("last", Json::Number(n)) if n.fract() == 0.0 && n.abs() <= MAX_FRAME => last = Some(*n as i64),
                ("fps", Json::Number(n)) if *n > 0.0 && *n <= 1e6 => top.fps = *n,
                ("first" | "last", _) => {
                    let expected = format!("a whole number from −{MAX_FRAME} to {MAX_FRAME}");
                    self.error(place, entry.value.brief(), expected, "write a frame number");
                }
                ("fps", _) => {
                    self.error(
                        place,
                        entry.value.brief(),
                        "frames per second, above 0 and at most 1e6",
                        "write, for example, 24",
                    );
                }
                (key, _) => {
                    self.unknown_key(FaultLocation::top(entry.offset, "frames"), key, &["first", "last", "fps"]);
                }
            }
        }
        top.last = last.unwrap_or(top.first);
        if top.last < top.first {
            let found = format!("first {} after last {}", top.first, top.last);
            self.error(place, found, "first ≤ last", "swap them");
            top.last = top.first;
        }
    }
}
