//! Noise and formulas over fields, with their f64 references and bounds, and hashes as random numbers.
//!
//! Noise and formulas have three evaluators each: a fast one for many samples at once; a reference in f64 at one sample,
//! straight from the definition; and one over intervals, for arguments known only within bounds
//! ([`Span`](trochoid_graph::Span)).
//!
//! ```
//! use trochoid_field::{Noise, NoiseKind, NoiseParameters, Program, parse};
//!
//! let parameters = NoiseParameters { scale: 0.5, octaves: 3, lacunarity: 2.0, gain: 0.5, seed: 7 };
//! let noise = Noise::new(NoiseKind::Fbm, parameters, None);
//! let mut fast = [0.0];
//! noise.fill([[0.3, 8.1]].into_iter(), &[], &mut fast);
//! assert!((f64::from(fast[0]) - noise.reference(&[0.3, 8.1], 0.0)).abs() < 1e-6);
//!
//! let formula = parse("a.x + 2*b", [Some(2), Some(1), None, None])?;
//! assert_eq!(formula.value(&[vec![1.0, 5.0], vec![3.0], vec![], vec![]]), [7.0]);
//! assert_eq!(Program::new(&formula).width(), 1);
//! # Ok::<(), trochoid_field::Fault>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod angles;
mod exponentials;
mod formula;
mod hypotenuses;
mod noise;
pub mod random;
mod ranks;

pub use angles::sines_and_cosines;
pub use exponentials::exponentials;
pub use formula::{
    Expected, Expression, Fault, Found, MAX_DEPTH, MAX_LENGTH, MAX_WIDTH, Program, Remedy, parse, parse_named,
};
pub use hypotenuses::hypotenuses;
pub use noise::{Noise, NoiseKind, NoiseParameters, Octave};
pub use ranks::Ranks;
