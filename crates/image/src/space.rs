/// The space in which a document's colors mix; the guarantee holds there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum WorkingSpace {
    /// Rec. 709 primaries, D65, linear light.
    #[default]
    LinearSrgb,
    /// ACEScg: AP1 primaries, ACES white, linear light.
    AcesCg,
    /// sRGB as encoded for display, the way paint swatches are sampled.
    Srgb,
}

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

/// Linear sRGB → ACEScg: Rec. 709 → XYZ (D65), Bradford adaptation to the ACES white, XYZ → AP1.
const ACESCG_FROM_SRGB: [[f64; 3]; 3] = [
    [0.613_097_4, 0.339_523_15, 0.047_379_45],
    [0.070_193_72, 0.916_353_88, 0.013_452_4],
    [0.020_615_59, 0.109_569_77, 0.869_814_64],
];

impl WorkingSpace {
    /// Every working space.
    pub const ALL: [Self; 3] = [Self::LinearSrgb, Self::AcesCg, Self::Srgb];

    /// The name used in documents and metadata.
    pub fn name(self) -> &'static str {
        match self {
            Self::LinearSrgb => "linear-srgb",
            Self::AcesCg => "acescg",
            Self::Srgb => "srgb",
        }
    }

    /// The space of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.name() == name)
    }

    /// The primaries and white point in which its values are stated.
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
            Self::AcesCg => multiply(&inverse(&ACESCG_FROM_SRGB), color),
            Self::Srgb => color.map(srgb_decode),
        }
    }

    /// Encodes a color of this space for an sRGB display; 0 to 1 is what it shows.
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

/// Encodes linear light for display (IEC 61966-2-1), odd about 0 and not limited to 1.
pub fn srgb_encode(linear: f64) -> f64 {
    let v = linear.abs();
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// Decodes a display value to linear light: the inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f64) -> f64 {
    let v = encoded.abs();
    let linear = if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

/// The inverse of a regular 3 × 3 matrix by its adjugate.
fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    // Cyclic indices give the signed minors directly.
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant = (0..3).map(|j| m[0][j] * minor(0, j)).sum::<f64>();
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(j, i) / determinant))
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
    fn white_stays_white() {
        let white = WorkingSpace::AcesCg.from_linear_srgb([1.0; 3]);
        assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-6), "{white:?}");
    }
}
