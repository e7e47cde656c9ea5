//! Boxes in layers, joined by wires that run from the top down.

use rust_sugiyama::configure::{Config, CrossingMinimization, RankingType};
use rust_sugiyama::from_vertices_and_edges;

/// Between neighbors in a layer.
const BESIDE: f64 = 22.0;
/// Between layers.
const BETWEEN: f64 = 46.0;
/// What a wire that passes a layer takes there.
const PASSING: f64 = 8.0;
/// More boxes than these are not compared pair by pair: it would take minutes.
const COMPARED: usize = 1500;

/// What leaves a box at one pin, and the boxes that it leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Net {
    /// The box above.
    pub from: usize,
    /// The boxes below, each once.
    pub to: Vec<usize>,
}

/// A point in pixels, x to the right and y down.
pub type Point = [f64; 2];

/// Where boxes and wires lie.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// By box: its upper left corner.
    pub corners: Vec<Point>,
    /// By net: pieces of wire, each from point to point downward; pieces that pass several boxes are shared.
    pub wires: Vec<Vec<Vec<Point>>>,
    /// Width and height of all.
    pub size: Point,
}

/// Lays boxes of the sizes given, in pixels, out in layers: each stands above all that it leads to, as low as that
/// allows, in an order with few crossings (Sugiyama, Tagawa and Toda 1981; Brandes and Köpf 2001).
///
/// A net that leads past layers runs through each of them once, whatever the number of boxes that it leads to. The nets
/// must have no cycle, as those of a checked graph have none. The same boxes and nets always lie the same.
pub fn layers(boxes: &[[f64; 2]], nets: &[Net]) -> Layout {
    let ranks = ranks(boxes.len(), nets);
    let mut vertices: Vec<(u32, (f64, f64))> =
        boxes.iter().enumerate().map(|(index, size)| (index as u32, (size[0], 1.0))).collect();
    let mut rank_of = ranks.clone();
    let mut edges = Vec::new();
    // By net: the vertices that stand for it in the layers that it passes, from the top down.
    let mut passing: Vec<Vec<usize>> = Vec::new();
    for net in nets {
        let lowest = net.to.iter().map(|&to| ranks[to]).max().unwrap_or(0);
        let first = ranks[net.from] + 1;
        let chain: Vec<usize> =
            (first..lowest.max(first)).enumerate().map(|(index, _)| vertices.len() + index).collect();
        for (index, &vertex) in chain.iter().enumerate() {
            vertices.push((vertex as u32, (PASSING, 1.0)));
            rank_of.push(first + index);
            let above = if index == 0 { net.from } else { chain[index - 1] };
            edges.push((above as u32, vertex as u32));
        }
        for &to in &net.to {
            let above = if ranks[to] == first { net.from } else { chain[ranks[to] - first - 1] };
            edges.push((above as u32, to as u32));
        }
        passing.push(chain);
    }
    edges.sort_unstable();
    edges.dedup();
    let mut centers = centers(&vertices, &edges);
    part(&mut centers, &vertices, &rank_of);

    let count = rank_of.iter().max().map_or(0, |last| last + 1);
    let mut heights = vec![0.0_f64; count];
    for (size, &rank) in boxes.iter().zip(&ranks) {
        heights[rank] = heights[rank].max(size[1]);
    }
    let mut tops = vec![0.0; count];
    for rank in 1..count {
        tops[rank] = tops[rank - 1] + heights[rank - 1] + BETWEEN;
    }
    let corner = |index: usize| {
        let rank = ranks[index];
        [centers[index] - boxes[index][0] / 2.0, tops[rank] + (heights[rank] - boxes[index][1]) / 2.0]
    };
    let corners: Vec<Point> = (0..boxes.len()).map(corner).collect();
    let size = [0, 1].map(|axis| {
        let ends = corners.iter().zip(boxes).map(|(corner, size)| corner[axis] + size[axis]);
        ends.chain(if axis == 0 { centers.iter().map(|x| x + PASSING).collect() } else { Vec::new() })
            .fold(0.0, f64::max)
    });
    let pins = Pins::new(boxes, nets, &passing, &ranks, &centers);
    let wires = nets.iter().enumerate().map(|(index, net)| {
        let start = [pins.below(index), corners[net.from][1] + boxes[net.from][1]];
        let through = |vertex: usize| {
            let rank = rank_of[vertex];
            [[centers[vertex], tops[rank]], [centers[vertex], tops[rank] + heights[rank]]]
        };
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        if !passing[index].is_empty() {
            pieces.push(
                std::iter::once(start).chain(passing[index].iter().flat_map(|&vertex| through(vertex))).collect(),
            );
        }
        for (nth, &to) in net.to.iter().enumerate() {
            let steps = ranks[to] - ranks[net.from] - 1;
            let from = if steps == 0 { start } else { through(passing[index][steps - 1])[1] };
            pieces.push(vec![from, [pins.above(index, nth), corners[to][1]]]);
        }
        pieces
    });
    let wires = wires.collect();
    Layout { corners, wires, size }
}

/// By box: its layer, 0 the uppermost. A box stands just above the highest of those that it leads to.
fn ranks(count: usize, nets: &[Net]) -> Vec<usize> {
    let mut above = vec![Vec::new(); count];
    let mut open = vec![0; count];
    for net in nets {
        for &to in &net.to {
            above[to].push(net.from);
            open[net.from] += 1;
        }
    }
    let mut height = vec![0; count];
    let mut ready: Vec<usize> = (0..count).filter(|&index| open[index] == 0).collect();
    while let Some(index) = ready.pop() {
        for &from in &above[index] {
            height[from] = height[from].max(height[index] + 1);
            open[from] -= 1;
            if open[from] == 0 {
                ready.push(from);
            }
        }
    }
    let highest = height.iter().max().copied().unwrap_or(0);
    height.iter().map(|height| highest - height).collect()
}

/// By vertex: its center along x; parts that nothing joins stand side by side, the left edge of all at 0.
fn centers(vertices: &[(u32, (f64, f64))], edges: &[(u32, u32)]) -> Vec<f64> {
    let config = Config {
        vertex_spacing: BESIDE,
        dummy_vertices: false,
        ranking_type: RankingType::Down,
        c_minimization: CrossingMinimization::Median,
        transpose: vertices.len() <= COMPARED,
        ..Config::default()
    };
    let mut centers = vec![0.0; vertices.len()];
    let mut start = 0.0;
    let mut parts = from_vertices_and_edges(vertices, edges, &config);
    parts.sort_by_key(|(part, ..)| part.iter().map(|(vertex, _)| *vertex).min());
    for (part, ..) in parts {
        let half = |vertex: usize| vertices[vertex].1.0 / 2.0;
        let left = part.iter().map(|&(vertex, (x, _))| x - half(vertex)).fold(f64::INFINITY, f64::min);
        let right = part.iter().map(|&(vertex, (x, _))| x + half(vertex)).fold(f64::NEG_INFINITY, f64::max);
        for (vertex, (x, _)) in part {
            centers[vertex] = start + x - left;
        }
        start += right - left + 2.0 * BESIDE;
    }
    centers
}

/// Moves what overlaps in a layer apart, all together as little as can be: least squares under an order, by pooling
/// neighbors that violate it.
fn part(centers: &mut [f64], vertices: &[(u32, (f64, f64))], rank_of: &[usize]) {
    let mut rows = vec![Vec::new(); rank_of.iter().max().map_or(0, |last| last + 1)];
    for (vertex, &rank) in rank_of.iter().enumerate() {
        rows[rank].push(vertex);
    }
    for row in &mut rows {
        row.sort_by(|&a, &b| centers[a].total_cmp(&centers[b]).then(a.cmp(&b)));
        // Without the widths before them, centers that do not overlap ascend.
        let mut before = vec![0.0; row.len()];
        for index in 1..row.len() {
            let widths = vertices[row[index - 1]].1.0 + vertices[row[index]].1.0;
            before[index] = before[index - 1] + widths / 2.0 + BESIDE;
        }
        let mut pools: Vec<(f64, usize)> = Vec::new();
        for (index, &vertex) in row.iter().enumerate() {
            let mut pool = (centers[vertex] - before[index], 1);
            while let Some((sum, count)) =
                pools.last().copied().filter(|(sum, count)| sum / *count as f64 > pool.0 / pool.1 as f64)
            {
                pool = (pool.0 + sum, pool.1 + count);
                pools.pop();
            }
            pools.push(pool);
        }
        let settled = pools.iter().flat_map(|(sum, count)| std::iter::repeat_n(sum / *count as f64, *count));
        for ((&vertex, start), before) in row.iter().zip(settled).zip(&before) {
            centers[vertex] = start + before;
        }
    }
    let left =
        (0..centers.len()).map(|vertex| centers[vertex] - vertices[vertex].1.0 / 2.0).fold(f64::INFINITY, f64::min);
    centers.iter_mut().for_each(|center| *center -= left);
}

/// Where wires touch boxes: side by side in the order in which they come, so that they do not cross at the box.
struct Pins {
    below: Vec<f64>,
    above: Vec<Vec<f64>>,
}

impl Pins {
    fn new(boxes: &[[f64; 2]], nets: &[Net], passing: &[Vec<usize>], ranks: &[usize], centers: &[f64]) -> Self {
        let mut below = vec![0.0; nets.len()];
        let mut above: Vec<Vec<f64>> = nets.iter().map(|net| vec![0.0; net.to.len()]).collect();
        // By box: where the wire goes to or comes from along x, and which it is.
        let mut leaving = vec![Vec::new(); boxes.len()];
        let mut coming = vec![Vec::new(); boxes.len()];
        for (index, net) in nets.iter().enumerate() {
            let next = passing[index].first().or(net.to.first()).map_or(0.0, |&vertex| centers[vertex]);
            leaving[net.from].push((next, index));
            for (nth, &to) in net.to.iter().enumerate() {
                let steps = ranks[to] - ranks[net.from] - 1;
                let last = if steps == 0 { net.from } else { passing[index][steps - 1] };
                coming[to].push((centers[last], (index, nth)));
            }
        }
        for (at, wires) in leaving.iter_mut().enumerate() {
            spread(wires, boxes[at][0], centers[at], |index, x| below[index] = x);
        }
        for (at, wires) in coming.iter_mut().enumerate() {
            spread(wires, boxes[at][0], centers[at], |(index, nth), x| above[index][nth] = x);
        }
        Self { below, above }
    }

    fn below(&self, net: usize) -> f64 {
        self.below[net]
    }

    fn above(&self, net: usize, nth: usize) -> f64 {
        self.above[net][nth]
    }
}

/// Pins evenly over the middle of an edge, by where their wires come from.
fn spread<K: Copy + Ord>(wires: &mut [(f64, K)], width: f64, center: f64, mut set: impl FnMut(K, f64)) {
    wires.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let step = (width * 0.8 / wires.len() as f64).min(18.0);
    let first = center - step * (wires.len() as f64 - 1.0) / 2.0;
    for (nth, (_, key)) in wires.iter().enumerate() {
        set(*key, first + step * nth as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A graph without cycles from a seed: nets lead to boxes of higher index.
    fn random(seed: u64, count: usize) -> (Vec<[f64; 2]>, Vec<Net>) {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut random = move |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 20) as usize % below
        };
        let boxes: Vec<[f64; 2]> = (0..count).map(|_| [40.0 + random(160) as f64, 30.0 + random(40) as f64]).collect();
        let mut nets = Vec::new();
        for from in 0..count {
            for _ in 0..random(3) {
                let to: Vec<usize> = (from + 1..count).filter(|_| random(count) < 2).collect();
                if !to.is_empty() {
                    nets.push(Net { from, to });
                }
            }
        }
        (boxes, nets)
    }

    #[test]
    fn boxes_never_overlap_and_wires_run_down_from_box_to_box() {
        for seed in 0..60 {
            let (boxes, nets) = random(seed, 1 + seed as usize);
            let layout = layers(&boxes, &nets);
            for (a, (corner, size)) in layout.corners.iter().zip(&boxes).enumerate() {
                assert!([0, 1].iter().all(|&i| corner[i] > -1e-6 && corner[i] + size[i] < layout.size[i] + 1e-6));
                for b in 0..a {
                    let apart = |i: usize| {
                        let (low, high) = if corner[i] < layout.corners[b][i] { (a, b) } else { (b, a) };
                        layout.corners[high][i] - layout.corners[low][i] - boxes[low][i]
                    };
                    assert!(apart(0) > 1.0 || apart(1) > 1.0, "seed {seed}: {a} and {b}");
                }
            }
            for (net, pieces) in nets.iter().zip(&layout.wires) {
                assert!(pieces.iter().all(|piece| piece.windows(2).all(|two| two[0][1] <= two[1][1])), "seed {seed}");
                for &to in &net.to {
                    let (corner, size) = (layout.corners[to], boxes[to]);
                    let lands = |end: &Point| end[1] == corner[1] && (corner[0]..corner[0] + size[0]).contains(&end[0]);
                    assert!(pieces.iter().any(|piece| piece.last().is_some_and(lands)), "seed {seed}");
                }
            }
            assert_eq!(layout, layers(&boxes, &nets), "the same graph lies the same");
        }
    }

    #[test]
    fn a_chain_stands_straight() {
        let boxes = [[100.0, 40.0], [60.0, 40.0], [80.0, 40.0]];
        let nets = [Net { from: 0, to: vec![1] }, Net { from: 1, to: vec![2] }];
        let layout = layers(&boxes, &nets);
        let centers: Vec<f64> =
            layout.corners.iter().zip(boxes).map(|(corner, size)| corner[0] + size[0] / 2.0).collect();
        assert_eq!(centers, [50.0; 3]);
        let tops: Vec<f64> = layout.corners.iter().map(|corner| corner[1]).collect();
        assert_eq!(tops, [0.0, 86.0, 172.0]);
    }

    #[test]
    fn nothing_lies_nowhere() {
        assert_eq!(layers(&[], &[]), Layout::default());
    }
}
