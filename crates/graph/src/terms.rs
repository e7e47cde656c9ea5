//! Names that other programs use for the jobs of nodes, so that an unknown node type can be answered with the right
//! node.

/// Names in other programs for one job.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// The names; only letters and digits count, and case does not.
    pub words: &'static [&'static str],
    /// Node that does the job; `None` if no node does it.
    pub node: Option<&'static str>,
    /// How to use the node, or how the job is done without one; empty if the node's name is enough.
    pub how: &'static str,
}

const fn node(node: &'static str, how: &'static str, words: &'static [&'static str]) -> Term {
    Term { words, node: Some(node), how }
}

/// All known names. Operations on colors that are not convex are in [`REFUSALS`](crate::REFUSALS).
pub const TERMS: &[Term] = &[
    node("Read", "", &["Image", "ImageRead", "ReadImage", "Load", "LoadImage", "Loader", "Input", "File", "Footage"]),
    node("Read", "its \"fit\"", &["Crop", "Reformat", "Resize", "Resample"]),
    node("Texture", "", &["ImageTexture", "TexImage", "STMap", "UVMap", "Tile"]),
    node("ViewFromPasses", "", &["Passes", "AOV", "AOVs", "RenderPasses", "Cryptomatte", "ReadPasses"]),
    node("Constant", "", &["Color", "Colour", "Solid", "SolidColor", "Fill", "Background", "RGB"]),
    node("Mix", "", &["Lerp", "Dissolve", "Crossfade", "CrossDissolve", "MixRGB", "MixColor", "Keymix"]),
    node("Blend", "", &["Average", "WeightedSum", "Combine"]),
    node("Stack", "", &["Layer", "Layers", "Composite", "Comp", "AlphaOver", "LayerStack"]),
    node("Ramp", "", &["ColorRamp", "Gradient", "GradientMap", "Curves", "ColorCurve", "Lookup", "LUT", "Colorize"]),
    node("Bands", "", &["Posterize", "Threshold", "Quantize", "Step", "Toon", "CelShade"]),
    node("Clamp", "", &["MapRange", "Remap", "Fit", "SmoothStep", "Levels"]),
    node("Switch", "", &["Choose", "Select", "Selector"]),
    node("Blur", "", &["GaussianBlur", "Defocus", "Soften", "BoxBlur"]),
    node(
        "Warp",
        "its \"dx\" and \"dy\"",
        &["Transform", "Move", "Translate", "Scale", "Rotate", "Displace", "IDistort", "Distort", "CornerPin"],
    ),
    node("Shape", "", &["Roto", "RotoPaint", "Ellipse", "Circle", "Rectangle", "Box", "Radial", "Polygon"]),
    node("Noise", "", &["Perlin", "Fractal", "Turbulence", "Voronoi", "Worley", "Cellular", "Fbm"]),
    node(
        "FieldMath",
        "with a formula",
        &[
            "Math",
            "Expression",
            "Formula",
            "Checkerboard",
            "Checker",
            "Stripes",
            "Grid",
            "MergeExpression",
            "VectorMath",
        ],
    ),
    node("Camera", "", &["Camera3D", "PerspectiveCamera", "Viewpoint"]),
    node("Light", "", &["DirectLight", "Sun", "PointLight", "SpotLight", "DistantLight"]),
    node("Mesh", "", &["Model", "ReadGeo", "Geometry", "OBJ", "Object", "GLTF", "FBX"]),
    node("Render", "", &["ScanlineRender", "Renderer", "Rasterize", "RenderLayers", "View"]),
    node("NonSpecular", "", &["Diffuse", "Lambert", "Shading"]),
    node("Specular", "", &["Phong", "Highlight", "Glossy", "BlinnPhong"]),
    node("GerstnerSea", "", &["Sea", "Ocean", "Water", "Waves", "Gerstner", "OceanModifier"]),
    Term {
        words: &["Write", "Output", "FileOutput", "Save", "Viewer", "Export"],
        node: None,
        how: "no node writes files: list the node under \"outputs\", with a \"file\"",
    },
];

impl Term {
    /// Finds the entry for a name.
    pub fn of(word: &str) -> Option<&'static Self> {
        let plain = |word: &str| word.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
        let wanted = plain(word);
        TERMS.iter().find(|term| term.words.iter().any(|known| plain(known) == wanted))
    }

    /// Returns the remedy as a sentence.
    pub fn remedy(&self) -> String {
        match (self.node, self.how) {
            (None, how) => how.into(),
            (Some(node), "") => format!("use the node \"{node}\""),
            (Some(node), how) => format!("use the node \"{node}\" ({how})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_word_means_one_thing_and_none_is_refused() {
        let words: Vec<&str> = TERMS.iter().flat_map(|term| term.words).copied().collect();
        for (index, word) in words.iter().enumerate() {
            assert!(crate::refusal(word).is_none(), "{word} is refused");
            assert!(!words[..index].iter().any(|other| other.eq_ignore_ascii_case(word)), "{word} stands twice");
        }
        assert_eq!(Term::of("image_read").and_then(|term| term.node), Some("Read"));
        assert!(Term::of("Read").is_none() && Term::of("").is_none());
    }
}
