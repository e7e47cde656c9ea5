//! Working spaces, their primaries, and conversions between them.

use std::sync::LazyLock;
use trochoid_key::content_key;

/// Color space in which a document's colors mix, and in which the guarantee holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum WorkingSpace {
    /// Rec. 709 primaries, D65, linear light.
    #[default]
    LinearSrgb,
    /// ACEScg: AP1 primaries, ACES white, linear light.
    AcesCg,
    /// sRGB as encoded for display, like sampled paint swatches.
    Srgb,
}

content_key!(
    enum WorkingSpace {
        LinearSrgb,
        AcesCg,
        Srgb,
    }
);

/// CIE xy coordinates of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Red primary.
    pub red: [f32; 2],
    /// Green primary.
    pub green: [f32; 2],
    /// Blue primary.
    pub blue: [f32; 2],
    /// White point.
    pub white: [f32; 2],
}

impl Chromaticities {
    /// Returns the matrix from linear light of these primaries to that of others, in f64; `None` if the primaries of
    /// either lie on a line, or if white does not need all three of them.
    ///
    /// White becomes white: if the white points differ, colors are adapted with Bradford's matrix, like in OpenEXR
    /// for ACES files. Primaries that are the tristimulus values XYZ themselves are not adapted: they have no white.
    ///
    /// ```
    /// use trochoid_image::{Chromaticities, WorkingSpace};
    /// let p3 = Chromaticities { red: [0.68, 0.32], green: [0.265, 0.69], blue: [0.15, 0.06], white: [0.3127, 0.329] };
    /// let m = p3.matrix_to(&WorkingSpace::LinearSrgb.chromaticities()).expect("primaries");
    /// assert!((m[0][0] - 1.224_940).abs() < 1e-5 && (m[0][1] + 0.224_940).abs() < 1e-5);
    /// ```
    pub fn matrix_to(&self, other: &Self) -> Option<[[f64; 3]; 3]> {
        let (from, to) = (self.to_xyz()?, other.to_xyz()?);
        let to = inverse(&to);
        if self.is_xyz() || other.is_xyz() {
            return Some(product(&to, &from));
        }
        let cone = |white: [f32; 2]| multiply(&BRADFORD, white_xyz(white));
        let (old, new) = (cone(self.white), cone(other.white));
        let scaled = [0, 1, 2].map(|i| BRADFORD[i].map(|v| v * new[i] / old[i]));
        let matrix = product(&to, &product(&product(&inverse(&BRADFORD), &scaled), &from));
        matrix.as_flattened().iter().all(|v| v.is_finite()).then_some(matrix)
    }

    fn is_xyz(&self) -> bool {
        [self.red, self.green, self.blue] == [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
    }

    /// Returns the matrix to XYZ, in which white has Y = 1.
    fn to_xyz(self) -> Option<[[f64; 3]; 3]> {
        // Smaller areas are rounding errors, or far from all primaries in use.
        const LEAST: f64 = 1e-4;
        let numbers = [self.red, self.green, self.blue, self.white];
        if !numbers.as_flattened().iter().all(|v| v.abs() <= 10.0) || f64::from(self.white[1]) < LEAST {
            return None;
        }
        let columns = [self.red, self.green, self.blue].map(|[x, y]| {
            let (x, y) = (f64::from(x), f64::from(y));
            [x, y, 1.0 - x - y]
        });
        let rows = [0, 1, 2].map(|i| columns.map(|column| column[i]));
        if determinant(&rows).abs() < LEAST {
            return None;
        }
        let scales = multiply(&inverse(&rows), white_xyz(self.white));
        let whole = scales.iter().all(|scale| scale.abs() > LEAST);
        whole.then(|| rows.map(|row| [0, 1, 2].map(|j| row[j] * scales[j])))
    }
}

/// Matrix from XYZ to cone responses, in which white points are adapted (Lam, *Metamerism and Colour Constancy*,
/// Bradford, 1985).
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

fn white_xyz([x, y]: [f32; 2]) -> [f64; 3] {
    let (x, y) = (f64::from(x), f64::from(y));
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// Linear sRGB → ACEScg: Rec. 709 → XYZ (D65), Bradford adaptation to the ACES white, XYZ → AP1.
const ACESCG_FROM_SRGB: [[f64; 3]; 3] = [
    [0.613_097_4, 0.339_523_15, 0.047_379_45],
    [0.070_193_72, 0.916_353_88, 0.013_452_4],
    [0.020_615_59, 0.109_569_77, 0.869_814_64],
];

static SRGB_FROM_ACESCG: LazyLock<[[f64; 3]; 3]> = LazyLock::new(|| inverse(&ACESCG_FROM_SRGB));

impl WorkingSpace {
    /// Every working space.
    pub const ALL: [Self; 3] = [Self::LinearSrgb, Self::AcesCg, Self::Srgb];

    /// Returns the name in documents and metadata.
    pub fn name(self) -> &'static str {
        match self {
            Self::LinearSrgb => "linear-srgb",
            Self::AcesCg => "acescg",
            Self::Srgb => "srgb",
        }
    }

    /// Returns the space with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.name() == name)
    }

    /// Returns the primaries and the white point.
    pub fn chromaticities(self) -> Chromaticities {
        match self {
            Self::LinearSrgb | Self::Srgb => {
                Chromaticities { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] }
            }
            Self::AcesCg => Chromaticities {
                red: [0.713, 0.293],
                green: [0.165, 0.830],
                blue: [0.128, 0.044],
                white: [0.32168, 0.33767],
            },
        }
    }

    /// Converts a linear sRGB color to this space.
    pub fn from_linear_srgb(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::LinearSrgb => color,
            Self::AcesCg => multiply(&ACESCG_FROM_SRGB, color),
            Self::Srgb => color.map(srgb_encode),
        }
    }

    /// Converts a color of this space to linear sRGB.
    pub fn to_linear_srgb(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::LinearSrgb => color,
            Self::AcesCg => multiply(&SRGB_FROM_ACESCG, color),
            Self::Srgb => color.map(srgb_decode),
        }
    }

    /// Encodes a color of this space for an sRGB display, which shows channels from 0 to 1.
    pub fn to_display(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Srgb => color,
            _ => self.to_linear_srgb(color).map(srgb_encode),
        }
    }
}

impl std::fmt::Display for WorkingSpace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Linear light above which the sRGB encoding is a power, and a limit of how far it falls there.
const BREAK: f64 = 0.003_130_8;
const FALL: f64 = 2.9e-8;

/// Returns how far [`srgb_encode`] may fall within a range of linear light: its two pieces do not meet exactly. Elsewhere
/// it increases.
pub fn srgb_fall(low: f64, high: f64) -> f64 {
    let holds = |at: f64| low <= at && at <= high;
    if holds(BREAK) || holds(-BREAK) { FALL } else { 0.0 }
}

/// Encodes linear light for display (IEC 61966-2-1). The function is odd, and not limited to 1.
pub fn srgb_encode(linear: f64) -> f64 {
    let v = linear.abs();
    let encoded = if v <= BREAK { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// Decodes a display value to linear light: the inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f64) -> f64 {
    let v = encoded.abs();
    let linear = if v <= 0.040_45 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) };
    linear.copysign(encoded)
}

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| [0, 1, 2].map(|j| (0..3).map(|i| row[i] * b[i][j]).sum()))
}

/// Returns a cofactor of a 3 × 3 matrix: cyclic indices give its sign directly.
fn minor(m: &[[f64; 3]; 3], i: usize, j: usize) -> f64 {
    let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
    m[a][c] * m[b][d] - m[a][d] * m[b][c]
}

fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    (0..3).map(|j| m[0][j] * minor(m, 0, j)).sum()
}

/// Returns the inverse of a regular 3 × 3 matrix, from its adjugate.
fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let determinant = determinant(m);
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(m, j, i) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_round_trip() {
        for space in WorkingSpace::ALL {
            for color in [[0.0, 0.0, 0.0], [0.2, 0.5, 0.9], [1.0, 1.0, 1.0], [4.0, 0.001, 12.0]] {
                let back = space.to_linear_srgb(space.from_linear_srgb(color));
                for c in 0..3 {
                    assert!((back[c] - color[c]).abs() < 1e-6 * (1.0 + color[c]), "{space}: {color:?} -> {back:?}");
                }
            }
            assert_eq!(WorkingSpace::from_name(space.name()), Some(space));
        }
    }

    #[test]
    fn the_encoding_falls_no_further_than_allowed_for() {
        let fall = srgb_encode(BREAK) - srgb_encode(BREAK.next_up());
        assert!(0.9 * FALL < fall && fall < FALL, "{fall}");
        assert_eq!((srgb_fall(0.0, 1.0), srgb_fall(-1.0, 0.0), srgb_fall(0.1, 1.0)), (FALL, FALL, 0.0));
    }

    const AP0: Chromaticities =
        Chromaticities { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.077], white: [0.32168, 0.33767] };

    #[test]
    fn matrices_are_the_published_ones() {
        let [srgb, ap1] = [WorkingSpace::LinearSrgb, WorkingSpace::AcesCg].map(WorkingSpace::chromaticities);
        let near = |from: &Chromaticities, to: &Chromaticities, expected: [[f64; 3]; 3], within: f64| {
            let found = from.matrix_to(to).expect("primaries");
            for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((found - expected).abs() < within, "{found} and {expected} of {from:?}");
            }
        };
        near(&srgb, &ap1, ACESCG_FROM_SRGB, 1e-5);
        // SMPTE ST 2065-1 to S-2014-004.
        let ap1_from_ap0 = [
            [1.451_439_316_1, -0.236_510_746_9, -0.214_928_569_3],
            [-0.076_553_773_4, 1.176_229_699_8, -0.099_675_926_4],
            [0.008_316_148_4, -0.006_032_449_8, 0.997_716_301_4],
        ];
        near(&AP0, &ap1, ap1_from_ap0, 1e-6);
        // IEC 61966-2-1, from XYZ.
        let xyz = Chromaticities { red: [1.0, 0.0], green: [0.0, 1.0], blue: [0.0; 2], white: [1.0 / 3.0; 2] };
        let srgb_from_xyz = [
            [3.240_969_9, -1.537_383_2, -0.498_610_8],
            [-0.969_243_6, 1.875_967_5, 0.041_555_1],
            [0.055_630_1, -0.203_976_9, 1.056_971_5],
        ];
        near(&xyz, &srgb, srgb_from_xyz, 1e-5);
    }

    #[test]
    fn primaries_that_span_nothing_have_no_matrix() {
        let good = WorkingSpace::LinearSrgb.chromaticities();
        for bad in [
            Chromaticities { blue: good.red, ..good },
            Chromaticities { red: [0.2, 0.2], green: [0.3, 0.3], blue: [0.4, 0.4], ..good },
            Chromaticities { white: [0.3, 0.0], ..good },
            Chromaticities { white: [f32::NAN, 0.3], ..good },
            Chromaticities { red: [f32::INFINITY, 0.3], ..good },
            // On the line between red and green: no blue in it.
            Chromaticities { white: [0.47, 0.465], ..good },
        ] {
            assert_eq!(bad.matrix_to(&good), None, "{bad:?}");
        }
    }

    #[test]
    fn white_stays_white() {
        let dci = Chromaticities { red: [0.68, 0.32], green: [0.265, 0.69], blue: [0.15, 0.06], white: [0.314, 0.351] };
        let matrix = dci.matrix_to(&WorkingSpace::LinearSrgb.chromaticities()).expect("primaries");
        assert!(multiply(&matrix, [1.0; 3]).iter().all(|v| (v - 1.0).abs() < 1e-12), "{matrix:?}");
        let white = WorkingSpace::AcesCg.from_linear_srgb([1.0; 3]);
        assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-6), "{white:?}");
    }
}
