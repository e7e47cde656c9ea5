//! What is said of uses of groups.

use super::items::{Names, node_and_output};
use super::{Checker, Draft, FaultLocation};
use crate::document::Origin;
use crate::expand::Use;
use crate::spanned::shorten;
use crate::{DocumentPlace, GroupUse};

impl<'a> Checker<'a> {
    /// Returns which use of which group a node belongs to, if it belongs to one.
    pub(super) fn use_of(&self, node: &str) -> Option<String> {
        let (path, _) = node.rsplit_once('/')?;
        let used = self.expanded.uses.iter().find(|used| used.path == path)?;
        let Origin { line, column, file, .. } = self.document.origin(used.offset);
        let file = if *file == *self.document.name() { String::new() } else { format!("{file}:") };
        Some(format!("the group {} as used at {file}{line}:{column}", used.group))
    }

    /// Returns the uses of groups.
    pub(super) fn group_uses(&self) -> Vec<GroupUse> {
        let known = |used: &Use| {
            let Origin { file, line, column, .. } = self.document.origin(used.offset);
            let place = DocumentPlace { document: file, line, column };
            GroupUse { path: used.path.clone(), group: used.group.clone(), place }
        };
        self.expanded.uses.iter().map(known).collect()
    }

    /// Reports inputs of groups that are connected to nodes of another kind.
    pub(super) fn inputs_of_groups(&mut self, drafts: &[Draft<'_>], names: &Names<'a>) {
        for used in &self.expanded.uses {
            for input in &used.inputs {
                let (name, output) = node_and_output(&input.reference, names);
                let Some(&(node, Some(declaration))) = names.get(name) else { continue };
                let index = output.and_then(|output| declaration.outputs.iter().position(|known| known.name == output));
                let Some(kind) = drafts[node].kinds.get(index.unwrap_or(0)) else { continue };
                if !input.accepts.takes(*kind) {
                    let place = FaultLocation { offset: input.offset, node: Some(&used.path), port: Some(&input.name) };
                    let found = format!("\"{}\", a {kind}", shorten(&input.reference));
                    self.error(place, found, format!("a {}", input.accepts), "connect another node");
                }
            }
        }
    }
}
