//! Spray: drops that breaking crests and directed bursts throw into the air.
//!
//! A [`Spray`] is the description. The world is divided into fixed cells and time into fixed steps; random numbers
//! belong to a cell and a step. A drop is born where the sea's det J is below a threshold, is moved by the water, a
//! throw and the wind, and its position is given by closed formulas. The drops of a moment are therefore a function
//! of the description, the sea and the moment alone, whatever was evaluated before and whatever the size of the
//! picture:
//!
//! ```
//! use trochoid_sea::spray::{Spray, SprayRun};
//! use trochoid_sea::{GerstnerSpectrum, Sea};
//!
//! let spectrum = GerstnerSpectrum { count: 50, height: 3.0, sharpness: 0.9, ..GerstnerSpectrum::default() };
//! let spray = Spray { density: 20.0, threshold: 0.6, ..Spray::default() };
//! let run = SprayRun::new(spray, Sea::new(spectrum.waves()?), 0.0)?;
//! let drops = run.at(2.5)?;
//! assert!(drops.iter().all(|drop| (0.0..1.0).contains(&drop.age)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The model
//! With s = clamp((threshold − det J)/width, 0, 1) at a cell's middle, `density`·s·m drops are born per square meter
//! and second, where m is the share that smooth noise leaves to the tuft. A drop of radius r then flies by
//! v' = −g·ŷ + (drag·radius/r)(wind·gust − v), so that small drops are carried to leeward and large ones fall.
//!
//! # Results
//! Whether a drop is born does not depend on how the sea is evaluated: if f32 leaves a doubt, the f64 sum decides.
//! The drop's position and velocity are those of the sea in f32. [`mod@reference`] does the same in f64 and plain
//! loops, and [`SprayRun::exact_at`] does what it does in less time.

use trochoid_key::content_key;

mod birth;
mod breeder;
mod burst;
mod draws;
mod error;
mod exact;
pub(crate) mod flight;
pub(crate) mod functions;
mod plain_sum;
pub mod reference;
mod run;

pub use birth::{Birth, Droplet};
pub use burst::Burst;
pub use error::{SprayError, SprayParameter};
pub use run::SprayRun;

/// Most cells of a spray.
pub const MAX_CELLS: usize = 1 << 20;
/// Most steps of births that a lifetime may span.
pub const MAX_STEPS: usize = 4096;
/// Most cells times steps.
pub const MAX_WORK: usize = 1 << 28;
/// Most drops that a cell may produce in a step.
pub const MAX_CROWD: usize = 256;
/// Most drops at a time.
pub const MAX_DROPS: usize = 500_000;

/// Where and how drops are born and fly.
///
/// In meters, seconds and radians. The corners of the cells are multiples of `cell` for every region.
#[derive(Clone, Debug, PartialEq)]
pub struct Spray {
    /// Middle of the region in which crests throw drops, x and z of the resting sea.
    pub center: [f64; 2],
    /// Size of the region along x and z.
    pub size: [f64; 2],
    /// Side of a cell, and the footprint under which the sea is evaluated: shorter crests throw nothing.
    pub cell: f64,
    /// Steps of births per second.
    pub rate: f64,
    /// Value of det J below which drops are born.
    pub threshold: f64,
    /// Amount by which det J must fall below the threshold for the full density.
    pub width: f64,
    /// Drops born per square meter and second where crests break fully.
    pub density: f64,
    /// Share of the water's velocity that drops inherit.
    pub follow: f64,
    /// Largest speed at which they are thrown, in addition to that.
    pub speed: f64,
    /// Largest angle from straight up at which they are thrown.
    pub cone: f64,
    /// Velocity of the wind.
    pub wind: [f64; 3],
    /// Rate at which a drop of the full radius adopts the wind's velocity, in 1/s.
    pub drag: f64,
    /// Longest lifetime of a drop.
    pub lifetime: f64,
    /// Radius of the largest drops at birth.
    pub radius: f64,
    /// Factor by which the radius grows over a lifetime.
    pub growth: f64,
    /// Variation of radii, lifetimes and speeds, 0 to 1.
    pub vary: f64,
    /// Size of the tufts in which drops gather along a crest.
    pub tuft: f64,
    /// Variation between tufts, 0 to 1: 1 leaves gaps between them.
    pub torn: f64,
    /// Random seed.
    pub seed: i64,
    /// Bursts, in addition to the drops that crests throw.
    pub bursts: Vec<Burst>,
}

content_key!(Spray {
    center,
    size,
    cell,
    rate,
    threshold,
    width,
    density,
    follow,
    speed,
    cone,
    wind,
    drag,
    lifetime,
    radius,
    growth,
    vary,
    tuft,
    torn,
    seed,
    bursts,
});

impl Default for Spray {
    fn default() -> Self {
        Self {
            center: [0.0; 2],
            size: [60.0; 2],
            cell: 0.5,
            rate: 20.0,
            threshold: 0.4,
            width: 0.2,
            density: 40.0,
            follow: 0.8,
            speed: 3.0,
            cone: 0.6,
            wind: [4.0, 0.0, 0.0],
            drag: 0.6,
            lifetime: 1.5,
            radius: 0.25,
            growth: 1.0,
            vary: 1.0,
            tuft: 3.0,
            torn: 0.8,
            seed: 0,
            bursts: Vec::new(),
        }
    }
}

/// Cells of a region: indices of the first one, and their numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    pub(crate) first: [i64; 2],
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Spray {
    /// Returns the cells that the region touches, as numbers that may be too large.
    fn span(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|axis| {
            let (middle, half) = (self.center[axis], self.size[axis] / 2.0);
            let first = ((middle - half) / self.cell).floor();
            [first, ((middle + half) / self.cell).ceil() - first]
        })
    }

    pub(crate) fn cells(&self) -> Cells {
        let [[x, columns], [z, rows]] = self.span();
        Cells { first: [x as i64, z as i64], columns: columns as usize, rows: rows as usize }
    }

    /// Returns the expected number of drops of a cell in a step where crests break fully.
    pub(crate) fn expected(&self) -> f64 {
        self.density * self.cell * self.cell / self.rate
    }

    /// Returns the most drops that may be alive at a time: at most [`MAX_DROPS`].
    pub fn most_drops(&self) -> f64 {
        let Cells { columns, rows, .. } = self.cells();
        let steps = self.lifetime * self.rate + 1.0;
        let bursts: f64 = self.bursts.iter().map(|burst| burst.count as f64).sum();
        (self.expected() * columns as f64 * rows as f64 * steps + bursts).min(MAX_DROPS as f64)
    }

    /// Returns the steps whose drops may be alive at a time.
    pub(crate) fn steps(&self, time: f64) -> std::ops::RangeInclusive<i64> {
        ((time - self.lifetime) * self.rate).floor() as i64..=(time * self.rate).floor() as i64
    }

    /// Checks every parameter, and the limits on their combination.
    ///
    /// # Errors
    /// A number is not finite, or is negative although it must not be, or there are too many cells, steps or drops.
    pub fn check(&self) -> Result<(), SprayError> {
        let any = self
            .center
            .iter()
            .map(|&v| (SprayParameter::Center, v))
            .chain(self.wind.iter().map(|&v| (SprayParameter::Wind, v)));
        for (parameter, value) in
            any.chain([(SprayParameter::Threshold, self.threshold), (SprayParameter::Follow, self.follow)])
        {
            if !value.is_finite() {
                return Err(SprayError::Parameter(parameter, value));
            }
        }
        let positive =
            [(SprayParameter::Cell, self.cell), (SprayParameter::Rate, self.rate), (SprayParameter::Tuft, self.tuft)];
        let parameters = [
            (SprayParameter::Size, self.size[0]),
            (SprayParameter::Size, self.size[1]),
            (SprayParameter::Width, self.width),
            (SprayParameter::Density, self.density),
            (SprayParameter::Speed, self.speed),
            (SprayParameter::Cone, self.cone),
            (SprayParameter::Drag, self.drag),
            (SprayParameter::Lifetime, self.lifetime),
            (SprayParameter::Radius, self.radius),
            (SprayParameter::Growth, self.growth),
            (SprayParameter::Vary, self.vary),
            (SprayParameter::Torn, self.torn),
        ];
        for (parameter, value) in positive.into_iter().chain(parameters) {
            if !value.is_finite() || value < 0.0 || (value == 0.0 && positive.contains(&(parameter, value))) {
                return Err(SprayError::Parameter(parameter, value));
            }
        }
        let [[_, columns], [_, rows]] = self.span();
        if columns * rows > MAX_CELLS as f64 {
            return Err(SprayError::Cells(columns, rows));
        }
        let steps = (self.lifetime * self.rate).floor() + 2.0;
        if steps > MAX_STEPS as f64 {
            return Err(SprayError::Steps(steps));
        }
        if steps * columns * rows > MAX_WORK as f64 {
            return Err(SprayError::Work(steps * columns * rows));
        }
        if self.expected().ceil() > MAX_CROWD as f64 {
            return Err(SprayError::Crowd(self.expected().ceil()));
        }
        self.bursts.iter().try_for_each(Burst::check)?;
        let thrown: usize = self.bursts.iter().map(|burst| burst.count).fold(0, usize::saturating_add);
        if thrown > MAX_DROPS { Err(SprayError::Drops) } else { Ok(()) }
    }
}
