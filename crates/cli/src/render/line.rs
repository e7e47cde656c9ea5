//! The line that is printed for a frame.

use crate::shell::printable;
use trochoid::accuracy::displayed_of;
use trochoid::certificate::{BoundSummary, CertifiedOutput};
use trochoid::{CheckedGraph, Frame, OutputFile, held};

/// Formats the line of a rendered frame: `frame 12: beauty → out/storm.0012.exr  hull, 0 outside, 1.42 s`. If the frame
/// is certified, the line has the errors of displayed values.
pub(super) fn rendered(
    graph: &CheckedGraph,
    frame: &Frame,
    files: &[(OutputFile, bool)],
    certified: &[CertifiedOutput],
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

/// Formats the certified errors of the pixels of all outputs together: `display error ≤ 9.6e-2 (7.8e-3 for 99.9 %), or
/// 0.92 where ambiguous, 1.41 % of the pixels ambiguous`. They are those of displayed values; of fields, which are not
/// displayed, only if nothing else is certified.
fn certainty(graph: &CheckedGraph, certified: &[CertifiedOutput]) -> Option<String> {
    let is_displayed = |output: &&CertifiedOutput| {
        let spec = graph.outputs().iter().find(|spec| spec.name == output.name);
        spec.is_some_and(|spec| displayed_of(spec.kind, 0.0, graph.space()).is_some())
    };
    let displayed: Vec<&CertifiedOutput> = certified.iter().filter(is_displayed).collect();
    let (of, what) = if displayed.is_empty() {
        (certified.iter().collect(), "error of fields")
    } else {
        (displayed, "display error")
    };
    let pixels = graph.format().window().area() as u64 * of.len() as u64;
    let unclear: u64 = of.iter().map(|output| output.error.ambiguous.pixels).sum();
    let share = 100.0 * unclear as f64 / pixels.max(1) as f64;
    let share = if unclear == 0 {
        "nothing ambiguous".into()
    } else if unclear == pixels {
        "all ambiguous".into()
    } else if share < 0.01 {
        "less than 0.01 % of the pixels ambiguous".into()
    } else {
        format!("{share:.2} % of the pixels ambiguous")
    };
    // Of all pixels, and of those that are not ambiguous.
    let summaries = |output: &&CertifiedOutput| match &output.error.display {
        Some(display) => vec![[display.all, display.clear]],
        None => output.error.channels.iter().map(|channels| [channels.all, channels.clear]).collect(),
    };
    let summaries: Vec<[BoundSummary; 2]> = of.iter().flat_map(summaries).collect();
    let largest = |which: usize| {
        let each = summaries.iter().map(|summaries| &summaries[which]);
        let is_known = each.clone().all(|summary| summary.unbounded == 0);
        is_known.then(|| each.filter_map(|summary| Some(summary.max?.bound)).fold(0.0, f64::max))
    };
    let usual = summaries.iter().filter_map(|[_, clear]| Some(clear.p999?.bound)).fold(0.0, f64::max);
    let error = match (largest(1), largest(0)) {
        _ if unclear == pixels => "no error certified".into(),
        (None, _) => "no error certified".into(),
        (Some(max), all) => {
            let clear = format!("{what} ≤ {max:.1e} ({usual:.1e} for 99.9 %)");
            match all {
                _ if unclear == 0 => clear,
                Some(all) => format!("{clear}, or {all:.1e} where ambiguous"),
                None => format!("{clear}, or unknown where ambiguous"),
            }
        }
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
