//! Sizes of a sea's waves, eight side by side, from which the distance of a sea from polynomials is bounded.

use fearless_simd::Level;
use trochoid_sea::FramedSea;
use trochoid_sea::kernel64::LANES;

/// Eight waves, or fewer and waves of height 0.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    /// k², in 1/m².
    pub(super) square: [f64; LANES],
    /// Sizes of its parts along u and v, in rad/m.
    pub(super) numbers: [[f64; LANES]; 2],
    /// Sizes of the amplitudes along u, up, and along v, and of all three together, in meters.
    pub(super) amplitudes: [[f64; LANES]; 3],
    pub(super) size: [f64; LANES],
    /// Errors of phases, in rad/m, and in rad at the origin.
    pub(super) phase_errors: [[f64; LANES]; 2],
}

/// The waves of a sea, by falling wavelength.
#[derive(Debug)]
pub(super) struct WaveSizes {
    pub(super) blocks: Vec<Sizes>,
    /// Wave numbers k, in rad/m.
    pub(super) numbers: Vec<f64>,
    /// Rounding error of sums, relative to the sizes of the waves.
    pub(super) rounding: f64,
    pub(super) level: Level,
}

impl WaveSizes {
    pub(super) fn new(sea: &FramedSea) -> Self {
        let blocks = sea.waves().chunks(LANES).map(|waves| {
            let lanes =
                |of: &dyn Fn(usize) -> f64| std::array::from_fn(|lane| if lane < waves.len() { of(lane) } else { 0.0 });
            let [along, up, across] = [0, 1, 2].map(|axis| lanes(&|lane| waves[lane].amplitudes[axis].abs()));
            let size = |lane: usize| {
                let [along, up, across] = [along[lane], up[lane], across[lane]];
                libm::sqrt(along * along + up * up + across * across)
            };
            Sizes {
                square: lanes(&|lane| waves[lane].number * waves[lane].number),
                numbers: [0, 1].map(|axis| lanes(&|lane| waves[lane].numbers[axis].abs())),
                amplitudes: [along, up, across],
                size: lanes(&size),
                phase_errors: [0, 1].map(|part| lanes(&|lane| waves[lane].phase_errors()[part])),
            }
        });
        Self {
            blocks: blocks.collect(),
            numbers: sea.waves().iter().map(|wave| wave.number).collect(),
            rounding: sea.rounding(),
            level: Level::new(),
        }
    }
}
