//! Outputs that are added from outside of a document, to look at any node.

use super::{ASSIGNED, Document};
use crate::spanned::{Entry, Json, Spanned};

impl Document {
    /// Adds an output that shows what a node makes, or what feeds one of its ports: `sea`, `view.coverage`,
    /// `blend.weights[1]`. It is the last output, and has the name of what it shows, with `-` for `/`.
    ///
    /// Its faults are at `view=REFERENCE`, as at an assignment.
    pub fn view(&mut self, reference: &str) {
        let offset = ASSIGNED + self.assignments.len();
        self.assignments.push(format!("view={reference}"));
        self.views.push(offset);
        let Json::Object(entries) = &mut self.root.json else { return };
        if !entries.iter().any(|entry| entry.key == "outputs") {
            let value = Spanned { offset, json: Json::Object(Vec::new()) };
            entries.push(Entry { key: "outputs".into(), offset, value });
        }
        let outputs = entries.iter_mut().find(|entry| entry.key == "outputs").map(|entry| &mut entry.value.json);
        let Some(Json::Object(outputs)) = outputs else { return };
        let plain = reference.replace('/', "-");
        let others = (2..).map(|n: usize| format!("{plain}-{n}"));
        let is_free = |name: &String| !outputs.iter().any(|output| output.key == *name);
        let key = std::iter::once(plain.clone()).chain(others).find(is_free).unwrap_or_default();
        // Whatever kind it has: checking takes it from what is there.
        let what = Spanned { offset, json: Json::String(reference.into()) };
        let items = vec![Entry { key: "color".into(), offset, value: what }];
        outputs.push(Entry { key, offset, value: Spanned { offset, json: Json::Object(items) } });
    }

    /// Whether an output with this offset was added by [`view`](Self::view).
    pub(crate) fn is_view(&self, offset: usize) -> bool {
        self.views.contains(&offset)
    }
}
