//! Properties of a drop at birth, and its state at a later time.

use super::draws::{Draws, noise};
use super::flight::fly;
use super::{Cells, Spray};

/// Lifetime of a tuft, in seconds.
const TUFT_S: f64 = 0.6;
/// Least radius of a drop, as a share of the largest, if `vary` is 1.
const LEAST: f64 = 0.12;

/// A drop at its birth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Birth {
    /// Time of birth, in seconds.
    pub time: f64,
    /// Position, in meters.
    pub position: [f64; 3],
    /// Velocity in m/s.
    pub velocity: [f64; 3],
    /// Factor of the wind.
    pub gust: f64,
    /// Radius, in meters.
    pub radius: f64,
    /// Lifetime, in seconds.
    pub lifetime: f64,
    /// Random bits for the renderer.
    pub shape: u64,
}

/// A drop at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Droplet {
    /// Position, in meters.
    pub position: [f64; 3],
    /// Velocity in m/s.
    pub velocity: [f64; 3],
    /// Radius, in meters.
    pub radius: f64,
    /// Radius at birth as a share of that of the largest drops, 0 to 1.
    pub share: f64,
    /// Share of its lifetime that has passed, 0 to 1.
    pub age: f64,
    /// Share of it that is above the sea's level, 0 to 1.
    pub strength: f64,
    /// Random bits for the renderer.
    pub shape: u64,
}

/// A possible drop in the grid of cells and steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    cell: [i64; 2],
    step: i64,
    draws: Draws,
    tuft: f64,
    gust: f64,
}

/// State of the sea at a rest point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Water {
    /// Position in the world.
    pub(crate) position: [f64; 3],
    /// Velocity.
    pub(crate) velocity: [f64; 3],
}

impl Spray {
    /// Returns the middle of a cell.
    pub(crate) fn middle(&self, [x, z]: [i64; 2]) -> [f64; 2] {
        [(x as f64 + 0.5) * self.cell, (z as f64 + 0.5) * self.cell]
    }

    /// Returns the time at which a step begins.
    pub(crate) fn moment(&self, step: i64) -> f64 {
        step as f64 / self.rate
    }

    /// Lists every candidate of a cell and step that could be born with enough folding, with the det J below which it
    /// is born.
    pub(crate) fn candidates(&self, cell: [i64; 2], step: i64, mut found: impl FnMut(Candidate, f64)) {
        let crowd = self.expected().ceil();
        let chance = if crowd > 0.0 { self.expected() / crowd } else { return };
        let at = self.middle(cell).map(|place| place / self.tuft);
        let place = [at[0], at[1], self.moment(step) / TUFT_S];
        let mut shared: Option<(f64, f64)> = None;
        for index in 0..crowd as i64 {
            let mut draws = Draws::of([self.seed, cell[0], cell[1], step, index]);
            let unit = draws.unit();
            // The limit is exceeded even without tufts, as for most candidates, so the noise is not computed.
            if unit >= chance {
                continue;
            }
            let (tuft, gust) =
                *shared.get_or_insert_with(|| (noise(self.seed ^ 0x51, place), noise(self.seed ^ 0x6b, place)));
            let leaves = 1.0 - self.torn * (1.0 - ((tuft - 0.35) * 3.0).clamp(0.0, 1.0));
            let quantile = unit / (chance * leaves);
            if quantile < 1.0 {
                found(Candidate { cell, step, draws, tuft, gust }, self.threshold - self.width * quantile);
            }
        }
    }

    /// Returns the drop that a candidate becomes at birth.
    pub(crate) fn birth(&self, candidate: &Candidate, water: &Water) -> Birth {
        let mut draws = candidate.draws;
        // Skip the position, which was drawn earlier.
        let _ = (draws.unit(), draws.unit());
        let later = draws.unit() / self.rate;
        let thrown =
            self.speed * (1.0 + self.torn * (candidate.tuft - 0.7)).max(0.0) * (1.0 - self.vary * draws.unit());
        let up = within([0.0, 1.0, 0.0], self.cone, &mut draws);
        let velocity = std::array::from_fn(|axis| self.follow * water.velocity[axis] + thrown * up[axis]);
        let position = std::array::from_fn(|axis| water.position[axis] + water.velocity[axis] * later);
        let gust = 1.0 + self.torn * (1.2 * candidate.gust - 0.6);
        self.born(self.moment(candidate.step) + later, position, velocity, gust, &mut draws)
    }

    /// Draws the properties that all drops have, however they are thrown.
    pub(crate) fn born(
        &self,
        time: f64,
        position: [f64; 3],
        velocity: [f64; 3],
        gust: f64,
        draws: &mut Draws,
    ) -> Birth {
        let size = draws.unit();
        // Many small drops and few large ones.
        let share = 1.0 - self.vary * (1.0 - LEAST) * (1.0 - size * size * libm::sqrt(size));
        let lifetime = self.lifetime * (1.0 - self.vary * 0.6 * draws.unit());
        Birth { time, position, velocity, gust, radius: self.radius * share, lifetime, shape: draws.bits() }
    }

    /// Returns the state of a drop while it lives; it sinks at the sea's level, if there is a sea.
    pub(crate) fn droplet(&self, birth: &Birth, level: Option<f64>, time: f64) -> Option<Droplet> {
        let flown = time - birth.time;
        if !(flown >= 0.0 && flown < birth.lifetime) {
            return None;
        }
        let share = if self.radius > 0.0 { birth.radius / self.radius } else { 1.0 };
        let drag = if share > 0.0 { self.drag / share } else { self.drag };
        let wind = self.wind.map(|speed| speed * birth.gust);
        let (position, velocity) = fly(birth.position, birth.velocity, wind, drag, flown);
        let age = flown / birth.lifetime;
        let radius = birth.radius * (1.0 + self.growth * age);
        let strength = match level {
            Some(level) if radius > 0.0 => (1.0 + (position[1] - level) / radius).clamp(0.0, 1.0),
            Some(level) => f64::from(u8::from(position[1] >= level)),
            None => 1.0,
        };
        (strength > 0.0).then_some(Droplet { position, velocity, radius, share, age, strength, shape: birth.shape })
    }
}

impl Candidate {
    /// Returns the rest point within its cell.
    pub(crate) fn rest(&self, spray: &Spray) -> [f64; 2] {
        let mut draws = self.draws;
        self.cell.map(|index| (index as f64 + draws.unit()) * spray.cell)
    }
}

impl Cells {
    /// Returns the indices of all cells, row by row.
    pub(crate) fn iter(self) -> impl Iterator<Item = [i64; 2]> {
        let [x, z] = self.first;
        (0..self.rows as i64).flat_map(move |row| (0..self.columns as i64).map(move |column| [x + column, z + row]))
    }
}

/// Returns a random unit vector within an angle of an axis, which is a unit vector; uniform over the cap.
pub(crate) fn within(axis: [f64; 3], angle: f64, draws: &mut Draws) -> [f64; 3] {
    let cos = 1.0 - draws.unit() * (1.0 - libm::cos(angle.min(std::f64::consts::PI)));
    let sin = libm::sqrt((1.0 - cos * cos).max(0.0));
    let (across, along) = libm::sincos(std::f64::consts::TAU * draws.unit());
    // Two unit vectors at right angles to the axis (Duff et al., Building an Orthonormal Basis, Revisited, 2017).
    let [x, y, z] = axis;
    let sign = if z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    let (u, v) = ([1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]);
    std::array::from_fn(|i| axis[i] * cos + (u[i] * along + v[i] * across) * sin)
}
