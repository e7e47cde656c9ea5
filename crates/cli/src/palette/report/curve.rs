//! Plot of what each number of colors costs, as SVG.

use super::super::Found;
use std::fmt::Write as _;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 330.0;
/// Room for the axes: left, top, right, bottom.
const ROOM: [f64; 4] = [56.0, 40.0, 24.0, 62.0];
/// Volume up to which a palette is quiet.
const QUIET: f64 = 2.5;

/// Draws the volume of the hulls over the number of colors; `None` with fewer than two palettes of a volume.
pub(super) fn curve(found: &Found) -> Option<String> {
    let solid = found.palettes.enclosing.iter().filter(|own| own.volume > 0.0);
    let points: Vec<(usize, f64, bool)> =
        solid.map(|own| (own.count(), own.volume, own.palette == found.chosen)).collect();
    if points.len() < 2 {
        return None;
    }
    let (first, last) = (points[0].0 as f64, points[points.len() - 1].0 as f64);
    let volumes = points.iter().map(|point| point.1).chain([1.0, QUIET]);
    let (low, high) = volumes.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    let (low, high) = (low / 1.15, high * 1.15);
    let x = |count: f64| ROOM[0] + 24.0 + (count - first) / (last - first) * (WIDTH - ROOM[0] - ROOM[2] - 48.0);
    let y = |volume: f64| ROOM[1] + (high / volume).ln() / (high / low).ln() * (HEIGHT - ROOM[1] - ROOM[3]);
    let mut svg = format!(
        "<svg class=\"curve\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-labelledby=\"curve-title\">\n"
    );
    svg.push_str(
        "<title id=\"curve-title\">Volume of the hull over the number of colors; the table has the figures</title>\n",
    );
    let (bottom, right) = (HEIGHT - ROOM[3], WIDTH - ROOM[2]);
    for tick in
        [0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].into_iter().filter(|tick| (low..high).contains(tick))
    {
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tick}</text>",
            ROOM[0],
            ROOM[0] - 8.0,
            y(tick) + 5.0,
            at = y(tick),
        );
    }
    let _ = writeln!(
        svg,
        "<line class=\"quiet\" x1=\"{}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\
         <text class=\"faint\" x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">loud above {QUIET}</text>",
        ROOM[0],
        y(QUIET) - 6.0,
        at = y(QUIET),
    );
    let line: Vec<String> =
        points.iter().map(|(count, volume, _)| format!("{:.1},{:.1}", x(*count as f64), y(*volume))).collect();
    let _ = writeln!(svg, "<polyline class=\"line\" points=\"{}\"/>", line.join(" "));
    for (count, volume, is_chosen) in &points {
        let (at, class) = (x(*count as f64), if *is_chosen { "chosen" } else { "point" });
        let radius = if *is_chosen { 7 } else { 4 };
        let _ = writeln!(
            svg,
            "<circle class=\"{class}\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"{radius}\"/>\
             <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{count}</text>",
            y(*volume),
            bottom + 26.0
        );
    }
    let middle = ROOM[0] + (right - ROOM[0]) / 2.0;
    let _ = writeln!(
        svg,
        "<text class=\"faint\" x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">colors</text>\
         <text class=\"faint\" x=\"{}\" y=\"22\">volume of the hull; 1: that of the pixels</text>\n</svg>",
        HEIGHT - 6.0,
        ROOM[0]
    );
    Some(svg)
}
