//! ToonSea: a height field that bursts raise as they travel.

use crate::scene_support::{Parted, REST, SurfaceHandle, TRAILS, memory, parted, stability};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::GridSurface;
use trochoid_sea::toon::{
    Basin, Behavior, Body as Afloat, Boundary, Burst, Combine, Drift, Drifted, Forecast, Guide, Instability, Mixing,
    Motion, Physics, Rift, Shape, Simulation, ToonError, ToonFrame, ToonSea as Sea, Wanted, reference,
};

pub(crate) static NODE: &dyn NodeType = &ToonSea;

struct ToonSea;

static DECLARATION: Declaration = Declaration {
    name: "ToonSea",
    end: End::Front,
    summary: "A finite sea of bursts that travel along splines: their heights spread over a grid and die away, and \
              foam and lines trail behind.",
    formula: "h' = c1·(2·mean of the 4 neighbors − h₋) + c2·h + bursts, 60 times a second; a burst is \
              (p·H/2)·(cos(min(π·|(u−x)/r|/p, π)) + 1), scaled by 1 − c1 − c2. x is a cubic Bézier curve at \
              (t mod d)/d. For Rift, r += k·max(d − m, 0), m the distance from a burst, and r ÷= 1 + ε at each step; \
              for DriftLines, two coordinates in the frame of the last bursts that passed.",
    edge_cases: "Without bursts the sea is flat. Every frame is reached from the sea at rest, `preroll` steps before \
                 the first frame; one after the other costs only the steps between. Mode \"resampled\" needs \
                 0 < c1 < 1 and equals \"literal\" at 60 frames a second; \"literal\" moves unevenly at 24. Unstable \
                 coefficients are refused with the nearest that are not. What a keyed knob holds at a frame it holds \
                 for the whole run up to it, from the sea at rest: only `x`, `z` and `level` are cheap to key.",
    source: "Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.1 and 3.2; Jury's criterion for stability.",
    items: &[
        Knob::integer("columns", 256, 2, 2048, "Cells along x.").scales().item(),
        Knob::integer("rows", 256, 2, 2048, "Cells along z.").scales().item(),
        Knob::number("spacing", 0.15, 1e-4, 1e4, "Distance of cells.").unit("m").item(),
        Knob::number("x", 0.0, -1e6, 1e6, "World x of the grid's first cell.").unit("m").item(),
        Knob::number("z", 0.0, -1e6, 1e6, "World z of the grid's first cell.").unit("m").item(),
        Knob::number("level", 0.0, -1e5, 1e5, "World y of the sea at rest.").unit("m").item(),
        Knob::choice("mode", &["resampled", "literal", "physical"], "How heights move.").item(),
        Knob::choice("boundary", &["replicate", "periodic", "fixed"], "What lies beyond the grid.").item(),
        Knob::number("c1", 0.3, -1.0, 1.0, "Weight of the neighbors and of the step before.").item(),
        Knob::number("c2", 0.65, -2.0, 2.0, "Weight of the height itself.").item(),
        Knob::number("rate", 60.0, 1.0, 1000.0, "Steps a second at which bursts act; \"literal\" has 60.")
            .unit("Hz")
            .item(),
        Knob::number("speed", 6.0, 0.0, 1e6, "Speed of waves, mode \"physical\".").unit("m/s").item(),
        Knob::number("damping", 16.0, 0.0, 1e6, "Damping γ, mode \"physical\".").unit("1/s").item(),
        Knob::number("frequency", 16.0, 0.0, 1e6, "Pull back to rest ω₀, mode \"physical\".").unit("rad/s").item(),
        Knob::number(
            "push",
            0.0,
            -1e12,
            1e12,
            "Acceleration for each meter of a burst, mode \"physical\"; ω₀² if unset.",
        )
        .optional()
        .unit("1/s²")
        .item(),
        Knob::integer("preroll", 120, 0, 100_000, "Steps that the sea has run at the first frame.").item(),
        Knob::choice("burst", &["intended", "literal"], "Profile as meant, or as printed: cos(min(p|u−x|/r, π) + 1).")
            .item(),
        Knob::number(
            "injection",
            0.05,
            -1e6,
            1e6,
            "Share of a burst that a step adds; 1 − c1 − c2 if unset, 1 of \"literal\" bursts.",
        )
        .optional()
        .item(),
        Knob::bool("oriented", true, "Radii along and across the heading; otherwise along x and z.").item(),
        Knob::number("rift_distance", 1.5, 1e-6, 1e6, "Distance d from a burst up to which it leaves foam.")
            .unit("m")
            .item(),
        Knob::number("rift_gain", 0.02, 0.0, 1e6, "What a step adds to the rift for each meter nearer than d: k.")
            .unit("1/m")
            .item(),
        Knob::number("rift_decay", 0.01, 0.0, 1e3, "What a step takes from the rift: it is divided by 1 + ε.").item(),
        Knob::choice("rift", &["sum", "nearest"], "Whether every burst adds to the rift, or the nearest alone.").item(),
        Knob::number("line_distance", 0.8, 1e-6, 1e6, "Distance of drift lines.").unit("m").item(),
        Knob::number("line_sweep", 0.35, -1e3, 1e3, "How far lines along the path fall back to the side.")
            .unit("m/m")
            .item(),
        Knob::number("line_decay", 0.02, 0.0, 1e3, "What a step takes from the weight of drift lines.").item(),
        Knob::number("line_renewal", 0.5, 0.0, 1e3, "What a burst takes in a step from lines that it overtakes.")
            .item(),
        List::of("bursts", BURST, 0, 10_000, "Bursts set one by one."),
        List::of("guides", GUIDE, 0, 100, "Guides: each a burst and its noisy copies side by side."),
        List::of(
            "bodies",
            BODY,
            0,
            1000,
            "What floats along: it presses the water down, heaps it up before its bow, and \
                                           leaves a wake.",
        ),
    ],
    outputs: &[Output::new("surface", Kind::Surface, "The sea at the frame's time.")],
    revision: 1,
};

static BURST: &[Item] = &[PATH, DURATION, OFFSET, HEIGHT, PEAK, ALONG, ACROSS, FADE, START, END];

static GUIDE: &[Item] = &[
    PATH,
    DURATION,
    OFFSET,
    HEIGHT,
    PEAK,
    ALONG,
    ACROSS,
    FADE,
    START,
    END,
    Knob::integer("count", 8, 1, 100_000, "Copies.").item(),
    Knob::number("width", 10.0, 0.0, 1e6, "Width over which copies stand side by side.").unit("m").item(),
    Knob::number("jitter", 0.5, 0.0, 1e6, "Standard deviation of control points.").unit("m").item(),
    Knob::number("jitter_time", 0.25, 0.0, 1e6, "Standard deviation of offsets: small makes crests, large cones.")
        .unit("s")
        .item(),
    Knob::number("jitter_size", 0.15, 0.0, 10.0, "Relative standard deviation of duration, peak and radii.").item(),
    Knob::integer("seed", 0, 0, 1_000_000_000, "Which of all such systems.").item(),
];

static BODY: &[Item] = &[
    PATH,
    DURATION,
    OFFSET,
    FADE,
    START,
    END,
    Knob::number("length", 4.0, 1e-3, 1e5, "Length.").unit("m").item(),
    Knob::number("beam", 1.2, 1e-3, 1e5, "Width.").unit("m").item(),
    Knob::number("draught", 0.5, -1e5, 1e5, "How deep it lies in the water.").unit("m").item(),
];

const PATH: Item =
    Knob::numbers("path", 8, 8, "Control points x, z, x, z, … of a cubic Bézier curve, from the first cell on.")
        .required()
        .unit("m")
        .item();
const DURATION: Item = Knob::number("duration", 10.0, 1e-3, 1e9, "Time from end to end.").unit("s").item();
const OFFSET: Item = Knob::number("offset", 0.0, -1e9, 1e9, "Time by which it is ahead.").unit("s").item();
const HEIGHT: Item = Knob::number("height", 1.0, -1e6, 1e6, "Height H.").unit("m").item();
const PEAK: Item = Knob::number("peak", 1.0, 1e-3, 1e3, "Peak p: scales height and radius.").item();
const ALONG: Item = Knob::number("along", 2.0, 1e-3, 1e6, "Radius r along the heading, or x.").unit("m").item();
const ACROSS: Item =
    Knob::number("across", 2.0, 1e-3, 1e6, "Radius r across the heading, or along z.").unit("m").item();
const FADE: Item = Knob::number("fade", 0.0, 0.0, 0.5, "Share of the path to grow in and to die out.").item();
const START: Item =
    Knob::number("start", 0.0, -1e9, 1e9, "First moment; from the preroll on if unset.").optional().unit("s").item();
const END: Item = Knob::number("end", 0.0, -1e9, 1e9, "Last moment; never if unset.").optional().unit("s").item();

/// Where and when the burst of any list travels.
fn way(record: &Settled) -> Burst {
    let points = record.numbers("path");
    let moment = |knob: &str, otherwise: f64| if record.is_set(knob) { record.number(knob) } else { otherwise };
    Burst {
        duration: record.number("duration"),
        offset: record.number("offset"),
        fade: record.number("fade"),
        active: [moment("start", f64::NEG_INFINITY), moment("end", f64::INFINITY)],
        ..Burst::along(std::array::from_fn(|index| {
            [0, 1].map(|axis| points.get(2 * index + axis).copied().unwrap_or_default())
        }))
    }
}

/// A burst set by itself, or the one that a guide copies.
fn burst(record: &Settled) -> Burst {
    Burst {
        height: record.number("height"),
        peak: record.number("peak"),
        influence: [record.number("along"), record.number("across")],
        ..way(record)
    }
}

fn body(record: &Settled) -> Result<Vec<Burst>, ToonError> {
    let [length, beam, draught] = ["length", "beam", "draught"].map(|knob| record.number(knob));
    Afloat { way: way(record), length, beam, draught }.bursts()
}

fn basin(node: &Settled) -> Basin {
    Basin {
        columns: node.integer("columns") as usize,
        rows: node.integer("rows") as usize,
        spacing: node.number("spacing"),
        boundary: match node.text("boundary") {
            "periodic" => Boundary::Periodic,
            "fixed" => Boundary::Fixed,
            _ => Boundary::Replicate,
        },
    }
}

fn optional(node: &Settled, knob: &str) -> Option<f64> {
    node.is_set(knob).then(|| node.number(knob))
}

fn motion(node: &Settled) -> Motion {
    let mixing = Mixing { c1: node.number("c1"), c2: node.number("c2") };
    let rate = node.number("rate");
    match node.text("mode") {
        "literal" => Motion::Literal(mixing),
        "physical" => {
            let physics = Physics {
                speed: node.number("speed"),
                damping: node.number("damping"),
                frequency: node.number("frequency"),
                push: optional(node, "push"),
            };
            Motion::Physical { physics, rate }
        }
        _ => Motion::Resampled { mixing, rate },
    }
}

/// What to do about coefficients that are refused: the nearest that are not, or the waves that cannot be unstable.
fn coefficients(node: &Settled) -> Option<String> {
    let (motion, basin) = (motion(node), basin(node));
    let (Motion::Literal(mixing) | Motion::Resampled { mixing, .. }) = motion else { return None };
    let (nearest, mut advice) = match Instability::check(mixing, &basin) {
        Err(Instability { nearest: [c1, c2], .. }) => {
            (Mixing { c1, c2 }, format!("set \"c1\" {c1}, \"c2\" {c2}, the nearest that are stable"))
        }
        Ok(()) => (mixing, "keep them".into()),
    };
    let again = match motion {
        Motion::Resampled { rate, .. } => Motion::Resampled { mixing: nearest, rate },
        other => other,
    };
    if matches!(Sea::new(basin, again, Behavior::default(), Vec::new()), Err(ToonError::NotResampled { .. })) {
        advice.push_str(" with \"mode\" \"literal\"");
    }
    let Physics { speed, damping, frequency, .. } = nearest.continuum(basin.spacing);
    Some(format!(
        "{advice}; or set \"mode\" \"physical\", which is stable whatever its numbers: the same waves are about \
         \"speed\" {speed:.3}, \"damping\" {damping:.2}, \"frequency\" {frequency:.2}"
    ))
}

/// The sea that the knobs describe.
fn sea(node: &Settled) -> Result<Sea, String> {
    let behavior = Behavior {
        shape: if node.text("burst") == "literal" { Shape::Literal } else { Shape::Intended },
        oriented: node.bool("oriented"),
        injection: optional(node, "injection"),
        preroll: node.integer("preroll") as u32,
        rift: Rift {
            distance: node.number("rift_distance"),
            gain: node.number("rift_gain"),
            decay: node.number("rift_decay"),
            combine: if node.text("rift") == "nearest" { Combine::Nearest } else { Combine::Sum },
        },
        drift: Drift {
            period: node.number("line_distance"),
            lag: node.number("line_sweep"),
            decay: node.number("line_decay"),
            renewal: node.number("line_renewal"),
            ..Drift::default()
        },
    };
    let mut bursts: Vec<Burst> = node.list("bursts").iter().map(burst).collect();
    for record in node.list("guides") {
        let guide = Guide {
            burst: burst(record),
            count: record.integer("count") as usize,
            width: record.number("width"),
            jitter: record.number("jitter"),
            jitter_time: record.number("jitter_time"),
            jitter_size: record.number("jitter_size"),
            seed: record.integer("seed") as u64,
        };
        bursts.extend(guide.bursts());
    }
    for record in node.list("bodies") {
        bursts.extend(body(record).map_err(|error| error.to_string())?);
    }
    Sea::new(basin(node), motion(node), behavior, bursts).map_err(|error| error.to_string())
}

/// Warns of a level sea that nothing holds and nothing brakes.
fn check_free(sea: &Sea, check: &mut Check<'_>) {
    if !Forecast::new(sea.motion(), sea.basin()).bounded {
        let found = "damping 0 and frequency 0: a level sea goes on for ever as bursts push it";
        let remedy = "raise \"damping\" or \"frequency\"";
        check.warning("damping", found, "something that brakes it or pulls it back", remedy);
    }
}

/// Warns of a sea that lies still.
fn check_bursts(sea: &Sea, check: &mut Check<'_>) {
    let remedy = "give \"guides\" or \"bursts\" with a \"path\" on the grid";
    if sea.bursts().is_empty() {
        let found = "no bursts, guides or bodies: the sea lies still";
        return check.warning("bursts", found, "something that raises waves", remedy);
    }
    let basin = sea.basin();
    let sides = [basin.columns, basin.rows].map(|cells| (cells - 1) as f64 * basin.spacing);
    // A profile ends within three radii.
    let misses = |burst: &Burst| {
        let reach = 3.0 * burst.influence[0].max(burst.influence[1]) * burst.peak.max(1.0);
        (0..2).any(|axis| {
            burst.path.iter().all(|point| point[axis] < -reach)
                || burst.path.iter().all(|point| point[axis] > sides[axis] + reach)
        })
    };
    if basin.boundary != Boundary::Periodic && sea.bursts().iter().all(misses) {
        let [x, z] = sides;
        let found = format!("every path beside the grid of {x:.2} × {z:.2} m: the sea lies still");
        let item = ["bursts", "guides", "bodies"];
        check.warning(item[usize::from(sea.bursts().len() > 1)], found, "a path over the grid", remedy);
    }
}

impl NodeType for ToonSea {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        match sea(node) {
            Err(error) => {
                let Parted { item, found, expected, remedy } = parted(&error, DECLARATION.items);
                let advice = if item == Some("c1") { coefficients(node) } else { None };
                check.error(item.unwrap_or("c1"), found, expected, advice.unwrap_or(remedy));
            }
            Ok(sea) => {
                check_free(&sea, check);
                check_bursts(&sea, check);
            }
        }
    }

    fn work(&self, node: &Settled, _format: Format, time: f64) -> Option<Work> {
        // A step, a cell of it, and a burst in it.
        const STEP: f64 = 2e-5;
        const CELL: f64 = 6e-10;
        const BURST: f64 = 2e-7;
        let sea = sea(node).ok()?;
        let step = STEP + CELL * sea.basin().cells() as f64 + BURST * sea.bursts().len() as f64;
        let remedy = "lower \"preroll\", \"columns\" or \"rows\", have fewer bursts or let them end sooner; or begin \
                      at an earlier frame: the first one takes all steps up to it, each after that only its own";
        Some(Work { seconds: sea.steps_to(time) as f64 * step, item: "preroll", remedy })
    }

    fn notes(&self, node: &Settled) -> Vec<String> {
        let Ok(sea) = sea(node) else { return Vec::new() };
        let size = |cells: usize| (cells - 1) as f64 * sea.basin().spacing;
        let (x, z) = (size(sea.basin().columns), size(sea.basin().rows));
        vec![format!("{} bursts on {x:.2} × {z:.2} m", sea.bursts().len())]
    }

    fn stability(&self, node: &Settled) -> Option<Stability> {
        Some(stability::toon(&sea(node).ok()?))
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for ToonSea {
    fn timed(&self) -> bool {
        true
    }

    fn formatted(&self) -> bool {
        false
    }

    fn offers(&self) -> &'static [&'static str] {
        &[REST, TRAILS]
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        // Heights and the simulation's fields, of trails as well where a view asks for them.
        const CELL: u64 = 64;
        let cells = (node.integer("columns") * node.integer("rows")).max(0) as u64;
        memory::of_grid(cells, CELL, reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = sea(node).map_err(NodeError::new)?;
        // Frames of one sea share its simulations, so that each takes only the steps since the one before. Trails have
        // simulations of their own, which are not begun before a view asks for them.
        let simulation = prepare.shared(&sea, || Ok(Mutex::new(sea.simulate(Wanted::default()))))?;
        let trails = |wanted: Wanted| {
            let make = || Ok(Mutex::new(None));
            let shared = prepare.shared(&(wanted, &sea), make)?;
            Ok::<_, NodeError>(Trails { sea: sea.clone(), wanted, time: prepare.frame.time, shared })
        };
        let (rift, drift) = (trails(RIFT)?, trails(DRIFT)?);
        let place = Place {
            columns: sea.basin().columns,
            spacing: sea.basin().spacing,
            origin: [node.number("x"), node.number("z")],
            level: node.number("level"),
        };
        let time = prepare.frame.time;
        let heights = match simulation.lock() {
            Ok(mut simulation) => {
                if !simulation.reach(time, prepare.cancellation()) {
                    return Err(NodeError::cancelled());
                }
                simulation.at(time).height.to_vec()
            }
            // Whatever stopped it may have done so within a step.
            Err(_) => sea.simulate(Wanted::default()).at(time).height.to_vec(),
        };
        let simulations = Simulations { heights: simulation, trails: [rift.shared.clone(), drift.shared.clone()] };
        let surface: SurfaceHandle =
            Arc::new(place.grid(heights).with_trails(move || rift.rift(), move || drift.drift()));
        Ok(Box::new(Surging { surface, sea, time, place, simulations, reference: OnceLock::new() }))
    }
}

const RIFT: Wanted = Wanted { rift: true, drift: false };
const DRIFT: Wanted = Wanted { rift: false, drift: true };
/// Everything that a view may ask of the sea.
const ALL: Wanted = Wanted { rift: true, drift: true };

/// The trails at a time, when they are asked for.
struct Trails {
    sea: Sea,
    wanted: Wanted,
    time: f64,
    /// The simulation that all frames share, once one of them was asked.
    shared: Arc<Mutex<Option<Simulation>>>,
}

impl Trails {
    fn at<T>(self, take: impl FnOnce(&ToonFrame<'_>) -> T) -> T {
        let begin = || self.sea.simulate_trails(self.wanted);
        match self.shared.lock() {
            Ok(mut simulation) => take(&simulation.get_or_insert_with(begin).at(self.time)),
            // Whatever stopped it may have done so within a step.
            Err(_) => take(&begin().at(self.time)),
        }
    }

    fn rift(self) -> Vec<f32> {
        self.at(|frame| frame.rift.to_vec())
    }

    fn drift(self) -> [Vec<f32>; 5] {
        let scale = self.sea.behavior().drift.scale() as f32;
        self.at(|frame| {
            let Drifted { weight, along, across } = frame.drift;
            [weight, along[0], along[1], across[0], across[1]]
                .map(|values| values.iter().map(|value| value * scale).collect())
        })
    }
}

/// Where the grid lies.
struct Place {
    columns: usize,
    spacing: f64,
    origin: [f64; 2],
    level: f64,
}

impl Place {
    fn exact(&self, frame: reference::Reference, scale: f64) -> SurfaceHandle {
        let single = |values: Vec<f64>, scale: f64| values.into_iter().map(|value| (value * scale) as f32).collect();
        let rift = single(frame.rift, 1.0);
        let drift = frame.drift.map(|values| single(values, scale));
        Arc::new(self.grid(single(frame.height, 1.0)).with_trails(|| rift, || drift))
    }

    fn grid(&self, heights: Vec<f32>) -> GridSurface {
        GridSurface::new(heights, self.columns, self.spacing, self.origin, self.level)
    }
}

/// The simulations that all frames share, held for the next one.
struct Simulations {
    heights: Arc<Mutex<Simulation>>,
    /// Of the rift and of the drift, which begin when they are first asked for.
    trails: [Arc<Mutex<Option<Simulation>>>; 2],
}

impl Simulations {
    /// Of each simulation the share of one of those that hold it, and the fields that were taken from it.
    fn bytes(&self) -> usize {
        fn share<T>(held: &Arc<Mutex<T>>, bytes: impl FnOnce(&T) -> usize) -> usize {
            bytes(&held.lock().unwrap_or_else(PoisonError::into_inner)).div_ceil(Arc::strong_count(held))
        }
        let trail = |(held, fields): (_, usize)| {
            share(held, |trail: &Option<Simulation>| {
                trail
                    .as_ref()
                    .map_or(0, |trail| trail.bytes() + fields * trail.sea().basin().cells() * size_of::<f32>())
            })
        };
        share(&self.heights, Simulation::bytes) + self.trails.iter().zip([1, 5]).map(trail).sum::<usize>()
    }
}

struct Surging {
    surface: SurfaceHandle,
    sea: Sea,
    time: f64,
    place: Place,
    simulations: Simulations,
    /// The same surface from the f64 simulation, made when a reference is first asked for.
    reference: OnceLock<SurfaceHandle>,
}

impl Prepared for Surging {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.surface.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let surface = self.reference.get_or_init(|| {
            self.place.exact(reference::frame(&self.sea, self.time, ALL), self.sea.behavior().drift.scale())
        });
        Ok(vec![Reference::Handle(Arc::new(surface.clone()))])
    }

    fn bytes(&self) -> usize {
        self.sea.basin().cells() * size_of::<f32>() + self.simulations.bytes()
    }
}
