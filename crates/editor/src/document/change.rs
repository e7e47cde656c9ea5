//! What a change of a document is.

use super::json::{Misplaced, Op, Path, Splice, Step, quoted, splice};
use serde_json::Value;

/// A change: what it is called, and what it does to the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// What undo calls it.
    pub label: String,
    /// Changes with the same key, without a pause between them, are one step of undo.
    pub merge: Option<String>,
    /// What is done, in order.
    pub ops: Vec<Op>,
}

impl Edit {
    /// A change of one step.
    pub fn new(label: impl Into<String>, ops: Vec<Op>) -> Self {
        Self { label: label.into(), merge: None, ops }
    }

    /// The same change as a part of a gesture.
    #[must_use]
    pub fn merging(mut self, key: impl Into<String>) -> Self {
        self.merge = Some(key.into());
        self
    }

    /// Sets one value.
    pub fn set(path: Path, value: &Value) -> Self {
        Self::new(format!("Set {}", spoken(&path)), vec![Op::Set(path, style(value))])
    }

    /// Takes one value away, which goes back to its default.
    pub fn reset(path: Path) -> Self {
        Self::new(format!("Reset {}", spoken(&path)), vec![Op::Remove(path)])
    }

    /// Both changes as one, called as the first.
    #[must_use]
    pub fn then(mut self, next: Self) -> Self {
        self.ops.extend(next.ops);
        self
    }

    /// A text after it, and what became of that.
    pub(super) fn applied(&self, text: &str) -> Result<(String, Vec<Splice>), Misplaced> {
        let mut text = text.to_string();
        let mut splices = Vec::new();
        for op in &self.ops {
            let splice = splice(&text, op)?;
            if splice.removed != splice.inserted {
                splice.redo(&mut text);
                splices.push(splice);
            }
        }
        Ok((text, splices))
    }

    /// Whether it means in a document what it was made for in another: what it changes is the same there, lists as a whole, and
    /// of the same nodes.
    pub fn fits(&self, made_for: &Value, document: &Value) -> bool {
        self.ops.iter().all(|op| {
            let steps = &op.path().0;
            let list = steps.iter().position(|step| matches!(step, Step::Index(_))).unwrap_or(steps.len());
            let [place, node] = [list, steps.len().min(2)].map(|count| Path(steps[..count].to_vec()));
            place.find(made_for) == place.find(document)
                && node.find(made_for).is_some() == node.find(document).is_some()
        })
    }
}

/// A place as people call it: `storm.height` for `nodes.storm.height`.
pub fn spoken(path: &Path) -> String {
    let steps = path.0.strip_prefix(&[Step::from("nodes")][..]).unwrap_or(&path.0);
    Path(steps.to_vec()).to_string()
}

/// A value as the project's documents write it: on one line, with spaces.
pub fn style(value: &Value) -> String {
    match value {
        Value::Array(items) => {
            let texts: Vec<String> = items.iter().map(style).collect();
            format!("[{}]", texts.join(", "))
        }
        Value::Object(entries) if entries.is_empty() => "{}".into(),
        Value::Object(entries) => {
            let texts: Vec<String> =
                entries.iter().map(|(key, value)| format!("{}: {}", quoted(key), style(value))).collect();
            format!("{{ {} }}", texts.join(", "))
        }
        Value::Number(number) => number_text(number.as_f64().unwrap_or_default(), number),
        other => other.to_string(),
    }
}

/// A number without digits that say nothing.
fn number_text(value: f64, number: &serde_json::Number) -> String {
    let whole = value.fract() == 0.0 && value.abs() < 1e15;
    if whole { format!("{value:.0}") } else { number.to_string() }
}
