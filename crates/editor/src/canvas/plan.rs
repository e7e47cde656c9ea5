//! Geometry and faults of a document as drawn, computed once per version of its text.

use super::curve::{Curve, WireShape};
use super::place::{self, GraphLayout};
use super::view::View;
use crate::document::sheet::Side;
use crate::document::{Edit, Point, Sheet, Wire, decor};
use crate::state::State;
use egui::{Pos2, Rect, Vec2, pos2};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// One end of a wire: an output or an input pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum End {
    /// Node index and output index.
    Output(usize, usize),
    /// Node index and pin index.
    Pin(usize, usize),
}

impl End {
    /// Returns the node.
    pub(super) fn node(self) -> usize {
        match self {
            Self::Output(node, _) | Self::Pin(node, _) => node,
        }
    }
}

/// Fault in a node or above it.
pub(super) struct Fault {
    /// The node at fault.
    pub(super) culprit: String,
    /// The message.
    pub(super) text: String,
}

/// Geometry of everything in a document.
pub(super) struct Plan {
    /// The document.
    pub(super) sheet: Arc<Sheet>,
    /// Area of each node.
    pub(super) boxes: Vec<Rect>,
    /// Curve of each wire.
    pub(super) curves: Vec<Curve>,
    /// Dots of each wire that the document places.
    pub(super) dots: Vec<Vec<Pos2>>,
    /// Route of each wire through the automatic layout.
    routes: HashMap<usize, Vec<Pos2>>,
    /// Bounding box of nodes and backdrops.
    pub(super) bounds: Rect,
    /// Fault to show at each node.
    pub(super) faults: HashMap<usize, Fault>,
    /// Names of the outputs that render each node.
    pub(super) makes: HashMap<usize, Vec<String>>,
    /// Nodes that no output needs, if there are outputs.
    pub(super) idle: BTreeSet<usize>,
    wire_at: HashMap<(usize, usize), usize>,
    /// Areas of the nodes without the drag in progress.
    home: Vec<Rect>,
    /// The node at which evaluation failed, and why, as of the last update of `faults`.
    broken: Option<(String, String)>,
    /// The nodes being dragged, and their offset.
    shifted: (BTreeSet<usize>, Vec2),
}

impl Plan {
    /// Computes the plan of a document.
    pub(super) fn new(state: &State, laid: &mut GraphLayout) -> Self {
        let sheet = state.sheet().clone();
        let boxes = place::boxes(&sheet, laid);
        if boxes.len() <= MOST {
            laid.update(&sheet);
        }
        let routes = routes(&sheet, &boxes, laid);
        let dots = sheet
            .wires
            .iter()
            .map(|wire| decor::dots(&sheet, wire.to).into_iter().map(|at| pos2(at[0], at[1])).collect::<Vec<Pos2>>());
        let dots: Vec<Vec<Pos2>> = dots.collect();
        let mut makes: HashMap<usize, Vec<String>> = HashMap::new();
        for output in &sheet.outputs {
            if let Some((node, _)) = sheet.source(&output.source) {
                makes.entry(node).or_default().push(output.name.clone());
            }
        }
        // What a group makes is needed by its outputs.
        let ends = sheet.nodes.iter().enumerate().filter(|(_, node)| node.side == Some(Side::Output));
        let needed = sheet.upstream(makes.keys().copied().chain(ends.map(|(index, _)| index)));
        let idle = (0..sheet.nodes.len()).filter(|node| !needed.is_empty() && !needed.contains(node)).collect();
        let mut plan = Self {
            boxes: boxes.clone(),
            curves: Vec::new(),
            dots,
            routes,
            bounds: Rect::NOTHING,
            faults: faults(state),
            broken: broken(state),
            makes,
            idle,
            wire_at: sheet.wires.iter().enumerate().map(|(index, wire)| (wire.to, index)).collect(),
            home: boxes,
            shifted: (BTreeSet::new(), Vec2::ZERO),
            sheet,
        };
        plan.curves = (0..plan.sheet.wires.len()).map(|wire| plan.curve(wire)).collect();
        plan.bounds = plan.around();
        plan
    }

    /// Updates the faults if evaluation has found a new one.
    pub(super) fn hear(&mut self, state: &State) {
        let broken = broken(state);
        if self.broken != broken {
            self.broken = broken;
            self.faults = faults(state);
        }
    }

    fn around(&self) -> Rect {
        let backdrops = self
            .sheet
            .backdrops
            .values()
            .map(|body| Rect::from_min_size(pos2(body.at[0], body.at[1]), body.size.into()));
        self.boxes.iter().copied().chain(backdrops).fold(Rect::NOTHING, Rect::union)
    }

    /// Returns the position of an end of a wire.
    pub(super) fn end(&self, end: End) -> Pos2 {
        let (area, node) = (self.boxes[end.node()], &self.sheet.nodes[end.node()]);
        match end {
            End::Output(_, output) => {
                pos2(area.left() + place::along(output, node.makes.len(), area.width()), area.bottom())
            }
            End::Pin(_, pin) => pos2(area.left() + place::along(pin, node.pins.len(), area.width()), area.top()),
        }
    }

    /// Returns the points that a wire passes through, including its ends.
    pub(super) fn points(&self, wire: usize) -> Vec<Pos2> {
        let Wire { from, to } = self.sheet.wires[wire];
        let mut points = vec![self.end(End::Output(from.0, from.1))];
        let between = if self.dots[wire].is_empty() { self.routes.get(&wire) } else { Some(&self.dots[wire]) };
        points.extend(between.into_iter().flatten());
        points.push(self.end(End::Pin(to.0, to.1)));
        points
    }

    fn curve(&self, wire: usize) -> Curve {
        let through = if self.dots[wire].is_empty() { WireShape::Down } else { WireShape::Dots };
        Curve::new(&self.points(wire), through)
    }

    /// Displays nodes at an offset while they are dragged.
    pub(super) fn shift(&mut self, nodes: &BTreeSet<usize>, by: Vec2) {
        if (&self.shifted.0, self.shifted.1) == (nodes, by) {
            return;
        }
        let mut touched: BTreeSet<usize> = std::mem::take(&mut self.shifted.0);
        touched.iter().for_each(|node| self.boxes[*node] = self.home[*node]);
        nodes.iter().for_each(|node| self.boxes[*node] = self.home[*node].translate(by));
        touched.extend(nodes);
        for wire in 0..self.curves.len() {
            let Wire { from, to } = self.sheet.wires[wire];
            if touched.contains(&from.0) || touched.contains(&to.0) {
                // A route past other nodes stays valid if both ends move together.
                let apart = nodes.contains(&from.0) != nodes.contains(&to.0);
                let route = if apart { self.routes.remove(&wire) } else { None };
                self.curves[wire] = self.curve(wire);
                if let Some(route) = route {
                    self.routes.insert(wire, route);
                }
            }
        }
        self.shifted = (nodes.clone(), by);
    }

    /// Displays a wire's dots at other places while one is dragged.
    pub(super) fn bend(&mut self, wire: usize, dots: &[Pos2]) {
        if self.dots[wire] != dots {
            self.dots[wire] = dots.to_vec();
            self.curves[wire] = self.curve(wire);
        }
    }

    /// Returns the wire that ends at a pin.
    pub(super) fn wire_at(&self, to: (usize, usize)) -> Option<usize> {
        self.wire_at.get(&to).copied()
    }

    /// Returns the wire nearest to a place, if it is within reach.
    pub(super) fn nearest_wire(&self, at: Pos2, reach: f32) -> Option<usize> {
        let near = self.curves.iter().enumerate().filter(|(_, curve)| curve.bounds.expand(reach).contains(at));
        let near = near.map(|(wire, curve)| (curve.distance(at), wire)).filter(|(distance, _)| *distance < reach);
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, wire)| wire)
    }

    /// Returns the topmost node at a place.
    pub(super) fn node_at(&self, at: Pos2) -> Option<usize> {
        self.boxes.iter().rposition(|area| area.contains(at))
    }

    /// Returns the end of a wire nearest to a place, if it is within reach.
    pub(super) fn end_at(&self, at: Pos2, reach: f32) -> Option<End> {
        let near = (0..self.boxes.len()).filter(|node| self.boxes[*node].expand(reach).contains(at));
        let ends = near.flat_map(|node| {
            let pins = (0..self.sheet.nodes[node].pins.len()).map(move |pin| End::Pin(node, pin));
            pins.chain((0..self.sheet.nodes[node].makes.len()).map(move |output| End::Output(node, output)))
        });
        let ends = ends.map(|end| (self.end(end).distance(at), end)).filter(|(distance, _)| *distance < reach);
        ends.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
    }

    /// Returns the bounding box of the named nodes, or of everything if none is named.
    pub(super) fn area(&self, names: &BTreeSet<String>) -> Option<Rect> {
        let some = names.iter().filter_map(|name| Some(self.boxes[self.sheet.find(name)?]));
        some.reduce(Rect::union).or(self.bounds.is_finite().then_some(self.bounds))
    }

    /// Returns the place of a node, in the form documents store.
    pub(super) fn corner(&self, node: usize) -> Point {
        self.boxes[node].min.into()
    }

    /// Returns an edit that keeps nodes where they are drawn: it first writes all places, if the document does not have
    /// them.
    pub(super) fn freezing(&self, then: Edit) -> Edit {
        place::freezing(&self.sheet, &self.home, then)
    }

    /// Returns the name of a wire's end for screen readers.
    pub(super) fn spoken(&self, end: End) -> String {
        let node = &self.sheet.nodes[end.node()];
        match end {
            End::Output(_, 0) => format!("Output of {}", node.called()),
            End::Output(_, output) => format!("Output {} of {}", node.makes[output].0, node.name),
            End::Pin(_, pin) => format!("Input {} of {}", node.pins[pin].label, node.called()),
        }
    }

    /// Returns whether any part of a node is in the viewport.
    pub(super) fn is_seen(&self, node: usize, view: &View) -> bool {
        view.seen().expand(24.0 / view.zoom).intersects(self.boxes[node])
    }
}

/// Documents with more nodes are laid out only if they do not place their nodes.
const MOST: usize = 300;

/// Returns routes for wires whose ends have the same relative position as in the layout.
fn routes(sheet: &Sheet, boxes: &[Rect], laid: &GraphLayout) -> HashMap<usize, Vec<Pos2>> {
    if laid.corners.len() != boxes.len() {
        return HashMap::new();
    }
    let kept = laid.routes.iter().filter_map(|(index, through)| {
        let wire = sheet.wires.get(*index)?;
        let [from, to] = [wire.from.0, wire.to.0].map(|node| boxes[node].min - laid.corners[node]);
        let together = (from - to).abs().max_elem() < 2.0;
        together.then(|| (*index, through.iter().map(|at| *at + from).collect()))
    });
    kept.collect()
}

/// Returns the node at which evaluation failed, and why.
fn broken(state: &State) -> Option<(String, String)> {
    let (node, why) = state.broken()?;
    Some((state.own_name(node?)?.into(), why.into()))
}

/// Returns the fault to show at each node.
fn faults(state: &State) -> HashMap<usize, Fault> {
    let sheet = state.sheet();
    let own = state.session.meaning().errors().filter_map(|error| sheet.find(state.own_name(error.node.as_deref()?)?));
    let below = sheet.downstream(own.collect::<BTreeSet<usize>>());
    let faults = below.into_iter().filter_map(|node| {
        let (culprit, fault) = state.fault_of(node)?;
        let mut text = format!("found {}; expected {}", fault.found, fault.expected);
        if let Some(port) = &fault.port {
            text = format!("{port}: {text}");
        }
        if !fault.remedy.is_empty() {
            text = format!("{text}\n{}", fault.remedy);
        }
        Some((node, Fault { culprit: culprit.into(), text }))
    });
    let mut faults: HashMap<usize, Fault> = faults.collect();
    if let Some((culprit, text)) = broken(state)
        && let Some(node) = sheet.find(&culprit)
    {
        for node in sheet.downstream([node]) {
            faults.entry(node).or_insert_with(|| Fault { culprit: culprit.clone(), text: text.clone() });
        }
    }
    faults
}
