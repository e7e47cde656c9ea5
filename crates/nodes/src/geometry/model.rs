//! Model files of Bézier patches.
//!
//! JSON with `points`, `patches` of 4 (bilinear) or 16 (bicubic) point numbers, row by row, and `sheets` of rails that
//! a surface passes through.

use serde::Deserialize;
use std::path::Path;
use trochoid_graph::NodeError;
use trochoid_scene::DVec3;
use trochoid_scene::bezier::{Bicubic, Bilinear, MAX_PATCHES, Patch, Rails};

/// Maximum size of a model file, in bytes.
const MAX_FILE_BYTES: u64 = 8 << 20;
/// Largest coordinate.
const FARTHEST: f64 = 1e9;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    /// Version of the format.
    trochoid_model: u32,
    #[serde(default, rename = "notes")]
    _notes: serde::de::IgnoredAny,
    #[serde(default)]
    points: Vec<[f64; 3]>,
    #[serde(default)]
    patches: Vec<Vec<u32>>,
    #[serde(default)]
    sheets: Vec<Sheet>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    #[serde(default, rename = "notes")]
    _notes: serde::de::IgnoredAny,
    #[serde(default)]
    closed_u: bool,
    #[serde(default)]
    closed_v: bool,
    rails: Vec<Vec<[f64; 3]>>,
}

/// Reads the patches of a model file.
///
/// # Errors
/// The file cannot be read, is too large, or is not a model. The error states line and column, or the faulty patch and
/// number.
pub(crate) fn read_model(path: &Path) -> Result<Vec<Patch>, NodeError> {
    let bytes = trochoid_io::read_bytes(path, MAX_FILE_BYTES)?;
    patches(&bytes).map_err(|message| NodeError::from(std::io::Error::other(format!("{}: {message}", path.display()))))
}

fn patches(bytes: &[u8]) -> Result<Vec<Patch>, String> {
    let model: Model = serde_json::from_slice(bytes).map_err(|error| {
        if error.is_data() {
            return format!("found {error}; expected a model of patches: correct the file there");
        }
        format!(
            "found a file that is no JSON ({error}); expected a model of patches, JSON with \"trochoid_model\": 1: \
             name one, or correct it there"
        )
    })?;
    if model.trochoid_model != 1 {
        return Err(format!("found \"trochoid_model\": {}; expected 1", model.trochoid_model));
    }
    let point = |what: &dyn Fn() -> String, point: [f64; 3]| {
        if point.iter().all(|part| part.abs() <= FARTHEST) {
            Ok(DVec3::from(point))
        } else {
            Err(format!("{}: found {point:?}; expected coordinates within ±{FARTHEST:e}", what()))
        }
    };
    let points: Result<Vec<DVec3>, String> =
        model.points.iter().enumerate().map(|(index, at)| point(&|| format!("point {index}"), *at)).collect();
    let points = points?;
    let mut patches = Vec::new();
    for (index, numbers) in model.patches.iter().enumerate() {
        let corners: Result<Vec<DVec3>, String> = numbers
            .iter()
            .map(|number| {
                let found = points.get(*number as usize).copied();
                found.ok_or_else(|| format!("patch {index}: names point {number}, but there are {}", points.len()))
            })
            .collect();
        patches.push(
            patch(&corners?).map_err(|found| {
                format!("patch {index}: found {found} points; expected 4 (bilinear) or 16 (bicubic)")
            })?,
        );
    }
    for (index, sheet) in model.sheets.iter().enumerate() {
        let at = |rail: usize, place: usize| format!("sheet {index}, rail {rail}, point {place}");
        let rails: Result<Vec<Vec<DVec3>>, String> = sheet
            .rails
            .iter()
            .enumerate()
            .map(|(r, rail)| rail.iter().enumerate().map(|(p, place)| point(&|| at(r, p), *place)).collect())
            .collect();
        let rails = Rails { rails: rails?, closed_u: sheet.closed_u, closed_v: sheet.closed_v };
        patches.extend(rails.patches().map_err(|error| format!("sheet {index}: {error}"))?);
    }
    if patches.is_empty() || patches.len() > MAX_PATCHES {
        return Err(format!("found {} patches; expected 1 to {MAX_PATCHES}", patches.len()));
    }
    Ok(patches)
}

/// Returns a patch of 4 or 16 points; for any other number of points, the number as an error.
pub(crate) fn patch(points: &[DVec3]) -> Result<Patch, usize> {
    if let Ok(points) = points.try_into() {
        return Ok(Patch::new(Bilinear { points }.elevate()));
    }
    let points = points.try_into().map_err(|_| points.len())?;
    Ok(Patch::new(Bicubic { points }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_scene::bezier::{Continuity, continuity};

    #[test]
    fn what_is_no_model_is_refused_by_name_and_place() {
        let refused = |text: &str| patches(text.as_bytes()).unwrap_err();
        let points = r#""points": [[0,0,0],[1,0,0],[0,0,1],[1,0,1]]"#;
        assert_eq!(
            patches(format!(r#"{{"trochoid_model":1,{points},"patches":[[0,1,2,3]]}}"#).as_bytes()).unwrap().len(),
            1
        );
        for (text, part) in [
            ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "unknown field `pints`"),
            ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "line 3"),
            (r#"{"trochoid_model": 2}"#, "\"trochoid_model\": 2; expected 1"),
            (r#"{"trochoid_model": 1}"#, "found 0 patches"),
            (r#"{"trochoid_model": 1, "points": [[1e300,0,0]]}"#, "point 0"),
            (r#"{"trochoid_model": 1, "points": [[1e999,0,0]]}"#, "line 1"),
            (r#"{"trochoid_model": 1, "points": [[0,0]]}"#, "line 1"),
            (r#"{"trochoid_model": 1, "points": [[0,0,0]], "patches": [[0,0,0]]}"#, "found 3 points"),
            (r#"{"trochoid_model": 1, "points": [[0,0,0]], "patches": [[0,0,7,0]]}"#, "names point 7, but there are 1"),
            (r#"{"trochoid_model": 1, "sheets": [{"rails": [[[0,0,0],[1,0,0]]]}]}"#, "sheet 0: 1 rails"),
        ] {
            assert!(refused(text).contains(part), "{text}: {}", refused(text));
        }
        let nested = "[".repeat(100_000);
        assert!(refused(&nested).contains("line 1"));
    }

    #[test]
    fn files_beyond_the_limit_are_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.json");
        std::fs::File::create(&path).unwrap().set_len(MAX_FILE_BYTES + 1).unwrap();
        let message = read_model(&path).unwrap_err().to_string();
        assert!(message.contains("large.json") && message.contains("at most 8388608"), "{message}");
        assert!(read_model(&folder.path().join("missing.json")).unwrap_err().to_string().contains("missing.json"));
        assert!(read_model(folder.path()).unwrap_err().to_string().contains("found a folder"));
    }

    fn sample(name: &str) -> Continuity {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name);
        let patches = read_model(&path).unwrap();
        continuity(patches.iter().map(|patch| &patch.shape))
    }

    #[test]
    fn the_teapot_is_newells() {
        let report = sample("teapot.json");
        // Body with bottom, lid, handle and spout each join smoothly within; 8 open edges around rim and lid, 8 at the
        // ends of handle and spout; the tip of the lid and the middle of the bottom are points of 4 patches each.
        assert_eq!((report.patches, report.joints, report.exact, report.smooth), (32, 52, 52, 52), "{report}");
        assert_eq!((report.open, report.points, report.widest_gap), (16, 8, 0.0), "{report}");
    }

    #[test]
    fn the_other_models_join_without_gaps() {
        let wave = sample("great_wave.json");
        assert_eq!((wave.patches, wave.joints, wave.equal_handles), (190, 351, 351), "{wave}");
        for name in ["boat.json", "lighthouse.json", "great_wave.json"] {
            let report = sample(name);
            assert!(report.joints > 100 && report.exact == report.joints, "{name}: {report}");
        }
    }
}
