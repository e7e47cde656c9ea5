//! FlowField: directions for brush strokes.

use super::flow_lanes::{LANES, Line, halves, store};
use super::{NORMAL, POSITION, grown, ramp};
use crate::field::Screen;
use crate::lit::eye;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use trochoid_field::{Noise, NoiseKind, NoiseParameters};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;
use trochoid_scene::{DVec3, Projector};
use trochoid_weights::kernel::{Kernel, Shape, filter};

/// Directions in the picture: up the slope of a surface, along its crests, along or across the gradient of a Field, or
/// constant.
///
/// # Formula
/// slope: the projection of Y − n(n·Y), the steepest way up, with n the normal; crest: of Y × n; gradient: (∂f/∂x,
/// ∂f/∂y) by central differences; contour: perpendicular to the gradient; constant: (1, 0). The direction is rotated
/// by `turn`, then, on surfaces, moved toward the projection of `calm` as 1 − n·Y falls from `steep` to `flat`, then
/// rotated by `waver` times noise. Directions are those of lines: v is represented by (cos 2φ, sin 2φ), smoothed by a
/// Gaussian of `smooth` pixels, and converted back by halving the angle, with x ≥ 0.
///
/// # Edge cases
/// `still` where nothing is seen, and where a direction vanishes. The length is 1 where all directions around agree,
/// and 0, with direction (0, 0), where lines of all directions meet. The noise is fixed to the picture.
///
/// # Source
/// Litwinowicz, 1997 (strokes across gradients); Kass and Witkin, Analyzing Oriented Patterns, 1987 (doubled angles).
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, example = r#""view": "view""#, outputs = Out)]
pub(crate) struct FlowField {
    /// View of the surfaces, for slope and crest.
    view: Optional<port::View>,
    /// Field to follow, for gradient and contour.
    field: Optional<port::Scalar>,
    /// Direction to follow: "slope" and "crest" of a surface, "gradient" and "contour" of a field, or "constant".
    pub(super) along: Along,
    /// Clockwise rotation of all directions.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    turn: f64,
    /// World-space direction used where the surface is flat; no effect while `flat` and `steep` are 0.
    #[knob(default = [1.0, 0.0, 0.0])]
    calm: [f64; 3],
    /// Value of 1 − n·Y below which only `calm` counts.
    #[knob(default = 0.0, range = 0.0..=2.0)]
    pub(super) flat: f64,
    /// Value of 1 − n·Y above which only the surface counts.
    #[knob(default = 0.0, range = 0.0..=2.0)]
    pub(super) steep: f64,
    /// Direction where nothing is seen, clockwise from the right.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    still: f64,
    /// Maximum rotation by noise, to either side.
    #[knob(default = 0.0, range = 0.0..=360.0, unit = "degrees")]
    waver: f64,
    /// Size of the noise.
    #[knob(default = 0.3, range = 1e-3..=1e3, unit = "picture heights")]
    waver_scale: f64,
    /// Standard deviation of the smoothing; 0 is none.
    #[knob(default = 0.0, range = 0.0..=64.0, in_pixels)]
    smooth: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(super) enum Along {
    Slope,
    Crest,
    Gradient,
    Contour,
    Constant,
}

impl Along {
    /// Whether directions come from the surface.
    fn is_of_surface(self) -> bool {
        matches!(self, Self::Slope | Self::Crest)
    }

    /// Whether directions come from a field.
    fn is_of_field(self) -> bool {
        matches!(self, Self::Gradient | Self::Contour)
    }

    /// Whether directions are perpendicular to the gradient.
    pub(super) fn is_crosswise(self) -> bool {
        matches!(self, Self::Crest | Self::Contour)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Direction of the flow: components to the right and down, of length at most 1.
    #[output(Kind::Field(2))]
    Flow,
    /// Length of the direction: how well nearby directions agree.
    #[output(Kind::MASK)]
    Length,
}

impl Node for FlowField {
    fn check(&self, check: &mut Check<'_>) {
        let along = self.along.word();
        if self.along.is_of_surface() && self.view.is_none() {
            let remedy = "connect \"view\", or choose gradient or contour";
            check.error(Self::ALONG, format!("{along} without a view"), "surfaces to follow", remedy);
        }
        if self.along.is_of_field() && self.field.is_none() {
            let remedy = "connect \"field\", or choose slope or crest";
            check.error(Self::ALONG, format!("{along} without a field"), "a field to follow", remedy);
        }
        if self.steep < self.flat {
            let found = format!("{}, below \"flat\" {}", self.steep, self.flat);
            check.error(Self::STEEP, found, "at least the value of \"flat\"", "swap them");
        }
        if self.along.is_of_surface() && self.steep > 0.0 && self.calm == [0.0; 3] {
            let remedy = "write for example [1, 0, 0], or \"steep\": 0 for no calm direction";
            check.error(Self::CALM, "[0, 0, 0], which has no direction", "a direction in world space", remedy);
        }
    }
}

impl Stage for FlowField {
    fn is_costly(&self) -> bool {
        true
    }

    fn memory(&self, _context: &MemoryContext<'_>) -> MemoryUse {
        // Planes in f64 and f32 before and after they are smoothed.
        MemoryUse::default().thread(64, u64::MAX)
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        if !self.along.is_of_surface() {
            return ChannelSet::EMPTY;
        }
        ChannelSet::of(&NORMAL).union(ChannelSet::of(&POSITION)).union(Channel::Coverage.into())
    }

    fn interval(&self, output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some(match Out::ALL[output] {
            Out::Flow => (-1.0, 1.0),
            Out::Length => (0.0, 1.0),
        })
    }

    fn regions_of_interest(&self, port: PortId, window: Window, _format: Format) -> Window {
        let difference = i64::from(port == self.field.id());
        grown(window, SMOOTHING.radius(self.smooth) + difference)
    }

    fn takes_whole_rows(&self) -> bool {
        true
    }

    fn rate(&self) -> Rate {
        Rate::Pixel
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let axes =
            NoiseParameters { scale: self.waver_scale, octaves: 2, lacunarity: 2.0, gain: 0.5, seed: self.seed as u32 };
        let format = prepare.frame.format;
        Ok(Box::new(PreparedFlowField {
            picture: format.window(),
            eye: self.along.is_of_surface().then(|| eye(prepare, &self.view, format)).transpose()?,
            turn: libm::sincos(self.turn.to_radians()),
            still: libm::sincos(self.still.to_radians()),
            calm: DVec3::from(self.calm).try_normalize().unwrap_or(DVec3::X),
            waver: self.waver.to_radians(),
            noise: Noise::new(NoiseKind::Fbm, axes, None),
            screen: Screen::of(format),
            kernel: Kernel::new(SMOOTHING, self.smooth),
            radius: SMOOTHING.radius(self.smooth),
            node: self.clone(),
        }))
    }
}

/// Kernel that smooths directions.
const SMOOTHING: Shape = Shape::Gaussian;

pub(super) struct PreparedFlowField {
    pub(super) node: FlowField,
    picture: Window,
    /// `Some` if directions come from the surface.
    eye: Option<Projector>,
    /// Sine and cosine.
    pub(super) turn: (f64, f64),
    pub(super) still: (f64, f64),
    pub(super) calm: DVec3,
    /// In radians.
    pub(super) waver: f64,
    noise: Noise,
    screen: Screen,
    kernel: Kernel,
    /// Maximum reach of the kernel, in pixels.
    radius: i64,
}

/// Length below which a direction vanishes.
pub(super) const SHORTEST: f64 = 1e-12;
/// Length below which a smoothed direction with doubled angle vanishes.
pub(super) const SHORTEST_DOUBLED: f64 = 1e-6;

/// Returns the unit vector of a direction; `None` if it vanishes.
fn unit([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let length = (x * x + y * y).sqrt();
    let unit = [x / length, y / length];
    (length > SHORTEST && length.is_finite()).then_some(unit)
}

/// Returns a unit vector rotated clockwise, in a picture with y down.
fn turned([x, y]: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [x * cos - y * sin, x * sin + y * cos]
}

/// Returns (cos 2φ, sin 2φ) for a unit vector: the same for both directions along a line.
pub(crate) fn doubled([x, y]: [f64; 2]) -> [f64; 2] {
    [x * x - y * y, 2.0 * x * y]
}

/// Inverts [`doubled`]: returns the direction along the line, to the right or down, and the length of the components.
pub(crate) fn halved([c, s]: [f64; 2]) -> ([f64; 2], f64) {
    let length = (c * c + s * s).sqrt().min(1.0);
    let cos = (c / length).clamp(-1.0, 1.0);
    let (x, y) = (((1.0 + cos) / 2.0).sqrt() * length, ((1.0 - cos) / 2.0).sqrt() * length);
    let way = [x, if s < 0.0 { -y } else { y }];
    if length < SHORTEST_DOUBLED { ([0.0; 2], 0.0) } else { (way, length) }
}

/// Returns the direction in the picture of a world-space direction at a point.
pub(crate) fn projected(eye: &Projector, point: DVec3, direction: DVec3) -> Option<[f64; 2]> {
    let along = [direction.dot(eye.right), -direction.dot(eye.up)];
    if eye.orthographic {
        return unit(along);
    }
    let offset = point - eye.position;
    let (depth, deeper) = (offset.dot(eye.forward), direction.dot(eye.forward));
    // Derivative of a quotient, times depth² > 0.
    let at = [offset.dot(eye.right), -offset.dot(eye.up)];
    unit([along[0] * depth - at[0] * deeper, along[1] * depth - at[1] * deeper])
}

impl PreparedFlowField {
    /// Returns (cos 2φ, sin 2φ) on a surface.
    fn on_surface(&self, eye: &Projector, point: DVec3, normal: DVec3) -> [f64; 2] {
        let still = [self.still.1, self.still.0];
        let upward = DVec3::Y - normal * normal.y;
        let way = if self.node.along.is_crosswise() { DVec3::Y.cross(normal) } else { upward };
        let way = projected(eye, point, way);
        let calm = projected(eye, point, self.calm - normal * self.calm.dot(normal)).unwrap_or(still);
        let steep = ramp(1.0 - normal.y, self.node.flat, self.node.steep - self.node.flat);
        let share = steep * steep * (3.0 - 2.0 * steep);
        let (own, calm) = (doubled(turned(way.unwrap_or(still), self.turn)), doubled(calm));
        let mixed = [share * own[0] + (1.0 - share) * calm[0], share * own[1] + (1.0 - share) * calm[1]];
        if way.is_some() { mixed } else { calm }
    }

    /// Returns (cos 2φ, sin 2φ) for the change of a field to the right and down.
    fn of_change(&self, change: [f64; 2]) -> [f64; 2] {
        let way = unit(change);
        let [x, y] = way.unwrap_or(change);
        let line = doubled(turned(if self.node.along.is_crosswise() { [-y, x] } else { [x, y] }, self.turn));
        if way.is_some() { line } else { doubled([self.still.1, self.still.0]) }
    }

    /// Rotates a doubled direction by noise; doubled angles rotate twice as far.
    fn wavering(&self, doubled: [f64; 2], noise: f64) -> [f64; 2] {
        if self.waver == 0.0 { doubled } else { turned(doubled, libm::sincos(2.0 * self.waver * noise)) }
    }

    /// Returns the doubled directions over a window, before smoothing.
    fn lines(&self, window: Window, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<[Scratch<f32>; 2], NodeError> {
        let mut lines = [0, 1].map(|_| Scratch::of(0.0f32, window.area()));
        let still = doubled(turned([1.0, 0.0], if self.is_by_hand() { self.turn } else { self.still }));
        let view = inputs.all(&self.node.view).first();
        let field = inputs.all(&self.node.field).first().and_then(|field| Some((field.window, field.planes[0]?)));
        let width = window.width();
        // Whole vectors, so that no rest is left; a field is read one pixel to the left and to the right, too.
        let room = width.next_multiple_of(LANES);
        let mut read = SEEN.map(|_| Scratch::of(0.0f32, room + 2));
        let mut noise = Scratch::of(0.0f32, room);
        let mut row = [0, 1].map(|_| Scratch::of(0.0f32, room));
        let waver = if self.waver > 0.0 { width } else { 0 };
        let across = self.screen.columns(window.x0..window.x0 + waver as i64, block.offset[0]);
        for (y, start) in (window.y0..window.y1).zip((0..).step_by(width.max(1))) {
            inputs.check_cancelled()?;
            if waver > 0 {
                let down = self.screen.row(y, block.offset[1]);
                self.noise.fill::<2>(across.iter().map(|across| [*across, down]), &[], &mut noise[..width]);
            }
            match (&self.eye, view, field) {
                (Some(_), Some(view), _) => {
                    for (row, channel) in read.iter_mut().zip(SEEN) {
                        if let Some(plane) = view.planes[channel as usize] {
                            copy_row(plane, view.window, [window.x0, y], row);
                        }
                    }
                }
                (None, _, Some((of, plane))) if self.node.along.is_of_field() => {
                    for (row, (x, y)) in read.iter_mut().zip([(-1, y), (0, y - 1), (0, y + 1)]) {
                        copy_row(plane, of, [window.x0 + x, y], row);
                    }
                }
                _ => {}
            }
            dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
                for start in (0..room).step_by(LANES) {
                    let mut line: Line<_> = still.map(|along| f64x8::splat(simd, along));
                    if let (Some(eye), true) = (&self.eye, view.is_some()) {
                        line = self.on_surfaces(simd, eye, read.each_ref().map(|row| chunk(row, start)), line);
                    } else if self.node.along.is_of_field() && field.is_some() {
                        let sides = [chunk(&read[0], start), chunk(&read[0], start + 2)];
                        line = self.of_changes(simd, [sides[0], sides[1], chunk(&read[1], start), chunk(&read[2], start)]);
                    }
                    if waver > 0 {
                        line = self.all_wavering(simd, line, chunk(&noise, start));
                    }
                    for (row, along) in row.iter_mut().zip(line) {
                        store(along, &mut row[start..]);
                    }
                }
            }));
            for (line, row) in lines.iter_mut().zip(&row) {
                line[start..start + width].copy_from_slice(&row[..width]);
            }
        }
        Ok(lines)
    }

    fn is_by_hand(&self) -> bool {
        self.eye.is_none() && !self.node.along.is_of_field()
    }

    /// Returns the doubled direction of the reference at an offset in pixels.
    fn line(&self, inputs: &References<'_>, dx: i64, dy: i64) -> [f64; 2] {
        // Beyond the picture, its border repeats.
        let inside = |at: f64, by: i64, first: i64, end: i64| {
            ((at.floor() as i64 + by).clamp(first, end - 1) - at.floor() as i64) as f64
        };
        let [x, y] = inputs.at;
        let there = inputs
            .moved(inside(x, dx, self.picture.x0, self.picture.x1), inside(y, dy, self.picture.y0, self.picture.y1));
        let still = doubled(turned([1.0, 0.0], if self.is_by_hand() { self.turn } else { self.still }));
        let line = if let (Some(eye), Some(view)) = (&self.eye, &*self.node.view) {
            let channel = |channel: Channel| there.view(view, channel);
            let vector = |channels: [Channel; 3]| DVec3::from(channels.map(channel));
            if channel(Channel::Coverage) > 0.0 {
                self.on_surface(eye, vector(POSITION), vector(NORMAL))
            } else {
                still
            }
        } else if let (true, Some(field)) = (self.node.along.is_of_field(), &*self.node.field) {
            let at = |dx: f64, dy: f64| there.moved(dx, dy).scalar(field);
            self.of_change([at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0)])
        } else {
            still
        };
        self.wavering(line, self.noise.reference(&self.screen.at(there.at), 0.0))
    }
}

/// Channels of the view that decide the direction on a surface.
const SEEN: [Channel; 7] = [POSITION[0], POSITION[1], POSITION[2], NORMAL[0], NORMAL[1], NORMAL[2], Channel::Coverage];

/// Copies the pixels of a plane over a window from (`x`, `y`) on; beyond it, the nearest pixel repeats.
fn copy_row(plane: &[f32], window: Window, [x, y]: [i64; 2], out: &mut [f32]) {
    let row = &plane[(y.clamp(window.y0, window.y1 - 1) - window.y0) as usize * window.width()..][..window.width()];
    let [left, right] = [window.x0 - x, window.x1 - x].map(|end| end.clamp(0, out.len() as i64) as usize);
    out[..left].fill(row[0]);
    out[right..].fill(row[row.len() - 1]);
    if left < right {
        out[left..right].copy_from_slice(&row[(x + left as i64 - window.x0) as usize..][..right - left]);
    }
}

/// Returns some values of a row.
#[inline(always)]
fn chunk(row: &[f32], start: usize) -> &[f32; LANES] {
    match row[start..].first_chunk() {
        Some(chunk) => chunk,
        None => unreachable!("rows are whole vectors"),
    }
}

impl Prepared for PreparedFlowField {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let from = grown(window, self.radius).intersect(self.picture);
        let mut lines = self.lines(from, block, inputs)?;
        if self.radius > 0 {
            lines = lines.map(|line| {
                let mut smooth = Scratch::of(0.0f32, window.area());
                let kernels = [&self.kernel, &self.kernel];
                filter(kernels, from, &line, self.picture, window, inputs.cancellation(), &mut smooth);
                smooth
            });
            inputs.check_cancelled()?;
        }
        let mut planes = [(Out::Flow, 0), (Out::Flow, 1), (Out::Length, 0)].map(|(out, axis)| outputs.take(out, axis));
        let room = window.area().next_multiple_of(LANES);
        lines.iter_mut().for_each(|line| line.resize(room, 0.0));
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for start in (0..room).step_by(LANES) {
                let found = halves(simd, [chunk(&lines[0], start), chunk(&lines[1], start)]);
                for (plane, found) in planes.iter_mut().zip(found) {
                    if let Some(plane) = plane {
                        store(found, &mut plane[start..]);
                    }
                }
            }
        }));
        Ok(())
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound("nearby directions differ without bound where lines meet"))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let weights = SMOOTHING.reference(self.node.smooth);
        let mut sum = [0.0; 2];
        for (dy, down) in &weights {
            for (dx, across) in &weights {
                let line = self.line(inputs, *dx, *dy);
                sum = [0, 1].map(|axis| sum[axis] + across * down * line[axis]);
            }
        }
        let (way, length) = halved(sum);
        Ok(vec![Reference::Field(way.to_vec()), Reference::Mask(length)])
    }
}
