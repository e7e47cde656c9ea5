//! Strokes: repaints an image with brush strokes.

use crate::filter::{fill_together, kind, numbers, value};
use crate::paint::{
    BlockSurroundings, Brush, Canvas, Cells, LANES, Layer, LayerKnobs, MARGIN, RESTS, ReferenceSurroundings, STRIDES,
    Stroke, StrokeInputs, StrokeSettings, StrokeSurroundings, index as place, layers, pixels, placed, reach, sample,
    seeds_of,
};
use fearless_simd::{Level, Simd, dispatch};
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;

/// Repaints an image with brush strokes; each takes one color of the image and follows a flow.
///
/// # Formula
/// Strokes are painted one over another, layer by layer, the first layer at the bottom: (1 − w)·below + w·c, where c is
/// the image's value at the stroke's source. With positions a along and b across the stroke from −1 to 1, and b shifted
/// by bend·a² where the flow turns: w = opacity · min(1, 2.2(1 − a²)(1 − b²)) · (1 − 0.55·bristle·(1 − hair)) · (1 −
/// 0.8·bristle·max(a, 0)·hair), hair(b) in [0, 1]. Seeds are the points of square grids on the surface at rest, one per
/// cell of side 2^ℓ, taken from the two levels ℓ nearest to one point per `spacing`² pixels; the levels fade into each
/// other. Everything else about strokes is under Definitions in the book.
///
/// # Edge cases
/// Seeds are fixed on the surface, so strokes move with it and neither boil nor swim; where no surface is seen, they
/// are fixed on the picture. With a spacing of 5 pixels or more, only every second pixel is searched for seeds. Strokes
/// end at edges of the surface and at jumps in depth, and take their color from their own side; only the fraction
/// `lost` ignores edges. Strokes fade out next to surfaces that hide their seed, and at the picture's border. Where no
/// stroke covers it, the image itself shows. Weights depend on geometry alone and are the same for all colors: a
/// picture in other colors has the same strokes, and no color is added to the palette. Each sample of a pixel is
/// painted separately; with `shading` pixel, all samples use the strokes found for the first.
///
/// # Source
/// Meier, Painterly Rendering for Animation, 1996; Litwinowicz, Processing Images and Video for an Impressionist Effect, 1997;
/// Hertzmann, Painterly Rendering with Curved Brush Strokes of Multiple Sizes, 1998.
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 2, output(image: Kind::ANY = "The painted image, of the same kind."))]
pub(crate) struct Strokes {
    /// Image to repaint.
    image: One<port::Image>,
    #[items]
    stroke_inputs: StrokeInputs,
    /// Layers of strokes, bottom layer first; usually the coarsest.
    #[list(1..=8)]
    layers: Vec<LayerKnobs>,
    /// Picture height for which the layers' sizes in pixels are chosen. Strokes scale with the actual height, so a
    /// draft at half the size has the same strokes. By default, sizes are in pixels of the picture itself.
    #[knob(range = 1..=1 << 20, unit = "pixels", picture_height)]
    height: Option<i64>,
    /// Space in which strokes are fixed: rest (points of the surface at rest) or screen (the picture). Views from passes
    /// have no points at rest and need screen.
    anchor: Anchor,
    /// Smallest jump in depth that counts as an edge, as a fraction of the depth.
    #[knob(default = 0.12, range = 1e-3..=1e3)]
    edge: f64,
    /// Fraction of the strokes that ignore edges and continue over them.
    #[knob(default = 0.3, range = 0.0..=1.0)]
    lost: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Space in which strokes are fixed.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Anchor {
    Rest,
    Screen,
}

impl Strokes {
    /// Returns whether seeds are fixed to surfaces.
    fn is_on_surfaces(&self) -> bool {
        self.stroke_inputs.view.is_some() && self.anchor == Anchor::Rest
    }

    /// Returns the layers in pixels of a format, bottom layer first.
    fn layers(&self, format: Format) -> Scratch<Layer> {
        layers(&self.layers, self.height, self.seed, format)
    }
}

impl Node for Strokes {
    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        // Seconds for a sample, for a stroke, and for each sample that a stroke covers.
        const SAMPLE: f64 = 2.6e-7;
        const STROKE: f64 = 1.5e-6;
        const COVERED: f64 = 2.0e-9;
        let layer = |layer: &Layer| {
            let strokes = 1.0 / (layer.spacing * layer.spacing);
            // Lengths and widths are between half and all of the largest, hence 0.56 of its area on average.
            strokes * (STROKE + COVERED * 0.56 * 4.0 * layer.half[0] * layer.half[1])
        };
        let samples = format.window().area() as f64 * f64::from(format.samples());
        let seconds = samples * (SAMPLE + self.layers(format).iter().map(layer).sum::<f64>());
        let remedy = "raise \"spacing\", or lower \"length\" and \"width\": each place is painted \
                      length · width / spacing² times; or use fewer samples or pixels";
        Some(Work { seconds, item: Self::LAYERS, remedy })
    }
}

impl Stage for Strokes {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        let rests = if self.is_on_surfaces() { ChannelSet::of(&RESTS) } else { ChannelSet::EMPTY };
        rests.union(Channel::Coverage.into())
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&[Channel::Depth, Channel::Surface])
    }

    fn regions_of_interest(&self, _port: PortId, window: Window, format: Format) -> Window {
        let by = reach(&self.layers(format)) + MARGIN + 1 + STRIDES[1];
        Window::new(window.x0 - by, window.y0 - by, window.x1 + by, window.y1 + by)
    }

    fn regions_after_find(&self, _port: PortId, window: Window, _format: Format) -> Window {
        window
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedStrokes {
            image: self.image.clone(),
            stroke_inputs: self.stroke_inputs.clone(),
            kind: kind(prepare),
            picture: prepare.frame.format.window(),
            layers: self.layers(prepare.frame.format),
            settings: StrokeSettings::new(self.edge, self.lost),
            on_surfaces: self.is_on_surfaces(),
        }))
    }
}

/// Width and height of the parts into which a block is split for painting.
const PART: (usize, usize) = (128, 64);

struct PreparedStrokes {
    image: One<port::Image>,
    stroke_inputs: StrokeInputs,
    kind: Kind,
    picture: Window,
    layers: Scratch<Layer>,
    settings: StrokeSettings,
    on_surfaces: bool,
}

impl PreparedStrokes {
    /// Returns the upper left pixels of all patches of side `stride` whose strokes may reach into a window.
    fn near(&self, window: Window, reach: i64, stride: i64) -> Window {
        let picture = self.picture;
        Window::new(
            (window.x0 - reach - stride).max(picture.x0),
            (window.y0 - reach - stride).max(picture.y0),
            (window.x1 + reach).min(picture.x1 - stride),
            (window.y1 + reach).min(picture.y1 - stride),
        )
    }

    /// Returns every stroke that may reach a window, with the index of its layer.
    fn strokes(
        &self,
        window: Window,
        around: &impl Canvas,
        check_cancelled: impl Fn() -> Result<(), NodeError>,
    ) -> Result<Scratch<(usize, Stroke)>, NodeError> {
        let mut strokes = Scratch::new();
        for stride in STRIDES {
            // Strokes of fine layers reach less far, so each layer has its own window.
            let mut layers: Scratch<(usize, &Layer, Window, Cells)> = Scratch::new();
            for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.stride() == stride) {
                layers.push((index, layer, self.near(window, reach(&[*layer]), stride), Cells::new(layer.key)));
            }
            let Some(all) = layers.iter().map(|(_, _, near, _)| *near).reduce(Window::union) else { continue };
            // Align the patches to the same grid for every window.
            let [x0, y0] = [all.x0, all.y0].map(|first| first + (-first).rem_euclid(stride));
            for y in (y0..all.y1).step_by(stride as usize) {
                check_cancelled()?;
                let mut left = [around.corner(x0, y), around.corner(x0, y + stride)];
                for x in (x0..all.x1).step_by(stride as usize) {
                    let right = [around.corner(x + stride, y), around.corner(x + stride, y + stride)];
                    let corners = [left[0], right[0], left[1], right[1]];
                    left = right;
                    let Some(patch) = placed(corners, stride as f64, self.settings.step) else { continue };
                    let [size, ..] = around.shares(x, y);
                    for (index, layer, near, cells) in &mut layers {
                        if !near.contains(x, y) {
                            continue;
                        }
                        seeds_of(&patch, pixels(layer, size), cells, |seed| {
                            let stroke = Stroke::new(layer, &self.settings, &seed, [x, y], around);
                            strokes.extend(stroke.map(|stroke| (*index, stroke)));
                        });
                    }
                }
            }
        }
        Ok(strokes)
    }
}

/// Strokes accumulated over a part of a block from the top down, and the fraction of the image that is still visible.
#[derive(Default)]
struct Sums {
    part: Window,
    /// Channels in which a stroke or the image differs from 0.
    is_used: Scratch<bool>,
    /// Of these channels the weighted sums of the strokes' values.
    sums: Scratch<Scratch<f64>>,
    left: Scratch<f64>,
    /// Weights of the stroke that is being added, at the pixels of a row.
    weights: Scratch<[f64; LANES]>,
}

impl Sums {
    /// Starts with another part; the memory stays.
    fn begin(&mut self, part: Window, is_used: Scratch<bool>) {
        self.sums.resize_with(is_used.len(), Scratch::new);
        // Groups of lanes may end behind the last row.
        let area = part.area() + LANES;
        for (sums, _) in self.sums.iter_mut().zip(&is_used).filter(|(_, is_used)| **is_used) {
            sums.clear();
            sums.resize(area, 0.0);
        }
        self.left.clear();
        self.left.resize(area, 1.0);
        (self.part, self.is_used) = (part, is_used);
    }

    /// Adds a stroke to pixels of a row, given its coverage of each pixel and its values by channel.
    #[inline(always)]
    fn add(&mut self, start: usize, covers: &[[f32; LANES]], values: &[(usize, f64)]) {
        let pixels = start..start + covers.len() * LANES;
        self.weights.resize(covers.len(), [0.0; LANES]);
        let left = self.left[pixels.clone()].as_chunks_mut::<LANES>().0;
        for ((weights, left), covers) in self.weights.iter_mut().zip(left).zip(covers) {
            (*weights, *left) = shared(*left, *covers);
        }
        for (channel, value) in values.iter().filter(|(channel, _)| self.is_used[*channel]) {
            let sums = self.sums[*channel][pixels.clone()].as_chunks_mut::<LANES>().0;
            if value.is_finite() {
                for (sums, weights) in sums.iter_mut().zip(&self.weights) {
                    *sums = weighted(*sums, *weights, *value);
                }
                continue;
            }
            // 0 times infinity counts as 0.
            let pixels = sums.as_flattened_mut().iter_mut().zip(self.weights.as_flattened());
            pixels.filter(|(_, weight)| **weight > 0.0).for_each(|(sum, weight)| *sum += weight * value);
        }
    }
}

/// Returns the weights of a stroke at a group of pixels, and what it leaves there.
#[inline(always)]
fn shared(mut left: [f64; LANES], covers: [f32; LANES]) -> ([f64; LANES], [f64; LANES]) {
    let mut weights = [0.0; LANES];
    for lane in 0..LANES {
        weights[lane] = f64::from(covers[lane]) * left[lane];
        left[lane] -= weights[lane];
    }
    (weights, left)
}

/// Returns sums with the value of a stroke added.
#[inline(always)]
fn weighted(mut sums: [f64; LANES], weights: [f64; LANES], value: f64) -> [f64; LANES] {
    for lane in 0..LANES {
        sums[lane] += weights[lane] * value;
    }
    sums
}

/// Strokes from the top down, and the image's values at their sources.
struct BlockStrokes {
    brushes: Scratch<Brush>,
    /// Of every stroke, the channels that are not 0, with their values. Recipes have many channels, of which most are.
    values: Scratch<(usize, f64)>,
    /// Of every stroke, the end of its values.
    ends: Scratch<usize>,
    /// Offset within its pixel of the sample they were found for.
    offset: [f64; 2],
}

impl BlockStrokes {
    /// Returns the values of a stroke that are not 0, by channel.
    fn values(&self, index: usize) -> &[(usize, f64)] {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.values[start..self.ends[index]]
    }
}

/// Returns of each channel of an image whether it differs from 0 anywhere in a window.
fn used(level: Level, image: &Connection<'_>, channels: usize, window: Window) -> Scratch<bool> {
    let mut used = Scratch::of(false, channels);
    dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
        for (channel, used) in used.iter_mut().enumerate() {
            *used = !is_zero(image, channel, window);
        }
    }));
    used
}

/// Whether a channel of an image is 0 all over a window.
#[inline(always)]
fn is_zero(image: &Connection<'_>, channel: usize, window: Window) -> bool {
    let Some(Some(plane)) = image.planes.get(channel) else { return true };
    // Beyond the image its border repeats.
    let x0 = window.x0.clamp(image.window.x0, image.window.x1 - 1);
    let x1 = window.x1.clamp(x0 + 1, image.window.x1);
    // A closure would not be compiled for the vectors of the caller.
    for y in window.y0..window.y1 {
        let row = &plane[place(image.window, x0, y)..][..(x1 - x0) as usize];
        // Without leaving early, rows are compared as vectors.
        if row.iter().fold(0, |bits, value| bits | value.to_bits()) << 1 != 0 {
            return false;
        }
    }
    true
}

/// Returns the pixels of a channel of an image from column `x0` up to `x1`, in row `y`. Beyond the image its border
/// repeats: then they are copied to `own`.
#[inline(always)]
fn own_row<'r>(plane: &'r [f32], window: Window, [x0, x1]: [i64; 2], y: i64, own: &'r mut Vec<f32>) -> &'r [f32] {
    if window.x0 <= x0 && x1 <= window.x1 {
        return &plane[place(window, x0, y)..][..(x1 - x0) as usize];
    }
    own.clear();
    own.extend((x0..x1).map(|x| plane[place(window, x, y)]));
    own
}

/// Returns the columns from the first to behind the last pixel that counts in a row of a part of a block.
fn counted_in(block: &Block<'_>, part: Window, y: i64) -> [i64; 2] {
    let start = place(block.window, part.x0, y);
    let counts = |column: &usize| block.counts(start + column);
    let first = (0..part.width()).find(counts).unwrap_or(part.width());
    let last = (first..part.width()).rfind(counts).map_or(first, |last| last + 1);
    [part.x0 + first as i64, part.x0 + last as i64]
}

impl PreparedStrokes {
    /// Finds the strokes of a block, for the sample that the inputs belong to.
    fn block_strokes(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<BlockStrokes, NodeError> {
        let image = &inputs.all(&self.image)[0];
        let planes = BlockSurroundings::new(&self.stroke_inputs, self.picture, self.on_surfaces, block, inputs);
        let mut strokes = self.strokes(block.window, &planes, || inputs.check_cancelled())?;
        // A surface that is placed several times has equal keys at several positions; the position breaks the tie.
        strokes.sort_unstable_by(|(layer, a), (other, b)| {
            let at = |axis: usize| a.at[axis].total_cmp(&b.at[axis]);
            other.cmp(layer).then(b.order.cmp(&a.order)).then_with(|| at(1)).then_with(|| at(0))
        });
        let is_used = used(Level::new(), image, self.kind.channels(), image.window);
        let channels: Scratch<usize> = (0..is_used.len()).filter(|channel| is_used[*channel]).collect();
        let (mut values, mut ends) = (Scratch::new(), Scratch::new());
        for (_, stroke) in &strokes {
            let [x, y] = stroke.source;
            let value = |channel: &usize| (*channel, sample(Some(image), *channel, x, y).unwrap_or(0.0));
            values.extend(channels.iter().map(value).filter(|(_, value)| *value != 0.0));
            ends.push(values.len());
        }
        let brushes = strokes.iter().map(|(_, stroke)| Brush::new(stroke)).collect();
        Ok(BlockStrokes { brushes, values, ends, offset: block.offset })
    }
}

impl Prepared for PreparedStrokes {
    fn find(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<Option<SharedResult>, NodeError> {
        Ok(Some(Arc::new(self.block_strokes(block, inputs)?)))
    }

    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let image = &inputs.all(&self.image)[0];
        let around = BlockSurroundings::new(&self.stroke_inputs, self.picture, self.on_surfaces, block, inputs);
        let own;
        let block_strokes = match inputs.found::<BlockStrokes>() {
            Some(found) => found,
            None => {
                own = self.block_strokes(block, inputs)?;
                &own
            }
        };
        let shift = [0, 1].map(|axis| block.offset[axis] - block_strokes.offset[axis]);
        let area = window.area();
        let width = window.width();
        let mut covers = Scratch::of([0.0f32; LANES], PART.0.div_ceil(LANES));
        let (flat, far) = (Scratch::of(-1.0f32, width), Scratch::of(f32::INFINITY, width));
        let level = Level::new();
        // Paint part by part, so that the sums stay in the cache; results do not depend on where parts end.
        let parts: Scratch<Window> = window.tiles(PART.0, PART.1).collect();
        let across = width.div_ceil(PART.0);
        let mut on: Scratch<Scratch<u32>> = parts.iter().map(|_| Scratch::new()).collect();
        for (index, brush) in block_strokes.brushes.iter().enumerate() {
            let bounds = brush.bounds(brush.seen_from(shift)).intersect(window);
            if bounds.is_empty() {
                continue;
            }
            let column = |x: i64| (x - window.x0) as usize / PART.0;
            let row = |y: i64| (y - window.y0) as usize / PART.1;
            for row in row(bounds.y0)..=row(bounds.y1 - 1) {
                for column in column(bounds.x0)..=column(bounds.x1 - 1) {
                    on[row * across + column].push(index as u32);
                }
            }
        }
        let (mut sums, mut own, black) = (Sums::default(), Scratch::new(), Scratch::of(0.0f32, width));
        let mut counted = Scratch::new();
        fill_together(self.kind, area, outputs, |planes| {
            for (&part, on) in parts.iter().zip(&on) {
                inputs.check_cancelled()?;
                counted.clear();
                counted.extend((part.y0..part.y1).map(|y| counted_in(block, part, y)));
                if counted.iter().all(|[from, to]| from >= to) {
                    continue;
                }
                let mut is_used = used(level, image, planes.len(), part);
                for index in on {
                    block_strokes.values(*index as usize).iter().for_each(|(channel, _)| is_used[*channel] = true);
                }
                is_used.iter_mut().zip(&*planes).for_each(|(is_used, plane)| *is_used &= plane.is_some());
                sums.begin(part, is_used);
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    for index in on {
                        let brush = &block_strokes.brushes[*index as usize];
                        let values = block_strokes.values(*index as usize);
                        let at = brush.seen_from(shift);
                        let bounds = brush.bounds(at);
                        for y in bounds.y0.max(part.y0)..bounds.y1.min(part.y1) {
                            let [from, to] = counted[(y - part.y0) as usize];
                            let [begin, end] = brush.columns(at, y);
                            let (x0, x1) = (begin.max(from), (end + 1).min(to));
                            if x0 >= x1 {
                                continue;
                            }
                            let count = (x1 - x0) as usize;
                            let [parts, depths] = around.row([x0, x1], y);
                            let (parts, depths) = (parts.unwrap_or(&flat[..count]), depths.unwrap_or(&far[..count]));
                            let from = [begin as f64 - at[0], y as f64 - at[1]];
                            let covers = &mut covers[..count.div_ceil(LANES)];
                            brush.cover_row(from, x0 - begin, parts, depths, covers);
                            sums.add(place(part, x0, y), covers, values);
                        }
                    }
                    for (channel, plane) in planes.iter_mut().enumerate() {
                        let Some(plane) = plane else { continue };
                        let under = image.planes.get(channel).copied().flatten();
                        for y in part.y0..part.y1 {
                            let out = &mut plane[place(window, part.x0, y)..][..part.width()];
                            if !sums.is_used[channel] {
                                out.fill(0.0);
                                continue;
                            }
                            let row = [part.x0, part.x1];
                            let own = under.map_or(&black[..], |plane| own_row(plane, image.window, row, y, &mut own));
                            let pixels = place(part, part.x0, y)..;
                            let (sums, left) = (&sums.sums[channel][pixels.clone()], &sums.left[pixels]);
                            for (((out, own), sum), left) in out.iter_mut().zip(own).zip(sums).zip(left) {
                                let sum = sum + if *left > 0.0 { left * f64::from(*own) } else { 0.0 };
                                // +∞ and −∞ have no mean: keep the image.
                                *out = if sum.is_nan() { *own } else { sum as f32 };
                            }
                        }
                    }
                }));
            }
            Ok(())
        })
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound(
            "where strokes begin, end and hide one another depends on the view in a wide neighborhood, with jumps",
        ))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let seen = ReferenceSurroundings::new(&self.stroke_inputs, self.picture, self.on_surfaces, inputs);
        let [x, y] = seen.pixel;
        let first = inputs.first();
        let found_at = ReferenceSurroundings::new(&self.stroke_inputs, self.picture, self.on_surfaces, &first);
        let mut strokes = self.strokes(Window::new(x, y, x + 1, y + 1), &found_at, || Ok(()))?;
        let shift = [0, 1].map(|axis| inputs.at[axis] - first.at[axis]);
        strokes.sort_by(|(layer, a), (other, b)| {
            let at = |axis: usize| b.at[axis].total_cmp(&a.at[axis]);
            layer.cmp(other).then(a.order.cmp(&b.order)).then_with(|| at(1)).then_with(|| at(0))
        });
        let image = &self.image;
        let own = numbers(inputs, image);
        let mut painted = own.clone();
        for (_, stroke) in &strokes {
            let stroke = stroke.seen_from(shift);
            let from = [x as f64 - stroke.at[0], y as f64 - stroke.at[1]];
            let w = stroke.covers(from, seen.part(x, y), seen.depth(x, y));
            if w == 0.0 {
                continue;
            }
            let source = first.moved((stroke.source[0] - x) as f64, (stroke.source[1] - y) as f64);
            for (below, color) in painted.iter_mut().zip(numbers(&source, image)) {
                *below = if w < 1.0 { (1.0 - w) * *below + w * color } else { color };
            }
        }
        for (painted, own) in painted.iter_mut().zip(own).filter(|(painted, _)| painted.is_nan()) {
            *painted = own;
        }
        Ok(vec![value(self.kind, painted)])
    }
}
