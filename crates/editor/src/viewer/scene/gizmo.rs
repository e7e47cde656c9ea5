//! What of the selected nodes stands somewhere in the world, found by what their knobs declare to place.

use super::water::{Water, level};
use crate::document::Step;
use crate::document::group::{NotWritten, Written};
use crate::state::State;
use glam::DVec3;
use std::sync::Arc;
use trochoid::{CheckedGraph, Item, Knob, KnobType, NodeId, Placing, Role, Settled, Values};

/// Maximum number of things that are shown at once.
const MOST: usize = 64;

/// A number that a handle changes.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    /// Value at the present frame.
    pub(super) value: f64,
    /// Where it is written.
    pub(super) place: Result<Written, NotWritten>,
}

impl Slot {
    /// Whether the number follows a formula.
    pub(super) fn is_linked(&self) -> bool {
        matches!(self.place, Err(NotWritten::Linked { .. }))
    }
}

/// Something in the world.
#[derive(Clone, Debug)]
pub(super) struct Gizmo {
    /// Name of what it belongs to.
    pub(super) title: String,
    /// Where it is.
    pub(super) at: DVec3,
    /// Where the thing is whose target it is.
    pub(super) of: Option<DVec3>,
    /// Its x, its height, and its z, as far as knobs set them.
    pub(super) axes: [Option<Slot>; 3],
    /// Its rotation about y in degrees, and whether that turns +X toward +Z.
    pub(super) turn: Option<(Slot, bool)>,
    /// Its scale factors.
    pub(super) scale: Vec<Slot>,
    /// The direction toward it, if it is infinitely far away.
    pub(super) direction: Vec<Slot>,
}

impl Gizmo {
    /// Returns the numbers that can be changed.
    fn slots(&self) -> impl Iterator<Item = &Slot> {
        let turn = self.turn.iter().map(|(turn, _)| turn);
        self.axes.iter().flatten().chain(turn).chain(&self.scale).chain(&self.direction)
    }

    /// Returns the direction toward it, if it is infinitely far away.
    pub(super) fn toward(&self) -> Option<DVec3> {
        let [x, y, z] = self.direction.as_slice() else { return None };
        Some(DVec3::new(x.value, y.value, z.value))
    }

    /// Leaves out what no knob of a use sets.
    fn within(mut self, state: &State, name: &str) -> Option<Self> {
        let root = state.session.sheet();
        let own = crate::document::group::definition_path(root, &state.whole_name(name));
        let is_own = |slot: &Slot| {
            let path = match &slot.place {
                Ok(written) => Some(&written.path),
                // What the use links to something else has a handle that says so.
                Err(NotWritten::Linked { at, .. }) => at.as_ref(),
                Err(_) => None,
            };
            path.zip(own.as_ref()).is_some_and(|(path, own)| path.0.starts_with(&own.0))
        };
        for axis in &mut self.axes {
            axis.take_if(|slot| !is_own(slot));
        }
        self.turn.take_if(|(turn, _)| !is_own(turn));
        for all in [&mut self.scale, &mut self.direction] {
            if !all.iter().all(is_own) {
                all.clear();
            }
        }
        self.slots().next()?;
        Some(self)
    }

    /// Whether two handles would change the same numbers.
    fn is_like(&self, other: &Self) -> bool {
        let same = |(a, b): (&Slot, &Slot)| match (&a.place, &b.place) {
            (Ok(a), Ok(b)) => a.is_at(b),
            (Err(NotWritten::Linked { at: a, .. }), Err(NotWritten::Linked { at: b, .. })) => a == b,
            _ => false,
        };
        self.slots().count() == other.slots().count() && self.slots().zip(other.slots()).all(same)
    }
}

/// Returns what the selected nodes have in the world, at the present frame.
pub(super) fn gizmos(state: &State, graph: &Arc<CheckedGraph>, water: &mut Water) -> Vec<Gizmo> {
    let mut all: Vec<Gizmo> = Vec::new();
    for name in &state.selection {
        let Some(node) = state.sheet().node(name) else { continue };
        let whole = state.whole_name(name);
        if !node.is_use {
            let Some(id) = graph.find(&whole) else { continue };
            all.extend(Finder { state, graph, id, water }.all(name));
            continue;
        }
        let inside = format!("{whole}/");
        let mut own: Vec<Gizmo> = Vec::new();
        for (index, node) in graph.nodes().iter().enumerate() {
            let Some(inner) = node.name.strip_prefix(&inside) else { continue };
            let (title, id) = (format!("{name}: {}", inner.replace('/', ".")), NodeId(index));
            for gizmo in (Finder { state, graph, id, water }).all(&title) {
                let Some(gizmo) = gizmo.within(state, name) else { continue };
                if !own.iter().any(|known| known.is_like(&gizmo)) {
                    own.push(gizmo);
                }
            }
        }
        if let [only] = own.as_mut_slice() {
            only.title.clone_from(name);
        }
        all.extend(own);
    }
    all.truncate(MOST);
    all
}

pub(super) fn knobs(items: &'static [Item]) -> impl Iterator<Item = &'static Knob> {
    items.iter().filter_map(|item| if let Item::Knob(knob) = item { Some(knob) } else { None })
}

/// Finds what a node has in the world.
struct Finder<'s> {
    state: &'s State,
    graph: &'s Arc<CheckedGraph>,
    id: NodeId,
    water: &'s mut Water,
}

impl Finder<'_> {
    fn all(&mut self, title: &str) -> Vec<Gizmo> {
        let node = self.graph.node(self.id);
        let items = node.ty.declaration().items;
        let places = |items: &'static [Item]| knobs(items).any(|knob| knob.places.is_some());
        let lists: Vec<_> =
            items.iter().filter_map(|item| if let Item::List(list) = item { Some(list) } else { None }).collect();
        let lists: Vec<_> = lists.into_iter().filter(|list| places(list.items)).collect();
        if node.disabled || (!places(items) && lists.is_empty()) {
            return Vec::new();
        }
        let settled = self.graph.settle(self.id, self.state.frame);
        let mut all = self.record(title, items, &settled, &[], &|placing| counts(&settled, placing));
        for list in lists {
            for (index, record) in settled.list(list.name).iter().enumerate().take(MOST) {
                let steps = [Step::from(list.name), Step::from(index)];
                let title = format!("{title}.{}[{index}]", list.name);
                all.extend(self.record(&title, list.items, record, &steps, &|_| true));
            }
        }
        all
    }

    /// Returns what the knobs of one record place.
    fn record(
        &mut self,
        title: &str,
        items: &'static [Item],
        values: &Values,
        steps: &[Step],
        counts: &dyn Fn(Placing) -> bool,
    ) -> Vec<Gizmo> {
        let empty = |title: &str, at: DVec3| Gizmo {
            title: title.into(),
            at,
            of: None,
            axes: [None, None, None],
            turn: None,
            scale: Vec::new(),
            direction: Vec::new(),
        };
        let (mut body, mut others) = (empty(title, DVec3::ZERO), Vec::new());
        let mut lift = None;
        for knob in knobs(items) {
            let Some(placing) = knob.places.filter(|placing| counts(*placing)) else { continue };
            let mut slots = self.slots(knob, values, steps).into_iter();
            let point = |mut slots: std::vec::IntoIter<Slot>| match slots.len() {
                // On the ground.
                2 => [slots.next(), None, slots.next()],
                _ => [slots.next(), slots.next(), slots.next()],
            };
            match placing {
                Placing::Position => body.axes = point(slots),
                Placing::Target => {
                    let mut target = empty(&format!("{title}.{}", knob.name), DVec3::ZERO);
                    target.axes = point(slots);
                    others.push(target);
                }
                Placing::Direction => {
                    let mut far = empty(&format!("{title}.{}", knob.name), DVec3::ZERO);
                    far.direction = slots.collect();
                    others.push(far);
                }
                Placing::X => body.axes[0] = slots.next(),
                Placing::Z => body.axes[2] = slots.next(),
                Placing::Level => body.axes[1] = slots.next(),
                Placing::Lift => lift = slots.next(),
                Placing::Heading => body.turn = slots.next().map(|turn| (turn, true)),
                Placing::Rotation => body.turn = slots.nth(1).map(|turn| (turn, false)),
                Placing::Scale => body.scale = slots.collect(),
            }
        }
        // A direction or a height alone is nowhere.
        if body.axes[0].is_some() && body.axes[2].is_some() {
            others.insert(0, body);
        }
        for gizmo in &mut others {
            gizmo.at =
                DVec3::from_array(gizmo.axes.each_ref().map(|slot| slot.as_ref().map_or(0.0, |slot| slot.value)));
            if gizmo.axes[1].is_some() || !gizmo.direction.is_empty() {
                continue;
            }
            let (graph, frame) = (self.graph, self.state.frame);
            match lift.take() {
                Some(lift) => {
                    gizmo.at.y = self.water.height(graph, self.id, frame, [gizmo.at.x, gizmo.at.z]) + lift.value;
                    gizmo.axes[1] = Some(lift);
                }
                None => gizmo.at.y = level(graph, self.id, frame).unwrap_or(0.0),
            }
        }
        if let [body, others @ ..] = others.as_mut_slice() {
            others.iter_mut().filter(|other| other.direction.is_empty()).for_each(|other| other.of = Some(body.at));
        }
        others
    }

    /// Returns the numbers of a knob.
    fn slots(&self, knob: &Knob, values: &Values, steps: &[Step]) -> Vec<Slot> {
        let root = self.state.session.sheet();
        let name = &self.graph.node(self.id).name;
        let (count, present) = match knob.takes {
            KnobType::Vector(count) => (count, values.vector3(knob.name)[..count.min(3)].to_vec()),
            _ => (1, vec![values.number(knob.name)]),
        };
        let is_vector = matches!(knob.takes, KnobType::Vector(_));
        let slot = |(index, value): (usize, &f64)| {
            let component = is_vector.then_some(index);
            Slot { value: *value, place: Written::find(root, name, steps, knob, component, &present) }
        };
        present.iter().take(count).enumerate().map(slot).collect()
    }
}

/// Returns whether a node uses what one of its knobs places: lights use other knobs for each of their kinds.
fn counts(settled: &Settled, placing: Placing) -> bool {
    if settled.ty().declaration().role != Some(Role::Light) {
        return true;
    }
    match settled.text("kind") {
        "directional" => placing == Placing::Direction,
        "spot" => placing != Placing::Direction,
        _ => placing == Placing::Position,
    }
}
