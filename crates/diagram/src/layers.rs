//! Layered layout of boxes connected by wires that run from top to bottom.

use rust_sugiyama::configure::{Config, CrossingMinimization, RankingType};
use rust_sugiyama::from_vertices_and_edges;
use std::collections::BTreeMap;

/// Distance between neighbors in a layer, in pixels.
const BESIDE: f64 = 10.0;
/// Distance between layers, in pixels.
const BETWEEN: f64 = 46.0;
/// Width of a wire that passes a layer, in pixels.
const PASSING: f64 = 8.0;
/// Number of sweeps that pull each layer toward its neighbors.
const SWEEPS: usize = 40;
/// Maximum number of boxes for pairwise transposition, which would take minutes for more.
const COMPARED: usize = 1500;

/// A wire from one pin of a box to one or several boxes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Net {
    /// The box above.
    pub from: usize,
    /// The boxes below, each once.
    pub to: Vec<usize>,
}

/// Point in pixels; x points right, y down.
pub type Point = [f64; 2];

/// Positions of boxes and wires.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Upper left corner of each box.
    pub corners: Vec<Point>,
    /// Pieces of wire for each net, as points from top to bottom; a piece that leads to several boxes is shared.
    pub wires: Vec<Vec<Vec<Point>>>,
    /// Total width and height.
    pub size: Point,
}

/// Lays out boxes of the given sizes, in pixels, in layers. Each box stands above all boxes it leads to, as low as
/// possible; the order within a layer has few crossings (Sugiyama, Tagawa and Toda 1981; Brandes and Köpf 2001); and
/// each box is as close to its connections as its neighbors allow: the sum of the squared horizontal extents of the
/// wires is minimal.
///
/// A net that passes layers runs through each of them once, however many boxes it leads to. The nets must be free of
/// cycles, as in a checked graph. The same boxes and nets always give the same layout.
pub fn layers(boxes: &[[f64; 2]], nets: &[Net]) -> Layout {
    let ranks = ranks(boxes.len(), nets);
    let mut vertices: Vec<(u32, (f64, f64))> =
        boxes.iter().enumerate().map(|(index, size)| (index as u32, (size[0], 1.0))).collect();
    let mut rank_of = ranks.clone();
    let mut edges = Vec::new();
    // For each net, the vertices that represent it in the layers it passes, from top to bottom.
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
    let centers = centers(&vertices, &edges, &rank_of, boxes.len());

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
        let start = [pins.below[index], corners[net.from][1] + boxes[net.from][1]];
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
            pieces.push(vec![from, [pins.above[index][nth], corners[to][1]]]);
        }
        pieces
    });
    let wires = wires.collect();
    Layout { corners, wires, size }
}

/// Returns the layer of each box, 0 at the top. A box is directly above the highest box it leads to.
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

/// Returns the x coordinate of each vertex's center. Unconnected parts stand side by side; the leftmost edge is at 0.
/// The first `boxes` vertices are boxes, the others represent wires.
fn centers(vertices: &[(u32, (f64, f64))], edges: &[(u32, u32)], rank_of: &[usize], boxes: usize) -> Vec<f64> {
    let config = Config {
        vertex_spacing: BESIDE,
        dummy_vertices: false,
        ranking_type: RankingType::Down,
        c_minimization: CrossingMinimization::Median,
        transpose: vertices.len() <= COMPARED,
        ..Config::default()
    };
    let mut joined = vec![Vec::new(); vertices.len()];
    for [above, below] in edges.iter().map(|(above, below)| [*above as usize, *below as usize]) {
        // Longer wires are straightened more strongly (Gansner, Koutsofios, North and Vo 1993).
        let strength = [1.0, 2.0, 8.0][usize::from(above >= boxes) + usize::from(below >= boxes)];
        joined[above].push((below, strength));
        joined[below].push((above, strength));
    }
    let width = |vertex: usize| vertices[vertex].1.0;
    let mut centers = vec![0.0; vertices.len()];
    let mut start = 0.0;
    let mut parts = from_vertices_and_edges(vertices, edges, &config);
    parts.sort_by_key(|(part, ..)| part.iter().map(|(vertex, _)| *vertex).min());
    for (part, ..) in parts {
        let mut rows: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &(vertex, (x, _)) in &part {
            centers[vertex] = x;
            rows.entry(rank_of[vertex]).or_default().push(vertex);
        }
        let mut rows: Vec<Vec<usize>> = rows.into_values().collect();
        for row in &mut rows {
            row.sort_by(|&a, &b| centers[a].total_cmp(&centers[b]).then(a.cmp(&b)));
            settle(row, &mut centers, width, |vertex, centers| [centers[vertex], 1.0]);
        }
        // The library gives a whole column the width of its widest box, so positions are improved here.
        for sweep in 0..SWEEPS {
            for nth in 0..rows.len() {
                let row = &rows[if sweep % 2 == 0 { nth } else { rows.len() - 1 - nth }];
                settle(row, &mut centers, width, |vertex, centers| {
                    let sums = joined[vertex].iter().fold([0.0, 0.0], |[sum, strengths], &(other, strength)| {
                        [sum + strength * centers[other], strengths + strength]
                    });
                    if sums[1] > 0.0 { [sums[0] / sums[1], sums[1]] } else { [centers[vertex], 1.0] }
                });
            }
        }
        let left = part.iter().map(|&(v, _)| centers[v] - width(v) / 2.0).fold(f64::INFINITY, f64::min);
        let right = part.iter().map(|&(v, _)| centers[v] + width(v) / 2.0).fold(f64::NEG_INFINITY, f64::max);
        part.iter().for_each(|&(vertex, _)| centers[vertex] = start + centers[vertex] - left);
        start += right - left + 2.0 * BESIDE;
    }
    centers
}

/// Places the vertices of a layer in order and without overlap, minimizing the weighted squared distances to their
/// preferred positions: isotonic least squares by pooling adjacent violators.
fn settle(row: &[usize], centers: &mut [f64], width: impl Fn(usize) -> f64, drawn: impl Fn(usize, &[f64]) -> [f64; 2]) {
    // After subtracting the preceding widths, centers that do not overlap are ascending.
    let mut before = Vec::with_capacity(row.len());
    // Sum of strength times position, sum of strengths, and number of vertices.
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (index, &vertex) in row.iter().enumerate() {
        before.push(match index.checked_sub(1) {
            Some(last) => before[last] + (width(row[last]) + width(vertex)) / 2.0 + BESIDE,
            None => 0.0,
        });
        let [place, strength] = drawn(vertex, centers);
        let mut pool = (strength * (place - before[index]), strength, 1);
        while let Some(last) = pools.last().copied().filter(|last| last.0 / last.1 > pool.0 / pool.1) {
            pool = (pool.0 + last.0, pool.1 + last.1, pool.2 + last.2);
            pools.pop();
        }
        pools.push(pool);
    }
    let settled = pools.iter().flat_map(|(sum, strength, count)| std::iter::repeat_n(sum / strength, *count));
    for ((&vertex, start), before) in row.iter().zip(settled).zip(&before) {
        centers[vertex] = start + before;
    }
}

/// Positions where wires meet boxes, ordered so that wires do not cross at the box.
struct Pins {
    /// x coordinate at which each net leaves its box.
    below: Vec<f64>,
    /// x coordinates at which each net arrives at its boxes.
    above: Vec<Vec<f64>>,
}

impl Pins {
    fn new(boxes: &[[f64; 2]], nets: &[Net], passing: &[Vec<usize>], ranks: &[usize], centers: &[f64]) -> Self {
        let mut below = vec![0.0; nets.len()];
        let mut above: Vec<Vec<f64>> = nets.iter().map(|net| vec![0.0; net.to.len()]).collect();
        // For each box: the x coordinate of the wire's other end, and the wire.
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
}

/// Spreads pins evenly over the middle of an edge, ordered by the other ends of their wires.
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

    /// Returns a random graph without cycles: nets lead to boxes with higher indices.
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
