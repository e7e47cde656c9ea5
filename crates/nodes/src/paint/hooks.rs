//! Hooks: claws of foam rooted in a surface.

use crate::lit::{eye, toward_eye};
use crate::sea::{Roots, check_indices, check_roots, check_surfaces};
use crate::view::{RenderHandle, SurfaceHandle};
use trochoid_field::random::{draw, key};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;
use trochoid_scene::claws::{Claw, Drawn, Places, Ribbon, Shape, covered};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{Anchor, DVec3, Projector};

/// Draws curling ribbons rooted in a surface, such as claws of foam on a wave, and gives the position of each pixel
/// within its ribbon.
///
/// # Formula
/// Along a spine, s runs from 0 at the root to 1 at the tip. Its direction is θ₀ + curl·s^late; half its width is h =
/// width/2·(1 − s)^taper·(1 + bulge·sin πs)·√min(1, s/0.14). θ₀ is the angle `direction` from ∂P/∂u toward ∂P/∂v at the
/// root, both projected into the picture and normalized. A point belongs to the segment of the spine with the smallest
/// distance in half widths, if that is at most 1, so ends and bends are round. Ribbons later in the list are on top. A
/// ribbon and its thumbs form one shape, and a point takes its values from the part it lies deepest in. Sizes are
/// multiplied by min(1, |n·v|/turned), so ribbons grow and shrink instead of popping. With the inset i in pixels: mask
/// = min(1, i); ink = clamp(½ + line − i), which fades in over s = 0.06 to 0.3 on the outside of the bend and 0.35 to
/// 0.65 on the inside; shade = clamp(½ + h·(t − 1 + shade·(0.98 − 0.8·((s − 0.42)/0.4)²))) with t = across·side.
///
/// # Edge cases
/// A ribbon grows from every point of the surface that has its u and v, visible or not. Ribbons cover what lies behind
/// their root, but not what is nearer by more than `edge`. All outputs are 0 where there is no ribbon. Needs a view
/// from a Render, because passes contain no surfaces. Each sample of a pixel is drawn separately.
///
/// # Source
/// The foam of Hokusai's Great Wave.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 2, outputs = Out)]
pub(crate) struct Hooks {
    /// View of the surfaces, from a Render.
    view: One<port::View>,
    /// Rows of ribbons, bottom row first.
    #[list(1..=256)]
    rows: Vec<Row>,
    /// Index of the surface in the Render's list, counted from 0; all surfaces by default.
    #[knob(range = 0..=63)]
    surface: Option<i64>,
    /// Value of |n · v| (surface normal and view direction) below which ribbons shrink as their root turns edge-on; 0
    /// never shrinks them.
    #[knob(default = 0.3, range = 0.0..=1.0)]
    turned: f64,
    /// Smallest jump in depth that hides a ribbon, as a fraction of the depth.
    #[knob(default = 0.05, range = 1e-4..=1e3)]
    edge: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// A row of ribbons side by side.
#[derive(Clone, Items)]
pub(crate) struct Row {
    /// Start of the row on the surface: u, v.
    #[knob(default = [0.0, 0.0])]
    pub(crate) from: [f64; 2],
    /// End of the row on the surface: u, v.
    #[knob(default = [1.0, 0.0])]
    pub(crate) to: [f64; 2],
    /// Largest random offset of the roots from the row, to either side: u, v.
    #[knob(default = [0.0, 0.0])]
    pub(crate) scatter: [f64; 2],
    /// Index of the row's surface; by default the node's `surface`.
    #[knob(range = 0..=63)]
    pub(crate) surface: Option<i64>,
    /// Number of ribbons in the row.
    #[knob(default = 8, range = 1..=512)]
    count: i64,
    /// Length of the ribbons.
    #[knob(default = 1.0, range = 1e-6..=1e6, unit = "m")]
    pub(crate) length: f64,
    /// Width of the ribbons.
    #[knob(default = 0.3, range = 1e-6..=1e6, unit = "m")]
    width: f64,
    /// Direction in which the ribbons grow: 0 is along u, 90 along v.
    #[knob(default = 90.0, range = -360.0..=360.0, unit = "degrees")]
    direction: f64,
    /// Total bend from root to tip; positive values bend from u toward v.
    #[knob(default = 110.0, range = -720.0..=720.0, unit = "degrees")]
    curl: f64,
    /// Where the ribbons bend: 1 bends them evenly, larger values (2.5) near the tip.
    #[knob(default = 1.5, range = 0.1..=16.0)]
    late: f64,
    /// Exponent of the narrowing toward the tip; small values keep the ribbons thick for longer.
    #[knob(default = 0.62, range = 0.05..=8.0)]
    taper: f64,
    /// Extra width in the middle, as a fraction; 0 adds none.
    #[knob(default = 0.25, range = 0.0..=4.0)]
    bulge: f64,
    /// Number of thumbs: small ribbons on the inner side of the bend.
    #[knob(default = 0, range = 0..=4)]
    thumbs: i64,
    /// Range along the ribbon where thumbs grow, from 0 (root) to 1 (tip).
    #[knob(default = [0.16, 0.4])]
    fork: [f64; 2],
    /// Widths of the ink along the outer and inner edges; 0 draws none.
    #[knob(default = [0.0, 0.0], unit = "m")]
    line: [f64; 2],
    /// Size of the shading crescent on the inner side; 0 draws none.
    #[knob(default = 0.0, range = 0.0..=2.0)]
    shade: f64,
    /// Largest random change of the direction, to either side.
    #[knob(default = 18.0, range = 0.0..=180.0, unit = "degrees")]
    spread: f64,
    /// Random variation of positions, lengths, widths and bends, as a fraction; 0 makes all ribbons alike.
    #[knob(default = 0.35, range = 0.0..=0.95)]
    vary: f64,
    /// Number passed on to the output `tag`, to tell kinds of ribbons apart.
    #[knob(default = 0.0, range = -1e6..=1e6)]
    tag: f64,
}

/// Outputs for each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
pub(crate) enum Out {
    /// Mask of the ribbons, with edges one pixel soft.
    #[output(Kind::MASK)]
    Mask,
    /// Position along the ribbon: 0 at the root, 1 at the tip.
    #[output(Kind::Field(1))]
    Along,
    /// Position across the ribbon: −1 at its left edge, 1 at its right edge (seen from the root).
    #[output(Kind::Field(1))]
    Across,
    /// Half the width of the ribbon at this point, in pixels.
    #[output(Kind::Field(1))]
    HalfWidth,
    /// Side to which the ribbon bends: 1 is right, −1 is left.
    #[output(Kind::Field(1))]
    Side,
    /// Random number of the ribbon, in [0, 1).
    #[output(Kind::Field(1))]
    Random,
    /// Number of the ribbon's row, counted from 1.
    #[output(Kind::Field(1))]
    Row,
    /// Distance to the edge of the ribbon and its thumbs together, in pixels.
    #[output(Kind::Field(1))]
    Inset,
    /// Tag of the ribbon's row.
    #[output(Kind::Field(1))]
    Tag,
    /// Mask of the ink lines along the edges, which fade in from the root. Apply it within `mask`.
    #[output(Kind::MASK)]
    Ink,
    /// Mask of the shading crescent on the inner side. Apply it within `mask`.
    #[output(Kind::MASK)]
    Shade,
}

impl Node for Hooks {
    fn check(&self, check: &mut Check<'_>) {
        check_surfaces(&self.view, check);
        let roots = |row: &Row| Roots {
            ends: [row.from, row.to],
            scatter: row.scatter,
            length: row.length,
            surface: row.surface.or(self.surface),
        };
        let rows: Vec<Roots> = self.rows.iter().map(roots).collect();
        check_roots(&self.view, Self::ROWS, &rows, check);
        check_indices(&self.view, Self::SURFACE, self.surface.map(|index| index as f64), check);
        let own = |row: &Row| row.surface.map(|index| index as f64);
        check_indices(&self.view, Self::ROWS, self.rows.iter().filter_map(own), check);
    }

    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        // Seconds per sample and ribbon for each pixel of the ribbon's length; cost of a thumb as a fraction of that of
        // its ribbon.
        const PIXEL: f64 = 1.5e-6;
        const THUMB: f64 = 0.25;
        // The size of the ribbons in the picture depends on the camera, which is unknown here; assume claws on a large
        // wave.
        let length = f64::from(format.height()) / 24.0;
        let row = |row: &Row| row.count as f64 * (1.0 + THUMB * row.thumbs as f64);
        let ribbons: f64 = self.rows.iter().map(row).sum();
        let remedy = "lower the \"count\" or \"thumbs\" of rows, or use fewer samples or pixels";
        Some(Work { seconds: PIXEL * length * f64::from(format.samples()) * ribbons, item: Self::ROWS, remedy })
    }
}

impl Stage for Hooks {
    fn is_costly(&self) -> bool {
        true
    }

    fn memory(&self, _context: &MemoryContext<'_>) -> MemoryUse {
        // The claws near it, and where their ribbons lie.
        MemoryUse::default().thread(96, u64::MAX)
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Depth.into()
    }

    fn interval(&self, output: usize, _channel: usize) -> Option<(f64, f64)> {
        match Out::ALL[output] {
            Out::Mask | Out::Along | Out::Random | Out::Ink | Out::Shade => Some((0.0, 1.0)),
            Out::Across | Out::Side => Some((-1.0, 1.0)),
            Out::HalfWidth | Out::Row | Out::Inset | Out::Tag => None,
        }
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let eye = eye(prepare, &self.view, prepare.frame.format)?;
        let handle = prepare.handle_of(&self.view);
        let Some(render) = handle.as_deref().and_then(|handle| handle.downcast_ref::<RenderHandle>()) else {
            return Err(BadData::new("a view of passes", "a view of surfaces", "connect a Render").into());
        };
        let (mut claws, mut exact): (Vec<Claw>, Vec<Claw>) = Default::default();
        for root in self.roots() {
            let only = |index: usize| root.surface.is_none_or(|only| only == index as i64);
            let grown = |surface: &SurfaceHandle| {
                let anchors = surface.anchors(root.uv);
                anchors.iter().filter_map(|anchor| root.grow(anchor, &eye, self.turned)).collect::<Vec<_>>()
            };
            for index in (0..render.surfaces.len()).filter(|index| only(*index)) {
                claws.extend(grown(&render.surfaces[index]));
                if prepare.referenced() {
                    exact.extend(grown(&render.exact[index]));
                }
            }
            if prepare.cancelled() {
                break;
            }
        }
        // Top ribbon first.
        let [claws, exact] =
            [claws, exact].map(|claws| claws.into_iter().rev().map(|claw| (claw.bounds(), claw)).collect());
        Ok(Box::new(PreparedHooks { view: self.view.clone(), claws, exact, step: 1.0 + self.edge }))
    }
}

/// A ribbon to grow on a surface.
struct Root<'n> {
    row: &'n Row,
    uv: [f64; 2],
    /// Index of the only surface it grows on; all if none.
    surface: Option<i64>,
    shape: Shape,
    /// Angle from u toward v, in radians.
    direction: f64,
    /// Length and half the width, in meters.
    size: [f64; 2],
    /// Number of its row, counted from 1.
    number: f64,
    key: u64,
}

/// Indices of a ribbon's random numbers. Those of thumb i start at 10·(i + 1): direction, bend, length, and the random
/// number of the thumb itself.
const OFF_PLACE: u64 = 0;
const OFF_SIZE: u64 = 1;
const OFF_CURL: u64 = 2;
const OFF_DIRECTION: u64 = 3;
const OWN: u64 = 4;
const OFF_SCATTER: u64 = 5;

impl Hooks {
    /// Returns all roots, bottom row first.
    fn roots(&self) -> Vec<Root<'_>> {
        let mut roots = Vec::new();
        for (at, row) in self.rows.iter().enumerate() {
            let count = row.count.max(1);
            let (from, to, vary) = (row.from, row.to, row.vary);
            for index in 0..count {
                let key = key(key(key(0x686f_6f6b, self.seed), at as i64), index);
                let off = |which: u64| 2.0 * draw(key, which) - 1.0;
                // Each ribbon varies its position only within its own part of the row; widths vary half as much as
                // lengths.
                let along = ((index as f64 + 0.5 + 0.5 * vary * off(OFF_PLACE)) / count as f64).clamp(0.0, 1.0);
                let size = 1.0 + vary * off(OFF_SIZE);
                let place = |axis: usize| {
                    from[axis] + along * (to[axis] - from[axis]) + row.scatter[axis] * off(OFF_SCATTER + axis as u64)
                };
                roots.push(Root {
                    row,
                    uv: [0, 1].map(place),
                    surface: row.surface.or(self.surface),
                    shape: Shape {
                        curl: row.curl.to_radians() * (1.0 + 0.5 * vary * off(OFF_CURL)),
                        late: row.late,
                        taper: row.taper,
                        bulge: row.bulge,
                    },
                    direction: (row.direction + row.spread * off(OFF_DIRECTION)).to_radians(),
                    size: [row.length * size, 0.5 * row.width * (0.5 + 0.5 * size)],
                    number: at as f64 + 1.0,
                    key,
                });
            }
        }
        roots
    }
}

/// Thumbs relative to their ribbon. They lean toward the inner side of its bend by 52° to 68°, bend by 0.75 to 1.25 of
/// its bend, late (s^2.2), and have 0.9 · (0.46 to 0.62) of its length and 0.7 of its width.
const LEAN: [f64; 2] = [52.0, 16.0];
const BEND: [f64; 2] = [0.75, 0.5];
const THUMB_LATE: f64 = 2.2;
const THUMB_LENGTH: [f64; 2] = [0.46, 0.16];
const SHORTER: f64 = 0.9;
const THINNER: f64 = 0.7;

impl Root<'_> {
    /// Returns the ribbon in the picture; none if its root does not project into it or its size is 0.
    fn grow(&self, anchor: &Anchor, eye: &Projector, turned: f64) -> Option<Claw> {
        let (place, depth) = eye.project(anchor.point)?;
        // Pixels per meter at the root, times min(1, |n·v|/turned).
        let normal = unit_or_up(anchor.along_v.cross(anchor.along_u));
        let facing = normal.dot(unit_or_up(toward_eye(eye, anchor.point))).abs();
        let size = if turned > 0.0 { (facing / turned).min(1.0) } else { 1.0 };
        let scale = size * if eye.orthographic { eye.scale } else { eye.scale / depth };
        let [length, half_width] = self.size.map(|size| size * scale);
        let seen = place.iter().all(|at| at.abs() <= FARTHEST) && (0.0..=FARTHEST).contains(&(length + half_width));
        // θ₀: the normalized projections of ∂P/∂u and ∂P/∂v, combined by the cosine and sine of `direction`.
        let (u, v) = (pictured(anchor, anchor.along_u, depth, eye)?, pictured(anchor, anchor.along_v, depth, eye)?);
        if !seen || length <= 0.0 || half_width <= 0.0 {
            return None;
        }
        let (sin, cos) = libm::sincos(self.direction);
        let way = [0, 1].map(|axis: usize| cos * u[axis] + sin * v[axis]);
        let direction = libm::atan2(way[1], way[0]);
        // Seen from behind, the projected u and v are mirrored, and so is the bend.
        let hand = if u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let shape = Shape { curl: self.shape.curl * hand, ..self.shape };
        let side = if shape.curl < 0.0 { -1.0 } else { 1.0 };
        let ribbon = Ribbon::new(&shape, place, direction, length, half_width);
        let mut parts: Vec<(Ribbon, f64)> =
            (0..self.thumbs()).map(|thumb| self.thumb(thumb, &ribbon, &shape, side, [length, half_width])).collect();
        parts.push((ribbon, draw(self.key, OWN)));
        let Row { line, tag, shade, .. } = *self.row;
        Some(Claw { parts, depth, side, row: self.number, tag, line: line.map(|line| line * scale), shade })
    }

    fn thumbs(&self) -> usize {
        self.row.thumbs.clamp(0, 4) as usize
    }

    /// Returns a thumb and its random number. `size` is the length and half width of the ribbon; thumb 0 is at the end
    /// of the fork nearest to the tip.
    fn thumb(&self, thumb: usize, ribbon: &Ribbon, shape: &Shape, side: f64, size: [f64; 2]) -> (Ribbon, f64) {
        let [length, half_width] = size;
        let fork = self.row.fork.map(|share| share.clamp(0.0, 1.0));
        let back = thumb as f64 / (self.thumbs().max(2) - 1) as f64;
        let (start, along) = ribbon.spine(fork[1] + back * (fork[0] - fork[1]));
        let random = |which: u64| draw(self.key, 10 * (thumb as u64 + 1) + which);
        let direction = along + side * (LEAN[0] + LEAN[1] * random(0)).to_radians();
        let curl = shape.curl * (BEND[0] + BEND[1] * random(1));
        let shape = Shape { curl, late: THUMB_LATE, taper: shape.taper, bulge: 0.0 };
        let length = SHORTER * length * (THUMB_LENGTH[0] + THUMB_LENGTH[1] * random(2));
        (Ribbon::new(&shape, start, direction, length, THINNER * half_width), random(3))
    }
}

/// Projects a world direction at a root of the given depth into the picture, and normalizes it; y points down.
///
/// A point P projects to (P·right, −P·up)/(P·forward); the projection of a direction d is the derivative of this along
/// d, up to a factor.
fn pictured(anchor: &Anchor, direction: DVec3, depth: f64, eye: &Projector) -> Option<[f64; 2]> {
    let offset = anchor.point - eye.position;
    let away = if eye.orthographic { 0.0 } else { direction.dot(eye.forward) / depth };
    let x = direction.dot(eye.right) - away * offset.dot(eye.right);
    let y = away * offset.dot(eye.up) - direction.dot(eye.up);
    let long = (x * x + y * y).sqrt();
    (long > 0.0 && long.is_finite()).then(|| [x / long, y / long])
}

/// Largest coordinate and size of a ribbon, in pixels; ribbons beyond it are not drawn.
const FARTHEST: f64 = 1e5;

struct PreparedHooks {
    view: One<port::View>,
    /// Claws with their bounding boxes, top claw first.
    claws: Vec<([[f64; 2]; 2], Claw)>,
    /// The same on the surfaces that references see.
    exact: Vec<([[f64; 2]; 2], Claw)>,
    step: f64,
}

impl PreparedHooks {
    /// Returns whether a surface at this depth hides a ribbon.
    fn is_hidden(&self, claw: &Claw, depth: f64) -> bool {
        depth * self.step < claw.depth
    }

    /// Returns the smallest part of `within` that contains all samples on which a claw may show: those that nothing
    /// hides or covers. `left` is the fraction of each sample of `window` that no ribbon covers yet.
    fn open(&self, claw: &Claw, within: Window, window: Window, left: &[f64], depths: &[f32]) -> Window {
        let mut open = Window::new(0, 0, 0, 0);
        for y in within.y0..within.y1 {
            let first = index(window, within.x0, y);
            let row = first..first + within.width();
            let is_open = |(left, depth): (&f64, &f32)| *left != 0.0 && !self.is_hidden(claw, f64::from(*depth));
            let mut samples = left[row.clone()].iter().zip(&depths[row]);
            if let Some(first) = samples.clone().position(is_open) {
                let last = samples.rposition(is_open).unwrap_or(first);
                let [x0, x1] = [first, last + 1].map(|column| within.x0 + column as i64);
                open = open.union(Window::new(x0, y, x1, y + 1));
            }
        }
        open
    }
}

/// Returns the index of a pixel of a window in its planes.
fn index(window: Window, x: i64, y: i64) -> usize {
    (y - window.y0) as usize * window.width() + (x - window.x0) as usize
}

impl Prepared for PreparedHooks {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let depths = inputs.view(&self.view, Channel::Depth);
        let mut planes = Out::ALL.map(|output| (output, outputs.take(output, 0)));
        planes.iter_mut().for_each(|(_, plane)| plane.iter_mut().for_each(|plane| plane.fill(0.0)));
        // Fraction of each sample that no ribbon covers yet; most blocks are far from all ribbons.
        let mut left = Scratch::new();
        let mut places = Places::default();
        for (bounds, claw) in &self.claws {
            let within = covered(*bounds, window);
            if within.area() == 0 {
                continue;
            }
            inputs.check_cancelled()?;
            if left.is_empty() {
                // What does not count is covered.
                left.extend((0..window.area()).map(|index| if block.counts(index) { 1.0 } else { 0.0 }));
            }
            let open = self.open(claw, within, window, &left, depths);
            let asked = |x: i64, y: i64| block.counts(index(window, x, y));
            let asked: Option<&dyn Fn(i64, i64) -> bool> = if block.only.is_some() { Some(&asked) } else { None };
            let pixels = (open.y0..open.y1).flat_map(|y| (open.x0..open.x1).map(move |x| (x, y)));
            for ((x, y), found) in pixels.zip(places.find(claw, open, block.offset, asked)) {
                let index = index(window, x, y);
                let Some((within, random)) = *found else { continue };
                if left[index] == 0.0 || self.is_hidden(claw, f64::from(depths[index])) {
                    continue;
                }
                let drawn = claw.drawn(within, random);
                let first = left[index] == 1.0;
                left[index] *= 1.0 - drawn.mask;
                for (output, plane) in &mut planes {
                    let Some(plane) = plane else { continue };
                    if *output == Out::Mask {
                        plane[index] = (1.0 - left[index]) as f32;
                    } else if first {
                        plane[index] = output.of(&drawn) as f32;
                    }
                }
            }
        }
        Ok(())
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound(
            "a point belongs to the nearest segment of a spine, and which segment is nearest may change at any point",
        ))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let depth = inputs.view(&self.view, Channel::Depth);
        let (mut drawn, mut left) = (Drawn::default(), 1.0);
        for (_, claw) in self.exact.iter().filter(|(_, claw)| !self.is_hidden(claw, depth)) {
            let Some((within, random)) = claw.at(inputs.at) else { continue };
            let found = claw.drawn(within, random);
            let mask = found.mask;
            if left == 1.0 {
                drawn = found;
            }
            left *= 1.0 - mask;
            drawn.mask = 1.0 - left;
        }
        let value = |output: Out| match output {
            Out::Mask | Out::Ink | Out::Shade => Reference::Mask(output.of(&drawn)),
            Out::Along | Out::Across | Out::HalfWidth | Out::Side | Out::Random | Out::Row | Out::Inset | Out::Tag => {
                Reference::Field(vec![output.of(&drawn)])
            }
        };
        Ok(Out::ALL.map(value).into())
    }

    fn bytes(&self) -> usize {
        self.claws
            .iter()
            .chain(&self.exact)
            .map(|(_, claw)| size_of::<Claw>() + claw.parts.len() * size_of::<(Ribbon, f64)>())
            .sum()
    }
}

impl Out {
    /// What a place has of it.
    fn of(self, drawn: &Drawn) -> f64 {
        match self {
            Self::Mask => drawn.mask,
            Self::Along => drawn.along,
            Self::Across => drawn.across,
            Self::HalfWidth => drawn.half_width,
            Self::Side => drawn.side,
            Self::Random => drawn.random,
            Self::Row => drawn.row,
            Self::Inset => drawn.inset,
            Self::Tag => drawn.tag,
            Self::Ink => drawn.ink,
            Self::Shade => drawn.shade,
        }
    }
}
