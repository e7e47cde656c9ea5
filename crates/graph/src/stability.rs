//! What can be said of a node's numerics over time: what is predicted beside what is measured.

/// What a node answers to [`Dynamics::stability`](crate::Dynamics::stability).
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// The verdict.
    pub verdict: Verdict,
    /// What is stable, by how much, and what would break it, in sentences.
    pub says: Vec<String>,
    /// Numbers, the most telling first.
    pub figures: Vec<Figure>,
    /// Where its coefficients lie in their plane.
    pub map: Option<StabilityMap>,
}

/// What becomes of a node's state in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything dies away.
    Stable,
    /// Nothing grows, and something stays for ever.
    Bounded,
    /// Something grows without bound.
    Unstable,
    /// There is no state: every frame is a function of its time.
    ClosedForm,
}

impl Verdict {
    /// One word or two.
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
    /// Its name in JSON, such as `spectral_radius`.
    pub key: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its unit; none for pure numbers.
    pub unit: &'static str,
    /// By theory.
    pub predicted: Option<f64>,
    /// By running the code.
    pub measured: Option<f64>,
    /// How the two are related.
    pub relation: Relation,
    /// Of what and how it was measured, in a few words.
    pub note: String,
}

/// What holds between what is measured and what is predicted, if all is well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relation {
    /// They are equal up to this.
    Equal(f64),
    /// They are equal up to this share of what is predicted.
    Near(f64),
    /// The measured one is no greater: the prediction is a bound.
    AtMost,
    /// The measured one is no less.
    AtLeast,
    /// One of them is not known, or they are two things.
    Unrelated,
}

impl Figure {
    /// Whether the measurement bears out the prediction, where there are both.
    pub fn holds(&self) -> Option<bool> {
        let (predicted, measured) = (self.predicted?, self.measured?);
        let off = if predicted == measured { 0.0 } else { (predicted - measured).abs() };
        Some(match self.relation {
            Relation::Equal(most) => off <= most,
            Relation::Near(share) => off <= share * predicted.abs(),
            Relation::AtMost => measured <= predicted,
            Relation::AtLeast => measured >= predicted,
            Relation::Unrelated => return None,
        })
    }
}

/// How fast states grow over the plane of two knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityMap {
    /// Names of the knobs, across and up.
    pub axes: [&'static str; 2],
    /// What the map spans of each.
    pub ranges: [[f64; 2]; 2],
    /// Points along each axis.
    pub size: [usize; 2],
    /// Greatest growth in a step at the middle of each field of the map, row by row from the least of the second knob on.
    pub growth: Vec<f64>,
    /// Corners of the stable region, around it.
    pub region: Vec<[f64; 2]>,
    /// What the node has.
    pub point: [f64; 2],
    /// Points at which the growth was measured, to be held against the map.
    pub measured: Vec<([f64; 2], f64)>,
    /// Of what it is the map.
    pub note: String,
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
        assert_eq!(both(Relation::AtLeast), Some(true));
        assert_eq!(both(Relation::AtMost), Some(false));
        assert_eq!(both(Relation::Unrelated), None);
        assert_eq!(figure(None, Some(1.0), Relation::AtMost).holds(), None);
        let infinite = |measured: f64| figure(Some(f64::INFINITY), Some(measured), Relation::Near(0.1)).holds();
        assert_eq!(infinite(f64::INFINITY), Some(true));
        assert_eq!(figure(Some(1.0), Some(f64::NAN), Relation::Equal(1.0)).holds(), Some(false));
    }
}
