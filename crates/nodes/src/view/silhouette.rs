//! Silhouette: lines where a surface turns away from the eye.

use super::{NORMAL, Neighborhood, POSITION, change, grown, is_covered, may_see, surface_of, view_planes, view_vector};
use crate::lit::{BoundedDirection, BoundedVector, eye, toward_eye, view_positions};
use fearless_simd::{Level, Simd, dispatch};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;
use trochoid_scene::Projector;
use trochoid_scene::shading::{facing, facings, view_directions};

/// A mask of the lines where surfaces turn away from the eye.
///
/// # Formula
/// e = max(0, N · V). By cutoff: 1 where e < cutoff, falling linearly to 0 at cutoff + ramp. By `width` in pixels:
/// width + ½ − d, limited to [0, 1], with d = e²/|∇e²| the distance to the place where e reaches 0, since toward a
/// round edge e falls like the root of the distance.
///
/// # Edge cases
/// Where nothing is seen, the mask is 0 and e is 1. ∇ is half the difference between the two neighboring pixels on an
/// axis, or the difference to the one that sees the same surface; without any, or where e² does not change, a line is
/// drawn only where e = 0. Ramp 0 is a hard cutoff. Toward the horizon, all faces of a sea are seen edge-on, and the
/// line thickens accordingly.
///
/// # Source
/// Toon shading by thresholds: edge = max(0, n · v), black below 0.01, or by a one-dimensional ramp: connect `edge` to
/// a Ramp.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, outputs = Out)]
pub(crate) struct Silhouette {
    /// View of the surfaces.
    view: One<port::View>,
    /// N · V below which the line is drawn.
    #[knob(default = 0.2, range = 0.0..=1.0)]
    cutoff: f64,
    /// Further increase of N · V over which the line fades out.
    #[knob(default = 0.05, range = 0.0..=1.0)]
    ramp: f64,
    /// Width of the line; if set, it replaces the cutoff.
    #[knob(range = 0.0..=100.0, in_pixels)]
    width: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// 1 on the line.
    #[output(Kind::MASK)]
    Mask,
    /// max(0, N · V): 0 where the surface turns away.
    #[output(Kind::MASK)]
    Edge,
}

impl Node for Silhouette {}

impl Stage for Silhouette {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&POSITION).union(Channel::Surface.into())
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn regions_of_interest(&self, _port: PortId, window: Window, _format: Format) -> Window {
        grown(window, i64::from(self.width.is_some()))
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let eye = eye(prepare, &self.view, prepare.frame.format)?;
        Ok(Box::new(PreparedSilhouette { node: self.clone(), eye }))
    }
}

struct PreparedSilhouette {
    node: Silhouette,
    eye: Projector,
}

impl PreparedSilhouette {
    /// Returns the mask by the cutoff.
    fn cut(&self, e: f64) -> f64 {
        if e < self.node.cutoff {
            1.0
        } else if self.node.ramp > 0.0 {
            (1.0 - (e - self.node.cutoff) / self.node.ramp).max(0.0)
        } else {
            0.0
        }
    }

    /// Returns the mask by a width, given e² and its changes to the right and down.
    #[inline(always)]
    fn line(width: f64, squared: f64, changes: [Option<f64>; 2]) -> f64 {
        let [across, down] = changes.map(|change| change.unwrap_or(0.0));
        let slope = (across * across + down * down).sqrt();
        if squared == 0.0 {
            (width + 0.5).min(1.0)
        } else if slope > 0.0 {
            (width + 0.5 - squared / slope).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// Returns max(0, N · V) at a sample of the reference.
    fn edge(&self, inputs: &References<'_>) -> f64 {
        let normal = view_vector(inputs, &self.node.view, NORMAL);
        facing(normal, toward_eye(&self.eye, view_vector(inputs, &self.node.view, POSITION)))
    }

    /// Returns max(0, N · V) at all samples around a block that see a surface.
    fn edges(&self, inputs: &Inputs<'_>, surfaces: &[f32]) -> Result<Scratch<f64>, NodeError> {
        let normals = view_planes(inputs, &self.node.view, NORMAL);
        let positions = view_positions(inputs, &self.node.view, &self.eye)?;
        let mut edges = Scratch::of(1.0, surfaces.len());
        let mut views = [[0.0; AT_ONCE]; 3];
        for (part, edges) in edges.chunks_mut(AT_ONCE).enumerate() {
            let range = part * AT_ONCE..part * AT_ONCE + edges.len();
            if surfaces[range.clone()].iter().all(|surface| *surface < 0.0) {
                continue;
            }
            let count = edges.len();
            let [positions, normals] =
                [positions, normals].map(|vectors| vectors.map(|plane| plane.get(range.clone()).unwrap_or_default()));
            view_directions(positions, &self.eye, views.each_mut().map(|axis| &mut axis[..count]));
            facings(normals, views.each_ref().map(|axis| &axis[..count]), edges);
        }
        Ok(edges)
    }
}

/// Number of samples computed at once.
const AT_ONCE: usize = 256;

/// e² and the surfaces of a row of samples, and of those above and below it. The row itself has one more on either
/// side.
struct Rows<'a> {
    squares: [&'a [f64]; 3],
    surfaces: [&'a [f32]; 3],
}

impl Rows<'_> {
    /// Fills the mask of the row by a width.
    fn fill(&self, width: f64, out: &mut [f32]) {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            let count = out.len();
            let Self { squares: [above, own, below], surfaces } = self;
            let (above, left, own, right, below) =
                (&above[..count], &own[..count], &own[1..][..count], &own[2..][..count], &below[..count]);
            let [over, here, under] = surfaces;
            let (over, before, here, after, under) =
                (&over[..count], &here[..count], &here[1..][..count], &here[2..][..count], &under[..count]);
            for x in 0..count {
                let like = |surface: f32, square: f64| (surface == here[x]).then_some(square);
                let across = change(like(before[x], left[x]), own[x], like(after[x], right[x]));
                let down = change(like(over[x], above[x]), own[x], like(under[x], below[x]));
                let line = PreparedSilhouette::line(width, own[x], [across, down]) as f32;
                out[x] = if here[x] >= 0.0 { line } else { 0.0 };
            }
        }));
    }
}

/// Rounding error of a mask.
const LOST: f64 = 1e-12;

impl Prepared for PreparedSilhouette {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let around = Neighborhood::of(inputs, &self.node.view);
        let surfaces = around.surfaces();
        let edges = self.edges(inputs, &surfaces)?;
        let Window { x0, x1, y0, .. } = block.window;
        let width = block.window.width().max(1);
        let mut spare: (Scratch<f64>, Scratch<f32>) = Default::default();
        if let Some(plane) = outputs.take(Out::Edge, 0) {
            for (y, out) in (y0..).zip(plane.chunks_exact_mut(width)) {
                let edges = around.row(&edges, y, x0..x1, &mut spare.0);
                let surfaces = around.row(&surfaces, y, x0..x1, &mut spare.1);
                for ((out, edge), surface) in out.iter_mut().zip(edges).zip(surfaces) {
                    *out = if *surface >= 0.0 { *edge as f32 } else { 1.0 };
                }
            }
        }
        let Some(mask) = outputs.take(Out::Mask, 0) else { return Ok(()) };
        let Some(line) = self.node.width else {
            for (y, out) in (y0..).zip(mask.chunks_exact_mut(width)) {
                let edges = around.row(&edges, y, x0..x1, &mut spare.0);
                let surfaces = around.row(&surfaces, y, x0..x1, &mut spare.1);
                for ((out, edge), surface) in out.iter_mut().zip(edges).zip(surfaces) {
                    *out = if *surface >= 0.0 { self.cut(*edge) as f32 } else { 0.0 };
                }
            }
            return Ok(());
        };
        let mut squares = edges;
        squares.iter_mut().for_each(|edge| *edge *= *edge);
        let mut spare: ([Scratch<f64>; 3], [Scratch<f32>; 3]) = Default::default();
        for (y, out) in (y0..).zip(mask.chunks_exact_mut(width)) {
            let ([a, b, c], [d, e, f]) = (&mut spare.0, &mut spare.1);
            let rows = Rows {
                squares: [
                    around.row(&squares, y - 1, x0..x1, a),
                    around.row(&squares, y, x0 - 1..x1 + 1, b),
                    around.row(&squares, y + 1, x0..x1, c),
                ],
                surfaces: [
                    around.row(&surfaces, y - 1, x0..x1, d),
                    around.row(&surfaces, y, x0 - 1..x1 + 1, e),
                    around.row(&surfaces, y + 1, x0..x1, f),
                ],
            };
            rows.fill(line, out);
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let view = &self.node.view;
        let around = Neighborhood::of(bounding.inputs, view);
        let edge = |there: usize| {
            let toward = BoundedDirection::eye(&self.eye, BoundedVector::point(bounding, view, there));
            BoundedDirection::normal(bounding, view, there).cosine(toward).within(0.0, 1.0)
        };
        let pixels: Vec<usize> = bounding.block.pixels().map(|[x, y]| around.index(x, y)).collect();
        bounding.bound_by(outputs, Out::Edge, 0, |sample| {
            // Where nothing is seen, `edge` is 1.
            let faced = bounding.where_covered(view, pixels[sample], || edge(pixels[sample]).through(|e| 1.0 - e));
            if faced.is_exact() {
                Span::exactly(1.0 - faced.low)
            } else {
                faced.through(|faced| 1.0 - faced).within(0.0, 1.0)
            }
        });
        let mut places = bounding.block.pixels();
        bounding.bound_by(outputs, Out::Mask, 0, |sample| {
            let [x, y] = places.next().unwrap_or_default();
            bounding.where_covered(view, pixels[sample], || match self.node.width {
                None => {
                    let e = edge(pixels[sample]);
                    let ends = [self.cut(e.high), self.cut(e.low)];
                    let cut = Span::of(&ends).wider(LOST).within(0.0, 1.0);
                    if ends[0] == ends[1] && (ends[0] == 0.0 || ends[0] == 1.0) {
                        Span::exactly(ends[0])
                    } else {
                        cut.with(e.clear && self.node.ramp > 0.0)
                    }
                }
                Some(width) => {
                    let seen = |x: i64, y: i64| may_see(bounding, view, around.index(x, y));
                    let squared = |x: i64, y: i64| edge(around.index(x, y)).through(|e| e * e).within(0.0, 1.0);
                    let (here, own) = (seen(x, y), squared(x, y));
                    let mut clear = here.is_exact() && own.clear;
                    let mut changes = [0.0; 2];
                    let mut least = [0.0; 2];
                    for (axis, [dx, dy]) in [[1, 0], [0, 1]].into_iter().enumerate() {
                        let beside = [-1, 1].map(|side| {
                            let there = seen(x + side * dx, y + side * dy);
                            clear &= there.is_exact();
                            (there.low == here.low).then(|| squared(x + side * dx, y + side * dy))
                        });
                        let Some(change) = change(beside[0], own, beside[1]) else { continue };
                        clear &= change.clear;
                        changes[axis] = change.low.abs().max(change.high.abs());
                        least[axis] = if change.holds(0.0) { 0.0 } else { change.low.abs().min(change.high.abs()) };
                    }
                    if !clear {
                        return Span::unclear(0.0, 1.0);
                    }
                    let [steepest, flattest] = [changes, least].map(|[across, down]| libm::hypot(across, down));
                    let line = |squared: f64, slope: f64| Self::line(width, squared, [Some(slope), None]);
                    let span =
                        Span::of(&[line(own.high, flattest), line(own.low, steepest)]).wider(LOST).within(0.0, 1.0);
                    // Where neither the square nor its slope is certainly nonzero, there may be no line or a full one.
                    span.with(flattest > 0.0 || (own.low > 0.0 && steepest == 0.0))
                }
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = &self.node.view;
        if !is_covered(inputs, view) {
            return Ok(vec![Reference::Mask(0.0), Reference::Mask(1.0)]);
        }
        let e = self.edge(inputs);
        let mask = match self.node.width {
            None => self.cut(e),
            Some(width) => {
                let surface = surface_of(inputs, view);
                let squared = |dx: f64, dy: f64| {
                    let there = inputs.moved(dx, dy);
                    let square = |e: f64| e * e;
                    (surface_of(&there, view) == surface).then(|| square(self.edge(&there)))
                };
                let across = change(squared(-1.0, 0.0), e * e, squared(1.0, 0.0));
                let down = change(squared(0.0, -1.0), e * e, squared(0.0, 1.0));
                Self::line(width, e * e, [across, down])
            }
        };
        Ok(vec![Reference::Mask(mask), Reference::Mask(e)])
    }
}
