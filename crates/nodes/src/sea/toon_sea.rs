//! ToonSea: a height field raised by traveling bursts.

use super::toon::{self, Burst, FloatingBody, GridLayout, Guide, PreparedToonSea, TimedPath};
use super::{profile, stability};
use crate::geometry::memory;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_sea::toon::{
    self as model, Basin, Behavior, Boundary, Combine, Drift, Instability, Mixing, Motion, Physics, Rift, Shape,
    ToonError, ToonParameter, TrailFields,
};

/// A finite sea raised by bursts that travel along splines. Their heights spread over a grid and die away; foam and
/// lines trail behind them.
///
/// # Formula
/// h' = c1·(2·mean of the 4 neighbors − h₋) + c2·h + bursts, 60 times a second, computed by the change of the height:
/// v' = c1·(v + 2·(mean − h)) − (1 − c1 − c2)·h + bursts, h' = h + v'. A burst is
/// (p·H/2)·(cos(min(π·|(u−x)/r|/p, π)) + 1), scaled by 1 − c1 − c2; x is a cubic Bézier curve at (t mod d)/d. For
/// Rift, r += k·max(d − m, 0), with m the distance from a burst, and r ÷= 1 + ε at each step. For DriftLines, two
/// coordinates in the frame of the last bursts that passed.
///
/// # Edge cases
/// Without bursts the sea is flat. Every frame is simulated from the sea at rest, `preroll` steps before the first
/// frame; consecutive frames cost only the steps between them. Mode "resampled" needs 0 < c1 < 1 and equals "literal"
/// at 60 frames per second; "literal" moves unevenly at 24. Unstable coefficients are refused, and the nearest stable
/// ones are suggested. A "literal" burst adds cos(π + 1)·H = −0.54·H to every cell beyond its radius at each step, so
/// that the whole sea sinks toward −0.54·ΣH/(1 − c1 − c2) while bursts last. A keyed knob's value at a frame applies to the whole simulation up to that frame, so only `x`,
/// `z` and `level` are cheap to key.
///
/// # Source
/// Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.1 and 3.2; Jury's criterion for stability.
#[derive(Clone, Node)]
#[node(
    stage,
    end = Front,
    revision = 2,
    role = Sea,
    offers(Rest, Trails, StabilityMap),
    output(surface: Kind::Surface = "The sea at the frame's time.")
)]
pub(crate) struct ToonSea {
    /// Number of cells along x.
    #[knob(default = 256, range = 2..=2048, affects_cost)]
    columns: i64,
    /// Number of cells along z.
    #[knob(default = 256, range = 2..=2048, affects_cost)]
    rows: i64,
    /// Distance between cells.
    #[knob(default = 0.15, range = 1e-4..=1e4, unit = "m")]
    spacing: f64,
    /// World x of the grid's first cell.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "m", places = X)]
    x: f64,
    /// World z of the grid's first cell.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "m", places = Z)]
    z: f64,
    /// World y of the sea at rest.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m", places = Level)]
    pub(super) level: f64,
    /// Method of the simulation: "resampled" and "literal" use c1 and c2; "physical" uses speed, damping and
    /// frequency.
    mode: Mode,
    /// Behavior at the grid's edges: "replicate" repeats the edge cells, so that waves are reflected; "periodic" wraps
    /// around to the opposite edge; "fixed" keeps the water beyond at rest, so that waves are reflected upside down.
    boundary: Beyond,
    /// Weight of the neighbors and of the previous step.
    #[knob(default = 0.3, range = -1.0..=1.0)]
    c1: f64,
    /// Weight of the cell's own height.
    #[knob(default = 0.65, range = -2.0..=2.0)]
    c2: f64,
    /// Number of steps per second at which bursts act; "literal" always takes 60.
    #[knob(default = 60.0, range = 1.0..=1000.0, unit = "Hz")]
    rate: f64,
    /// Speed of waves, for mode "physical".
    #[knob(default = 6.0, range = 0.0..=1e6, unit = "m/s")]
    speed: f64,
    /// Damping γ, for mode "physical".
    #[knob(default = 16.0, range = 0.0..=1e6, unit = "1/s")]
    damping: f64,
    /// Angular frequency ω₀ of the pull back to rest, for mode "physical".
    #[knob(default = 16.0, range = 0.0..=1e6, unit = "rad/s")]
    frequency: f64,
    /// Acceleration per meter of a burst's height, for mode "physical"; if unset, ω₀².
    #[knob(range = -1e12..=1e12, unit = "1/s²")]
    push: Option<f64>,
    /// Number of steps simulated before the first frame.
    #[knob(default = 120, range = 0..=100_000)]
    preroll: i64,
    /// Profile of bursts: "intended", or "literal", as printed: cos(min(p|u−x|/r, π) + 1).
    burst: BurstProfile,
    /// Share of a burst that a step adds; if unset, 1 − c1 − c2, or 1 for "literal" bursts.
    #[knob(range = -1e6..=1e6)]
    injection: Option<f64>,
    /// Orients the radii along and across the heading; otherwise they lie along x and z.
    #[knob(default = true)]
    oriented: bool,
    /// Distance d from a burst within which it leaves foam.
    #[knob(default = 1.5, range = 1e-6..=1e6, unit = "m")]
    rift_distance: f64,
    /// Gain k: amount that a step adds to the rift for each meter closer than d.
    #[knob(default = 0.02, range = 0.0..=1e6, unit = "1/m")]
    rift_gain: f64,
    /// Decay ε: each step divides the rift by 1 + ε.
    #[knob(default = 0.01, range = 0.0..=1e3)]
    rift_decay: f64,
    /// Combination of bursts in the rift: "sum" adds all bursts, "nearest" only the nearest one.
    rift: RiftCombination,
    /// Distance between drift lines.
    #[knob(default = 0.8, range = 1e-6..=1e6, unit = "m")]
    line_distance: f64,
    /// Distance by which drift lines are swept back, per meter to the side of the path.
    #[knob(default = 0.35, range = -1e3..=1e3, unit = "m/m")]
    line_sweep: f64,
    /// Decay of drift lines: each step divides their weight by 1 + this value.
    #[knob(default = 0.02, range = 0.0..=1e3)]
    line_decay: f64,
    /// Replacement of older drift lines by a burst: at each step, its middle divides their weight by 1 + this value.
    #[knob(default = 0.5, range = 0.0..=1e3)]
    line_renewal: f64,
    /// Individual bursts.
    #[list(0..=10_000)]
    bursts: Vec<Burst>,
    /// Guides: each is a burst with randomized copies side by side.
    #[list(0..=100)]
    guides: Vec<Guide>,
    /// Floating bodies: each presses the water down, heaps it up in front of its bow, and leaves a wake.
    #[list(0..=1000)]
    bodies: Vec<FloatingBody>,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Mode {
    Resampled,
    Literal,
    Physical,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Beyond {
    Replicate,
    Periodic,
    Fixed,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum BurstProfile {
    Intended,
    Literal,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum RiftCombination {
    Sum,
    Nearest,
}

impl ToonSea {
    /// Returns the least and greatest x, z of the grid.
    pub(super) fn extent(&self) -> [[f64; 2]; 2] {
        let side = |cells: i64| (cells as f64 - 1.0) * self.spacing;
        [[self.x, self.z], [self.x + side(self.columns), self.z + side(self.rows)]]
    }

    fn layout(&self, basin: &Basin) -> GridLayout {
        GridLayout { columns: basin.columns, spacing: basin.spacing, origin: [self.x, self.z], level: self.level }
    }

    fn basin(&self) -> Basin {
        Basin {
            columns: self.columns as usize,
            rows: self.rows as usize,
            spacing: self.spacing,
            boundary: match self.boundary {
                Beyond::Replicate => Boundary::Replicate,
                Beyond::Periodic => Boundary::Periodic,
                Beyond::Fixed => Boundary::Fixed,
            },
        }
    }

    fn mixing(&self) -> Mixing {
        Mixing { c1: self.c1, c2: self.c2 }
    }

    fn motion(&self) -> Motion {
        let rate = self.rate;
        match self.mode {
            Mode::Resampled => Motion::Resampled { mixing: self.mixing(), rate },
            Mode::Literal => Motion::Literal(self.mixing()),
            Mode::Physical => {
                let Self { speed, damping, frequency, push, .. } = *self;
                Motion::Physical { physics: Physics { speed, damping, frequency, push }, rate }
            }
        }
    }

    fn behavior(&self) -> Behavior {
        Behavior {
            shape: match self.burst {
                BurstProfile::Intended => Shape::Intended,
                BurstProfile::Literal => Shape::Literal,
            },
            oriented: self.oriented,
            injection: self.injection,
            preroll: self.preroll as u32,
            rift: Rift {
                distance: self.rift_distance,
                gain: self.rift_gain,
                decay: self.rift_decay,
                combine: match self.rift {
                    RiftCombination::Sum => Combine::Sum,
                    RiftCombination::Nearest => Combine::Nearest,
                },
            },
            drift: Drift {
                period: self.line_distance,
                lag: self.line_sweep,
                decay: self.line_decay,
                renewal: self.line_renewal,
                ..Drift::default()
            },
        }
    }

    /// Returns the sea that the knobs describe.
    fn sea(&self) -> Result<model::ToonSea, ToonError> {
        let mut bursts: Vec<model::Burst> = self.bursts.iter().map(Burst::burst).collect();
        bursts.extend(self.guides.iter().flat_map(Guide::bursts));
        for body in &self.bodies {
            let index = bursts.len();
            bursts.extend(body.bursts().map_err(|error| error.of_burst(index))?);
        }
        model::ToonSea::new(self.basin(), self.motion(), self.behavior(), bursts)
    }

    /// Runs a sea over the frames of a document, as far as it gets within some seconds of work.
    fn run(sea: &model::ToonSea, times: FrameTimes, work: f64, stop: &dyn Fn() -> bool) -> Option<Reached> {
        if sea.bursts().is_empty() {
            return None;
        }
        let mut simulation = sea.simulate(TrailFields { rift: true, drift: false });
        let mut reached: Option<Reached> = None;
        for time in times.iter() {
            if sea.steps_to(time) as f64 * step_seconds(sea) > work {
                break;
            }
            if !simulation.reach(time, stop) {
                return None;
            }
            let frame = simulation.at(time);
            let so_far =
                reached.map_or(([0.0_f32; 2], 0.0), |so_far| (so_far.heights.map(|h| h as f32), so_far.rift as f32));
            let ([low, high], most) = so_far;
            let (low, high) =
                frame.height.iter().fold((low, high), |(low, high), height| (low.min(*height), high.max(*height)));
            let rift = frame.rift.iter().copied().fold(most, f32::max);
            reached = Some(Reached { until: time, heights: [low, high].map(f64::from), rift: f64::from(rift) });
        }
        reached
    }

    /// Returns the list that a burst comes from, given its index among all bursts.
    fn list_of(&self, burst: usize) -> ItemName {
        let guided = self.bursts.len() + self.guides.iter().map(Guide::count).sum::<usize>();
        match burst {
            single if single < self.bursts.len() => Self::BURSTS,
            copy if copy < guided => Self::GUIDES,
            _ => Self::BODIES,
        }
    }

    /// Returns the knob or list that a parameter comes from.
    fn item_of(&self, parameter: ToonParameter, burst: Option<usize>) -> ItemName {
        match (parameter, burst) {
            (_, Some(burst)) => self.list_of(burst),
            (ToonParameter::Columns | ToonParameter::Cells, None) => Self::COLUMNS,
            (ToonParameter::Rows, None) => Self::ROWS,
            (ToonParameter::Spacing, None) => Self::SPACING,
            (ToonParameter::Rate, None) => Self::RATE,
            (ToonParameter::Speed, None) => Self::SPEED,
            (ToonParameter::Damping, None) => Self::DAMPING,
            (ToonParameter::Frequency, None) => Self::FREQUENCY,
            (ToonParameter::Push, None) => Self::PUSH,
            (ToonParameter::Injection, None) => Self::INJECTION,
            (ToonParameter::RiftDistance, None) => Self::RIFT_DISTANCE,
            (ToonParameter::RiftGain, None) => Self::RIFT_GAIN,
            (ToonParameter::RiftDecay, None) => Self::RIFT_DECAY,
            (ToonParameter::DriftPeriod | ToonParameter::DriftReach, None) => Self::LINE_DISTANCE,
            (ToonParameter::DriftLag, None) => Self::LINE_SWEEP,
            (ToonParameter::DriftDecay, None) => Self::LINE_DECAY,
            (ToonParameter::DriftRenewal, None) => Self::LINE_RENEWAL,
            // Only guides can make that many.
            (ToonParameter::Bursts, None) => Self::GUIDES,
            (ToonParameter::BodyLength | ToonParameter::BodyBeam | ToonParameter::BodyDraught, None) => Self::BODIES,
            (
                ToonParameter::ControlPoint
                | ToonParameter::Duration
                | ToonParameter::Offset
                | ToonParameter::Height
                | ToonParameter::Peak
                | ToonParameter::Influence
                | ToonParameter::Fade
                | ToonParameter::Lane
                | ToonParameter::Active,
                None,
            ) => Self::BURSTS,
        }
    }

    /// Reports why the knobs do not describe a sea.
    fn report(&self, error: &ToonError, check: &mut Check<'_>) {
        let (item, remedy) = match error {
            ToonError::Range { parameter, burst, .. } => (self.item_of(*parameter, *burst), "change it".into()),
            ToonError::Unstable(_) | ToonError::NotResampled { .. } => (Self::C1, self.coefficients()),
        };
        check.error(item, error.found(), error.expected(), remedy);
    }

    /// Returns the remedy for refused coefficients: the nearest stable ones, or mode "physical", which cannot be
    /// unstable.
    fn coefficients(&self) -> String {
        let (mixing, basin) = (self.mixing(), self.basin());
        let (nearest, mut advice) = match Instability::check(mixing, &basin) {
            Err(Instability { nearest: [c1, c2], .. }) => {
                (Mixing { c1, c2 }, format!("set \"c1\" {c1}, \"c2\" {c2}, the nearest stable values"))
            }
            Ok(()) => (mixing, "keep them".into()),
        };
        let again = match self.motion() {
            Motion::Resampled { rate, .. } => Motion::Resampled { mixing: nearest, rate },
            other @ (Motion::Literal(_) | Motion::Physical { .. }) => other,
        };
        let resampled = model::ToonSea::new(basin, again, Behavior::default(), Vec::new());
        if matches!(resampled, Err(ToonError::NotResampled { .. })) {
            advice.push_str(" with \"mode\" \"literal\"");
        }
        let Physics { speed, damping, frequency, .. } = nearest.continuum(basin.spacing);
        format!(
            "{advice}; or set \"mode\" \"physical\", which is always stable; the same waves have about \"speed\" \
             {speed:.3}, \"damping\" {damping:.2}, \"frequency\" {frequency:.2}"
        )
    }
}

/// Returns the seconds that a step of a sea takes, roughly.
fn step_seconds(sea: &model::ToonSea) -> f64 {
    // Per step, per cell, and per burst.
    const STEP: f64 = 2e-5;
    const CELL: f64 = 6e-10;
    const BURST: f64 = 2e-7;
    STEP + CELL * sea.basin().cells() as f64 + BURST * sea.bursts().len() as f64
}

impl Node for ToonSea {
    fn check(&self, check: &mut Check<'_>) {
        match self.sea() {
            Err(error) => self.report(&error, check),
            Ok(sea) => {
                toon::check(&sea, check);
            }
        }
    }

    fn work(&self, _format: Format, time: f64) -> Option<Work> {
        let sea = self.sea().ok()?;
        let remedy = "lower \"preroll\", \"columns\" or \"rows\", or use fewer or shorter bursts; or start at an \
                      earlier frame: the first frame simulates all steps up to it, later ones only their own";
        Some(Work { seconds: sea.steps_to(time) as f64 * step_seconds(&sea), item: Self::PREROLL, remedy })
    }

    fn notes(&self, times: FrameTimes) -> Vec<String> {
        const WORK: f64 = 1.0;
        let Ok(sea) = self.sea() else { return Vec::new() };
        let size = |cells: usize| (cells - 1) as f64 * sea.basin().spacing;
        let (x, z) = (size(sea.basin().columns), size(sea.basin().rows));
        let noun = if sea.bursts().len() == 1 { "burst" } else { "bursts" };
        let mut notes = vec![format!("{} {noun} on {x:.2} × {z:.2} m", sea.bursts().len())];
        notes.extend(Self::run(&sea, times, WORK, &|| false).map(|reached| {
            let Reached { until, heights: [low, high], rift } = reached;
            let frames = if times.count <= 1 {
                "at the only frame".into()
            } else if until < times.last() {
                format!("in the first {until:.2} of {:.2} s", times.last())
            } else {
                format!("over all frames, {until:.2} s")
            };
            format!("{frames}: heights from {low:.3} to {high:.3} m, a rift of up to {rift:.3}, for thresholds")
        }));
        notes
    }

    fn dynamics(&self) -> Option<&dyn Dynamics> {
        Some(self)
    }
}

impl Dynamics for ToonSea {
    fn stability(&self) -> Option<Stability> {
        Some(stability::toon(&self.sea().ok()?))
    }

    fn step_errors(&self, steps: u64, stop: &(dyn Fn() -> bool + Sync)) -> Option<StepErrors> {
        stability::errors(&self.sea().ok()?, steps, stop)
    }

    fn profile(&self, line: &ProfileLine, time: f64) -> Option<Profile> {
        const WORK: f64 = 2.0;
        let sea = self.sea().ok()?;
        if sea.steps_to(time) as f64 * step_seconds(&sea) > WORK {
            return None;
        }
        let mut simulation = sea.simulate(TrailFields::default());
        let heights = simulation.at(time).height;
        Some(profile::of_grid(heights, &self.layout(sea.basin()), self.extent(), line))
    }

    fn reached(&self, times: FrameTimes, stop: &dyn Fn() -> bool) -> Option<Reached> {
        const WORK: f64 = 5.0;
        Self::run(&self.sea().ok()?, times, WORK, stop)
    }

    fn paths(&self) -> Option<Paths> {
        Some(Paths {
            origin: [self.x, self.level, self.z],
            knob: TimedPath::PATH,
            lists: vec![Self::GUIDES, Self::BURSTS, Self::BODIES],
        })
    }
}

impl Stage for ToonSea {
    fn depends_on_time(&self) -> bool {
        true
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        // Heights and the fields of the simulation, including trails in case a view requests them, and a state's copy
        // for a store.
        const CELL: u64 = 84;
        // Their f64 runs, and the fields of the surface taken from them.
        const EXACT: u64 = 200;
        let cells = (self.columns * self.rows).max(0) as u64;
        let exact = if context.purpose == Purpose::Pictures { 0 } else { EXACT };
        memory::of_grid(cells, CELL + exact, context)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = self.sea()?;
        let layout = self.layout(sea.basin());
        Ok(Box::new(PreparedToonSea::new(sea, layout, prepare)?))
    }
}
