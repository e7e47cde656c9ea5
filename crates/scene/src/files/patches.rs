//! Model files of Bézier patches.
//!
//! The JSON has `points`, `patches` that list 4 (bilinear) or 16 (bicubic) points by number, row by row, and `sheets`
//! with rails that a surface passes through.

use super::faults::MAX_PATCH_COORDINATE;
use super::{PatchesFault, PointPlace};
use crate::DVec3;
use crate::bezier::{MAX_PATCHES, Patch, Rails};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    /// Version of the format.
    trochoid_model: Option<u32>,
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

/// Reads the patches of a model file from its bytes.
///
/// # Errors
/// The bytes are not a valid model. The error names the line and column, or the patch and point.
pub fn patches(bytes: &[u8]) -> Result<Vec<Patch>, PatchesFault> {
    let model: Model = serde_json::from_slice(bytes)
        .map_err(|error| if error.is_data() { PatchesFault::NoModel(error) } else { PatchesFault::NoJson(error) })?;
    match model.trochoid_model {
        Some(1) => {}
        Some(other) => return Err(PatchesFault::Version(other)),
        None => return Err(PatchesFault::NoVersion),
    }
    let point = |at: PointPlace, found: [f64; 3]| {
        let near = found.iter().all(|part| part.abs() <= MAX_PATCH_COORDINATE);
        if near { Ok(DVec3::from(found)) } else { Err(PatchesFault::Point { at, found }) }
    };
    let points = model.points.iter().enumerate().map(|(index, found)| point(PointPlace::Points(index), *found));
    let points: Vec<DVec3> = points.collect::<Result<_, _>>()?;
    let mut patches = Vec::new();
    for (index, numbers) in model.patches.iter().enumerate() {
        let corners = numbers.iter().map(|number| {
            let found = points.get(*number as usize).copied();
            found.ok_or(PatchesFault::NoPoint { patch: index, point: *number, count: points.len() })
        });
        let corners: Vec<DVec3> = corners.collect::<Result<_, _>>()?;
        patches.push(Patch::of(&corners).map_err(|found| PatchesFault::Points { patch: index, found })?);
    }
    for (index, sheet) in model.sheets.iter().enumerate() {
        let at = |rail: usize, point: usize| PointPlace::Rail { sheet: index, rail, point };
        let rails = sheet.rails.iter().enumerate();
        let rails = rails.map(|(r, rail)| rail.iter().enumerate().map(|(p, found)| point(at(r, p), *found)).collect());
        let rails: Vec<Vec<DVec3>> = rails.collect::<Result<_, PatchesFault>>()?;
        let rails = Rails { rails, closed_u: sheet.closed_u, closed_v: sheet.closed_v };
        patches.extend(rails.patches().map_err(|fault| PatchesFault::Sheet { sheet: index, fault })?);
    }
    if patches.is_empty() || patches.len() > MAX_PATCHES {
        return Err(PatchesFault::Count(patches.len()));
    }
    Ok(patches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::{Continuity, continuity};
    use std::path::Path;

    #[test]
    fn what_is_no_model_is_refused_by_name_and_place() {
        let refused = |text: &str| patches(text.as_bytes()).unwrap_err().to_string();
        let points = r#""points": [[0,0,0],[1,0,0],[0,0,1],[1,0,1]]"#;
        assert_eq!(
            patches(format!(r#"{{"trochoid_model":1,{points},"patches":[[0,1,2,3]]}}"#).as_bytes()).unwrap().len(),
            1
        );
        for (text, part) in [
            ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "unknown field `pints`"),
            ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "line 3"),
            (r#"{"trochoid_model": 2}"#, "\"trochoid_model\": 2; expected 1"),
            (r#"{"points": []}"#, "found no \"trochoid_model\"; expected \"trochoid_model\": 1"),
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

    fn sample(name: &str) -> Continuity {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name);
        let patches = patches(&std::fs::read(path).unwrap()).unwrap();
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
