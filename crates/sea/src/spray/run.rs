//! The drops at given times; births are kept, since the next time needs most of them again.

use super::birth::{Birth, Droplet};
use super::breeder::Breeder;
use super::{MAX_DROPS, Spray, SprayError};
use crate::Sea;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Births by step.
pub(super) type Steps = BTreeMap<i64, Arc<[Birth]>>;

/// A spray over a sea, evaluated at times in any order.
///
/// The births of the last evaluation are kept, so that the next one only costs the steps between them; those of the
/// last exact evaluation, too. This changes no bit.
#[derive(Debug)]
pub struct SprayRun {
    spray: Spray,
    sea: Sea,
    level: Option<f64>,
    kept: Mutex<Steps>,
    pub(super) exact: Mutex<Steps>,
}

/// Locks births. They are consistent even if a panic interrupted someone who held them.
pub(super) fn locked(steps: &Mutex<Steps>) -> MutexGuard<'_, Steps> {
    steps.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SprayRun {
    /// Makes the spray of a sea that rests at world y = `level`.
    ///
    /// # Errors
    /// Same as [`Spray::check`].
    pub fn new(spray: Spray, sea: Sea, level: f64) -> Result<Self, SprayError> {
        spray.check()?;
        Ok(Self { spray, sea, level: Some(level), kept: Mutex::default(), exact: Mutex::default() })
    }

    /// Makes only the bursts of a spray, without a sea into which drops could sink.
    ///
    /// # Errors
    /// Same as [`Spray::check`].
    pub fn bursts(spray: Spray) -> Result<Self, SprayError> {
        spray.check()?;
        Ok(Self { spray, sea: Sea::default(), level: None, kept: Mutex::default(), exact: Mutex::default() })
    }

    /// Returns the description.
    pub fn spray(&self) -> &Spray {
        &self.spray
    }

    /// Returns the sea.
    pub fn sea(&self) -> &Sea {
        &self.sea
    }

    /// Returns the level at which drops sink, if there is a sea.
    pub fn level(&self) -> Option<f64> {
        self.level
    }

    /// Returns the drops that are alive at a time in seconds, always in the same order.
    ///
    /// # Errors
    /// There are more than [`MAX_DROPS`].
    pub fn at(&self, time: f64) -> Result<Vec<Droplet>, SprayError> {
        self.at_unless(time, &|| false)
    }

    /// Does the same, but asks within every step whether to stop.
    ///
    /// # Errors
    /// There are more than [`MAX_DROPS`], or [`SprayError::Stopped`].
    pub fn at_unless(&self, time: f64, stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Droplet>, SprayError> {
        let steps = self.births(time, stop)?;
        let droplet = |birth: &Birth| self.spray.droplet(birth, self.level, time);
        let mut drops: Vec<Droplet> =
            steps.par_iter().flat_map_iter(|births| births.iter().filter_map(droplet)).collect();
        drops.extend(self.spray.thrown(time).filter_map(|birth| droplet(&birth)));
        Ok(drops)
    }

    /// Returns the births of every step that matters at a time.
    fn births(&self, time: f64, stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Arc<[Birth]>>, SprayError> {
        let Some(level) = self.level else { return Ok(Vec::new()) };
        // A sea without waves has det J = 1 everywhere.
        if self.spray.expected() == 0.0 || (self.sea.waves().is_empty() && self.spray.threshold <= 1.0) {
            return Ok(Vec::new());
        }
        let wanted = self.spray.steps(time);
        // Nothing is computed under the lock: a thread that waits for its helpers may pick up a task that needs the
        // lock.
        let kept = locked(&self.kept).clone();
        let (mut steps, mut breeder, mut total) = (BTreeMap::new(), None, 0);
        for step in wanted {
            let births: Arc<[Birth]> = match kept.get(&step) {
                Some(births) => births.clone(),
                None => {
                    let breeder = breeder.get_or_insert_with(|| Breeder::new(&self.spray, &self.sea, level));
                    breeder.step(step, stop)?.into()
                }
            };
            total += births.len();
            if total > MAX_DROPS {
                return Err(SprayError::Drops);
            }
            steps.insert(step, births);
        }
        let births = steps.values().cloned().collect();
        *locked(&self.kept) = steps;
        Ok(births)
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        let bytes = |steps: &Steps| steps.values().map(|births| births.len() * size_of::<Birth>()).sum::<usize>();
        bytes(&locked(&self.kept)) + bytes(&locked(&self.exact))
    }
}
