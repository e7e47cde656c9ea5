//! The line that is printed for a frame.

use crate::shell::printable;
use trochoid::{Certified, CheckedGraph, Frame, OutputFile, held};

/// Formats the line of a rendered frame: `frame 12: beauty → out/storm.0012.exr  hull, 0 exits, 1.42 s`. If the frame
/// is certified, the line has the error of the samples that are not ambiguous.
pub(super) fn rendered(
    graph: &CheckedGraph,
    frame: &Frame,
    files: &[(OutputFile, bool)],
    certified: &[Certified],
    seconds: f64,
) -> String {
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
    facts.extend(certainty(certified));
    facts.push(format!("{seconds:.2} s"));
    format!("frame {}: {}  {}\n", frame.number, places.join(", "), facts.join(", "))
}

/// Formats the certified error of all outputs together: `error ≤ 3.1e-7, 0.80 % ambiguous`.
fn certainty(certified: &[Certified]) -> Option<String> {
    let [clear, unclear] =
        certified.iter().fold([0, 0], |[clear, unclear], c| [clear + c.clear.total(), unclear + c.unclear.total()]);
    let share = 100.0 * unclear as f64 / (clear + unclear).max(1) as f64;
    let share = if unclear == 0 {
        "nothing ambiguous".into()
    } else if clear == 0 {
        "all ambiguous".into()
    } else if share < 0.01 {
        "less than 0.01 % ambiguous".into()
    } else {
        format!("{share:.2} % ambiguous")
    };
    let max = certified.iter().map(|certified| certified.clear.max()).fold(0.0, f64::max);
    let error =
        if clear == 0 || max.is_infinite() { "no error certified".into() } else { format!("error ≤ {max:.1e}") };
    (!certified.is_empty()).then(|| format!("{error}, {share}"))
}

/// Formats the line of a skipped frame: `frame 12: beauty → out/storm.0012.exr  up to date`.
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
