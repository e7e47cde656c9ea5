//! Hooks: claws of foam that grow on a surface.

use crate::paint_support::{Ribbon, Shape, draw, key, within};
use crate::scene_support::{Around, check_roots, eye, grown};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_scene::Projector;

pub(crate) static NODE: &dyn NodeType = &Hooks;

struct Hooks;

static DECLARATION: Declaration = Declaration {
    name: "Hooks",
    end: End::Front,
    summary: "Draws ribbons on bending spines that are rooted in a surface, such as claws of foam, and hands over \
              where in its ribbon each pixel lies.",
    formula: "Direction of a spine after the share s of its way: θ₀ + curl·s^late; half its width: width/2·(1 − \
              s)^taper·(1 + bulge·sin πs)·√min(1, s/0.14). θ₀ is `direction` between the pictures of the axes u and v \
              at the root, both taken as one long. A place belongs to the step of the spine whose middle is nearest \
              in half widths, up to one: ends and bends are round. Of two ribbons the later in the list is on top.",
    edge_cases: "A root that is hidden has no ribbon; one that is seen at several places has one at each. Ribbons \
                 reach out over what lies behind their root, not over what is nearer. Where there is none, all \
                 outputs are 0. Ribbons longer than `reach` are as long as that. Needs a view with a camera. Each \
                 sample of a pixel is drawn apart.",
    source: "The foam of Hokusai's Great Wave.",
    items: &[
        Port::one("view", Accepts::View, "The surface."),
        Port::optional("size", Accepts::Mask, "Share of the size, at the root; 0 leaves a ribbon away."),
        List::of(
            "rows",
            &[
                Knob::vector("from", &[0.0, 0.0], "Where the row begins on the surface: u, v.").item(),
                Knob::vector("to", &[1.0, 0.0], "Where it ends: u, v.").item(),
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
                Knob::integer("thumbs", 0, 0, 2, "Small ribbons on the inner side of the bend.").item(),
                Knob::number("spread", 18.0, 0.0, 180.0, "How far directions differ, to either side.")
                    .unit("degrees")
                    .item(),
                Knob::number("vary", 0.35, 0.0, 0.95, "How far places, lengths and bends differ, as a share.").item(),
            ],
            1,
            64,
            "Rows of ribbons, the lowest first.",
        ),
        Knob::integer("surface", 0, 0, 63, "Index of the surface in the Render's list; by default any.")
            .optional()
            .item(),
        Knob::number("reach", 64.0, 1.0, 512.0, "How far ribbons reach at most, in pixels.").unit("pixels").item(),
        Knob::number("edge", 0.05, 1e-4, 1e3, "The least jump of depth that hides, as a share of the depth.").item(),
        Knob::integer("seed", 0, 0, 1_000_000_000, "Which ribbons of all that have these figures.").item(),
    ],
    outputs: &[
        Output::new("mask", Kind::MASK, "1 within ribbons."),
        Output::new("along", Kind::Field(1), "0 at the root, 1 at the tip."),
        Output::new("across", Kind::Field(1), "−1 to 1 from the left of the way to its right."),
        Output::new("half_width", Kind::Field(1), "Half the width there, in pixels."),
        Output::new("side", Kind::Field(1), "The side to which the ribbon bends: 1 right, −1 left."),
        Output::new("random", Kind::Field(1), "A number of each ribbon, in [0, 1)."),
        Output::new("row", Kind::Field(1), "Which row, the first is 1."),
    ],
    revision: 1,
};

const UV: [ViewChannel; 2] = [ViewChannel::U, ViewChannel::V];

impl NodeType for Hooks {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_roots(node, check);
    }

    fn work(&self, node: &Settled, format: Format, _time: f64) -> Option<Work> {
        // A sample, and a sample near a ribbon.
        const SAMPLE: f64 = 1.5e-7;
        const NEAR: f64 = 1e-9;
        let ribbons = |row: &Settled| row.number("count") * (1.0 + row.number("thumbs"));
        let (pixels, reach) = (format.window().area() as f64, node.number("reach"));
        let near = node.list("rows").iter().map(ribbons).sum::<f64>() * pixels.min(reach * reach);
        let seconds = f64::from(format.samples()) * (SAMPLE * pixels + NEAR * near);
        Some(Work { seconds, item: "rows", remedy: "lower \"count\" of the rows, \"reach\", or the samples or pixels" })
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Hooks {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&UV).union(ChannelSet::of(&[ViewChannel::Coverage, ViewChannel::Depth]))
    }

    fn prefers(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ViewChannel::Surface.into()
    }

    fn interval(&self, _node: &Settled, output: usize, _channel: usize) -> Option<(f64, f64)> {
        match output {
            0 | 1 | 5 => Some((0.0, 1.0)),
            2 | 4 => Some((-1.0, 1.0)),
            _ => None,
        }
    }

    fn regions_of_interest(&self, node: &Settled, _port: &str, window: Window) -> Window {
        grown(window, node.number("reach").ceil() as i64 + 2)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Growing {
            node: node.clone(),
            picture: prepare.frame.format.window(),
            eye: eye(node, prepare, prepare.frame.format)?,
            roots: roots(node),
            surface: node.is_set("surface").then(|| node.number("surface")),
            reach: node.number("reach"),
            step: 1.0 + node.number("edge"),
        }))
    }
}

/// One ribbon on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Root {
    uv: [f64; 2],
    shape: Shape,
    /// In radians, between u and v.
    direction: f64,
    /// Length and half width, in meters.
    size: [f64; 2],
    thumbs: usize,
    /// Its place in the list, over all rows.
    order: usize,
    row: usize,
    key: u64,
}

/// All roots by u.
fn roots(node: &Settled) -> Vec<Root> {
    let mut roots = Vec::new();
    for (row, list) in node.list("rows").iter().enumerate() {
        let count = list.integer("count").max(1);
        let (from, to, vary) = (list.vector3("from"), list.vector3("to"), list.number("vary"));
        for index in 0..count {
            let key = key(key(key(0x686f_6f6b, node.integer("seed")), row as i64), index);
            let off = |which: u64| 2.0 * draw(key, which) - 1.0;
            let along = ((index as f64 + 0.5 + 0.5 * vary * off(0)) / count as f64).clamp(0.0, 1.0);
            let size = 1.0 + vary * off(1);
            roots.push(Root {
                uv: [0, 1].map(|axis| from[axis] + along * (to[axis] - from[axis])),
                shape: Shape {
                    curl: list.number("curl").to_radians() * (1.0 + 0.5 * vary * off(2)),
                    late: list.number("late"),
                    taper: list.number("taper"),
                    bulge: list.number("bulge"),
                },
                direction: (list.number("direction") + list.number("spread") * off(3)).to_radians(),
                size: [list.number("length") * size, 0.5 * list.number("width") * (0.5 + 0.5 * size)],
                thumbs: list.integer("thumbs").clamp(0, 2) as usize,
                order: roots.len(),
                row,
                key,
            });
        }
    }
    roots.sort_by(|a, b| a.uv[0].total_cmp(&b.uv[0]).then(a.order.cmp(&b.order)));
    roots
}

struct Growing {
    node: Settled,
    picture: Window,
    eye: Projector,
    roots: Vec<Root>,
    surface: Option<f64>,
    reach: f64,
    step: f64,
}

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    uv: [f64; 2],
    surface: f64,
    depth: f64,
}

/// A ribbon in the picture.
struct Grown {
    ribbon: Ribbon,
    /// Of what it is rooted in.
    depth: f64,
    /// Later ones are on top.
    order: (usize, usize),
    side: f64,
    random: f64,
    row: usize,
}

/// Values of all outputs.
const OUTPUTS: usize = 7;

impl Growing {
    /// The place of a root between four pixels (upper left, upper right, lower left, lower right), in pixels from the
    /// first, and the directions of u and v there; `None` where it does not lie between them.
    fn between(&self, corners: [Seen; 4], uv: [f64; 2]) -> Option<([f64; 2], [[f64; 2]; 2])> {
        let [a, b, c, d] = corners.map(|corner| corner.uv);
        let at = within(&[a, b, c, d], uv)?;
        // Changes of u and v to the right and down; their inverse says where u and v lead in the picture.
        let right = [0, 1].map(|axis: usize| 0.5 * (b[axis] - a[axis] + d[axis] - c[axis]));
        let down = [0, 1].map(|axis: usize| 0.5 * (c[axis] - a[axis] + d[axis] - b[axis]));
        let area = right[0] * down[1] - right[1] * down[0];
        let unit = |[x, y]: [f64; 2]| {
            let length = (x * x + y * y).sqrt() * area.signum();
            (length != 0.0 && length.is_finite()).then(|| [x / length, y / length])
        };
        Some((at, [unit([down[1], -right[1]])?, unit([-down[0], right[0]])?]))
    }

    /// The ribbons of a root that was found at a place in pixels.
    fn grow(&self, root: &Root, at: [f64; 2], axes: [[f64; 2]; 2], depth: f64, size: f64, found: &mut Vec<Grown>) {
        let scale = if self.eye.orthographic { self.eye.scale } else { self.eye.scale / depth };
        let half_width = (root.size[1] * scale * size).min(0.25 * self.reach);
        let length = (root.size[0] * scale * size).min(self.reach - half_width * (1.0 + root.shape.bulge) - 1.0);
        if !(length > 0.0 && half_width > 0.0) {
            return;
        }
        let [u, v] = axes;
        let (sin, cos) = libm::sincos(root.direction);
        let way = [0, 1].map(|axis| cos * u[axis] + sin * v[axis]);
        let direction = libm::atan2(way[1], way[0]);
        let hand = if u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let shape = Shape { curl: root.shape.curl * hand, ..root.shape };
        let side = if shape.curl < 0.0 { -1.0 } else { 1.0 };
        let random = |which: u64| draw(root.key, which);
        let ribbon = Ribbon::new(&shape, at, direction, length, half_width);
        let row = root.row;
        for thumb in 0..root.thumbs {
            let (start, along) = ribbon.spine([0.4, 0.16][thumb]);
            let which = 10 * (thumb as u64 + 1);
            let direction = along + side * (52.0 + 16.0 * random(which)).to_radians();
            let curl = side * (95.0 + 45.0 * random(which + 1)).to_radians();
            let shape = Shape { curl, late: 2.2, taper: root.shape.taper, bulge: 0.0 };
            let length = length * (0.46 + 0.16 * random(which + 2)) * 0.9;
            let small = Ribbon::new(&shape, start, direction, length, 0.55 * half_width);
            found.push(Grown {
                ribbon: small,
                depth,
                order: (root.order, thumb),
                side,
                random: random(which + 3),
                row,
            });
        }
        found.push(Grown { ribbon, depth, order: (root.order, 2), side, random: random(4), row });
    }

    /// All ribbons whose roots lie between pixels of a window, as far as the picture goes, the uppermost first.
    fn ribbons(
        &self,
        near: Window,
        seen: impl Fn(i64, i64) -> Seen,
        size: impl Fn(i64, i64) -> f64,
        go_on: impl Fn() -> Result<(), NodeError>,
    ) -> Result<Vec<Grown>, NodeError> {
        let mut found = Vec::new();
        let last = (self.picture.x1 - 1, self.picture.y1 - 1);
        for y in near.y0.max(self.picture.y0)..near.y1.min(last.1) {
            go_on()?;
            for x in near.x0.max(self.picture.x0)..near.x1.min(last.0) {
                let corners = [seen(x, y), seen(x + 1, y), seen(x, y + 1), seen(x + 1, y + 1)];
                let surface = corners[0].surface;
                if surface < 0.0 || self.surface.is_some_and(|only| only != surface) {
                    continue;
                }
                let [low, high] = [0, 1].map(|end| {
                    let more = |a: f64, b: f64| if end == 0 { a.min(b) } else { a.max(b) };
                    [0, 1].map(|axis: usize| corners.iter().map(|c| c.uv[axis]).reduce(more).unwrap_or(0.0))
                });
                let first = self.roots.partition_point(|root| root.uv[0] < low[0]);
                for root in self.roots[first..].iter().take_while(|root| root.uv[0] <= high[0]) {
                    if root.uv[1] < low[1] || root.uv[1] > high[1] {
                        continue;
                    }
                    let near = corners.iter().map(|c| c.depth).fold(f64::INFINITY, f64::min);
                    let parted = |c: &Seen| c.surface != surface || c.depth > near * self.step;
                    if corners.iter().any(parted) {
                        continue;
                    }
                    if let Some((at, axes)) = self.between(corners, root.uv) {
                        let place = [x as f64 + at[0], y as f64 + at[1]];
                        self.grow(root, place, axes, corners[0].depth, size(x, y).clamp(0.0, 1.0), &mut found);
                    }
                }
            }
        }
        found.sort_by(|a, b| {
            let at = |grown: &Grown| grown.ribbon.spine(0.0).0;
            let [first, second] = [at(a), at(b)];
            b.order.cmp(&a.order).then(first[0].total_cmp(&second[0])).then(first[1].total_cmp(&second[1]))
        });
        Ok(found)
    }

    /// Values of a ribbon at a place, where it is not hidden.
    fn values(&self, grown: &Grown, place: [f64; 2], depth: f64) -> Option<[f64; OUTPUTS]> {
        if depth * self.step < grown.depth {
            return None;
        }
        let within = grown.ribbon.at(place)?;
        let row = grown.row as f64 + 1.0;
        Some([1.0, within.along, within.across, within.half_width, grown.side, grown.random, row])
    }
}

impl Prepared for Growing {
    fn fill(&self, block: &Block, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let window = block.window;
        let around = Around::of(inputs);
        let surfaces = around.surfaces();
        let depths = around.whole(ViewChannel::Depth);
        let uv = UV.map(|channel| around.whole(channel));
        let seen = |x: i64, y: i64| {
            let at = around.index(x, y);
            let uv = uv.map(|plane| f64::from(plane[at]));
            Seen { uv, surface: f64::from(surfaces[at]), depth: f64::from(depths[at]) }
        };
        let size = inputs.all("size").first().and_then(|size| Some((size.window, size.planes[0]?)));
        let size_at = |x: i64, y: i64| {
            size.map_or(1.0, |(window, plane)| {
                let column = x.clamp(window.x0, window.x1 - 1) - window.x0;
                let row = y.clamp(window.y0, window.y1 - 1) - window.y0;
                f64::from(plane[row as usize * window.width() + column as usize])
            })
        };
        let near = grown(window, self.reach.ceil() as i64 + 1);
        let ribbons = self.ribbons(near, seen, size_at, || inputs.go_on())?;
        let mut planes: [Option<&mut [f32]>; OUTPUTS] = std::array::from_fn(|output| outputs.take(output, 0));
        planes.iter_mut().flatten().for_each(|plane| plane.fill(0.0));
        let mut taken = vec![false; window.area()];
        for grown in &ribbons {
            let [[x0, x1], [y0, y1]] = grown.ribbon.bounds();
            for y in (y0.ceil() as i64).max(window.y0)..(y1.floor() as i64 + 1).min(window.y1) {
                inputs.go_on()?;
                for x in (x0.ceil() as i64).max(window.x0)..(x1.floor() as i64 + 1).min(window.x1) {
                    let index = (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
                    if taken[index] {
                        continue;
                    }
                    let Some(values) = self.values(grown, [x as f64, y as f64], seen(x, y).depth) else { continue };
                    taken[index] = true;
                    for (plane, value) in planes.iter_mut().zip(values) {
                        if let Some(plane) = plane {
                            plane[index] = value as f32;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = self.node.source("view");
        let [x, y] = inputs.at.map(|at| at.floor() as i64);
        let there = |px: i64, py: i64| inputs.moved((px - x) as f64, (py - y) as f64);
        let seen = |x: i64, y: i64| {
            let there = there(x, y);
            let channel = |channel: ViewChannel| there.view(view, channel);
            let surface = crate::scene_support::surface_of(&self.node, &there);
            Seen { uv: UV.map(channel), surface, depth: channel(ViewChannel::Depth) }
        };
        let size = |x: i64, y: i64| self.node.all("size").first().map_or(1.0, |size| there(x, y).scalar(size));
        let near = grown(Window::new(x, y, x + 1, y + 1), self.reach.ceil() as i64 + 1);
        let ribbons = self.ribbons(near, seen, size, || Ok(()))?;
        let depth = seen(x, y).depth;
        let values = ribbons.iter().find_map(|grown| self.values(grown, [x as f64, y as f64], depth));
        let values = values.unwrap_or([0.0; OUTPUTS]);
        let fields = values[1..].iter().map(|value| Reference::Field(vec![*value]));
        Ok(std::iter::once(Reference::Mask(values[0])).chain(fields).collect())
    }
}
