//! Comparison of one output's pixels with their references.

use super::chance::{allowed, choose};
use super::color::Coding;
use super::failed_claim::FailedClaim;
use super::image::{StoredChannel, StoredImage};
use super::make::hash_of_corners;
use super::map::PixelMap;
use super::storage::before_rounding;
use super::words::Words;
use super::*;
use trochoid_engine::{Hull, Monitor, ReferenceFrame, ReferencePixel};
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::Window;
use trochoid_io::FileKind;

/// Number of pixels evaluated at once. Only their values are held, and the check can stop between pieces.
const PIECE: usize = 8192;
/// Maximum number of pixels that are named for each kind of failure.
const NAMED: u64 = 5;
/// Tolerance for f64 sums of weights.
const SUM: f64 = 1e-9;
/// Tolerance for sums of f32 weights: far more than the rounding errors of any partition.
const SUM_F32: f64 = 1e-5;
/// Relative error of a literal that was rounded to f32.
const LITERAL: f64 = 1.0 / 16_777_216.0;
/// Maximum number of operations per node between a control color and a pixel, for the margin of rounding.
const LEVELS: usize = 64;

/// Output of a certificate with consistent numbers, ready to be compared with the references.
pub(super) struct PixelCheck<'c> {
    written: &'c CertifiedOutput,
    digest: &'c str,
    kind: Kind,
    window: Window,
    ambiguous: PixelMap,
    channels: Vec<&'c StoredChannel>,
    coding: Coding,
    /// Number of nodes in the document.
    nodes: usize,
}

/// Failures of one kind: the first few with their pixels, the others as a count.
#[derive(Default)]
struct Faults {
    named: Vec<FailedClaim>,
    count: u64,
}

impl Faults {
    fn add(&mut self, fault: impl FnOnce() -> FailedClaim) {
        self.count += 1;
        if self.count <= NAMED {
            self.named.push(fault());
        }
    }

    fn tell(self, found: &mut Verification, place: String) {
        found.failures.extend(self.named);
        if self.count > NAMED {
            found.fail(place, format!("{} more pixels that fail in this way", self.count - NAMED), "none");
        }
    }
}

/// Returns a bound as a number: infinity if there is none.
fn bound(written: Option<f64>) -> f64 {
    written.unwrap_or(f64::INFINITY)
}

impl<'c> PixelCheck<'c> {
    /// Checks that the numbers of an output are consistent; `None` if its pixels cannot be checked.
    pub(super) fn new(
        found: &mut Verification,
        certificate: &'c Certificate,
        written: &'c CertifiedOutput,
        graph: &CheckedGraph,
        index: usize,
        image: &'c StoredImage,
    ) -> Option<Self> {
        let spec = &graph.outputs()[index];
        let place = |field: &str| format!("output \"{}\", {field}", written.name);
        if let Some(controls) = &written.controls {
            let listed = controls.values.len() as u64;
            let complete = controls.count <= LISTED;
            if (complete && listed != controls.count) || listed > LISTED {
                let expected =
                    if complete { format!("{}, as in the count", controls.count) } else { format!("at most {LISTED}") };
                found.fail(place("controls.values"), format!("{listed} colors"), expected);
            }
        }
        let window = graph.format().window();
        let pixels = window.area() as u64;
        let (audit, error) = (&written.audit, &written.error);
        found.same(place("audit.pixels"), &audit.pixels, &pixels);
        if audit.judged > pixels || audit.outside > audit.judged || (audit.worst == Some(0.0)) != (audit.outside == 0) {
            found.fail(place("audit"), "counts that contradict one another", "outside ≤ judged ≤ pixels");
        }
        let sums = (0.0..=SUM_F32).contains(&audit.weight_sum_max_deviation);
        if !sums || audit.weight_min.is_some_and(|least| least < 0.0) {
            let weights =
                format!("weights from {}, sums off by {}", audit.weight_min.words(), audit.weight_sum_max_deviation);
            found.fail(place("audit"), weights, format!("no weight below 0, sums of 1 within {SUM_F32:e}"));
        }
        let samples = match spec.kind {
            Kind::Field(_) => 1,
            _ => u64::from(graph.format().samples()),
        };
        let ambiguous = &error.ambiguous;
        let map = match PixelMap::decode(&ambiguous.map, window.area()) {
            Ok(map) => map,
            Err(why) => {
                found.fail(place("error.ambiguous.map"), why, format!("one bit for each of {pixels} pixels"));
                return None;
            }
        };
        found.same(place("error.ambiguous.pixels"), &ambiguous.pixels, &map.count());
        found.same(place("error.pixels.count"), &error.pixels.count, &(pixels - map.count()));
        let all = pixels * samples;
        let total = error.samples.count.checked_add(ambiguous.samples);
        found.same(place("error.samples.count, with those that are ambiguous"), &total, &Some(all));
        let least_and_most = map.count()..=map.count() * samples;
        if !least_and_most.contains(&ambiguous.samples) {
            let expected = format!("{} to {}", least_and_most.start(), least_and_most.end());
            found.fail(place("error.ambiguous.samples"), ambiguous.samples, expected);
        }
        let share = ambiguous.samples as f64 / all as f64;
        // Reading JSON may round once.
        let agrees = (ambiguous.share - share).abs() <= 1e-15;
        if !agrees {
            found.fail(place("error.ambiguous.share"), ambiguous.share, share);
        }
        if !(0.0..=ambiguous.share).contains(&ambiguous.share_beyond_8_bit) {
            let place = place("error.ambiguous.share_beyond_8_bit");
            found.fail(place, ambiguous.share_beyond_8_bit, format!("0 to {}", ambiguous.share));
        }
        let pairs =
            [("pixels", error.pixels.p999, error.pixels.max), ("samples", error.samples.p999, error.samples.max)];
        for (of, p999, max) in pairs {
            let (p999, max) = (bound(p999), bound(max));
            if !(0.0 <= p999 && p999 <= max) {
                found.fail(place(&format!("error.{of}.p999")), p999, format!("0 to {max}"));
            }
        }
        if bound(ambiguous.max) < 0.0 {
            found.fail(place("error.ambiguous.max"), bound(ambiguous.max), "0 or more");
        }
        let channels: Option<Vec<&StoredChannel>> = written.channels.iter().map(|name| image.channel(name)).collect();
        let channels = channels.filter(|channels| channels.len() == spec.kind.channels());
        Some(Self {
            written,
            digest: &certificate.digest,
            kind: spec.kind,
            window,
            ambiguous: map,
            // Missing channels have been reported already, and no pixels are checked then.
            channels: channels?,
            coding: Coding::new(spec.kind, graph.space(), image.kind == FileKind::Png),
            nodes: graph.nodes().len(),
        })
    }

    pub(super) fn name(&self) -> &str {
        &self.written.name
    }

    /// Returns the number of pixels to check.
    pub(super) fn count(&self, choice: Choice) -> usize {
        match choice {
            Choice::All => self.window.area(),
            Choice::Some(count) => self.window.area().min(usize::try_from(count).unwrap_or(usize::MAX)),
        }
    }

    /// Evaluates this many pixels by the references, and compares those of the file with them.
    pub(super) fn run(
        &self,
        found: &mut Verification,
        reference: &ReferenceFrame<'_>,
        count: usize,
        monitor: &dyn Monitor,
    ) -> Result<Findings, CertificateError> {
        let place = |field: &str| format!("output \"{}\", {field}", self.written.name);
        let hulls = self.hulls(found, reference);
        let mut findings = Findings {
            output: self.written.name.clone(),
            looked_at: count as u64,
            pixels: self.window.area() as u64,
            ambiguous: 0,
            hull: hulls.is_some(),
            distance: 0.0,
            distance_ambiguous: 0.0,
            weight_min: f64::INFINITY,
            weight_sum_max_deviation: 0.0,
        };
        let mut faults: [Faults; 3] = Default::default();
        let mut beyond = 0;
        let chosen = choose(self.digest, self.window.area(), count);
        for (index, piece) in chosen.chunks(PIECE).enumerate() {
            let places: Vec<[i64; 2]> = piece.iter().map(|pixel| self.place(*pixel)).collect();
            let after = PieceMonitor { monitor, before: index * PIECE };
            let pixels = reference.pixels(&places, &after)?;
            for (&pixel, reference) in piece.iter().zip(&pixels) {
                findings.weight_min = findings.weight_min.min(reference.weight_min);
                findings.weight_sum_max_deviation =
                    findings.weight_sum_max_deviation.max(reference.weight_sum_max_deviation);
                beyond += u64::from(self.error(pixel, reference, &mut findings, &mut faults[0]));
                self.weights(pixel, reference, &mut faults[1]);
                if let Some(hulls) = &hulls {
                    self.hull(pixel, reference, hulls, &mut faults[2]);
                }
            }
        }
        for (faults, of) in faults.into_iter().zip(["error", "weights", "hull"]) {
            faults.tell(found, place(of));
        }
        let clear = findings.looked_at - findings.ambiguous;
        let most = if findings.looked_at == findings.pixels { clear / 1000 } else { allowed(clear, 0.001) };
        if beyond > most {
            let p999 = bound(self.written.error.pixels.p999);
            let beyond = format!("{beyond} of {clear} pixels farther than {p999:e} from their references");
            found.fail(place("error.pixels.p999"), beyond, format!("at most {most}"));
        }
        Ok(findings)
    }

    fn place(&self, pixel: usize) -> [i64; 2] {
        let width = self.window.width();
        [self.window.x0 + (pixel % width) as i64, self.window.y0 + (pixel / width) as i64]
    }

    fn fault(&self, pixel: usize, found: String, expected: String) -> FailedClaim {
        let [x, y] = self.place(pixel);
        FailedClaim { place: format!("output \"{}\", pixel ({x}, {y})", self.written.name), found, expected }
    }

    /// Returns the range of values before rounding for each channel of a stored pixel.
    fn stored(&self, pixel: usize) -> impl Iterator<Item = (f64, f64)> {
        self.channels.iter().map(move |channel| before_rounding(channel.stored, channel.plane.samples()[pixel]))
    }

    /// Compares a pixel with its reference; returns whether it is unambiguous and exceeds the 99.9th percentile.
    fn error(&self, pixel: usize, reference: &ReferencePixel, findings: &mut Findings, faults: &mut Faults) -> bool {
        let error = &self.written.error;
        let ambiguous = self.ambiguous.contains(pixel);
        findings.ambiguous += u64::from(ambiguous);
        let most = bound(if ambiguous { error.ambiguous.max } else { error.pixels.max });
        let within = |most: f64| {
            let ends = self.coding.ends(&reference.value, most);
            // False for NaN.
            let mut pairs = self.stored(pixel).zip(ends);
            pairs.all(|((low, high), (least, largest))| least <= high && low <= largest)
        };
        if !within(most) {
            faults.add(|| {
                let values: Vec<f32> = self.channels.iter().map(|channel| channel.plane.samples()[pixel]).collect();
                let ends = self.coding.ends(&reference.value, 0.0);
                let middle: Vec<f64> = ends.iter().map(|(low, high)| 0.5 * (low + high)).collect();
                let expected = format!("{middle:?} by the references, within the certified {most:e}");
                self.fault(pixel, format!("{values:?}"), expected)
            });
        }
        let exact = self.coding.ends(&reference.value, 0.0);
        let apart = self.stored(pixel).zip(exact).map(|((low, high), (least, largest))| {
            // The difference of infinities is undefined: they must be equal.
            if low == least && high == largest { 0.0 } else { (low - largest).max(least - high).max(0.0) }
        });
        let distance = apart.fold(0.0, f64::max);
        let largest = if ambiguous { &mut findings.distance_ambiguous } else { &mut findings.distance };
        *largest = largest.max(distance);
        !ambiguous && !within(bound(error.pixels.p999))
    }

    /// Checks the weights of all nodes in the references, and those in the file.
    fn weights(&self, pixel: usize, reference: &ReferencePixel, faults: &mut Faults) {
        let (least, off) = (reference.weight_min, reference.weight_sum_max_deviation);
        if least < -SUM || off > SUM {
            let found = format!("a weight of {least:e}, and a sum off by {off:e}, in the references");
            faults.add(|| self.fault(pixel, found, "weights of 0 or more that sum to 1".into()));
        }
        let Kind::Weights(n) = self.kind else { return };
        let stored: Vec<(f64, f64)> = self.stored(pixel).collect();
        let slack = LITERAL * n as f64;
        let legal = stored.iter().all(|(low, high)| *low <= 1.0 && *high >= 0.0);
        let sums = [stored.iter().map(|ends| ends.0).sum::<f64>(), stored.iter().map(|ends| ends.1).sum()];
        // For a mask, the file stores one of its two weights.
        let sum = n == 2 || (sums[0] <= 1.0 + slack && sums[1] >= 1.0 - slack);
        if !legal || !sum {
            let found = format!("weights whose sum lies from {} to {}", sums[0], sums[1]);
            faults.add(|| self.fault(pixel, found, "weights from 0 to 1 that sum to 1".into()));
        }
    }

    /// Checks the control colors against the references, and returns their hull; `None` if no hull is certified.
    fn hulls(&self, found: &mut Verification, reference: &ReferenceFrame<'_>) -> Option<Hulls> {
        let place = |field: &str| format!("output \"{}\", {field}", self.written.name);
        let controls = self.written.controls.as_ref()?;
        let all = Hull::new(&reference.controls());
        found.same(place("controls.corners"), &controls.corners, &(all.vertices().len() as u64));
        found.same(place("controls.hash"), &controls.hash, &hash_of_corners(all.vertices()));
        let values = &controls.values;
        let outside = values.iter().filter(|color| all.exit(color, all.margin(1)).is_some()).count();
        if outside > 0 {
            let wrong = format!("{} colors, {outside} of which are not in the document", values.len());
            found.fail(place("controls.values"), wrong, "control colors of the document");
        }
        let margin = self.written.audit.margin;
        let most = all.margin(LEVELS * (self.nodes + 1));
        if !(0.0..=most).contains(&margin) {
            found.fail(place("audit.margin"), margin, format!("0 to {most:e}, the limit of rounding"));
        }
        let complete = controls.count <= LISTED;
        let listed = complete.then(|| Hull::new(values));
        let held = self.written.guarantee.as_ref().is_some_and(|guarantee| guarantee.held.is_some());
        let largest = all.vertices().iter().flatten().fold(0.0, |most: f64, v| most.max(f64::from(v.abs())));
        held.then(|| Hulls { hull: listed.unwrap_or(all), margin, slack: 4.0 * LITERAL * largest })
    }

    /// Checks that a color and its reference lie in the hull, up to the rounding of the format.
    fn hull(&self, pixel: usize, reference: &ReferencePixel, hulls: &Hulls, faults: &mut Faults) {
        let [r, g, b] = reference.value[..] else { return };
        let distance = hulls.hull.signed_distance([r, g, b]);
        // Literals are rounded in the hull, but not in the references.
        let inside = distance <= hulls.margin + hulls.slack;
        if !inside {
            let found = format!("the reference {:?}, {distance:e} outside the hull", reference.value);
            faults.add(|| self.fault(pixel, found, "no color outside the hull".into()));
        }
        let ends: Vec<(f64, f64)> = self.stored(pixel).collect();
        let at = |share: &dyn Fn(usize) -> f64| {
            self.coding.color([0, 1, 2].map(|c| ends[c].0 + share(c) * (ends[c].1 - ends[c].0)))
        };
        let color = at(&|_| 0.5);
        let distance = hulls.hull.signed_distance(color);
        if distance <= hulls.margin {
            return;
        }
        let corners = (0..8).map(|corner: usize| at(&|c| (corner >> c & 1) as f64));
        let apart = |other: [f64; 3]| color.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let size = color.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let rounded = corners.map(apart).fold(0.0, f64::max) + self.coding.rounding() * size;
        let inside = distance <= hulls.margin + rounded;
        if !inside {
            let found = format!("{color:?} in the working space, {distance:e} outside the hull");
            let expected = format!("at most {:e} outside, the rounding of the file's format", hulls.margin + rounded);
            faults.add(|| self.fault(pixel, found, expected));
        }
    }
}

/// Hull that colors are compared with, and its tolerances.
struct Hulls {
    hull: Hull,
    /// Margin of rounding, as certified.
    margin: f64,
    /// Error from rounding the control colors themselves.
    slack: f64,
}

/// Monitor of one piece of an output's work.
struct PieceMonitor<'m> {
    monitor: &'m dyn Monitor,
    before: usize,
}

impl Monitor for PieceMonitor<'_> {
    fn progress(&self, done: usize, total: usize) {
        self.monitor.progress(self.before + done, self.before + total);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}
