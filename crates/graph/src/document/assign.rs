//! Assignments from outside of a document.

use super::{ASSIGNED, Document, relocate};
use crate::spanned::{Entry, Json, Spanned, parse, shorten};
use crate::{Diagnostic, Means, Severity, nearest};

/// One step of a path into a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step<'t> {
    /// An entry of an object.
    Key(&'t str),
    /// An item of a list, from 0.
    Index(usize),
}

/// Splits `storm.groups[1].height` into its steps; `None` if it has another form.
fn steps(path: &str) -> Option<Vec<Step<'_>>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (key, indices) = part.split_at(part.find('[').unwrap_or(part.len()));
        steps.push(Step::Key(Some(key).filter(|key| !key.is_empty())?));
        let mut rest = indices;
        while let Some((index, after)) = rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        }
        if !rest.is_empty() {
            return None;
        }
    }
    Some(steps)
}

/// What a path leads to instead of a place for a value.
struct Astray {
    found: String,
    expected: String,
    remedy: String,
}

/// Puts a value where a path leads. All but the last step must exist.
fn put(target: &mut Spanned, steps: &[Step<'_>], walked: &str, value: Spanned) -> Result<(), Astray> {
    let (step, rest) = match steps {
        [] => {
            *target = value;
            return Ok(());
        }
        [step, rest @ ..] => (*step, rest),
    };
    let here = shorten(walked);
    match (&mut target.json, step) {
        (Json::Object(entries), Step::Key(key)) => {
            let path = if walked.is_empty() { key.to_owned() } else { format!("{walked}.{key}") };
            if rest.is_empty() {
                entries.retain(|entry| entry.key != key);
                entries.push(Entry { key: key.into(), offset: value.offset, value });
                return Ok(());
            }
            match entries.iter_mut().rfind(|entry| entry.key == key) {
                Some(entry) => put(&mut entry.value, rest, &path, value),
                None => {
                    let near = nearest(key, entries.iter().map(|entry| entry.key.as_str()));
                    let remedy = match near {
                        Some(near) => format!("did you mean \"{near}\"?"),
                        None => format!("set all of \"{}\"", shorten(&path)),
                    };
                    let found = format!("\"{}\", which the document does not set", shorten(&path));
                    Err(Astray { found, expected: "a value to change a part of".into(), remedy })
                }
            }
        }
        (Json::Array(items), Step::Index(index)) => {
            let (path, count) = (format!("{walked}[{index}]"), items.len());
            match items.get_mut(index) {
                Some(item) => put(item, rest, &path, value),
                None => {
                    let found = format!("\"{}\", in a list of {count}", shorten(&path));
                    let expected = match count {
                        0 => "a list with items".into(),
                        1 => "item 0".into(),
                        _ => format!("an item from 0 to {}", count - 1),
                    };
                    Err(Astray { found, expected, remedy: format!("set all of \"{here}\" to make it longer") })
                }
            }
        }
        (_, Step::Key(key)) => {
            let found = format!("\"{}\", an entry of {}", shorten(&format!("{walked}.{key}")), target.brief());
            let remedy = if matches!(target.json, Json::Array(_)) {
                format!("name an item of the list first: {here}[0].{}", shorten(key))
            } else {
                format!("set all of \"{here}\"")
            };
            Err(Astray { found, expected: "entries in what is set".into(), remedy })
        }
        (_, Step::Index(index)) => {
            let found = format!("\"{}\", an item of {}", shorten(&format!("{walked}[{index}]")), target.brief());
            Err(Astray { found, expected: "a list".into(), remedy: format!("set all of \"{here}\"") })
        }
    }
}

impl Document {
    /// Sets a value by an assignment `PATH=VALUE`. The path is that of a knob or port, `NODE.KNOB`; of a part of one,
    /// such as `sky.stops[1].color` or `camera.position[0]`, where items count from 0; or of a color, `palette.NAME`.
    /// `VALUE` is JSON, or a bare word that stands for a string.
    ///
    /// # Errors
    /// The assignment has another form, or its path leads to nothing in the document.
    pub fn set(&mut self, assignment: &str) -> Result<(), Box<Diagnostic>> {
        let mut fault = Diagnostic {
            severity: Severity::Error,
            file: shorten(assignment),
            is_assigned: true,
            line: 0,
            column: 0,
            node: None,
            port: None,
            found: format!("\"{}\"", shorten(assignment)),
            expected: "NODE.KNOB=VALUE, for example storm.height=3".into(),
            remedy: "write a node of the document, a dot, one of its knobs, =, and a JSON value".into(),
            means: None,
            used: None,
        };
        let parts = assignment.split_once('=').and_then(|(path, value)| Some((steps(path)?, value)));
        let Some(([Step::Key(node), path @ ..], value)) = parts.as_ref().map(|(steps, value)| (&steps[..], *value))
        else {
            return Err(Box::new(fault));
        };
        if !matches!(path, [Step::Key(_), ..]) {
            return Err(Box::new(fault));
        }
        let mut value = match parse(value) {
            Ok(value) => value,
            // A bare word or color. A text that looks like JSON must be JSON.
            Err(_) if !value.is_empty() && !value.starts_with(['{', '[', '"', '-']) => {
                Spanned { offset: 0, json: Json::String(value.into()) }
            }
            Err(error) => {
                fault.found = error.fault.to_string();
                return Err(Box::new(fault));
            }
        };
        let place = ASSIGNED + self.assignments.len();
        relocate(&mut value, &|_| place);
        let set = match *node {
            "palette" => Some(self.set_color(path, value.clone())),
            "knobs" => Some(self.set_knob(path, value.clone())),
            _ => None,
        };
        if let Some(set) = set {
            return match set {
                Ok(()) => {
                    self.assignments.push(assignment.into());
                    Ok(())
                }
                Err(Astray { found, expected, remedy }) => {
                    Err(Box::new(Diagnostic { found, expected, remedy, ..fault }))
                }
            };
        }
        let at_top = matches!(&self.root.json, Json::Object(entries) if entries.iter().any(|entry| entry.key == *node));
        let mut names = Vec::new();
        if let Some(Json::Object(nodes)) = self.top("nodes").map(|nodes| &mut nodes.json) {
            names = nodes.iter().map(|entry| entry.key.clone()).collect();
            if let Some(entry) = nodes.iter_mut().find(|entry| entry.key == *node)
                && matches!(entry.value.json, Json::Object(_))
            {
                return match put(&mut entry.value, path, "", value) {
                    Ok(()) => {
                        self.assignments.push(assignment.into());
                        Ok(())
                    }
                    Err(Astray { found, expected, remedy }) => {
                        let node = Some(shorten(node));
                        Err(Box::new(Diagnostic { node, found, expected, remedy, ..fault }))
                    }
                };
            }
        }
        fault.found = format!("node \"{}\"", shorten(node));
        fault.expected = "a node of the document".into();
        if at_top {
            fault.found = format!("\"{}\", which is not a node but a key beside \"nodes\"", shorten(node));
            let key = shorten(node);
            fault.remedy =
                format!("change \"{key}\" in the document itself: assignments change only nodes and the palette");
            fault.means = Some(Means::EditDocument { key });
        } else if let Some(near) = nearest(node, names.iter().map(String::as_str)) {
            fault.remedy = format!("did you mean \"{near}\"?");
        }
        Err(Box::new(fault))
    }

    /// Sets a color of the palette, or a part of one.
    fn set_color(&mut self, path: &[Step<'_>], value: Spanned) -> Result<(), Astray> {
        let none = |found: &str| Astray {
            found: found.into(),
            expected: "a document with a palette".into(),
            remedy: "add \"palette\": { … } to the document".into(),
        };
        let Some(palette) = self.top("palette") else { return Err(none("no \"palette\"")) };
        let Json::Object(entries) = &palette.json else { return Err(none("a palette that is not read")) };
        if let [Step::Key(name), ..] = path
            && !entries.iter().any(|entry| entry.key == *name)
        {
            let remedy = match nearest(name, entries.iter().map(|entry| entry.key.as_str())) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "name a color that the palette has, or add it in the document".into(),
            };
            let found = format!("the color \"{}\"", shorten(name));
            return Err(Astray { found, expected: "a color of the document's palette".into(), remedy });
        }
        put(palette, path, "palette", value)
    }

    /// Sets a knob of the document, or a part of its value. Its range and help stay.
    fn set_knob(&mut self, path: &[Step<'_>], value: Spanned) -> Result<(), Astray> {
        let Some(Json::Object(knobs)) = self.top("knobs").map(|knobs| &mut knobs.json) else {
            return Err(Astray {
                found: "no \"knobs\"".into(),
                expected: "a document with knobs".into(),
                remedy: "add \"knobs\": { … } to the document, or set a knob of a node: NODE.KNOB=VALUE".into(),
            });
        };
        let [Step::Key(name), rest @ ..] = path else { unreachable!("a path of a knob begins with its name") };
        let names: Vec<String> = knobs.iter().map(|knob| knob.key.clone()).collect();
        let Some(knob) = knobs.iter_mut().find(|knob| knob.key == *name) else {
            let remedy = match nearest(name, names.iter().map(String::as_str)) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("knobs of the document: {}", names.join(", ")),
            };
            let found = format!("the knob \"{}\"", shorten(name));
            return Err(Astray { found, expected: "a knob of the document".into(), remedy });
        };
        let target = match &mut knob.value.json {
            Json::Object(items) if items.iter().any(|item| item.key == "value") => {
                items.iter_mut().find(|item| item.key == "value").map(|item| &mut item.value)
            }
            _ => Some(&mut knob.value),
        };
        target.map_or(Ok(()), |target| put(target, rest, &format!("knobs.{name}"), value))
    }

    /// Returns the value of a key at the top.
    pub(super) fn top(&mut self, key: &str) -> Option<&mut Spanned> {
        let Json::Object(entries) = &mut self.root.json else { return None };
        entries.iter_mut().find(|entry| entry.key == key).map(|entry| &mut entry.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = r##"{
        "palette": { "deep": "#000", "glow": { "keys": [[1, "#fff"], [9, "#888"]] } },
        "nodes": { "storm": { "height": 1, "groups": [{ "x": 1 }, { "x": 2, "path": [0, 1, 2] }] } }
    }"##;

    fn set(assignments: &[&str]) -> String {
        let mut document = Document::parse("d", DOCUMENT).expect("valid");
        assignments.iter().for_each(|assignment| document.set(assignment).expect(assignment));
        document.canonical()
    }

    fn fails(assignment: &str) -> String {
        let mut document = Document::parse("d", DOCUMENT).expect("valid");
        let before = document.canonical();
        let fault = document.set(assignment).expect_err(assignment);
        assert_eq!(document.canonical(), before, "{assignment}");
        fault.to_string()
    }

    #[test]
    fn knobs_are_replaced_or_added() {
        let text = set(&["storm.height=2.5", "storm.word=deep"]);
        assert!(text.contains(r#""height":2.5,"word":"deep""#), "{text}");
    }

    #[test]
    fn parts_are_replaced_and_the_rest_stays() {
        let text = set(&["storm.groups[1].x=5", "storm.groups[0].seed=3", "storm.groups[1].path[2]=7"]);
        assert!(text.contains(r#""groups":[{"seed":3.0,"x":1.0},{"path":[0.0,1.0,7.0],"x":5.0}]"#), "{text}");
        let text = set(&["storm.groups[0]={\"x\": 9}"]);
        assert!(text.contains(r#""groups":[{"x":9.0},{"#), "{text}");
    }

    #[test]
    fn colors_of_the_palette_are_replaced() {
        let text = set(&["palette.deep=#14262e", "palette.glow.keys[1][1]=#c00"]);
        assert!(
            text.contains(r##""palette":{"deep":"#14262e","glow":{"keys":[[1.0,"#fff"],[9.0,"#c00"]]}}"##),
            "{text}"
        );
    }

    #[test]
    fn paths_that_lead_to_nothing_are_told() {
        for (assignment, words) in [
            ("nonsense", "expected NODE.KNOB=VALUE"),
            ("storm=1", "expected NODE.KNOB=VALUE"),
            ("storm[0]=1", "expected NODE.KNOB=VALUE"),
            ("storm.groups[x]=1", "expected NODE.KNOB=VALUE"),
            ("storm.groups[1=1", "expected NODE.KNOB=VALUE"),
            ("storm..x=1", "expected NODE.KNOB=VALUE"),
            ("storm.height={", "a syntax error"),
            ("strom.height=1", "did you mean \"storm\"?"),
            ("storm.groups[2].x=1", "\"groups[2]\", in a list of 2; expected an item from 0 to 1"),
            ("storm.groups.x=1", "name an item of the list first: groups[0].x"),
            ("storm.group[0].x=1", "did you mean \"groups\"?"),
            ("storm.stops[0].x=1", "set all of \"stops\""),
            ("storm.height[0]=1", "\"height[0]\", an item of 1; expected a list"),
            ("storm.height.x=1", "set all of \"height\""),
            ("palette.depe=#fff", "did you mean \"deep\"?"),
            ("nodes.x=1", "a key beside \"nodes\""),
        ] {
            let said = fails(assignment);
            assert!(said.contains(words), "{assignment}: {said}");
        }
    }
}
