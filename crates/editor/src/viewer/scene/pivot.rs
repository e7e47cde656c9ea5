//! The point about which the camera moves: what is seen at a place in the picture.

use super::Seen;
use super::eye::{Eye, Pose};
use super::gizmo::knobs;
use super::water::level;
use egui::{Pos2, vec2};
use glam::DVec3;
use trochoid::{CheckedGraph, Item, NodeId, Placing, Role, Settled, Source, Values};

/// Farthest point of the sea about which the camera moves, in distances to its target: beyond, near the horizon, it would
/// fly.
const FAR: f64 = 4.0;
/// Distance in the picture within which a thing is meant, as a share of the width. Places are known, but not outlines.
const NEAR: f32 = 0.1;

/// Returns the point that is seen at a place in the picture: as far away as the thing there, or on the sea, whatever is
/// nearer; or else as far away as the camera's target.
pub(super) fn at(seen: &Seen, pose: &Pose, at: Pos2) -> DVec3 {
    let eye = Eye::new(pose, seen.aspect);
    let far = FAR * pose.position.distance(pose.target).max(1e-3);
    let on_sea = seen.level.and_then(|level| eye.on_level(at, level));
    let on_sea = on_sea.filter(|point| eye.orthographic || point.distance(pose.position) <= far);
    let is_meant = |thing: &&DVec3| {
        let off = eye.project(**thing).map(|place| (place - at) * vec2(1.0, 1.0 / seen.aspect as f32));
        off.is_some_and(|off| off.length() <= NEAR)
    };
    let things = seen.things.iter().filter(is_meant).filter_map(|thing| eye.beside(at, *thing));
    let ahead = |point: &DVec3| (*point - pose.position).dot(eye.forward);
    let nearest = things.chain(on_sea).min_by(|a, b| ahead(a).total_cmp(&ahead(b)));
    nearest.or_else(|| eye.beside(at, pose.target)).unwrap_or(pose.target)
}

/// Returns where the surfaces stand that a view shows, as far as knobs place them.
pub(super) fn things(graph: &CheckedGraph, view: NodeId, frame: i64) -> Vec<DVec3> {
    let sources = |settled: &Settled| -> Vec<NodeId> {
        let all = settled.sources().into_iter();
        all.filter_map(|source| if let Source::Output { node, .. } = source { Some(*node) } else { None }).collect()
    };
    let mut open = sources(&graph.settle(view, frame));
    let (mut reached, mut found) = (vec![false; graph.nodes().len()], Vec::new());
    while let Some(id) = open.pop() {
        let ty = graph.node(id).ty.declaration();
        let is_shown = !matches!(ty.role, Some(Role::Camera | Role::Light));
        if std::mem::replace(&mut reached[id.0], true) || !is_shown {
            continue;
        }
        let settled = graph.settle(id, frame);
        let rest = || level(graph, id, frame).unwrap_or(0.0);
        let lists = ty.items.iter().filter_map(|item| if let Item::List(list) = item { Some(list) } else { None });
        let own = point(ty.items, &settled, &rest).into_iter().chain(lists.flat_map(|list| {
            settled.list(list.name).iter().filter_map(|record| point(list.items, record, &rest)).collect::<Vec<_>>()
        }));
        let before = found.len();
        found.extend(own);
        // What is placed again, such as a model that floats, is not where its own knobs say.
        if found.len() == before {
            open.extend(sources(&settled));
        }
    }
    found
}

/// Returns the point at which the knobs of one record place something.
fn point(items: &'static [Item], values: &Values, rest: &dyn Fn() -> f64) -> Option<DVec3> {
    let (mut x, mut y, mut z, mut lift) = (None, None, None, 0.0);
    for knob in knobs(items) {
        match knob.places {
            Some(Placing::Position) => {
                let place = values.vector3(knob.name);
                [x, y, z] = place.map(Some);
            }
            Some(Placing::X) => x = Some(values.number(knob.name)),
            Some(Placing::Z) => z = Some(values.number(knob.name)),
            Some(Placing::Lift) => lift = values.number(knob.name),
            _ => {}
        }
    }
    Some(DVec3::new(x?, y.unwrap_or_else(|| rest() + lift), z?))
}
