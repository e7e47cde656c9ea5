//! What a job renders, and what its commands have in common for all engines.

use super::tiles::{self, Grid};
use super::{Args, Engine, inputs, ranges};
use crate::failure::{FAILED, Failure};
use crate::frames;
use crate::wedge::Wedge;
use std::path::Path;
use trochoid::{CheckedGraph, LoadError, Pictures, Plan, Settings, output_files, quoted};

/// Folder of the copied document.
pub(super) const GRAPH: &str = "graph";
/// Folder of the pictures.
pub(super) const OUT: &str = "out";
/// Folder of the tiles, within the one of the pictures.
pub(super) const TILES: &str = "tiles";

/// Most tasks of a job, as far as engines are known to take them.
const MOST: usize = 100_000;
/// Most tasks of an array in Slurm, unless its settings say otherwise.
const USUAL: usize = 1000;
/// Most minutes of a task, if neither given nor measured.
const MINUTES: u32 = 60;
/// Memory of a task beside what `--memory` bounds, in MiB: the program and its threads.
const BESIDE: u64 = 256;

/// What a job renders.
pub(super) struct Work {
    /// Name of the job, which needs no quotes.
    pub(super) name: String,
    /// Path of the document: relative to the folder of the job if it is copied, else absolute.
    pub(super) graph: String,
    /// Path of the palette of the command line, in the same way.
    pub(super) palette: Option<String>,
    pub(super) is_shared: bool,
    /// Frames in ascending order.
    pub(super) frames: Vec<i64>,
    /// Most frames of a task.
    pub(super) chunk: usize,
    /// Tiles, each as left, top, width and height; empty if pictures are rendered whole.
    pub(super) tiles: Vec<[u32; 4]>,
    /// Index of the tile in the middle of the picture.
    pub(super) middle: usize,
    pub(super) wedge: Option<Wedge>,
    /// Options of all render commands, one word each: names may begin with a hyphen.
    pub(super) options: Vec<String>,
    /// Pattern of the files, relative to the folder of the pictures.
    pub(super) pattern: String,
    /// Patterns of the files of each output.
    pub(super) outputs: Vec<String>,
    pub(super) threads: u16,
    /// Bound of the memory of a render, in MiB.
    pub(super) bound: u64,
    /// Most time of a task that renders.
    pub(super) minutes: u32,
    /// Most time of a task that joins, which is not measured.
    pub(super) join_minutes: u32,
}

impl Work {
    /// Lays the work out, and adds all faults to `faults`; what has faults is not to be written.
    pub(super) fn new(
        args: &Args,
        graph: &CheckedGraph,
        variants: &[&CheckedGraph],
        chosen: &[usize],
        mut frames: Vec<i64>,
        wedge: Option<Wedge>,
        faults: &mut Vec<Failure>,
    ) -> Self {
        frames.sort_unstable();
        let several = frames.len() > 1;
        faults.extend(pattern_faults(args));
        let named = output_files(graph, chosen, frames[0], several, Some(&args.out));
        faults.extend(named.err().map(|error| Failure::written(&error, "--out")));
        let tiles = args.tiles.map(|grid| tiles_of(grid, graph, faults)).unwrap_or_default();
        let mut text = |what: &str, path: &Path| {
            utf8(what, path).unwrap_or_else(|fault| {
                faults.push(fault);
                String::new()
            })
        };
        let place = |path: &Path| if args.shared { absolute(path) } else { path.into() };
        let document = text("the document", &place(&args.graph));
        let copied = || format!("{GRAPH}/{}", args.graph.file_name().unwrap_or_default().to_string_lossy());
        let palette = args.changes.palette.as_ref().map(|path| {
            let given = text("--palette", &place(path));
            if args.shared { given } else { inputs::palette(path) }
        });
        let mut options: Vec<String> = Vec::new();
        for set in &args.changes.set {
            options.push(format!("--set={set}"));
        }
        if let Some(folder) = &args.cache {
            options.push(format!("--cache={}", text("--cache", &absolute(folder))));
        }
        for output in &args.output {
            options.push(format!("--output={output}"));
        }
        if args.shared {
            for path in &args.allow {
                options.push(format!("--allow={}", text("--allow", &absolute(path))));
            }
        }
        let names = chosen.iter().map(|index| graph.outputs()[*index].name.as_str());
        let escaped = names.map(|name| args.out.replace("{output}", &trochoid::escape_frame(name)));
        let work = Self {
            name: plain_name(&args.graph.file_stem().unwrap_or_default().to_string_lossy()),
            graph: if args.shared { document } else { copied() },
            palette,
            is_shared: args.shared,
            chunk: args.chunk as usize,
            tiles,
            middle: args.tiles.map_or(0, Grid::middle),
            wedge,
            options,
            pattern: args.out.clone(),
            outputs: escaped.collect(),
            threads: args.threads,
            bound: bound(variants, chosen, frames[0], args.threads, faults),
            minutes: args.minutes.unwrap_or(MINUTES),
            join_minutes: args.minutes.unwrap_or(MINUTES),
            frames,
        };
        let (tasks, joins) = (work.tasks(), work.joins());
        if tasks.max(joins) > MOST {
            let message = format!("found {} tasks; expected at most {MOST} in a job", tasks.max(joins));
            faults.push(Failure::usage(
                message,
                "give fewer --frames, --tiles or --wedge, or more frames a task: --chunk",
            ));
        }
        work
    }

    /// Returns the number of values of the wedge; one without a wedge.
    pub(super) fn variants(&self) -> usize {
        self.wedge.as_ref().map_or(1, |wedge| wedge.values.len())
    }

    /// Returns the lists of frames of tasks.
    pub(super) fn chunks(&self) -> Vec<String> {
        self.frames.chunks(self.chunk).map(ranges::list).collect()
    }

    /// Returns the number of tasks that render.
    pub(super) fn tasks(&self) -> usize {
        self.frames.len().div_ceil(self.chunk) * self.tiles.len().max(1) * self.variants()
    }

    /// Returns the number of tasks that join tiles.
    pub(super) fn joins(&self) -> usize {
        if self.tiles.is_empty() { 0 } else { self.frames.len() * self.variants() }
    }

    /// Returns the memory of a task in MiB.
    pub(super) fn memory(&self) -> u64 {
        self.bound + BESIDE
    }

    /// Returns the pattern of the files that a task writes: the parts before and after the number of the tile, or all of
    /// it if there are no tiles.
    pub(super) fn pattern_around(&self) -> (String, &'static str) {
        match self.tiles[..] {
            [] => (self.pattern.clone(), ""),
            _ => (format!("{TILES}/{}.t", stem(&self.pattern)), ".exr"),
        }
    }

    /// Returns notes on frames beyond those of the document, and on what the engine may not take.
    pub(super) fn notes(&self, engine: Engine, graph: &CheckedGraph) -> Vec<String> {
        let most = self.tasks().max(self.joins());
        let is_long = engine == Engine::Slurm && most > USUAL;
        let note = || {
            format!(
                "note: found an array of {most} tasks; expected at most {USUAL}, unless MaxArraySize of Slurm is set higher\n  \
                 remedy: give more frames a task: --chunk"
            )
        };
        frames::beyond(graph, &self.frames).into_iter().chain(is_long.then(note)).collect()
    }
}

/// Returns a pattern without its extension.
pub(super) fn stem(pattern: &str) -> &str {
    pattern.rsplit_once('.').map_or(pattern, |(stem, _)| stem)
}

/// Returns a text as a name of at most 100 letters, digits and signs that no shell, pattern or engine reads as anything
/// else: all others become `_`.
pub(crate) fn plain_name(text: &str) -> String {
    let plain = |sign: char| if sign.is_ascii_alphanumeric() || "._=+-".contains(sign) { sign } else { '_' };
    text.chars().take(100).map(plain).collect()
}

/// Returns a path as text, as templates and scripts hold it.
///
/// # Errors
/// It is not UTF-8.
pub(super) fn utf8(what: &str, path: &Path) -> Result<String, Failure> {
    path.to_str().map(String::from).ok_or_else(|| {
        let message =
            format!("{what}: found the path {}, which is not UTF-8; expected text", quoted(&path.to_string_lossy()));
        Failure::usage(message, "give the file another name")
    })
}

fn absolute(path: &Path) -> std::path::PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

/// Returns failures for a pattern that leads out of the folder of the pictures, or that tiles cannot have.
fn pattern_faults(args: &Args) -> Vec<Failure> {
    let (pattern, place) = (&args.out, format!("--out {}", quoted(&args.out)));
    let mut faults = Vec::new();
    let is_inside = |part: std::path::Component<'_>| matches!(part, std::path::Component::Normal(_));
    if !Path::new(pattern).components().all(is_inside) {
        let message = format!("{place}: found a path that may lead out of the output folder; expected one within it");
        faults.push(Failure::usage(message, "give a relative path without \".\" and \"..\""));
    }
    if args.tiles.is_some() && !pattern.ends_with(".exr") {
        let message = format!("{place}: found another ending; expected .exr with --tiles");
        faults.push(Failure::usage(message, "let the pattern end with .exr, or omit --tiles"));
    }
    faults
}

fn tiles_of(grid: Grid, graph: &CheckedGraph, faults: &mut Vec<Failure>) -> Vec<[u32; 4]> {
    let format = graph.format();
    let (width, height) = (format.width(), format.height());
    if grid.columns > width || grid.rows > height {
        let Grid { columns, rows } = grid;
        let message =
            format!("--tiles {columns}x{rows}: found more tiles than pixels; expected at most {width}x{height}");
        faults.push(Failure::usage(message, "give fewer tiles"));
    }
    tiles::regions(grid, [width, height])
}

/// Returns the bound of the memory of a render in MiB: what the first frame takes, of the variant that takes most, and a
/// quarter more.
fn bound(graphs: &[&CheckedGraph], outputs: &[usize], frame: i64, threads: u16, faults: &mut Vec<Failure>) -> u64 {
    let mut settings = Settings::default();
    (settings.threads, settings.memory_limit) = (usize::from(threads), u64::MAX);
    let mut most = 0;
    for graph in graphs {
        let graph = match evaluated(graph, outputs) {
            Ok(graph) => graph,
            Err(fault) => {
                faults.push(fault);
                continue;
            }
        };
        let names: Vec<&str> = outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        match Plan::new(&graph, &names, frame, &[], &settings) {
            Ok(plan) => most = most.max(plan.memory(Pictures::Files).total()),
            Err(error) => faults.push(Failure::new(FAILED, format!("frame {frame}: {error}"))),
        }
    }
    most.saturating_add(most / 4).div_ceil(1 << 20).max(BESIDE)
}

/// Returns a graph as it is evaluated: with recipes if its palette is used so.
///
/// # Errors
/// It has no recipes.
pub(super) fn evaluated(graph: &CheckedGraph, outputs: &[usize]) -> Result<CheckedGraph, Failure> {
    let graph = graph.clone();
    if !graph.has_recipe(outputs) {
        return Ok(graph);
    }
    graph.with_recipes(outputs).map_err(|refused| LoadError::Invalid(refused).into())
}
