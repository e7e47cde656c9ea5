//! Warp: looks up an image at displaced positions.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use crate::filter::{
    BoundedChannel, BoundedSum, LANES, blended_together, fill_together, kind, mean, numbers, value, weights_together,
};
use fearless_simd::{Level, Simd, dispatch};
use std::convert::Infallible;
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;

/// Displaces the pixels of an image: colors, a mask, weights or a field.
///
/// # Formula
/// image(x + dx, y + dy), y down. Between pixels, the four nearest are blended. dx and dy are clamped to [−reach,
/// reach].
///
/// # Edge cases
/// A displacement by whole pixels copies pixels exactly. Beyond its border, an image repeats the nearest pixel; a file
/// with overscan uses those pixels instead if it is connected directly or through other filters. Every result lies
/// between the four pixels, and weights still sum to 1. Where +∞ and −∞ of a field meet, the upper left of the four is
/// taken. Each sample of a pixel is displaced separately. No color is added to the palette.
///
/// # Source
/// Bilinear resampling: its weights are ≥ 0 and sum to 1.
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 1, output(image: Kind::ANY = "The displaced image, of the same kind."))]
#[also_called(
    "Transform", "Move", "Translate", "Scale", "Rotate", "Displace", "IDistort", "Distort", "CornerPin" => "by \"dx\" and \"dy\""
)]
pub(crate) struct Warp {
    /// Image to displace.
    image: One<port::Image>,
    /// Horizontal offset of the lookup, in pixels; positive values look to the right, which moves the image left. 0 by
    /// default.
    dx: Optional<port::Scalar>,
    /// Vertical offset of the lookup, in pixels; positive values look down, which moves the image up. 0 by default.
    dy: Optional<port::Scalar>,
    /// Largest displacement along each axis; larger values are clamped to it.
    #[knob(default = 32.0, range = 0.0..=4096.0, in_pixels)]
    reach: f64,
}

impl Node for Warp {}

impl Stage for Warp {
    fn is_costly(&self) -> bool {
        true
    }

    fn regions_of_interest(&self, port: PortId, window: Window, _format: Format) -> Window {
        let reach = if port == self.image.id() { self.reach.ceil() as i64 } else { 0 };
        Window::new(window.x0 - reach, window.y0 - reach, window.x1 + reach, window.y1 + reach)
    }

    fn takes_whole_rows(&self) -> bool {
        true
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        // Offsets are in pixels of the document, also where a smaller picture is drawn.
        let [own, meant] =
            [prepare.frame.format, prepare.frame.document_format].map(|format| f64::from(format.width()));
        Ok(Box::new(PreparedWarp { node: self.clone(), kind: kind(prepare), scale: own / meant }))
    }
}

struct PreparedWarp {
    node: Warp,
    kind: Kind,
    /// Pixels of the picture per pixel of the document.
    scale: f64,
}

impl PreparedWarp {
    /// Splits a displacement into whole pixels and a fraction.
    #[inline(always)]
    fn split(&self, displacement: f64) -> (i32, f64) {
        let reach = self.node.reach;
        let limited = if displacement.is_nan() { 0.0 } else { displacement };
        let limited = if limited < -reach { -reach } else { limited };
        let limited = if limited > reach { reach } else { limited };
        (limited.floor() as i32, limited - limited.floor())
    }

    /// Does the same, for windows.
    fn whole(&self, displacement: f64) -> (i64, f64) {
        let (whole, part) = self.split(displacement);
        (i64::from(whole), part)
    }

    /// Finds the pixels that a row of displaced samples blends, from the row's displacements in pixels of the document.
    #[inline(always)]
    fn look_up(&self, row: Window, displacements: [Option<&[f32]>; 2], from: Window, taps: &mut Scratch<Taps>) {
        let [dx, dy] = displacements;
        for start in (0..row.width()).step_by(LANES) {
            let (mut steps, mut parts) = ([[0_i32; LANES]; 2], [[0.0_f64; LANES]; 2]);
            for (axis, plane) in [dx, dy].into_iter().enumerate() {
                let Some(plane) = plane else { continue };
                let values = padded(&plane[start..]);
                for lane in 0..LANES {
                    (steps[axis][lane], parts[axis][lane]) = self.split(f64::from(values[lane]) * self.scale);
                }
            }
            let mut found = Taps { weights: weights_together(&parts[0], &parts[1]), ..Taps::default() };
            for lane in 0..LANES {
                let (dx, dy) = (steps[0][lane], steps[1][lane]);
                let (u, v) = (parts[0][lane], parts[1][lane]);
                found.moved[lane] = (dx != 0) | (dy != 0) | (u != 0.0) | (v != 0.0);
                let (x, y) = (row.x0 + (start + lane) as i64 + i64::from(dx), row.y0 + i64::from(dy));
                let column = |x: i64| (x.max(from.x0).min(from.x1 - 1) - from.x0) as usize;
                let line = |y: i64| (y.max(from.y0).min(from.y1 - 1) - from.y0) as usize * from.width();
                let (left, right, above, below) = (column(x), column(x + 1), line(y), line(y + 1));
                found.at[0][lane] = above + left;
                found.at[1][lane] = above + right;
                found.at[2][lane] = below + left;
                found.at[3][lane] = below + right;
            }
            taps.push(found);
        }
    }

    /// Returns the error bound of a sample whose displacements lie within spans.
    fn sample_bound(&self, image: BoundedChannel<'_>, [x, y]: [i64; 2], spans: [Span; 2], filled: f32) -> Bound {
        let [(dx, u), (dy, v)] = spans.map(|span| self.whole(span.middle()));
        let shares =
            [((0, 0), (1.0 - u) * (1.0 - v)), ((1, 0), u * (1.0 - v)), ((0, 1), (1.0 - u) * v), ((1, 1), u * v)];
        let middle = shares.into_iter().fold(BoundedSum::NOTHING, |sum, ((right, down), weight)| {
            sum.plus(weight, image.at(x + dx + right, y + dy + down))
        });
        if spans.iter().all(|span| span.low == span.high) {
            return middle.of(filled, 0.0).with(spans.iter().all(|span| span.clear));
        }
        // Between four pixels, the image changes by no more than they differ. Take the steepest change among all pixels
        // that the lookup may reach.
        let [across, down] = spans.map(|span| [self.whole(span.low).0, self.whole(span.high).0 + 1]);
        let [width, height] = [across, down].map(|[first, last]| last - first + 1);
        if width * height > MOST {
            let most = if matches!(self.kind, Kind::Weights(_)) { 1.0 } else { f64::INFINITY };
            return Bound::of(most).with(false);
        }
        let at = |column: i64, row: i64| image.at(x + across[0] + column, y + down[0] + row);
        let (mut steepest, mut own) = ([0.0_f64; 2], Bound::EXACT);
        for row in 0..height {
            for column in 0..width {
                let here = at(column, row);
                own = Bound { size: own.size.max(here.bound.size), clear: own.clear && here.bound.clear };
                for (axis, there) in [(0, (column + 1, row)), (1, (column, row + 1))] {
                    if there.0 < width && there.1 < height {
                        let change = (at(there.0, there.1).value - here.value).abs();
                        steepest[axis] = if change.is_nan() { f64::INFINITY } else { steepest[axis].max(change) };
                    }
                }
            }
        }
        let off = [0, 1].map(|axis| if spans[axis].half() > 0.0 { spans[axis].half() * steepest[axis] } else { 0.0 });
        let clear = own.clear && spans.iter().all(|span| span.clear);
        middle.within(own).of(filled, (off[0] + off[1]) * (1.0 + 1e-9)).with(clear)
    }
}

/// Pixels of an image that some displaced samples blend, and their weights.
#[derive(Default)]
struct Taps {
    at: [[usize; LANES]; 4],
    weights: [[f32; LANES]; 4],
    /// Whether each sample is displaced at all: the others are copied.
    moved: [bool; LANES],
}

impl Taps {
    /// Returns the samples of an image.
    #[inline(always)]
    fn blend(&self, image: &[f32]) -> [f32; LANES] {
        let mut values = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            values[0][lane] = image[self.at[0][lane]];
        }
        if self.moved == [false; LANES] {
            return values[0];
        }
        for pixel in 1..4 {
            for lane in 0..LANES {
                values[pixel][lane] = image[self.at[pixel][lane]];
            }
        }
        let mut blends = blended_together(&values, &self.weights);
        for lane in 0..LANES {
            blends[lane] = if self.moved[lane] { blends[lane] } else { values[0][lane] };
        }
        blends
    }
}

/// Returns the first values, and zeros where there are fewer.
#[inline(always)]
fn padded(values: &[f32]) -> [f32; LANES] {
    let mut all = [0.0; LANES];
    if let Some(values) = values.first_chunk() {
        all = *values;
    } else {
        all[..values.len()].copy_from_slice(values);
    }
    all
}

/// Largest number of pixels examined for an uncertain lookup; beyond it, the bound is the largest possible error.
const MOST: i64 = 4096;

impl Prepared for PreparedWarp {
    fn data_window(&self, _picture: Window, inputs: &dyn Fn(PortId) -> Window) -> Window {
        inputs(self.node.image.id()).intersect(inputs(self.node.dx.id())).intersect(inputs(self.node.dy.id()))
    }

    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Warp { image, dx, dy, .. } = &self.node;
        let image = &inputs.all(image)[0];
        let (window, from) = (block.window, image.window);
        let displacements = |port| inputs.all(port).first().and_then(|connection| connection.planes[0]);
        let displacements = [displacements(dx), displacements(dy)];
        let (level, width) = (Level::new(), window.width());
        // Lookups of a row's samples, computed once for all channels.
        let mut taps: Scratch<Taps> = Scratch::new();
        let Ok(()) = fill_together(self.kind, window.area(), outputs, |planes| -> Result<(), Infallible> {
            for (y, start) in (window.y0..window.y1).zip((0..).step_by(width.max(1))) {
                let row = Window { y0: y, y1: y + 1, ..window };
                let of_row = displacements.map(|plane| plane.map(|plane| &plane[start..start + width]));
                taps.clear();
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    self.look_up(row, of_row, from, &mut taps);
                }));
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let (Some(plane), Some(Some(samples))) = (plane, image.planes.get(channel)) else { continue };
                    let out = &mut plane[start..start + width];
                    dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                        for (taps, out) in taps.iter().zip(out.chunks_mut(LANES)) {
                            let blends = taps.blend(samples);
                            if let Some(out) = out.first_chunk_mut() {
                                *out = blends;
                            } else {
                                out.copy_from_slice(&blends[..out.len()]);
                            }
                        }
                    }));
                }
            }
            Ok(())
        });
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let Warp { image, dx, dy, reach } = &self.node;
        let displaced = |port, sample: usize| {
            let span = bounding.known(port, 0, sample).unwrap_or(Span::exactly(0.0));
            let scaled = Span { low: span.low * self.scale, high: span.high * self.scale, ..span };
            scaled.within(-reach, *reach)
        };
        let pixels: Vec<[i64; 2]> = bounding.block.pixels().collect();
        for (image, filled, bounds) in BoundedChannel::channels(bounding, image, self.kind, outputs) {
            for (sample, ((bound, filled), [x, y])) in bounds.iter_mut().zip(filled).zip(&pixels).enumerate() {
                let spans = [dx, dy].map(|port| displaced(port, sample));
                *bound = self.sample_bound(image, [*x, *y], spans, *filled).encode();
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let Warp { image, dx, dy, .. } = &self.node;
        let split =
            |port: &Optional<_>| self.whole(port.as_ref().map_or(0.0, |source| inputs.scalar(source) * self.scale));
        let ((dx, u), (dy, v)) = (split(dx), split(dy));
        let at = |right: i64, down: i64| numbers(&inputs.moved((dx + right) as f64, (dy + down) as f64), image);
        let corners = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
        let terms = corners.into_iter().filter(|(.., w)| *w > 0.0).map(|(right, down, w)| (w, at(right, down)));
        Ok(vec![value(self.kind, mean(terms, || at(0, 0)))])
    }
}
