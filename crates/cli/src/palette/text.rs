//! Palettes as a table.

use super::Found;
use super::write::hex;
use std::fmt::Write as _;
use trochoid_palette::{MOST_COLORS, Outside};

/// Formats what was found, and the palette that was chosen.
pub(super) fn text(found: &Found) -> String {
    let Found { cloud, palettes, chosen, .. } = found;
    let counted = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let mut text = format!(
        "{} in {} of {}",
        counted(cloud.colors().count() as u64, "color"),
        counted(found.pictures.len() as u64, "picture"),
        counted(cloud.pixels(), "pixel"),
    );
    if palettes.corners > 0 {
        let _ = write!(text, "; their hull has {}", counted(palettes.corners as u64, "corner"));
    }
    text.push('\n');
    let outside = chosen.outside(cloud);
    let is_exact = found.ignored == 0 && outside.pixels == 0;
    if found.ignored > 0 {
        let _ = write!(text, "{} ignored; ", counted(found.ignored, "pixel"));
    }
    if !is_exact {
        let farthest = if outside.pixels > 0 { beyond(&outside) } else { String::new() };
        let _ = writeln!(text, "{} outside of this palette{farthest}", counted(outside.pixels, "pixel"));
    }
    if found.brighter > 0 {
        let _ = writeln!(text, "{} brighter than white, and white there", counted(found.brighter, "pixel"));
    }
    if found.transparent > 0 {
        let _ = writeln!(text, "{} transparent, and left out", counted(found.transparent, "pixel"));
    }
    if palettes.corners > 0 {
        table(&mut text, found);
    }
    text.push('\n');
    let width = chosen.names.iter().map(String::len).max().unwrap_or(0);
    let inner = chosen.inner();
    for (index, (name, color)) in chosen.names.iter().zip(&chosen.colors).enumerate() {
        let color = match chosen.units {
            1 => hex(*color),
            _ => format!("[{:.6}, {:.6}, {:.6}]", color[0], color[1], color[2]),
        };
        let prior = match (index < found.prior, inner.contains(&index)) {
            (true, true) => "  prior, in the hull of the others",
            (true, false) => "  prior",
            _ => "",
        };
        let _ = writeln!(text, "  {name:width$}  {color}{prior}");
    }
    if chosen.names.len() > MOST_COLORS {
        let count = chosen.names.len();
        let _ =
            writeln!(text, "\n{count} colors are more than `decompose` takes: at most {MOST_COLORS}. Leave some out.");
    }
    text
}

fn beyond(outside: &Outside) -> String {
    format!(", by up to {:.1} steps of 255", outside.largest)
}

/// Writes what each number of colors costs.
fn table(text: &mut String, found: &Found) {
    let Found { cloud, palettes, chosen, .. } = found;
    text.push_str("\n  colors   hull  farthest\n");
    for short in &palettes.short {
        let _ = writeln!(
            text,
            "  {:6}      –         –  {:.2} % of the pixels are outside{} (rms {:.2})",
            short.colors.len(),
            100.0 * short.share,
            beyond(&short.outside),
            short.outside.rms
        );
    }
    for own in &palettes.enclosing {
        let farthest = own.distances.iter().copied().fold(0.0, f64::max);
        let mark = if own.palette == *chosen { '*' } else { ' ' };
        let _ = write!(text, "{mark} {:6} {:6.2} {farthest:9.0}", own.count(), own.volume);
        if own.outside.pixels > 0 {
            let share = 100.0 * own.outside.pixels as f64 / cloud.pixels().max(1) as f64;
            let _ = write!(text, "  {share:.2} % of the pixels are outside{}", beyond(&own.outside));
        }
        let grid = match own.palette.units {
            1 => String::new(),
            units => format!("  on a grid of 1/{units} step"),
        };
        let _ = writeln!(text, "{grid}");
    }
    text.push_str(
        "hull: volume, relative to the pixels' hull; farthest: of its colors from the nearest pixel, in steps of 255\n",
    );
}
