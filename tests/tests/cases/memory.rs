//! Memory is made once: after the first tiles of a frame, no tile takes memory of its own.
//!
//! Every case counts how often a frame asks the heap for memory, in a picture of some tiles and in one of three times as many.
//! What a thread makes for itself is made once in either, so the more tiles may not ask more often, but for what is stated.

use crate::support::{folder, graph_in, root, settings};
use crate::trial;
use allocation_counter::measure;
use libtest_mimic::Trial;
use trochoid::{Buffers, Cache, CheckedGraph, Format, Plan, Shading, Silent, registry};

/// Width of the pictures, and heights of a picture and of one with more tiles.
const WIDTH: u32 = 96;
const HEIGHTS: [u32; 2] = [36, 180];

/// Size of tiles.
const TILE: (u32, u32) = (8, 6);

/// Most vectors that still grow, as a share of the tiles: some tiles see more than any before.
const GROW: f64 = 0.5;

/// Nodes that need memory for each tile, and at most how often: the strokes that are found for a block are shared by its
/// samples, and lists of strokes grow longer than in any tile before.
const STATED: [(&str, u64); 1] = [("Strokes", 3)];

/// Scenes, as a whole.
const SCENES: [&str; 9] = [
    "bake_sea",
    "cartoon_bay",
    "from_passes",
    "great_wave",
    "open_sea",
    "stormy_sea",
    "stormy_sea_bare",
    "toon_sea",
    "toon_teapot",
];

/// Returns how often a frame asks for memory, once everything is prepared.
fn counted(graph: &CheckedGraph) -> u64 {
    let settings =
        settings(|settings| (settings.tile, settings.threads) = (Some((TILE.0 as usize, TILE.1 as usize)), 0));
    let plan = Plan::new(graph, &[], graph.frames().0, &[], &settings).unwrap();
    let mut cache = Cache::new();
    let mut frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
    measure(|| plan.evaluate_into(&mut frame, &Buffers::new(), &mut cache, &Silent).unwrap()).count_total
}

/// Checks that more tiles take no more memory.
fn tiles_take_nothing(graph: &CheckedGraph, adaptive: Option<f32>) -> Result<(), String> {
    // One thread, on which everything is counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let stated: u64 = (graph.nodes().iter())
        .flat_map(|node| STATED.iter().filter(|(ty, _)| node.ty.declaration().name == *ty).map(|(_, count)| count))
        .sum();
    let tiles = (WIDTH / TILE.0) * ((HEIGHTS[1] - HEIGHTS[0]) / TILE.1);
    let mut faults = Vec::new();
    // With adaptive sampling, the first sample is taken like all others without it.
    for (samples, shading, adaptive) in
        [(1, Shading::Sample, None), (4, Shading::Sample, adaptive), (4, Shading::Pixel, None)]
    {
        let [few, many] = HEIGHTS.map(|height| {
            let format = Format::new(WIDTH, height, samples).unwrap().with_shading(shading).with_adaptive(adaptive);
            pool.install(|| counted(&graph.clone().with_scaled_format(format)))
        });
        let taken = many.saturating_sub(few);
        let each = taken as f64 / f64::from(tiles);
        if each > stated as f64 + GROW {
            let shading = shading.name();
            faults.push(format!("{samples} samples, shaded by the {shading}: {tiles} tiles more take memory {taken} times more: {each:.2} each"));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n")) }
}

fn scene(name: &str) -> Result<(), String> {
    let path = root().join(format!("graphs/{name}.json"));
    tiles_take_nothing(&trochoid::load(&path, &[]).map_err(|error| error.to_string())?.graph, Some(0.02))
}

fn node(name: &str) -> Result<(), String> {
    let text = std::fs::read_to_string(root().join(format!("tests/nodes/{name}.json"))).unwrap();
    let folder = folder();
    tiles_take_nothing(&graph_in(folder.path(), &text), None)
}

pub(crate) fn trials() -> Vec<Trial> {
    let scenes = SCENES.into_iter().map(|name| trial("memory", name, move || scene(name)));
    let types = registry().iter().map(|ty| ty.declaration().name);
    scenes.chain(types.map(|name| trial("memory/nodes", name, move || node(name)))).collect()
}
