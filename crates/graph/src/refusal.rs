//! Operations of other compositors that leave the convex hull, each with the reason, an example that proves it
//! and the nearest convex rewrite.

/// Why an operation is refused.
#[derive(Clone, Copy, Debug)]
pub struct Refusal {
    /// Names of the operation in other compositors.
    pub names: &'static [&'static str],
    /// Why the operation is not convex.
    pub reason: &'static str,
    /// Example: control colors and weights whose result leaves the hull.
    pub witness: &'static str,
    /// Convex replacement, as an instruction.
    pub rewrite: &'static str,
}

/// All refused operations.
pub const REFUSALS: &[Refusal] = &[
    Refusal {
        names: &["Plus", "Add", "Sum", "Linear Dodge"],
        reason: "weights 1 and 1 sum to 2",
        witness: "0.6 + 0.6 = 1.2 leaves the segment from 0.6 to 0.6",
        rewrite: "Mix the two (weight 0.5 for equal parts), or Blend with weights that sum to 1",
    },
    Refusal {
        names: &["Minus", "Subtract", "Difference", "From", "AbsMinus"],
        reason: "the weight of the second color is −1",
        witness: "0.2 − 0.6 = −0.4 is not a color",
        rewrite: "Mix toward a darker control color, with the second picture's pass as the weight",
    },
    Refusal {
        names: &["Gain", "Exposure", "Brightness", "MultiplyColor"],
        reason: "the weight is the gain, but a single weight must be 1",
        witness: "2 × 0.6 = 1.2 leaves the palette {0.6}",
        rewrite: "Mix toward a brighter control color (gain above 1) or a darker one (below 1)",
    },
    Refusal {
        names: &["Grade", "ColorCorrect", "Contrast", "Saturation", "HueCorrect", "Gamma", "Lift", "Offset"],
        reason: "a grade scales and shifts each channel by its own amount, without limits",
        witness: "gain 1.5 and lift −0.1 turn (0.8, 0.1, 0.1) into (1.1, 0.05, 0.05)",
        rewrite: "choose other control colors (the picture is linear in them), or use a Ramp over a mask",
    },
    Refusal {
        names: &["Over", "Under", "Atop", "In", "Out", "Mask", "Matte", "Premult", "Unpremult", "Merge", "Copy"],
        reason: "on premultiplied colors A + (1 − α)·B has the weights 1 and 1 − α, which sum to 2 − α",
        witness: "A = 0.9, α = 0.5, B = 0.9 give 1.35",
        rewrite: "Mix with the background as `a`, the foreground color (not premultiplied) as `b` and its coverage as \
                  `weight`; or Stack for several layers",
    },
    Refusal {
        names: &["Sharpen", "Laplacian", "Emboss", "EdgeDetect", "Median", "Lanczos", "Unsharp"],
        reason: "the kernel has negative weights",
        witness: "kernel (−1, 3, −1) turns (1, 0.5, 1) into −0.5",
        rewrite: "use a kernel of non-negative weights that sum to 1; find edges in a front-end pass",
    },
    Refusal {
        names: &[
            "Divide",
            "ColorDodge",
            "ColorBurn",
            "Overlay",
            "SoftLight",
            "HardLight",
            "Max",
            "Min",
            "Lighten",
            "Darken",
            "Hypot",
            "Exclusion",
        ],
        reason: "the result is not a weighted average of its colors, channel by channel",
        witness: "the per-channel maximum of (1, 0, 0) and (0, 1, 0) is (1, 1, 0), off the segment between them",
        rewrite: "Mix with a mask that selects the color at each place",
    },
    Refusal {
        names: &["Multiply", "Screen"],
        reason: "each channel of one color is the weight of that channel of the other, and such weights do not sum \
                 to 1",
        witness: "red (1, 0, 0) times green (0, 1, 0) is black, off the segment between them",
        rewrite: "Mix toward a darker color (for Multiply) or a brighter one (for Screen), with the pass as the \
                  weight; Multiply and Screen here combine the masks in their \"weights\"",
    },
    Refusal {
        names: &["LumaKey", "ChromaKey", "Keyer", "Primatte", "IBKColour", "Luminance"],
        reason: "with weights made from colors, the picture would no longer be linear in its palette",
        witness: "doubling a control color would change every other color's weight",
        rewrite: "Read the picture as a field (\"as\": \"field\") and Clamp it to a mask",
    },
];

/// Returns the refusal of the operation with a name, ignoring case.
pub fn refusal(name: &str) -> Option<&'static Refusal> {
    REFUSALS.iter().find(|refusal| refusal.names.iter().any(|known| known.eq_ignore_ascii_case(name)))
}
