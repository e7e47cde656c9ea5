//! One line a frame.

use crate::shell::printable;
use trochoid::{CheckedGraph, Frame, OutputFile, held};

/// `frame 12: beauty → out/storm.0012.exr  hull, 0 exits, 1.42 s`.
pub(super) fn rendered(graph: &CheckedGraph, frame: &Frame, files: &[(OutputFile, bool)], seconds: f64) -> String {
    let places: Vec<String> = files.iter().map(|(file, written)| place(graph, file, *written)).collect();
    let colors = || frame.pictures.iter().filter(|picture| picture.guarantee.is_some());
    let mut facts = Vec::new();
    if let Some(class) = colors().filter_map(|picture| picture.guarantee).min() {
        let exits: u64 = colors().map(|picture| picture.audit.hull_exits).sum();
        facts.push(format!("{}, {exits} exits", class.name()));
        let nan: u64 = colors().filter(|picture| held(picture).is_none()).map(|picture| picture.audit.nan_count).sum();
        if nan > 0 {
            facts.push(format!("{nan} NaN"));
        }
    }
    let repaired: u64 = frame.nodes.iter().map(|node| node.repaired).sum();
    if repaired > 0 {
        let names: Vec<&str> =
            frame.nodes.iter().filter(|node| node.repaired > 0).map(|node| node.name.as_str()).collect();
        facts.push(format!("{repaired} illegal values (NaN) replaced in {}", printable(&names.join(", "))));
    }
    facts.push(format!("{seconds:.2} s"));
    format!("frame {}: {}  {}\n", frame.number, places.join(", "), facts.join(", "))
}

/// `frame 12: beauty → out/storm.0012.exr  up to date`.
pub(super) fn skipped(graph: &CheckedGraph, frame: i64, files: &[OutputFile]) -> String {
    let places: Vec<String> = files.iter().map(|file| place(graph, file, true)).collect();
    format!("frame {frame}: {}  up to date\n", places.join(", "))
}

fn place(graph: &CheckedGraph, file: &OutputFile, written: bool) -> String {
    let names: Vec<&str> = file.outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
    let names = names.join(" + ");
    if written {
        format!("{names} → {}", printable(&file.path.display().to_string()))
    } else {
        format!("{names} not written")
    }
}
