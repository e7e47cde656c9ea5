use crate::fields::{FieldSet, Fields, Points};
use crate::frame::Sea;
use crate::wave::Wave;

/// How folds are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldOptions {
    /// Time in seconds at which the surface is sampled.
    pub time: f64,
    /// Number of rest points to sample.
    pub samples: usize,
    /// Largest folded share at which a sea counts as not folding.
    pub tolerated_share: f64,
}

impl Default for FoldOptions {
    fn default() -> Self {
        Self { time: 0.0, samples: 4096, tolerated_share: 1e-3 }
    }
}

/// How far the crests of a sea are from folding over, without any footprint.
///
/// With q = h·k of each wave and Qm = Σ q d dᵀ: a largest eigenvalue λ₁ < 1 proves that the map from rest to
/// displaced points is one-to-one, and inf det J = (1−λ₁)(1−λ₂) over independent phases. λ₁ ≥ 1 does not prove a
/// fold, and is pessimistic for many waves; the folded share tells what to expect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Folding {
    /// Eigenvalues λ₁ ≥ λ₂ of Qm.
    pub lambda: [f64; 2],
    /// Σ|q|: a value of at most 1 is sufficient, and for waves of a single direction also necessary.
    pub q_sum: f64,
    /// Share of the sampled rest points whose neighborhood is turned over: the largest compression exceeds 1.
    pub folded_share: f64,
    /// Least det J over the sampled rest points.
    pub jacobian_min: f64,
    /// Factor on all sharpnesses at which the folded share is just tolerated; infinite if nothing ever folds.
    pub unfolded_scale: f64,
}

impl Folding {
    /// Returns the infimum of det J over all positions and phases, (1−λ₁)(1−λ₂), valid if λ₁ < 1 and no wave has the
    /// sign printed in the thesis.
    pub fn jacobian_infimum(&self) -> f64 {
        (1.0 - self.lambda[0]) * (1.0 - self.lambda[1])
    }

    /// Returns whether λ₁ proves that nothing folds anywhere at any time.
    pub fn proved(&self) -> bool {
        self.lambda[0] < 1.0
    }
}

/// Returns the eigenvalues, larger first, of [[xx, xz], [xz, zz]].
fn eigenvalues(xx: f64, xz: f64, zz: f64) -> [f64; 2] {
    let (mean, half) = ((xx + zz) / 2.0, (xx - zz) / 2.0);
    let radius = libm::sqrt(half * half + xz * xz);
    [mean + radius, mean - radius]
}

impl Sea {
    /// Returns how far this sea is from folding.
    pub fn folding(&self, options: FoldOptions) -> Folding {
        let q = |wave: &Wave| wave.compression().abs();
        let sum = |term: &dyn Fn(&Wave) -> f64| self.waves().iter().map(term).sum::<f64>();
        let lambda = eigenvalues(
            sum(&|wave| q(wave) * wave.direction[0] * wave.direction[0]),
            sum(&|wave| q(wave) * wave.direction[0] * wave.direction[1]),
            sum(&|wave| q(wave) * wave.direction[1] * wave.direction[1]),
        );
        let mut compressions = Vec::new();
        let mut jacobian_min = 1.0;
        // J = I + E with E the strain. Scaling all sharpnesses by s scales E by s, and the first fold occurs where
        // s·μ reaches 1, μ the largest eigenvalue of −E: the share at any s follows from the μ's.
        let strain = self.sampled_strain(options);
        for ((&xx, &xz), &zz) in strain[0].iter().zip(&strain[1]).zip(&strain[2]) {
            let (xx, xz, zz) = (f64::from(xx), f64::from(xz), f64::from(zz));
            compressions.push(eigenvalues(-xx, -xz, -zz)[0]);
            jacobian_min = f64::min(jacobian_min, (1.0 + xx) * (1.0 + zz) - xz * xz);
        }
        compressions.sort_by(|a, b| b.total_cmp(a));
        let folded = compressions.partition_point(|&compression| compression >= 1.0);
        let tolerated = (options.tolerated_share * compressions.len() as f64) as usize;
        let decisive = compressions.get(tolerated).copied().unwrap_or(0.0);
        Folding {
            lambda,
            q_sum: sum(&q),
            folded_share: folded as f64 / compressions.len().max(1) as f64,
            jacobian_min,
            unfolded_scale: if decisive > 0.0 { 1.0 / decisive } else { f64::INFINITY },
        }
    }

    fn sampled_strain(&self, options: FoldOptions) -> [Vec<f32>; 3] {
        let longest = self.waves().iter().map(|wave| wave.wavelength).fold(0.0, f64::max);
        // The R₂ sequence (Roberts 2018) spreads points evenly; an area hundreds of wavelengths wide makes phases
        // independent.
        let side = 512.0 * longest;
        let at = |index: usize, ratio: f64| {
            let turns = ratio * (index + 1) as f64;
            side * (turns - turns.floor() - 0.5)
        };
        let x: Vec<f64> = (0..options.samples).map(|index| at(index, 0.754_877_666_246_692_7)).collect();
        let z: Vec<f64> = (0..options.samples).map(|index| at(index, 0.569_840_290_998_053_3)).collect();
        let points = Points { x: &x, z: &z, footprint: &vec![0.0; options.samples] };
        let mut fields = Fields::default();
        self.at(options.time).direct(points, FieldSet { derivatives: true, ..FieldSet::default() }, &mut fields);
        fields.strain
    }
}
