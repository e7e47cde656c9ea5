//! Packets on their way through a tree.

use super::beam::Beam;
use super::facets::Facets;
use super::packet::Packet;
use super::tree::{Child, Tree};
use fearless_simd::Simd;

/// A box that some ray of a packet may enter.
#[derive(Clone, Copy)]
pub(super) struct Waiting {
    node: u32,
    lane: u32,
    /// Where the packet's beam enters it.
    near: f32,
}

/// Walks a packet of so many rays through a tree, and returns the rays that meet a triangle, as bits; the packet then has
/// their distances. If `ANY`, a ray ends at any triangle that it meets.
#[inline(always)]
pub(super) fn walk<S: Simd, const ANY: bool>(
    simd: S,
    (facets, tree): (&Facets, &Tree),
    (packet, rays): (&mut Packet, usize),
    waiting: &mut Vec<Waiting>,
) -> u32 {
    let beam = Beam::new(packet, rays);
    let mut most = packet.most(simd);
    let mut found = 0;
    waiting.clear();
    let mut next = (!tree.nodes.is_empty()).then_some(0);
    loop {
        if let Some(node) = next.take() {
            let (mut entered, near) = beam.enter(simd, &tree.nodes[node as usize], most);
            let base = waiting.len();
            while entered != 0 {
                let lane = entered.trailing_zeros();
                entered &= entered - 1;
                let new = Waiting { node, lane, near: near[lane as usize] };
                // The nearest box is visited first, so it comes last.
                let mut place = waiting.len();
                waiting.push(new);
                while place > base && waiting[place - 1].near < new.near {
                    waiting[place] = waiting[place - 1];
                    place -= 1;
                }
                waiting[place] = new;
            }
        }
        let Some(Waiting { node, lane, near }) = waiting.pop() else { return found };
        if near > most {
            continue;
        }
        let (node, lane) = (&tree.nodes[node as usize], lane as usize);
        let (low, high) = node.bounds(lane);
        let (entering, entry) = packet.enter(simd, low, high);
        if entering == 0 {
            continue;
        }
        match node.child(lane) {
            Child::Node(below) => next = Some(below),
            Child::Triangle(triangle) => {
                let met = packet.meet(simd, facets.corners(triangle), entering, entry);
                if met != 0 {
                    found |= met;
                    if ANY {
                        packet.close(met);
                    }
                    most = packet.most(simd);
                }
            }
        }
    }
}
