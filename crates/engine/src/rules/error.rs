//! How errors pass through every operation: bounds from non-expansion.
//!
//! Each rule bounds the effect of the operands' errors on the exact operation. The rounding error of the operation
//! itself is added, measured as the distance of its computed result from that of the exact operation on the same
//! operands.

use trochoid_graph::{Bound, LITERAL, Op, REFERENCE};
use trochoid_weights::reference as r;

/// Operands of an operation at one sample: computed values and bounds on their errors, by position and row.
pub(crate) trait Operands {
    fn value(&self, position: u32, row: usize) -> f64;
    fn bound(&self, position: u32, row: usize) -> Bound;
}

/// Bounds how far the results of an operation may lie from the reference at one sample where it computed `computed`:
/// one bound per row.
///
/// `Load`s are skipped; their bounds come from outside.
pub(crate) fn error(op: &Op, of: &impl Operands, computed: &[f64], out: &mut [Bound]) {
    let scalar = |s: trochoid_graph::Scalar| (of.value(s.0, 0), of.bound(s.0, 0));
    match op {
        Op::Load(_) | Op::LoadColor(_) => {}
        // The reference takes literals as they are written, in f64.
        Op::Constant(_) | Op::ConstantColor(_) => {
            for (out, value) in out.iter_mut().zip(computed) {
                *out = Bound::of(value.abs() * LITERAL);
            }
        }
        Op::Clamp { x, min, max } => {
            let (x, dx) = scalar(*x);
            out[0] = clamp(x, dx, f64::from(*min), f64::from(*max), computed[0]);
        }
        Op::Step { x, threshold } => {
            let at = f64::from(*threshold);
            let (x, dx) = scalar(*x);
            out[0] = clamp(x, dx, at, at, computed[0]);
        }
        Op::Smooth(t) => {
            let (t, dt) = scalar(*t);
            // The slope of t²(3 − 2t) is 6t(1 − t), which is steepest nearest to ½.
            let steepest = 0.5_f64.clamp((t - dt.size).max(0.0), (t + dt.size).min(1.0));
            let slope = 6.0 * steepest * (1.0 - steepest);
            out[0] = mask(slope * dt.size, rounded(computed[0], r::smooth(t)), dt.clear);
        }
        Op::Power { t, p } => {
            let ((t, dt), p) = (scalar(*t), f64::from(*p));
            // The slope of tᵖ on [0, t + dt] is at most p·(t + dt)^(p−1). In p it is tᵖ·ln t, at least −1/(e·p).
            let slope = if p == 1.0 { 1.0 } else { p * r::power((t + dt.size).min(1.0), p - 1.0) };
            out[0] = mask(slope * dt.size + 0.37 * LITERAL, rounded(computed[0], r::power(t, p)), dt.clear);
        }
        Op::Complement(t) => {
            let (t, dt) = scalar(*t);
            out[0] = mask(dt.size, rounded(computed[0], 1.0 - t), dt.clear);
        }
        Op::Product(t, u) => {
            let ((t, dt), (u, du)) = (scalar(*t), scalar(*u));
            let size = times(t, du.size) + times(u, dt.size) + times(dt.size, du.size);
            // A factor that is certainly 0 hides doubt about the other factor.
            let hidden = |value: f64, bound: Bound| value == 0.0 && bound.size == 0.0;
            let clear = (dt.clear || hidden(u, du)) && (du.clear || hidden(t, dt));
            out[0] = mask(size, rounded(computed[0], t * u), clear);
        }
        Op::Partition(weights) => {
            for (row, (out, weight)) in out.iter_mut().zip(weights).enumerate() {
                let (w, dw) = scalar(*weight);
                *out = mask(dw.size, rounded(computed[row], w), dw.clear);
            }
        }
        Op::Normalize { values, floor } => normalize(values, f64::from(*floor), of, computed, out),
        Op::Weight(partition, i) => out[0] = of.bound(partition.0, *i),
        Op::Mix { a, b, t } => {
            let (t, dt) = scalar(*t);
            let moved = dt.size.min(1.0);
            for (row, out) in out.iter_mut().enumerate() {
                let [(a, da), (b, db)] = [a.0, b.0].map(|color| (of.value(color, row), of.bound(color, row)));
                let apart = (b - a).abs() + da.size + db.size;
                let size = times(1.0 - t, da.size) + times(t, db.size) + times(moved, apart);
                let unused = |share: f64| share == 0.0 && moved == 0.0;
                let clear = (da.clear || unused(1.0 - t))
                    && (db.clear || unused(t))
                    && (dt.clear || moved == 0.0 || apart == 0.0);
                *out = color(size, rounded(computed[row], r::mix(a, b, t)), clear);
            }
        }
        Op::Blend { colors, weights } => {
            for (row, out) in out.iter_mut().enumerate() {
                // Σ dw = 0, so only differences of colors count: at most half the diameter times Σ|dw|.
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                let (mut size, mut sum, mut moved, mut clear) = (0.0, 0.0, 0.0, true);
                for (i, c) in colors.iter().enumerate() {
                    let (w, dw) = (of.value(weights.0, i), of.bound(weights.0, i));
                    let (c, dc) = (of.value(c.0, row), of.bound(c.0, row));
                    let most = dw.size.min(1.0);
                    sum += times(w, c);
                    if w == 0.0 && most == 0.0 {
                        continue;
                    }
                    (low, high) = (low.min(c - dc.size), high.max(c + dc.size));
                    size += times(w + most, dc.size);
                    moved += most;
                    clear &= dw.clear && dc.clear;
                }
                *out = color(size + times(0.5 * moved, high - low), rounded(computed[row], sum), clear);
            }
        }
    }
}

/// Multiplies so that 0 times anything is 0: a term without weight does not matter, however little is known about it.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// Returns how far a computed result lies from the exact result for the same operands.
fn rounded(computed: f64, exact: f64) -> f64 {
    (computed - exact).abs() + exact.abs() * REFERENCE
}

/// Returns the bound of a mask; masks differ by at most 1.
fn mask(size: f64, rounded: f64, clear: bool) -> Bound {
    Bound::of((size + rounded).min(1.0)).with(clear)
}

fn color(size: f64, rounded: f64, clear: bool) -> Bound {
    Bound::of(size + rounded).with(clear)
}

/// Bounds the error of a clamp, or of a step if `max` is `min`.
fn clamp(x: f64, dx: Bound, min: f64, max: f64, computed: f64) -> Bound {
    let [slack_min, slack_max] = [min, max].map(|bound| bound.abs() * LITERAL);
    // Saturated for every value within the error, so no error passes. (∞ ± ∞ is never certain.)
    if x - dx.size >= max + slack_max || x + dx.size < min - slack_min {
        return Bound::EXACT;
    }
    if max == min || !(max - min).is_finite() {
        // The side is not certain.
        return Bound { size: 1.0, clear: false };
    }
    let width = (max - min) - slack_min - slack_max;
    let size = if width > 0.0 { (dx.size + slack_min + slack_max) / width } else { 1.0 };
    mask(size, rounded(computed, r::clamp(x, min, max)), dx.clear)
}

fn normalize(values: &[trochoid_graph::Scalar], floor: f64, of: &impl Operands, computed: &[f64], out: &mut [Bound]) {
    // An infinite field counts as the largest finite one.
    let share = |v: &trochoid_graph::Scalar| of.value(v.0, 0).clamp(0.0, f64::from(f32::MAX));
    let (mut sum, mut total, mut clear) = (0.0, 0.0, true);
    for v in values {
        sum += share(v);
        total += of.bound(v.0, 0).size;
        clear &= of.bound(v.0, 0).clear;
    }
    // Over any S' ≥ max(S − total, τ): |d(v/S)| ≤ (dv + w·dS)/S'; a change of τ moves weights by no more than itself.
    let slack = LITERAL * floor;
    let (divisor, least) = (sum.max(floor), (sum - total).max(floor - slack));
    for (row, out) in out.iter_mut().enumerate() {
        let (exact, dv) = match values.get(row) {
            Some(v) => (share(v) / divisor, of.bound(v.0, 0).size),
            None => (1.0 - sum / divisor, 0.0),
        };
        let moved = if row < values.len() { dv + times(exact, total + slack) } else { total + slack };
        *out = mask(moved / least, rounded(computed[row], exact), clear);
    }
}
