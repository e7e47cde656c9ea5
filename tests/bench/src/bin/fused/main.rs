//! Comparison of the engine with C code for single graphs: random graphs of about 60 nodes, each also as a single loop.
//!
//! `cargo run --release -p trochoid-bench --bin fused -- [--seeds 1-10] [--keep DIR]` makes a document for every seed,
//! over four masks and a field that are bound as buffers, and the C of the same graph: all nodes in one loop over the
//! pixels, in local variables, with plain mixes `a + (b - a) * t`, constants folded, and what depends on x alone in a
//! table. It compares the results and times both in turn on one thread. The passes are noise, so that no mask is 0 or 1
//! on a whole chunk and the engine cannot jump over branches; the C jumps over none.
//!
//! `--keep` writes the documents and the C. Two of them lie beside this file, to be read: `seed_3.json` with
//! `seed_3.c`, and `seed_7.json` with `seed_7.c`. The C compiler is `CC`, or else `cc`.

mod c;
mod graph;

use graph::{Draw, Graph, HEIGHT, PASSES, WIDTH};
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::time::Instant;
use trochoid::{Buffers, Cache, Frame, Judging, Plan, Plane, Settings, Silent, Window};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// How the C is compiled. What would change results beyond rounding (`-ffast-math`) is left out.
const FLAGS: [&str; 5] = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"];
/// Number of blocks of each program, which run in turn.
const BLOCKS: usize = 9;
/// Runs in a block; the first is not counted, because it finds the other program's data in the cache.
const RUNS: usize = 8;
/// Rounding of both programs, through up to 60 nodes.
const TOLERANCE: f32 = 2e-6;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let (seeds, keep) = arguments()?;
    let folder = tempfile::tempdir()?;
    let passes = passes()?;
    let file = folder.path().join("passes.f32");
    let bytes: Vec<u8> = passes.iter().flat_map(Plane::samples).flat_map(|value| value.to_ne_bytes()).collect();
    std::fs::write(&file, bytes)?;
    println!("ns a pixel, one thread, {WIDTH} x {HEIGHT}: median of {BLOCKS} blocks (least of all runs)");
    println!("seed  nodes  mixes         engine               C         ratio  difference");
    let (mut ratios, mut ratios_least) = (Vec::new(), Vec::new());
    for seed in seeds {
        let graph = Graph::random(seed);
        let code = c::code(&graph);
        let document = graph.json();
        if let Some(keep) = &keep {
            std::fs::create_dir_all(keep)?;
            std::fs::write(keep.join(format!("seed_{seed}.json")), &document)?;
            std::fs::write(keep.join(format!("seed_{seed}.c")), &code.text)?;
        }
        let mut peer = Peer::start(folder.path(), &code.text, &file)?;
        let found = compare(&document, &passes, &mut peer, &folder.path().join("result.f32"))?;
        let [(engine, least), (fused, least_fused)] = [&found.engine, &found.fused].map(|times| summary(times));
        let (ratio, ratio_least) = (engine / fused, least / least_fused);
        println!(
            "{seed:>4}  {:>5}  {:>5}  {engine:>6.2} ({least:>5.2})  {fused:>6.2} ({least_fused:>5.2})  \
             {ratio:>5.2} ({ratio_least:.2})  {:>10.1e}",
            graph.nodes.len() - PASSES.len(),
            code.mixes,
            found.difference
        );
        if found.difference.is_nan() || found.difference > TOLERANCE {
            return Err(format!("seed {seed}: the results differ by {:e}", found.difference).into());
        }
        ratios.push(ratio);
        ratios_least.push(ratio_least);
    }
    ratios.sort_by(f64::total_cmp);
    ratios_least.sort_by(f64::total_cmp);
    if let (Some(worst), Some(worst_least)) = (ratios.last(), ratios_least.last()) {
        let medians = [&ratios, &ratios_least].map(|ratios| median(ratios));
        println!("worst ratio {worst:.2} ({worst_least:.2}), median {:.2} ({:.2})", medians[0], medians[1]);
    }
    Ok(())
}

/// Parses the seeds, and the folder to keep files in.
fn arguments() -> Result<(RangeInclusive<u64>, Option<PathBuf>)> {
    let usage = "usage: fused [--seeds 1-10] [--keep DIR]";
    let (mut seeds, mut keep) = (1..=10, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or(usage)?;
        match argument.as_str() {
            "--seeds" => {
                let (first, last) = value.split_once('-').unwrap_or((&value, &value));
                let number = |text: &str| text.parse().map_err(|_| format!("found the seeds \"{value}\"; {usage}"));
                seeds = number(first)?..=number(last)?;
            }
            "--keep" => keep = Some(PathBuf::from(value)),
            _ => return Err(format!("found \"{argument}\"; {usage}").into()),
        }
    }
    Ok((seeds, keep))
}

/// Makes four masks and a field of 0 to 1000, all noise.
fn passes() -> Result<Vec<Plane>> {
    let mut draw = Draw::new(0);
    let mut planes = Vec::new();
    for (index, name) in PASSES.iter().enumerate() {
        let scale = if *name == "z" { 1000.0 } else { 1.0 };
        // After the three planes of the result, so that all eight lie at different places of a page.
        let mut plane = Plane::zeroed(Window::sized(WIDTH as u32, HEIGHT as u32), 4 + index)?;
        plane.samples_mut().fill_with(|| scale * draw.unit());
        planes.push(plane);
    }
    Ok(planes)
}

/// Seconds of runs, block by block, and the largest difference of any value.
struct Found {
    engine: Vec<Vec<f64>>,
    fused: Vec<Vec<f64>>,
    difference: f32,
}

fn compare(document: &str, passes: &[Plane], peer: &mut Peer, result: &Path) -> Result<Found> {
    let loaded = trochoid::parse("random.json", document, Path::new("."), &[])?;
    let mut settings = Settings::default();
    settings.threads = 1;
    // The C checks nothing. The engine still checks all weights and the palette's box at every pixel.
    settings.judge = Judging::Sampled;
    let plan = Plan::new(&loaded.graph, &["out"], 1, &PASSES, &settings)?;
    let mut buffers = Buffers::new();
    for (name, plane) in PASSES.iter().zip(passes) {
        buffers = buffers.with(name, &[plane.samples()]);
    }
    let (mut frame, mut cache) = (Frame::default(), Cache::new());
    let mut evaluate = |frame: &mut Frame| plan.evaluate_into(frame, &buffers, &mut cache, &Silent);
    evaluate(&mut frame)?;
    peer.run(1)?;
    let planes = &frame.pictures[0].planes;
    let expected = peer.result(result)?;
    let mut difference = 0.0_f32;
    for (found, expected) in planes.iter().flat_map(Plane::samples).zip(&expected) {
        let off = (found - expected).abs();
        // NaN counts as a difference.
        difference = if off <= difference { difference } else { off };
    }
    let mut found = Found { engine: Vec::new(), fused: Vec::new(), difference };
    for _ in 0..BLOCKS {
        found.fused.push(peer.run(RUNS)?.split_off(1));
        let mut times = Vec::new();
        for run in 0..RUNS {
            let started = Instant::now();
            evaluate(&mut frame)?;
            if run > 0 {
                times.push(started.elapsed().as_secs_f64());
            }
        }
        found.engine.push(times);
    }
    Ok(found)
}

/// Returns the median; of an even number, the mean of both in the middle.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 }
}

/// Returns the median of all blocks' medians, and the shortest time, in ns per pixel.
fn summary(blocks: &[Vec<f64>]) -> (f64, f64) {
    let sorted = |values: &[f64]| {
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        values
    };
    let medians: Vec<f64> = blocks.iter().map(|block| median(&sorted(block))).collect();
    let least = blocks.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let scale = 1e9 / (WIDTH * HEIGHT) as f64;
    (median(&sorted(&medians)) * scale, least * scale)
}

/// The C program, which waits for requests.
struct Peer {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    fn start(folder: &Path, code: &str, passes: &Path) -> Result<Self> {
        let (source, program) = (folder.join("fused.c"), folder.join("fused"));
        std::fs::write(&source, code)?;
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let compiled = Command::new(&compiler)
            .args(FLAGS)
            .arg(&source)
            .arg("-o")
            .arg(&program)
            .status()
            .map_err(|error| format!("the C compiler \"{compiler}\" cannot be started: {error}; name one in CC"))?;
        if !compiled.success() {
            return Err(format!("the C compiler \"{compiler}\" failed").into());
        }
        let mut process = Command::new(&program).arg(passes).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let missing = "the C program has no standard input or output";
        let requests = process.stdin.take().ok_or(missing)?;
        let answers = BufReader::new(process.stdout.take().ok_or(missing)?);
        Ok(Self { process, requests, answers })
    }

    fn ask(&mut self, request: &str) -> Result<String> {
        let stopped = |error: &dyn std::fmt::Display| format!("the C program stopped: {error}");
        writeln!(self.requests, "{request}").map_err(|error| stopped(&error))?;
        let mut answer = String::new();
        if self.answers.read_line(&mut answer)? == 0 {
            return Err(stopped(&"it gave no answer").into());
        }
        Ok(answer)
    }

    /// Returns the seconds of each of `count` runs.
    fn run(&mut self, count: usize) -> Result<Vec<f64>> {
        let answer = self.ask(&format!("run {count}"))?;
        let times: Vec<f64> = answer.split_whitespace().map(str::parse).collect::<std::result::Result<_, _>>()?;
        if times.len() == count { Ok(times) } else { Err("the C program gave too few times".into()) }
    }

    /// Returns all values of the result, channel by channel.
    fn result(&mut self, file: &Path) -> Result<Vec<f32>> {
        self.ask(&format!("write {}", file.display()))?;
        let bytes = std::fs::read(file)?;
        if bytes.len() != 12 * WIDTH * HEIGHT {
            return Err(format!("the C program wrote {} bytes", bytes.len()).into());
        }
        Ok(bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // The program ends when its input ends, or here; an error means that it has ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
