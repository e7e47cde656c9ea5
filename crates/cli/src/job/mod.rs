//! `trochoid job`: folders with which render farms take a document's frames: templates of Open Job Description, and
//! scripts of Slurm.
//!
//! Nothing is rendered here. The tasks call `trochoid render` and, for tiles, `trochoid join`.

mod folder;
mod inputs;
mod join;
mod measure;
mod openjd;
mod ranges;
mod slurm;
mod tiles;
mod work;

use crate::changes::Changes;
use crate::failure::Failure;
use crate::shell::{self, printable};
use crate::wedge::{self, Wedge};
use crate::{frames, interrupt, outputs, warnings};
use folder::{Content, Folder};
use std::path::PathBuf;
use tiles::Grid;
use trochoid::{Access, CheckedGraph, UNNAMED_FILE, load_within};
use work::Work;
pub(crate) use work::plain_name;

/// Options of `trochoid job`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
DIR holds what the engine takes: template.json for Open Job Description and what builds on it, such as AWS Deadline Cloud; \
submit.sh and job.sh for Slurm. It also holds a copy of the document and of all files that it reads at these frames, so \
that it can be moved. These files must lie beneath the document's folder, and the document must name them by relative \
paths; with --shared it refers to the document in its place instead, which every machine must reach by the same path.

The memory of a task is what the first frame is estimated to take, a quarter more and 256 MiB. A task skips frames that \
are up to date, so a task that is run again goes on where it ended. Pictures go to DIR/out, with a folder for each value \
of a wedge; the tiles from which they are joined stay in a folder named tiles.

Examples:
  trochoid job storm.json --engine openjd -o farm
  trochoid job storm.json --engine slurm --frames 1-96 --chunk 8 --threads 16 -o farm && bash farm/submit.sh
  trochoid job storm.json --engine openjd --wedge sea.height=3,4,5 --measure -o heights
  trochoid job storm.json --engine slurm --frames 36 --tiles 4x2 --output beauty --minutes 600 -o poster")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// What runs the tasks
    #[arg(long, value_enum, value_name = "ENGINE")]
    engine: Engine,
    /// Frames, such as 1-10,20-40x2 (every second frame) or -5--1 [default: all frames of the document]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Most frames of a task; each task computes the first frame of a toon sea anew
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    chunk: u32,
    /// Render each picture as C columns and R rows of tiles, such as 4x2, which a second step joins
    #[arg(long, value_name = "CxR", value_parser = tiles::grid)]
    tiles: Option<Grid>,
    /// Render all frames once for each of these values of a knob or port, such as sea.height=3,4,5
    #[arg(long, value_name = "NODE.KNOB=VALUES")]
    wedge: Option<String>,
    /// Render this output; may be repeated [default: all outputs]
    #[arg(long, value_name = "NAME")]
    output: Vec<String>,
    /// Pattern for the pictures within the output folder
    #[arg(long, value_name = "PATTERN", default_value = UNNAMED_FILE)]
    out: String,
    #[command(flatten)]
    changes: Changes,
    /// Threads, and cores that a task asks for; an engine never starts a task that asks for more than a machine has
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Most time of a task in minutes, after which the engine ends it; make it generous [default: 60, or as measured]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    minutes: Option<u32>,
    /// Render two frames of the last task on this machine, or a tile of them, writing nothing: tells the time of a task,
    /// the share of it that each task does anew, and sets --minutes to four times as long and two minutes
    #[arg(long)]
    measure: bool,
    /// Let tasks keep the states of long simulations in this folder, which all machines must reach by the same path, and
    /// go on from those of others
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Refer to the document in its place instead of copying it and its files
    #[arg(long)]
    shared: bool,
    /// Allow the document to read this file, or anything under this folder, beside its own folder; may be repeated
    #[arg(long, value_name = "PATH")]
    allow: Vec<PathBuf>,
    /// The folder to write: a new or empty one, or one that `job` wrote
    #[arg(short = 'o', long = "into", value_name = "DIR")]
    into: PathBuf,
    /// Print nothing on stdout
    #[arg(long)]
    quiet: bool,
}

/// Program that runs the tasks of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    /// Open Job Description, jobtemplate-2023-09 with the extension TASK_CHUNKING
    Openjd,
    /// Slurm, as job arrays
    Slurm,
}

/// Writes the folder of a job.
///
/// # Errors
/// All problems of the options and of the document that can be found, together; an input cannot be read; or the folder
/// cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let mut faults = Vec::new();
    let listed = args.frames.as_deref().map(frames::parse).transpose().unwrap_or_else(|pieces| {
        faults.extend(pieces.into_iter().map(|piece| Failure::usage(piece, "use a list such as 1-10,20-40x2")));
        None
    });
    faults.extend(args.changes.set.iter().filter_map(|set| palette_by_set(set)));
    Failure::all(std::mem::take(&mut faults))?;
    let load = |set: &[String]| load_within(&args.graph, set, args.access());
    let loaded = load(&args.changes.assignments())?;
    let graph = &loaded.graph;
    let frames = listed.unwrap_or_else(|| frames::all(graph, args.frames.is_some(), &mut faults));
    let wedge = args.wedge.as_deref().map(Wedge::parse).transpose().unwrap_or_else(|fault| {
        faults.push(fault);
        None
    });
    // What a document reads and takes may depend on the value.
    let mut variants = Vec::new();
    for assignment in wedge.iter().flat_map(Wedge::assignments) {
        match load(&[&args.changes.assignments()[..], &[assignment]].concat()) {
            Ok(loaded) => variants.push(loaded.graph),
            // The other values would most often be refused for the same reason.
            Err(error) => {
                faults.push(wedge::refused(error));
                break;
            }
        }
    }
    let variants: Vec<&CheckedGraph> = if wedge.is_some() { variants.iter().collect() } else { vec![graph] };
    let chosen = outputs::choose(graph, &args.output, &mut faults);
    let mut work = Work::new(args, graph, &variants, &chosen, frames, wedge, &mut faults);
    let inputs = inputs::files(args, &variants, &chosen, &work.frames, &mut faults);
    warnings::after(faults, &warnings::of(graph, &chosen, loaded.warnings))?;
    let read = crate::files::inputs(graph, &args.graph, &args.changes.set, &[]);
    let folder = |work: &Work| {
        let mut files = inputs.clone();
        files.extend(match args.engine {
            Engine::Openjd => openjd::files(work)?,
            Engine::Slurm => slurm::files(work),
        });
        Folder::check(&args.into, files, &read)
    };
    // What cannot be written need not be measured.
    folder(&work)?;
    interrupt::watch()?;
    let measured = if args.measure { Some(measure::measure(&work, variants[0], &chosen)?) } else { None };
    if let (Some(measured), None) = (&measured, args.minutes) {
        work.minutes = measured.minutes();
    }
    let folder = folder(&work)?;
    folder.write()?;
    shell::tell(&work.notes(args.engine, graph));
    let times = measured.map_or(String::new(), |measured| measured.told(work.frames.len()));
    if args.quiet { Ok(()) } else { shell::print(&(told(args, &work) + &times)) }
}

impl Args {
    /// Returns the files that the document may read: those that a task may read, whatever folder it runs in.
    fn access(&self) -> Access {
        let folder = self.graph.parent().unwrap_or(std::path::Path::new("."));
        self.allow.iter().fold(Access::beneath(folder), |access, path| access.allowing(path))
    }
}

/// Returns a failure if an assignment names a palette file, which could not be copied.
fn palette_by_set(set: &str) -> Option<Failure> {
    let file = set.strip_prefix("palette=")?;
    let found = format!("--set {}: found a palette; expected a knob or a color", trochoid::quoted(set));
    Some(Failure::usage(found, format!("give the palette as --palette {}", trochoid::quoted(file))))
}

/// Returns what was written and what to do with it, as lines.
fn told(args: &Args, work: &Work) -> String {
    let dir = args.into.display().to_string();
    let count = |tasks: usize| if tasks == 1 { "1 task".into() } else { format!("{tasks} tasks") };
    let joins = match work.joins() {
        0 => String::new(),
        joins => format!(", and {} to join tiles", count(joins)),
    };
    let tasks = count(work.tasks()) + &joins;
    let next = match args.engine {
        Engine::Openjd => {
            // A template holds no paths outside of its folder.
            let paths = [("Graph", Some(&work.graph)), ("Palette", work.palette.as_ref())];
            let given = paths.into_iter().filter_map(|(name, path)| Some(format!("{name}={}", path?)));
            let given = given.filter(|_| args.shared).map(|value| format!(" -p {}", trochoid::quoted(&value)));
            let template = trochoid::quoted_path(&args.into.join("template.json"));
            format!("openjd run {template}{}", given.collect::<String>())
        }
        Engine::Slurm => format!("bash {}", trochoid::quoted_path(&args.into.join("submit.sh"))),
    };
    let memory = work.memory();
    let threads = if work.threads == 1 { "1 thread".into() } else { format!("{} threads", work.threads) };
    let minutes = if work.minutes == 1 { "1 minute".into() } else { format!("{} minutes", work.minutes) };
    format!("{}: {tasks}, of {threads}, {memory} MiB and at most {minutes} each\nrun them: {next}\n", printable(&dir))
}

/// Files of a job: the path in the folder, and what is there.
type Files = Vec<(String, Content)>;
