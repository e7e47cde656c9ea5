//! Names in shaders, which are the same in every language.

use std::collections::HashSet;
use trochoid_graph::Kind;

/// Words that no name may be: keywords of GLSL 4.60 and ES 3.20, of OSL 1.14, of WGSL, variables of every OSL shader, functions of
/// its standard library with names such as nodes have, macros of its header, and those that shaders here or programs around them call.
const RESERVED: &[&str] = &[
    "abs",
    "area",
    "aastep",
    "background",
    "blackbody",
    "bump",
    "cellnoise",
    "debug",
    "diffuse",
    "emission",
    "fresnel",
    "hash",
    "holdout",
    "linearstep",
    "luminance",
    "phong",
    "reflection",
    "refraction",
    "rotate",
    "spline",
    "trace",
    "transform",
    "translucent",
    "transparent",
    "ward",
    "active",
    "and",
    "asm",
    "attribute",
    "bool",
    "break",
    "buffer",
    "case",
    "cast",
    "catch",
    "centroid",
    "char",
    "clamp",
    "class",
    "closure",
    "coherent",
    "color",
    "common",
    "const",
    "continue",
    "default",
    "delete",
    "discard",
    "displacement",
    "do",
    "double",
    "else",
    "emit",
    "encoded",
    "enum",
    "exp",
    "extern",
    "external",
    "false",
    "filter",
    "fixed",
    "flat",
    "float",
    "floor",
    "for",
    "friend",
    "goto",
    "half",
    "highp",
    "if",
    "illuminance",
    "illuminate",
    "image",
    "in",
    "inline",
    "inout",
    "input",
    "int",
    "interface",
    "invariant",
    "layout",
    "length",
    "log",
    "long",
    "lowp",
    "main",
    "matrix",
    "max",
    "mediump",
    "min",
    "mix",
    "mod",
    "namespace",
    "new",
    "noinline",
    "noise",
    "noperspective",
    "normal",
    "normalize",
    "not",
    "operator",
    "or",
    "out",
    "output",
    "partition",
    "patch",
    "point",
    "pow",
    "precise",
    "precision",
    "private",
    "protected",
    "public",
    "readonly",
    "register",
    "resource",
    "restrict",
    "result",
    "return",
    "sample",
    "shader",
    "shared",
    "short",
    "sign",
    "signed",
    "sizeof",
    "smooth",
    "sqrt",
    "static",
    "step",
    "string",
    "struct",
    "subroutine",
    "superp",
    "surface",
    "switch",
    "template",
    "texture",
    "this",
    "throw",
    "time",
    "true",
    "try",
    "typedef",
    "uniform",
    "union",
    "unsigned",
    "using",
    "varying",
    "vector",
    "virtual",
    "void",
    "volatile",
    "volume",
    "while",
    "writeonly",
    "NULL",
    "Self",
    "abstract",
    "alias",
    "alignas",
    "alignof",
    "array",
    "as",
    "asm_fragment",
    "async",
    "auto",
    "await",
    "become",
    "bitcast",
    "co_await",
    "co_return",
    "co_yield",
    "column_major",
    "compile",
    "compile_fragment",
    "concept",
    "const_assert",
    "const_cast",
    "consteval",
    "constexpr",
    "constinit",
    "continuing",
    "crate",
    "debugger",
    "decltype",
    "demote",
    "demote_to_helper",
    "diagnostic",
    "dynamic_cast",
    "enable",
    "explicit",
    "export",
    "extends",
    "f16",
    "f32",
    "fallthrough",
    "final",
    "finally",
    "fn",
    "from",
    "fxgroup",
    "get",
    "groupshared",
    "i32",
    "impl",
    "implements",
    "import",
    "instanceof",
    "let",
    "loop",
    "macro",
    "macro_rules",
    "match",
    "meta",
    "module",
    "move",
    "mut",
    "mutable",
    "nil",
    "noexcept",
    "nointerpolation",
    "non_coherent",
    "noncoherent",
    "null",
    "nullptr",
    "of",
    "override",
    "package",
    "packoffset",
    "pass",
    "pixelfragment",
    "premerge",
    "priv",
    "ptr",
    "pub",
    "ref",
    "regardless",
    "reinterpret_cast",
    "require",
    "requires",
    "select",
    "self",
    "set",
    "snorm",
    "static_assert",
    "static_cast",
    "std",
    "super",
    "target",
    "thread_local",
    "trait",
    "type",
    "typeid",
    "typename",
    "typeof",
    "u32",
    "unless",
    "unorm",
    "unsafe",
    "unsized",
    "use",
    "var",
    "where",
    "with",
    "yield",
    "BUILTIN",
    "BUILTIN_DERIV",
    "PERCOMP1",
    "PERCOMP2",
    "PERCOMP2F",
    "STDOSL_H",
    "Ci",
    "I",
    "N",
    "Ng",
    "P",
    "Ps",
    "dPdtime",
    "dPdu",
    "dPdv",
    "dtime",
    "u",
    "v",
];

/// Beginnings of GLSL's names of types.
const TYPES: &[&str] = &[
    "sampler", "isampler", "usampler", "image", "iimage", "uimage", "texture", "itexture", "utexture", "subpass",
    "vec", "ivec", "uvec", "bvec", "dvec", "hvec", "fvec", "mat", "dmat", "uint", "atomic",
];

/// Functions of the shader's own, whose names begin with its name.
pub(crate) const FUNCTIONS: [&str; 6] = ["mask", "ramp", "smooth", "share", "mix", "decode"];

/// Returns the identifier nearest to a name: of ASCII letters, digits and single underscores.
pub(crate) fn identifier(name: &str) -> String {
    let mut made = String::new();
    for sign in name.chars() {
        // Two underscores in a row are reserved in GLSL.
        match sign {
            sign if sign.is_ascii_alphanumeric() => made.push(sign),
            _ if made.is_empty() || made.ends_with('_') => {}
            _ => made.push('_'),
        }
    }
    let made = made.trim_end_matches('_');
    if made.is_empty() {
        return "unnamed".into();
    }
    // GLSL keeps all names that begin with the first for itself; OSL has macros that begin with the second.
    if made.starts_with("gl_") || made.starts_with("M_") || made.starts_with(|first: char| first.is_ascii_digit()) {
        return format!("n_{made}");
    }
    let is_type = TYPES.iter().any(|ty| made.starts_with(ty) && !made[ty.len()..].starts_with(char::is_lowercase));
    if is_type || RESERVED.contains(&made) || is_ours(made) { format!("{made}_in") } else { made.into() }
}

/// Whether shaders call their own variables so: a letter, and a position in the program.
fn is_ours(name: &str) -> bool {
    let rest = name.strip_prefix(['t', 'c', 'w', 'q', 's', 'd', 'r', 'e']);
    rest.is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_digit()))
}

/// Returns the names of what a shader returns for an output of this name and kind.
pub(crate) fn results(name: &str, kind: Kind) -> Vec<String> {
    match kind {
        Kind::Color => vec!["result".into()],
        kind if kind.channels() == 1 => vec!["result".into()],
        kind => (0..kind.channels()).map(|channel| format!("{name}_{channel}")).collect(),
    }
}

/// Names that are taken.
pub(crate) struct Taken {
    names: HashSet<String>,
}

impl Taken {
    /// Takes the names of a function, of its own functions, and of its results.
    pub(crate) fn new(function: &str, results: &[String]) -> Self {
        let own = FUNCTIONS.iter().map(|own| format!("{function}_{own}"));
        Self { names: own.chain([function.into()]).chain(results.iter().cloned()).collect() }
    }

    /// Takes the identifier nearest to a name, with a number if it is taken.
    pub(crate) fn take(&mut self, name: &str) -> String {
        let plain = identifier(name);
        let mut made = plain.clone();
        let mut number = 2;
        while !self.names.insert(made.clone()) {
            made = format!("{plain}_{number}");
            number += 1;
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_in_every_language() {
        for (name, expected) in [
            ("light", "light"),
            ("front/hull.coverage", "front_hull_coverage"),
            ("a__b _c", "a_b_c"),
            ("Über mich", "ber_mich"),
            ("3d", "n_3d"),
            ("…", "unnamed"),
            ("noise", "noise_in"),
            ("gl_Color", "n_gl_Color"),
            ("M_PI", "n_M_PI"),
            ("e3", "e3_in"),
            ("sampler2D", "sampler2D_in"),
            ("material", "material"),
            ("vector_of", "vector_of"),
            ("t12", "t12_in"),
            ("u", "u_in"),
        ] {
            assert_eq!(identifier(name), expected, "{name}");
        }
    }

    #[test]
    fn no_two_inputs_have_one_name() {
        let mut taken = Taken::new("look", &["look_0".into()]);
        let names = ["a/b", "a.b", "a_b", "look", "look mix", "look.0"].map(|name| taken.take(name));
        assert_eq!(names, ["a_b", "a_b_2", "a_b_3", "look_2", "look_mix_2", "look_0_2"]);
    }
}
