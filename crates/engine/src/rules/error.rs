//! How errors pass through every operation: bounds from non-expansion.
//!
//! Each rule bounds how far the result of one operation lies from the reference, at one sample of one row. It follows
//! from an inequality |f(x′) − y| ≤ |f(x′) − f(x)| + |y − f(x)|, where x are the computed operands,
//! x′ those of the reference, |x′ − x| ≤ dx, and y is the computed result. The first term is bounded by the slope of f
//! between x and x′, and with it everything that operands err by, whatever their size. The second is the rounding of
//! the operation itself, measured in f64 on the same operands ([`rounded`]); f64 holds every f32 exactly, subnormal
//! ones and the largest too.
//!
//! Numbers of the document are rounded to f32 and differ from those of the reference by up to [`literal_error`]. What
//! the f64 arithmetic on bounds itself rounds is covered by [`Bound::encode`], which enlarges them by 10⁻⁹: all terms
//! are ≥ 0, so nothing cancels.

use trochoid_graph::{Bound, LITERAL, REFERENCE, literal_error};
use trochoid_weights::reference as r;

/// A computed value at one sample, and the bound of its error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub(crate) value: f64,
    pub(crate) bound: Bound,
}

/// A number of the document.
#[inline(always)]
pub(crate) fn constant(value: f32) -> Bound {
    Bound::of(literal_error(value))
}

/// A clamp, or a step if `max` is `min`.
///
/// The ramp u = (x − min)/(max − min), limited to [0, 1], changes by at most
/// (|dx| + (1 − u)·|dmin| + u·|dmax|)/(max − min) where it is not constant, which is at most
/// (dx + the larger slack)/(the least width). Beyond either end, with all slack, it is constant.
#[inline(always)]
pub(crate) fn clamp(x: Known, min: f32, max: f32, computed: f64) -> Bound {
    let Known { value: x, bound: dx } = x;
    let [slack_min, slack_max] = [min, max].map(literal_error);
    let [min, max] = [min, max].map(f64::from);
    // Saturated for every value within the error, so no error passes. Sums that are nearly equal have been rounded by
    // 2⁻⁵³ of the ends, which the slack includes. (∞ ± ∞ is never certain.)
    if x - dx.size >= max + slack_max || x + dx.size < min - slack_min {
        return Bound::EXACT;
    }
    if max == min || !(max - min).is_finite() {
        // The side is not certain.
        return Bound { size: 1.0, clear: false };
    }
    let width = (max - min) - slack_min - slack_max;
    let size = if width > 0.0 { (dx.size + slack_min.max(slack_max)) / width } else { 1.0 };
    mask(size, rounded(computed, r::clamp(x, min, max)), dx.clear)
}

/// The slope of t²(3 − 2t) is 6t(1 − t), which is steepest nearest to ½.
#[inline(always)]
pub(crate) fn smooth(t: Known, computed: f64) -> Bound {
    let Known { value: t, bound: dt } = t;
    let steepest = 0.5_f64.clamp((t - dt.size).max(0.0), (t + dt.size).min(1.0));
    let slope = 6.0 * steepest * (1.0 - steepest);
    mask(times(slope, dt.size), rounded(computed, r::smooth(t)), dt.clear)
}

/// The slope of tᵖ on [0, t + dt] is at most p·(t + dt)ᵖ⁻¹, for p ≥ 1. In p it is tᵖ·ln t, at least −1/(e·p), and p is
/// off by up to p·[`LITERAL`].
#[inline(always)]
pub(crate) fn power(t: Known, p: f32, computed: f64) -> Bound {
    let (Known { value: t, bound: dt }, p) = (t, f64::from(p));
    let slope = if p == 1.0 { 1.0 } else { p * r::power((t + dt.size).min(1.0), p - 1.0) };
    mask(times(slope, dt.size) + 0.37 * LITERAL, rounded(computed, r::power(t, p)), dt.clear)
}

/// |(1 − t′) − (1 − t)| = |t′ − t|.
#[inline(always)]
pub(crate) fn complement(t: Known, computed: f64) -> Bound {
    mask(t.bound.size, rounded(computed, 1.0 - t.value), t.bound.clear)
}

/// |t′u′ − tu| ≤ t·du + u·dt + dt·du.
#[inline(always)]
pub(crate) fn product(t: Known, u: Known, computed: f64) -> Bound {
    let (Known { value: t, bound: dt }, Known { value: u, bound: du }) = (t, u);
    let size = times(t, du.size) + times(u, dt.size) + times(dt.size, du.size);
    // A factor that is certainly 0 hides doubt about the other factor.
    let hidden = |value: f64, bound: Bound| value == 0.0 && bound.size == 0.0;
    let clear = (dt.clear || hidden(u, du)) && (du.clear || hidden(t, dt));
    mask(size, rounded(computed, t * u), clear)
}

/// A weight of a partition. In the reference they sum to 1 as they are, so that it takes them unchanged; what rounding
/// and the residual do to the computed weight is measured.
#[inline(always)]
pub(crate) fn part(weight: Known, computed: f64) -> Bound {
    mask(weight.bound.size, rounded(computed, weight.value), weight.bound.clear)
}

/// The fields of a Normalize at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fields {
    sum: f64,
    /// Sum of the bounds.
    total: f64,
    clear: bool,
}

impl Default for Fields {
    fn default() -> Self {
        Self { sum: 0.0, total: 0.0, clear: true }
    }
}

/// A field as a share: an infinite one counts as the largest finite one. Limiting does not enlarge errors.
#[inline(always)]
fn share(field: Known) -> f64 {
    field.value.clamp(0.0, f64::from(f32::MAX))
}

impl Fields {
    #[inline(always)]
    pub(crate) fn add(&mut self, field: Known) {
        self.sum += share(field);
        self.total += field.bound.size;
        self.clear &= field.bound.clear;
    }

    #[inline(always)]
    pub(crate) fn shares(self, floor: f32) -> Shares {
        let (slack, floor) = (literal_error(floor), f64::from(floor));
        let least = (self.sum - self.total).max(floor - slack);
        Shares { fields: self, divisor: self.sum.max(floor), least, moved: self.total + slack }
    }
}

/// Shares of the sum of fields.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    fields: Fields,
    /// D = max(S, τ).
    divisor: f64,
    /// Least possible divisor of the reference, D′.
    least: f64,
    /// Largest possible |D′ − D|, since |S′ − S| is at most the sum of bounds and |τ′ − τ| at most τ's slack; both at
    /// most their sum.
    moved: f64,
}

impl Shares {
    /// |v′/D′ − v/D| = |(v′ − v)/D′ + (v/D)·(D − D′)/D′| ≤ (dv + (v/D)·|D′ − D|)/D′.
    ///
    /// Sums of up to 255 fields are rounded in f64 by less than 10⁻¹³ of the divisor, here and in the reference.
    #[inline(always)]
    pub(crate) fn of(&self, field: Known, computed: f64) -> Bound {
        let exact = share(field) / self.divisor;
        let size = (field.bound.size + times(exact, self.moved)) / self.least;
        mask(size + REFERENCE, rounded(computed, exact), self.fields.clear)
    }

    /// The rest is max(0, τ − S)/τ: where it is not 0, it changes by at most (|dS| + (S/τ)·|dτ|)/τ′ with S ≤ τ.
    #[inline(always)]
    pub(crate) fn rest(&self, computed: f64) -> Bound {
        let exact = 1.0 - self.fields.sum / self.divisor;
        mask(self.moved / self.least + REFERENCE, rounded(computed, exact), self.fields.clear)
    }
}

/// With t′ = t + dt: (1 − t′)·a′ + t′·b′ − (1 − t)·a − t·b = (1 − t)·da + t·db + dt·(b′ − a′), and |b′ − a′| is at most
/// |b − a| + |da| + |db|.
#[inline(always)]
pub(crate) fn mix(a: Known, b: Known, t: Known, computed: f64) -> Bound {
    let (Known { value: a, bound: da }, Known { value: b, bound: db }) = (a, b);
    let Known { value: t, bound: dt } = t;
    let moved = dt.size.min(1.0);
    let apart = (b - a).abs() + da.size + db.size;
    let size = times(1.0 - t, da.size) + times(t, db.size) + times(moved, apart);
    let unused = |share: f64| share == 0.0 && moved == 0.0;
    let clear = (da.clear || unused(1.0 - t)) && (db.clear || unused(t)) && (dt.clear || moved == 0.0 || apart == 0.0);
    Bound::of(size + rounded(computed, r::mix(a, b, t))).with(clear)
}

/// The terms of a Blend in one channel at one sample, and what is known of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum {
    /// Least and largest color.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Σ (w + dw)·dc.
    pub(crate) size: f64,
    /// Σ wc.
    pub(crate) sum: f64,
    /// Σ dw.
    pub(crate) moved: f64,
    pub(crate) clear: bool,
}

impl Default for Sum {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: 0.0, size: 0.0, sum: 0.0, moved: 0.0, clear: true }
    }
}

impl Sum {
    #[inline(always)]
    pub(crate) fn add(&mut self, weight: Known, color: Known) {
        let (Known { value: w, bound: dw }, Known { value: c, bound: dc }) = (weight, color);
        let most = dw.size.min(1.0);
        if w == 0.0 && most == 0.0 {
            return;
        }
        self.sum += times(w, c);
        (self.low, self.high) = (self.low.min(c), self.high.max(c));
        self.size += times(w + most, dc.size);
        self.moved += most;
        self.clear &= dw.clear && dc.clear;
    }

    /// Σ w′c′ − Σ wc = Σ w′·(c′ − c) + Σ (w′ − w)·c. The first sum is at most Σ (w + dw)·dc. In the second, both
    /// weights sum to 1, so c may be taken from the middle m of all colors: it is at most ½·(high − low)·Σ dw.
    ///
    /// The reference's n weights sum to 1 up to 2n roundings in f64, and both sums of colors ≥ 0 are rounded n times:
    /// together less than 4n·2⁻⁵² of the largest color.
    #[inline(always)]
    pub(crate) fn bound(&self, count: usize, computed: f64) -> Bound {
        let spread = if self.moved > 0.0 { times(0.5 * self.moved, self.high - self.low) } else { 0.0 };
        let lost = 4.0 * count as f64 * f64::EPSILON * self.high;
        Bound::of(self.size + spread + lost + rounded(computed, self.sum)).with(self.clear)
    }
}

/// Multiplies so that 0 times anything is 0: a term without weight does not matter, however little is known about it.
#[inline(always)]
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// Returns how far a computed result lies from the exact result for the same operands, and what f64 rounds of the
/// latter, here and in the reference.
#[inline(always)]
fn rounded(computed: f64, exact: f64) -> f64 {
    (computed - exact).abs() + exact.abs() * REFERENCE
}

/// Returns the bound of a mask; masks differ by at most 1.
#[inline(always)]
fn mask(size: f64, rounded: f64, clear: bool) -> Bound {
    Bound::of((size + rounded).min(1.0)).with(clear)
}
