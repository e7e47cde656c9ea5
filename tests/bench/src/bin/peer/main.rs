//! Work that other programs do as well, so that both can be timed side by side.
//!
//! `peer CASE` prepares itself, does the work once, prints one line of JSON with the error of its result (null where it
//! only reads), and then, for each line `run N` on stdin, does the work N times and prints how long each took; `quit`
//! ends it. Cases: `W1:uhd` and `W1:hd` evaluate a graph of nine mixes on five passes in memory; `io:uhd:half:zip` and
//! the like read or write an EXR file; `W2` and `W2:1e-6` sum waves on a grid, to 5e-4 or the given error; `W3:100`
//! and `W3:10000` take steps of a toon sea with so many bursts. Inputs lie in the folder `PEER_WORK`; `PEER_THREADS`
//! (default: all cores), `PEER_INSTRUCTIONS` (`avx2`, `baseline`) and `PEER_MACHINE_CODE` (`never`) choose what is
//! used.

use std::error::Error;
use std::io::{BufRead, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;
use trochoid::io::{EncodeScratch, ExrHeader, ExrWriter, Limits, SampleType, Selection, read};
use trochoid::{Buffers, Cache, Frame, Instructions, Judging, Plan, Plane, Settings, Silent, Window};

mod w2;
mod w3;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Graph of W1.
const W1: &str = include_str!("w1.json");

fn main() -> Result<()> {
    let case = std::env::args().nth(1).ok_or("usage: peer CASE")?;
    let work =
        PathBuf::from(std::env::var("PEER_WORK").map_err(|_| "PEER_WORK is not set: name the folder of the inputs")?);
    let parts: Vec<&str> = case.split(':').collect();
    match parts[..] {
        ["W1", size] => w1(&work, size),
        ["W2"] => w2::run(&work, "5e-4"),
        ["W2", tolerance] => w2::run(&work, tolerance),
        ["W3", bursts] => w3::run(&work, bursts),
        ["io", size, kind, "write"] => write(&work, size, kind),
        ["io", size, kind, compression] => reading(&work, &format!("w1_{size}_{kind}_{compression}.exr")),
        _ => {
            let cases = "W1:SIZE, W2, W2:TOLERANCE, W3:BURSTS or io:SIZE:KIND:COMPRESSION";
            Err(format!("found the case \"{case}\"; expected {cases}").into())
        }
    }
}

/// Answers requests until the end of stdin.
fn serve(error: Option<f64>, note: &str, mut work: impl FnMut() -> Result<()>) -> Result<()> {
    println!("{}", serde_json::json!({ "ready": true, "setup_s": 0.0, "error": error, "note": note }));
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let mut words = line.split_whitespace();
        let (Some("run"), Some(count)) = (words.next(), words.next()) else { break };
        let mut times = Vec::new();
        for _ in 0..count.parse::<usize>()? {
            let started = Instant::now();
            work()?;
            times.push(started.elapsed().as_secs_f64());
        }
        println!("{}", serde_json::json!({ "times": times }));
        std::io::stdout().flush()?;
    }
    Ok(())
}

fn settings() -> Result<Settings> {
    let mut settings = Settings::default();
    if let Ok(threads) = std::env::var("PEER_THREADS") {
        settings.threads = threads.parse()?;
    }
    settings.instructions = match std::env::var("PEER_INSTRUCTIONS").as_deref() {
        Ok("avx2") => Instructions::Avx2,
        Ok("baseline") => Instructions::Baseline,
        _ => Instructions::Best,
    };
    settings.switches.compile = std::env::var("PEER_MACHINE_CODE").as_deref() != Ok("never");
    // The other programs check nothing. The engine still checks all weights and the palette's box at every pixel.
    settings.judge = Judging::Sampled;
    Ok(settings)
}

/// Returns the f32 numbers of a NumPy file.
fn numbers(path: &Path) -> Result<Vec<f32>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path).map_err(|error| format!("{}: {error}", path.display()))?.read_to_end(&mut bytes)?;
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    Ok(bytes[header..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// W1 in memory: five passes bound as buffers, one color output.
fn w1(work: &Path, size: &str) -> Result<()> {
    let (width, height) = if size == "hd" { (1920, 1080) } else { (3840, 2160) };
    let text = W1.replace("\"width\": 3840", &format!("\"width\": {width}"));
    let text = text.replace("\"height\": 2160", &format!("\"height\": {height}"));
    let loaded = trochoid::parse("peer_w1.json", &text, Path::new("."), &[])?;
    let names = ["c", "s", "f", "a", "z"];
    let window = Window::sized(width, height);
    let mut passes = Vec::new();
    for (index, name) in names.iter().enumerate() {
        // After the three planes of the result, so that all eight lie at different places of a page.
        let mut plane = Plane::zeroed(window, 4 + index)?;
        plane.samples_mut().copy_from_slice(&numbers(&work.join(format!("w1_{size}_{name}.npy")))?);
        passes.push(plane);
    }
    let mut buffers = Buffers::new();
    for (name, plane) in names.iter().zip(&passes) {
        buffers = buffers.with(name, &[plane.samples()]);
    }
    let plan = Plan::new(&loaded.graph, &["beauty"], 1, &names, &settings()?)?;
    let mut frame = Frame::default();
    let mut cache = Cache::new();
    plan.evaluate_into(&mut frame, &buffers, &mut cache, &Silent)?;
    let expected = numbers(&work.join(format!("w1_{size}_ref_float.npy")))?;
    let mut error = 0.0f64;
    for (channel, plane) in frame.pictures[0].planes.iter().enumerate() {
        for (found, expected) in plane.samples().iter().zip(expected[channel..].iter().step_by(3)) {
            let off = f64::from((found - expected).abs());
            // NaN counts as an error.
            error = if off <= error { error } else { off };
        }
    }
    let audit = frame.pictures[0].audit;
    let note = format!(
        "planar, {} threads, {} exits, {} of {} pixels judged one by one",
        frame.threads, audit.hull_exits, audit.judged, audit.pixels
    );
    serve(Some(error), &note, || Ok(plan.evaluate_into(&mut frame, &buffers, &mut cache, &Silent)?))
}

/// Reads five channels of a file to f32 planes.
fn reading(work: &Path, file: &str) -> Result<()> {
    let path = work.join(file);
    let selection = Selection::channels(["sea.c.V", "sea.s.V", "sea.f.V", "sea.a.V", "sea.z.V"]);
    let once = || -> Result<()> {
        std::hint::black_box(read(&path, &selection, &Limits::default())?);
        Ok(())
    };
    once()?;
    serve(None, "five channels to f32 planes", once)
}

/// Writes RGB as half or float, with ZIP.
fn write(work: &Path, size: &str, kind: &str) -> Result<()> {
    let (width, height) = if size == "hd" { (1920, 1080) } else { (3840, 2160) };
    let window = Window::sized(width, height);
    let pixels = numbers(&work.join(format!("w1_{size}_ref_float.npy")))?;
    let planes: Vec<Vec<f32>> = (0..3).map(|c| pixels[c..].iter().step_by(3).copied().collect()).collect();
    let sample_type = if kind == "half" { SampleType::Half } else { SampleType::Float };
    let path = work.join(format!("out_trochoid_{size}.exr"));
    let header = ExrHeader {
        channels: ["R", "G", "B"].map(|name| (name.to_string(), sample_type)).into(),
        ..ExrHeader::new(window)
    };
    let once = || -> Result<()> {
        let writer = ExrWriter::create(&path, &header)?;
        let next = std::sync::atomic::AtomicUsize::new(0);
        let encode = || -> std::result::Result<(), trochoid::io::Error> {
            let mut scratch = EncodeScratch::new();
            loop {
                let band = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                if band >= writer.bands() {
                    return Ok(());
                }
                let rows = writer.band_window(band);
                let range = rows.y0 as usize * rows.width()..rows.y1 as usize * rows.width();
                let rows: Vec<&[f32]> = planes.iter().map(|plane| &plane[range.clone()]).collect();
                writer.push(writer.encode(band, &rows, &mut scratch)?)?;
            }
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            let others: Vec<_> = (1..threads).map(|_| scope.spawn(encode)).collect();
            encode()?;
            others.into_iter().try_for_each(|other| other.join().unwrap_or(Ok(())))
        })?;
        Ok(writer.finish(&[])?)
    };
    once()?;
    let written = read(&path, &Selection::channels(["R", "G", "B"]), &Limits::default())?;
    let mut error = 0.0f64;
    for (channel, plane) in written.channels.iter().zip(&planes) {
        for (found, expected) in channel.plane.samples().iter().zip(plane) {
            error = error.max(f64::from((found - expected).abs()));
        }
    }
    serve(Some(error), "half ZIP, atomic, on disk", once)
}
