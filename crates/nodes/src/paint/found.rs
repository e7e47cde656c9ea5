//! Finds the strokes of a block: its patches are searched for seeds, and each seed gives at most one stroke.

use super::planes::{index, sample, used};
use super::scan::Row;
use super::strokes::{PreparedStrokes, grown};
use super::{BlockSurroundings, Brush, Canvas, Cells, Layer, STRIDES, Stroke, pixels, reach, seeds_of};
use fearless_simd::Level;
use trochoid_graph::{Block, Inputs, NodeError};
use trochoid_image::Window;
use trochoid_memory::{Scratch, prefetch};

/// Number of strokes whose sources are prefetched.
const AHEAD: usize = 8;

/// Strokes from the top down, and the image's values at their sources.
pub(super) struct BlockStrokes {
    pub(super) brushes: Scratch<Brush>,
    /// Of every stroke, the channels that are not 0, with their values. Recipes have many channels, of which most are.
    values: Scratch<(usize, f64)>,
    /// Of every stroke, the end of its values.
    ends: Scratch<usize>,
    /// Offset within its pixel of the sample they were found for.
    pub(super) offset: [f64; 2],
}

impl BlockStrokes {
    /// Returns the bytes that a thread takes for each stroke while it finds those of a block, and then, given the channels of
    /// the image: lists grow to twice what they hold.
    pub(super) const fn bytes_of_stroke(channels: usize) -> [usize; 2] {
        let found = size_of::<usize>() + channels * size_of::<(usize, f64)>();
        [2 * size_of::<(usize, Stroke)>(), 2 * found + size_of::<Brush>()]
    }

    /// Returns the values of a stroke that are not 0, by channel.
    pub(super) fn values(&self, stroke: u32) -> &[(usize, f64)] {
        &self.values[self.start(stroke)..self.ends[stroke as usize]]
    }

    fn start(&self, stroke: u32) -> usize {
        (stroke as usize).checked_sub(1).map_or(0, |before| self.ends[before])
    }

    /// Loads what is known of a stroke into the cache, but for its values.
    #[inline(always)]
    pub(super) fn prefetch(&self, stroke: u32) {
        prefetch(&self.brushes, stroke as usize);
        prefetch(&self.ends, stroke as usize);
    }

    /// Loads the first values of a stroke into the cache.
    #[inline(always)]
    pub(super) fn prefetch_values(&self, stroke: u32) {
        prefetch(&self.values, self.start(stroke));
    }
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
    pub(super) fn strokes<C: Canvas>(
        &self,
        window: Window,
        around: &C,
        check_cancelled: impl Fn() -> Result<(), NodeError>,
    ) -> Result<Scratch<(usize, Stroke)>, NodeError> {
        let mut strokes = Scratch::new();
        let (mut row, mut candidates) = (Row::default(), Scratch::new());
        for stride in STRIDES {
            // Strokes of fine layers reach less far, so each layer has its own window.
            let mut layers: Scratch<(usize, &Layer, Window, Cells)> = Scratch::new();
            for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.stride() == stride) {
                layers.push((index, layer, self.near(window, reach(&[*layer]), stride), Cells::new(layer.key)));
            }
            let Some(all) = layers.iter().map(|(_, _, near, _)| *near).reduce(Window::union) else { continue };
            // Align the patches to the same grid for every window.
            let [x0, y0] = [all.x0, all.y0].map(|first| first + (-first).rem_euclid(stride));
            let columns = || (x0..all.x1).step_by(stride as usize);
            let corners =
                |y: i64| columns().chain(columns().last().map(|x| x + stride)).map(move |x| around.corner(x, y));
            row.begin(stride as f64, self.settings.step, corners(y0));
            for y in (y0..all.y1).step_by(stride as usize) {
                check_cancelled()?;
                row.next(corners(y + stride), columns().map(|x| around.shares(x, y)[0]));
                candidates.clear();
                if C::IS_FAST {
                    row.scan(layers.iter().map(|(_, layer, ..)| *layer), &mut candidates);
                } else {
                    let numbers = 0..layers.len();
                    candidates.extend(
                        (0..columns().count()).flat_map(|patch| numbers.clone().map(move |layer| (patch, layer))),
                    );
                }
                for (patch, number) in candidates.iter().copied() {
                    let (index, layer, near, cells) = &mut layers[number];
                    let x = x0 + patch as i64 * stride;
                    let Some(placed) = row.patch(patch).filter(|_| near.contains(x, y)) else { continue };
                    seeds_of(&placed, pixels(layer, row.size(patch)), cells, |seed| {
                        let stroke = Stroke::new(layer, &self.settings, &seed, [x, y], around);
                        strokes.extend(stroke.map(|stroke| (*index, stroke)));
                    });
                }
            }
        }
        Ok(strokes)
    }

    /// Finds the strokes of a block, for the sample that the inputs belong to.
    pub(super) fn block_strokes(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<BlockStrokes, NodeError> {
        let image = &inputs.all(&self.image)[0];
        let planes = BlockSurroundings::new(&self.stroke_inputs, self.picture, self.on_surfaces, block, inputs);
        let mut strokes = self.strokes(block.window, &planes, || inputs.check_cancelled())?;
        // A surface that is placed several times has equal keys at several positions; the position breaks the tie.
        strokes.sort_unstable_by(|(layer, a), (other, b)| {
            let at = |axis: usize| a.at[axis].total_cmp(&b.at[axis]);
            other.cmp(layer).then(b.order.cmp(&a.order)).then_with(|| at(1)).then_with(|| at(0))
        });
        let sources = grown(block.window, &self.layers).intersect(image.window);
        let is_used = used(Level::new(), image, self.kind.channels(), sources);
        let channels: Scratch<usize> = (0..is_used.len()).filter(|channel| is_used[*channel]).collect();
        let (mut values, mut ends) = (Scratch::new(), Scratch::new());
        for (number, (_, stroke)) in strokes.iter().enumerate() {
            // Sources lie all over the image.
            if let Some((_, later)) = strokes.get(number + AHEAD) {
                let at = index(image.window, later.source[0], later.source[1]);
                channels.iter().filter_map(|channel| image.planes[*channel]).for_each(|plane| prefetch(plane, at));
            }
            let [x, y] = stroke.source;
            let value = |channel: &usize| (*channel, sample(Some(image), *channel, x, y).unwrap_or(0.0));
            values.extend(channels.iter().map(value).filter(|(_, value)| *value != 0.0));
            ends.push(values.len());
        }
        let brushes = strokes.iter().map(|(_, stroke)| Brush::new(stroke)).collect();
        Ok(BlockStrokes { brushes, values, ends, offset: block.offset })
    }
}
