//! Palettes in files: JSON of the form that documents have, and the palettes of GIMP, Krita and Inkscape.

use super::{Document, FILED, MAX_FILE_BYTES, ReadFile, STRIDE, fault, json, relocate};
use crate::access::ALLOW;
use crate::spanned::{Entry, Json, Spanned, line_and_column, shorten};
use crate::{AccessViolation, Diagnostic, Means, nearest};
use std::collections::HashSet;
use std::path::Path;
use trochoid_image::WorkingSpace;

/// First line of a `.gpl` file.
const GIMP: &str = "GIMP Palette";

impl Document {
    /// Returns the path of the file that has the document's palette, relative to the document; `None` if there is none,
    /// or it is read already.
    pub fn palette_file(&self) -> Option<&str> {
        match &self.palette_value()?.json {
            Json::String(path) => Some(path),
            _ => None,
        }
    }

    /// Puts the colors of a palette file in the place of its name. `text` is JSON, either `{"NAME": COLOR, …}` or an object
    /// with these under `"palette"`, as a document has them; or a palette of GIMP. `path` is
    /// its path from the current folder, as diagnostics call it.
    ///
    /// # Errors
    /// The text is not a palette.
    pub fn read_palette(&mut self, path: &Path, text: &str) -> Result<(), Box<Diagnostic>> {
        let colors = self.colors(path, text)?;
        if let Some(palette) = self.top("palette") {
            palette.json = Json::Object(colors);
        }
        Ok(())
    }

    /// Replaces colors of the document's palette by those of the same names in a palette file, see
    /// [`read_palette`](Self::read_palette). Colors that the file lacks stay as they are.
    ///
    /// # Errors
    /// The text is not a palette, or names colors that the document does not.
    pub fn replace_palette(&mut self, path: &Path, text: &str) -> Result<(), Box<Diagnostic>> {
        let colors = self.colors(path, text)?;
        let name = &path.display().to_string();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let Some(Spanned { json: Json::Object(own), .. }) = self.top("palette") else {
            let remedy = "give its colors names: add \"palette\": { … }, and write \"palette.NAME\" for them";
            let found = format!("no palette in the document that {} could replace", shorten(name));
            return Err(fault(&self.name, (0, 0), found, "\"palette\"", remedy));
        };
        let known = |color: &Entry, own: &[Entry]| own.iter().position(|entry| entry.key == color.key);
        let strange: Vec<&Entry> = colors.iter().filter(|color| known(color, own).is_none()).collect();
        if let Some(first) = strange.first() {
            let near = nearest(&first.key, own.iter().map(|entry| entry.key.as_str()));
            let remedy = match near {
                Some(near) if strange.len() == 1 => format!("did you mean \"{near}\"?"),
                _ => "rename them as the colors that they replace, or remove them".into(),
            };
            let listed: Vec<&str> = strange.iter().map(|color| color.key.as_str()).collect();
            let found = format!("{}, which the document does not name", list(&listed));
            let own: Vec<&str> = own.iter().map(|entry| entry.key.as_str()).collect();
            let place = line_and_column(text, (first.offset - FILED) % STRIDE);
            return Err(fault(name, place, found, format!("colors of its palette: {}", list(&own)), remedy));
        }
        for color in colors {
            if let Some(index) = known(&color, own) {
                own[index] = color;
            }
        }
        Ok(())
    }

    /// Reads the colors of a file, with the offsets that the file gets.
    fn colors(&mut self, path: &Path, text: &str) -> Result<Vec<Entry>, Box<Diagnostic>> {
        let name = &path.display().to_string();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.len() > MAX_FILE_BYTES {
            let (found, expected) = (format!("{} bytes", text.len()), format!("at most {MAX_FILE_BYTES} bytes"));
            return Err(fault(name, (0, 0), found, expected, "name a file that has the colors and little else"));
        }
        let is_gimp = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gpl"));
        if is_gimp && !text.starts_with(GIMP) {
            let found = format!("the line \"{}\"", shorten(text.lines().next().unwrap_or_default()));
            return Err(fault(
                name,
                (1, 1),
                found,
                format!("\"{GIMP}\", as .gpl begins"),
                "name such a file, or .json",
            ));
        }
        let mut colors = if text.starts_with(GIMP) { gimp(name, text)? } else { named(name, text, self.space())? };
        let mut seen = HashSet::new();
        if let Some(second) = colors.iter().find(|color| !seen.insert(color.key.as_str())) {
            let found = format!("a second \"{}\"", shorten(&second.key));
            let place = line_and_column(text, second.offset);
            return Err(fault(name, place, found, "each name once", "rename or remove one of them"));
        }
        if colors.is_empty() {
            return Err(fault(name, (1, 1), "no colors".into(), "some", "write the colors, or name another file"));
        }
        let first = FILED + STRIDE * self.files.len();
        for color in &mut colors {
            color.offset += first;
            relocate(&mut color.value, &|offset| first + offset);
        }
        self.files.push(ReadFile { path: path.into(), name: name.as_str().into(), text: text.into(), folder: None });
        Ok(colors)
    }

    /// Returns the name of the document's working space, if it has one.
    fn space(&self) -> Option<&str> {
        let Json::Object(entries) = &self.root.json else { return None };
        match &entries.iter().find(|entry| entry.key == "working_space")?.value.json {
            Json::String(name) => Some(name),
            _ => None,
        }
    }

    /// Returns the fault of a palette file that the document may not read.
    pub fn refused_palette(&self, outside: AccessViolation) -> Diagnostic {
        let origin = self.origin(self.palette_value().map_or(0, |value| value.offset));
        let place = (origin.line, origin.column);
        let found = format!("the palette file {}", outside.leads_to.display());
        let mut fault = fault(&self.name, place, found, outside.expected(), ALLOW);
        (fault.port, fault.means) = (Some("palette".into()), Some(Means::Allow(vec![outside])));
        *fault
    }

    /// Returns the fault of a palette file that cannot be read, for some reason.
    pub fn unread_palette(&self, why: String) -> Diagnostic {
        let origin = self.origin(self.palette_value().map_or(0, |value| value.offset));
        let remedy = "correct the path, which is relative to the document";
        let mut fault = fault(&self.name, (origin.line, origin.column), why, "a palette file", remedy);
        fault.port = Some("palette".into());
        *fault
    }

    fn palette_value(&self) -> Option<&Spanned> {
        let Json::Object(entries) = &self.root.json else { return None };
        entries.iter().find(|entry| entry.key == "palette").map(|entry| &entry.value)
    }
}

/// Reads the colors of a JSON file, for a document with a working space. If the file states another one, it may have no
/// colors as numbers, which would mean others.
fn named(name: &str, text: &str, space: Option<&str>) -> Result<Vec<Entry>, Box<Diagnostic>> {
    let root = json(name, text, "a palette")?;
    let (offset, found) = (root.offset, root.brief());
    let other = |found: String| {
        let remedy = "write { \"deep\": \"#14262e\", … }, or name a .gpl file";
        fault(name, line_and_column(text, offset), found, "an object of colors by name", remedy)
    };
    let Json::Object(entries) = root.json else { return Err(other(found)) };
    let stated = entries.iter().find(|entry| entry.key == "working_space").map(|entry| entry.value.json.clone());
    let (inner, outer): (Vec<Entry>, Vec<Entry>) = entries.into_iter().partition(|entry| entry.key == "palette");
    let colors = match inner.into_iter().next() {
        None if outer.iter().any(|entry| entry.key == "nodes") => {
            return Err(other("a document without a palette".into()));
        }
        None => outer,
        Some(Entry { value: Spanned { json: Json::Object(colors), .. }, .. }) => colors,
        Some(Entry { value: Spanned { json: Json::String(file), .. }, .. }) => {
            return Err(other(format!("a document whose palette is another file, \"{}\"", shorten(&file))));
        }
        Some(_) => return Err(other(found)),
    };
    let space = space.unwrap_or(WorkingSpace::default().name());
    if let Some(Json::String(stated)) = stated
        && stated != space
        && let Some(color) = colors.iter().find_map(|entry| numbers_in(&entry.value))
    {
        let found = format!("a color as numbers of the working space {}", shorten(&stated));
        let expected = format!("numbers of the document's, {}", shorten(space));
        let remedy = "write the colors as \"#rrggbb\", or take a document of the same working space";
        return Err(fault(name, line_and_column(text, color), found, expected, remedy));
    }
    Ok(colors)
}

/// Lists names, the first ones of many.
fn list(names: &[&str]) -> String {
    let mut text: String = names.iter().take(12).map(|name| shorten(name)).collect::<Vec<_>>().join(", ");
    if names.len() > 12 {
        text.push_str(&format!(" and {} more", names.len() - 12));
    }
    text
}

/// Returns the place of a color that is written as numbers: a list without other lists or texts.
fn numbers_in(value: &Spanned) -> Option<usize> {
    match &value.json {
        Json::Array(items) if items.len() == 3 && items.iter().all(|item| matches!(item.json, Json::Number(_))) => {
            Some(value.offset)
        }
        Json::Array(items) => items.iter().find_map(numbers_in),
        Json::Object(entries) => entries.iter().find_map(|entry| numbers_in(&entry.value)),
        _ => None,
    }
}

/// Reads the colors of a palette of GIMP: lines of three numbers from 0 to 255 and a name.
fn gimp(name: &str, text: &str) -> Result<Vec<Entry>, Box<Diagnostic>> {
    let mut colors: Vec<Entry> = Vec::new();
    let mut taken = HashSet::new();
    let mut offset = 0;
    // Some programs add a column for opacity, and say so before the first color.
    let mut count = 3;
    for (index, line) in text.split_inclusive('\n').enumerate() {
        let (start, line) = (offset + line.len() - line.trim_start().len(), line.trim());
        offset += text[offset..].split_inclusive('\n').next().map_or(0, str::len);
        if line.strip_prefix("Channels:").is_some_and(|channels| channels.trim() == "RGBA") {
            count = 4;
        }
        if index == 0 || line.is_empty() || line.starts_with('#') || is_header(line) {
            continue;
        }
        let mut rest = line;
        let mut channels = [0; 4];
        for channel in &mut channels[..count] {
            let (number, after) = rest.split_at(rest.find(char::is_whitespace).unwrap_or(rest.len()));
            *channel = number.parse::<u8>().map_err(|_| {
                let place = line_and_column(text, start);
                let expected =
                    format!("{} numbers from 0 to 255 and a name", if count == 3 { "three" } else { "four" });
                fault(
                    name,
                    place,
                    format!("the line \"{}\"", shorten(line)),
                    expected,
                    "correct the line, or remove it",
                )
            })?;
            rest = after.trim_start();
        }
        let [r, g, b, _] = channels;
        let key = unique(rest, &mut taken);
        let value = Spanned { offset: start, json: Json::String(format!("#{r:02x}{g:02x}{b:02x}")) };
        colors.push(Entry { key, offset: start, value });
    }
    Ok(colors)
}

/// Whether a line of a palette of GIMP describes the palette.
fn is_header(line: &str) -> bool {
    let word = line.split_once(':').map(|(word, _)| word.trim_end());
    word.is_some_and(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_alphabetic()))
}

/// Makes a legal name of one in a palette of GIMP, which may have any characters and occur twice.
fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let mut legal = words.collect::<Vec<_>>().join("_");
    if legal.is_empty() || legal == "Untitled" {
        legal = "color".into();
    } else if legal.starts_with(|c: char| c.is_ascii_digit()) {
        legal = format!("color_{legal}");
    }
    let mut free = legal.clone();
    let mut count = 1;
    while !taken.insert(free.clone()) {
        count += 1;
        free = format!("{legal}_{count}");
    }
    free
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = r##"{"palette": {"deep": "#000", "glow": "#fff"}, "nodes": {}}"##;

    fn document(text: &str) -> Document {
        Document::parse("d.json", text).expect("valid")
    }

    #[test]
    fn a_file_takes_the_place_of_its_name() {
        for text in [
            r##"{"deep": "#123", "glow": {"keys": [[1, "#fff"]]}}"##,
            r##"{"palette": {"deep": "#123", "glow": {"keys": [[1, "#fff"]]}}, "nodes": {}}"##,
        ] {
            let mut document = document(r#"{"palette": "night.json", "nodes": {}}"#);
            assert_eq!(document.palette_file(), Some("night.json"));
            document.read_palette(Path::new("night.json"), text).expect("a palette");
            assert_eq!(document.palette_file(), None);
            assert_eq!(
                document.canonical(),
                r##"{"nodes":{},"palette":{"deep":"#123","glow":{"keys":[[1.0,"#fff"]]}}}"##
            );
        }
    }

    #[test]
    fn palettes_of_gimp_have_legal_names() {
        let text = "GIMP Palette\r\nName: Night sea\r\nColumns: 4\r\n# a comment\r\n 20  38  46\tdeep blue\r\n255 255 255 Untitled\n0 0 0\n1 2 3 deep-blue\n4 5 6 7th: sky\n";
        let mut document = document(r#"{"palette": "x.gpl", "nodes": {}}"#);
        document.read_palette(Path::new("x.gpl"), text).expect("a palette");
        let found = document.canonical();
        let mut clear = self::document(r#"{"palette": "y.gpl", "nodes": {}}"#);
        clear.read_palette(Path::new("y.gpl"), "GIMP Palette\nChannels: RGBA\n1 2 3 0 ink\n").expect("a palette");
        assert_eq!(clear.canonical(), r##"{"nodes":{},"palette":{"ink":"#010203"}}"##);
        for color in [
            r##""deep_blue":"#14262e""##,
            r##""color":"#ffffff""##,
            r##""color_2":"#000000""##,
            r##""deep_blue_2":"#010203""##,
            r##""color_7th_sky":"#040506""##,
        ] {
            assert!(found.contains(color), "{color} in {found}");
        }
    }

    #[test]
    fn colors_are_replaced_by_name() {
        let mut document = document(DOCUMENT);
        document.replace_palette(Path::new("n.json"), r##"{"glow": "#abc"}"##).expect("known names");
        assert!(document.canonical().contains(r##"{"deep":"#000","glow":"#abc"}"##));
        let mut fails = |text: &str| document.replace_palette(Path::new("m.json"), text).expect_err(text).to_string();
        let one = fails("{\n \"glwo\": \"#abc\"}");
        assert!(one.contains("m.json:2:2: found glwo") && one.contains("did you mean \"glow\"?"), "{one}");
        let two = fails("{ \"glwo\": \"#abc\", \"glow\": \"#111\", \"other\": 1 }");
        assert!(two.contains("found glwo, other, which the document does not name"), "{two}");
        assert!(two.contains("colors of its palette: deep, glow"), "{two}");
        assert!(document.canonical().contains("#abc"), "nothing is replaced if a name is unknown");
        let mut without = super::Document::parse("d", r#"{"nodes": {}}"#).expect("valid");
        let fault = without.replace_palette(Path::new("n.json"), r##"{"a": "#fff"}"##).expect_err("no palette");
        assert!(fault.to_string().contains("no palette in the document"));
    }

    #[test]
    fn what_is_no_palette_is_told() {
        for (text, words) in [
            ("", "p:1:1: found an empty file"),
            ("[1]", "p:1:1: found a list of 1; expected an object of colors by name"),
            (r#"{"palette": 3}"#, "expected an object of colors by name"),
            ("{", "expected JSON"),
            ("{}", "p:1:1: found no colors"),
            (r##"{"a": "#fff", "b": "#000", "a": "#111"}"##, "p:1:28: found a second \"a\""),
            (r#"{"trochoid": 1, "nodes": {}}"#, "found a document without a palette"),
            (r#"{"palette": "other.json", "nodes": {}}"#, "whose palette is another file, \"other.json\""),
            ("GIMP Palette\nName: x\n1 2 deep\n", "p:3:1: found the line \"1 2 deep\"; expected three numbers"),
            ("GIMP Palette\n1 2 256 deep\n", "p:2:1"),
            (
                r#"{"working_space": "srgb", "palette": {"deep": [0, 0.5, 1]}}"#,
                "p:1:47: found a color as numbers of the working space srgb; expected numbers of the document's, linear-srgb",
            ),
        ] {
            let said = document(DOCUMENT).read_palette(Path::new("p"), text).expect_err(text).to_string();
            assert!(said.contains(words), "{text}: {said}");
        }
        let empty = document(DOCUMENT).read_palette(Path::new("p.GPL"), "").expect_err("not of GIMP").to_string();
        assert!(empty.contains("expected \"GIMP Palette\", as .gpl begins"), "{empty}");
        let long = format!("GIMP Palette\n{}", "#\n".repeat(MAX_FILE_BYTES / 2));
        assert!(document(DOCUMENT).read_palette(Path::new("p"), &long).is_err());
    }
}
