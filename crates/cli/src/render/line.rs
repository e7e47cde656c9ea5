//! The line that is printed for a frame.

use crate::shell::printable;
use trochoid::accuracy::displayed_of;
use trochoid::{Certified, CheckedGraph, Frame, OutputFile, held};

/// Formats the line of a rendered frame: `frame 12: beauty → out/storm.0012.exr  hull, 0 outside, 1.42 s`. If the frame
/// is certified, the line has the errors of displayed values.
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
        facts.push(format!("{}, {exits} outside", class.name()));
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
    facts.extend(certainty(graph, certified));
    facts.push(format!("{seconds:.2} s"));
    format!("frame {}: {}  {}\n", frame.number, places.join(", "), facts.join(", "))
}

/// Formats the certified errors of all outputs together: `display error ≤ 3.1e-7, or 0.31 where ambiguous, 0.80 %
/// ambiguous`. They are those of displayed values; of fields, which are not displayed, only if nothing else is certified.
fn certainty(graph: &CheckedGraph, certified: &[Certified]) -> Option<String> {
    let shown = |certified: &&Certified| displayed_of(certified.kind, 0.0, graph.space()).is_some();
    let displayed: Vec<&Certified> = certified.iter().filter(shown).collect();
    let (of, what) = if displayed.is_empty() {
        (certified.iter().collect(), "error of fields")
    } else {
        (displayed, "display error")
    };
    let total = |samples: &dyn Fn(&Certified) -> u64| of.iter().map(|certified| samples(certified)).sum::<u64>();
    let [clear, unclear] = [total(&|certified| certified.clear.total()), total(&|certified| certified.unclear.total())];
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
    let largest = |samples: &dyn Fn(&Certified) -> f64| {
        let error = |certified: &&Certified| {
            let error = samples(certified);
            displayed_of(certified.kind, error, graph.space()).unwrap_or(error)
        };
        of.iter().map(error).fold(0.0, f64::max)
    };
    let (max, most) = (largest(&|certified| certified.clear.max()), largest(&|certified| certified.unclear.max()));
    let error = match (clear, unclear) {
        (0, _) => "no error certified".into(),
        _ if max.is_infinite() => "no error certified".into(),
        (_, 0) => format!("{what} ≤ {max:.1e}"),
        _ if most.is_infinite() => format!("{what} ≤ {max:.1e}, or unknown where ambiguous"),
        _ => format!("{what} ≤ {max:.1e}, or {most:.1e} where ambiguous"),
    };
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
