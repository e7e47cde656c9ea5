//! Shape: a mask of discs, boxes and polygons on the picture.

use crate::field::Screen;
use fearless_simd::{Level, Simd, dispatch};
use trochoid_graph::*;
use trochoid_memory::Scratch;

/// A mask of discs, boxes and polygons; 1 inside any of them.
///
/// # Formula
/// ½ − d/edge, limited to [0, 1], where d is the smallest signed distance to a shape, in pixels, negative inside.
///
/// # Edge cases
/// Coordinates run right and down from the upper left corner in picture heights, from (0, 0) to (width/height, 1).
/// `edge` 0 gives a hard edge that includes the outline. Polygons are closed automatically; where a polygon crosses
/// itself, areas enclosed twice are outside. Round corners do not change the size of a box.
///
/// # Source
/// Signed distance fields; the even-odd rule for polygons.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The mask: 1 inside any of the shapes."))]
#[also_called("Text" => "letters as polygons, or a picture of them by a Read \"as\": \"field\"")]
#[also_called("Roto", "RotoPaint", "Ellipse", "Circle", "Rectangle", "Box", "Radial", "Polygon")]
pub(crate) struct Shape {
    /// Shapes to draw.
    #[list(1..=1000)]
    shapes: Vec<Figure>,
    /// Width of the soft edge; 1 antialiases even with one sample per pixel, 0 gives hard edges.
    #[knob(default = 1.0, range = 0.0..=1e4, in_pixels)]
    edge: f64,
}

/// Types of shapes.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Form {
    Disc,
    Box,
    Polygon,
}

/// A disc, box or polygon.
#[derive(Clone, Items)]
pub(crate) struct Figure {
    /// Type of shape: disc, box or polygon.
    form: Form,
    /// Position of the shape: the center of a disc or box, the origin of a polygon's `points`.
    #[knob(default = [0.0, 0.0], unit = "picture heights")]
    center: [f64; 2],
    /// Radius of the disc.
    #[knob(default = 0.1, range = 0.0..=1e3, unit = "picture heights")]
    radius: f64,
    /// Width and height of the box.
    #[knob(default = [0.2, 0.1], unit = "picture heights")]
    size: [f64; 2],
    /// Radius of the box's rounded corners; at most half its shorter side.
    #[knob(default = 0.0, range = 0.0..=1e3, unit = "picture heights")]
    corner: f64,
    /// Corners of the polygon as x₀, y₀, x₁, y₁, …, relative to `center`.
    #[knob(len = 6..=4000, unit = "picture heights")]
    points: Option<Vec<f64>>,
    /// Rotation about `center`, clockwise.
    #[knob(default = 0.0, range = -3600.0..=3600.0, unit = "degrees")]
    angle: f64,
}

impl Figure {
    /// Returns the coordinates of the polygon's corners; empty if unset.
    fn points(&self) -> &[f64] {
        self.points.as_deref().unwrap_or_default()
    }
}

impl Node for Shape {
    fn check(&self, check: &mut Check<'_>) {
        for (index, shape) in self.shapes.iter().enumerate() {
            let points = shape.points();
            if shape.form == Form::Polygon && (points.len() < 6 || points.len() % 2 != 0) {
                let found = format!("{} numbers as points of shapes[{index}]", points.len());
                check.error(Self::SHAPES, found, "an x and a y for three corners or more", "complete the pairs");
            }
            if shape.form == Form::Box && shape.size.iter().any(|side| *side < 0.0) {
                let found = format!("a negative size of shapes[{index}]");
                check.error(Self::SHAPES, found, "width and height ≥ 0", "write them without a sign");
            }
        }
    }
}

impl Stage for Shape {
    fn is_costly(&self) -> bool {
        true
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let screen = Screen::of(prepare.frame.format);
        let drawn = self.shapes.iter().map(|shape| Drawn::new(shape, screen)).collect();
        Ok(Box::new(PreparedShape { drawn, edge: self.edge }))
    }
}

/// A shape in pixels.
struct Drawn {
    center: [f64; 2],
    /// Sine and cosine of its rotation.
    turn: (f64, f64),
    outline: Outline,
    /// Bounding box on the picture: minimum x and y, maximum x and y.
    bounds: [[f64; 2]; 2],
}

enum Outline {
    Disc(f64),
    /// Half the size without the rounded corners, and the radius of the corners.
    Box([f64; 2], f64),
    Polygon(Polygon),
}

/// Corners of a polygon; the first is repeated at the end.
struct Polygon {
    /// Corners relative to the center, before the rotation.
    corners: Vec<[f64; 2]>,
    /// Corners on the picture.
    seen: Vec<[f64; 2]>,
}

impl Drawn {
    fn new(shape: &Figure, screen: Screen) -> Self {
        // Limit coordinates to values far beyond any picture, so that nothing overflows.
        let pixels = |heights: f64| (heights * screen.height).clamp(-1e12, 1e12);
        let [x, y] = shape.center.map(pixels);
        let turn = libm::sincos(shape.angle.to_radians());
        let around = |reach: f64| [[x - reach, y - reach], [x + reach, y + reach]];
        let (outline, bounds) = match shape.form {
            Form::Box => {
                let [width, height] = shape.size.map(|side| pixels(side) / 2.0);
                let corner = pixels(shape.corner).min(width).min(height);
                (Outline::Box([width - corner, height - corner], corner), around(width + height))
            }
            Form::Polygon => {
                let mut corners: Vec<[f64; 2]> =
                    shape.points().chunks_exact(2).map(|pair| [pixels(pair[0]), pixels(pair[1])]).collect();
                corners.extend(corners.first().copied());
                let (sin, cos) = turn;
                let seen: Vec<[f64; 2]> =
                    corners.iter().map(|[a, b]| [x + a * cos - b * sin, y + a * sin + b * cos]).collect();
                let extreme = |of: fn(f64, f64) -> f64, from: f64| {
                    seen.iter().fold([from; 2], |all, at| [of(all[0], at[0]), of(all[1], at[1])])
                };
                let bounds = [extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY)];
                (Outline::Polygon(Polygon { corners, seen }), bounds)
            }
            Form::Disc => {
                let radius = pixels(shape.radius);
                (Outline::Disc(radius), around(radius))
            }
        };
        Self { center: [x, y], turn, outline, bounds }
    }

    /// Transforms a point of the picture into the shape's own coordinates, before its rotation and translation.
    #[inline(always)]
    fn place(&self, at: [f64; 2]) -> [f64; 2] {
        let [x, y] = [at[0] - self.center[0], at[1] - self.center[1]];
        let (sin, cos) = self.turn;
        [x * cos + y * sin, y * cos - x * sin]
    }

    /// Returns whether a point of the picture lies within a distance of the bounding box.
    fn may_reach(&self, at: [f64; 2], reach: f64) -> bool {
        let [low, high] = self.bounds;
        (0..2).all(|axis| at[axis] >= low[axis] - reach && at[axis] <= high[axis] + reach)
    }

    /// Returns the signed distance in pixels, negative inside.
    #[inline(always)]
    fn distance(&self, at: [f64; 2]) -> f64 {
        let place = self.place(at);
        match &self.outline {
            Outline::Disc(radius) => length(place) - radius,
            Outline::Box(half, corner) => {
                let beyond = [place[0].abs() - half[0], place[1].abs() - half[1]];
                let inside = beyond[0].max(beyond[1]).min(0.0);
                length(beyond.map(|side| side.max(0.0))) + inside - corner
            }
            Outline::Polygon(polygon) => polygon.signed(place, 0..polygon.corners.len() - 1),
        }
    }
}

impl Polygon {
    /// Returns the signed distance to the nearest of the given sides, negative inside the polygon.
    fn signed(&self, place: [f64; 2], sides: impl IntoIterator<Item = usize>) -> f64 {
        let of = |side: usize| (self.corners[side], self.corners[side + 1]);
        let nearest = sides.into_iter().map(of).map(|(a, b)| squared_away(place, a, b)).fold(f64::INFINITY, f64::min);
        let nearest = nearest.sqrt();
        let inside = self.corners.windows(2).fold(false, |inside, side| inside ^ crosses(place, side[0], side[1]));
        if inside { -nearest } else { nearest }
    }

    /// Returns the sides that come within `reach` of a row of the picture, with the range of columns where they do.
    fn near(&self, row: f64, reach: f64) -> Scratch<(std::ops::RangeInclusive<f64>, usize)> {
        let mut near = Scratch::new();
        for (index, side) in self.seen.windows(2).enumerate() {
            let ([ax, ay], [bx, by]) = (side[0], side[1]);
            if ay.max(by) < row - reach || ay.min(by) > row + reach {
                continue;
            }
            // The part of the side within the band; the whole side if it runs along the row.
            let at = |y: f64| if ay == by { ax } else { ax + ((y - ay) / (by - ay)).clamp(0.0, 1.0) * (bx - ax) };
            let ends = if (ay - by).abs() <= reach { [ax, bx] } else { [at(row - reach), at(row + reach)] };
            near.push((ends[0].min(ends[1]) - reach..=ends[0].max(ends[1]) + reach, index));
        }
        near.sort_by(|a, b| a.0.start().total_cmp(b.0.start()));
        near
    }
}

#[inline(always)]
fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// Returns the square of the distance from a point to a side.
fn squared_away(place: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (side, from) = ([b[0] - a[0], b[1] - a[1]], [place[0] - a[0], place[1] - a[1]]);
    let squared = side[0] * side[0] + side[1] * side[1];
    let part = if squared > 0.0 { ((from[0] * side[0] + from[1] * side[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let [x, y] = [from[0] - part * side[0], from[1] - part * side[1]];
    x * x + y * y
}

/// Returns whether the ray to the right of a point crosses a side.
fn crosses(place: [f64; 2], a: [f64; 2], b: [f64; 2]) -> bool {
    (a[1] > place[1]) != (b[1] > place[1]) && place[0] < a[0] + (place[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
}

/// Samples of a row that are drawn together, in vectors.
const LANES: usize = 8;

struct PreparedShape {
    drawn: Vec<Drawn>,
    edge: f64,
}

impl PreparedShape {
    /// Returns the distance from a shape's bounding box beyond which it is not drawn: half the edge, and one more pixel
    /// for rounding.
    fn reach(&self) -> f64 {
        self.edge / 2.0 + 1.0
    }

    /// Returns the mask at a position in pixels, in f64.
    fn truth(&self, at: [f64; 2]) -> f64 {
        let near = self.drawn.iter().filter(|shape| shape.may_reach(at, self.reach()));
        self.mask(near.map(|shape| shape.distance(at)).fold(f64::INFINITY, f64::min))
    }

    /// Draws a disc or a box over samples of a row, from the one in the column `x` on, which are shifted by `offset`.
    fn draw(&self, shape: &Drawn, [x, y]: [f64; 2], offset: f64, row: &mut [f32]) {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for (start, out) in (0..).step_by(LANES).zip(row.chunks_mut(LANES)) {
                let mut distances = [0.0; LANES];
                for (lane, distance) in distances.iter_mut().enumerate() {
                    *distance = shape.distance([x + (start + lane) as f64 + offset, y]);
                }
                let mut masks = [0.0; LANES];
                for (mask, distance) in masks.iter_mut().zip(distances) {
                    *mask = self.mask(distance) as f32;
                }
                for (out, mask) in out.iter_mut().zip(masks) {
                    *out = out.max(mask);
                }
            }
        }));
    }

    #[inline(always)]
    fn mask(&self, distance: f64) -> f64 {
        if self.edge > 0.0 {
            (0.5 - distance / self.edge).clamp(0.0, 1.0)
        } else if distance <= 0.0 {
            1.0
        } else {
            0.0
        }
    }
}

impl Prepared for PreparedShape {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        mask.fill(0.0);
        let window = block.window;
        for shape in &self.drawn {
            // Skip pixels beyond the shape and its edge.
            let reach = self.reach();
            let [low, high] = shape.bounds;
            let within = |axis: usize, first: i64, end: i64| {
                let from = (low[axis] - reach - block.offset[axis]).floor().max(first as f64) as i64;
                let to = (high[axis] + reach - block.offset[axis]).ceil().min((end - 1) as f64) as i64;
                from..to + 1
            };
            let columns = within(0, window.x0, window.x1);
            for y in within(1, window.y0, window.y1) {
                let row = &mut mask[(y - window.y0) as usize * window.width()..][..window.width()];
                let at = y as f64 + block.offset[1];
                let place = |x: i64| shape.place([x as f64 + block.offset[0], at]);
                let Outline::Polygon(polygon) = &shape.outline else {
                    if !columns.is_empty() {
                        let [first, end] = [columns.start, columns.end].map(|x| (x - window.x0) as usize);
                        self.draw(shape, [columns.start as f64, at], block.offset[0], &mut row[first..end]);
                    }
                    continue;
                };
                let mut draw = |x: i64, distance: f64| {
                    let out = &mut row[(x - window.x0) as usize];
                    *out = out.max(self.mask(distance) as f32);
                };
                let near = polygon.near(at, reach);
                let (mut x, mut begun) = (columns.start, 0);
                while x < columns.end {
                    let here = x as f64 + block.offset[0];
                    begun += near[begun..].iter().take_while(|(span, _)| *span.start() <= here).count();
                    let beside = near[..begun].iter().filter(|(span, _)| here <= *span.end()).map(|(_, side)| *side);
                    if beside.clone().next().is_some() {
                        draw(x, polygon.signed(place(x), beside));
                        x += 1;
                        continue;
                    }
                    // Up to the next side, all pixels are inside or all are outside, and too far away for the soft
                    // edge.
                    let next = near.get(begun).map_or(f64::INFINITY, |(span, _)| *span.start() - block.offset[0]);
                    let end = (next.ceil().min(columns.end as f64) as i64).max(x + 1);
                    if polygon.signed(place(x), []) < 0.0 {
                        (x..end).for_each(|x| draw(x, f64::NEG_INFINITY));
                    }
                    x = end;
                }
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_at(outputs, SoleOutput, 0, |at| self.truth(at));
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Mask(self.truth(inputs.at))])
    }
}
