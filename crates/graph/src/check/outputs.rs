//! Reads the `outputs` of a document: what is rendered, into which files, with which guarantees.

use super::items::Names;
use super::kinds::kind_of;
use super::{Checker, Draft, FaultLocation};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Guarantee, Kind, OutputSpec, Precision, Severity, Source};

const KEYS: [&str; 9] = ["color", "weights", "field", "recipe", "file", "layer", "precision", "require", "notes"];

impl<'a> Checker<'a> {
    pub(super) fn outputs(&mut self, value: &'a Spanned, drafts: &[Draft<'a>], names: &Names<'a>) -> Vec<OutputSpec> {
        let place = FaultLocation::top(value.offset, "outputs");
        let Some(entries) = self.object(value, place, "an object of outputs by name") else { return Vec::new() };
        if entries.is_empty() {
            let remedy = "add one, for example \"beauty\": { \"color\": \"node\" }";
            self.error(place, "a document without outputs, which has nothing to render", "at least one output", remedy);
        }
        if entries.len() > 1024 {
            self.error(place, format!("{} outputs", entries.len()), "at most 1024 outputs", "split the document");
            return Vec::new();
        }
        entries.into_iter().filter_map(|entry| self.output(entry, drafts, names)).collect()
    }

    fn output(&mut self, entry: &'a Entry, drafts: &[Draft<'a>], names: &Names<'a>) -> Option<OutputSpec> {
        let place = FaultLocation::top(entry.offset, &entry.key);
        let mut spec = OutputSpec {
            name: entry.key.clone(),
            node: crate::NodeId(0),
            output: 0,
            kind: Kind::Color,
            is_recipe: false,
            file: None,
            layer: None,
            precision: None,
            require: None,
            place: self.line_and_column(place.offset),
        };
        if self.document.is_view(entry.offset) {
            return self.view(spec, entry, drafts, names);
        }
        let legal =
            !entry.key.is_empty() && entry.key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if !legal {
            let found = format!("the output name \"{}\"", shorten(&entry.key));
            self.error(place, found, "a–z, A–Z, 0–9, _ and -", "rename the output");
        }
        let entries =
            self.object(&entry.value, place, "an object with \"color\", \"weights\", \"field\" or \"recipe\"")?;
        let (mut source, mut required_at) = (None, None);
        let (mut file_at, mut precision_at) = (place, place);
        for item in entries {
            let place = place.at(item.value.offset);
            match (item.key.as_str(), &item.value.json) {
                ("color" | "weights" | "field" | "recipe", Json::String(text)) => {
                    if source.is_some() {
                        self.error(
                            place,
                            "a second thing to render",
                            "only one of \"color\", \"weights\", \"field\" and \"recipe\"",
                            "make it a separate output",
                        );
                    }
                    source = Some((item, self.reference(text, place, names, false)));
                }
                ("color" | "weights" | "field" | "recipe", _) => {
                    self.error(
                        place,
                        item.value.brief(),
                        "a reference to a node",
                        "write the name of a node in quotes",
                    );
                    return None;
                }
                ("file", Json::String(text)) if !text.is_empty() && !text.contains('\0') => {
                    spec.file = Some(text.clone());
                    spec.place = self.line_and_column(place.offset);
                    file_at = place;
                }
                ("layer", Json::String(text)) if is_layer(text) => spec.layer = Some(text.clone()),
                ("precision", Json::String(text)) if Precision::from_name(text).is_some() => {
                    spec.precision = Precision::from_name(text);
                    precision_at = place;
                }
                ("require", _) => {
                    spec.require = self.require(&item.value, place);
                    required_at = Some(item.value.offset);
                }
                ("notes", _) => {}
                ("file", _) => {
                    self.error(place, item.value.brief(), "a path that ends in .exr or .png", "write a path");
                }
                ("layer", _) => {
                    self.error(
                        place,
                        item.value.brief(),
                        "a layer name of a–z, A–Z, 0–9, _, - and spaces, or \"\" for the main layer",
                        "write a name",
                    );
                }
                ("precision", _) => {
                    let expected = format!("one of {}", Precision::NAMES.join(", "));
                    self.error(place, item.value.brief(), expected, "choose one of them");
                }
                (key, _) => self.unknown_key(place.at(item.offset), key, &KEYS),
            }
        }
        self.file(&mut spec, place);
        let Some((item, resolved)) = source else {
            let remedy = "add one, for example \"color\": \"node\"; a mask is written under \"weights\"";
            self.error(
                place,
                "an output that renders nothing",
                "one of \"color\", \"weights\", \"field\" and \"recipe\"",
                remedy,
            );
            return None;
        };
        if let Some(offset) = required_at.filter(|_| item.key != "color") {
            let found = format!("a requirement on \"{}\"", item.key);
            self.error(place.at(offset), found, "one on \"color\": only colors have a palette", "remove it");
        }
        spec.is_recipe = item.key == "recipe";
        let resolved = resolved?;
        let Source::Output { node, output } = resolved else { return None };
        (spec.node, spec.output) = (node, output);
        let place = place.at(item.value.offset);
        if drafts[node.0].disabled {
            return self.bypassed(spec, &drafts[node.0], place, drafts);
        }
        spec.kind = kind_of(&resolved, drafts)?;
        let fits = matches!(
            (item.key.as_str(), spec.kind),
            ("color" | "recipe", Kind::Color) | ("weights", Kind::Weights(_)) | ("field", Kind::Field(_) | Kind::MASK)
        );
        if !fits {
            let remedy = match spec.kind {
                Kind::Color => "write it as \"color\"",
                Kind::Weights(_) => "write it as \"weights\"",
                Kind::Field(_) => "write it as \"field\"",
                _ => "connect a pass of it, for example Depth",
            };
            let found = format!("\"{}\", a {}", drafts[node.0].name, spec.kind);
            self.error(place, found, format!("a value for \"{}\"", item.key), remedy);
        } else {
            self.stored(&spec, file_at, precision_at);
        }
        Some(spec)
    }

    /// Resolves an output of a disabled node, which shows the first input of that node if it has the same kind.
    pub(super) fn bypassed(
        &mut self,
        mut spec: OutputSpec,
        draft: &Draft<'a>,
        place: FaultLocation<'_>,
        drafts: &[Draft<'a>],
    ) -> Option<OutputSpec> {
        // Connections already bypass disabled nodes, so the first source is enabled.
        let first = draft.record.sources().into_iter().next();
        match first {
            Some(source @ Source::Output { node, output })
                if kind_of(source, drafts) == draft.kinds.first().copied() =>
            {
                (spec.node, spec.output) = (*node, *output);
                spec.kind = kind_of(source, drafts)?;
                Some(spec)
            }
            _ => {
                let found = format!("the disabled node \"{}\", which passes nothing through", draft.name);
                self.error(place, found, "an enabled node", "enable it, or render another node");
                None
            }
        }
    }

    fn require(&mut self, value: &'a Spanned, place: FaultLocation<'_>) -> Option<Guarantee> {
        let entries = self.object(value, place, "an object with \"guarantee\"")?;
        let mut guarantee = None;
        for entry in entries {
            let place = place.at(entry.value.offset);
            match (entry.key.as_str(), &entry.value.json) {
                ("guarantee", Json::String(name)) if Guarantee::from_name(name).is_some() => {
                    guarantee = Guarantee::from_name(name);
                }
                ("guarantee", _) => self.error(place, entry.value.brief(), "hull or box", "choose one of them"),
                (key, _) => self.unknown_key(place.at(entry.offset), key, &["guarantee"]),
            }
        }
        guarantee
    }

    /// Checks that the file can store the output, and warns if it rounds coarsely.
    fn stored(&mut self, spec: &OutputSpec, file: FaultLocation<'_>, precision: FaultLocation<'_>) {
        if let Some(path) = &spec.file
            && path.to_lowercase().ends_with(".png")
            && (spec.is_recipe || !matches!(spec.kind, Kind::Color | Kind::Weights(2)))
        {
            let kind = if spec.is_recipe { "recipe".into() } else { spec.kind.to_string() };
            let found = format!("\"{}\", a PNG, for a {kind}", shorten(path));
            self.error(
                file,
                found,
                "an EXR: PNG holds one color or one mask",
                "change the extension of the path to .exr",
            );
        }
        if let (Kind::Field(_), Some(Precision::Half)) = (spec.kind, spec.precision) {
            self.report(
                Severity::Warning,
                precision,
                "precision half for a Field: half keeps 3 digits, so that 1000 m is stored in steps of half a \
                 meter"
                    .into(),
                "float, which keeps 7 digits".into(),
                "remove \"precision\": float is the default for Fields".into(),
            );
        }
    }

    fn line_and_column(&self, offset: usize) -> [usize; 2] {
        let origin = self.document.origin(offset);
        [origin.line, origin.column]
    }

    /// Checks that the extension of the file is supported, and that its format has the precision.
    fn file(&mut self, spec: &mut OutputSpec, place: FaultLocation<'_>) {
        let Some(file) = &spec.file else { return };
        let lower = file.to_lowercase();
        let (png, exr) = (lower.ends_with(".png"), lower.ends_with(".exr"));
        if !png && !exr {
            let found = format!("the file \"{}\"", shorten(file));
            self.error(place, found, "a path that ends in .exr or .png", "EXR keeps every value; PNG is for viewing");
        }
        if let Some(precision) = spec.precision
            && (png != precision.is_integer())
            && (png || exr)
        {
            let found = format!("precision {} for \"{}\"", precision.name(), shorten(file));
            self.error(place, found, "half or float for EXR, uint8 or uint16 for PNG", "change one of them");
        }
    }
}

fn is_layer(text: &str) -> bool {
    text.len() <= 64 && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | ' '))
}
