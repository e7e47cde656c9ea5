//! `trochoid check --explain`: lists for each output the nodes that are evaluated and those that are left out, with the
//! reasons and the time saved.
//!
//! In the JSON output, `explained` is a list of outputs, each with
//! - `output`, `kind`, `frame`;
//! - `nodes`, by name: `type`; `fate`, one of `evaluated`, `folded`, `hands_on`, `merged`, `left_out`; `why`, a
//!   sentence, null if the node is evaluated; `proof`, a list of `{node, type, low, high, evidence}`, from the proved
//!   weight or value back to the known ones; `channels`, a list of `{output, wanted, unasked}`; `seconds` (null: left
//!   out), `seconds_in_full` (null: not evaluated even with nothing left out), `spread` (difference between runs) and
//!   `estimated`, all four null unless measured;
//! - `omissions`: a list of `{node, of, what, left_out, of_all, why}`, the work that stages skip; `not_prepared` is the
//!   reason if this work is unknown;
//! - `held`: a list of `{node, what, channels, bytes}`, the planes that are filled over the whole picture before tiles read
//!   them; `what` is `result`, or `inputs` if the planes are what the node reads;
//! - `measured`: null, or `{width, height, samples, runs, seconds, seconds_in_full, spread}`, or `{error}`.
//!
//! Infinite interval bounds are the strings `inf` and `-inf`.

use crate::failure::{Failure, INVALID};
use crate::interrupt;
use crate::remedies;
use crate::shell::{HEADING, printable, wrap};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use trochoid::{
    Account, Cache, CheckedGraph, Cost, Costs, EvalError, Evidence, Fate, HeldPlanes, Interval, LeftOut, MeasureError,
    Monitor, NodeId, Omission, Plan, ProofStep, Settings, in_bytes, measure,
};

/// Maximum width and height of the picture that is evaluated for measuring, in pixels.
const LARGEST: u32 = 480;

/// Explanation of an output at a frame.
pub(crate) struct Explanation<'g> {
    graph: &'g CheckedGraph,
    output: usize,
    frame: i64,
    accounts: Vec<Account>,
    omissions: Result<Vec<(NodeId, Vec<Omission>)>, EvalError>,
    held: Vec<HeldPlanes>,
    /// Measured costs; `None` if measuring was not requested.
    costs: Option<Result<Costs, MeasureError>>,
}

/// Monitor that cancels on an interrupt by the user.
struct InterruptMonitor;

impl Monitor for InterruptMonitor {
    fn cancelled(&self) -> bool {
        interrupt::asked()
    }
}

/// Explains an output, prepares its stages, and measures it if asked to.
///
/// # Errors
/// The output cannot be planned.
pub(crate) fn explain(
    graph: &CheckedGraph,
    output: usize,
    frame: i64,
    measured: bool,
) -> Result<Explanation<'_>, Failure> {
    let name = graph.outputs()[output].name.as_str();
    let (plan, accounts) = Plan::explained(graph, &[name], frame, &[], &Settings::default())
        .map_err(|error| Failure::new(INVALID, error))?;
    // Missing files are reported as warnings already; the rest of the explanation does not need them.
    let mut cache = Cache::new();
    let omissions = plan.omissions(&mut cache, &InterruptMonitor);
    let held = omissions.as_ref().map_or(Vec::new(), |_| plan.held(&mut cache, &InterruptMonitor).unwrap_or_default());
    let costs = measured.then(|| measure(graph, name, frame, LARGEST, &InterruptMonitor));
    Ok(Explanation { graph, output, frame, accounts, omissions, held, costs })
}

/// Nodes that are not evaluated for the same reason.
struct Group<'e> {
    why: String,
    proof: &'e [ProofStep],
    by_weight: bool,
    nodes: Vec<NodeId>,
}

impl Explanation<'_> {
    fn cost(&self, id: NodeId) -> Option<Cost> {
        self.costs.as_ref()?.as_ref().ok()?.nodes.get(id.0).copied()
    }

    /// Returns the groups of nodes that are not evaluated, in document order.
    fn groups(&self) -> Vec<Group<'_>> {
        let mut groups: Vec<Group<'_>> = Vec::new();
        for account in &self.accounts {
            let Some(why) = why(&account.fate) else { continue };
            let same = |group: &&mut Group<'_>| group.why == why && group.proof == account.proof.as_slice();
            match groups.iter_mut().find(same) {
                Some(group) => group.nodes.push(account.node),
                None => {
                    let by_weight = matches!(account.fate, Fate::LeftOut(LeftOut::Weight(_)));
                    groups.push(Group { why, proof: &account.proof, by_weight, nodes: vec![account.node] });
                }
            }
        }
        groups
    }

    /// Returns the explanation as text.
    pub(crate) fn to_text(&self) -> String {
        let spec = &self.graph.outputs()[self.output];
        let title = format!("{} ({})", printable(&spec.name), spec.kind);
        let mut text = format!("\n{HEADING}{title}{HEADING:#} at frame {}\n", self.frame);
        let evaluated: Vec<NodeId> = self
            .accounts
            .iter()
            .filter(|account| account.fate == Fate::Evaluated)
            .map(|account| account.node)
            .collect();
        let _ = writeln!(text, "  Evaluated: {} of {} nodes", evaluated.len(), self.accounts.len());
        self.rows(&mut text, &evaluated, |cost| cost.seconds);
        for group in self.groups() {
            text.push('\n');
            text.push_str(&wrap(&group.why, 2));
            for (index, bound) in group.proof.iter().enumerate() {
                let rest = group.by_weight && index == 0 && bound.interval.constant() == Some(1.0);
                let rest = if rest { ", which leaves 1 − 1 = 0" } else { "" };
                text.push_str(&wrap(&format!("· {}{rest}", sentence(bound)), 6));
            }
            self.rows(&mut text, &group.nodes, |cost| cost.seconds_in_full);
        }
        self.channels(&mut text);
        self.spared(&mut text);
        self.held(&mut text);
        self.how(&mut text);
        text
    }

    /// Appends a table of nodes: name, type, and time if measured.
    fn rows(&self, text: &mut String, nodes: &[NodeId], time: impl Fn(&Cost) -> Option<f64>) {
        let named = |id: &NodeId| (printable(&self.graph.node(*id).name), self.graph.node(*id).ty.declaration().name);
        let rows: Vec<(String, &str)> = nodes.iter().map(named).collect();
        let names = rows.iter().map(|row| row.0.chars().count()).max().unwrap_or(0);
        let types = rows.iter().map(|row| row.1.chars().count()).max().unwrap_or(0);
        for (id, (name, ty)) in nodes.iter().zip(rows) {
            let cell = self.cost(*id).map_or(String::new(), |cost| match time(&cost) {
                Some(seconds) => format!("{:>12}{}", milliseconds(seconds), if cost.estimated { " ≈" } else { "" }),
                None => format!("{:>12}", "—"),
            });
            let _ = writeln!(text, "{}", format!("    {name:names$}  {ty:types$}{cell}").trim_end());
        }
    }

    /// Appends the requested and unrequested channels of views and other stages with several channels.
    fn channels(&self, text: &mut String) {
        let mut heading = "\n  Unrequested channels\n";
        for account in &self.accounts {
            let unasked: usize = account.channels.iter().map(|output| output.unasked.len()).sum();
            if unasked == 0 {
                continue;
            }
            text.push_str(std::mem::take(&mut heading));
            let node = self.graph.node(account.node);
            let wanted: usize = account.channels.iter().map(|output| output.wanted.len()).sum();
            let saved = self.cost(account.node).and_then(|cost| {
                cost.seconds?;
                let (saved, spread) = (cost.saved()?, cost.spread);
                Some(if saved > spread {
                    format!(", which saves {}", milliseconds(saved))
                } else {
                    format!("; what that saves is less than runs differ by, {}", milliseconds(spread))
                })
            });
            let saved = saved.unwrap_or_default();
            let name = printable(&node.name);
            let all = wanted + unasked;
            let _ = writeln!(text, "    {name} ({}): {wanted} of {all} computed{saved}", node.ty.declaration().name);
            for (word, list) in [("computed:", true), ("left out:", false)] {
                let names: Vec<String> = account
                    .channels
                    .iter()
                    .flat_map(|output| {
                        let channels = if list { &output.wanted } else { &output.unasked };
                        channels.iter().map(|channel| match channel == output.output {
                            true => channel.clone(),
                            false => format!("{}.{channel}", output.output),
                        })
                    })
                    .collect();
                if !names.is_empty() {
                    text.push_str(&wrap(&format!("{word} {}", names.join(", ")), 6));
                }
            }
        }
    }

    /// Appends the work that stages skip.
    fn spared(&self, text: &mut String) {
        match &self.omissions {
            Err(reason) => {
                text.push_str(
                    "\n  Work left out by footprint and frame is unknown, because the frame cannot be prepared\n",
                );
                text.push_str(&wrap(&printable(&reason.to_string()), 6));
            }
            Ok(omissions) if omissions.is_empty() => {}
            Ok(omissions) => {
                let format = self.graph.format();
                let _ = writeln!(text, "\n  Left out within nodes, at {} × {} pixels", format.width(), format.height());
                for (id, omissions) in omissions {
                    for omission in omissions {
                        let of = self.source(*id, omission).map_or(String::new(), |name| format!("of \"{name}\", "));
                        let Omission { what, count, of: all, why, .. } = omission;
                        let name = &self.graph.node(*id).name;
                        let text_of = format!("{name}: {of}{} of {} {what}: {why}", whole(*count), whole(*all));
                        text.push_str(&wrap(&printable(&text_of), 4));
                    }
                }
            }
        }
    }

    /// Appends the planes that are held over the whole picture.
    fn held(&self, text: &mut String) {
        if self.held.is_empty() {
            return;
        }
        text.push_str("\n  Filled over the whole picture first, since filters read far around tiles\n");
        for HeldPlanes { node, before, channels, bytes } in &self.held {
            let (name, what) = (&self.graph.node(*node).name, if *before { "what it reads" } else { "its result" });
            let (planes, bytes) = (if *channels == 1 { "channel" } else { "channels" }, in_bytes(*bytes as u64));
            text.push_str(&wrap(&printable(&format!("{name}: {what}, {channels} {planes}, {bytes}")), 4));
        }
    }

    /// Returns the name of the node whose work is left out, if it is connected to the node that reports the omission.
    fn source(&self, id: NodeId, omission: &Omission) -> Option<&str> {
        let (port, index) = omission.port?;
        let settled = self.graph.settle(id, self.frame);
        match settled.all(port.name()).get(index)? {
            trochoid::Source::Output { node, .. } => Some(&self.graph.node(*node).name),
            _ => None,
        }
    }

    /// Appends how the times were measured.
    fn how(&self, text: &mut String) {
        match &self.costs {
            None => {}
            Some(Err(reason)) => {
                text.push_str("\n  Not measured\n");
                text.push_str(&wrap(&printable(&reason.to_string()), 6));
            }
            Some(Ok(costs)) => {
                let (format, runs) = (costs.format, costs.runs);
                let runs = if runs == 1 { "1 run".into() } else { format!("the least of {runs} runs") };
                let (seconds, full) = (milliseconds(costs.seconds), milliseconds(costs.seconds_in_full));
                let line = format!(
                    "Measured at {} × {} pixels, {runs}: the frame takes {seconds}, and {full} with nothing left out; \
                     runs differ by {}. \
                     Times of nodes are those of all threads together; of what is left out, those with nothing left out. \
                     ≈: shared out within one program by what operations cost. —: not evaluated in either case.",
                    format.width(),
                    format.height(),
                    milliseconds(costs.spread)
                );
                text.push('\n');
                text.push_str(&wrap(&line, 2));
            }
        }
    }

    /// Returns the explanation as JSON; see the documentation of this module.
    pub(crate) fn to_json(&self) -> Value {
        let spec = &self.graph.outputs()[self.output];
        let nodes: Map<String, Value> = self
            .accounts
            .iter()
            .map(|account| {
                let node = self.graph.node(account.node);
                let cost = self.cost(account.node);
                let proof = account.proof.iter().map(|bound| {
                    json!({
                        "node": bound.node, "type": bound.ty,
                        "low": end(bound.interval.low), "high": end(bound.interval.high),
                        "evidence": evidence(bound),
                    })
                });
                let channels = account.channels.iter().map(
                    |output| json!({ "output": output.output, "wanted": output.wanted, "unasked": output.unasked }),
                );
                let value = json!({
                    "type": node.ty.declaration().name,
                    "fate": match account.fate {
                        Fate::Evaluated => "evaluated",
                        Fate::Folded => "folded",
                        Fate::PassesThrough(_) => "hands_on",
                        Fate::Merged(_) => "merged",
                        Fate::LeftOut(_) => "left_out",
                    },
                    "why": why(&account.fate),
                    "proof": proof.collect::<Vec<_>>(),
                    "channels": channels.collect::<Vec<_>>(),
                    "seconds": cost.and_then(|cost| cost.seconds),
                    "seconds_in_full": cost.and_then(|cost| cost.seconds_in_full),
                    "spread": cost.map(|cost| cost.spread),
                    "estimated": cost.map(|cost| cost.estimated),
                });
                (node.name.clone(), value)
            })
            .collect();
        let omissions = self.omissions.as_ref().map_or(Vec::new(), |omissions| {
            let each = omissions.iter().flat_map(|(id, omissions)| omissions.iter().map(move |one| (*id, one)));
            each.map(|(id, one)| {
                json!({
                    "node": self.graph.node(id).name, "of": self.source(id, one), "what": one.what,
                    "left_out": one.count, "of_all": one.of, "why": one.why,
                })
            })
            .collect()
        });
        let measured = match &self.costs {
            None => Value::Null,
            Some(Err(error)) => json!({ "error": remedies::measuring(error) }),
            Some(Ok(costs)) => json!({
                "width": costs.format.width(), "height": costs.format.height(), "samples": costs.format.samples(),
                "runs": costs.runs, "seconds": costs.seconds, "seconds_in_full": costs.seconds_in_full,
                "spread": costs.spread,
            }),
        };
        json!({
            "output": spec.name,
            "kind": spec.kind.to_string(),
            "frame": self.frame,
            "nodes": nodes,
            "omissions": omissions,
            "not_prepared": self.omissions.as_ref().err().map(ToString::to_string),
            "held": self.held.iter().map(|held| json!({
                "node": self.graph.node(held.node).name, "what": if held.before { "inputs" } else { "result" },
                "channels": held.channels, "bytes": held.bytes,
            })).collect::<Vec<_>>(),
            "measured": measured,
        })
    }
}

/// Returns the reason that a node is not evaluated.
fn why(fate: &Fate) -> Option<String> {
    Some(match fate {
        Fate::Evaluated => return None,
        Fate::Folded => "Folded: it depends on constants alone, and is one itself".into(),
        Fate::PassesThrough(from) => format!("Nothing to compute: it passes \"{from}\" through unchanged"),
        Fate::Merged(with) => format!("Computed with \"{with}\": the operations are the same"),
        Fate::LeftOut(why) => format!("Left out: {why}"),
    })
}

/// Returns a sentence with the proved interval of a node and its evidence.
fn sentence(bound: &ProofStep) -> String {
    let lies = match bound.interval.constant() {
        Some(value) => format!("is {value}"),
        None => format!("lies in {}", interval(bound.interval)),
    };
    format!("\"{}\" {lies}: {}", bound.node, evidence(bound))
}

fn evidence(bound: &ProofStep) -> String {
    match &bound.evidence {
        Evidence::Written { keyed: false } => "as written in the document".into(),
        Evidence::Written { keyed: true } => "as keyed at this frame".into(),
        Evidence::Stated => format!("a {} never leaves that", bound.ty),
        Evidence::Kind(kind) => format!("as every {kind}"),
        Evidence::Computed(from) => {
            let names: Vec<String> = from.iter().map(|name| format!("\"{name}\"")).collect();
            format!("{} of {}", bound.ty, names.join(" and "))
        }
    }
}

fn interval(Interval { low, high }: Interval) -> String {
    let end = |value: f64| match value {
        f64::INFINITY => "∞".into(),
        f64::NEG_INFINITY => "−∞".into(),
        value => value.to_string(),
    };
    format!("[{}, {}]", end(low), end(high))
}

/// Returns a number as JSON: as a string if it is infinite, since JSON has no infinity.
fn end(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}

/// Formats a count without decimals, and a mean with one decimal.
fn whole(count: f64) -> String {
    if count == count.trunc() { count.to_string() } else { format!("{count:.1}") }
}

fn milliseconds(seconds: f64) -> String {
    let ms = seconds * 1e3;
    match ms.abs() {
        size if size >= 100.0 => format!("{ms:.0} ms"),
        size if size >= 1.0 => format!("{ms:.1} ms"),
        _ => format!("{ms:.3} ms"),
    }
}
