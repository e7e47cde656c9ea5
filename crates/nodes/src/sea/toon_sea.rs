//! ToonSea: a height field that bursts raise as they travel.

use super::stability;
use super::toon::{Afloat, Burst, Guide, Place, PreparedToon, Way};
use crate::geometry::memory;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_sea::toon::{
    self as model, Basin, Behavior, Boundary, Combine, Drift, Forecast, Instability, Mixing, Motion, Physics, Rift,
    Shape, ToonError, ToonFigure,
};

/// A finite sea of bursts that travel along splines: their heights spread over a grid and die away, and foam and lines
/// trail behind.
///
/// # Formula
/// h' = c1·(2·mean of the 4 neighbors − h₋) + c2·h + bursts, 60 times a second; a burst is
/// (p·H/2)·(cos(min(π·|(u−x)/r|/p, π)) + 1), scaled by 1 − c1 − c2. x is a cubic Bézier curve at (t mod d)/d. For Rift,
/// r += k·max(d − m, 0), m the distance from a burst, and r ÷= 1 + ε at each step; for DriftLines, two coordinates in
/// the frame of the last bursts that passed.
///
/// # Edge cases
/// Without bursts the sea is flat. Every frame is reached from the sea at rest, `preroll` steps before the first frame;
/// one after the other costs only the steps between. Mode "resampled" needs 0 < c1 < 1 and equals "literal" at 60
/// frames a second; "literal" moves unevenly at 24. Unstable coefficients are refused with the nearest that are not.
/// What a keyed knob holds at a frame it holds for the whole run up to it, from the sea at rest: only `x`, `z` and
/// `level` are cheap to key.
///
/// # Source
/// Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.1 and 3.2; Jury's criterion for stability.
#[derive(Clone, Node)]
#[node(
    end = Front,
    revision = 1,
    role = Sea,
    offers(Rest, Trails, StabilityMap),
    output(surface: Kind::Surface = "The sea at the frame's time.")
)]
pub(crate) struct ToonSea {
    /// Cells along x.
    #[knob(default = 256, range = 2..=2048, scales)]
    columns: i64,
    /// Cells along z.
    #[knob(default = 256, range = 2..=2048, scales)]
    rows: i64,
    /// Distance of cells.
    #[knob(default = 0.15, range = 1e-4..=1e4, unit = "m")]
    spacing: f64,
    /// World x of the grid's first cell.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "m")]
    x: f64,
    /// World z of the grid's first cell.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "m")]
    z: f64,
    /// World y of the sea at rest.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m")]
    pub(super) level: f64,
    /// How heights move.
    mode: Mode,
    /// What lies beyond the grid.
    boundary: Beyond,
    /// Weight of the neighbors and of the step before.
    #[knob(default = 0.3, range = -1.0..=1.0)]
    c1: f64,
    /// Weight of the height itself.
    #[knob(default = 0.65, range = -2.0..=2.0)]
    c2: f64,
    /// Steps a second at which bursts act; "literal" has 60.
    #[knob(default = 60.0, range = 1.0..=1000.0, unit = "Hz")]
    rate: f64,
    /// Speed of waves, mode "physical".
    #[knob(default = 6.0, range = 0.0..=1e6, unit = "m/s")]
    speed: f64,
    /// Damping γ, mode "physical".
    #[knob(default = 16.0, range = 0.0..=1e6, unit = "1/s")]
    damping: f64,
    /// Pull back to rest ω₀, mode "physical".
    #[knob(default = 16.0, range = 0.0..=1e6, unit = "rad/s")]
    frequency: f64,
    /// Acceleration for each meter of a burst, mode "physical"; ω₀² if unset.
    #[knob(range = -1e12..=1e12, unit = "1/s²")]
    push: Option<f64>,
    /// Steps that the sea has run at the first frame.
    #[knob(default = 120, range = 0..=100_000)]
    preroll: i64,
    /// Profile as meant, or as printed: cos(min(p|u−x|/r, π) + 1).
    burst: Profile,
    /// Share of a burst that a step adds; 1 − c1 − c2 if unset, 1 of "literal" bursts.
    #[knob(range = -1e6..=1e6)]
    injection: Option<f64>,
    /// Radii along and across the heading; otherwise along x and z.
    #[knob(default = true)]
    oriented: bool,
    /// Distance d from a burst up to which it leaves foam.
    #[knob(default = 1.5, range = 1e-6..=1e6, unit = "m")]
    rift_distance: f64,
    /// What a step adds to the rift for each meter nearer than d: k.
    #[knob(default = 0.02, range = 0.0..=1e6, unit = "1/m")]
    rift_gain: f64,
    /// What a step takes from the rift: it is divided by 1 + ε.
    #[knob(default = 0.01, range = 0.0..=1e3)]
    rift_decay: f64,
    /// Whether every burst adds to the rift, or the nearest alone.
    rift: Joined,
    /// Distance of drift lines.
    #[knob(default = 0.8, range = 1e-6..=1e6, unit = "m")]
    line_distance: f64,
    /// How far lines along the path fall back to the side.
    #[knob(default = 0.35, range = -1e3..=1e3, unit = "m/m")]
    line_sweep: f64,
    /// What a step takes from the weight of drift lines.
    #[knob(default = 0.02, range = 0.0..=1e3)]
    line_decay: f64,
    /// What a burst takes in a step from lines that it overtakes.
    #[knob(default = 0.5, range = 0.0..=1e3)]
    line_renewal: f64,
    /// Bursts set one by one.
    #[list(0..=10_000)]
    bursts: Vec<Burst>,
    /// Guides: each a burst and its noisy copies side by side.
    #[list(0..=100)]
    guides: Vec<Guide>,
    /// What floats along: it presses the water down, heaps it up before its bow, and leaves a wake.
    #[list(0..=1000)]
    bodies: Vec<Afloat>,
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
enum Profile {
    Intended,
    Literal,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Joined {
    Sum,
    Nearest,
}

impl ToonSea {
    /// Its least and greatest x, z.
    pub(super) fn extent(&self) -> [[f64; 2]; 2] {
        let side = |cells: i64| (cells as f64 - 1.0) * self.spacing;
        [[self.x, self.z], [self.x + side(self.columns), self.z + side(self.rows)]]
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
                Profile::Intended => Shape::Intended,
                Profile::Literal => Shape::Literal,
            },
            oriented: self.oriented,
            injection: self.injection,
            preroll: self.preroll as u32,
            rift: Rift {
                distance: self.rift_distance,
                gain: self.rift_gain,
                decay: self.rift_decay,
                combine: match self.rift {
                    Joined::Sum => Combine::Sum,
                    Joined::Nearest => Combine::Nearest,
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

    /// The sea that the knobs describe.
    fn sea(&self) -> Result<model::ToonSea, ToonError> {
        let mut bursts: Vec<model::Burst> = self.bursts.iter().map(Burst::burst).collect();
        bursts.extend(self.guides.iter().flat_map(Guide::bursts));
        for body in &self.bodies {
            let index = bursts.len();
            bursts.extend(body.bursts().map_err(|error| error.of_burst(index))?);
        }
        model::ToonSea::new(self.basin(), self.motion(), self.behavior(), bursts)
    }

    /// The list that a burst comes from, by its place among all.
    fn list_of(&self, burst: usize) -> ItemName {
        let guided = self.bursts.len() + self.guides.iter().map(Guide::count).sum::<usize>();
        match burst {
            single if single < self.bursts.len() => Self::BURSTS,
            copy if copy < guided => Self::GUIDES,
            _ => Self::BODIES,
        }
    }

    /// The knob or list that a figure comes from.
    fn item_of(&self, figure: ToonFigure, burst: Option<usize>) -> ItemName {
        match (figure, burst) {
            (_, Some(burst)) => self.list_of(burst),
            (ToonFigure::Columns | ToonFigure::Cells, None) => Self::COLUMNS,
            (ToonFigure::Rows, None) => Self::ROWS,
            (ToonFigure::Spacing, None) => Self::SPACING,
            (ToonFigure::Rate, None) => Self::RATE,
            (ToonFigure::Speed, None) => Self::SPEED,
            (ToonFigure::Damping, None) => Self::DAMPING,
            (ToonFigure::Frequency, None) => Self::FREQUENCY,
            (ToonFigure::Push, None) => Self::PUSH,
            (ToonFigure::Injection, None) => Self::INJECTION,
            (ToonFigure::RiftDistance, None) => Self::RIFT_DISTANCE,
            (ToonFigure::RiftGain, None) => Self::RIFT_GAIN,
            (ToonFigure::RiftDecay, None) => Self::RIFT_DECAY,
            (ToonFigure::DriftPeriod | ToonFigure::DriftReach, None) => Self::LINE_DISTANCE,
            (ToonFigure::DriftLag, None) => Self::LINE_SWEEP,
            (ToonFigure::DriftDecay, None) => Self::LINE_DECAY,
            (ToonFigure::DriftRenewal, None) => Self::LINE_RENEWAL,
            // Guides alone make that many.
            (ToonFigure::Bursts, None) => Self::GUIDES,
            (ToonFigure::BodyLength | ToonFigure::BodyBeam | ToonFigure::BodyDraught, None) => Self::BODIES,
            (
                ToonFigure::ControlPoint
                | ToonFigure::Duration
                | ToonFigure::Offset
                | ToonFigure::Height
                | ToonFigure::Peak
                | ToonFigure::Influence
                | ToonFigure::Fade
                | ToonFigure::Lane
                | ToonFigure::Active,
                None,
            ) => Self::BURSTS,
        }
    }

    /// Reports why there is no such sea.
    fn report(&self, error: &ToonError, check: &mut Check<'_>) {
        let (item, remedy) = match error {
            ToonError::Range { figure, burst, .. } => (self.item_of(*figure, *burst), "change it".into()),
            ToonError::Unstable(_) | ToonError::NotResampled { .. } => (Self::C1, self.coefficients()),
        };
        check.error(item, error.found(), error.expected(), remedy);
    }

    /// What to do about coefficients that are refused: the nearest that are not, or the waves that cannot be unstable.
    fn coefficients(&self) -> String {
        let (mixing, basin) = (self.mixing(), self.basin());
        let (nearest, mut advice) = match Instability::check(mixing, &basin) {
            Err(Instability { nearest: [c1, c2], .. }) => {
                (Mixing { c1, c2 }, format!("set \"c1\" {c1}, \"c2\" {c2}, the nearest that are stable"))
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
            "{advice}; or set \"mode\" \"physical\", which is stable whatever its numbers: the same waves are about \
             \"speed\" {speed:.3}, \"damping\" {damping:.2}, \"frequency\" {frequency:.2}"
        )
    }
}

/// Warns of a level sea that nothing holds and nothing brakes.
fn check_free(sea: &model::ToonSea, check: &mut Check<'_>) {
    if !Forecast::new(sea.motion(), sea.basin()).bounded {
        let found = "damping 0 and frequency 0: a level sea goes on for ever as bursts push it";
        let remedy = "raise \"damping\" or \"frequency\"";
        check.warning(ToonSea::DAMPING, found, "something that brakes it or pulls it back", remedy);
    }
}

/// Warns of a sea that lies still.
fn check_bursts(sea: &model::ToonSea, check: &mut Check<'_>) {
    let remedy = "give \"guides\" or \"bursts\" with a \"path\" on the grid";
    if sea.bursts().is_empty() {
        let found = "no bursts, guides or bodies: the sea lies still";
        return check.warning(ToonSea::BURSTS, found, "something that raises waves", remedy);
    }
    let basin = sea.basin();
    let sides = [basin.columns, basin.rows].map(|cells| (cells - 1) as f64 * basin.spacing);
    // A profile ends within three radii.
    let misses = |burst: &model::Burst| {
        let reach = 3.0 * burst.influence[0].max(burst.influence[1]) * burst.peak.max(1.0);
        (0..2).any(|axis| {
            burst.path.iter().all(|point| point[axis] < -reach)
                || burst.path.iter().all(|point| point[axis] > sides[axis] + reach)
        })
    };
    if basin.boundary != Boundary::Periodic && sea.bursts().iter().all(misses) {
        let [x, z] = sides;
        let found = format!("every path beside the grid of {x:.2} × {z:.2} m: the sea lies still");
        let item = if sea.bursts().len() > 1 { ToonSea::GUIDES } else { ToonSea::BURSTS };
        check.warning(item, found, "a path over the grid", remedy);
    }
}

impl Node for ToonSea {
    fn check(&self, check: &mut Check<'_>) {
        match self.sea() {
            Err(error) => self.report(&error, check),
            Ok(sea) => {
                check_free(&sea, check);
                check_bursts(&sea, check);
            }
        }
    }

    fn work(&self, _format: Format, time: f64) -> Option<Work> {
        // A step, a cell of it, and a burst in it.
        const STEP: f64 = 2e-5;
        const CELL: f64 = 6e-10;
        const BURST: f64 = 2e-7;
        let sea = self.sea().ok()?;
        let step = STEP + CELL * sea.basin().cells() as f64 + BURST * sea.bursts().len() as f64;
        let remedy = "lower \"preroll\", \"columns\" or \"rows\", have fewer bursts or let them end sooner; or begin \
                      at an earlier frame: the first one takes all steps up to it, each after that only its own";
        Some(Work { seconds: sea.steps_to(time) as f64 * step, item: Self::PREROLL, remedy })
    }

    fn notes(&self) -> Vec<String> {
        let Ok(sea) = self.sea() else { return Vec::new() };
        let size = |cells: usize| (cells - 1) as f64 * sea.basin().spacing;
        let (x, z) = (size(sea.basin().columns), size(sea.basin().rows));
        vec![format!("{} bursts on {x:.2} × {z:.2} m", sea.bursts().len())]
    }

    fn dynamics(&self) -> Option<&dyn Dynamics> {
        Some(self)
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Dynamics for ToonSea {
    fn stability(&self) -> Option<Stability> {
        Some(stability::toon(&self.sea().ok()?))
    }

    fn paths(&self) -> Option<Paths> {
        Some(Paths {
            origin: [self.x, self.level, self.z],
            knob: Way::PATH,
            lists: vec![Self::GUIDES, Self::BURSTS, Self::BODIES],
        })
    }
}

impl Stage for ToonSea {
    fn timed(&self) -> bool {
        true
    }

    fn formatted(&self) -> bool {
        false
    }

    fn memory(&self, reckoning: &Reckoning<'_>) -> MemoryUse {
        // Heights and the simulation's fields, of trails as well where a view asks for them.
        const CELL: u64 = 64;
        let cells = (self.columns * self.rows).max(0) as u64;
        memory::of_grid(cells, CELL, reckoning)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = self.sea()?;
        let place = Place {
            columns: sea.basin().columns,
            spacing: sea.basin().spacing,
            origin: [self.x, self.z],
            level: self.level,
        };
        Ok(Box::new(PreparedToon::new(sea, place, prepare)?))
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::refused;

    #[test]
    fn faults_of_bursts_name_the_list_that_they_are_in() {
        let (near, far) = (r#"[{ "path": [0, 0, 1, 1, 2, 2, 3, 3] }]"#, r#"[{ "path": [1e10, 0, 1, 1, 2, 2, 3, 3] }]"#);
        for (lists, port) in [
            (format!(r#""bursts": {far}"#), "bursts"),
            (format!(r#""bursts": {near}, "guides": {far}"#), "guides"),
            (format!(r#""bursts": {near}, "guides": {near}, "bodies": {far}"#), "bodies"),
        ] {
            let nodes = format!(
                r#""c": {{ "type": "Camera" }}, "s": {{ "type": "ToonSea", {lists} }},
                "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }}, "out": {{ "type": "Depth", "view": "v" }}"#
            );
            let faults = refused("field", &nodes);
            let place = format!("port: Some(\"{port}\"), found: \"control point 10000000000");
            assert!(faults.contains(&place), "{port}: {faults}");
        }
    }
}
