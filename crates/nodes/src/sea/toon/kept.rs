//! A simulation that goes on from what other processes have kept.

use std::sync::Arc;
use std::time::{Duration, Instant};
use trochoid_graph::{Key, Store};
use trochoid_sea::toon::{Simulation, ToonFrame};

/// Time after which a long simulation keeps its state, so that a process that is killed loses little.
const SLICE: Duration = Duration::from_secs(30);

/// A simulation, and what it needs to use a store.
pub(super) struct KeptRun {
    simulation: Simulation,
    store: Option<Arc<dyn Store>>,
    /// Key of its states.
    series: Key,
    /// Seconds that its state takes from the sea at rest, and that the state took which was kept last.
    seconds: f64,
    kept: f64,
}

impl KeptRun {
    /// Makes a run from a simulation of the sea at rest, whose states have this key.
    pub(super) fn new(simulation: Simulation, series: Key, store: Option<Arc<dyn Store>>) -> Self {
        Self { simulation, store, series, seconds: 0.0, kept: 0.0 }
    }

    pub(super) fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Returns the fields at a time; `None` soon after `stop` says that they are no longer needed.
    pub(super) fn at(&mut self, time: f64, stop: &(dyn Fn() -> bool + Sync)) -> Option<ToonFrame<'_>> {
        self.reach(time, stop).then(|| self.simulation.at(time))
    }

    /// Takes the steps to a time, or goes on from a later step that is kept, if that is faster.
    fn reach(&mut self, time: f64, stop: &(dyn Fn() -> bool + Sync)) -> bool {
        let Some(store) = self.store.clone() else { return self.simulation.reach(time, &|| stop()) };
        let bytes = self.simulation.saved_bytes();
        let last = self.simulation.last_step(time);
        if last < self.simulation.step() {
            // The simulation starts over.
            (self.seconds, self.kept) = (0.0, 0.0);
        }
        self.restore(store.as_ref(), last, bytes);
        loop {
            let started = Instant::now();
            let done = self.simulation.reach(time, &|| stop() || started.elapsed() > SLICE);
            self.seconds += started.elapsed().as_secs_f64();
            if stop() {
                return done;
            }
            if store.keeping_pays(bytes, self.seconds - self.kept) {
                store.keep(self.series, self.simulation.step(), self.seconds, &self.simulation.save());
                self.kept = self.seconds;
            }
            if done {
                return true;
            }
        }
    }

    /// Goes to the last step that is kept, up to `last`, if reading it takes less time than the steps.
    fn restore(&mut self, store: &dyn Store, last: u64, bytes: u64) {
        let held = self.simulation.step();
        let held = if held > last { 0 } else { held };
        let pays = |seconds: f64| store.reading_pays(bytes, seconds - self.seconds);
        let Some(entry) = store.find(self.series, held, last) else { return };
        if entry.bytes == bytes
            && pays(entry.seconds)
            && let Some(state) = store.read(self.series, &entry)
            && self.simulation.restore(entry.number, &state)
        {
            (self.seconds, self.kept) = (entry.seconds, entry.seconds);
        }
    }
}
