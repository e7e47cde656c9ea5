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
