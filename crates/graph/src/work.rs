//! Estimates of the time that nodes take for a frame, made from their knobs before anything runs.

use crate::ItemName;

/// Estimate of the time that a node takes for one frame, and the item that makes it long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Seconds on one core, from typical times of each step on a current machine; the estimate is the same on every
    /// machine.
    pub seconds: f64,
    /// Knob, list or port to change first.
    pub item: ItemName,
    /// Remedy: what to make smaller or larger.
    pub remedy: &'static str,
}

impl Work {
    /// Time above which validation warns, in seconds on one core.
    pub const HEAVY_SECONDS: f64 = 30.0;

    /// Whether the user should be warned.
    pub fn is_heavy(&self) -> bool {
        self.seconds > Self::HEAVY_SECONDS
    }

    /// Returns what was found, for messages.
    pub fn found(&self) -> String {
        format!("about {} of work per frame on one core", duration(self.seconds))
    }

    /// Returns what was expected, for messages.
    pub fn expected() -> String {
        format!("at most {}", duration(Self::HEAVY_SECONDS))
    }
}

/// Formats a duration in a suitable unit.
fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 100.0 => (s, "seconds"),
        s if s < 6_000.0 => (s / 60.0, "minutes"),
        s if s < 172_800.0 => (s / 3600.0, "hours"),
        s => (s / 86_400.0, "days"),
    };
    format!("{value:.0} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units_for_people() {
        for (seconds, text) in
            [(30.0, "30 seconds"), (119.0, "2 minutes"), (5400.0, "90 minutes"), (36e3, "10 hours"), (1e7, "116 days")]
        {
            assert_eq!(duration(seconds), text);
        }
        let work = |seconds: f64| Work { seconds, item: ItemName::declared("size"), remedy: "make it smaller" };
        assert!(work(31.0).is_heavy() && !work(30.0).is_heavy() && work(f64::INFINITY).is_heavy());
    }
}
