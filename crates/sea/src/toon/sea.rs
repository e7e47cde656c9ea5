use rayon::prelude::*;
use trochoid_key::content_key;

use super::burst::StampParameters;
use super::error::within;
use super::splat::{DriftStep, Gains, RiftStep, Splat, Stamp, StepFields};
use super::spline::Spline;
use super::trail::decayed;
use super::{Basin, Burst, Drift, Field, LITERAL_HZ, Motion, Rift, Shape, ToonError, ToonParameter};

/// Most bursts of a sea.
pub const MAX_BURSTS: usize = 1_000_000;

/// Properties of a sea other than its grid, its motion and its bursts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Behavior {
    /// Profile of bursts.
    pub shape: Shape,
    /// Whether radii are along and across the heading, instead of along x and z.
    pub oriented: bool,
    /// Share of a burst that a literal step adds; if `None`, 1 − c₁ − c₂ for the intended profile, 1 for the literal
    /// one.
    pub injection: Option<f64>,
    /// Number of steps that the sea has run before time 0.
    pub preroll: u32,
    /// Trails of foam.
    pub rift: Rift,
    /// Coordinates of drift lines.
    pub drift: Drift,
}

content_key!(Behavior { shape, oriented, injection, preroll, rift, drift });

/// Fields that a simulation keeps in addition to the height. Fields that are not requested are not simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrailFields {
    /// Trails of foam.
    pub rift: bool,
    /// Coordinates of drift lines.
    pub drift: bool,
}

content_key!(TrailFields { rift, drift });

/// A toon sea: its complete description for all times.
#[derive(Clone, Debug, PartialEq)]
pub struct ToonSea {
    pub(crate) basin: Basin,
    pub(crate) motion: Motion,
    pub(crate) behavior: Behavior,
    pub(crate) bursts: Vec<Burst>,
    /// Arc lengths of each burst's path.
    pub(crate) lengths: Vec<Vec<f64>>,
}

content_key!(ToonSea { basin, motion, behavior, bursts, lengths });

/// Scratch buffers of a step, kept to reuse their memory.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(crate) stamps: Vec<Stamp>,
    pub(crate) splat: Splat,
}

impl Scratch {
    pub(crate) fn bytes(&self) -> usize {
        self.stamps.capacity() * size_of::<Stamp>() + self.splat.bytes()
    }
}

impl ToonSea {
    /// Makes a sea that is stable and within bounds.
    ///
    /// # Errors
    /// A number is out of range, or the motion is unstable; the latter error includes the nearest stable motion.
    pub fn new(basin: Basin, motion: Motion, behavior: Behavior, bursts: Vec<Burst>) -> Result<Self, ToonError> {
        basin.validate()?;
        motion.validate(&basin)?;
        behavior.rift.validate()?;
        behavior.drift.validate()?;
        within(ToonParameter::Injection, behavior.injection.unwrap_or(0.0), (-1e6, 1e6), "-1e6 to 1e6")?;
        within(ToonParameter::Bursts, bursts.len() as f64, (0.0, MAX_BURSTS as f64), "at most a million")?;
        for (index, burst) in bursts.iter().enumerate() {
            burst.validate().map_err(|error| error.of_burst(index))?;
        }
        Ok(Self { basin, motion, behavior, bursts, lengths: Vec::new() })
    }

    /// Returns the grid.
    pub fn basin(&self) -> &Basin {
        &self.basin
    }

    /// Returns how heights move.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Returns its properties other than its grid, its motion and its bursts.
    pub fn behavior(&self) -> &Behavior {
        &self.behavior
    }

    /// Returns the bursts.
    pub fn bursts(&self) -> &[Burst] {
        &self.bursts
    }

    pub(super) fn with_lengths(&self, wanted: TrailFields) -> Self {
        let mut sea = self.clone();
        if wanted.drift {
            sea.lengths = sea.bursts.iter().map(|burst| Spline(burst.path).lengths()).collect();
        }
        sea
    }

    /// Adds the bursts of one time to the velocities of a field, moves its heights by them, and lets the bursts leave
    /// their trails in `rift` if it has the basin's size. After [`Field::accelerate`], this completes a literal step.
    ///
    /// # Panics
    /// The field does not have the basin's size.
    pub fn inject(&self, time: f64, field: &mut Field, rift: &mut [f32], scratch: &mut Scratch) {
        assert_eq!(field.height.len(), self.basin.cells(), "the field is of the basin's size");
        let wanted = TrailFields { rift: rift.len() == self.basin.cells(), drift: false };
        let Field { height, velocity } = field;
        let fields = StepFields { force: velocity, height, rift, ..StepFields::default() };
        self.splat(time, 1.0 / LITERAL_HZ, wanted, fields, scratch);
    }

    /// Returns the share of a burst that goes into the force of a step.
    pub fn injection(&self) -> f64 {
        match (self.behavior.injection, self.motion, self.behavior.shape) {
            (Some(injection), ..) => injection,
            (None, Motion::Literal(mixing) | Motion::Resampled { mixing, .. }, Shape::Intended) => mixing.loss(),
            _ => 1.0,
        }
    }

    /// Adds the bursts of a time to forces or velocities, and to trails over the seconds that end then.
    pub(crate) fn splat(
        &self,
        time: f64,
        seconds: f64,
        wanted: TrailFields,
        fields: StepFields<'_>,
        scratch: &mut Scratch,
    ) {
        let Behavior { shape, oriented, rift: trail, drift: lines, .. } = self.behavior;
        let at = StampParameters {
            basin: &self.basin,
            shape,
            oriented,
            rift: wanted.rift.then_some(trail),
            drift: wanted.drift.then_some(lines),
        };
        let stamp = |(index, burst): (usize, &Burst)| {
            let lengths = self.lengths.get(index).map_or(&[][..], Vec::as_slice);
            burst.is_active(time).then(|| burst.stamp(time, &at, lengths))
        };
        scratch.stamps.clear();
        if self.bursts.len() < 1024 {
            scratch.stamps.extend(self.bursts.iter().enumerate().filter_map(stamp));
        } else {
            let stamps = self.bursts.par_iter().enumerate().with_min_len(512).filter_map(stamp);
            scratch.stamps.par_extend(stamps);
        }
        let steps = seconds * LITERAL_HZ;
        let (left, added) = decayed(trail.decay, steps);
        let rift = wanted.rift.then_some(RiftStep {
            combine: trail.combine,
            distance: (trail.distance / self.basin.spacing) as f32,
            gain: (trail.gain * self.basin.spacing * added) as f32,
            left: left as f32,
        });
        let (left, added) = decayed(lines.decay, steps);
        let drift = wanted.drift.then_some(DriftStep {
            gain: added as f32,
            left: left as f32,
            renewal: (lines.renewal * steps) as f32,
        });
        let gains = Gains { force: self.injection() as f32, rift, drift };
        scratch.splat.add(&scratch.stamps, shape, [self.basin.columns, self.basin.rows], gains, fields);
    }

    /// Returns the time of step k, in seconds.
    pub(crate) fn time_of(&self, step: u64) -> f64 {
        (step as f64 - f64::from(self.behavior.preroll)) / self.motion.rate()
    }

    /// Returns the last step up to a time, and the seconds since then; step 0 before the sea began.
    pub(crate) fn step_at(&self, time: f64) -> (u64, f64) {
        // A frame's time is a quotient, so a millionth of a step is rounding.
        const ROUNDING: f64 = 1e-6;
        let exact = time * self.motion.rate() + f64::from(self.behavior.preroll);
        let step = (exact + ROUNDING).floor().max(0.0);
        let part = exact - step;
        let literal = matches!(self.motion, Motion::Literal(_));
        (step as u64, if part > ROUNDING && !literal { part / self.motion.rate() } else { 0.0 })
    }

    /// Returns the first step, from step 1 on, that is not before a time.
    fn first_step(&self, time: f64) -> u64 {
        if time == f64::INFINITY {
            return u64::MAX;
        }
        let guess = (time * self.motion.rate() + f64::from(self.behavior.preroll)).ceil().max(1.0) as u64;
        // A quotient may round to either side of a step.
        if guess > 1 && self.time_of(guess - 1) >= time {
            guess - 1
        } else if self.time_of(guess) < time {
            guess.saturating_add(1)
        } else {
            guess
        }
    }

    /// Returns the number of steps with bursts up to a time in seconds; the time between them is covered by single
    /// jumps.
    pub fn steps_to(&self, time: f64) -> u64 {
        let (last, _) = self.step_at(time);
        let within = |[start, end]: [u64; 2]| end.min(last.saturating_add(1)).saturating_sub(start);
        self.forced().into_iter().map(within).sum()
    }

    /// Returns the spans of steps at which some burst is active, in order and disjoint.
    pub(crate) fn forced(&self) -> Vec<[u64; 2]> {
        let mut spans: Vec<[u64; 2]> =
            self.bursts.iter().map(|burst| burst.active.map(|time| self.first_step(time))).collect();
        spans.retain(|[start, end]| start < end);
        spans.sort_unstable();
        let mut merged: Vec<[u64; 2]> = Vec::new();
        for span in spans {
            match merged.last_mut() {
                Some(last) if span[0] <= last[1] => last[1] = last[1].max(span[1]),
                _ => merged.push(span),
            }
        }
        merged
    }
}
