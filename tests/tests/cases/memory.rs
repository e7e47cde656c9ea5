//! Memory is made once: after the first tiles of a frame, no tile takes memory of its own.
//!
//! Every case counts how often a frame asks the heap for memory, in a picture of some tiles and in one of three times as many.
//! What a thread makes for itself is made once in either, so the more tiles may not ask more often, but for what is stated.

use crate::support::{folder, graph_in, root, settings};
use crate::trial;
use allocation_counter::measure;
use libtest_mimic::Trial;
use trochoid::{
    Buffers, Cache, CheckedGraph, Format, Frame, MemoryConsumer, Pictures, Plan, Shading, Silent, registry,
};

/// Width of the pictures, and heights of a picture and of one with more tiles.
const WIDTH: u32 = 48;
const HEIGHTS: [u32; 2] = [18, 54];

/// Size of tiles.
const TILE: (u32, u32) = (4, 3);

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

/// Samples of a pixel, how they are shaded, and the tolerance of adaptive sampling.
type Sampling = (u32, Shading, Option<f32>);

/// Samplings of scenes, and of nodes. With adaptive sampling, the first sample is taken like all others without it.
const OF_SCENES: [Sampling; 3] =
    [(1, Shading::Sample, None), (4, Shading::Sample, Some(0.02)), (4, Shading::Pixel, None)];
const OF_NODES: [Sampling; 3] = [(1, Shading::Sample, None), (4, Shading::Sample, None), (4, Shading::Pixel, None)];

/// What is checked of a document that is sampled in several ways.
type Check = fn(&CheckedGraph, &[Sampling]) -> Result<(), String>;

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
fn tiles_take_nothing(graph: &CheckedGraph, samplings: &[Sampling]) -> Result<(), String> {
    // One thread, on which everything is counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let stated: u64 = (graph.nodes().iter())
        .flat_map(|node| STATED.iter().filter(|(ty, _)| node.ty.declaration().name == *ty).map(|(_, count)| count))
        .sum();
    let tiles = (WIDTH / TILE.0) * ((HEIGHTS[1] - HEIGHTS[0]) / TILE.1);
    let mut faults = Vec::new();
    for (samples, shading, adaptive) in samplings {
        let [few, many] = HEIGHTS.map(|height| {
            let format = Format::new(WIDTH, height, *samples).unwrap().with_shading(*shading).with_adaptive(*adaptive);
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

fn scene(name: &str, check: Check) -> Result<(), String> {
    check(&load_scene(name)?, &OF_SCENES)
}

fn node(name: &str, check: Check) -> Result<(), String> {
    let text = std::fs::read_to_string(root().join(format!("tests/nodes/{name}.json"))).unwrap();
    let folder = folder();
    check(&graph_in(folder.path(), &text), &OF_NODES)
}

/// Size of the pictures whose memory is estimated, and of their tiles, unless the engine chooses one.
const SIZE: (u32, u32) = (192, 108);
const TILES: [Option<(usize, usize)>; 2] = [None, Some((96, 54))];

/// Most times that an estimate may be of what tiles take, and bytes that do not matter.
const OVER: f64 = 6.0;
const SMALL: u64 = 1 << 20;

/// Checks that the tiles of one thread take no more memory than estimated, nor much less.
fn tiles_are_estimated(graph: &CheckedGraph, samplings: &[Sampling]) -> Result<(), String> {
    let pool = || rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut faults = Vec::new();
    for (samples, shading, adaptive) in samplings {
        let format = Format::new(SIZE.0, SIZE.1, *samples).unwrap().with_shading(*shading).with_adaptive(*adaptive);
        let graph = graph.clone().with_scaled_format(format);
        for tile in TILES {
            // Whole planes count apart.
            let settings = settings(|settings| {
                (settings.tile, settings.threads, settings.switches.hold) = (tile, 0, false);
            });
            let plan = Plan::new(&graph, &[], graph.frames().0, &[], &settings).unwrap();
            let (mut cache, mut frame) = (Cache::new(), Frame::default());
            let mut evaluate = || plan.evaluate_into(&mut frame, &Buffers::new(), &mut cache, &Silent).unwrap();
            pool().install(&mut evaluate);
            // A thread of its own, which holds nothing yet.
            let (estimated, taken) = pool().install(|| {
                let account = plan.memory(Pictures::Whole);
                let tiles = account.consumers.iter().find(|(consumer, ..)| *consumer == MemoryConsumer::Tiles);
                (tiles.map_or(0, |(_, bytes, _)| *bytes), measure(&mut evaluate).bytes_max)
            });
            if estimated < taken || estimated as f64 > OVER * taken as f64 + SMALL as f64 {
                let shading = shading.name();
                faults.push(format!(
                    "{samples} samples, shaded by the {shading}, adaptive {adaptive:?}, tiles {tile:?}: \
                     estimated {estimated} bytes, taken {taken}"
                ));
            }
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n")) }
}

fn load_scene(name: &str) -> Result<CheckedGraph, String> {
    let path = root().join(format!("graphs/{name}.json"));
    trochoid::load(&path, &[]).map(|loaded| loaded.graph).map_err(|error| error.to_string())
}

pub(crate) fn trials() -> Vec<Trial> {
    let checks: [(&str, Check); 2] = [("memory", tiles_take_nothing), ("memory/estimates", tiles_are_estimated)];
    let of_scenes = move |(kind, check): (&'static str, Check)| {
        SCENES.into_iter().map(move |name| trial(kind, name, move || scene(name, check)))
    };
    let of_nodes = move |(kind, check): (&'static str, Check)| {
        let names = registry().iter().map(|ty| ty.declaration().name);
        names.map(move |name| trial(&format!("{kind}/nodes"), name, move || node(name, check)))
    };
    checks.into_iter().flat_map(of_scenes).chain(checks.into_iter().flat_map(of_nodes)).collect()
}
