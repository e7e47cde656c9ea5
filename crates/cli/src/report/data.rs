//! The contents of a report: labels, sentences, and what was left out.

use super::numbers::{count, percent, place, seconds, short, thousands};
use trochoid::accuracy::{EIGHT_BIT, ErrorAt, ErrorFigures, Ladder, Limit, Rung, Saving};
use trochoid::{CheckedGraph, Kind, Tolerance, WorkingSpace};

/// Ladder, with what is needed to describe it.
pub(super) struct Report<'a> {
    pub(super) ladder: &'a Ladder,
    pub(super) scene: String,
    pub(super) kind: Kind,
    pub(super) space: WorkingSpace,
    /// Seconds that the report was to take; `None` if there was no limit.
    pub(super) within: Option<f64>,
    /// Label of each rung, which tells its settings apart from the others.
    pub(super) labels: Vec<String>,
}

impl<'a> Report<'a> {
    pub(super) fn new(graph: &CheckedGraph, ladder: &'a Ladder, within: Option<f64>) -> Self {
        let scene = graph.name().to_owned();
        let kind = graph.outputs().iter().find(|output| output.name == ladder.output).map(|output| output.kind);
        let sets: Vec<&[String]> = ladder.rungs.iter().map(|rung| rung.set.as_slice()).collect();
        let kind = kind.unwrap_or(Kind::Color);
        Self { ladder, scene, kind, space: graph.space(), within, labels: labels(&sets) }
    }

    /// Each rung with its label.
    pub(super) fn rungs(&self) -> impl Iterator<Item = (&Rung, &str)> + Clone {
        self.ladder.rungs.iter().zip(self.labels.iter().map(String::as_str))
    }

    /// Returns the pixels whose errors are certified, and that tolerances are judged on: all of them, or some.
    pub(super) fn scope(&self) -> &'static str {
        if self.ladder.is_whole { "whole" } else { "pixels" }
    }

    /// Returns the suffix of figures that hold only at the pixels that were looked at; empty if they hold everywhere.
    pub(super) fn at_pixels(&self) -> &'static str {
        if self.ladder.is_whole { "" } else { " at the pixels looked at" }
    }

    /// Returns what errors are errors of.
    pub(super) fn unit(&self) -> &'static str {
        if self.kind == Kind::Color { "display values from 0 to 1 (sRGB)" } else { "weights from 0 to 1" }
    }

    /// Returns a sentence on why nothing is certified, if that is the case.
    pub(super) fn uncertain(&self) -> Option<String> {
        if self.ladder.rungs.iter().any(|rung| certified(rung).is_some()) {
            return None;
        }
        let output = &self.ladder.output;
        if self.ladder.rungs.iter().all(|rung| rung.certified.is_none()) {
            return Some(format!("Nothing is certified of “{output}”: there was no time for a single pixel."));
        }
        let limit = self.ladder.attempts.iter().find_map(|attempt| attempt.limit.as_ref());
        let because = match limit {
            Some(Limit::Unbounded { node, ty, why }) => format!(", because “{node}” ({ty}) has no error bound: {why}"),
            Some(Limit::Unseen) => ", because visibility is not certain anywhere".into(),
            _ => String::new(),
        };
        let pixels = self.at_pixels();
        Some(format!("Nothing is certified of “{output}”{pixels}: all of them are ambiguous{because}."))
    }

    /// Returns the omitted work, largest savings first.
    pub(super) fn savings(&self) -> Vec<&'a Saving> {
        let mut savings: Vec<&Saving> = self.ladder.savings.iter().collect();
        let size = |saving: &Saving| saving.seconds.unwrap_or(f64::NEG_INFINITY);
        savings.sort_by(|a, b| size(b).total_cmp(&size(a)));
        savings
    }

    /// Returns the most useful results in a few sentences.
    pub(super) fn summary(&self) -> Vec<String> {
        let mut all: Vec<String> = self.broken().into_iter().collect();
        all.extend(self.best());
        if self.ladder.rungs.iter().any(|rung| rung.certified.is_some()) {
            all.push(self.reached());
        }
        all.extend(self.basis());
        let unseen = self.ladder.unseen.iter().map(|unseen| {
            let nodes: Vec<String> = unseen.nodes.iter().map(|node| format!("“{node}”")).collect();
            format!("“{}” shows nothing of {}.", unseen.view, nodes.join(", "))
        });
        all.extend(unseen);
        all.extend(self.shortfall());
        all.extend(self.left_to_whole());
        all
    }

    /// Returns a sentence on bounds that do not hold.
    fn broken(&self) -> Option<String> {
        let broken = self.rungs().flat_map(|(rung, label)| rung.broken.iter().map(move |broken| (broken, label)));
        let (first, label) = broken.clone().next()?;
        Some(format!(
            "{} {} not hold. At pixel {}, {label}, the error is {:.2e} in {}, and the bound {:.2e}: this is a fault of \
             Trochoid; please report it.",
            count(broken.clone().count(), "bound"),
            if broken.count() == 1 { "does" } else { "do" },
            place(first.pixel),
            first.error,
            self.space.name(),
            first.bound,
        ))
    }

    /// Returns a sentence on the most accurate and on the coarsest method.
    fn best(&self) -> Option<String> {
        let methods: Vec<_> = self.rungs().filter(|(rung, _)| rung.is_method).collect();
        let known = methods.iter().filter_map(|(rung, label)| Some((*rung, *label, certified(rung)?)));
        let best = known.min_by(|a, b| a.2.size.display.total_cmp(&b.2.size.display));
        let Some((best, label, bound)) = best else { return self.uncertain() };
        let mut first = format!(
            "{} is certified to {}{} in {} per frame",
            in_words(label, &self.ladder.output),
            short(bound.size.display),
            self.at_pixels(),
            seconds(best.times.median()),
        );
        if let Some(measured) = best.measured.as_ref().and_then(|measured| measured.clear_max) {
            first.push_str(&format!(" (measured: {})", short(measured.size.display)));
        }
        if let Some(ambiguous) = best.ambiguous {
            let share = match ambiguous.low == ambiguous.high {
                true => percent(ambiguous.value),
                false => format!("{} to {}", percent(ambiguous.low), percent(ambiguous.high)),
            };
            first.push_str(&format!(", where no sample is ambiguous; {share} of the pixels have ambiguous samples"));
        }
        if let Some((coarse, label)) = methods.first().filter(|(coarse, _)| coarse.set != best.set) {
            let bound = match certified(coarse) {
                Some(bound) => format!("is certified only to {}", short(bound.size.display)),
                None => "is not certified anywhere".into(),
            };
            first.push_str(&format!("; {label} takes {} and {bound}", seconds(coarse.times.median())));
        }
        Some(first + ".")
    }

    /// Returns the name of the settings of a rung that meets a tolerance.
    pub(super) fn met_by(&self, rung: usize) -> &str {
        match self.labels[rung].as_str() {
            AS_IT_IS => "the document as it is",
            label => label,
        }
    }

    /// Returns a sentence on the tolerances that are met.
    fn reached(&self) -> String {
        let attempts = &self.ladder.attempts;
        let finest = attempts.iter().filter_map(|attempt| Some((attempt, attempt.rung?)));
        let finest = finest.min_by(|a, b| a.0.tolerance.total_cmp(&b.0.tolerance));
        let refused = attempts.iter().filter(|attempt| attempt.rung.is_none());
        let refused = refused.max_by(|a, b| a.tolerance.total_cmp(&b.tolerance)).map(|refused| {
            let why = match &refused.limit {
                Some(Limit::Pass { node, ty }) => format!("“{node}” ({ty}) limits it"),
                Some(Limit::Unbounded { node, ty, .. }) => format!("“{node}” ({ty}) has no error bound"),
                Some(Limit::Unseen) => "visibility is not certain anywhere".into(),
                Some(Limit::Rounding) => "f32 rounding limits it".into(),
                None => "there was no time to certify every method".into(),
            };
            format!("{} is not met, because {why}", Tolerance::Error(refused.tolerance))
        });
        let met = finest.map(|(attempt, rung)| {
            let (asked, by) = (Tolerance::Error(attempt.tolerance), self.met_by(rung));
            format!("a tolerance of {asked} is met{} by {by}", self.at_pixels())
        });
        let sentence = match (met, refused) {
            (Some(met), Some(refused)) => format!("{met}; {refused}"),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => "no tolerance was requested".into(),
        };
        capital(&sentence) + "."
    }

    /// Returns sentences on the pixels that were looked at, and on what they are worth.
    fn basis(&self) -> Vec<String> {
        let ladder = self.ladder;
        let at = ladder.looked_at;
        if at.all == 0 {
            return Vec::new();
        }
        let drawn = match at.picture == at.total {
            true => format!("All {} pixels were looked at", thousands(at.total)),
            false => format!(
                "{} of {} pixels were drawn, one in each of as many equal parts of the picture",
                thousands(at.picture),
                thousands(at.total)
            ),
        };
        let apart = match at.differing {
            0 => "; all settings give the same picture".into(),
            differing if at.apart == differing => {
                format!(", and all {} where settings differ", thousands(differing))
            }
            differing => format!(", and {} of the {} where settings differ", thousands(at.apart), thousands(differing)),
        };
        let mut all = vec![format!("{drawn}{apart}.")];
        if at.given_up > 0 {
            all.push(format!(
                "At {} of them no error is measured: there, a surface is so rough that it takes too long to find what a \
                 reference's ray meets.",
                thousands(at.given_up)
            ));
        }
        if !ladder.is_whole && at.picture < at.total {
            // Of as many pixels, none exceeds the largest of all that were looked at.
            let figures = ladder.rungs.iter().find_map(|rung| rung.certified.as_ref());
            let beyond = figures.and_then(|figures| figures.picture.above(figures.max?.size.display));
            if let Some(beyond) = beyond {
                all.push(format!(
                    "What holds at all of them fails at no more than {} of the picture's pixels, with a confidence of 95 %.",
                    percent(beyond.high)
                ));
            }
        }
        if self.within.is_some() {
            all.push(format!("--pixels {} --seed {} repeats these figures.", at.picture, ladder.seed));
        }
        all
    }

    /// Returns a sentence on what did not fit into the time.
    pub(super) fn shortfall(&self) -> Option<String> {
        let (within, short) = (self.within?, &self.ladder.shortfall);
        let mut missing: Vec<String> = Vec::new();
        if !short.settings.is_empty() {
            let sets: Vec<String> = short.settings.iter().map(|set| set.join(" ")).collect();
            missing.push(format!("rendering with {}", sets.join(" or ")));
        }
        if short.bounds > 0 {
            missing.push(format!("the bounds of {}", of(short.bounds, self.ladder.rungs.len())));
        }
        if short.references {
            missing.push("any reference, so that no error is measured".into());
        }
        if short.certify > short.bounds {
            missing.push(format!("the time of certifying {}", of(short.certify, self.ladder.rungs.len())));
        }
        if short.passes && short.bounds == 0 {
            missing.push("the error of all passes".into());
        }
        let last = missing.pop()?;
        let list = if missing.is_empty() { last } else { format!("{} and {last}", missing.join(", ")) };
        Some(format!("{} did not suffice for {list}: more --seconds do, or --pixels without a limit.", seconds(within)))
    }

    /// Returns a sentence on what `--whole` adds.
    pub(super) fn left_to_whole(&self) -> Option<String> {
        let ladder = self.ladder;
        if ladder.is_whole {
            return None;
        }
        let mut left = vec!["the bounds of all pixels with their map".to_owned()];
        let nodes = ladder.savings.iter().filter(|saving| saving.is_node).count();
        if nodes > 0 {
            left.push(format!("the time saved by leaving out {}", count(nodes, "node")));
        }
        if ladder.costly > 0 {
            left.push(format!("the time over the values of {}", count(ladder.costly, "knob")));
        }
        let last = left.pop()?;
        let list = if left.is_empty() { last } else { format!("{} and {last}", left.join(", ")) };
        Some(format!("Left to --whole: {list}."))
    }
}

/// Returns the largest bound of pixels without ambiguous samples.
pub(super) fn certified(rung: &Rung) -> Option<ErrorAt> {
    rung.certified.as_ref().and_then(|figures| figures.clear_max)
}

/// Returns the largest error of pixels without ambiguous samples.
pub(super) fn measured(rung: &Rung) -> Option<ErrorAt> {
    rung.measured.as_ref().and_then(|figures| figures.clear_max)
}

/// Returns the share of pixels that are off by more than an 8-bit display may show.
pub(super) fn beyond(figures: &Option<ErrorFigures>) -> [Option<trochoid::accuracy::Estimate>; 2] {
    let Some(figures) = figures else { return [None; 2] };
    [&figures.picture, &figures.apart].map(|sample| sample.above(EIGHT_BIT))
}

fn of(some: usize, all: usize) -> String {
    if some == all { "all settings".into() } else { format!("{some} of {all} settings") }
}

fn in_words(label: &str, output: &str) -> String {
    if label == AS_IT_IS { format!("“{output}”") } else { format!("With {label}, “{output}”") }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// Label of a document without accuracy knobs.
pub(super) const AS_IT_IS: &str = "as it is";

/// Returns short labels for lists of assignments. A label has the knobs with their values, without the names of nodes
/// and without assignments that all rungs share. A label that is not unique is replaced by the full assignments.
fn labels(sets: &[&[String]]) -> Vec<String> {
    let short: Vec<String> = sets
        .iter()
        .map(|set| {
            let mut words: Vec<(String, Vec<&str>)> = Vec::new();
            for assignment in set.iter().filter(|assignment| !sets.iter().all(|other| other.contains(assignment))) {
                let (path, value) = assignment.split_once('=').unwrap_or((assignment, ""));
                let knob = path.rsplit('.').next().unwrap_or(path);
                match words.iter_mut().find(|(known, _)| known == knob) {
                    Some((_, values)) if values.contains(&value) => {}
                    Some((_, values)) => values.push(value),
                    None => words.push((knob.to_owned(), vec![value])),
                }
            }
            let words: Vec<String> =
                words.iter().map(|(knob, values)| format!("{knob} {}", values.join("/"))).collect();
            if words.is_empty() { AS_IT_IS.to_owned() } else { words.join(", ") }
        })
        .collect();
    let told_apart = |label: &String| short.iter().filter(|other| *other == label).count() == 1;
    let full = |(label, set): (&String, &&[String])| if told_apart(label) { label.clone() } else { set.join(", ") };
    short.iter().zip(sets).map(full).collect()
}
