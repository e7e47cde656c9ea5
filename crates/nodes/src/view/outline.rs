//! Outline: lines along edges of objects and jumps of depth.

use super::seen_rows::{NEAREST, SeenRows, SeenSample};
use super::{Neighborhood, grown, surface_of};
use trochoid_graph::*;
use trochoid_image::{Format, Window};

/// A mask of lines along the edges of objects and along jumps in depth.
///
/// # Formula
/// An edge separates two neighboring pixels if they see different surfaces, or if w = 1/depth differs by more than
/// depth_step · w and by more than the slope on either side explains. One of the two pixels owns the edge. A line is
/// width · thickness − r, limited to [0, 1], at r pixels from the owner's center, on the owner's side.
///
/// # Edge cases
/// 1/depth is linear on planes in perspective, so planes at grazing angles have no lines. The sky counts as a surface
/// of its own, behind everything, and last in the list. Beyond its border, the image repeats. The owner's side
/// consists of the pixels that see its surface and are closer to it than to the other side in 1/depth. Each sample of
/// a pixel is drawn separately.
///
/// # Source
/// Saito and Takahashi, Comprehensible Rendering of 3-D Shapes, 1990.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "1 on the lines."))]
pub(crate) struct Outline {
    /// View to outline.
    view: One<port::View>,
    /// Factor of the width at each place, for example from a Noise; 1 if not connected.
    thickness: Optional<port::Mask>,
    /// Width of the line on the owner's side.
    #[knob(default = 1.5, range = 0.0..=64.0, in_pixels)]
    width: f64,
    /// Side that owns the edge and carries the line: "near", "far", "both", or the "first" or "last" surface in the
    /// Render's list; within one surface, the near side is the first.
    owner: Owner,
    /// Draws lines between different surfaces, and between surfaces and the sky.
    #[knob(default = true)]
    objects: bool,
    /// Groups of surfaces that count as one surface, the first of the group.
    #[list(0..=64)]
    together: Vec<Group>,
    /// Smallest jump in depth that has a line, as a share of the depth.
    #[knob(default = 0.1, range = 1e-6..=1e6)]
    depth_step: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Owner {
    Near,
    Far,
    Both,
    First,
    Last,
}

/// Surfaces that count as one.
#[derive(Clone, Items)]
struct Group {
    /// Indices of the surfaces in the Render's list, counted from 0.
    #[knob(len = 1..=64)]
    surfaces: Vec<f64>,
}

impl Node for Outline {}

impl Outline {
    /// Returns the surface that each surface counts as: the first of its group.
    fn group_of(&self) -> Vec<f64> {
        let mut group_of: Vec<f64> = (0..64).map(f64::from).collect();
        for Group { surfaces } in &self.together {
            for surface in surfaces {
                if let (Some(entry), Some(first)) = (group_of.get_mut(*surface as usize), surfaces.first()) {
                    *entry = *first;
                }
            }
        }
        group_of
    }

    /// Returns the maximum distance of an owner from the pixels it draws on.
    fn reach(&self) -> i64 {
        self.width.ceil() as i64
    }
}

impl Stage for Outline {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&[Channel::Coverage, Channel::Depth])
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Surface.into()
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn regions_of_interest(&self, port: PortId, window: Window, _format: Format) -> Window {
        // The edge of an owner, and the slope beyond it.
        if port == self.view.id() { grown(window, self.reach() + 2) } else { window }
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (reach, side) = (self.reach(), 2 * self.reach() + 1);
        let away = |index: i64| {
            let [x, y] = [index % side - reach, index / side - reach];
            ((x * x + y * y) as f64).sqrt()
        };
        let aways = (0..side * side).map(away).collect();
        Ok(Box::new(PreparedOutline { node: self.clone(), group_of: self.group_of(), aways }))
    }
}

struct PreparedOutline {
    node: Outline,
    /// The surface that each surface counts as.
    group_of: Vec<f64>,
    /// Distances in pixels of the pixels around an owner that it may draw on, row by row.
    aways: Vec<f64>,
}

impl PreparedOutline {
    /// Returns the surface that a surface counts as.
    fn group(&self, surface: f64) -> f64 {
        if surface < 0.0 { surface } else { *self.group_of.get(surface as usize).unwrap_or(&surface) }
    }

    /// Returns what a sample sees, with a group replaced by its first surface.
    fn seen(&self, surface: f64, depth: f64) -> SeenSample {
        SeenSample::new(self.group(surface), depth)
    }

    /// Whether an edge separates `a` from its neighbor `b`; `before` and `after` are the next pixels on the same line.
    #[inline]
    fn parted(&self, before: SeenSample, a: SeenSample, b: SeenSample, after: SeenSample) -> bool {
        if self.node.objects && a.surface != b.surface {
            return true;
        }
        let step = self.node.depth_step * a.w.min(b.w);
        let jump = (a.w - b.w).abs();
        // On planes, each side predicts the other.
        jump > step && (b.w - (2.0 * a.w - before.w)).abs() > step && (a.w - (2.0 * b.w - after.w)).abs() > step
    }

    /// Whether `a` and whether `b` own the edge between them.
    fn owners(&self, a: SeenSample, b: SeenSample) -> [bool; 2] {
        let near = a.w >= b.w;
        let first = if a.surface == b.surface { near } else { a.rank() < b.rank() };
        match self.node.owner {
            Owner::Near => [near, !near],
            Owner::Far => [!near, near],
            Owner::Both => [true; 2],
            Owner::First => [first, !first],
            Owner::Last => [!first, first],
        }
    }

    /// Whether a sample is on the owner's side of an edge.
    #[inline]
    fn belongs(sample: SeenSample, owner: SeenSample, other: SeenSample) -> bool {
        sample.surface == owner.surface && (sample.w - owner.w).abs() <= (sample.w - other.w).abs()
    }

    /// Draws the line of an owner at a place on the mask of a window.
    fn draw(
        &self,
        at: [i64; 2],
        edge: [SeenSample; 2],
        seen: &SeenRows,
        thickness: Option<&[f32]>,
        canvas: &mut Canvas,
    ) {
        let ([x, y], [owner, other], reach, window) = (at, edge, self.node.reach(), canvas.window);
        for py in (y - reach).max(window.y0)..(y + reach + 1).min(window.y1) {
            let aways = &self.aways[((py - y + reach) * (2 * reach + 1)) as usize..];
            for px in (x - reach).max(window.x0)..(x + reach + 1).min(window.x1) {
                let index = (py - window.y0) as usize * window.width() + (px - window.x0) as usize;
                let width = self.node.width * thickness.map_or(1.0, |plane| f64::from(plane[index]));
                let drawn = (width - aways[(px - x + reach) as usize]).clamp(0.0, 1.0) as f32;
                if drawn > canvas.mask[index] && Self::belongs(seen.at(px, py), owner, other) {
                    canvas.mask[index] = drawn;
                }
            }
        }
    }
}

/// The mask of a window.
struct Canvas<'a> {
    window: Window,
    mask: &'a mut [f32],
}

/// Rounding error of widths.
const LOST: f64 = 1e-15;

/// Truth of a statement; `None` if uncertain.
type Certainty = Option<bool>;
const YES: Certainty = Some(true);
const NO: Certainty = Some(false);

fn and(a: Certainty, b: Certainty) -> Certainty {
    match (a, b) {
        (YES, YES) => YES,
        (NO, _) | (_, NO) => NO,
        _ => None,
    }
}

fn not(a: Certainty) -> Certainty {
    a.map(|a| !a)
}

/// Whether a number is above another.
fn above(a: [f64; 2], b: [f64; 2]) -> Certainty {
    if a[0] > b[1] {
        YES
    } else if a[1] <= b[0] {
        NO
    } else {
        None
    }
}

/// Returns the range of |a − b| for numbers in ranges.
fn apart(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let (low, high) = (a[0] - b[1], a[1] - b[0]);
    let slack = LOST * (a[1].abs() + b[1].abs());
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    [(least - slack).max(0.0), low.abs().max(high.abs()) + slack]
}

/// Data that a sample may see: its surface if certain, and a range of 1/depth.
struct SeenRange {
    surface: Option<f64>,
    w: [f64; 2],
}

impl SeenRange {
    /// Whether it sees the same surface as another sample.
    fn is_like(&self, other: &Self) -> Certainty {
        Some(self.surface? == other.surface?)
    }

    /// Whether it belongs to the owner of an edge.
    fn may_belong(&self, owner: &Self, other: &Self) -> Certainty {
        and(self.is_like(owner), not(above(apart(self.w, owner.w), apart(self.w, other.w))))
    }
}

impl PreparedOutline {
    /// Returns what a sample may see, from its coverage, surface and depth.
    fn near(&self, [coverage, surface, depth]: [Span; 3]) -> SeenRange {
        if coverage.high <= 0.0 {
            return SeenRange { surface: Some(-1.0), w: [0.0; 2] };
        }
        let w = [depth.high, depth.low].map(|depth| 1.0 / depth.max(NEAREST));
        if coverage.low > 0.0 && surface.low == surface.high {
            let seen = self.seen(surface.low.max(0.0), depth.low);
            SeenRange { surface: Some(seen.surface), w }
        } else {
            SeenRange { surface: None, w: [0.0, w[1]] }
        }
    }

    /// Whether an edge separates `a` from `b`, as in [`parted`](Self::parted).
    fn may_part(&self, before: &SeenRange, a: &SeenRange, b: &SeenRange, after: &SeenRange) -> Certainty {
        let differs = if self.node.objects { not(a.is_like(b)) } else { NO };
        if differs == YES {
            return YES;
        }
        let step = [0, 1].map(|end| self.node.depth_step * a.w[end].min(b.w[end]));
        let foretold = |from: [f64; 2], by: [f64; 2]| [2.0 * from[0] - by[1], 2.0 * from[1] - by[0]];
        let jumps = and(
            above(apart(a.w, b.w), step),
            and(above(apart(b.w, foretold(a.w, before.w)), step), above(apart(a.w, foretold(b.w, after.w)), step)),
        );
        if jumps == YES {
            YES
        } else if differs == NO {
            jumps
        } else {
            None
        }
    }

    /// Whether an edge's `owner` draws; `is_first` if it comes before the `other` along the axis.
    fn may_own(&self, owner: &SeenRange, other: &SeenRange, is_first: bool) -> Certainty {
        // At equal depths, the first pixel counts as nearer.
        let nearer = if is_first { not(above(other.w, owner.w)) } else { above(owner.w, other.w) };
        let listed = match owner.is_like(other) {
            None => None,
            YES => nearer,
            NO => {
                let rank = |seen: &SeenRange| seen.surface.map(|surface| SeenSample { surface, w: 0.0 }.rank());
                rank(owner).zip(rank(other)).map(|(owner, other)| owner < other)
            }
        };
        match self.node.owner {
            Owner::Near => nearer,
            Owner::Far => not(nearer),
            Owner::Both => YES,
            Owner::First => listed,
            Owner::Last => not(listed),
        }
    }
}

/// Which pixels of a window may have an edge, as sums over all pixels above and to the left.
struct Busy {
    sums: Vec<u32>,
    stride: usize,
}

impl Busy {
    fn new(width: usize, edges: impl Iterator<Item = bool>) -> Self {
        let stride = width + 1;
        let mut sums = vec![0; stride];
        for (index, is_edge) in edges.enumerate() {
            if index % width == 0 {
                sums.push(0);
            }
            let end = sums.len();
            sums.push(u32::from(is_edge) + sums[end - 1] + sums[end - stride] - sums[end - stride - 1]);
        }
        Self { sums, stride }
    }

    /// Returns whether any pixel of a square may have an edge.
    fn any(&self, [x, y]: [usize; 2], side: usize) -> bool {
        let at = |x: usize, y: usize| self.sums[y * self.stride + x];
        at(x + side, y + side) + at(x, y) != at(x + side, y) + at(x, y + side)
    }
}

/// Steps to the right and down.
const STEPS: [(i64, i64); 2] = [(1, 0), (0, 1)];

impl Prepared for PreparedOutline {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        mask.fill(0.0);
        let around = Neighborhood::of(inputs, &self.node.view);
        let depths = inputs.view(&self.node.view, Channel::Depth);
        let thickness = inputs.all(&self.node.thickness).first().and_then(|connection| connection.planes[0]);
        let (window, reach) = (block.window, self.node.reach());
        let seen = SeenRows::new(&around, depths, grown(window, reach + 2), |surface| self.group(f64::from(surface)));
        let mut canvas = Canvas { window, mask };
        // Visit every edge with an owner that may draw within the window.
        let edges = Window::new(window.x0 - reach - 1, window.y0 - reach - 1, window.x1 + reach, window.y1 + reach);
        for (dx, dy) in STEPS {
            seen.visit_jumps(edges, (dx, dy), self.node.objects, self.node.depth_step, |x, y| {
                let (a, b) = (seen.at(x, y), seen.at(x + dx, y + dy));
                if !self.parted(seen.at(x - dx, y - dy), a, b, seen.at(x + 2 * dx, y + 2 * dy)) {
                    return;
                }
                let [first, second] = self.owners(a, b);
                if first {
                    self.draw([x, y], [a, b], &seen, thickness, &mut canvas);
                }
                if second {
                    self.draw([x + dx, y + dy], [b, a], &seen, thickness, &mut canvas);
                }
            });
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let around = Neighborhood::of(bounding.inputs, &self.node.view);
        let [coverage, surface, depth] = [Channel::Coverage, Channel::Surface, Channel::Depth]
            .map(|channel| bounding.channel(&self.node.view, channel));
        let seen: Vec<SeenRange> = (0..around.area())
            .map(|sample| self.near([coverage.at(sample), surface.at(sample), depth.at(sample)]))
            .collect();
        let at = |x: i64, y: i64| &seen[around.index(x, y)];
        let reach = self.node.reach();
        // Visit every horizontal and vertical edge with an owner that may draw within the window.
        let edges = grown(bounding.block.window, reach + 1);
        let part = |x: i64, y: i64| {
            STEPS.map(|(dx, dy)| {
                self.may_part(at(x - dx, y - dy), at(x, y), at(x + dx, y + dy), at(x + 2 * dx, y + 2 * dy))
            })
        };
        let parted: Vec<[Certainty; 2]> = (edges.y0..edges.y1)
            .flat_map(|y| (edges.x0..edges.x1).map(move |x| (x, y)))
            .map(|(x, y)| part(x, y))
            .collect();
        let busy = Busy::new(edges.width(), parted.iter().map(|parted| *parted != [NO; 2]));
        let mut pixels = bounding.block.pixels();
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            let [px, py] = pixels.next().unwrap_or_default();
            let thickness = bounding.known(&self.node.thickness, 0, sample).unwrap_or(Span::exactly(1.0));
            let width = thickness.through(|thickness| self.node.width * thickness);
            // Coverage that is certain, and coverage that is possible.
            let (mut sure, mut most) = (0.0_f64, 0.0_f64);
            let corner = [px - reach - 1 - edges.x0, py - reach - 1 - edges.y0].map(|along| along as usize);
            let reach = if busy.any(corner, 2 * reach as usize + 2) { reach } else { -1 };
            for (x, y) in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))) {
                let away = libm::sqrt((x * x + y * y) as f64);
                let drawn = [width.low, width.high].map(|width| (width - away).clamp(0.0, 1.0));
                if drawn[1] <= most && drawn[0] <= sure {
                    continue;
                }
                for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    let (x, y) = (px + x, py + y);
                    let (left, upper) = (x.min(x + dx), y.min(y + dy));
                    let index = (upper - edges.y0) as usize * edges.width() + (left - edges.x0) as usize;
                    let parted = parted[index][usize::from(dx == 0)];
                    if parted == NO {
                        continue;
                    }
                    let [owner, other] = [at(x, y), at(x + dx, y + dy)];
                    let own = if (x, y) == (px, py) { YES } else { at(px, py).may_belong(owner, other) };
                    let owns = and(parted, and(self.may_own(owner, other, dx + dy > 0), own));
                    sure = if owns == YES { sure.max(drawn[0]) } else { sure };
                    most = if owns == NO { most } else { most.max(drawn[1]) };
                }
            }
            // Uncertainty of the width alone is not a jump.
            let clear = thickness.clear && most - sure <= width.high - width.low + LOST;
            Span { low: sure, high: most, clear }.wider(LOST).within(0.0, 1.0)
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = &self.node.view;
        let reach = self.node.reach();
        let side = 2 * (reach + 2) + 1;
        let from = -(reach + 2);
        let seen: Vec<SeenSample> = (0..side * side)
            .map(|index| {
                let there = inputs.moved((from + index % side) as f64, (from + index / side) as f64);
                self.seen(surface_of(&there, view), there.view(view, Channel::Depth))
            })
            .collect();
        let at = |x: i64, y: i64| seen[((y - from) * side + x - from) as usize];
        let thickness = self.node.thickness.as_ref().map_or(1.0, |source| inputs.scalar(source));
        let mut mask: f64 = 0.0;
        for (x, y) in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))) {
            // The four neighbors of an owner.
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (owner, other) = (at(x, y), at(x + dx, y + dy));
                let (before, after) = (at(x - dx, y - dy), at(x + 2 * dx, y + 2 * dy));
                let forward = dx + dy > 0;
                let owns = if forward { self.owners(owner, other)[0] } else { self.owners(other, owner)[1] };
                if owns && self.parted(before, owner, other, after) && Self::belongs(at(0, 0), owner, other) {
                    let away = ((x * x + y * y) as f64).sqrt();
                    mask = mask.max((self.node.width * thickness - away).clamp(0.0, 1.0));
                }
            }
        }
        Ok(vec![Reference::Mask(mask)])
    }
}
