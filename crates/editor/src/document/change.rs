//! Edits: labeled sequences of JSON operations that change a document.

use super::json::{Misplaced, Op, Path, Splice, Step, quoted, splice};
use serde_json::Value;

/// A change to a document's text, with the label shown by undo.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Label shown by undo.
    pub label: String,
    /// Edits with the same key and no pause between them merge into one step of undo.
    pub merge: Option<String>,
    /// Operations, in order.
    pub ops: Vec<Op>,
    /// Operations after these whose places are those of the whole document, even if a group is entered.
    pub around: Vec<Op>,
}

impl Edit {
    /// Creates an edit that merges with no other.
    pub fn new(label: impl Into<String>, ops: Vec<Op>) -> Self {
        Self { label: label.into(), merge: None, ops, around: Vec::new() }
    }

    /// Returns the edit with a merge key, as part of a gesture.
    #[must_use]
    pub fn merging(mut self, key: impl Into<String>) -> Self {
        self.merge = Some(key.into());
        self
    }

    /// Creates an edit that sets one value.
    pub fn set(path: Path, value: &Value) -> Self {
        Self::new(format!("Set {}", spoken(&path)), vec![Op::Set(path, style(value))])
    }

    /// Creates an edit that removes one value, which returns to its default.
    pub fn reset(path: Path) -> Self {
        Self::new(format!("Reset {}", spoken(&path)), vec![Op::Remove(path)])
    }

    /// Returns both edits as one, with the label of the first.
    #[must_use]
    pub fn then(mut self, next: Self) -> Self {
        self.ops.extend(next.ops);
        self.around.extend(next.around);
        self
    }

    /// Returns the text after the edit, and the splices that lead there.
    pub(super) fn applied(&self, text: &str) -> Result<(String, Vec<Splice>), Misplaced> {
        let mut text = text.to_string();
        let mut splices = Vec::new();
        for op in self.ops.iter().chain(&self.around) {
            let splice = splice(&text, op)?;
            if splice.removed != splice.inserted {
                splice.redo(&mut text);
                splices.push(splice);
            }
        }
        Ok((text, splices))
    }

    /// Returns whether the edit, made for one document, has the same meaning in another: the value it changes (for a
    /// list element: the whole list) is equal in both, and the node exists in both or in neither.
    pub fn fits(&self, made_for: &Value, document: &Value) -> bool {
        self.ops.iter().chain(&self.around).all(|op| {
            let steps = &op.path().0;
            let list = steps.iter().position(|step| matches!(step, Step::Index(_))).unwrap_or(steps.len());
            let [place, node] = [list, steps.len().min(2)].map(|count| Path(steps[..count].to_vec()));
            place.find(made_for) == place.find(document)
                && node.find(made_for).is_some() == node.find(document).is_some()
        })
    }
}

/// Returns a path in readable form: `storm.height` for `nodes.storm.height`.
pub fn spoken(path: &Path) -> String {
    let steps = path.0.strip_prefix(&[Step::from("nodes")][..]).unwrap_or(&path.0);
    Path(steps.to_vec()).to_string()
}

/// Formats a value in the style of the project's documents: on one line, with spaces.
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

/// Formats a number without superfluous digits.
fn number_text(value: f64, number: &serde_json::Number) -> String {
    let whole = value.fract() == 0.0 && value.abs() < 1e15;
    if whole { format!("{value:.0}") } else { number.to_string() }
}
