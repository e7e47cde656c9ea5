mod curves;
mod document_knobs;
mod drops;
mod faults;
mod files;
mod find;
mod formulas;
mod graph;
mod groups;
mod help;
mod keys;
mod lasting;
mod leaving;
mod linking;
mod looking;
mod looks;
mod modules;
mod palette;
mod panels;
mod parts;
mod play;
mod presets;
mod reach;
mod safety;
mod second;
mod several;
mod sight;
#[cfg(feature = "snapshots")]
mod snapshots;
mod steady;
mod told;
mod transforms;
mod typing;
mod versions;
mod waves;
mod welcome;

use crate::document::Session;

/// A ramp that a mask darkens.
const DUSK: &str = r##"{
  "trochoid": 1,
  "format": { "width": 48, "height": 27 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 8, "fps": 24 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [ { "at": 0, "color": "#2d3f52" }, { "at": 1, "color": "#f0cf8e" } ] },
    "dusk": { "type": "Mix", "a": "sky", "b": "#14262e", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "dusk", "file": "dusk.####.png" } }
}
"##;

fn dusk() -> Session {
    Session::new(DUSK.into(), None)
}
