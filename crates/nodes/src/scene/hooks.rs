//! Hooks: claws of foam that grow on a surface.

use crate::paint_support::{Claw, Places, Ribbon, Shape, VALUES, covered, draw, key};
use crate::scene_support::{Looking, check_indices, check_roots, check_surfaces, eye, toward_eye};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{Anchor, Projector};

pub(crate) static NODE: &dyn NodeType = &Hooks;

struct Hooks;

static DECLARATION: Declaration = Declaration {
    name: "Hooks",
    end: End::Front,
    summary: "Draws ribbons on bending spines that are rooted in a surface, such as claws of foam, and hands over \
              where in its ribbon each pixel lies.",
    formula: "Direction of a spine after the share s of its way: θ₀ + curl·s^late; half its width: h = width/2·(1 − \
              s)^taper·(1 + bulge·sin πs)·√min(1, s/0.14). θ₀ is `direction` between the pictures of ∂P/∂u and ∂P/∂v \
              at the root, both taken as one long. A place belongs to the step of the spine whose middle is nearest \
              in half widths, up to one: ends and bends are round. Of two ribbons the later in the list is on top; a \
              ribbon and its thumbs are one, in that of which a place lies deepest. Sizes are those of the row times \
              min(1, |n·v|/turned), so that ribbons come and go by growing. With the inset i in pixels: mask = min(1, \
              i); ink = clamp(½ + line − i), which sets in at s from 0.06 to 0.3 outside, 0.35 to 0.65 inside the \
              bend; shade = clamp(½ + h·(t − 1 + shade·(0.98 − 0.8·((s − 0.42)/0.4)²))), t = across·side.",
    edge_cases: "Roots are where the surface itself has these u and v, seen or not; where several of its points have \
                 them, each has a ribbon. Ribbons reach out over what lies behind their root, not over what is nearer \
                 by more than `edge`. Where there is none, all outputs are 0. Needs a Render's view: passes know no \
                 surfaces. Each sample of a pixel is drawn apart.",
    source: "The foam of Hokusai's Great Wave.",
    items: &[
        Port::one("view", Accepts::View, "The surface."),
        List::of(
            "rows",
            &[
                Knob::vector("from", &[0.0, 0.0], "Where the row begins on the surface: u, v.").item(),
                Knob::vector("to", &[1.0, 0.0], "Where it ends: u, v.").item(),
                Knob::vector("scatter", &[0.0, 0.0], "How far roots stand off the row, to either side: u, v.").item(),
                Knob::integer("surface", 0, 0, 63, "Index of the row's surface; by default that of the node.")
                    .optional()
                    .item(),
                Knob::integer("count", 8, 1, 512, "Ribbons in the row.").item(),
                Knob::number("length", 1.0, 1e-6, 1e6, "Their length.").unit("m").item(),
                Knob::number("width", 0.3, 1e-6, 1e6, "Their width.").unit("m").item(),
                Knob::number("direction", 90.0, -360.0, 360.0, "Where they grow: 0 along u, 90 along v.")
                    .unit("degrees")
                    .item(),
                Knob::number("curl", 110.0, -720.0, 720.0, "How far they bend to the tip: positive from u toward v.")
                    .unit("degrees")
                    .item(),
                Knob::number("late", 1.5, 0.1, 16.0, "How late they bend: 1 evenly, 2.5 near the tip.").item(),
                Knob::number("taper", 0.62, 0.05, 8.0, "How they get thinner: small ones stay thick for long.").item(),
                Knob::number("bulge", 0.25, 0.0, 4.0, "How much thicker they are in the middle.").item(),
                Knob::integer("thumbs", 0, 0, 4, "Small ribbons on the inner side of the bend.").item(),
                Knob::vector("fork", &[0.16, 0.4], "Between which shares of the way thumbs grow.").item(),
                Knob::vector("line", &[0.0, 0.0], "How wide the ink is along the outer and the inner rim.")
                    .unit("m")
                    .item(),
                Knob::number("shade", 0.0, 0.0, 2.0, "Size of the crescent of shade on the inner side.").item(),
                Knob::number("spread", 18.0, 0.0, 180.0, "How far directions differ, to either side.")
                    .unit("degrees")
                    .item(),
                Knob::number("vary", 0.35, 0.0, 0.95, "How far places, lengths and bends differ, as a share.").item(),
                Knob::number("tag", 0.0, -1e6, 1e6, "Handed on, to tell kinds of ribbons apart.").item(),
            ],
            1,
            256,
            "Rows of ribbons, the lowest first.",
        ),
        Knob::integer("surface", 0, 0, 63, "Index of the surface in the Render's list; by default all.")
            .optional()
            .item(),
        Knob::number("turned", 0.3, 0.0, 1.0, "|n · v| below which ribbons shrink as their root turns away.").item(),
        Knob::number("edge", 0.05, 1e-4, 1e3, "The least jump of depth that hides, as a share of the depth.").item(),
        Knob::integer("seed", 0, 0, 1_000_000_000, "Which ribbons of all that have these figures.").item(),
    ],
    outputs: &[
        Output::new("mask", Kind::MASK, "1 within ribbons, soft by a pixel at their rims."),
        Output::new("along", Kind::Field(1), "0 at the root, 1 at the tip."),
        Output::new("across", Kind::Field(1), "−1 to 1 from the left of the way to its right."),
        Output::new("half_width", Kind::Field(1), "Half the width there, in pixels."),
        Output::new("side", Kind::Field(1), "The side to which the ribbon bends: 1 right, −1 left."),
        Output::new("random", Kind::Field(1), "A number of each ribbon, in [0, 1)."),
        Output::new("row", Kind::Field(1), "Which row, the first is 1."),
        Output::new("inset", Kind::Field(1), "Distance in pixels to the rim of a ribbon and its thumbs together."),
        Output::new("tag", Kind::Field(1), "The row's tag."),
        Output::new("ink", Kind::MASK, "Lines along the rims that fade in from the root; within `mask`."),
        Output::new("shade", Kind::MASK, "A crescent on the inner side; within `mask`."),
    ],
    revision: 2,
};

impl NodeType for Hooks {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_surfaces(node, check);
        check_roots(node, check);
        let own = |of: &Settled| of.is_set("surface").then(|| of.number("surface"));
        check_indices(node, check, "surface", own(node).into_iter());
        check_indices(node, check, "rows", node.list("rows").iter().filter_map(own));
    }

    fn work(&self, node: &Settled, format: Format, _time: f64) -> Option<Work> {
        // A ribbon at a sample, for each pixel of its length; and a thumb beside it, as a share of that.
        const PIXEL: f64 = 1.5e-6;
        const THUMB: f64 = 0.25;
        // How large ribbons are in the picture is known to the camera alone: taken is a claw of a large wave.
        let length = f64::from(format.height()) / 24.0;
        let row = |row: &Settled| row.number("count") * (1.0 + THUMB * row.number("thumbs"));
        let ribbons: f64 = node.list("rows").iter().map(row).sum();
        let remedy = "lower the \"count\" or \"thumbs\" of rows, or have fewer samples or pixels";
        Some(Work { seconds: PIXEL * length * f64::from(format.samples()) * ribbons, item: "rows", remedy })
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Hooks {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        Channel::Depth.into()
    }

    fn interval(&self, _node: &Settled, output: usize, _channel: usize) -> Option<(f64, f64)> {
        match output {
            0 | 1 | 5 | 9 | 10 => Some((0.0, 1.0)),
            2 | 4 => Some((-1.0, 1.0)),
            _ => None,
        }
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let eye = eye(node, prepare, prepare.frame.format)?;
        let handle = prepare.handle_of(node, "view");
        let Some(looking) = handle.as_deref().and_then(|handle| handle.downcast_ref::<Looking>()) else {
            return Err(NodeError::new("the view knows no surfaces: connect a Render"));
        };
        let turned = node.number("turned");
        let mut claws: Vec<Claw> = Vec::new();
        for root in roots(node) {
            let only = |index: usize| root.surface.is_none_or(|only| only == index as f64);
            for (_, surface) in looking.surfaces.iter().enumerate().filter(|(index, _)| only(*index)) {
                claws.extend(surface.anchors(root.uv).iter().filter_map(|anchor| root.grow(anchor, &eye, turned)));
            }
            if prepare.cancelled() {
                break;
            }
        }
        // The uppermost first.
        let claws = claws.into_iter().rev().map(|claw| (claw.bounds(), claw)).collect();
        Ok(Box::new(Growing { node: node.clone(), claws, step: 1.0 + node.number("edge") }))
    }
}

/// One ribbon on a surface.
struct Root {
    uv: [f64; 2],
    /// The only surface that it grows on.
    surface: Option<f64>,
    shape: Shape,
    /// In radians, between u and v.
    direction: f64,
    /// Length and half width, in meters.
    size: [f64; 2],
    thumbs: usize,
    /// Where they grow.
    fork: [f64; 2],
    /// Widths of the ink outside and inside the bend, in meters.
    line: [f64; 2],
    shade: f64,
    row: usize,
    tag: f64,
    key: u64,
}

/// All roots, the lowest first.
fn roots(node: &Settled) -> Vec<Root> {
    let mut roots = Vec::new();
    for (row, list) in node.list("rows").iter().enumerate() {
        let count = list.integer("count").max(1);
        let surface = [list, node].into_iter().find(|of| of.is_set("surface")).map(|of| of.number("surface"));
        let (from, to, vary) = (list.vector3("from"), list.vector3("to"), list.number("vary"));
        let [scatter, fork, line] = ["scatter", "fork", "line"].map(|knob| list.vector3(knob));
        for index in 0..count {
            let key = key(key(key(0x686f_6f6b, node.integer("seed")), row as i64), index);
            let off = |which: u64| 2.0 * draw(key, which) - 1.0;
            let along = ((index as f64 + 0.5 + 0.5 * vary * off(0)) / count as f64).clamp(0.0, 1.0);
            let size = 1.0 + vary * off(1);
            let place =
                |axis: usize| from[axis] + along * (to[axis] - from[axis]) + scatter[axis] * off(5 + axis as u64);
            roots.push(Root {
                uv: [0, 1].map(place),
                surface,
                shape: Shape {
                    curl: list.number("curl").to_radians() * (1.0 + 0.5 * vary * off(2)),
                    late: list.number("late"),
                    taper: list.number("taper"),
                    bulge: list.number("bulge"),
                },
                direction: (list.number("direction") + list.number("spread") * off(3)).to_radians(),
                size: [list.number("length") * size, 0.5 * list.number("width") * (0.5 + 0.5 * size)],
                thumbs: list.integer("thumbs").clamp(0, 4) as usize,
                fork: [fork[0], fork[1]].map(|share| share.clamp(0.0, 1.0)),
                line: [line[0], line[1]],
                shade: list.number("shade"),
                row,
                tag: list.number("tag"),
                key,
            });
        }
    }
    roots
}

impl Root {
    /// The ribbon in the picture, where the eye sees its root's place and it has any size.
    fn grow(&self, anchor: &Anchor, eye: &Projector, turned: f64) -> Option<Claw> {
        let (place, depth) = eye.project(anchor.point)?;
        let normal = unit_or_up(anchor.along_v.cross(anchor.along_u));
        let facing = normal.dot(unit_or_up(toward_eye(eye, anchor.point))).abs();
        let size = if turned > 0.0 { (facing / turned).min(1.0) } else { 1.0 };
        let scale = size * if eye.orthographic { eye.scale } else { eye.scale / depth };
        let [length, half_width] = self.size.map(|size| size * scale);
        let offset = anchor.point - eye.position;
        // Where a direction in the world leads in the picture, one long.
        let pictured = |direction: trochoid_scene::DVec3| {
            let away = if eye.orthographic { 0.0 } else { direction.dot(eye.forward) / depth };
            let x = direction.dot(eye.right) - away * offset.dot(eye.right);
            let y = away * offset.dot(eye.up) - direction.dot(eye.up);
            let long = (x * x + y * y).sqrt();
            (long > 0.0 && long.is_finite()).then(|| [x / long, y / long])
        };
        let (u, v) = (pictured(anchor.along_u)?, pictured(anchor.along_v)?);
        let seen = place.iter().all(|at| at.abs() <= FARTHEST) && (0.0..=FARTHEST).contains(&(length + half_width));
        if !seen || length <= 0.0 || half_width <= 0.0 {
            return None;
        }
        let (sin, cos) = libm::sincos(self.direction);
        let way = [0, 1].map(|axis: usize| cos * u[axis] + sin * v[axis]);
        let direction = libm::atan2(way[1], way[0]);
        let hand = if u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let shape = Shape { curl: self.shape.curl * hand, ..self.shape };
        let side = if shape.curl < 0.0 { -1.0 } else { 1.0 };
        let random = |which: u64| draw(self.key, which);
        let ribbon = Ribbon::new(&shape, place, direction, length, half_width);
        let thumb = |thumb: usize| {
            // From the tip's end of the fork on.
            let back = thumb as f64 / (self.thumbs.max(2) - 1) as f64;
            let (start, along) = ribbon.spine(self.fork[1] + back * (self.fork[0] - self.fork[1]));
            let which = 10 * (thumb as u64 + 1);
            let direction = along + side * (52.0 + 16.0 * random(which)).to_radians();
            let curl = shape.curl * (0.75 + 0.5 * random(which + 1));
            let shape = Shape { curl, late: 2.2, taper: shape.taper, bulge: 0.0 };
            let length = 0.9 * length * (0.46 + 0.16 * random(which + 2));
            (Ribbon::new(&shape, start, direction, length, 0.7 * half_width), random(which + 3))
        };
        let mut parts: Vec<(Ribbon, f64)> = (0..self.thumbs).map(thumb).collect();
        parts.push((ribbon, random(4)));
        let line = self.line.map(|line| line * scale);
        Some(Claw { parts, depth, side, row: self.row as f64 + 1.0, tag: self.tag, line, shade: self.shade })
    }
}

/// Pixels beyond which no ribbon begins or reaches.
const FARTHEST: f64 = 1e5;

struct Growing {
    node: Settled,
    /// The uppermost first, each with its bounds.
    claws: Vec<([[f64; 2]; 2], Claw)>,
    step: f64,
}

impl Growing {
    /// Whether a ribbon is hidden by what stands at that depth.
    fn is_hidden(&self, claw: &Claw, depth: f64) -> bool {
        depth * self.step < claw.depth
    }
}

impl Prepared for Growing {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let depths = inputs.view("view", Channel::Depth);
        let mut planes: [Option<&mut [f32]>; VALUES] = std::array::from_fn(|output| outputs.take(output, 0));
        planes.iter_mut().flatten().for_each(|plane| plane.fill(0.0));
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
                let values = claw.values(within, random);
                let first = left[index] == 1.0;
                left[index] *= 1.0 - values[0];
                for (output, plane) in planes.iter_mut().enumerate() {
                    let Some(plane) = plane else { continue };
                    if output == 0 {
                        plane[index] = (1.0 - left[index]) as f32;
                    } else if first {
                        plane[index] = values[output] as f32;
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
        let depth = inputs.view(self.node.source("view"), Channel::Depth);
        let (mut values, mut left) = ([0.0; VALUES], 1.0);
        for (_, claw) in self.claws.iter().filter(|(_, claw)| !self.is_hidden(claw, depth)) {
            let Some((within, random)) = claw.at(inputs.at) else { continue };
            let found = claw.values(within, random);
            if left == 1.0 {
                values = found;
            }
            left *= 1.0 - found[0];
            values[0] = 1.0 - left;
        }
        let value = |(output, value): (usize, f64)| match output {
            0 | 9 | 10 => Reference::Mask(value),
            _ => Reference::Field(vec![value]),
        };
        Ok(values.into_iter().enumerate().map(value).collect())
    }

    fn bytes(&self) -> usize {
        self.claws.iter().map(|(_, claw)| size_of::<Claw>() + claw.parts.len() * size_of::<(Ribbon, f64)>()).sum()
    }
}
