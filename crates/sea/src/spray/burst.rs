//! Drops thrown at a position and time, such as where a sea hits a rock.

use super::birth::{Birth, within};
use super::draws::Draws;
use super::{Spray, SprayError, SprayParameter};
use trochoid_key::content_key;

/// Drops thrown from one position in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burst {
    /// Position, in meters.
    pub position: [f64; 3],
    /// Radius of the ball around the position in which drops are born, in meters.
    pub extent: f64,
    /// Start time, in seconds.
    pub time: f64,
    /// Duration, in seconds.
    pub duration: f64,
    /// Direction, of any length; 0 means straight up.
    pub direction: [f64; 3],
    /// Largest angle from the direction, in radians.
    pub spread: f64,
    /// Largest speed, in m/s.
    pub speed: f64,
    /// Number of drops.
    pub count: usize,
}

content_key!(Burst { position, extent, time, duration, direction, spread, speed, count });

impl Burst {
    pub(crate) fn check(&self) -> Result<(), SprayError> {
        let any = self.position.iter().chain(&self.direction).chain([&self.time]);
        let not_negative = [self.extent, self.duration, self.spread, self.speed];
        let bad = any.chain(&not_negative).find(|value| !value.is_finite());
        match bad.or_else(|| not_negative.iter().find(|value| **value < 0.0)) {
            Some(found) => Err(SprayError::Parameter(SprayParameter::Bursts, *found)),
            None => Ok(()),
        }
    }

    /// Returns the unit vector of its direction.
    fn axis(&self) -> [f64; 3] {
        // Divided by the largest component first, so that no square is too large or too small.
        let most = self.direction.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        if most == 0.0 {
            return [0.0, 1.0, 0.0];
        }
        let [x, y, z] = self.direction.map(|part| part / most);
        let length = libm::sqrt(x * x + y * y + z * z);
        [x / length, y / length, z / length]
    }
}

impl Spray {
    /// Returns the drops of all bursts that may be alive at a time, in a fixed order.
    ///
    /// A burst throws about √count jets, each with its own direction and speed: water that hits something is torn
    /// into strands, not scattered evenly.
    pub(crate) fn thrown(&self, time: f64) -> impl Iterator<Item = Birth> {
        let live = move |burst: &Burst| burst.time <= time && time - burst.time - burst.duration < self.lifetime;
        self.bursts.iter().enumerate().filter(move |(_, burst)| live(burst)).flat_map(move |(number, burst)| {
            let jets = (libm::sqrt(burst.count as f64).ceil() as i64).max(1);
            (0..burst.count as i64).map(move |index| self.drop_of(burst, number as i64, index, index % jets))
        })
    }

    fn drop_of(&self, burst: &Burst, number: i64, index: i64, jet: i64) -> Birth {
        let mut of_jet = Draws::of([self.seed, -1, number, jet]);
        let mut draws = Draws::of([self.seed, -2, number, index]);
        let toward = within(burst.axis(), burst.spread, &mut of_jet);
        let direction = within(toward, 0.25 * burst.spread, &mut draws);
        let slower = (1.0 - 0.5 * self.vary * of_jet.unit()) * (1.0 - 0.8 * self.vary * draws.unit());
        let gust = 1.0 + self.torn * (1.2 * of_jet.unit() - 0.6);
        let place = within([0.0, 1.0, 0.0], std::f64::consts::PI, &mut draws);
        let out = burst.extent * libm::cbrt(draws.unit());
        let position = std::array::from_fn(|axis| burst.position[axis] + out * place[axis]);
        let velocity = direction.map(|part| part * burst.speed * slower);
        let time = burst.time + burst.duration * draws.unit();
        self.born(time, position, velocity, gust, &mut draws)
    }
}
