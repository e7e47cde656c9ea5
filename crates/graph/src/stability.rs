//! Numerical stability of nodes over time: predictions next to measurements.

/// Result of [`Dynamics::stability`](crate::Dynamics::stability).
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// Verdict.
    pub verdict: Verdict,
    /// Explanation in sentences: what is stable, with which margin, and what would make it unstable.
    pub explanation: Vec<String>,
    /// Numbers, the most important first.
    pub figures: Vec<Figure>,
    /// Map of the plane of the node's coefficients.
    pub map: Option<StabilityMap>,
}

/// Long-term behavior of a node's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything decays.
    Stable,
    /// Nothing grows, but something never decays.
    Bounded,
    /// Something grows without bound.
    Unstable,
    /// No state: every frame is a function of its time.
    ClosedForm,
}

impl Verdict {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Bounded => "bounded",
            Self::Unstable => "unstable",
            Self::ClosedForm => "closed form",
        }
    }
}

/// A number that is predicted, measured, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name in JSON, such as `spectral_radius`.
    pub key: &'static str,
    /// Name in reports.
    pub name: &'static str,
    /// Unit; empty for dimensionless numbers.
    pub unit: &'static str,
    /// Value by theory.
    pub predicted: Option<f64>,
    /// Value measured by running the code.
    pub measured: Option<f64>,
    /// Expected relation of the two values.
    pub relation: Relation,
    /// Description of the quantity and of its measurement, in a few words.
    pub note: String,
}

/// Expected relation between the measured and the predicted value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relation {
    /// Equal up to this difference.
    Equal(f64),
    /// Equal up to this fraction of the predicted value.
    Near(f64),
    /// The measured value is at most the predicted one, which is an upper bound.
    AtMost,
    /// The measured value is at least the predicted one, up to this fraction of it.
    AtLeast(f64),
    /// One of the values is unknown, or they measure different things.
    Unrelated,
}

impl Figure {
    /// Whether the measurement confirms the prediction; `None` unless both are known and related.
    pub fn holds(&self) -> Option<bool> {
        let (predicted, measured) = (self.predicted?, self.measured?);
        let off = if predicted == measured { 0.0 } else { (predicted - measured).abs() };
        Some(match self.relation {
            Relation::Equal(most) => off <= most,
            Relation::Near(share) => off <= share * predicted.abs(),
            Relation::AtMost => measured <= predicted,
            Relation::AtLeast(share) => measured >= predicted - share * predicted.abs(),
            Relation::Unrelated => return None,
        })
    }
}

/// Growth rate of states over the plane of two knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityMap {
    /// Names of the knobs on the horizontal and vertical axis.
    pub axes: [&'static str; 2],
    /// Range of the map along each axis.
    pub ranges: [[f64; 2]; 2],
    /// Points along each axis.
    pub size: [usize; 2],
    /// Largest growth per step at the center of each cell of the map, row by row from the smallest value of the
    /// second knob.
    pub growth: Vec<f64>,
    /// Corners of the stable region, in order around it.
    pub region: Vec<[f64; 2]>,
    /// The node's own values of the knobs.
    pub point: [f64; 2],
    /// Points at which the growth was measured, for comparison with the map.
    pub measured: Vec<([f64; 2], f64)>,
    /// Description of the map.
    pub note: String,
}

/// What f32 loses of a node's state, step by step: the result of [`Dynamics::step_errors`](crate::Dynamics::step_errors).
#[derive(Clone, Debug, PartialEq)]
pub struct StepErrors {
    /// Numbers of steps from rest, in increasing order.
    pub steps: Vec<u64>,
    /// Groups of settings; each group changes one thing.
    pub groups: Vec<StepErrorGroup>,
    /// What was run, and what errors are relative to.
    pub note: String,
}

/// Settings that differ in one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct StepErrorGroup {
    /// Name of what changes.
    pub name: &'static str,
    /// The settings; those that are refused are left out.
    pub rows: Vec<StepErrorRow>,
}

/// Errors of one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct StepErrorRow {
    /// The setting.
    pub name: String,
    /// Difference from a run in f64 after each number of steps.
    pub errors: Vec<f64>,
    /// How far rounding may have carried the f64 run itself after the last step.
    pub doubt: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_hold_or_not() {
        let figure = |predicted: Option<f64>, measured: Option<f64>, relation: Relation| Figure {
            key: "a",
            name: "a",
            unit: "",
            predicted,
            measured,
            relation,
            note: String::new(),
        };
        let both = |relation: Relation| figure(Some(2.0), Some(2.1), relation).holds();
        assert_eq!(both(Relation::Equal(0.2)), Some(true));
        assert_eq!(both(Relation::Equal(0.05)), Some(false));
        assert_eq!(both(Relation::Near(0.06)), Some(true));
        assert_eq!(both(Relation::Near(0.04)), Some(false));
        assert_eq!(both(Relation::AtLeast(0.0)), Some(true));
        assert_eq!(figure(Some(2.0), Some(1.9), Relation::AtLeast(0.1)).holds(), Some(true));
        assert_eq!(figure(Some(2.0), Some(1.7), Relation::AtLeast(0.1)).holds(), Some(false));
        assert_eq!(both(Relation::AtMost), Some(false));
        assert_eq!(both(Relation::Unrelated), None);
        assert_eq!(figure(None, Some(1.0), Relation::AtMost).holds(), None);
        let infinite = |measured: f64| figure(Some(f64::INFINITY), Some(measured), Relation::Near(0.1)).holds();
        assert_eq!(infinite(f64::INFINITY), Some(true));
        assert_eq!(figure(Some(1.0), Some(f64::NAN), Relation::Equal(1.0)).holds(), Some(false));
    }
}
