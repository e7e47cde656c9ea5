use super::modes::Modes;
use super::propagator::Propagator;
use super::splat::{DRIFTS, StepFields};
use super::trail::decayed;
use super::{Field, LITERAL_HZ, Mixing, Motion, Scratch, ToonSea, TrailFields};

/// Number of propagators kept, by their seconds: that of a step, and those of the parts in which frames end.
const PROPAGATORS: usize = 4;

/// Number of steps without bursts from which a jump costs less.
const WORTH_A_JUMP: u64 = 64;

/// A toon sea that is stepped through time.
///
/// It keeps the state at its last step, so that each new frame costs only the steps in between. A frame is reached
/// from there by one partial step, and an interval without bursts by one jump from its start; neither result is kept.
/// A frame therefore does not depend on the frames shown before it. Going back in time starts over.
#[derive(Clone)]
pub struct Simulation {
    pub(super) sea: ToonSea,
    wanted: TrailFields,
    /// Whether heights are kept; trails do not need them.
    heights: bool,
    /// Spans of steps with bursts.
    forced: Vec<[u64; 2]>,
    /// Step of `state`: one with bursts, or 0. For a literal sea, any step.
    pub(super) step: u64,
    pub(super) state: State,
    shown: State,
    modes: Option<Modes>,
    /// Coefficients of the recurrence, if a step is a literal one: that costs one pass over the cells, while a step
    /// in modes costs three transforms.
    recurrence: Option<Mixing>,
    propagators: Vec<(u64, Propagator)>,
    force: Vec<f32>,
    coefficients: Vec<f32>,
    height: Vec<f32>,
    scratch: Scratch,
}

/// State of a sea.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    /// h and v by cell if steps use the recurrence itself, or the two numbers of each mode.
    pub(super) a: Vec<f32>,
    pub(super) b: Vec<f32>,
    pub(super) rift: Vec<f32>,
    pub(super) drift: [Vec<f32>; DRIFTS],
}

impl State {
    pub(super) fn fields(&self) -> impl Iterator<Item = &Vec<f32>> {
        [&self.a, &self.b, &self.rift].into_iter().chain(&self.drift)
    }
}

/// Fields of a sea at one time, row by row.
#[derive(Clone, Copy, Debug)]
pub struct ToonFrame<'a> {
    /// Heights, in meters; empty if only trails are simulated.
    pub height: &'a [f32],
    /// The rift; empty if not wanted.
    pub rift: &'a [f32],
    /// Coordinates of drift lines; empty if not wanted.
    pub drift: DriftPhases<'a>,
}

/// Phases of drift lines: see [`Drift`](super::Drift). Each component is a sum with the weight.
#[derive(Clone, Copy, Debug)]
pub struct DriftPhases<'a> {
    /// Weight w: how recently and how closely bursts have passed.
    pub weight: &'a [f32],
    /// w·(cos, sin) of the angle along the paths.
    pub along: [&'a [f32]; 2],
    /// w·(cos, sin) of the angle across them.
    pub across: [&'a [f32]; 2],
}

impl ToonSea {
    /// Returns the sea at rest, ready to be stepped through time.
    pub fn simulate(&self, wanted: TrailFields) -> Simulation {
        Simulation::new(self.with_lengths(wanted), wanted, true)
    }

    /// Does the same without heights: trails depend only on bursts, and have the same bits. Trails can therefore be
    /// computed only when needed.
    pub fn simulate_trails(&self, wanted: TrailFields) -> Simulation {
        Simulation::new(self.with_lengths(wanted), wanted, false)
    }
}

impl Simulation {
    pub(crate) fn new(sea: ToonSea, wanted: TrailFields, heights: bool) -> Self {
        let modes = match sea.motion {
            Motion::Literal(_) => None,
            _ => heights.then(|| Modes::new(&sea.basin)),
        };
        let recurrence = match sea.motion {
            Motion::Literal(mixing) => Some(mixing),
            Motion::Resampled { mixing, rate } => (rate == LITERAL_HZ).then_some(mixing),
            Motion::Physical { .. } => None,
        };
        let mut simulation = Self {
            forced: sea.forced(),
            sea,
            wanted,
            heights,
            step: 0,
            state: State::default(),
            shown: State::default(),
            modes,
            recurrence,
            propagators: Vec::new(),
            force: Vec::new(),
            coefficients: Vec::new(),
            height: Vec::new(),
            scratch: Scratch::default(),
        };
        simulation.rewind();
        simulation
    }

    /// Returns the sea that is simulated.
    pub fn sea(&self) -> &ToonSea {
        &self.sea
    }

    /// Returns the number of bytes held: fields, and the data kept for their next step.
    pub fn bytes(&self) -> usize {
        let fields = [&self.force, &self.coefficients, &self.height];
        let fields: usize =
            fields.into_iter().chain(self.state.fields()).chain(self.shown.fields()).map(Vec::capacity).sum();
        let propagators: usize = self.propagators.iter().map(|(_, propagator)| propagator.bytes()).sum();
        fields * size_of::<f32>() + propagators + self.scratch.bytes()
    }

    /// Returns the fields at a time in seconds; the sea is at rest before its preroll.
    pub fn at(&mut self, time: f64) -> ToonFrame<'_> {
        self.reach(time, &|| false);
        let (step, part) = self.sea.step_at(time);
        if matches!(self.sea.motion, Motion::Literal(_)) {
            return self.frame(false);
        }
        let rate = self.sea.motion.rate();
        let gap = (step - self.step) as f64 / rate;
        if gap == 0.0 && part == 0.0 {
            if self.recurrence.is_some() {
                self.height.clone_from(&self.state.a);
            } else {
                self.coefficients.clone_from(&self.state.a);
                self.show();
            }
            return self.frame(false);
        }
        self.shown.clone_from(&self.state);
        if self.recurrence.is_some() {
            Self::to_modes(self.modes.as_ref(), &mut self.shown, &mut self.coefficients);
        }
        if gap > 0.0 {
            self.jump(gap, true);
        }
        if part > 0.0 {
            if self.sea.bursts.iter().any(|burst| burst.is_active(time)) {
                self.forced_step(time, part, true);
            } else {
                self.jump(part, true);
            }
        }
        self.coefficients.clone_from(&self.shown.a);
        self.show();
        self.frame(true)
    }

    /// Takes the steps to a time in seconds, unless told to stop between two of them: then it returns false, and
    /// continues from there at the next call.
    pub fn reach(&mut self, time: f64, stop: &dyn Fn() -> bool) -> bool {
        let (step, _) = self.sea.step_at(time);
        if step < self.step {
            self.rewind();
        }
        if !matches!(self.sea.motion, Motion::Literal(_)) {
            return self.advance(step, stop);
        }
        while self.step < step {
            if stop() {
                return false;
            }
            self.literal_step();
        }
        true
    }

    fn rewind(&mut self) {
        let cells = self.sea.basin.cells();
        let field = |wanted: bool, values: &mut Vec<f32>| {
            values.clear();
            values.resize(if wanted { cells } else { 0 }, 0.0);
        };
        self.step = 0;
        field(self.heights, &mut self.state.a);
        field(self.heights, &mut self.state.b);
        field(self.wanted.rift, &mut self.state.rift);
        self.state.drift.iter_mut().for_each(|values| field(self.wanted.drift, values));
    }

    /// Takes every step with bursts up to `step`, and jumps between their spans. Returns false if it was stopped.
    fn advance(&mut self, step: u64, stop: &dyn Fn() -> bool) -> bool {
        let rate = self.sea.motion.rate();
        while self.step < step {
            let next = self.step + 1;
            let index = self.forced.partition_point(|span| span[1] <= next);
            let Some(&[start, _]) = self.forced.get(index) else { return true };
            let forced = start.max(next);
            if forced > step {
                return true;
            }
            if stop() {
                return false;
            }
            let gap = forced - next;
            if self.recurrence.is_none() {
                if gap > 0 {
                    self.jump(gap as f64 / rate, false);
                }
                self.forced_step(self.sea.time_of(forced), 1.0 / rate, false);
                self.step = forced;
                continue;
            }
            if gap > WORTH_A_JUMP {
                Self::to_modes(self.modes.as_ref(), &mut self.state, &mut self.coefficients);
                self.jump(gap as f64 / rate, false);
                Self::to_cells(self.modes.as_ref(), &mut self.state, &mut self.coefficients);
                self.step = forced - 1;
            }
            while self.step < forced {
                if stop() {
                    return false;
                }
                self.literal_step();
            }
        }
        true
    }

    /// Transforms both fields of a state from cells to modes.
    fn to_modes(modes: Option<&Modes>, state: &mut State, coefficients: &mut Vec<f32>) {
        let Some(modes) = modes else { return };
        for field in [&mut state.a, &mut state.b] {
            modes.forward(field, coefficients);
            std::mem::swap(field, coefficients);
        }
    }

    /// Transforms both fields of a state back to cells.
    fn to_cells(modes: Option<&Modes>, state: &mut State, field: &mut Vec<f32>) {
        let Some(modes) = modes else { return };
        for coefficients in [&mut state.a, &mut state.b] {
            modes.backward(coefficients, field);
            std::mem::swap(field, coefficients);
        }
    }

    fn literal_step(&mut self) {
        let Some(mixing) = self.recurrence else { return };
        let (a, b) = (std::mem::take(&mut self.state.a), std::mem::take(&mut self.state.b));
        let mut field = Field { height: a, velocity: b };
        if self.heights {
            field.accelerate(mixing, &self.sea.basin);
        }
        self.step += 1;
        let State { rift, drift, .. } = &mut self.state;
        let Field { height, velocity } = &mut field;
        let fields = StepFields { force: velocity, height, rift, drift: drift.each_mut().map(Vec::as_mut_slice) };
        let time = self.sea.time_of(self.step);
        self.sea.splat(time, 1.0 / LITERAL_HZ, self.wanted, fields, &mut self.scratch);
        (self.state.a, self.state.b) = (field.height, field.velocity);
    }

    /// Advances the state, or the shown state, over seconds that end at a time, under its bursts.
    fn forced_step(&mut self, time: f64, seconds: f64, shown: bool) {
        self.propagator(seconds);
        let state = if shown { &mut self.shown } else { &mut self.state };
        self.force.clear();
        self.force.resize(state.a.len(), 0.0);
        let State { rift, drift, .. } = &mut *state;
        let drift = drift.each_mut().map(Vec::as_mut_slice);
        let fields = StepFields { force: &mut self.force, rift, drift, ..StepFields::default() };
        self.sea.splat(time, seconds, self.wanted, fields, &mut self.scratch);
        if let (Some(modes), Some((_, propagator))) = (&self.modes, self.propagators.first()) {
            modes.forward(&mut self.force, &mut self.coefficients);
            propagator.apply(&mut state.a, &mut state.b, Some(&self.coefficients));
        }
    }

    /// Does the same without bursts.
    fn jump(&mut self, seconds: f64, shown: bool) {
        self.propagator(seconds);
        let state = if shown { &mut self.shown } else { &mut self.state };
        if let Some((_, propagator)) = self.propagators.first() {
            propagator.apply(&mut state.a, &mut state.b, None);
        }
        let steps = seconds * LITERAL_HZ;
        let fade = |values: &mut Vec<f32>, decay: f64| {
            let left = decayed(decay, steps).0 as f32;
            values.iter_mut().for_each(|value| *value = super::splat::flushed(*value * left));
        };
        fade(&mut state.rift, self.sea.behavior.rift.decay);
        state.drift.iter_mut().for_each(|values| fade(values, self.sea.behavior.drift.decay));
    }

    /// Moves the propagator over these seconds to the front.
    fn propagator(&mut self, seconds: f64) {
        let Some(modes) = &self.modes else { return };
        let key = seconds.to_bits();
        let place = self.propagators.iter().position(|(bits, _)| *bits == key).unwrap_or_else(|| {
            self.propagators.truncate(PROPAGATORS - 1);
            self.propagators.push((key, Propagator::new(&self.sea.motion, &self.sea.basin, modes, seconds)));
            self.propagators.len() - 1
        });
        self.propagators[..=place].rotate_right(1);
    }

    /// Transforms coefficients to heights.
    fn show(&mut self) {
        if let Some(modes) = &self.modes {
            modes.backward(&mut self.coefficients, &mut self.height);
        }
    }

    fn frame(&self, shown: bool) -> ToonFrame<'_> {
        let state = if shown { &self.shown } else { &self.state };
        let [weight, along_cos, along_sin, across_cos, across_sin] = state.drift.each_ref().map(Vec::as_slice);
        ToonFrame {
            height: if self.modes.is_some() { &self.height } else { &state.a },
            rift: &state.rift,
            drift: DriftPhases { weight, along: [along_cos, along_sin], across: [across_cos, across_sin] },
        }
    }
}
