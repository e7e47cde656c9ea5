//! Reads the palette, and colors that are named by it.

use super::keyed::COLOR;
use super::{Checker, FaultLocation};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Animated, DocumentPlace, NodeId, PaletteColor, PaletteUse, Severity, nearest};

/// What stands before the name of a color.
const PREFIX: &str = "palette.";

/// Colors of a document by name, in its order, with the places that use them.
#[derive(Default)]
pub(super) struct Palette<'a> {
    colors: Vec<Named<'a>>,
    /// Names with a fault, which is reported once.
    faulty: Vec<&'a str>,
    /// Whether the palette as a whole has a fault, so that nothing is known of its names.
    is_unread: bool,
    uses: Vec<Use>,
}

struct Named<'a> {
    name: &'a str,
    offset: usize,
    color: Animated,
}

/// Place that uses a color.
struct Use {
    color: usize,
    node: String,
    item: String,
    is_whole: bool,
}

/// Whether a text is the name of a color, right or wrong.
pub(super) fn is_name(text: &str) -> bool {
    text.starts_with(PREFIX) || text == "palette"
}

impl<'a> Checker<'a> {
    /// Reads the palette of a document, after its working space.
    pub(super) fn palette(&mut self, root: &[&'a Entry]) {
        let Some(entry) = root.iter().find(|entry| entry.key == "palette") else {
            // A misspelt key is told by itself.
            let is_slip = |entry: &&&Entry| nearest(&entry.key, super::top::KEYS) == Some("palette");
            self.palette.is_unread = root.iter().any(|entry| is_slip(&entry));
            return;
        };
        let place = FaultLocation::top(entry.value.offset, "palette");
        self.palette.is_unread = true;
        if let Json::String(path) = &entry.value.json {
            let found = format!("the palette file \"{}\", which was not read", shorten(path));
            self.error(place, found, "the colors of the palette", "load the document from its file");
            return;
        }
        let expected = "an object of colors by name, or a file's name";
        let Some(entries) = self.object(&entry.value, place, expected) else { return };
        self.palette.is_unread = false;
        for entry in entries {
            let name = entry.key.as_str();
            let place = FaultLocation::top(entry.value.offset, "palette");
            if !super::is_legal_name(name) {
                let found = format!("the name \"{}\"", shorten(name));
                let expected = "a–z, A–Z, 0–9 and _, not starting with a digit";
                self.error(place.at(entry.offset), found, expected, "rename the color");
            }
            if let Json::String(text) = &entry.value.json
                && is_name(text)
            {
                let remedy = "write its color; two names for one color are no help when one of them changes";
                self.error(place, entry.value.brief(), "a color", remedy);
                self.palette.faulty.push(name);
                continue;
            }
            let named = format!("{PREFIX}{}", shorten(name));
            let place = FaultLocation { port: Some(&named), ..place };
            match self.animated(&entry.value, COLOR, place, Self::color) {
                Some(color) => self.palette.colors.push(Named { name, offset: entry.offset, color }),
                None => self.palette.faulty.push(name),
            }
        }
    }

    /// Returns the name in the palette that a text was probably meant to be.
    pub(super) fn meant(&self, text: &str) -> Option<String> {
        let name = text.rsplit('.').next().unwrap_or_default();
        let known = self.palette.colors.iter().find(|known| known.name.eq_ignore_ascii_case(name));
        known.map(|known| format!("{PREFIX}{}", known.name))
    }

    /// Reads a color, a keyed color, or the name of one in the palette.
    pub(super) fn color_or_name(&mut self, value: &'a Spanned, place: FaultLocation<'_>) -> Option<Animated> {
        match &value.json {
            Json::String(text) if is_name(text) => self.named(text, place, true),
            _ => self.animated(value, COLOR, place, Self::color),
        }
    }

    /// Returns the color of a name, and records where it is used: by itself, or in a key.
    pub(super) fn named(&mut self, text: &str, place: FaultLocation<'_>, is_whole: bool) -> Option<Animated> {
        let name = text.strip_prefix(PREFIX).unwrap_or_default();
        let Some(color) = self.palette.colors.iter().position(|known| known.name == name) else {
            if self.palette.is_unread || self.palette.faulty.contains(&name) {
                return None;
            }
            let near = nearest(name, self.palette.colors.iter().map(|known| known.name));
            let remedy = match near {
                Some(near) => format!("did you mean \"{PREFIX}{near}\"?"),
                None if self.palette.colors.is_empty() => {
                    "add the color: \"palette\": { \"NAME\": \"#rrggbb\" } beside \"nodes\"".into()
                }
                None => "add the color to \"palette\", or correct the name".into(),
            };
            let found = format!("\"{}\", which is not a color of the palette", shorten(text));
            self.error(place, found, "the name of a color of the palette", remedy);
            return None;
        };
        if let Some((node, item)) = self.item_at(place) {
            self.palette.uses.push(Use { color, node, item, is_whole });
        }
        Some(self.palette.colors[color].color.clone())
    }

    /// Warns of colors that nothing uses, and of colors that are nearly the same; returns all colors with their uses.
    pub(super) fn palette_colors(&mut self, find: &dyn Fn(&str) -> Option<NodeId>) -> Vec<PaletteColor> {
        let palette = std::mem::take(&mut self.palette);
        // What seems to be unused may be used where there is an error.
        let is_valid = self.diagnostics.iter().all(|diagnostic| diagnostic.severity == Severity::Warning);
        for (index, named) in palette.colors.iter().enumerate().filter(|_| is_valid) {
            let place = FaultLocation::top(named.offset, "palette");
            // A file may have colors for several documents, and is often made by a program.
            let is_own = *self.document.origin(named.offset).file == *self.document.name();
            if is_own && !palette.uses.iter().any(|used| used.color == index) {
                let found = format!("the color \"{}\", which nothing uses", named.name);
                let remedy = format!("write \"{PREFIX}{}\" where it belongs, or remove it", named.name);
                self.report(Severity::Warning, place, found, "colors that are used".into(), remedy);
            }
            let twin = palette.colors[..index].iter().find(|other| self.is_near(&other.color, &named.color));
            if let Some(twin) = twin.filter(|_| is_own) {
                let found = format!("the colors \"{}\" and \"{}\", which look the same", twin.name, named.name);
                let remedy = "use one of them for both, or keep them if they will differ in another palette";
                self.report(Severity::Warning, place, found, "colors that one can tell apart".into(), remedy.into());
            }
        }
        let color = |Named { name, offset, color }: Named<'_>| {
            let origin = self.document.origin(offset);
            let place = DocumentPlace { document: origin.file, line: origin.line, column: origin.column };
            PaletteColor { name: name.into(), color, place, uses: Vec::new() }
        };
        let mut colors: Vec<PaletteColor> = palette.colors.into_iter().map(color).collect();
        for used in palette.uses {
            if let Some(node) = find(&used.node) {
                colors[used.color].uses.push(PaletteUse { node, item: used.item, is_whole: used.is_whole });
            }
        }
        colors
    }

    /// Whether two constant colors differ by less than 4 of 255 steps in each displayed channel. Weights of a picture that
    /// is taken apart into such colors get as steep as one over their distance.
    fn is_near(&self, a: &Animated, b: &Animated) -> bool {
        let shown = |color: &Animated| -> Option<[f64; 3]> {
            let [color] = color.values().collect::<Vec<_>>()[..] else { return None };
            Some(self.space.to_display([color[0], color[1], color[2]]).map(|channel| 255.0 * channel))
        };
        match (shown(a), shown(b)) {
            (Some(a), Some(b)) => a.iter().zip(b).all(|(a, b)| (a - b).abs() < 4.0 - 1e-6),
            _ => false,
        }
    }
}
