//! Where a ray first passes through a surface, by steps along it.

/// Halvings of the stretch in which a ray passes.
const HALVINGS: usize = 60;
/// Steps toward the least gap where a ray just may touch, each of which leaves 62 % of the stretch.
const NARROWINGS: usize = 60;
/// Gaps over the bend of three of them, from which on no gap between them is 0: a parabola through them has its least
/// within an eighth of the bend of the middle one.
const BENDS: f64 = 1.0;

/// The first distance at which the gap between a ray and a surface changes its sign, between two distances: where the sign
/// has just changed.
///
/// `look` gives the gap at a distance, and how far the next step may go, which is short against the surface's bends.
/// Between steps the gap may touch 0 and turn, where a ray cuts a crest: so each least gap is looked for too.
pub(crate) fn first_crossing([start, end]: [f64; 2], mut look: impl FnMut(f64) -> (f64, f64)) -> Option<f64> {
    let mut near = start;
    let (mut at_near, mut step) = look(near);
    // A step more at each end, where the gap may be least beside it.
    let first = start - step;
    let mut before = (first >= 0.0).then(|| (first, look(first).0)).filter(|(_, gap)| (*gap > 0.0) == (at_near > 0.0));
    while near < end + if step.is_finite() { step } else { 0.0 } {
        let far = if step.is_finite() { near + step.max(1e-9 * near) } else { end };
        let (at_far, next) = look(far);
        let mut gap = |distance: f64| look(distance).0;
        if (at_near > 0.0) != (at_far > 0.0) || at_far == 0.0 {
            return Some(halve([near, far], at_near > 0.0, gap));
        }
        if let Some((from, at_from)) = before {
            let is_least = at_near.abs() < at_from.abs() && at_near.abs() <= at_far.abs();
            if is_least && at_near.abs() <= BENDS * (at_from - 2.0 * at_near + at_far).abs() {
                let passed = touch([from, far], at_near > 0.0, &mut gap);
                if let Some(passed) = passed {
                    return Some(halve([from, passed], at_near > 0.0, gap));
                }
            }
        }
        before = Some((near, at_near));
        (near, at_near, step) = (far, at_far, next);
    }
    None
}

fn halve([mut near, mut far]: [f64; 2], above: bool, mut gap: impl FnMut(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = (near + far) / 2.0;
        if (gap(middle) > 0.0) == above { near = middle } else { far = middle }
    }
    far
}

/// A distance at which the gap has changed its sign, if it does so where it is least: golden-section search.
fn touch([mut from, mut to]: [f64; 2], above: bool, gap: &mut impl FnMut(f64) -> f64) -> Option<f64> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut size = |distance: f64| {
        let gap = gap(distance);
        if (gap > 0.0) == above { gap.abs() } else { -1.0 }
    };
    let mut inner = [to - golden * (to - from), from + golden * (to - from)];
    let mut sizes = inner.map(&mut size);
    for _ in 0..NARROWINGS {
        if let Some(passed) = (0..2).find(|which| sizes[*which] < 0.0) {
            return Some(inner[passed]);
        }
        if sizes[0] < sizes[1] {
            to = inner[1];
            inner = [to - golden * (to - from), inner[0]];
            sizes = [size(inner[0]), sizes[0]];
        } else {
            from = inner[0];
            inner = [inner[1], from + golden * (to - from)];
            sizes = [sizes[1], size(inner[1])];
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touches_beside_the_ends_are_found() {
        let gap = |distance: f64| (0.5 * (distance - 5.03) * (distance - 5.03) - 1e-3, 0.4);
        for ends in [[4.9, 20.0], [0.0, 5.1]] {
            assert!(first_crossing(ends, gap).is_some_and(|found| (found - 4.985).abs() < 1e-3), "{ends:?}");
        }
    }

    #[test]
    fn touches_between_steps_are_found() {
        for depth in [1e-1, 1e-3, 1e-6, 1e-9] {
            // Two zeros beside 5.03, far less than a step apart.
            let gap = |distance: f64| (0.5 * (distance - 5.03) * (distance - 5.03) - depth, 0.4);
            let found = first_crossing([0.0, 20.0], gap).expect("it passes");
            assert!((found - (5.03 - (2.0 * depth).sqrt())).abs() < 1e-12, "{depth}: {found}");
            let beside = |distance: f64| (0.5 * (distance - 5.03) * (distance - 5.03) + depth, 0.4);
            assert_eq!(first_crossing([0.0, 20.0], beside), None);
        }
    }
}
