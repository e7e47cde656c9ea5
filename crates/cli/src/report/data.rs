//! The contents of a report: labels, sentences, columns, and JSON.

use super::numbers::{percent, seconds, short};
use serde_json::{Map, Value, json};
use trochoid::accuracy::{Ladder, Limit, Rung, Saving};
use trochoid::{CheckedGraph, Shading, Tolerance, VERSION, WorkingSpace};

/// Ladder, with what is needed to describe it.
pub(super) struct Report<'a> {
    pub(super) ladder: &'a Ladder,
    pub(super) scene: String,
    pub(super) space: WorkingSpace,
    /// Whether the whole picture is certified, not only strips.
    pub(super) whole: bool,
    /// Label of each rung, which tells its settings apart from the others.
    pub(super) labels: Vec<String>,
}

impl<'a> Report<'a> {
    pub(super) fn new(graph: &CheckedGraph, ladder: &'a Ladder, whole: bool) -> Self {
        let scene = graph.name().to_owned();
        let sets: Vec<&[String]> = ladder.rungs.iter().map(|rung| rung.set.as_slice()).collect();
        Self { ladder, scene, space: graph.space(), whole, labels: labels(&sets) }
    }

    /// Each rung with its label.
    pub(super) fn rungs(&self) -> impl Iterator<Item = (&Rung, &str)> + Clone {
        self.ladder.rungs.iter().zip(self.labels.iter().map(String::as_str))
    }

    /// Returns the area in which errors are certified and measured: the whole picture, or strips of it.
    pub(super) fn scope(&self) -> &'static str {
        if self.whole { "whole" } else { "strips" }
    }

    /// Returns the suffix of figures that hold only on the strips; empty if they hold everywhere.
    pub(super) fn on_strips(&self) -> &'static str {
        if self.whole { "" } else { " on the strips" }
    }

    /// Returns a sentence on why nothing is certified, if that is the case.
    pub(super) fn uncertain(&self) -> Option<String> {
        let certain = self.ladder.rungs.iter().any(|rung| rung.certified.max.is_finite());
        let limit = self.ladder.attempts.iter().find_map(|attempt| attempt.limit.as_ref());
        let because = match limit {
            Some(Limit::Unbounded { node, ty, why }) => format!(", because “{node}” ({ty}) has no error bound: {why}"),
            Some(Limit::Unseen) => ", because visibility is not certain anywhere".into(),
            _ => String::new(),
        };
        let (output, strips) = (&self.ladder.output, self.on_strips());
        (!certain).then(|| format!("Nothing is certified of “{output}”{strips}: all samples are ambiguous{because}."))
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
        let methods: Vec<_> = self.rungs().filter(|(rung, _)| rung.is_method).collect();
        let known = methods.iter().filter(|(rung, _)| rung.certified.max.is_finite());
        let best = known.min_by(|a, b| a.0.certified.max.total_cmp(&b.0.certified.max));
        let Some((best, label)) = best else {
            return self.uncertain().into_iter().collect();
        };
        let mut first = format!(
            "{} is certified to {}{} in {} per frame, with {} of its samples{} ambiguous",
            in_words(label, &self.ladder.output),
            short(best.certified.max),
            self.on_strips(),
            seconds(best.seconds),
            percent(best.ambiguous),
            if self.whole { "" } else { " there" },
        );
        if let Some((coarse, label)) = methods.first().filter(|(coarse, _)| coarse.set != best.set) {
            let bound = match coarse.certified.max {
                max if max.is_finite() => format!("is certified only to {}", short(max)),
                _ => "is not certified anywhere".into(),
            };
            first.push_str(&format!("; {label} takes {} and {bound}", seconds(coarse.seconds)));
        }
        let mut all = vec![first + ".", self.reached()];
        if !self.whole {
            all.push(STRIPS.into());
        }
        all
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
                Some(Limit::Rounding) | None => "f32 rounding limits it".into(),
            };
            format!("{} is refused, because {why}", Tolerance::Error(refused.tolerance))
        });
        let met = finest.map(|(attempt, rung)| {
            let (asked, by) = (Tolerance::Error(attempt.tolerance), self.met_by(rung));
            format!("a tolerance of {asked} is met{} by {by}", self.on_strips())
        });
        let sentence = match (met, refused) {
            (Some(met), Some(refused)) => format!("{met}; {refused}"),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => "no tolerance was requested".into(),
        };
        capital(&sentence) + "."
    }
}

fn in_words(label: &str, output: &str) -> String {
    if label == AS_IT_IS { format!("“{output}”") } else { format!("With {label}, “{output}”") }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// Sentence on the limits of certifying strips.
pub(super) const STRIPS: &str = "Errors are certified and measured only on strips, an eighth of the picture in total; \
                                 elsewhere they may be larger. --whole certifies the whole picture, and so does \
                                 trochoid plan.";

/// Label of a document without accuracy knobs.
const AS_IT_IS: &str = "as it is";

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

/// Returns a number as JSON: null if it is not finite.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// Returns the row of a rung: names and values of its columns. All rungs have the same names.
pub(super) fn columns(report: &Report<'_>, rung: &Rung) -> Vec<(&'static str, Value)> {
    let ladder = report.ladder;
    let settings = if rung.set.is_empty() { AS_IT_IS.to_owned() } else { rung.set.join(" ") };
    vec![
        ("scene", json!(report.scene)),
        ("output", json!(ladder.output)),
        ("frame", json!(ladder.frame)),
        ("settings", json!(settings)),
        ("is_method", json!(rung.is_method)),
        ("scope", json!(report.scope())),
        ("certified_max", finite(rung.certified.max)),
        ("certified_p999", finite(rung.certified.p999)),
        ("certified_median", finite(rung.certified.median)),
        ("measured_max", finite(rung.measured.max)),
        ("measured_rms", finite(rung.measured.rms)),
        ("measured_p999", finite(rung.measured.p999)),
        ("measured_median", finite(rung.measured.median)),
        ("measured_pixels", json!(rung.measured_pixels)),
        ("certified_over_measured", finite(rung.ratio)),
        ("ambiguous", finite(rung.ambiguous)),
        ("ambiguous_beyond_8_bit", finite(rung.ambiguous_beyond_8_bit)),
        ("hull_exits", json!(rung.hull_exits)),
        ("nan_count", json!(rung.nan)),
        ("seconds", finite(rung.seconds)),
        ("seconds_spread", finite(rung.spread)),
        ("seconds_predicted", finite(rung.predicted)),
        ("predicted_over_taken", finite(rung.predicted / rung.seconds)),
        ("bytes", json!(rung.bytes)),
        ("threads", json!(ladder.threads)),
        ("pareto", json!(rung.is_best)),
    ]
}

/// Returns a limit as JSON: a pass, with the reason if it has no error bound; or a word for another limit.
fn limited_by(limit: &Limit) -> Value {
    match limit {
        Limit::Pass { node, ty } => json!({ "node": node, "type": ty }),
        Limit::Unbounded { node, ty, why } => json!({ "node": node, "type": ty, "why": why }),
        Limit::Rounding => json!("rounding"),
        Limit::Unseen => json!("what is seen"),
    }
}

/// Returns the whole report except for its pictures as JSON.
pub(super) fn to_json(report: &Report<'_>) -> Value {
    let ladder = report.ladder;
    let rungs = ladder.rungs.iter().map(|rung| {
        let mut row: Map<String, Value> =
            columns(report, rung).into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        row.insert("set".into(), json!(rung.set));
        let passes = rung.passes.iter();
        let passes = passes.map(|pass| json!({ "node": pass.node, "type": pass.ty, "drop": finite(pass.drop) }));
        row.insert("passes".into(), passes.collect());
        Value::Object(row)
    });
    let attempts = ladder.attempts.iter().map(|attempt| {
        let met = attempt.rung.map(|index| &ladder.rungs[index]);
        json!({
            "tolerance": finite(attempt.tolerance),
            "allowed": finite(attempt.allowed),
            "scope": report.scope(),
            "met": met.is_some(),
            "set": met.map(|rung| &rung.set),
            "certified_max": met.map(|rung| finite(rung.certified.max)),
            "limited_by": attempt.limit.as_ref().map(limited_by),
        })
    });
    let savings = ladder.savings.iter().map(|saving| {
        let seconds = saving.seconds.map(finite);
        json!({ "node": saving.node, "type": saving.ty, "why": saving.why, "seconds": seconds })
    });
    let scalings = ladder.scalings.iter().map(|scaling| {
        let points = scaling.points.iter();
        let points = points.map(|(value, seconds)| json!({ "value": finite(*value), "seconds": finite(*seconds) }));
        json!({ "knob": scaling.knob, "points": points.collect::<Vec<_>>() })
    });
    json!({
        "trochoid": VERSION,
        "scene": report.scene,
        "output": ladder.output,
        "frame": ladder.frame,
        "format": {
            "width": ladder.format.width(),
            "height": ladder.format.height(),
            "samples": ladder.format.samples(),
            "shading": match ladder.format.shading() { Shading::Pixel => "pixel", Shading::Sample => "sample" },
        },
        "space": report.space.name(),
        "threads": ladder.threads,
        "whole": report.whole,
        "summary": report.summary(),
        "rungs": rungs.collect::<Vec<_>>(),
        "attempts": attempts.collect::<Vec<_>>(),
        "savings": savings.collect::<Vec<_>>(),
        "scalings": scalings.collect::<Vec<_>>(),
    })
}
