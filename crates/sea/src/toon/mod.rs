//! The toon sea: a height field after Dadfar and Welling, *Japanese-Style Toon-Based Water Shader*.
//!
//! Bursts travel along splines and raise a height field, which spreads and decays; each burst leaves a rift, a trail
//! that decays. A [`ToonSea`] is the description, a [`Simulation`] steps it through time:
//!
//! ```
//! use trochoid_sea::toon::{Basin, Behavior, Boundary, Burst, Motion, ToonSea, TrailFields};
//!
//! let basin = Basin { columns: 64, rows: 48, spacing: 0.25, boundary: Boundary::Replicate };
//! let path = [[2.0, 6.0], [6.0, 4.0], [10.0, 8.0], [14.0, 6.0]];
//! let burst = Burst { duration: 4.0, ..Burst::along(path) };
//! let sea = ToonSea::new(basin, Motion::default(), Behavior::default(), vec![burst])?;
//! let mut simulation = sea.simulate(TrailFields { rift: true, drift: false });
//! let frame = simulation.at(1.5);
//! assert_eq!(frame.height.len(), 64 * 48);
//! assert!(frame.height.iter().any(|&height| height > 0.1));
//! # Ok::<(), trochoid_sea::toon::ToonError>(())
//! ```
//!
//! # The height field
//! h' = c₁(2·Lm(h) − h₋) + c₂·h + bursts, Lm the mean of the four neighbors; [`Motion`] selects how it is stepped.
//! Every boundary has its own basis in which Lm is diagonal, so [`Motion::Resampled`] and [`Motion::Physical`]
//! advance by any amount of time in one exact step.
//!
//! # Conventions
//! Meters and seconds. Cell (i, j) is at x = i·spacing, z = j·spacing; fields are stored row by row. A literal step
//! takes 1/60 s.
//!
//! # Results
//! A frame depends only on the description and its time, however it was reached, bit for bit, on any number of
//! threads. [`mod@reference`] does the same in f64.

mod basin;
mod body;
mod burst;
mod decay;
mod error;
mod field;
mod line_masks;
mod line_span;
pub mod lines;
mod modes;
mod motion;
mod probe;
mod propagator;
pub mod reference;
mod saved;
mod sea;
mod shape;
mod simulation;
mod splat;
mod spline;
mod stability;
mod step_error;
mod system;
mod trail;
mod trial;

pub use basin::{Basin, Boundary};
pub use body::Body;
pub use burst::Burst;
pub use decay::Decay;
pub use error::{Instability, ToonError, ToonParameter};
pub use field::Field;
pub use line_masks::{LineMasks, LinePlaces};
pub use line_span::{NearPhase, NearPlace, density_span};
pub use motion::{LITERAL_HZ, Mixing, Motion, Physics};
pub use probe::Probe;
pub use sea::{Behavior, MAX_BURSTS, Scratch, ToonSea, TrailFields};
pub use shape::Shape;
pub use simulation::{DriftPhases, Simulation, ToonFrame};
pub use stability::Forecast;
pub use step_error::StepError;
pub use system::Guide;
pub use trail::{Combine, Drift, Rift, spread};
pub use trial::{LevelDrift, Transient, Trial};
