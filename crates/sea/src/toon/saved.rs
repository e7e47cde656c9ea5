//! The state of a simulation as bytes, from which another one goes on.

use super::Simulation;
use super::simulation::State;

impl Simulation {
    /// Returns the step at which the simulation stands: the last one with bursts up to the time that it has
    /// [reached](Self::reach), or 0.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Returns the last step up to a time in seconds, beyond which reaching the time does not take the simulation.
    pub fn last_step(&self, time: f64) -> u64 {
        self.sea.step_at(time).0
    }

    /// Returns the number of bytes of the saved state.
    pub fn saved_bytes(&self) -> u64 {
        self.state.fields().map(|field| (field.len() * size_of::<f32>()) as u64).sum()
    }

    /// Returns the state at the step where the simulation stands: its fields as little-endian `f32`.
    pub fn save(&self) -> Vec<u8> {
        let mut saved = Vec::with_capacity(self.saved_bytes() as usize);
        self.state.fields().for_each(|field| saved.extend(field.iter().flat_map(|value| value.to_le_bytes())));
        saved
    }

    /// Goes to the state that another simulation of the same sea and with the same fields saved at a step. Returns false
    /// and changes nothing if the bytes are no such state: their number is another, or a value is not finite.
    pub fn restore(&mut self, step: u64, saved: &[u8]) -> bool {
        if saved.len() as u64 != self.saved_bytes() {
            return false;
        }
        let values = || saved.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        if !values().all(f32::is_finite) {
            return false;
        }
        let mut values = values();
        let State { a, b, rift, drift } = &mut self.state;
        for field in [a, b, rift].into_iter().chain(drift) {
            field.iter_mut().zip(&mut values).for_each(|(to, value)| *to = value);
        }
        self.step = step;
        true
    }
}
