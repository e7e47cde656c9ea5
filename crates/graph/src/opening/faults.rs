//! Faults of inputs: names that lead to nothing for which samples can be supplied.

use super::{At, item_at};
use crate::*;

/// Most names that a remedy lists.
const LISTED: usize = 12;

impl CheckedGraph {
    /// The name is none of the document's.
    pub(super) fn no_such_input(&self, name: &str) -> Box<Diagnostic> {
        let first = name.split_once('.').map_or(name, |(first, _)| first);
        let colors = || self.palette.iter().map(|color| color.name.as_str());
        let knobs = || self.knobs.iter().map(|knob| knob.name.as_str());
        let (expected, all) = match first {
            "palette" => ("a color of the document's palette", listed("colors of the palette", colors())),
            "knobs" => ("a knob of the document", listed("knobs of the document", knobs())),
            _ => (
                "a node of the document, palette.NAME, knobs.NAME, or NODE.PORT as in water.weight or \
                 water.stops[1].color",
                listed("nodes of the document", self.own_names()),
            ),
        };
        let remedy = self.meant(name).map_or(all, |meant| format!("did you mean \"{meant}\"?"));
        self.nowhere(format!("\"{}\"", spanned::shorten(name)), expected, remedy)
    }

    /// Names of the nodes that documents have: not those of literals that are inputs.
    fn own_names(&self) -> impl Iterator<Item = &str> {
        self.nodes.iter().map(|node| node.name.as_str()).filter(|name| !name.contains('.'))
    }

    /// Returns the name of something that may be meant by a name.
    fn meant(&self, name: &str) -> Option<String> {
        let colors = || self.palette.iter().map(|color| color.name.as_str());
        let knobs = || self.knobs.iter().map(|knob| knob.name.as_str());
        match name.split_once('.') {
            Some(("palette", color)) => nearest(color, colors()).map(|near| format!("palette.{near}")),
            Some(("knobs", knob)) => nearest(knob, knobs()).map(|near| format!("knobs.{near}")),
            Some((node, item)) => {
                let near = nearest(node, self.own_names().chain(["palette", "knobs"]))?;
                Some(format!("{near}.{item}"))
            }
            None => {
                // Who forgets where a color stands names it exactly.
                let color = colors().find(|color| *color == name).map(|color| format!("palette.{color}"));
                let knob = || knobs().find(|knob| *knob == name).map(|knob| format!("knobs.{knob}"));
                color.or_else(knob).or_else(|| nearest(name, self.own_names()).map(str::to_owned))
            }
        }
    }

    /// The node makes nothing that samples can hold.
    pub(super) fn no_image(&self, id: NodeId) -> Box<Diagnostic> {
        let node = self.node(id);
        let found = format!("the input \"{}\", a {}", node.name, node.ty.declaration().name);
        let remedy = "make what is computed of it the input";
        self.at_node(id, None, found, "a node that makes a Color, a mask, Weights or a Field", remedy)
    }

    /// Nothing takes the color or knob.
    pub(super) fn unused(&self, name: &str) -> Box<Diagnostic> {
        let found = format!("\"{name}\", which nothing in the document takes");
        self.nowhere(
            found,
            "a color or number that ports take",
            "leave the input out, or use it in the document".into(),
        )
    }

    /// A color of the palette is a part of a value.
    pub(super) fn within_value(&self, name: &str, place: &PaletteUse) -> Box<Diagnostic> {
        let found = format!("the input \"{name}\" in keys, or as a part of a knob");
        let remedy = "write the color itself there, or bind this node";
        self.at_node(
            place.node,
            Some(&place.item),
            found,
            "it at ports alone, where samples can take its place",
            remedy,
        )
    }

    /// A knob of the document is used to compute something.
    pub(super) fn computed_with(&self, name: &str, knob: &DocumentKnob) -> Box<Diagnostic> {
        let DocumentPlace { document, line, column } = &knob.place;
        Box::new(Diagnostic {
            file: document.to_string(),
            line: *line,
            column: *column,
            port: Some(name.into()),
            ..*self.nowhere(
                format!("the input \"{name}\", which is used in a formula, in keys, or in a knob of a node"),
                &format!("a knob that ports alone take, as it is: \"weight\": \"= {name}\""),
                "bind the ports or nodes that take it".into(),
            )
        })
    }

    /// A part of a node is no literal at a port.
    pub(super) fn no_literal(&self, name: &str, id: NodeId, item: &str, source: Option<&Source>) -> Box<Diagnostic> {
        let node = self.node(id);
        let declaration = node.ty.declaration();
        let input = format!("the input \"{}\"", spanned::shorten(name));
        let literals = node.literals();
        let others = || match &literals[..] {
            [] => format!("bind \"{}\" itself", node.name),
            names => {
                let near = nearest(item, names.iter().map(String::as_str));
                let full = |item: &str| format!("{}.{item}", node.name);
                match near {
                    Some(near) => format!("did you mean \"{}\"?", full(near)),
                    None => listed("such ports", names.iter().map(|item| full(item)).collect::<Vec<_>>().iter()),
                }
            }
        };
        let (found, remedy) = match (source, item_at(declaration.items, item)) {
            (Some(Source::Output { node: from, output }), _) => {
                let from = self.node(*from);
                let (name, is_opened) = (&from.name, from.name.contains('.'));
                match output {
                    _ if is_opened => {
                        (format!("{input}, which is the input \"{name}\" already"), "leave one of them out".into())
                    }
                    0 => (format!("{input}, which is connected to \"{name}\""), format!("bind \"{name}\"")),
                    _ => (format!("{input}, which is connected to another output of \"{name}\""), others()),
                }
            }
            (Some(_), _) => (format!("{input}, several numbers"), "connect a node to it, and bind that".into()),
            (None, At::Knob) => {
                let found = format!("{input}, a knob, which is the same for all samples");
                match name.strip_prefix("palette.") {
                    Some(_) => (found, format!("bind \"{}\" itself, or write the color itself there", node.name)),
                    None => (found, format!("set it instead: {name}=VALUE")),
                }
            }
            (None, At::Port(_)) => (format!("{input}, which the document does not set"), others()),
            (None, At::List) => (format!("{input}, a list"), others()),
            (None, At::Nothing) => (input, others()),
        };
        let item = Some(item).filter(|_| item_at(declaration.items, item) != At::Nothing);
        let expected = format!("a port of this {} with a color or a number", declaration.name);
        self.at_node(id, item, found, &expected, &remedy)
    }

    fn at_node(&self, id: NodeId, item: Option<&str>, found: String, expected: &str, remedy: &str) -> Box<Diagnostic> {
        let node = self.node(id);
        let top = item.map(|item| item.split(['.', '[']).next().unwrap_or(item));
        let DocumentPlace { document, line, column } = self.place_of(id, top);
        Box::new(Diagnostic {
            file: document.to_string(),
            line,
            column,
            node: Some(spanned::shorten(&node.name)),
            port: item.map(spanned::shorten),
            ..*self.nowhere(found, expected, remedy.into())
        })
    }

    fn nowhere(&self, found: String, expected: &str, remedy: String) -> Box<Diagnostic> {
        Box::new(Diagnostic {
            severity: Severity::Error,
            file: self.name.clone(),
            is_assigned: false,
            line: 0,
            column: 0,
            node: None,
            port: None,
            found,
            expected: expected.into(),
            remedy,
            means: None,
            used: None,
        })
    }
}

impl CheckedNode {
    /// Returns the ports that have a color or number of their own, as in `a` and `stops[1].color`.
    fn literals(&self) -> Vec<String> {
        let mut all = Vec::new();
        literals(&self.record, self.ty.declaration().items, "", &mut all);
        all
    }
}

fn literals(record: &Record, items: &'static [Item], within: &str, all: &mut Vec<String>) {
    for item in items {
        match item {
            Item::Port(port) => {
                let sources = record.ports.iter().find(|(name, _)| *name == port.name);
                let sources = sources.into_iter().flat_map(|(_, sources)| sources).enumerate();
                for (index, _) in sources.filter(|(_, source)| matches!(source, Source::Color(_) | Source::Number(_))) {
                    all.push(match port.arity {
                        Arity::Many { .. } => format!("{within}{}[{index}]", port.name),
                        _ => format!("{within}{}", port.name),
                    });
                }
            }
            Item::List(list) => {
                let records = record.lists.iter().find(|(name, _)| *name == list.name);
                for (index, record) in records.into_iter().flat_map(|(_, records)| records).enumerate() {
                    literals(record, list.items, &format!("{within}{}[{index}].", list.name), all);
                }
            }
            Item::Knob(_) => {}
        }
    }
}

/// Lists the first names under a heading.
fn listed<S: AsRef<str>>(heading: &str, names: impl Iterator<Item = S>) -> String {
    let names: Vec<String> = names.map(|name| spanned::shorten(name.as_ref())).collect();
    match names.len() {
        0 => format!("{heading}: none"),
        1..=LISTED => format!("{heading}: {}", names.join(", ")),
        count => format!("{heading}: {} and {} more", names[..LISTED].join(", "), count - LISTED),
    }
}
