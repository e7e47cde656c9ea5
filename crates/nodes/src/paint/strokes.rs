//! Strokes: repaints an image with brush strokes.

use super::canvas::ViewPlanes;
use super::found::BlockStrokes;
use super::groups::{PART, Spot, parts_in};
use super::painting::Painting;
use super::planes::used;
use super::{
    Layer, LayerKnobs, MARGIN, RESTS, ReferenceSurroundings, STRIDES, StrokeInputs, StrokeSettings, StrokeSurroundings,
    layers, pixels, reach,
};
use crate::filter::{fill_together, kind, numbers, value};
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

/// Size of strokes that stands for those of a mask in estimates of memory: few pictures have smaller ones throughout.
const SMALL: f64 = 0.33;

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
        grown(window, &self.layers(format))
    }

    fn takes_whole_rows(&self) -> bool {
        true
    }

    fn regions_after_find(&self, _port: PortId, window: Window, _format: Format) -> Window {
        window
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let layers = self.layers(context.frame.format);
        // Smaller strokes lie nearer together. A mask makes some of them small.
        let size = match self.stroke_inputs.size.as_ref() {
            None => 1.0,
            Some(Source::Number(size)) => size[0],
            Some(_) => SMALL,
        };
        // Seeds on surfaces do not come nearer or part gradually: some of them wait until there is room.
        let waiting = if self.is_on_surfaces() { 2.0 } else { 1.0 };
        let strokes = waiting * layers.iter().map(|layer| pixels(layer, size).recip()).sum::<f64>();
        let channels = context.wanted.iter().flatten().filter(|wanted| **wanted).count();
        let [working, found] =
            BlockStrokes::bytes_of_stroke(channels).map(|bytes| (strokes * bytes as f64).ceil() as u64);
        MemoryUse::default().thread(working, u64::MAX).found(found)
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

/// Returns the window whose pixels may decide what strokes of some layers show in another.
pub(super) fn grown(window: Window, layers: &[Layer]) -> Window {
    let by = reach(layers) + MARGIN + 1 + STRIDES[1];
    Window::new(window.x0 - by, window.y0 - by, window.x1 + by, window.y1 + by)
}

/// Strokes of a frame.
pub(super) struct PreparedStrokes {
    pub(super) image: One<port::Image>,
    pub(super) stroke_inputs: StrokeInputs,
    pub(super) kind: Kind,
    pub(super) picture: Window,
    pub(super) layers: Scratch<Layer>,
    pub(super) settings: StrokeSettings,
    pub(super) on_surfaces: bool,
}

impl Prepared for PreparedStrokes {
    fn find(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<Option<SharedResult>, NodeError> {
        Ok(Some(Arc::new(self.block_strokes(block, inputs)?)))
    }

    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let image = &inputs.all(&self.image)[0];
        let own;
        let block_strokes = match inputs.found::<BlockStrokes>() {
            Some(found) => found,
            None => {
                own = self.block_strokes(block, inputs)?;
                &own
            }
        };
        let BlockStrokes { brushes, offset, .. } = block_strokes;
        let shift = [0, 1].map(|axis| block.offset[axis] - offset[axis]);
        let parts: Scratch<Window> = window.tiles(PART.0, PART.1).collect();
        let across = window.width().div_ceil(PART.0);
        let mut spots: Scratch<Scratch<Spot>> = parts.iter().map(|_| Scratch::new()).collect();
        for (stroke, brush) in brushes.iter().enumerate() {
            let bounds = brush.bounds(brush.seen_from(shift)).intersect(window);
            if bounds.is_empty() {
                continue;
            }
            let [rows, columns] = parts_in(bounds, window);
            for row in rows {
                for column in columns.clone() {
                    let part = row * across + column;
                    spots[part].push(Spot::of(stroke as u32, bounds, parts[part]));
                }
            }
        }
        let (level, view) = (Level::new(), ViewPlanes::of(&self.stroke_inputs, self.picture, inputs));
        let mut painting = Painting::default();
        fill_together(self.kind, window.area(), outputs, |planes| {
            for (&part, spots) in parts.iter().zip(&mut spots) {
                inputs.check_cancelled()?;
                painting.counted.find(part, block);
                if !painting.counted.any() {
                    continue;
                }
                spots.retain(|spot| painting.counted.shows(*spot));
                let mut is_used = used(level, image, planes.len(), part);
                for spot in &*spots {
                    if is_used.iter().all(|is_used| *is_used) {
                        break;
                    }
                    block_strokes.values(spot.stroke).iter().for_each(|(channel, _)| is_used[*channel] = true);
                }
                is_used.iter_mut().zip(&*planes).for_each(|(is_used, plane)| *is_used &= plane.is_some());
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    painting.prime(&is_used, &view);
                    painting.paint(spots, block_strokes, shift);
                    for (channel, plane) in planes.iter_mut().enumerate() {
                        if let Some(plane) = plane {
                            painting.finish(channel, image, window, plane);
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
