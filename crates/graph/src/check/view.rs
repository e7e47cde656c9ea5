//! Outputs that show any node, or what feeds one of its ports.

use super::items::{Names, node_and_output};
use super::kinds::kind_of;
use super::{Checker, Draft, FaultLocation};
use crate::spanned::{Entry, Json, shorten};
use crate::{Kind, NodeId, OutputSpec, Record, Source, nearest};

/// Most names in a remedy.
const LISTED: usize = 12;

impl<'a> Checker<'a> {
    /// Reads an output that [`Document::view`](crate::Document::view) added.
    pub(super) fn view(
        &mut self,
        spec: OutputSpec,
        entry: &'a Entry,
        drafts: &[Draft<'a>],
        names: &Names<'a>,
    ) -> Option<OutputSpec> {
        let place = FaultLocation { offset: entry.offset, node: None, port: None };
        let Json::Object(items) = &entry.value.json else { return None };
        let reference = &items.first()?.value;
        let Json::String(text) = &reference.json else {
            self.error(place, reference.brief(), "a node, or a port that a node feeds", "show another node");
            return None;
        };
        let source = self.shown(text, place, drafts, names)?;
        let Source::Output { node, output } = source else { return None };
        let draft = &drafts[node.0];
        let spec = OutputSpec { node, output, ..spec };
        let spec = match draft.disabled {
            true => self.bypassed(spec, draft, place, drafts)?,
            false => OutputSpec { kind: kind_of(&source, drafts)?, ..spec },
        };
        let kind = spec.kind;
        if !is_picture(kind) {
            let found = format!("\"{}\", a {kind}, which is not a picture", draft.name);
            let expected = "a node that makes a Color, a mask, Weights or a Field";
            let pictures = pictures_of(spec.node, drafts);
            let remedy = match listed(&pictures) {
                Some(list) => format!("show a node that makes a picture of it: {list}"),
                None if kind == Kind::View => "add a pass of it, such as Depth, and show that".into(),
                None => "add a Render and a pass of it, such as Depth, and show that".into(),
            };
            self.error(place, found, expected, remedy);
            return None;
        }
        Some(spec)
    }

    /// Returns the output of a node that a text names, or the one that feeds the port that it names.
    fn shown(
        &mut self,
        text: &str,
        place: FaultLocation<'_>,
        drafts: &[Draft<'a>],
        names: &Names<'a>,
    ) -> Option<Source> {
        let (name, item) = node_and_output(text, names);
        let known = item.and_then(|item| Some((name, item, names.get(name)?)));
        let Some((name, item, &(node, Some(declaration)))) = known else {
            return self.reference(text, place, names, false);
        };
        if let Some(output) = declaration.outputs.iter().position(|output| output.name == item) {
            return Some(Source::Output { node: NodeId(node), output });
        }
        let mut ports = Vec::new();
        feeding(&drafts[node].record, "", &mut ports);
        match ports.iter().find(|(port, _)| port == item) {
            Some((_, source @ Source::Output { .. })) => return Some((*source).clone()),
            Some(_) => {
                let found = format!("\"{}\", a value that the document writes", shorten(text));
                self.error(place, found, "a port that a node feeds", format!("show the node itself: {name}"));
                return None;
            }
            None => {}
        }
        let fed = ports.iter().filter(|(_, source)| matches!(source, Source::Output { .. }));
        let outputs = declaration.outputs.iter().filter(|output| !output.name.is_empty()).map(|output| output.name);
        let all: Vec<&str> = outputs.chain(fed.map(|(port, _)| port.as_str())).collect();
        let of_list: Vec<&str> = all
            .iter()
            .copied()
            .filter(|port| port.strip_prefix(item).is_some_and(|rest| rest.starts_with('[')))
            .collect();
        let remedy = match (nearest(item, all.iter().copied()), listed(&of_list), listed(&all)) {
            (_, Some(list), _) => format!("choose one: {list}"),
            (Some(near), ..) => format!("did you mean {name}.{near}?"),
            (_, _, Some(list)) => format!("{name} has: {list}"),
            _ => format!("show the node itself: {name}"),
        };
        let found = format!("\"{}\" of a {}", shorten(item), declaration.name);
        self.error(place, found, "one of its outputs, or a port that a node feeds", remedy);
        None
    }
}

fn is_picture(kind: Kind) -> bool {
    matches!(kind, Kind::Color | Kind::Weights(_) | Kind::Field(_))
}

/// Lists names; `None` if there are none.
fn listed(names: &[&str]) -> Option<String> {
    let more = if names.len() > LISTED { ", …" } else { "" };
    (!names.is_empty()).then(|| names[..names.len().min(LISTED)].join(", ") + more)
}

/// Appends the path of each port of a record, with what feeds it: `weight`, `weights[1]`, `layers[0].color`.
fn feeding<'r>(record: &'r Record, within: &str, found: &mut Vec<(String, &'r Source)>) {
    for (port, sources) in record.ports() {
        match sources {
            [source] => found.push((format!("{within}{port}"), source)),
            several => {
                found.extend(several.iter().enumerate().map(|(i, source)| (format!("{within}{port}[{i}]"), source)));
            }
        }
    }
    for (list, records) in &record.lists {
        for (index, record) in records.iter().enumerate() {
            feeding(record, &format!("{within}{list}[{index}]."), found);
        }
    }
}

/// Returns the nearest nodes downstream that make pictures.
fn pictures_of<'d>(node: NodeId, drafts: &'d [Draft<'_>]) -> Vec<&'d str> {
    let mut seen = vec![false; drafts.len()];
    let (mut open, mut pictures) = (vec![node], Vec::new());
    while let Some(node) = open.pop() {
        for (index, draft) in drafts.iter().enumerate().filter(|(_, draft)| !draft.disabled) {
            let mut uses = false;
            draft.record.each_node(|input| uses |= input == node);
            if !uses || std::mem::replace(&mut seen[index], true) {
                continue;
            }
            match draft.kinds.first() {
                Some(kind) if is_picture(*kind) => pictures.push((index, draft.name)),
                _ => open.push(NodeId(index)),
            }
        }
    }
    // In the order of the document.
    pictures.sort_unstable();
    pictures.into_iter().map(|(_, name)| name).collect()
}
