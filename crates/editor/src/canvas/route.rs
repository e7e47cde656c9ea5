//! Straightening of wires that pass layers of nodes: they run straight down as far as nothing is in the way.

use egui::{Pos2, Rect, pos2};

/// Distance between a wire and the nodes that it passes.
const BESIDE: f32 = 12.0;
/// Distance between wires that would run along the same nodes.
const LANE: f32 = 6.0;
/// Number of lanes before the first is reused.
const LANES: usize = 5;

/// Removes needless bends from a wire that starts at the first point and passes one layer with every two further
/// points. The result leaves the first point out.
pub(super) fn straightened(wire: &[Pos2], boxes: &[Rect], nth: usize) -> Vec<Pos2> {
    let Some((start, layers)) = wire.split_first() else { return Vec::new() };
    let rooms: Vec<[f32; 2]> = layers.chunks_exact(2).map(|ends| room(ends[0], ends[1], boxes)).collect();
    let lane = LANE * (nth % LANES) as f32;
    let mut straight = Vec::with_capacity(layers.len());
    let mut x = start.x;
    let mut first = 0;
    while first < rooms.len() {
        // Joins as many layers as are free at the same place.
        let [mut low, mut high] = rooms[first];
        let mut next = first + 1;
        while let Some(room) = rooms.get(next).filter(|room| room[0].max(low) <= room[1].min(high)) {
            [low, high] = [low.max(room[0]), high.min(room[1])];
            next += 1;
        }
        if x < low {
            x = (low + lane).min(high);
        } else if x > high {
            x = (high - lane).max(low);
        }
        straight.extend(layers[2 * first..2 * next].iter().map(|at| pos2(x, at.y)));
        first = next;
    }
    straight
}

/// Returns the horizontal range that is free for a wire passing a layer.
fn room(top: Pos2, bottom: Pos2, boxes: &[Rect]) -> [f32; 2] {
    let mut room = [f32::NEG_INFINITY, f32::INFINITY];
    for own in boxes.iter().filter(|own| own.bottom() > top.y && own.top() < bottom.y) {
        if own.center().x < top.x {
            room[0] = room[0].max(own.right() + BESIDE);
        } else {
            room[1] = room[1].min(own.left() - BESIDE);
        }
    }
    if room[0] <= room[1] { room } else { [top.x, top.x] }
}

/// Removes points in the middle of straight vertical pieces.
pub(super) fn without_middles(line: &[Pos2]) -> Vec<Pos2> {
    let mut kept: Vec<Pos2> = Vec::new();
    for &at in line {
        if let [.., before, last] = kept[..]
            && before.x == last.x
            && last.x == at.x
        {
            kept.pop();
        }
        kept.push(at);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    fn own(x: f32, y: f32) -> Rect {
        Rect::from_min_size(pos2(x, y), vec2(100.0, 50.0))
    }

    #[test]
    fn a_wire_bends_only_where_a_node_is_in_its_way() {
        let wire = [
            (50.0, 0.0),
            (130.0, 100.0),
            (130.0, 150.0),
            (110.0, 200.0),
            (110.0, 250.0),
            (170.0, 300.0),
            (170.0, 350.0),
        ]
        .map(|(x, y)| pos2(x, y));
        let free = straightened(&wire, &[], 3);
        assert_eq!(without_middles(&free), [pos2(50.0, 100.0), pos2(50.0, 350.0)]);
        let boxes = [own(0.0, 100.0), own(0.0, 200.0), own(180.0, 300.0)];
        let beside = straightened(&wire, &boxes, 0);
        assert_eq!(without_middles(&beside), [pos2(112.0, 100.0), pos2(112.0, 350.0)]);
        let next = straightened(&wire, &boxes, 1);
        assert_eq!(without_middles(&next), [pos2(118.0, 100.0), pos2(118.0, 350.0)]);
        assert_eq!(straightened(&[], &[], 0), []);
    }
}
