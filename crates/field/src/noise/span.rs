//! Spans of noise over uncertain points and footprints.

use super::reference::{MOST_AXES, distances, gradient_noise, gradient_value, kept, place};
use super::{AMPLITUDE, Noise, NoiseKind, Octave};
use trochoid_graph::Span;

impl Noise {
    /// Returns the span of the noise at a point of two or three coordinates, over spans of the coordinates and the
    /// footprint.
    ///
    /// # Panics
    /// If the point has fewer than two coordinates or more than three.
    pub fn span(&self, point: &[Span], footprint: Span) -> Span {
        let axes = point.len() + usize::from(self.evolution.is_some());
        let mean = self.kind.mean(axes);
        let clear = footprint.clear && point.iter().all(|along| along.clear);
        let (mut low, mut high) = (0.0, 0.0);
        for octave in &self.octaves {
            let kept = footprint.through(|footprint| kept(octave, footprint)).within(0.0, 1.0);
            let value = if kept.high > 0.0 { octave_span(self, octave, point) } else { Span::exactly(mean) };
            let corners = [kept.low, kept.high].map(|kept| [value.low, value.high].map(|value| kept * (value - mean)));
            let corners = corners.as_flattened();
            low += octave.weight * (mean + corners.iter().copied().fold(f64::INFINITY, f64::min));
            high += octave.weight * (mean + corners.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        }
        let (least, most) = self.kind.range();
        Span { low: low - LOST, high: high + LOST, clear }.within(least, most)
    }
}

/// Rounding error of the sum of octaves.
const LOST: f64 = 1e-14;

/// Returns the span of one octave.
fn octave_span(noise: &Noise, octave: &Octave, point: &[Span]) -> Span {
    let place = place(noise, octave, point.iter().map(|along| along.middle()));
    // Uncertainty along each axis of space, in cells, including the rounding to cells.
    let mut reaches = [0.0; MOST_AXES];
    for ((reach, along), place) in reaches.iter_mut().zip(point).zip(&*place) {
        *reach = match along.half() {
            0.0 => 0.0,
            half => half * octave.frequency + 1e-15 * (1.0 + place.abs()),
        };
    }
    let reach = &reaches[..point.len()];
    let (least, most) = noise.kind.range();
    if !reach.iter().all(|reach| reach.is_finite()) {
        return Span::unclear(least, most);
    }
    let around = |value: f64, by: f64| Span { low: value - by, high: value + by, clear: true }.within(least, most);
    let straight = reach.iter().map(|reach| reach * reach).sum::<f64>().sqrt();
    match noise.kind {
        NoiseKind::Fbm => gradients(octave, &place, reach),
        NoiseKind::Ridged => {
            let Span { low, high, .. } = gradients(octave, &place, reach);
            let farthest = high.abs().max(low.abs());
            let nearest = if low <= 0.0 && high >= 0.0 { 0.0 } else { high.abs().min(low.abs()) };
            let ends = [farthest, nearest].map(|height| (1.0 - height) * (1.0 - height));
            Span { low: ends[0], high: ends[1], clear: true }
        }
        // Moving a point changes its distance to the nearest feature point, and to the second nearest, by at most the
        // length of the move.
        NoiseKind::Cellular => around(distances(octave.seed, &place)[0], straight),
        NoiseKind::Edges => {
            let [first, second] = distances(octave.seed, &place);
            around(second - first, 2.0 * straight)
        }
    }
}

/// Returns the span of gradient noise within `reach` of a place, from its slopes there and a bound of their change.
fn gradients(octave: &Octave, place: &[f64], reach: &[f64]) -> Span {
    if reach.iter().all(|reach| *reach == 0.0) {
        return Span::exactly(gradient_value(octave.seed, place));
    }
    let (value, slopes) = gradient_noise(octave.seed, place);
    let straight: f64 = slopes.iter().zip(reach).map(|(slope, reach)| slope.abs() * reach).sum();
    // No second derivative exceeds the amplitude times 225/16 · axes + 15/2: the fade's slope is at most 15/8 and its
    // second derivative at most 10/√3; between corners, gradients differ by at most 2 and the values they lead to by at
    // most 4 · axes.
    let axes = place.len();
    let bend = f64::from(AMPLITUDE[axes]) * (225.0 / 16.0 * axes as f64 + 7.5);
    let all: f64 = reach.iter().sum();
    let off = straight + 0.5 * bend * (all * all);
    Span { low: value - off, high: value + off, clear: true }.within(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoiseParameters;
    use trochoid_graph::Bound;

    #[test]
    fn noise_stays_within_its_span_however_far_it_is_moved() {
        let kinds = [NoiseKind::Fbm, NoiseKind::Ridged, NoiseKind::Cellular, NoiseKind::Edges];
        let mut state = 1u32;
        let mut random = || {
            state = super::super::extend(state, 1);
            f64::from(state) / f64::from(u32::MAX) * 2.0 - 1.0
        };
        let mut ratios = Vec::new();
        for (kind, evolution) in kinds.into_iter().flat_map(|kind| [None, Some(0.3)].map(|evolution| (kind, evolution)))
        {
            let parameters = NoiseParameters { scale: 0.7, octaves: 4, lacunarity: 2.1, gain: 0.5, seed: 9 };
            let noise = Noise::new(kind, parameters, evolution);
            for round in 0..4000 {
                let size = [1e-9, 1e-6, 1e-4, 1e-2, 0.1, 3.0][round % 6];
                let (count, footprint) = (2 + round % 2, 0.2 * (random() + 1.0));
                let point: Vec<f64> = (0..count).map(|_| 10.0 * random()).collect();
                let spans: Vec<Span> =
                    point.iter().map(|along| Span::around(*along, Bound::of(size * (random() + 1.0)))).collect();
                let print = Span::around(footprint, Bound::of(size * footprint * (random() + 1.0) / 2.0));
                let within = |span: &Span, at: f64| span.low + (span.high - span.low) * (at + 1.0) / 2.0;
                let moved: Vec<f64> = spans.iter().map(|span| within(span, random())).collect();
                let (here, there) =
                    (noise.reference(&point, footprint), noise.reference(&moved, within(&print, random())));
                let span = noise.span(&spans, print);
                assert!(
                    span.holds(here) && span.holds(there),
                    "{kind:?}: {here} and {there} beyond {span:?} at {point:?}"
                );
                if size == 1e-4 {
                    ratios.push((span.high - here).max(here - span.low) / (there - here).abs().max(1e-12));
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let median = ratios[ratios.len() / 2];
        assert!(median < 10.0, "spans are {median} times as wide as noise moves");
    }
}
