//! Draws a graph as SVG.

use crate::boxes::{Groups, Members, boxes};
use crate::layers::{Net, Point, layers};
use crate::palette::{Swatch, color_name, controls, palette};
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Path, Rectangle, Text, Title};
use svg::{Document, Node as _};
use trochoid_graph::{CheckedGraph, End, GroupUse, Kind, NodeId, OutputSpec, Source};

const MARGIN: f64 = 28.0;
const PADDING: f64 = 12.0;
const NAME: f64 = 13.0;
const TYPE: f64 = 11.0;
/// Side of a swatch in a box, in pixels, and number of swatches per row.
const SWATCH: f64 = 12.0;
const IN_A_ROW: usize = 12;
/// Side of a swatch below the graph, and height of its label, in pixels.
const CONTROL: f64 = 44.0;
const LABEL: f64 = 16.0;
/// Height of the line with a color's name, and the size of its letters.
const NAMED: f64 = 11.0;
const SMALL: f64 = 9.5;

const PAPER: &str = "#f6f3ec";
const CARD: &str = "#fffdf8";
const LINE: &str = "#cbc4b6";
const INK: &str = "#22303a";
const GRAY: &str = "#6d747a";
const FRONT: &str = "#5a86a3";
const BACK: &str = "#c1844d";
const SANS: &str = "Inter, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";

/// A box of the diagram: a node or an output.
struct Card {
    name: String,
    kind: String,
    stripe: &'static str,
    swatches: Vec<Swatch>,
    title: String,
    dim: bool,
    /// Whether it stands for several nodes, so that it is drawn with an edge of another one behind it.
    stacked: bool,
    size: [f64; 2],
}

impl Card {
    fn new(name: &str, kind: String, stripe: &'static str, swatches: Vec<Swatch>, title: String, dim: bool) -> Self {
        let name = printable(name);
        let columns = swatches.len().min(IN_A_ROW) as f64;
        let rows = swatches.len().div_ceil(IN_A_ROW) as f64;
        let text = (width(&name) * NAME).max(width(&kind) * TYPE).max(columns * SWATCH);
        let below = if rows > 0.0 { rows * SWATCH + 6.0 } else { 0.0 };
        Self { kind, stripe, swatches, title, dim, stacked: false, size: [text + 2.0 * PADDING, 42.0 + below], name }
    }

    fn node(graph: &CheckedGraph, id: NodeId, left_out: Option<&str>) -> Self {
        let node = graph.node(id);
        let declaration = node.ty.declaration();
        let stripe = if declaration.end == End::Front { FRONT } else { BACK };
        let why = left_out.map_or(String::new(), |why| format!("\nLeft out: {why}"));
        let title = format!("{} ({}): {}{why}", node.name, declaration.name, declaration.summary);
        Self::new(&node.name, declaration.name.into(), stripe, controls(graph, id), title, left_out.is_some())
    }

    fn used(graph: &CheckedGraph, used: &GroupUse, nodes: &[NodeId], left_out: &[Option<String>]) -> Self {
        let is_front = |node: &NodeId| graph.node(*node).ty.declaration().end == End::Front;
        let stripe = if nodes.iter().all(is_front) { FRONT } else { BACK };
        let mut swatches: Vec<Swatch> = Vec::new();
        for swatch in nodes.iter().flat_map(|node| controls(graph, *node)) {
            if !swatches.contains(&swatch) {
                swatches.push(swatch);
            }
        }
        let count = match nodes.len() {
            1 => "1 node".into(),
            count => format!("{count} nodes"),
        };
        let names: Vec<&str> = nodes.iter().map(|node| graph.node(*node).name.as_str()).collect();
        let title = format!("{} (group {}): {}", used.path, used.group, names.join(", "));
        let dim = nodes.iter().all(|node| left_out[node.0].is_some());
        Self {
            stacked: true,
            ..Self::new(&used.path, format!("{} · {count}", used.group), stripe, swatches, title, dim)
        }
    }

    fn output(spec: &OutputSpec) -> Self {
        let required = spec.require.map_or(String::new(), |require| format!(", within the {}", require.name()));
        let title = format!("Output {}: {}{required}", spec.name, spec.kind);
        Self::new(&spec.name, format!("output{required}"), INK, Vec::new(), title, false)
    }

    fn draw(&self, corner: Point) -> Group {
        let [x, y] = [corner[0] + MARGIN, corner[1] + MARGIN];
        let frame = Rectangle::new().set("x", x).set("y", y).set("rx", 6);
        let frame = frame.set("width", self.size[0]).set("height", self.size[1]).set("fill", CARD).set("stroke", LINE);
        let stripe = Rectangle::new().set("x", x).set("y", y + 6.0).set("width", 3);
        let stripe = stripe.set("height", self.size[1] - 12.0).set("fill", self.stripe);
        let name = text(&self.name, [x + PADDING, y + 18.0], NAME, INK).set("font-weight", 600);
        let kind = text(&self.kind, [x + PADDING, y + 33.0], TYPE, GRAY);
        let mut group = Group::new();
        if self.dim {
            group = group.set("opacity", 0.42);
        }
        group = group.add(Title::new(printable(&self.title)));
        if self.stacked {
            let behind = Rectangle::new().set("x", x + 4.0).set("y", y + 4.0).set("rx", 6).set("width", self.size[0]);
            group = group.add(behind.set("height", self.size[1]).set("fill", CARD).set("stroke", LINE));
        }
        group = group.add(frame).add(stripe).add(name).add(kind);
        for (index, swatch) in self.swatches.iter().enumerate() {
            let at = [(index % IN_A_ROW) as f64, (index / IN_A_ROW) as f64];
            let square = Rectangle::new().set("x", x + PADDING + at[0] * SWATCH).set("y", y + 40.0 + at[1] * SWATCH);
            let square = square.set("width", SWATCH - 1.0).set("height", SWATCH - 1.0);
            group.append(square.set("fill", swatch.to_string()).set("stroke", LINE).set("stroke-width", 0.5));
        }
        group
    }
}

/// Draws a graph as SVG: sources at the top, outputs at the bottom, control colors below.
///
/// `outputs` selects the outputs to show, by index, with everything connected to them; if empty, all nodes and outputs
/// are shown, and of groups what `groups` says. `left_out` gives, for each node, the reason why it is not evaluated, if any; such nodes are drawn pale.
/// Wires are colored by the kind of data on them.
///
/// # Panics
/// Panics if an output index is out of range or `left_out` has fewer entries than there are nodes.
pub fn tree(graph: &CheckedGraph, outputs: &[usize], left_out: &[Option<String>], groups: Groups<'_>) -> String {
    let all: Vec<usize> = (0..graph.outputs().len()).collect();
    let chosen = if outputs.is_empty() { &all } else { outputs };
    let roots = chosen.iter().map(|&index| graph.outputs()[index].node);
    let mut shown = if outputs.is_empty() { vec![true; graph.nodes().len()] } else { graph.upstream(roots) };
    let inside = if let Groups::Inside(path) = groups { Some(path) } else { None };
    if let Some(path) = inside {
        shown = around(graph, path);
    }

    let mut cards = Vec::new();
    let mut card_of = vec![None; graph.nodes().len()];
    for members in boxes(graph, &shown, groups) {
        members.nodes().iter().for_each(|node| card_of[node.0] = Some(cards.len()));
        let mut card = match &members {
            Members::One(node) => Card::node(graph, *node, left_out[node.0].as_deref()),
            Members::Use(index, nodes) => Card::used(graph, &graph.groups()[*index], nodes, left_out),
        };
        card.dim |= inside.is_some_and(|path| !is_within(&graph.node(members.nodes()[0]).name, path));
        cards.push(card);
    }
    let mut wires = Wires::default();
    for (index, card) in card_of.iter().enumerate() {
        for source in card.iter().flat_map(|_| graph.node(NodeId(index)).record.sources()) {
            if let (Source::Output { node, output }, Some(to)) = (source, *card)
                && card_of[node.0] != *card
            {
                wires.join(&card_of, *node, *output, to);
            }
        }
    }
    let chosen = if inside.is_some() { &[][..] } else { chosen };
    for spec in chosen.iter().map(|&index| &graph.outputs()[index]) {
        wires.join(&card_of, spec.node, spec.output, cards.len());
        cards.push(Card::output(spec));
    }
    let sizes: Vec<[f64; 2]> = cards.iter().map(|card| card.size).collect();
    let layout = layers(&sizes, &wires.nets);

    let mut lines = Group::new().set("fill", "none").set("stroke-width", 1.6).set("stroke-linecap", "round");
    let mut pins = Group::new();
    for (pieces, (node, output)) in layout.wires.iter().zip(&wires.ends) {
        let checked = graph.node(*node);
        let (kind, names) = (checked.kinds[*output], checked.ty.declaration().outputs);
        let name = names.get(*output).map_or("", |output| output.name);
        let mut group = Group::new().set("stroke", color(kind));
        group.append(Title::new(printable(&format!("{}.{name}: {kind}", checked.name))));
        for piece in pieces {
            group.append(Path::new().set("d", curve(piece)));
        }
        lines.append(group);
        // Pieces of two points lead to boxes; longer ones are trunks that end between layers.
        let tops = pieces.iter().filter(|piece| piece.len() == 2).map(|piece| piece[1]);
        for [x, y] in tops.chain(pieces.iter().flat_map(|piece| piece.first()).take(1).copied()) {
            pins.append(dot([x + MARGIN, y + MARGIN], color(kind)));
        }
    }
    // Control colors of nodes that are not evaluated are not part of the palette.
    let evaluated: Vec<bool> = shown.iter().zip(left_out).map(|(shown, why)| *shown && why.is_none()).collect();
    let controls: Vec<(Swatch, Option<&str>)> =
        palette(graph, &evaluated).into_iter().map(|swatch| (swatch, color_name(graph, swatch))).collect();
    let width = (layout.size[0]).max(8.0 * CONTROL) + 2.0 * MARGIN;
    let (below, height) = swatches(&controls, width, layout.size[1] + 2.0 * MARGIN);
    let paper = Rectangle::new().set("width", width).set("height", height).set("fill", PAPER);
    let mut document = Document::new().set("width", width.ceil()).set("height", height.ceil());
    document = document.set("viewBox", (0, 0, width.ceil(), height.ceil())).set("font-family", SANS);
    document = document.add(Title::new(printable(graph.name()))).add(paper).add(lines);
    for (card, corner) in cards.iter().zip(&layout.corners) {
        document = document.add(card.draw(*corner));
    }
    format!("{}\n", document.add(pins).add(below))
}

/// Whether a node is within the use with a path.
fn is_within(name: &str, path: &str) -> bool {
    name.strip_prefix(path).is_some_and(|rest| rest.starts_with('/'))
}

/// Returns the nodes of a use, and those that lead into it.
fn around(graph: &CheckedGraph, path: &str) -> Vec<bool> {
    let within: Vec<bool> = graph.nodes().iter().map(|node| is_within(&node.name, path)).collect();
    let mut shown = within.clone();
    for (node, _) in graph.nodes().iter().zip(&within).filter(|(_, within)| **within) {
        for source in node.record.sources() {
            if let Source::Output { node, .. } = source {
                shown[node.0] = true;
            }
        }
    }
    shown
}

/// Nets of a graph, with the node output at which each begins.
#[derive(Default)]
struct Wires {
    nets: Vec<Net>,
    ends: Vec<(NodeId, usize)>,
}

impl Wires {
    fn join(&mut self, card_of: &[Option<usize>], node: NodeId, output: usize, to: usize) {
        let Some(from) = card_of[node.0] else { return };
        let end = (node, output);
        let index = self.ends.iter().position(|known| *known == end).unwrap_or_else(|| {
            self.ends.push(end);
            self.nets.push(Net { from, to: Vec::new() });
            self.nets.len() - 1
        });
        if !self.nets[index].to.contains(&to) {
            self.nets[index].to.push(to);
        }
    }
}

/// Returns the color of wires that carry a kind.
fn color(kind: Kind) -> &'static str {
    match kind {
        Kind::Color | Kind::Layers(_) => "#d08a2e",
        Kind::Weights(_) => "#3f9a76",
        Kind::Field(_) => "#4a7fc1",
        Kind::View => "#8a6bb0",
        Kind::Surface => "#7d8790",
        Kind::Camera | Kind::Light => "#b9b2a3",
    }
}

/// Returns a path that is straight across layers and curved between them.
fn curve(points: &[Point]) -> Data {
    let at = |point: Point| (point[0] + MARGIN, point[1] + MARGIN);
    let mut data = Data::new().move_to(at(points[0]));
    for two in points.windows(2) {
        let (from, to) = (two[0], two[1]);
        let middle = (from[1] + to[1]) / 2.0;
        data = if from[0] == to[0] {
            data.line_to(at(to))
        } else {
            data.cubic_curve_to((at([from[0], middle]), at([to[0], middle]), at(to)))
        };
    }
    data
}

fn dot(at: Point, fill: &str) -> Circle {
    Circle::new().set("cx", at[0]).set("cy", at[1]).set("r", 2.6).set("fill", fill)
}

/// Draws the control colors with their names in rows below `top`; also returns the bottom of the rows.
fn swatches(controls: &[(Swatch, Option<&str>)], width: f64, top: f64) -> (Group, f64) {
    let mut group = Group::new();
    if controls.is_empty() {
        return (group, top);
    }
    let count = match controls.len() {
        1 => "1 control color".into(),
        count => format!("{count} control colors"),
    };
    group.append(text(&count, [MARGIN, top + 8.0], TYPE, GRAY));
    let columns = (((width - 2.0 * MARGIN) / (CONTROL + 8.0)) as usize).max(1);
    let label = if controls.iter().any(|(_, name)| name.is_some()) { LABEL + NAMED } else { LABEL };
    for (index, (swatch, name)) in controls.iter().enumerate() {
        let x = MARGIN + (index % columns) as f64 * (CONTROL + 8.0);
        let y = top + 18.0 + (index / columns) as f64 * (CONTROL + label + 6.0);
        let square = Rectangle::new().set("x", x).set("y", y).set("rx", 4).set("width", CONTROL).set("height", CONTROL);
        let square = square.set("fill", swatch.to_string()).set("stroke", LINE);
        group.append(text(&swatch.to_string(), [x, y + CONTROL + 11.0], SMALL, GRAY));
        match name {
            Some(name) => {
                group.append(square.add(Title::new(*name)));
                // The whole name appears where the pointer rests.
                group.append(text(&fitting(name, CONTROL + 6.0, SMALL), [x, y + CONTROL + 11.0 + NAMED], SMALL, INK));
            }
            None => group.append(square),
        }
    }
    let rows = controls.len().div_ceil(columns) as f64;
    (group, top + 18.0 + rows * (CONTROL + label + 6.0) + MARGIN / 2.0)
}

/// Shortens a text to a width.
fn fitting(content: &str, limit: f64, size: f64) -> String {
    if width(content) * size <= limit {
        return content.into();
    }
    let mut short = String::new();
    for c in content.chars() {
        if width(&short) * size + size > limit {
            break;
        }
        short.push(c);
    }
    short + "…"
}

fn text(content: &str, at: Point, size: f64, fill: &str) -> Text {
    Text::new(content).set("x", at[0]).set("y", at[1]).set("font-size", size).set("fill", fill)
}

/// Estimates the width of a text relative to its font size, for a typical sans serif; it affects only the sizes of
/// boxes.
fn width(text: &str) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | '\'' | '|' => 0.3,
        'f' | 'r' | 't' | ' ' => 0.4,
        'm' | 'w' => 0.9,
        'M' | 'W' => 0.95,
        'A'..='Z' => 0.7,
        c if c.is_ascii() => 0.6,
        _ => 1.0,
    };
    text.chars().map(em).sum()
}

/// Replaces control characters, which XML does not allow, and truncates texts that would widen the diagram too much.
fn printable(text: &str) -> String {
    let mut shown: String =
        text.chars().take(400).map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect();
    if text.chars().count() > 400 {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_any_kind_stay_text() {
        assert_eq!(printable("a\u{1}<b>"), "a\u{fffd}<b>");
        assert_eq!(printable(&"x".repeat(500)).chars().count(), 401);
        let drawn = text("<b> & \"c\"", [0.0, 0.0], 1.0, INK).to_string();
        assert!(drawn.contains("&lt;b&gt; &amp;"), "{drawn}");
    }

    #[test]
    fn wires_of_a_kind_have_a_color() {
        let kinds = [Kind::Color, Kind::MASK, Kind::Field(1), Kind::View, Kind::Surface, Kind::Camera];
        let colors: std::collections::HashSet<_> = kinds.map(color).into_iter().collect();
        assert_eq!(colors.len(), kinds.len());
    }
}
