//! Comparison of rays with Embree: the same rays and the same triangles, in turn, on one thread.
//!
//! `PYTHON=VENV/bin/python cargo run --release -p trochoid-bench --bin rays [--runs N]`; the Python needs `numpy` and
//! `embreex`, which asks Embree about one ray after another. The rays are those of a teapot's shadows and of light
//! through a storm (`crates/scene/benches/rays/scenes.rs`). Times are of answers alone, without building trees.
//! The last column counts rays of which only one of both says that they meet something.

#[path = "../../../../../crates/scene/benches/rays/scenes.rs"]
mod scenes;

use scenes::{Question, Scene};
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::time::Instant;
use trochoid_scene::{Obstacles, Segment, Surface, inside};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Rays that are asked for together, as for a block of a picture.
const TOGETHER: usize = 64;
/// What Python runs.
const SCRIPT: &str = include_str!("embree.py");

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
    let runs = runs()?;
    println!("million rays a second, one thread, from the median of {runs} runs");
    println!("scene   rays                 number  built   triangles      own   Embree   time, own/Embree   differ");
    for (name, scene) in [("teapot", scenes::teapot as fn() -> Scene), ("storm", scenes::storm)] {
        let scene = scene();
        let surfaces: Vec<&dyn Surface> = scene.surfaces.iter().map(AsRef::as_ref).collect();
        let started = Instant::now();
        let obstacles = Obstacles::new(&scene.projector, &surfaces);
        let built = started.elapsed().as_secs_f64();
        let folder = tempfile::tempdir()?;
        let (origin, triangles) = inside::triangles(&obstacles);
        write(&folder.path().join("triangles.f32"), triangles.as_flattened().as_flattened())?;
        for (index, question) in scene.questions.iter().enumerate() {
            let rays = question.segments.iter().flat_map(|Segment { ray, limit }| {
                let [a, b, c] = (ray.origin - origin).to_array();
                let [x, y, z] = ray.direction.to_array();
                [a, b, c, x, y, z, *limit].map(|value| value as f32)
            });
            write(&folder.path().join(format!("{index}.f32")), &rays.collect::<Vec<f32>>())?;
        }
        let mut peer = Peer::start(folder.path())?;
        for (index, question) in scene.questions.iter().enumerate() {
            let Question { name: kind, any, segments } = question;
            let order = format!("{index} {}", if *any { "any" } else { "first" });
            let (mut own, mut embree) = (Vec::new(), Vec::new());
            let mut found = Vec::new();
            for _ in 0..runs {
                let started = Instant::now();
                found = answers(&obstacles, *any, segments);
                own.push(started.elapsed().as_secs_f64());
                embree.push(peer.ask(&format!("time {order}"))?.trim().parse::<f64>()?);
            }
            peer.ask(&format!("answer {order}"))?;
            let theirs = std::fs::read(folder.path().join("answers"))?;
            if theirs.len() != found.len() {
                return Err(format!("{} answers about {} rays", theirs.len(), found.len()).into());
            }
            let differ = found.iter().zip(&theirs).filter(|(own, theirs)| **own != (**theirs == 1)).count();
            let [own, embree] = [own, embree].map(median);
            let pace = |seconds: f64| segments.len() as f64 / seconds / 1e6;
            println!(
                "{name:<7} {kind:<18} {:>8} {:>4.0} ms {:>11} {:>8.2} {:>8.2} {:>18.2} {differ:>8}",
                segments.len(),
                1e3 * built,
                triangles.len(),
                pace(own),
                pace(embree),
                own / embree
            );
        }
    }
    Ok(())
}

fn runs() -> Result<usize> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.as_slice() {
        [] => Ok(9),
        [option, runs] if option == "--runs" => Ok(runs.parse::<usize>()?.max(1)),
        _ => Err(format!("{} is not understood; expected --runs N, or nothing", arguments.join(" ")).into()),
    }
}

/// Returns whether each ray meets something.
fn answers(obstacles: &Obstacles, any: bool, segments: &[Segment]) -> Vec<bool> {
    let mut answers = Vec::with_capacity(segments.len());
    for segments in segments.chunks(TOGETHER) {
        if any {
            answers.extend(obstacles.blocks(segments).iter().copied());
        } else {
            answers.extend(obstacles.first(segments).iter().map(Option::is_some));
        }
    }
    answers
}

fn write(path: &Path, values: &[f32]) -> Result<()> {
    Ok(std::fs::write(path, values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())?)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Embree in a process of its own.
struct Peer {
    child: Child,
    orders: ChildStdin,
    replies: BufReader<ChildStdout>,
}

impl Peer {
    fn start(folder: &Path) -> Result<Self> {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        let mut command = Command::new(python);
        command.args(["-c", SCRIPT]).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn()?;
        let orders = child.stdin.take().ok_or("no pipe to Python")?;
        let replies = BufReader::new(child.stdout.take().ok_or("no pipe from Python")?);
        Ok(Self { child, orders, replies })
    }

    /// Gives an order, and returns the line of its reply.
    fn ask(&mut self, order: &str) -> Result<String> {
        writeln!(self.orders, "{order}")?;
        self.orders.flush()?;
        let mut reply = String::new();
        if self.replies.read_line(&mut reply)? == 0 {
            return Err("Python has ended; PYTHON must name one with numpy and embreex".into());
        }
        Ok(reply)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
