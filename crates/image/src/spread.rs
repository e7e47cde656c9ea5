//! Colors for uncovered pixels, which have none of their own: they take the nearest covered pixel's color.

use crate::Plane;

/// Marks a column without a covered pixel.
const NONE: u32 = u32::MAX;

/// Gives every pixel with alpha 0 the values of the nearest pixel with nonzero alpha; returns `false` if there is
/// none.
///
/// The nearest pixel has the least exact Euclidean distance between centers. Found in two passes (Meijster, Roerdink,
/// Hesselink, *A General Algorithm for Computing Distance Transforms in Linear Time*, 2000): first the nearest covered
/// row g of each column, then, along each row y, the lower envelope of the parabolas (x − i)² + (y − gᵢ)².
///
/// # Panics
/// If the planes have another window than the alpha.
pub fn spread(planes: &mut [Plane; 3], alpha: &Plane) -> bool {
    let width = alpha.window().width();
    let covered = |index: usize| alpha.samples()[index] != 0.0;
    if !(0..alpha.samples().len()).any(covered) {
        return false;
    }
    let rows = nearest_rows(alpha);
    let mut stack: Vec<(usize, i64)> = Vec::with_capacity(width);
    for (y, row) in rows.chunks(width.max(1)).enumerate() {
        let start = y * width;
        if (0..width).all(|x| covered(start + x)) {
            continue;
        }
        envelope(row, y, &mut stack);
        for x in (0..width).rev() {
            while stack.last().is_some_and(|(_, from)| *from > x as i64) {
                stack.pop();
            }
            let Some(&(column, _)) = stack.last() else { break };
            if !covered(start + x) {
                let source = row[column] as usize * width + column;
                for plane in planes.iter_mut() {
                    let samples = plane.samples_mut();
                    samples[start + x] = samples[source];
                }
            }
        }
    }
    true
}

/// Returns for each pixel the nearest row, the upper one on ties, that is covered in its column.
fn nearest_rows(alpha: &Plane) -> Vec<u32> {
    let width = alpha.window().width().max(1);
    let mut rows = vec![NONE; alpha.samples().len()];
    let mut last = vec![NONE; width];
    for (y, (row, alpha)) in rows.chunks_mut(width).zip(alpha.samples().chunks(width)).enumerate() {
        for ((row, alpha), last) in row.iter_mut().zip(alpha).zip(&mut last) {
            if *alpha != 0.0 {
                *last = y as u32;
            }
            *row = *last;
        }
    }
    last.fill(NONE);
    let height = rows.len() / width;
    for (y, row) in (0..height as u32).zip(0..height).rev().map(|(y, index)| (y, index * width)) {
        for (above, below) in rows[row..row + width].iter_mut().zip(&mut last) {
            if *above == y {
                *below = y;
            } else if *below != NONE && (*above == NONE || *below - y < y - *above) {
                *above = *below;
            }
        }
    }
    rows
}

/// Returns the columns whose parabola is lowest somewhere on row `y`, each with the first x where it is.
fn envelope(rows: &[u32], y: usize, stack: &mut Vec<(usize, i64)>) {
    let height = |column: usize| (y as i64 - i64::from(rows[column])).pow(2);
    let distance = |x: i64, column: usize| (x - column as i64).pow(2) + height(column);
    stack.clear();
    for column in (0..rows.len()).filter(|&column| rows[column] != NONE) {
        while stack.last().is_some_and(|&(top, from)| distance(from, top) > distance(from, column)) {
            stack.pop();
        }
        let Some(&(top, _)) = stack.last() else {
            stack.push((column, 0));
            continue;
        };
        let (i, u) = (top as i64, column as i64);
        let from = 1 + (u * u - i * i + height(column) - height(top)).div_euclid(2 * (u - i));
        if from < rows.len() as i64 {
            stack.push((column, from));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;

    #[test]
    fn the_nearest_covered_pixel_is_nearest() {
        let (width, height) = (13_usize, 9_usize);
        let window = Window::sized(width as u32, height as u32);
        let mut state = 1_u32;
        for share in [1_u32, 3, 20, 90] {
            let mut alpha = Plane::filled(window, 0.0);
            for sample in alpha.samples_mut() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *sample = if (state >> 16) % 100 < share { 0.5 } else { 0.0 };
            }
            alpha.samples_mut()[57] = 1.0;
            let marks: Vec<f32> = (0..width * height).map(|index| index as f32).collect();
            let mut planes = [0, 1, 2].map(|_| Plane::new(window, marks.clone()).unwrap());
            assert!(spread(&mut planes, &alpha));
            let squared = |a: usize, b: usize| {
                let (dx, dy) = ((a % width).abs_diff(b % width), (a / width).abs_diff(b / width));
                dx * dx + dy * dy
            };
            let covered: Vec<usize> = (0..marks.len()).filter(|&index| alpha.samples()[index] != 0.0).collect();
            for (index, taken) in planes[2].samples().iter().enumerate() {
                let best = covered.iter().map(|&other| squared(index, other)).min().unwrap();
                assert!(covered.contains(&(*taken as usize)));
                assert_eq!(squared(index, *taken as usize), best, "pixel {index} of share {share}");
            }
        }
    }

    #[test]
    fn nothing_covered_is_told() {
        let window = Window::sized(2, 1);
        let mut planes = [0, 1, 2].map(|_| Plane::filled(window, 0.25));
        assert!(!spread(&mut planes, &Plane::filled(window, 0.0)));
    }
}
