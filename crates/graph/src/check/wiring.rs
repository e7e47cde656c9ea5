//! Checks connections: disabled nodes, kinds, views, loops, and nodes that no output needs.

use super::kinds::kind_of;
use super::{Checker, Draft, FaultLocation};
use crate::{
    Accepts, Arity, ChannelSet, Item, Kind, Knob, KnobType, Means, NodeId, OutputSpec, Port, Record, Settled, Severity,
    Source, refusal,
};
use petgraph::algo::{tarjan_scc, toposort};
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::BTreeSet;

impl<'a> Checker<'a> {
    /// Bypasses disabled nodes: connects their users to what they pass through, or removes the connection.
    pub(super) fn bypass_disabled(&mut self, drafts: &mut [Draft<'a>]) {
        let resolved = bypass_targets(drafts);
        for draft in drafts.iter_mut() {
            bypass(&mut draft.record, &resolved);
        }
        // Ports that a disabled node left open are reported at the port.
        for draft in drafts.iter().filter(|draft| !draft.disabled) {
            let Some(ty) = draft.ty.filter(|_| !draft.faulty) else { continue };
            self.open_ports(ty.declaration().items, &draft.record, draft);
        }
        for draft in drafts.iter_mut() {
            let Some(ty) = draft.ty else { continue };
            if !complete(ty.declaration().items, &draft.record) {
                draft.faulty = true;
            }
        }
    }

    fn open_ports(&mut self, items: &'static [Item], record: &Record, draft: &Draft<'_>) {
        for item in items {
            match item {
                Item::Port(port) if is_short(port, record) => {
                    let offset = draft.offset_of(port.name);
                    let place = FaultLocation { offset, node: Some(draft.name), port: Some(port.name) };
                    let found = "a disabled node that passes nothing through";
                    self.error(place, found, format!("a {}", port.accepts), "enable the node, or connect another");
                }
                Item::List(list) => {
                    for record in record.list(list.name) {
                        self.open_ports(list.items, record, draft);
                    }
                }
                _ => {}
            }
        }
    }

    /// Checks the kind of every connection, and the channels that nodes require of views.
    pub(super) fn connections(&mut self, drafts: &[Draft<'a>]) {
        for draft in drafts.iter().filter(|draft| !draft.disabled) {
            let Some(ty) = draft.ty else { continue };
            self.kinds(ty.declaration().items, &draft.record, draft, drafts);
            if draft.faulty {
                continue;
            }
            let settled = ty.settle(draft.record.settle(0.0));
            let Some(stage) = settled.stage() else { continue };
            let required_channels = stage.required_channels(&vec![true; draft.kinds.len()]);
            for (port, sources) in settled.ports() {
                for source in sources {
                    let Source::Output { node, .. } = source else { continue };
                    if kind_of(source, drafts) != Some(Kind::View) || drafts[node.0].faulty {
                        continue;
                    }
                    let view = drafts[node.0].ty.map(|ty| ty.settle(drafts[node.0].record.settle(0.0)));
                    let Some(view) = view.as_ref().and_then(Settled::stage) else { continue };
                    let missing = required_channels.minus(view.supplied_channels());
                    let never = missing.minus(view.impossible_channels()) != missing;
                    self.missing_channels(missing, never, port, draft, &drafts[node.0]);
                }
            }
        }
    }

    /// Reports channels that a view lacks; `never` means that no setting of the view could supply them.
    fn missing_channels(
        &mut self,
        missing: ChannelSet,
        never: bool,
        port: &'static str,
        draft: &Draft<'_>,
        view: &Draft<'_>,
    ) {
        if missing.is_empty() {
            return;
        }
        let mut names: Vec<&str> = missing.iter().map(|channel| channel.name()).collect();
        names.dedup();
        let offset = draft.offset_of(port);
        let place = FaultLocation { offset, node: Some(draft.name), port: Some(port) };
        let found = format!("the view \"{}\", which has no {}", view.name, names.join(", no "));
        let mut expected = format!("a view with {}", names.join(", "));
        let remedy = if let Some((choice, word)) = choice_without(missing, draft) {
            format!("set \"{choice}\" to \"{word}\", or connect a view that has this")
        } else if never {
            expected.push_str(": the view of a Render");
            let ty = view.ty.map_or("node", |ty| ty.declaration().name);
            format!("connect a Render, which sees the surfaces themselves; no pass of a {ty} holds this")
        } else {
            format!("add the pass that holds it to \"{}\", or use another pass here", view.name)
        };
        self.error(place, found, expected, remedy);
    }

    fn kinds(&mut self, items: &'static [Item], record: &Record, draft: &Draft<'_>, drafts: &[Draft<'a>]) {
        for item in items {
            match item {
                Item::Port(port) => {
                    for source in record.all(port.name) {
                        if matches!(source, Source::Output { .. }) {
                            self.kind(port.accepts, port.name, source, draft, drafts);
                        }
                    }
                }
                Item::List(list) => {
                    for record in record.list(list.name) {
                        self.kinds(list.items, record, draft, drafts);
                    }
                }
                Item::Knob(_) => {}
            }
        }
    }

    fn kind(&mut self, accepts: Accepts, port: &'static str, source: &Source, draft: &Draft<'_>, drafts: &[Draft<'a>]) {
        let Some(found) = kind_of(source, drafts) else { return };
        if accepts.takes(found) {
            return;
        }
        let Source::Output { node, .. } = source else { return };
        let offset = draft.offset_of(port);
        let place = FaultLocation { offset, node: Some(draft.name), port: Some(port) };
        let found_text = format!("\"{}\", a {found}", drafts[node.0].name);
        let operation = draft.ty.and_then(|ty| refusal(ty.declaration().name));
        match operation.filter(|_| found == Kind::Color) {
            Some(operation) => {
                let expected = format!("a {accepts}: {}; {}", operation.reason, operation.witness);
                self.error(place, found_text, expected, operation.rewrite);
            }
            None => self.error(place, found_text, format!("a {accepts}"), accepts.remedy(found)),
        }
    }

    /// Reports every loop; `None` if there are any.
    pub(super) fn loops(&mut self, drafts: &[Draft<'_>]) -> Option<()> {
        let mut graph: DiGraph<(), ()> = DiGraph::with_capacity(drafts.len(), drafts.len());
        for _ in drafts {
            graph.add_node(());
        }
        for (to, draft) in drafts.iter().enumerate() {
            draft.record.each_node(|node| {
                graph.add_edge(NodeIndex::new(node.0), NodeIndex::new(to), ());
            });
        }
        if toposort(&graph, None).is_ok() {
            return Some(());
        }
        for component in tarjan_scc(&graph) {
            let first = component[0];
            if component.len() == 1 && graph.find_edge(first, first).is_none() {
                continue;
            }
            let inside = |node: NodeId| component.contains(&NodeIndex::new(node.0));
            let start = component.iter().map(|index| index.index()).min().unwrap_or(0);
            let path = walk_loop(start, drafts, &inside);
            let names: Vec<&str> = path.iter().map(|&node| drafts[node].name).collect();
            let place = FaultLocation { offset: drafts[start].offset, node: Some(drafts[start].name), port: None };
            let shown = if names.len() > 12 {
                format!("{} ← … ({} nodes) … ← {}", names[..6].join(" ← "), names.len() - 1, names[names.len() - 1])
            } else {
                names.join(" ← ")
            };
            self.error(place, format!("the loop {shown}"), "a graph without loops", "remove one of these connections");
        }
        None
    }

    /// Warns about nodes that no output needs.
    pub(super) fn unused(&mut self, drafts: &[Draft<'_>], outputs: &[OutputSpec]) {
        // A node may be unused because of an error, which is reported already.
        if outputs.is_empty() || self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
            return;
        }
        let mut used = vec![false; drafts.len()];
        let mut open: Vec<usize> = outputs.iter().map(|output| output.node.0).collect();
        while let Some(node) = open.pop() {
            if std::mem::replace(&mut used[node], true) {
                continue;
            }
            drafts[node].record.each_node(|node| open.push(node.0));
        }
        let is_loose = |node: usize| !used[node] && !drafts[node].disabled;
        let mut is_end = vec![true; drafts.len()];
        let mut joined = vec![Vec::new(); drafts.len()];
        for (index, draft) in drafts.iter().enumerate() {
            draft.record.each_node(|node| {
                is_end[node.0] = false;
                if is_loose(index) && is_loose(node.0) {
                    joined[index].push(node.0);
                    joined[node.0].push(index);
                }
            });
        }
        let mut seen = vec![false; drafts.len()];
        for end in 0..drafts.len() {
            if !is_end[end] || !is_loose(end) || seen[end] {
                continue;
            }
            // Connected nodes form one branch, which may have several ends.
            let (mut branch, mut open) = (BTreeSet::new(), vec![end]);
            while let Some(node) = open.pop() {
                if branch.insert(node) {
                    seen[node] = true;
                    open.extend(&joined[node]);
                }
            }
            branch.remove(&end);
            let names = |nodes: &[usize]| {
                let names: Vec<&str> = nodes.iter().map(|&node| drafts[node].name).take(6).collect();
                format!("{}{}", names.join(", "), if nodes.len() > names.len() { ", …" } else { "" })
            };
            let (ends, others): (Vec<usize>, Vec<usize>) = branch.into_iter().partition(|&node| is_end[node]);
            let draft = &drafts[end];
            let mut found = "a node that no output needs".to_string();
            if !ends.is_empty() {
                found += &format!(", like {}", names(&ends));
            }
            if !others.is_empty() {
                let whose = if ends.is_empty() { "it needs" } else { "they need" };
                found += &format!(", with the nodes that only {whose}: {}", names(&others));
            }
            let remedy = match (ends.len(), ends.len() + others.len() + 1) {
                (0, 1) => {
                    "it is not evaluated; add an output of it, connect it to a node that an output needs, or disable it"
                        .to_string()
                }
                (0, all) => {
                    format!(
                        "none of the {all} is evaluated; add an output of {0}, connect {0} to a node that an output needs, \
                         or disable all",
                        draft.name
                    )
                }
                (_, all) => format!(
                    "none of the {all} is evaluated; add outputs of {0}, {1}, connect them to nodes that an output needs, \
                     or disable all",
                    draft.name,
                    names(&ends)
                ),
            };
            let place = FaultLocation { offset: draft.offset, node: Some(draft.name), port: None };
            let told = self.report(Severity::Warning, place, found, "every node to be used".into(), remedy);
            if let Some(told) = told {
                told.means = Some(Means::LeadToOutput);
            }
        }
    }
}

/// Returns the output that stands for each node: its own, or, if the node is disabled, the one that its first
/// connection leads to if it has the same kind.
fn bypass_targets(drafts: &[Draft<'_>]) -> Vec<Option<(NodeId, usize)>> {
    let mut resolved: Vec<Option<(NodeId, usize)>> = vec![None; drafts.len()];
    let mut visited = vec![false; drafts.len()];
    for start in 0..drafts.len() {
        let mut path = Vec::new();
        let mut at = (NodeId(start), 0);
        let end = loop {
            let draft = &drafts[at.0.0];
            if !draft.disabled {
                break Some(at);
            }
            // Either known from an earlier path, or a loop of disabled nodes, which passes nothing through and is
            // reported elsewhere.
            if std::mem::replace(&mut visited[at.0.0], true) {
                break resolved[at.0.0];
            }
            path.push(at.0);
            match draft.record.sources().into_iter().next() {
                Some(first @ Source::Output { node, output })
                    if kind_of(first, drafts) == draft.kinds.first().copied() =>
                {
                    at = (*node, *output);
                }
                _ => break None,
            }
        };
        path.into_iter().for_each(|node| resolved[node.0] = end);
        if !drafts[start].disabled {
            resolved[start] = end;
        }
    }
    resolved
}

fn bypass(record: &mut Record, resolved: &[Option<(NodeId, usize)>]) {
    for (_, sources) in &mut record.ports {
        sources.retain_mut(|source| {
            let Source::Output { node, output } = source else { return true };
            match resolved[node.0] {
                Some((to, to_output)) if to != *node => {
                    (*node, *output) = (to, to_output);
                    true
                }
                kept => kept.is_some(),
            }
        });
    }
    for (_, records) in &mut record.lists {
        records.iter_mut().for_each(|record| bypass(record, resolved));
    }
}

/// Returns a choice of a node, and a word for it with which the node does not require these channels.
fn choice_without(missing: ChannelSet, draft: &Draft<'_>) -> Option<(&'static str, &'static str)> {
    let ty = draft.ty?;
    let choices = ty.declaration().items.iter().filter_map(|item| match item {
        Item::Knob(Knob { name, takes: KnobType::Choice(words), .. }) => Some((*name, *words)),
        _ => None,
    });
    let mut words = choices.flat_map(|(choice, words)| words.iter().map(move |word| (choice, *word)));
    words.find(|(choice, word)| {
        let settled = ty.settle(draft.record.with_word(choice, word).settle(0.0));
        let stage = settled.stage();
        stage.is_some_and(|stage| !stage.required_channels(&vec![true; draft.kinds.len()]).intersects(missing))
    })
}

fn is_short(port: &Port, record: &Record) -> bool {
    let connected = record.all(port.name).len();
    match port.arity {
        Arity::One => connected == 0,
        Arity::Optional => false,
        Arity::Many { min, .. } => connected < min,
    }
}

fn complete(items: &'static [Item], record: &Record) -> bool {
    items.iter().all(|item| match item {
        Item::Port(port) => record.ports.is_empty() || !is_short(port, record),
        Item::List(list) => record.lists.is_empty() || record.list(list.name).iter().all(|r| complete(list.items, r)),
        Item::Knob(_) => true,
    })
}

/// Finds a loop from `start` back to `start` within a strongly connected component.
fn walk_loop(start: usize, drafts: &[Draft<'_>], inside: &dyn Fn(NodeId) -> bool) -> Vec<usize> {
    // A breadth-first search upstream finds the shortest loop.
    let mut from = vec![usize::MAX; drafts.len()];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        for source in drafts[node].record.sources() {
            let Source::Output { node: up, .. } = source else { continue };
            if up.0 == start {
                let mut path = vec![start, node];
                let mut at = node;
                while at != start {
                    at = from[at];
                    path.push(at);
                }
                path.reverse();
                if node == start {
                    path = vec![start, start];
                }
                return path;
            }
            if inside(*up) && from[up.0] == usize::MAX {
                from[up.0] = node;
                queue.push_back(up.0);
            }
        }
    }
    vec![start]
}
