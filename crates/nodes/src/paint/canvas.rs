//! Access to a stroke's surroundings (surfaces, flow, shares) in the planes of a block and in the reference's values,
//! behind one trait, so that both place the same strokes.

use super::brush::Ground;
use super::painting::padded;
use super::planes::{self, index, sample};
use super::{Corner, LANES, StrokeSurroundings};
use std::cell::RefCell;
use std::collections::HashMap;
use trochoid_graph::*;
use trochoid_image::Window;

/// Inputs of strokes besides the image.
#[derive(Clone, Items)]
pub(crate) struct StrokeInputs {
    /// View of the surfaces that strokes lie on; without it, they lie on the picture.
    pub(crate) view: Optional<port::View>,
    /// Direction of the strokes (components right and down), for example from a FlowField; to the right by default.
    flow: Optional<port::Direction>,
    /// Scale of the strokes' length, width and spacing at each place; values below 1/16 count as 1/16.
    pub(super) size: Optional<port::Mask>,
    /// Fraction of the strokes that are painted at each place.
    density: Optional<port::Mask>,
    /// Share of the last (finest) layer: where it is 1, only that layer paints; where 0, all do.
    detail: Optional<port::Mask>,
}

/// Channels of the surface point at rest, to which seeds are fixed.
pub(crate) const RESTS: [Channel; 3] = [Channel::RestX, Channel::RestY, Channel::RestZ];

/// Surroundings that also give the corners of patches.
pub(crate) trait Canvas: StrokeSurroundings {
    /// Whether patches without seeds are sorted out; the reference searches all of them.
    const IS_FAST: bool;

    /// Returns the surface point, surface and depth that a pixel sees.
    fn corner(&self, x: i64, y: i64) -> Corner;
}

/// The planes of a view that tell its surfaces apart.
#[derive(Clone, Copy)]
pub(crate) struct ViewPlanes<'a> {
    window: Window,
    coverage: Option<&'a [f32]>,
    surfaces: Option<&'a [f32]>,
    depths: Option<&'a [f32]>,
}

impl<'a> ViewPlanes<'a> {
    /// Collects the planes of the view, if there is one.
    pub(crate) fn of(stroke_inputs: &StrokeInputs, picture: Window, inputs: &Inputs<'a>) -> Self {
        let view = inputs.all(&stroke_inputs.view).first();
        let channel = |channel: Channel| view.and_then(|view| view.planes[channel as usize]);
        Self {
            window: view.map_or(picture, |view| view.window),
            coverage: channel(Channel::Coverage),
            surfaces: channel(Channel::Surface),
            depths: channel(Channel::Depth),
        }
    }

    /// Writes what the groups of pixels of a row see, as far as it is known.
    #[inline(always)]
    pub(crate) fn lay(&self, columns: [i64; 2], y: i64, own: &mut Vec<f32>, ground: &mut [Ground]) {
        if let Some(coverage) = self.coverage {
            let row = planes::row(coverage, self.window, columns, y, own);
            for (group, ground) in ground.iter_mut().enumerate() {
                ground.parts = padded(row, group * LANES);
            }
            let row = self.surfaces.map_or(&[][..], |plane| planes::row(plane, self.window, columns, y, own));
            for (group, ground) in ground.iter_mut().enumerate() {
                ground.parts = seen(ground.parts, padded(row, group * LANES));
            }
        }
        if let Some(depths) = self.depths {
            let row = planes::row(depths, self.window, columns, y, own);
            for (group, ground) in ground.iter_mut().enumerate() {
                ground.depths = padded(row, group * LANES);
            }
        }
    }
}

/// Returns the indices of the surfaces of a group of pixels with this coverage; −1 where none is seen.
#[inline(always)]
fn seen(coverage: [f32; LANES], surfaces: [f32; LANES]) -> [f32; LANES] {
    let mut parts = [-1.0; LANES];
    for lane in 0..LANES {
        if coverage[lane] > 0.0 {
            parts[lane] = surfaces[lane].max(0.0);
        }
    }
    parts
}

/// Surroundings from the planes of a block.
pub(crate) struct BlockSurroundings<'a> {
    picture: Window,
    /// Offset of the samples from the upper left corners of their pixels.
    offset: [f64; 2],
    view: ViewPlanes<'a>,
    /// Surface points at rest, if seeds are fixed to surfaces.
    rests: Option<[&'a [f32]; 3]>,
    flow: Option<&'a Connection<'a>>,
    /// Size, density and detail.
    shares: [Option<&'a Connection<'a>>; 3],
}

impl<'a> BlockSurroundings<'a> {
    /// Collects the planes for a block of a picture. `on_surfaces` fixes seeds to surfaces instead of the picture.
    pub(crate) fn new(
        stroke_inputs: &StrokeInputs,
        picture: Window,
        on_surfaces: bool,
        block: &Block<'_>,
        inputs: &Inputs<'a>,
    ) -> Self {
        let view = inputs.all(&stroke_inputs.view).first();
        let channel = |channel: Channel| view.and_then(|view| view.planes[channel as usize]);
        let rests = RESTS.map(|rest| channel(rest).unwrap_or_default());
        Self {
            picture,
            offset: block.offset,
            view: ViewPlanes::of(stroke_inputs, picture, inputs),
            rests: on_surfaces.then_some(rests),
            flow: inputs.all(&stroke_inputs.flow).first(),
            shares: [&stroke_inputs.size, &stroke_inputs.density, &stroke_inputs.detail]
                .map(|port| inputs.all(port).first()),
        }
    }
}

impl StrokeSurroundings for BlockSurroundings<'_> {
    #[inline(always)]
    fn inside(&self, x: i64, y: i64) -> bool {
        self.picture.contains(x, y)
    }

    #[inline(always)]
    fn part(&self, x: i64, y: i64) -> f64 {
        let ViewPlanes { window, coverage, surfaces, .. } = self.view;
        let at = index(window, x, y);
        match coverage {
            Some(coverage) if coverage[at] > 0.0 => surfaces.map_or(0.0, |surfaces| f64::from(surfaces[at].max(0.0))),
            _ => -1.0,
        }
    }

    #[inline(always)]
    fn depth(&self, x: i64, y: i64) -> f64 {
        self.view.depths.map_or(f64::INFINITY, |depths| f64::from(depths[index(self.view.window, x, y)]))
    }

    #[inline(always)]
    fn flow(&self, x: i64, y: i64) -> [f64; 2] {
        [0, 1].map(|axis| sample(self.flow, axis, x, y).unwrap_or(1.0 - axis as f64))
    }

    #[inline(always)]
    fn shares(&self, x: i64, y: i64) -> [f64; 3] {
        let [size, density, detail] = self.shares;
        [
            sample(size, 0, x, y).unwrap_or(1.0),
            sample(density, 0, x, y).unwrap_or(1.0),
            sample(detail, 0, x, y).unwrap_or(0.0),
        ]
    }
}

impl Canvas for BlockSurroundings<'_> {
    const IS_FAST: bool = true;

    #[inline(always)]
    fn corner(&self, x: i64, y: i64) -> Corner {
        let part = self.part(x, y);
        let rest = match self.rests {
            Some(rests) if part >= 0.0 => rests.map(|plane| f64::from(plane[index(self.view.window, x, y)])),
            _ => [x as f64 + self.offset[0], 0.0, y as f64 + self.offset[1]],
        };
        Corner { rest, part, depth: self.depth(x, y) }
    }
}

/// Surroundings from the reference's values.
pub(crate) struct ReferenceSurroundings<'a> {
    stroke_inputs: &'a StrokeInputs,
    picture: Window,
    on_surfaces: bool,
    inputs: &'a References<'a>,
    pub(crate) pixel: [i64; 2],
    offset: [f64; 2],
    /// Cache of the view's channels at pixels.
    views: RefCell<HashMap<(i64, i64), Vec<f64>>>,
}

impl<'a> ReferenceSurroundings<'a> {
    pub(crate) fn new(
        stroke_inputs: &'a StrokeInputs,
        picture: Window,
        on_surfaces: bool,
        inputs: &'a References<'a>,
    ) -> Self {
        let pixel = inputs.at.map(|at| at.floor() as i64);
        let offset = [0, 1].map(|axis| inputs.at[axis] - pixel[axis] as f64);
        Self { stroke_inputs, picture, on_surfaces, inputs, pixel, offset, views: RefCell::default() }
    }

    /// Returns the inputs at a pixel's sample; beyond the picture, those of the nearest pixel.
    fn there(&self, x: i64, y: i64) -> References<'a> {
        let picture = self.picture;
        let (x, y) = (x.clamp(picture.x0, picture.x1 - 1), y.clamp(picture.y0, picture.y1 - 1));
        self.inputs.moved((x - self.pixel[0]) as f64, (y - self.pixel[1]) as f64)
    }

    fn view(&self, x: i64, y: i64, channel: Channel) -> f64 {
        let Some(source) = &*self.stroke_inputs.view else {
            return f64::from(channel.background());
        };
        let mut views = self.views.borrow_mut();
        let channels = views.entry((x, y)).or_insert_with(|| match self.there(x, y).value(source) {
            Reference::View(channels) => channels,
            _ => Vec::new(),
        });
        channels.get(channel as usize).copied().unwrap_or(f64::from(channel.background()))
    }

    fn number(&self, port: &Optional<port::Mask>, x: i64, y: i64, default: f64) -> f64 {
        port.as_ref().map_or(default, |source| self.there(x, y).scalar(source))
    }
}

impl StrokeSurroundings for ReferenceSurroundings<'_> {
    fn inside(&self, x: i64, y: i64) -> bool {
        self.picture.contains(x, y)
    }

    fn part(&self, x: i64, y: i64) -> f64 {
        if self.view(x, y, Channel::Coverage) > 0.0 { self.view(x, y, Channel::Surface).max(0.0) } else { -1.0 }
    }

    fn depth(&self, x: i64, y: i64) -> f64 {
        self.view(x, y, Channel::Depth)
    }

    fn flow(&self, x: i64, y: i64) -> [f64; 2] {
        match self.stroke_inputs.flow.as_ref().map(|flow| self.there(x, y).value(flow)) {
            Some(Reference::Field(flow)) => [flow[0], flow[1]],
            _ => [1.0, 0.0],
        }
    }

    fn shares(&self, x: i64, y: i64) -> [f64; 3] {
        let StrokeInputs { size, density, detail, .. } = self.stroke_inputs;
        [(size, 1.0), (density, 1.0), (detail, 0.0)].map(|(port, default)| self.number(port, x, y, default))
    }
}

impl Canvas for ReferenceSurroundings<'_> {
    const IS_FAST: bool = false;

    fn corner(&self, x: i64, y: i64) -> Corner {
        let part = self.part(x, y);
        let rest = if self.on_surfaces && part >= 0.0 {
            RESTS.map(|channel| self.view(x, y, channel))
        } else {
            [x as f64 + self.offset[0], 0.0, y as f64 + self.offset[1]]
        };
        Corner { rest, part, depth: self.depth(x, y) }
    }
}
