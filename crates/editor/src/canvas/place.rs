//! Sizes and positions of nodes, including positions for nodes that the document does not place.

use super::route;
use crate::document::{Edit, Node, Point, Sheet, edit};
use egui::{Pos2, Rect, Vec2, pos2, vec2};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use trochoid::{Declaration, Item, Kind};
use trochoid_diagram::{Net, layers};

/// Minimum width of a node.
pub(super) const WIDTH: f32 = 120.0;
/// Height of the head, which shows name and type.
pub(super) const HEAD: f32 = 38.0;
/// Height of the thumbnail.
pub(super) const PICTURE: f32 = 60.0;
/// Distance between pins, if there is room.
const PIN: f32 = 17.0;
/// Margin around a node in the automatic layout.
const FREE: Vec2 = vec2(14.0, 12.0);

/// Returns whether a node has a result that a thumbnail can show.
pub(super) fn has_picture(node: &Node) -> bool {
    matches!(node.makes.first(), Some((_, Some(Kind::Color | Kind::Weights(_) | Kind::Field(_)))))
}

/// Returns the size of a node.
pub(super) fn size(node: &Node) -> Vec2 {
    vec2(width(node.pins.len().max(node.makes.len())), if has_picture(node) { HEAD + PICTURE } else { HEAD })
}

/// Returns the size that a new node of a type has at most.
pub(super) fn most_size(declaration: &Declaration) -> Vec2 {
    fn pins(items: &[Item]) -> usize {
        let count = |item: &Item| match item {
            Item::Port(_) => 1,
            Item::List(list) => list.min * pins(list.items),
            Item::Knob(_) => 0,
        };
        items.iter().map(count).sum()
    }
    let pins = pins(declaration.items).max(declaration.outputs.len());
    vec2(width(pins), HEAD + PICTURE)
}

/// Returns the width of a node with some pins at one edge.
fn width(pins: usize) -> f32 {
    WIDTH.max(pins as f32 * 13.0 + 14.0)
}

/// Returns the distance of a pin from the left end of its edge.
pub(super) fn along(index: usize, count: usize, width: f32) -> f32 {
    let step = PIN.min((width - 16.0) / (count.max(2) - 1) as f32);
    width / 2.0 + step * (index as f32 - (count as f32 - 1.0) / 2.0)
}

/// A layered layout: positions of nodes and routes of wires.
#[derive(Default)]
pub(super) struct GraphLayout {
    /// Hash of the wires and node sizes that were laid out.
    key: u64,
    /// Upper left corner of each node.
    pub(super) corners: Vec<Pos2>,
    /// Points where wires pass other layers, by wire.
    pub(super) routes: HashMap<usize, Vec<Pos2>>,
}

impl GraphLayout {
    /// Lays out all nodes of a document, unless wires and sizes are unchanged since the last layout.
    pub(super) fn update(&mut self, sheet: &Sheet) {
        let mut hasher = DefaultHasher::new();
        sheet.wires.hash(&mut hasher);
        for node in &sheet.nodes {
            let size = size(node);
            [size.x.to_bits(), size.y.to_bits()].hash(&mut hasher);
        }
        let key = hasher.finish() | 1;
        if self.key != key {
            let all: Vec<usize> = (0..sheet.nodes.len()).collect();
            *self = Self { key, ..lay(sheet, &all) };
        }
    }
}

/// Lays out some nodes in layers, with wires running down.
fn lay(sheet: &Sheet, members: &[usize]) -> GraphLayout {
    let place: HashMap<usize, usize> = members.iter().enumerate().map(|(at, node)| (*node, at)).collect();
    let boxes: Vec<[f64; 2]> = members
        .iter()
        .map(|node| {
            let size = size(&sheet.nodes[*node]) + 2.0 * FREE;
            [f64::from(size.x), f64::from(size.y)]
        })
        .collect();
    // By output: the nodes that take it, with the wires to them.
    let mut joined: BTreeMap<(usize, usize), BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
    for index in acyclic(sheet) {
        let wire = &sheet.wires[index];
        if let (Some(from), Some(to)) = (place.get(&wire.from.0), place.get(&wire.to.0)) {
            joined.entry((*from, wire.from.1)).or_default().entry(*to).or_default().push(index);
        }
    }
    let nets: Vec<Net> =
        joined.iter().map(|((from, _), to)| Net { from: *from, to: to.keys().copied().collect() }).collect();
    let layout = layers(&boxes, &nets);
    let point = |at: [f64; 2]| pos2(at[0] as f32, at[1] as f32);
    let corners: Vec<Pos2> = layout.corners.iter().map(|at| point(*at) + FREE).collect();
    let areas: Vec<Rect> =
        members.iter().zip(&corners).map(|(node, at)| Rect::from_min_size(*at, size(&sheet.nodes[*node]))).collect();
    let mut routes = HashMap::new();
    for (net, (pieces, to)) in layout.wires.iter().zip(joined.values()).enumerate() {
        // If layers are passed, the first piece is shared by all wires of the net.
        let shared = if pieces.len() > to.len() { pieces[0].as_slice() } else { &[] };
        let shared: Vec<Pos2> = shared.iter().copied().map(point).collect();
        let straight = route::straightened(&shared, &areas, net);
        for (piece, wires) in pieces.iter().skip(usize::from(!shared.is_empty())).zip(to.values()) {
            let start = piece.first().copied().map(point);
            let Some(end) = shared.iter().position(|at| Some(*at) == start).filter(|end| *end > 0) else { continue };
            let through = route::without_middles(&straight[..end]);
            routes.extend(wires.iter().map(|wire| (*wire, through.clone())));
        }
    }
    GraphLayout { key: 0, corners, routes }
}

/// Returns all wires except those that close a cycle, which an invalid document may have.
fn acyclic(sheet: &Sheet) -> Vec<usize> {
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); sheet.nodes.len()];
    for (index, wire) in sheet.wires.iter().enumerate() {
        below[wire.from.0].push(index);
    }
    // 1 while the nodes below are being visited, 2 when done.
    let mut state = vec![0_u8; sheet.nodes.len()];
    let mut kept = Vec::new();
    for root in 0..sheet.nodes.len() {
        let mut open = vec![(root, 0)];
        while let Some((node, next)) = open.pop() {
            if next == 0 && state[node] != 0 {
                continue;
            }
            state[node] = 1;
            let Some(&wire) = below[node].get(next) else {
                state[node] = 2;
                continue;
            };
            open.push((node, next + 1));
            let to = sheet.wires[wire].to.0;
            if state[to] != 1 {
                kept.push(wire);
                open.push((to, 0));
            }
        }
    }
    kept
}

/// Returns the area of each node. Nodes that the document does not place are laid out.
pub(super) fn boxes(sheet: &Sheet, laid: &mut GraphLayout) -> Vec<Rect> {
    let at = |node: &Node, at: Pos2| Rect::from_min_size(at, size(node));
    let placed = sheet.nodes.iter().filter(|node| node.placed).count();
    let mut boxes: Vec<Rect> = sheet.nodes.iter().map(|node| at(node, pos2(node.at[0], node.at[1]))).collect();
    if placed == sheet.nodes.len() {
        return boxes;
    }
    if 2 * placed < sheet.nodes.len() {
        // A few placed nodes in an otherwise unplaced document do not disturb its layout.
        laid.update(sheet);
        let laid_out = boxes.iter_mut().zip(&sheet.nodes).zip(&laid.corners).filter(|((_, node), _)| !node.placed);
        laid_out.for_each(|((own, node), corner)| *own = at(node, *corner));
        return boxes;
    }
    // The remaining nodes go next to the nodes they are connected to.
    let mut done: Vec<usize> = (0..boxes.len()).filter(|index| sheet.nodes[*index].placed).collect();
    for index in 0..boxes.len() {
        if sheet.nodes[index].placed {
            continue;
        }
        let above = sheet.wires.iter().find(|wire| wire.to.0 == index && done.contains(&wire.from.0));
        let below = sheet.wires.iter().find(|wire| wire.from.0 == index && done.contains(&wire.to.0));
        let size = boxes[index].size();
        let wanted = match (above, below) {
            (Some(wire), _) => boxes[wire.from.0].left_bottom() + vec2(0.0, 40.0),
            (None, Some(wire)) => boxes[wire.to.0].min - vec2(0.0, 40.0 + size.y),
            (None, None) => done.first().map_or(Pos2::ZERO, |first| boxes[*first].right_top() + vec2(40.0, 0.0)),
        };
        boxes[index] = free(Rect::from_min_size(wanted, size), done.iter().map(|done| boxes[*done]));
        done.push(index);
    }
    boxes
}

/// Returns the document with a place for every node: the place where it is drawn.
pub(super) fn placed(sheet: &Sheet) -> Sheet {
    let boxes = boxes(sheet, &mut GraphLayout::default());
    let mut sheet = sheet.clone();
    sheet.nodes.iter_mut().zip(&boxes).for_each(|(node, own)| node.at = own.min.into());
    sheet
}

/// Prefixes an edit with the places of all nodes, if the document does not have them.
pub(super) fn freezing(sheet: &Sheet, boxes: &[Rect], then: Edit) -> Edit {
    if sheet.nodes.iter().all(|node| node.placed) {
        return then;
    }
    let places: Vec<(String, Point)> =
        sheet.nodes.iter().zip(boxes).map(|(node, own)| (node.name.clone(), own.min.into())).collect();
    Edit { ops: [edit::laid_out(sheet, &places).ops, then.ops].concat(), ..then }
}

/// Moves a box to the right until it overlaps none of the others.
pub(super) fn free(mut wanted: Rect, others: impl Iterator<Item = Rect> + Clone) -> Rect {
    // Terminates: each of the others can be in the way only once.
    while let Some(other) = others.clone().find(|other| other.expand(8.0).intersects(wanted)) {
        wanted = wanted.translate(vec2(other.right() + 20.0 - wanted.left(), 0.0));
    }
    wanted
}

/// Returns the place nearest to the wanted one where a box overlaps none of the others.
pub(super) fn nearest(wanted: Rect, others: &[Rect]) -> Rect {
    const STEP: f32 = 20.0;
    let is_free = |place: &Rect| !others.iter().any(|other| other.expand(8.0).intersects(*place));
    // Rings around the wanted place; on each ring, below and beside come before above.
    let rings = (0..200).flat_map(|ring| {
        let points = if ring == 0 { 1 } else { 8 * ring };
        (0..points).map(move |point| {
            let angle = std::f32::consts::TAU * (point as f32 / points as f32 + 0.25);
            wanted.translate((STEP * ring as f32 * Vec2::angled(angle)).round())
        })
    });
    rings.into_iter().find(is_free).unwrap_or_else(|| free(wanted, others.iter().copied()))
}

/// Returns positions from a layered layout of the selected nodes, or of all nodes if fewer than two are selected.
pub(super) fn arrange(sheet: &Sheet, chosen: &BTreeSet<String>) -> Vec<(String, Point)> {
    let some: Vec<usize> = chosen.iter().filter_map(|name| sheet.find(name)).collect();
    let some = if some.len() < 2 { (0..sheet.nodes.len()).collect() } else { some };
    let laid = lay(sheet, &some);
    let boxes = boxes(sheet, &mut GraphLayout::default());
    let corner = |corners: &mut dyn Iterator<Item = Pos2>| corners.reduce(Pos2::min).unwrap_or_default();
    let shift = corner(&mut some.iter().map(|node| boxes[*node].min)) - corner(&mut laid.corners.iter().copied());
    let places = some.iter().zip(&laid.corners).map(|(node, at)| {
        let at = *at + shift;
        (sheet.nodes[*node].name.clone(), [at.x.round(), at.y.round()])
    });
    places.collect()
}
