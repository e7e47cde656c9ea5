//! Tests of what the derive macros refuse. In each group of programs the first one compiles; the others, which differ
//! from it in one place, do not.

/// A program with one part replaced: a node, the types of its words and outputs, and a function that uses it.
macro_rules! program {
    ($how:literal, documentation $text:literal) => {
        program!($how, $text, attribute!(), fields!(), types!(), "")
    };
    ($how:literal, attribute $text:literal) => {
        program!($how, documentation!(), $text, fields!(), types!(), "")
    };
    ($how:literal, fields $text:literal) => {
        program!($how, documentation!(), attribute!(), $text, types!(), "")
    };
    ($how:literal, types $text:literal) => {
        program!($how, documentation!(), attribute!(), fields!(), $text, "")
    };
    ($how:literal, body $text:literal) => {
        program!($how, documentation!(), attribute!(), fields!(), types!(), $text)
    };
    ($how:literal, $documentation:expr, $attribute:expr, $fields:expr, $types:expr, $body:expr) => {
        concat!(
            "```",
            $how,
            "\nuse trochoid_graph::*;\n",
            $documentation,
            "\n#[derive(Clone, Node)]\n",
            $attribute,
            "\nstruct Tint {\n",
            $fields,
            "\n}\n",
            $types,
            "\nfn with(node: &Tint, outputs: &mut trochoid_graph::Outputs<'_>) {\n",
            $body,
            "\n}\n```\n"
        )
    };
}

macro_rules! documentation {
    () => {
        "/// Tints a color.\n/// # Formula\n/// C\n/// # Edge cases\n/// None.\n/// # Source\n/// None."
    };
}

macro_rules! attribute {
    () => {
        "#[node(end = Back, revision = 1, outputs = Out)]"
    };
}

macro_rules! fields {
    () => {
        "/// The color.\ncolor: One<port::Color>,\n/// How.\nmanner: Manner,\n/// How much.\n\
         #[knob(default = 1.0, range = 0.0..=9.0)]\nstrength: f64,"
    };
}

macro_rules! types {
    () => {
        "#[derive(Clone, Copy, PartialEq, Choice)]\nenum Manner { Soft, Hard }\n#[derive(Clone, Copy, Outputs)]\n\
         enum Out {\n/// It.\n#[output(Kind::Color)]\nTinted,\n}\n#[derive(Clone, Items)]\nstruct Stop {\n/// Where.\n\
         #[knob(range = 0.0..=1.0, required)]\nat: f64,\n}"
    };
}

macro_rules! groups {
    ($($name:ident: $hole:ident $taken:literal => [$($refused:literal),* $(,)?];)*) => {$(
        #[doc = program!("", $hole $taken)]
        $(#[doc = program!("compile_fail", $hole $refused)])*
        mod $name {}
    )*};
}

// Misspelled names, and forgotten words.
groups! {
    port: body "let _ = &node.color;" => ["let _ = &node.colour;"];
    knob: body "let _ = node.strength;" => ["let _ = node.strenght;"];
    choice: body
        "let _ = node.manner == Manner::Soft;"
        => ["let _ = node.manner == Manner::Sotf;", "let _ = node.manner == \"soft\";"];
    words: body
        "match node.manner { Manner::Soft | Manner::Hard => {} }" => ["match node.manner { Manner::Soft => {} }"];
    output: body "outputs.take(Out::Tinted, 0);" => ["outputs.take(Out::Tintde, 0);"];
    item: body "let _: ItemName = Tint::STRENGTH;" => ["let _: ItemName = Tint::STRENGHT;"];
}

// Attributes and documentation of the node.
groups! {
    documentation: documentation
        "/// Tints.\n/// # Formula\n/// C\n/// # Edge cases\n/// None.\n/// # Source\n/// None."
        => [
            // No sentence, a missing heading, and headings in another order.
            "/// # Formula\n/// C\n/// # Edge cases\n/// None.\n/// # Source\n/// None.",
            "/// Tints.\n/// # Formula\n/// C\n/// # Edge cases\n/// None.",
            "/// Tints.\n/// # Edge cases\n/// None.\n/// # Formula\n/// C\n/// # Source\n/// None.",
        ];
    attribute: attribute
        "#[node(end = Back, revision = 1, outputs = Out, role = Sea)]"
        => [
            "",
            "#[node(revision = 1, outputs = Out, role = Sea)]",
            "#[node(end = Back, outputs = Out, role = Sea)]",
            "#[node(end = Back, revision = 1, role = Sea)]",
            "#[node(end = Side, revision = 1, outputs = Out, role = Sea)]",
            "#[node(end = Back, revision = 1, outputs = Out, role = See)]",
            "#[node(end = Back, revision = 1, outputs = Out, rolle = Sea)]",
        ];
}

// Attributes of the fields.
groups! {
    one: fields
        "/// The color.\ncolor: One<port::Color>,"
        => [
            "color: One<port::Color>,",
            "/// The color.\ncolor: One<port::Colour>,",
            "/// The color.\n#[port(1..=8)]\ncolor: One<port::Color>,",
        ];
    many: fields
        "/// Colors.\n#[port(1..=8)]\ncolors: Many<port::Color>,"
        => [
            "/// Colors.\ncolors: Many<port::Color>,",
            "/// Colors.\n#[port(1..)]\ncolors: Many<port::Color>,",
        ];
    wants: fields
        "/// A view.\n#[port(wants(Folds))]\nview: One<port::View>,"
        => ["/// A view.\n#[port(wants(Fold))]\nview: One<port::View>,"];
    number: fields
        "/// How much.\n#[knob(default = 1.0, range = 0.0..=9.0, hold_keys)]\nstrength: f64,"
        => [
            "/// How much.\n#[knob(default = 1.0, hold_keys)]\nstrength: f64,",
            "/// How much.\n#[knob(default = 1.0, range = 0.0.., hold_keys)]\nstrength: f64,",
            "/// How much.\n#[knob(default = 1.0, range = 0.0..=9.0, hold)]\nstrength: f64,",
        ];
    integer: fields
        "/// How many.\n#[knob(default = 1, range = 0..=9)]\ncount: i64,"
        => [
            "/// How many.\n#[knob(default = 1)]\ncount: i64,",
            "/// How many.\n#[knob(default = 1.5, range = 0..=9)]\ncount: i64,",
        ];
    vector: fields
        "/// Where.\n#[knob(default = [0.0; 2])]\nplace: [f64; 2],"
        => ["/// Where.\n#[knob(default = [0.0; 3])]\nplace: [f64; 2],"];
    numbers: fields "/// Places.\n#[knob(len = 0..=4)]\nat: Vec<f64>," => ["/// Places.\nat: Vec<f64>,"];
    texts: fields "/// Names.\n#[knob(len = 0..=4)]\nnames: Vec<String>," => ["/// Names.\nnames: Vec<String>,"];
    list: fields "/// Stops.\n#[list(1..=8)]\nstops: Vec<Stop>," => ["/// Stops.\nstops: Vec<Stop>,"];
    word: fields "/// How.\nmanner: Manner," => ["/// How.\nmanner: Out,"];
}

// Types of words and outputs.
groups! {
    types: types
        "#[derive(Clone, Choice)]\nenum Manner { Soft }\n#[derive(Clone, Copy, Outputs)]\n\
         enum Out {\n/// It.\n#[output(Kind::Color)]\nTinted }"
        => [
            // A word with data, an output without help, and one without a kind.
            "#[derive(Clone, Choice)]\nenum Manner { Soft(f64) }\n#[derive(Clone, Copy, Outputs)]\n\
             enum Out {\n/// It.\n#[output(Kind::Color)]\nTinted }",
            "#[derive(Clone, Choice)]\nenum Manner { Soft }\n#[derive(Clone, Copy, Outputs)]\n\
             enum Out {\n#[output(Kind::Color)]\nTinted }",
            "#[derive(Clone, Choice)]\nenum Manner { Soft }\n#[derive(Clone, Copy, Outputs)]\n\
             enum Out {\n/// It.\nTinted }",
        ];
}
