//! Texture: a picture file looked up by texture coordinates.

use crate::files::average::{Interval, Sums, Wrap, covered};
use crate::files::knobs::{As, DecodeKnobs, FileKnobs, Knobs, SelectionKnobs};
use crate::files::{Planes, Reading, controls, index_of_nearest, memory_of_picture};
use crate::filter::{blended, fill, value, weights};
use crate::view::named;
use std::path::PathBuf;
use std::sync::OnceLock;
use trochoid_graph::*;
use trochoid_image::{Plane, Rgb, Window};
use trochoid_memory::Scratch;

/// Looks up a picture file at u and v: on a surface, or wherever fields specify.
///
/// # Formula
/// The picture's value at x = u·width − ½, y = (1 − v)·height − ½ in its pixels: u from 0 at the left edge to 1 at the
/// right, v from 0 at the lower edge to 1 at the upper. bilinear: a blend of the four nearest pixels; nearest: the
/// pixel that contains the position. With a `footprint` f: the mean over f·width × f·height pixels around the position,
/// at least 1 × 1, where one side is longer than a pixel.
///
/// # Edge cases
/// Beyond [0, 1] the picture repeats, is mirrored at its edges, or continues with its border pixels, by `wrap`. A
/// coordinate of NaN or ±∞ counts as 0; with `wrap` clamp, ±∞ counts as the edge. Outside its data window, a picture
/// repeats its nearest pixel. Without a `footprint`, a picture displayed smaller than stored is not averaged, and flickers
/// toward the horizon. On a plane seen from the height h, a sample at the distance d covers about d²·p/h meters along its
/// ray, with p = 2·tan(fov/2)/width, the angle of a pixel. A footprint above 16 counts as 16; NaN as 0, and so does every
/// footprint where the picture has infinite values.
/// To fill the screen with a picture, use Read with `fit`: ScreenX is 0 and 1 at the centers of the outermost pixels,
/// and ScreenY increases downward, but u and v are 0 and 1 at the picture's edges, and v increases upward. Bad data is
/// handled as in Read. Every color of the file is a control color.
///
/// # Source
/// v rises from the lower edge as in OBJ, RenderMan and Blender; OpenEXR, Technical Introduction.
#[derive(Clone, Node)]
#[node(
    stage,
    end = Back,
    revision = 1,
    reads("a picture": "exr", "png", "jpg", "jpeg", "tif", "tiff"),
    output(image: Kind::Color or [Kind::MASK, Kind::ANY_WEIGHTS, Kind::Field(1)] = "The picture, of the kind that `as` and `channels` decide.")
)]
#[also_called("ImageTexture", "TexImage", "STMap", "UVMap", "Tile")]
pub(crate) struct Texture {
    #[items]
    named: FileKnobs,
    /// Texture coordinate across the picture: 0 to 1 from left to right.
    u: One<port::Scalar>,
    /// Texture coordinate along the picture's height: 0 to 1 from bottom to top.
    v: One<port::Scalar>,
    /// Side of the square of u and v that a sample covers: 1 is the whole picture. Larger than a pixel of the picture, it
    /// is averaged.
    footprint: Optional<port::Scalar>,
    /// Behavior outside 0 to 1.
    wrap: Wrap,
    /// Interpolation between pixels.
    filter: Filter,
    #[items]
    selected: SelectionKnobs,
    #[items]
    taken: DecodeKnobs,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Filter {
    Bilinear,
    Nearest,
}

impl Texture {
    fn knobs(&self) -> Knobs<'_> {
        Knobs { named: &self.named, selected: &self.selected, taken: &self.taken, fit: None }
    }
}

impl Node for Texture {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![self.knobs().kind()])
    }

    fn check(&self, check: &mut Check<'_>) {
        self.knobs().check("a Texture", None, check);
    }
}

impl Stage for Texture {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        (self.named.r#as == As::Weights).then_some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.named.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let picture = memory_of_picture(self.knobs(), context, None);
        // Sums take 8 bytes for each sample of 4.
        let sums = if self.footprint.is_some() { 2 * picture.held } else { 0 };
        let pixel = if self.footprint.is_some() { BYTES_OF_AREA } else { BYTES_OF_PIXEL };
        MemoryUse { held: picture.held + sums, ..picture }.thread(pixel, u64::MAX)
    }

    fn check_headers(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, &self.named.file)?;
        let wanted = wanted.first().map(Vec::as_slice).unwrap_or_default();
        Reading { knobs: self.knobs(), frame, path: &path, outside: None }.check_headers(wanted, false)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.named.file)?;
        let kind = self.knobs().kind();
        let wanted = prepare.wanted.first().map(Vec::as_slice).unwrap_or_default();
        let mut display = Window::default();
        let reading = Reading { knobs: self.knobs(), frame: prepare.frame, path: &path, outside: None };
        let Planes { planes, exact, repaired } = reading.planes(kind, wanted, &mut |picture| {
            display = picture.display;
            Ok(())
        })?;
        let ranges = planes.iter().map(|_| OnceLock::new()).collect();
        let side = [display.width(), display.height()];
        let sums = |plane: &Option<Plane>| {
            let plane = plane.as_ref().filter(|_| self.footprint.is_some())?;
            let pixel = |x: usize, y: usize| f64::from(plane.nearest(display.x0 + x as i64, display.y0 + y as i64));
            Some(Sums::new(side, pixel))
        };
        let sums = planes.iter().map(sums).collect();
        Ok(Box::new(PreparedTexture { node: self.clone(), kind, planes, exact, sums, display, repaired, ranges }))
    }
}

impl Wrap {
    /// Returns a coordinate wrapped to [0, 1].
    fn unit(self, at: f64) -> f64 {
        let within = match self {
            Self::Repeat => at - at.floor(),
            Self::Clamp => at.clamp(0.0, 1.0),
            Self::Mirror => {
                let twice = at.rem_euclid(2.0);
                if twice > 1.0 { 2.0 - twice } else { twice }
            }
        };
        if within.is_finite() { within } else { 0.0 }
    }
}

/// A picture, ready to be looked up.
struct PreparedTexture {
    node: Texture,
    kind: Kind,
    planes: Vec<Option<Plane>>,
    /// What the planes are rounded from, sample by sample; empty if they are exact.
    exact: Vec<Vec<f64>>,
    /// Sums of each plane, if footprints are averaged.
    sums: Vec<Option<Sums>>,
    /// Display window: the range of u and v.
    display: Window,
    repaired: u64,
    /// Least and greatest sample of each plane, computed on request.
    ranges: Vec<OnceLock<(f64, f64)>>,
}

/// The two neighbors along an axis, and the position between them.
type Tap = ([i64; 2], f64);

/// Largest footprint that counts, in pictures.
const WIDEST: f64 = 16.0;

/// A rectangle of the picture, in pixels from its upper left corner.
struct Area {
    across: [f64; 2],
    down: [f64; 2],
}

impl Area {
    fn pixels(&self) -> f64 {
        (self.across[1] - self.across[0]) * (self.down[1] - self.down[0])
    }
}

impl PreparedTexture {
    fn is_bilinear(&self) -> bool {
        self.node.filter == Filter::Bilinear
    }

    /// Returns the neighbors of a position along an axis of `count` pixels.
    fn tap(&self, at: f64, count: usize) -> Tap {
        let (place, count) = (at * count as f64, count as i64);
        if !self.is_bilinear() {
            return ([(place.floor() as i64).clamp(0, count - 1); 2], 0.0);
        }
        let center = place - 0.5;
        let low = center.floor() as i64;
        ([low, low + 1].map(|pixel| self.node.wrap.pixel(pixel, count)), center - center.floor())
    }

    /// Returns the pixels around u and v, and the position between them, toward the right and lower ones.
    fn taps(&self, u: f64, v: f64) -> ([[i64; 2]; 4], [f64; 2]) {
        let (xs, across) = self.tap(self.node.wrap.unit(u), self.display.width());
        let (ys, down) = self.tap(1.0 - self.node.wrap.unit(v), self.display.height());
        let at = |x: usize, y: usize| [self.display.x0 + xs[x], self.display.y0 + ys[y]];
        ([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], [across, down])
    }

    /// Returns the rectangle that a footprint covers around u and v; `None` if it is not larger than a pixel.
    fn area(&self, u: f64, v: f64, footprint: f64) -> Option<Area> {
        let [width, height] = [self.display.width(), self.display.height()].map(|side| side as f64);
        let footprint = footprint.min(WIDEST);
        // False for NaN.
        if !(footprint * width > 1.0 || footprint * height > 1.0) {
            return None;
        }
        let around = |middle: f64, side: f64| {
            let half = (footprint * side).max(1.0) / 2.0;
            [middle * side - half, middle * side + half]
        };
        let (u, v) = (self.node.wrap.unit(u), self.node.wrap.unit(v));
        Some(Area { across: around(u, width), down: around(1.0 - v, height) })
    }

    /// Returns the mean of a channel over a rectangle; `None` if it has infinite values.
    fn mean(&self, channel: usize, [across, down]: &[Interval; 2], pixels: f64) -> Option<f32> {
        let mean = self.sums[channel].as_ref()?.over(across, down) / pixels;
        let (least, most) = self.range(channel)?;
        // Sums are rounded; a mean lies between the pixels.
        mean.is_finite().then(|| mean.clamp(least, most) as f32)
    }

    /// Returns the mean of a channel over a rectangle, in f64, pixel by pixel.
    fn true_mean(&self, channel: usize, area: &Area) -> f64 {
        let across = covered(self.node.wrap, area.across, self.display.width());
        let down = covered(self.node.wrap, area.down, self.display.height());
        let [x0, y0] = [self.display.x0, self.display.y0];
        let row = |y: usize| -> f64 {
            let texel = |(x, length): (usize, &f64)| length * self.texel(channel, [x0 + x as i64, y0 + y as i64]);
            across.iter().enumerate().filter(|(_, length)| **length > 0.0).map(texel).sum()
        };
        let rows = down.iter().enumerate().filter(|(_, length)| **length > 0.0);
        rows.map(|(y, length)| length * row(y)).sum::<f64>() / area.pixels()
    }

    /// Returns the least and the greatest sample of a channel.
    fn range(&self, channel: usize) -> Option<(f64, f64)> {
        let plane = self.planes[channel].as_ref()?;
        let all = || match self.exact.get(channel) {
            Some(exact) => extremes(exact.iter().copied()),
            None => extremes(plane.samples().iter().map(|sample| f64::from(*sample))),
        };
        Some(*self.ranges[channel].get_or_init(all))
    }

    /// Returns the pixel of a channel that is nearest to (x, y), before it is rounded to f32.
    fn texel(&self, channel: usize, [x, y]: [i64; 2]) -> f64 {
        let Some(plane) = &self.planes[channel] else { return 0.0 };
        match self.exact.get(channel) {
            Some(exact) => index_of_nearest(plane.window(), x, y).map_or(0.0, |index| exact[index]),
            None => f64::from(plane.nearest(x, y)),
        }
    }

    /// Returns the value of a channel at u and v, in f64.
    fn truth(&self, channel: usize, u: f64, v: f64) -> f64 {
        let (pixels, [across, down]) = self.taps(u, v);
        let weights = [(1.0 - across) * (1.0 - down), across * (1.0 - down), (1.0 - across) * down, across * down];
        let texel = |pixel: [i64; 2]| self.texel(channel, pixel);
        let terms = pixels.iter().zip(weights).filter(|(_, w)| *w > 0.0);
        let sum: f64 = terms.map(|(pixel, w)| w * texel(*pixel)).sum();
        if sum.is_nan() { texel(pixels[0]) } else { sum }
    }

    /// Returns the span of a channel for u and v in spans.
    fn span(&self, channel: usize, [u, v]: [Span; 2]) -> Span {
        if self.planes[channel].is_none() {
            return Span::exactly(0.0);
        }
        if u.low == u.high && v.low == v.high {
            let truth = self.truth(channel, u.low, v.low);
            return Span::of(&[truth, truth]).with(u.clear && v.clear);
        }
        // Range of pixels that may contribute, before wrapping.
        let sides = [self.display.width() as f64, self.display.height() as f64];
        let (center, more) = if self.is_bilinear() { (0.5, 1.0) } else { (0.0, 0.0) };
        let [across, down] = [(u, sides[0]), (v, sides[1])].map(|(span, side)| {
            let lost = 1e-15 * side * (1.0 + span.low.abs() + span.high.abs());
            [(span.low * side - center - lost).floor(), (span.high * side - center + lost).floor() + more]
        });
        let count = |[first, last]: [f64; 2]| last - first + 1.0;
        let few = count(across) * count(down) <= MOST;
        let texels = if few { self.texels(channel, across, down) } else { Vec::new() };
        let (least, most) = extremes(texels.iter().flatten().copied());
        if texels.is_empty() || !(most - least).is_finite() {
            // The value is a blend of some pixels.
            let (least, most) = self.range(channel).unwrap_or_default();
            return Span::unclear(least, most);
        }
        let clear = u.clear && v.clear;
        if !self.is_bilinear() {
            return Span { low: least, high: most, clear: least == most };
        }
        let (steepest_across, steepest_down) = (
            texels.iter().flat_map(|row| row.windows(2)).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max),
            texels
                .windows(2)
                .flat_map(|rows| rows[0].iter().zip(&rows[1]))
                .map(|(a, b)| (b - a).abs())
                .fold(0.0, f64::max),
        );
        let off = u.half() * sides[0] * steepest_across + v.half() * sides[1] * steepest_down;
        let lost = 1e-13
            * (least.abs().max(most.abs())
                + (u.middle().abs() * sides[0] + v.middle().abs() * sides[1]) * (most - least));
        let middle = self.truth(channel, u.middle(), v.middle());
        Span { low: middle - off, high: middle + off, clear }.wider(lost)
    }

    /// Returns the rows of pixels in a range, with those beyond the edges wrapped.
    fn texels(&self, channel: usize, across: [f64; 2], down: [f64; 2]) -> Vec<Vec<f64>> {
        let pixels = |[first, last]: [f64; 2], side: usize, is_up: bool| -> Vec<i64> {
            let side = side as f64;
            let of = |at: i64| {
                let unit = self.node.wrap.unit((at as f64 + 0.5) / side);
                (((if is_up { 1.0 - unit } else { unit }) * side).floor() as i64).clamp(0, side as i64 - 1)
            };
            (first as i64..=last as i64).map(of).collect()
        };
        let columns = pixels(across, self.display.width(), false);
        let rows = pixels(down, self.display.height(), true);
        let [x0, y0] = [self.display.x0, self.display.y0];
        rows.iter().map(|y| columns.iter().map(|x| self.texel(channel, [x0 + x, y0 + y])).collect()).collect()
    }
}

/// Returns the least and the greatest of some numbers.
fn extremes(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), number| (least.min(number), most.max(number)))
}

/// Bytes that a thread takes for a pixel: the pixels that it reads, and, with a footprint, the area that it covers, in a
/// list that grows to twice what it holds.
const BYTES_OF_PIXEL: u64 = 128;
const BYTES_OF_AREA: u64 = 800;

/// Maximum number of pixels examined where a position is uncertain.
const MOST: f64 = 4096.0;

impl Prepared for PreparedTexture {
    fn controls(&self) -> Vec<Rgb> {
        match &self.planes[..] {
            [Some(r), Some(g), Some(b)] if self.kind == Kind::Color => controls([r, g, b].map(Plane::samples)),
            _ => Vec::new(),
        }
    }

    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let coordinate =
            |port: &One<port::Scalar>| inputs.planes(port, 0).first().copied().flatten().unwrap_or_default();
        let (u, v) = (coordinate(&self.node.u), coordinate(&self.node.v));
        // Compute each sample's pixels once for all channels.
        let taps: Scratch<_> = u
            .iter()
            .zip(v)
            .map(|(u, v)| {
                let (pixels, [across, down]) = self.taps(f64::from(*u), f64::from(*v));
                (pixels, weights(across, down))
            })
            .collect();
        let footprints: &[f32] = if self.node.footprint.is_some() {
            inputs.planes(&self.node.footprint, 0).first().copied().flatten().unwrap_or_default()
        } else {
            &[]
        };
        let wide: Scratch<_> = u
            .iter()
            .zip(v)
            .zip(footprints)
            .enumerate()
            .filter_map(|(sample, ((u, v), footprint))| {
                let area = self.area(f64::from(*u), f64::from(*v), f64::from(*footprint))?;
                let interval = |at: [f64; 2], count: usize| Interval::new(self.node.wrap, at, count);
                let across = interval(area.across, self.display.width());
                Some((sample, [across, interval(area.down, self.display.height())], area.pixels()))
            })
            .collect();
        fill(self.kind, block.window.area(), outputs, |channel, out| {
            if let Some(plane) = &self.planes[channel] {
                for (out, (pixels, weights)) in out.iter_mut().zip(&taps) {
                    *out = blended(pixels.map(|[x, y]| plane.nearest(x, y)), weights);
                }
                for (sample, intervals, pixels) in &wide {
                    if let Some(mean) = self.mean(channel, intervals, *pixels) {
                        out[*sample] = mean;
                    }
                }
            }
        });
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for channel in 0..self.planes.len() {
            bounding.bound_by(outputs, SoleOutput, channel, |sample| {
                let place = [&self.node.u, &self.node.v]
                    .map(|port| bounding.known(port, 0, sample).unwrap_or(Span::exactly(0.0)));
                let footprint = bounding.known(&self.node.footprint, 0, sample).unwrap_or(Span::exactly(0.0));
                let side = self.display.width().max(self.display.height()) as f64;
                let span = if footprint.clear && footprint.high * side <= 1.0 {
                    self.span(channel, place)
                } else {
                    let (least, most) = self.range(channel).unwrap_or_default();
                    Span::unclear(least, most)
                };
                if matches!(self.kind, Kind::Weights(_)) { span.within(0.0, 1.0) } else { span }
            });
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let (u, v) = (inputs.scalar(&self.node.u), inputs.scalar(&self.node.v));
        let footprint = self.node.footprint.as_ref().map_or(0.0, |footprint| inputs.scalar(footprint));
        let area = self.area(u, v, footprint);
        let truth = |channel: usize| {
            let mean = area.as_ref().map(|area| self.true_mean(channel, area)).filter(|mean| mean.is_finite());
            mean.unwrap_or_else(|| self.truth(channel, u, v))
        };
        Ok(vec![value(self.kind, (0..self.planes.len()).map(truth).collect())])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        let exact = self.exact.iter().map(|exact| size_of_val(&exact[..]));
        let sums = self.sums.iter().flatten().map(Sums::bytes);
        self.planes.iter().flatten().map(|plane| size_of_val(plane.samples())).chain(exact).chain(sums).sum()
    }
}
