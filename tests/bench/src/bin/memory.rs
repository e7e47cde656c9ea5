//! Memory of documents: estimated in advance, and measured.
//!
//!     cargo run --release -p trochoid-bench --bin memory -- graphs/stormy_sea.json
//!
//! All outputs of each document are evaluated at its first frame. There is one line per node with figures of a megabyte
//! or more.

use std::collections::BTreeMap;
use trochoid::{Buffers, Cache, Heap, MemoryConsumer, Pictures, Plan, Settings, Silent, in_bytes};

#[global_allocator]
static HEAP: Heap = Heap;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let graph = trochoid::load(path.as_ref(), &[])?.graph;
        let plan = Plan::new(&graph, &[], graph.frames().0, &[], &Settings::default())?;
        let account = plan.memory(Pictures::Whole);
        let before = Heap::taken();
        Heap::forget_peak();
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::with_limit(0), &Silent)?;
        let peak = Heap::peak().saturating_sub(before);
        println!("{path}: reckoned {}, at most taken {}", in_bytes(account.total()), in_bytes(peak as u64));
        let mut nodes: BTreeMap<String, [u64; 2]> = BTreeMap::new();
        for (consumer, bytes, _) in &account.consumers {
            match consumer {
                MemoryConsumer::Node(id) => nodes.entry(graph.node(*id).name.clone()).or_default()[0] = *bytes,
                MemoryConsumer::Preparing(id) => println!("  preparing {} {}", graph.node(*id).name, in_bytes(*bytes)),
                other => println!("  {other:?} {}", in_bytes(*bytes)),
            }
        }
        for node in &frame.nodes {
            nodes.entry(node.name.clone()).or_default()[1] = node.bytes as u64;
        }
        for (name, [reckoned, held]) in nodes.iter().filter(|(_, bytes)| bytes.iter().any(|bytes| *bytes >= 1_000_000))
        {
            println!("  {name}: reckoned {}, held {}", in_bytes(*reckoned), in_bytes(*held));
        }
    }
    Ok(())
}
