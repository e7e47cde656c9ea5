//! Access to images of any kind: as planes to fill, and as numbers of the reference.

use std::convert::Infallible;
use trochoid_graph::{Kind, Outputs, Prepare, Reference, References, Source};
use trochoid_memory::Scratch;
use trochoid_weights::arithmetic;

/// Returns the kind of a node's only output.
pub(crate) fn kind(prepare: &Prepare<'_>) -> Kind {
    prepare.kinds.first().copied().unwrap_or(Kind::Color)
}

/// Fills the requested planes of the first output, of `area` samples each, channel by channel. Weights, which are
/// filtered one by one, are rounded so that they sum to exactly 1 again.
pub(crate) fn fill(kind: Kind, area: usize, outputs: &mut Outputs<'_>, mut channel: impl FnMut(usize, &mut [f32])) {
    let Ok(()) = fill_together(kind, area, outputs, |planes| -> Result<(), Infallible> {
        for (index, plane) in planes.iter_mut().enumerate() {
            if let Some(plane) = plane {
                channel(index, plane);
            }
        }
        Ok(())
    });
}

/// Does the same with all planes at once; those that are not needed are `None`.
///
/// # Errors
/// The error of `paint`; then the planes are of no use.
pub(crate) fn fill_together<E>(
    kind: Kind,
    area: usize,
    outputs: &mut Outputs<'_>,
    paint: impl FnOnce(&mut [Option<&mut [f32]>]) -> Result<(), E>,
) -> Result<(), E> {
    // The sum of weights needs every weight, including those that are not requested.
    let mut spare: Scratch<Scratch<f32>> = Scratch::new();
    let mut planes: Scratch<Option<&mut [f32]>> = (0..kind.channels()).map(|index| outputs.only(index)).collect();
    if !matches!(kind, Kind::Weights(n) if n > 2) {
        return paint(&mut planes);
    }
    spare.extend(planes.iter().map(|plane| Scratch::of(0.0, if plane.is_some() { 0 } else { area })));
    for (plane, spare) in planes.iter_mut().zip(&mut spare) {
        plane.get_or_insert(spare);
    }
    paint(&mut planes)?;
    arithmetic::round_partition_rows(
        &mut planes.iter_mut().flatten().map(|plane| &mut **plane).collect::<Scratch<_>>(),
    );
    Ok(())
}

/// Returns a value of the reference as one number per plane.
pub(crate) fn numbers(inputs: &References<'_>, source: &Source<Vec<f64>>) -> Vec<f64> {
    match inputs.value(source) {
        Reference::Color(color) => color.to_vec(),
        Reference::Mask(t) => vec![t],
        Reference::Weights(numbers) | Reference::Field(numbers) | Reference::View(numbers) => numbers,
        Reference::Handle(_) => Vec::new(),
    }
}

/// Returns the value of a kind with one number per plane.
pub(crate) fn value(kind: Kind, numbers: Vec<f64>) -> Reference {
    match (kind, &numbers[..]) {
        (Kind::Color, &[r, g, b]) => Reference::Color([r, g, b]),
        (Kind::MASK, &[t]) => Reference::Mask(t),
        (Kind::Weights(_), _) => Reference::Weights(numbers),
        _ => Reference::Field(numbers),
    }
}

/// Returns Σ wᵢ·vᵢ over the terms whose weight is above 0, number by number. Where the sum is NaN, as for +∞ and −∞,
/// the number of `otherwise` is taken.
pub(crate) fn mean(terms: impl Iterator<Item = (f64, Vec<f64>)>, otherwise: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
    let mut sum: Vec<f64> = Vec::new();
    for (weight, values) in terms.filter(|(weight, _)| *weight > 0.0) {
        sum.resize(values.len(), 0.0);
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    if sum.iter().any(|sum| sum.is_nan()) {
        let otherwise = otherwise();
        sum.iter_mut().zip(otherwise).filter(|(sum, _)| sum.is_nan()).for_each(|(sum, other)| *sum = other);
    }
    sum
}
