mod curve;
mod edits;
pub(crate) mod groups;
mod kept;
mod moved;
mod places;
mod random;
mod swatches;

use super::Session;

/// A small document with everything that edits touch.
pub(super) const SMALL: &str = r##"{
  "trochoid": 1,
  "format": { "width": 8, "height": 4 },
  "nodes": {
    "across": { "type": "ScreenX" },
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" },
      { "at": 1, "color": "#f0cf8e" }
    ] },
    "sea": { "type": "Mix", "a": "#14262e", "b": "sky", "weight": "across" },
    "both": { "type": "Blend", "colors": ["sky", "sea"], "weights": [0.25, 0.75] },
    "soft": { "type": "Blur", "image": "both", "size": 2 }
  },
  "outputs": { "beauty": { "color": "soft" } }
}
"##;

pub(super) fn small() -> Session {
    let session = Session::new(SMALL.into(), None);
    assert!(session.meaning().graph.is_some(), "{:?}", session.meaning().diagnostics);
    session
}
