//! What other programs call the job of a node, for who writes their word.

/// Words of other programs for one job.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// The words; case, spaces and underscores do not count.
    pub words: &'static [&'static str],
    /// The node that does the job; `None` where it is no node's.
    pub node: Option<&'static str>,
    /// What to do with it, or where else the job is done; empty where the node's name says it.
    pub how: &'static str,
}

const fn node(node: &'static str, how: &'static str, words: &'static [&'static str]) -> Term {
    Term { words, node: Some(node), how }
}

/// Every word that is known. What other compositors do to colors and a convex one cannot is in
/// [`REFUSALS`](crate::REFUSALS).
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
    /// What is known of a word.
    pub fn of(word: &str) -> Option<&'static Self> {
        let plain = |word: &str| word.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
        let wanted = plain(word);
        TERMS.iter().find(|term| term.words.iter().any(|known| plain(known) == wanted))
    }

    /// What to do, as a sentence.
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
