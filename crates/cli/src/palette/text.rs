//! Palettes as a table.

use super::Found;
use super::write::hex;
use std::fmt::Write as _;
use trochoid_palette::Enclosing;

/// Formats what was found, and the palette that was chosen.
pub(super) fn text(pictures: usize, found: &Found, chosen: &Enclosing) -> String {
    let Found { cloud, brighter, ignored, palettes: found } = found;
    let counted = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let mut text = format!(
        "{} in {} of {}; their hull has {}\n",
        counted(found.distinct as u64, "color"),
        counted(pictures as u64, "picture"),
        counted(cloud.pixels(), "pixel"),
        counted(found.corners as u64, "corner")
    );
    if *ignored > 0 {
        let outside = chosen.outside(cloud);
        let _ = writeln!(
            text,
            "{} ignored; {} outside of this palette{}",
            counted(*ignored, "pixel"),
            outside.pixels,
            if outside.pixels > 0 { format!(", by up to {:.1} steps of 255", outside.largest) } else { String::new() }
        );
    }
    if *brighter > 0 {
        let _ = writeln!(text, "{brighter} pixels are brighter than white, and count as white there");
    }
    let _ = writeln!(text, "\n  colors   hull  farthest");
    for short in &found.short {
        let _ = writeln!(
            text,
            "  {:6}      –         –  {:.2} % of the pixels are outside, by up to {:.1} steps of 255 (rms {:.2})",
            short.colors.len(),
            100.0 * short.outside,
            short.largest,
            short.rms
        );
    }
    for palette in &found.enclosing {
        let farthest = palette.distances.iter().copied().fold(0.0, f64::max);
        let mark = if palette == chosen { '*' } else { ' ' };
        let _ = write!(text, "{mark} {:6} {:6.2} {farthest:9.0}", palette.colors.len(), palette.volume);
        let grid = if palette.units == 1 { String::new() } else { format!("  on a grid of 1/{} step", palette.units) };
        let _ = writeln!(text, "{grid}");
    }
    text.push_str("hull: volume, relative to the pixels' hull; farthest: of its colors from the nearest pixel, in steps of 255\n\n");
    let width = chosen.names.iter().map(String::len).max().unwrap_or(0);
    for (name, color) in chosen.names.iter().zip(&chosen.colors) {
        let color = match chosen.units {
            1 => hex(*color),
            _ => format!("[{:.6}, {:.6}, {:.6}]", color[0], color[1], color[2]),
        };
        let _ = writeln!(text, "  {name:width$}  {color}");
    }
    text
}
