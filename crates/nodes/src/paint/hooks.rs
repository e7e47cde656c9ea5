//! Hooks: claws of foam that grow on a surface.

use crate::lit::{eye, toward_eye};
use crate::sea::{Roots, check_indices, check_roots, check_surfaces};
use crate::view::Looking;
use trochoid_field::random::{draw, key};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::claws::{Claw, Drawn, Places, Ribbon, Shape, covered};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{Anchor, DVec3, Projector};

/// Draws ribbons on bending spines that are rooted in a surface, such as claws of foam, and hands over where in its ribbon each
/// pixel lies.
///
/// # Formula
/// Direction of a spine after the share s of its way: θ₀ + curl·s^late; half its width: h = width/2·(1 − s)^taper·(1 + bulge·sin
/// πs)·√min(1, s/0.14). θ₀ is `direction` between the pictures of ∂P/∂u and ∂P/∂v at the root, both taken as one long. A place
/// belongs to the step of the spine whose middle is nearest in half widths, up to one: ends and bends are round. Of two ribbons
/// the later in the list is on top; a ribbon and its thumbs are one, in that of which a place lies deepest. Sizes are those of the
/// row times min(1, |n·v|/turned), so that ribbons come and go by growing. With the inset i in pixels: mask = min(1, i); ink =
/// clamp(½ + line − i), which sets in at s from 0.06 to 0.3 outside, 0.35 to 0.65 inside the bend; shade = clamp(½ + h·(t − 1 +
/// shade·(0.98 − 0.8·((s − 0.42)/0.4)²))), t = across·side.
///
/// # Edge cases
/// Roots are where the surface itself has these u and v, seen or not; where several of its points have them, each has a ribbon.
/// Ribbons reach out over what lies behind their root, not over what is nearer by more than `edge`. Where there is none, all
/// outputs are 0. Needs a Render's view: passes know no surfaces. Each sample of a pixel is drawn apart.
///
/// # Source
/// The foam of Hokusai's Great Wave.
#[derive(Clone, Node)]
#[node(end = Front, revision = 2, outputs = Out)]
pub(crate) struct Hooks {
    /// The surface.
    view: One<port::View>,
    /// Rows of ribbons, the lowest first.
    #[list(1..=256)]
    rows: Vec<Row>,
    /// Index of the surface in the Render's list; by default all.
    #[knob(range = 0..=63)]
    surface: Option<i64>,
    /// |n · v| below which ribbons shrink as their root turns away.
    #[knob(default = 0.3, range = 0.0..=1.0)]
    turned: f64,
    /// The least jump of depth that hides, as a share of the depth.
    #[knob(default = 0.05, range = 1e-4..=1e3)]
    edge: f64,
    /// Which ribbons of all that have these figures.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Ribbons side by side.
#[derive(Clone, Items)]
pub(crate) struct Row {
    /// Where the row begins on the surface: u, v.
    #[knob(default = [0.0, 0.0])]
    pub(crate) from: [f64; 2],
    /// Where it ends: u, v.
    #[knob(default = [1.0, 0.0])]
    pub(crate) to: [f64; 2],
    /// How far roots stand off the row, to either side: u, v.
    #[knob(default = [0.0, 0.0])]
    pub(crate) scatter: [f64; 2],
    /// Index of the row's surface; by default that of the node.
    #[knob(range = 0..=63)]
    pub(crate) surface: Option<i64>,
    /// Ribbons in the row.
    #[knob(default = 8, range = 1..=512)]
    count: i64,
    /// Their length.
    #[knob(default = 1.0, range = 1e-6..=1e6, unit = "m")]
    pub(crate) length: f64,
    /// Their width.
    #[knob(default = 0.3, range = 1e-6..=1e6, unit = "m")]
    width: f64,
    /// Where they grow: 0 along u, 90 along v.
    #[knob(default = 90.0, range = -360.0..=360.0, unit = "degrees")]
    direction: f64,
    /// How far they bend to the tip: positive from u toward v.
    #[knob(default = 110.0, range = -720.0..=720.0, unit = "degrees")]
    curl: f64,
    /// How late they bend: 1 evenly, 2.5 near the tip.
    #[knob(default = 1.5, range = 0.1..=16.0)]
    late: f64,
    /// How they get thinner: small ones stay thick for long.
    #[knob(default = 0.62, range = 0.05..=8.0)]
    taper: f64,
    /// How much thicker they are in the middle.
    #[knob(default = 0.25, range = 0.0..=4.0)]
    bulge: f64,
    /// Small ribbons on the inner side of the bend.
    #[knob(default = 0, range = 0..=4)]
    thumbs: i64,
    /// Between which shares of the way thumbs grow.
    #[knob(default = [0.16, 0.4])]
    fork: [f64; 2],
    /// How wide the ink is along the outer and the inner rim.
    #[knob(default = [0.0, 0.0], unit = "m")]
    line: [f64; 2],
    /// Size of the crescent of shade on the inner side.
    #[knob(default = 0.0, range = 0.0..=2.0)]
    shade: f64,
    /// How far directions differ, to either side.
    #[knob(default = 18.0, range = 0.0..=180.0, unit = "degrees")]
    spread: f64,
    /// How far places, lengths and bends differ, as a share.
    #[knob(default = 0.35, range = 0.0..=0.95)]
    vary: f64,
    /// Handed on, to tell kinds of ribbons apart.
    #[knob(default = 0.0, range = -1e6..=1e6)]
    tag: f64,
}

/// What is known of each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
pub(crate) enum Out {
    /// 1 within ribbons, soft by a pixel at their rims.
    #[output(Kind::MASK)]
    Mask,
    /// 0 at the root, 1 at the tip.
    #[output(Kind::Field(1))]
    Along,
    /// −1 to 1 from the left of the way to its right.
    #[output(Kind::Field(1))]
    Across,
    /// Half the width there, in pixels.
    #[output(Kind::Field(1))]
    HalfWidth,
    /// The side to which the ribbon bends: 1 right, −1 left.
    #[output(Kind::Field(1))]
    Side,
    /// A number of each ribbon, in [0, 1).
    #[output(Kind::Field(1))]
    Random,
    /// Which row, the first is 1.
    #[output(Kind::Field(1))]
    Row,
    /// Distance in pixels to the rim of a ribbon and its thumbs together.
    #[output(Kind::Field(1))]
    Inset,
    /// The row's tag.
    #[output(Kind::Field(1))]
    Tag,
    /// Lines along the rims that fade in from the root; within `mask`.
    #[output(Kind::MASK)]
    Ink,
    /// A crescent on the inner side; within `mask`.
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
        // A ribbon at a sample, for each pixel of its length; and a thumb beside it, as a share of that.
        const PIXEL: f64 = 1.5e-6;
        const THUMB: f64 = 0.25;
        // How large ribbons are in the picture is known to the camera alone: taken is a claw of a large wave.
        let length = f64::from(format.height()) / 24.0;
        let row = |row: &Row| row.count as f64 * (1.0 + THUMB * row.thumbs as f64);
        let ribbons: f64 = self.rows.iter().map(row).sum();
        let remedy = "lower the \"count\" or \"thumbs\" of rows, or have fewer samples or pixels";
        Some(Work { seconds: PIXEL * length * f64::from(format.samples()) * ribbons, item: Self::ROWS, remedy })
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Hooks {
    fn asks(&self, _wanted: &[bool]) -> ChannelSet {
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
        let Some(looking) = handle.as_deref().and_then(|handle| handle.downcast_ref::<Looking>()) else {
            return Err(BadData::new("a view of passes", "one of surfaces", "connect a Render").into());
        };
        let mut claws: Vec<Claw> = Vec::new();
        for root in self.roots() {
            let only = |index: usize| root.surface.is_none_or(|only| only == index as i64);
            for (_, surface) in looking.surfaces.iter().enumerate().filter(|(index, _)| only(*index)) {
                claws.extend(surface.anchors(root.uv).iter().filter_map(|anchor| root.grow(anchor, &eye, self.turned)));
            }
            if prepare.cancelled() {
                break;
            }
        }
        // The uppermost first.
        let claws = claws.into_iter().rev().map(|claw| (claw.bounds(), claw)).collect();
        Ok(Box::new(PreparedHooks { view: self.view.clone(), claws, step: 1.0 + self.edge }))
    }
}

/// One ribbon on a surface.
struct Root<'n> {
    row: &'n Row,
    uv: [f64; 2],
    /// The only surface that it grows on.
    surface: Option<i64>,
    shape: Shape,
    /// In radians, between u and v.
    direction: f64,
    /// Length and half width, in meters.
    size: [f64; 2],
    /// Of its row, the first is 1.
    number: f64,
    key: u64,
}

/// Which of a ribbon's random numbers means what. Those of thumb i begin at 10·(i + 1): turn, bend, length, its own.
const OFF_PLACE: u64 = 0;
const OFF_SIZE: u64 = 1;
const OFF_CURL: u64 = 2;
const OFF_DIRECTION: u64 = 3;
const OWN: u64 = 4;
const OFF_SCATTER: u64 = 5;

impl Hooks {
    /// All roots, the lowest first.
    fn roots(&self) -> Vec<Root<'_>> {
        let mut roots = Vec::new();
        for (at, row) in self.rows.iter().enumerate() {
            let count = row.count.max(1);
            let (from, to, vary) = (row.from, row.to, row.vary);
            for index in 0..count {
                let key = key(key(key(0x686f_6f6b, self.seed), at as i64), index);
                let off = |which: u64| 2.0 * draw(key, which) - 1.0;
                // A share of the row, within its own part of it; widths differ half as much as lengths.
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

/// Thumbs against the ribbon that they grow on. They lean off it toward the inner side of its bend by 52° to 68°, bend by 0.75
/// to 1.25 of its bend, late (s^2.2), and are 0.9 · (0.46 to 0.62) as long and 0.7 as wide.
const LEAN: [f64; 2] = [52.0, 16.0];
const BEND: [f64; 2] = [0.75, 0.5];
const THUMB_LATE: f64 = 2.2;
const THUMB_LENGTH: [f64; 2] = [0.46, 0.16];
const SHORTER: f64 = 0.9;
const THINNER: f64 = 0.7;

impl Root<'_> {
    /// The ribbon in the picture, where the eye sees its root's place and it has any size.
    fn grow(&self, anchor: &Anchor, eye: &Projector, turned: f64) -> Option<Claw> {
        let (place, depth) = eye.project(anchor.point)?;
        // Pixels for a meter at the root, times min(1, |n·v|/turned).
        let normal = unit_or_up(anchor.along_v.cross(anchor.along_u));
        let facing = normal.dot(unit_or_up(toward_eye(eye, anchor.point))).abs();
        let size = if turned > 0.0 { (facing / turned).min(1.0) } else { 1.0 };
        let scale = size * if eye.orthographic { eye.scale } else { eye.scale / depth };
        let [length, half_width] = self.size.map(|size| size * scale);
        let seen = place.iter().all(|at| at.abs() <= FARTHEST) && (0.0..=FARTHEST).contains(&(length + half_width));
        // θ₀: the pictures of ∂P/∂u and ∂P/∂v, one long each, by cos and sin of `direction`.
        let (u, v) = (pictured(anchor, anchor.along_u, depth, eye)?, pictured(anchor, anchor.along_v, depth, eye)?);
        if !seen || length <= 0.0 || half_width <= 0.0 {
            return None;
        }
        let (sin, cos) = libm::sincos(self.direction);
        let way = [0, 1].map(|axis: usize| cos * u[axis] + sin * v[axis]);
        let direction = libm::atan2(way[1], way[0]);
        // Seen from behind, u and v change hands, and so does the bend.
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

    /// A thumb of a ribbon so long and half so wide, from the tip's end of the fork on; with its random number.
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

/// Where a direction in the world leads in the picture from a root at a depth, one long; y down.
///
/// The picture of a point P is (P·right, −P·up)/(P·forward), so that of a step d is its derivative along d, up to a factor.
fn pictured(anchor: &Anchor, direction: DVec3, depth: f64, eye: &Projector) -> Option<[f64; 2]> {
    let offset = anchor.point - eye.position;
    let away = if eye.orthographic { 0.0 } else { direction.dot(eye.forward) / depth };
    let x = direction.dot(eye.right) - away * offset.dot(eye.right);
    let y = away * offset.dot(eye.up) - direction.dot(eye.up);
    let long = (x * x + y * y).sqrt();
    (long > 0.0 && long.is_finite()).then(|| [x / long, y / long])
}

/// Pixels beyond which no ribbon begins or reaches.
const FARTHEST: f64 = 1e5;

struct PreparedHooks {
    view: One<port::View>,
    /// The uppermost first, each with its bounds.
    claws: Vec<([[f64; 2]; 2], Claw)>,
    step: f64,
}

impl PreparedHooks {
    /// Whether a ribbon is hidden by what stands at that depth.
    fn is_hidden(&self, claw: &Claw, depth: f64) -> bool {
        depth * self.step < claw.depth
    }
}

impl Prepared for PreparedHooks {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let depths = inputs.view(&self.view, Channel::Depth);
        let mut planes = Out::ALL.map(|output| (output, outputs.take(output, 0)));
        planes.iter_mut().for_each(|(_, plane)| plane.iter_mut().for_each(|plane| plane.fill(0.0)));
        // What no ribbon covers yet.
        let mut left = vec![1.0; window.area()];
        let mut places = Places::default();
        for (bounds, claw) in &self.claws {
            let within = covered(*bounds, window);
            if within.area() == 0 {
                continue;
            }
            inputs.go_on()?;
            let pixels = (within.y0..within.y1).flat_map(|y| (within.x0..within.x1).map(move |x| (x, y)));
            for ((x, y), found) in pixels.zip(places.find(claw, within, block.offset)) {
                let index = (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
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
        Err(NoBound("a place belongs to the nearest step of a spine, and which is the nearest may change anywhere"))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let depth = inputs.view(&self.view, Channel::Depth);
        let (mut drawn, mut left) = (Drawn::default(), 1.0);
        for (_, claw) in self.claws.iter().filter(|(_, claw)| !self.is_hidden(claw, depth)) {
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
        self.claws.iter().map(|(_, claw)| size_of::<Claw>() + claw.parts.len() * size_of::<(Ribbon, f64)>()).sum()
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
