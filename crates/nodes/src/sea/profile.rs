//! Profiles of seas: their surface above a line, for plots.

use super::toon::GridLayout;
use trochoid_graph::{Harmonic, Profile, ProfileLine, ProfilePoint};
use trochoid_sea::{FieldSet, Fields, Points, Sea, Wave};

/// Length of a profile without one, in wavelengths that count as much as their waves carry energy.
const WAVES: f64 = 3.0;

/// Returns the waves as plots show them.
pub(super) fn harmonics(waves: &[Wave]) -> Vec<Harmonic> {
    let harmonic = |wave: &Wave| Harmonic {
        wavelength: wave.wavelength,
        amplitude: wave.amplitude,
        direction: libm::atan2(wave.direction[1], wave.direction[0]).to_degrees(),
        sharpness: wave.compression(),
    };
    waves.iter().map(harmonic).collect()
}

/// Returns the places of a line's points at rest, as distances from its middle, and its direction.
fn along(line: &ProfileLine, length: f64) -> (Vec<f64>, [f64; 2]) {
    let last = line.points.max(2) - 1;
    let distances = (0..=last).map(|index| length * (index as f64 / last as f64 - 0.5)).collect();
    let (sin, cos) = libm::sincos(line.direction.to_radians());
    (distances, [cos, sin])
}

/// Returns the profile of a sum of waves.
pub(super) fn of_waves(waves: Vec<Wave>, line: &ProfileLine, time: f64) -> Profile {
    let energy = |wave: &Wave| wave.amplitude * wave.amplitude;
    let (carried, total) = waves
        .iter()
        .fold((0.0, 0.0), |(carried, total), wave| (carried + energy(wave) * wave.wavelength, total + energy(wave)));
    let length = line.length.unwrap_or(if total > 0.0 { WAVES * carried / total } else { 10.0 });
    let through = line.through.unwrap_or_default();
    let (distances, [dx, dz]) = along(line, length);
    let x: Vec<f64> = distances.iter().map(|distance| through[0] + dx * distance).collect();
    let z: Vec<f64> = distances.iter().map(|distance| through[1] + dz * distance).collect();
    let (mut fields, wanted) =
        (Fields::default(), FieldSet { displacement: true, derivatives: true, ..FieldSet::default() });
    let footprint = vec![0.0; x.len()];
    Sea::new(waves).at(time).direct(Points { x: &x, z: &z, footprint: &footprint }, wanted, &mut fields);
    let point = |(index, distance): (usize, &f64)| {
        let [moved_x, height, moved_z] = [0, 1, 2].map(|axis| f64::from(fields.displacement[axis][index]));
        let [xx, xz, zz] = [0, 1, 2].map(|part| f64::from(fields.strain[part][index]));
        ProfilePoint {
            along: distance + dx * moved_x + dz * moved_z,
            height,
            // The area ratio of the map from rest is negative where the surface is turned over.
            folded: (1.0 + xx) * (1.0 + zz) - xz * xz < 0.0,
        }
    };
    Profile { through, length, points: distances.iter().enumerate().map(point).collect() }
}

/// Returns the profile of heights on a grid; points beyond the grid are left out.
pub(super) fn of_grid(heights: &[f32], layout: &GridLayout, extent: [[f64; 2]; 2], line: &ProfileLine) -> Profile {
    let [least, most] = extent;
    let through = line.through.unwrap_or([0, 1].map(|axis| least[axis].midpoint(most[axis])));
    let (_, [dx, dz]) = along(line, 0.0);
    // The longer side, seen along the line.
    let length = line.length.unwrap_or((dx * (most[0] - least[0])).abs() + (dz * (most[1] - least[1])).abs());
    let (distances, _) = along(line, length);
    let rows = heights.len() / layout.columns.max(1);
    let point = |distance: f64| {
        let at = [through[0] + dx * distance, through[1] + dz * distance];
        let cell = [0, 1].map(|axis| (at[axis] - layout.origin[axis]) / layout.spacing);
        let [columns, rows] = [layout.columns, rows].map(|cells| cells as f64 - 1.0);
        if !((0.0..=columns).contains(&cell[0]) && (0.0..=rows).contains(&cell[1])) {
            return None;
        }
        let [(column, right), (row, down)] = [(cell[0], columns), (cell[1], rows)].map(|(cell, last)| {
            let first = cell.floor().min(last - 1.0).max(0.0);
            (first as usize, cell - first)
        });
        let at = |column: usize, row: usize| heights.get(row * layout.columns + column).copied().map_or(0.0, f64::from);
        let across = |row: usize| at(column, row) * (1.0 - right) + at(column + 1, row) * right;
        let height = across(row) * (1.0 - down) + across(row + 1) * down;
        Some(ProfilePoint { along: distance, height, folded: false })
    };
    Profile { through, length, points: distances.into_iter().filter_map(point).collect() }
}
