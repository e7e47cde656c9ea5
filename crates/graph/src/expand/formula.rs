//! Formulas in links: evaluated at each frame, so that what is checked are constants and keys.

use super::Expander;
use super::link::is_word;
use super::scope::Scope;
use crate::spanned::{Entry, Json, Spanned, number_text, shorten};
use crate::{Animated, CurveHandle, CurveKey, Interpolation, nearest};
use std::ops::Range;
use std::rc::Rc;

/// Most frames of a document with formulas over time.
const MOST_FRAMES: i64 = 100_000;
/// Most components of a value.
const WIDTH: usize = 4;
/// Names that every formula has.
const NAMES: [&str; 4] = ["frame", "time", "width", "height"];

/// Frames and size of a document.
pub(super) struct Time {
    first: i64,
    last: i64,
    fps: f64,
    size: [f64; 2],
}

impl Time {
    /// Reads frames and size; what is faulty is reported where it is checked.
    pub(super) fn of(root: &[Entry]) -> Self {
        let number = |within: &str, key: &str| -> Option<f64> {
            let Json::Object(entries) = &root.iter().find(|entry| entry.key == within)?.value.json else { return None };
            match entries.iter().find(|entry| entry.key == key)?.value.json {
                Json::Number(number) => Some(number),
                _ => None,
            }
        };
        let first = number("frames", "first").unwrap_or(1.0) as i64;
        let last = number("frames", "last").map_or(first, |last| last as i64);
        let fps = number("frames", "fps").filter(|fps| *fps > 0.0).unwrap_or(24.0);
        let size = ["width", "height"].map(|side| number("format", side).unwrap_or(1.0));
        Self { first, last, fps, size }
    }

    /// Returns the values of [`NAMES`] at a frame.
    fn at(&self, frame: i64) -> [f64; 4] {
        [frame as f64, (frame - self.first) as f64 / self.fps, self.size[0], self.size[1]]
    }
}

/// Named value in a formula.
enum Named {
    /// One of [`NAMES`].
    Own(usize),
    Numbers(Animated),
}

impl<'d> Expander<'d> {
    /// Returns the value of a formula: a number or a list of numbers, keyed at each frame if it changes.
    pub(super) fn formula(&mut self, text: &str, offset: usize, scope: &Rc<Scope<'d>>) -> Option<Spanned> {
        let Some(formulas) = self.registry.formulas() else {
            let found = format!("the formula \"{}\"", shorten(text));
            self.error(offset, found, "\"= knobs.NAME\" or \"= NODE.KNOB\"", "this build has no formulas");
            return None;
        };
        let (mut names, mut values) = (Vec::new(), Vec::new());
        for name in names_in(text) {
            let value = self.named(&name, text, offset, scope)?;
            let width = match &value {
                Named::Own(_) => 1,
                Named::Numbers(numbers) => numbers.values().next().map_or(1, <[f64]>::len),
            };
            names.push((name, width));
            values.push(value);
        }
        let formula = match formulas.parse(text, &names) {
            Ok(formula) => formula,
            Err(fault) => {
                let found = format!("{} of the formula \"{}\"", fault.found, shorten(text));
                let remedy = if fault.remedy.is_empty() { "correct the formula".into() } else { fault.remedy };
                self.error(offset, found, fault.expected, remedy);
                return None;
            }
        };
        let changes = values.iter().any(|value| match value {
            Named::Own(index) => *index < 2,
            Named::Numbers(numbers) => numbers.frames().next().is_some(),
        });
        let last = if changes { self.time.last.max(self.time.first) } else { self.time.first };
        if last - self.time.first >= MOST_FRAMES {
            let found = format!("a formula over {} frames", last - self.time.first + 1);
            self.error(offset, found, format!("at most {MOST_FRAMES} frames"), "split the document");
            return None;
        }
        let mut keys: Vec<(i64, Vec<f64>)> = Vec::new();
        for frame in self.time.first..=last {
            let own = self.time.at(frame);
            let at = |value: &Named| match value {
                Named::Own(index) => vec![own[*index]],
                Named::Numbers(numbers) => numbers.at(frame as f64),
            };
            let inputs: Vec<Vec<f64>> = values.iter().map(at).collect();
            let value = formula.value(&inputs);
            if let Some(bad) = value.iter().find(|number| !number.is_finite()) {
                let part = formula.origin(&inputs).map(|part| slice(text, part)).filter(|part| part != text.trim());
                let by = part.map_or(String::new(), |part| format!(", because of \"{}\"", shorten(&part)));
                let found = format!("{bad} at frame {frame}, the value of \"{}\"{by}", shorten(text));
                self.error(offset, found, "finite numbers", self.explained(&names, &inputs));
                return None;
            }
            keys.push((frame, value));
        }
        Some(Spanned { offset, json: written(&keys, offset) })
    }

    /// Returns a list of which some components are keyed, by links, as one keyed value; `None` if none is, or it is no list of
    /// numbers.
    pub(super) fn keyed_list(&self, list: &[Spanned], offset: usize) -> Option<Json> {
        let parts: Vec<Animated> = list.iter().map(numbers).collect::<Option<_>>()?;
        let is_list = parts.len() <= WIDTH && parts.iter().all(|part| part.values().all(|value| value.len() == 1));
        let is_keyed = parts.iter().any(|part| part.frames().next().is_some());
        let frames = self.time.first..=self.time.last.max(self.time.first);
        if !is_list || !is_keyed || frames.end() - frames.start() >= MOST_FRAMES {
            return None;
        }
        let at = |frame: i64| (frame, parts.iter().flat_map(|part| part.at(frame as f64)).collect());
        Some(written(&frames.map(at).collect::<Vec<_>>(), offset))
    }

    /// Lists what the names of a formula stand for.
    fn explained(&self, names: &[(String, usize)], inputs: &[Vec<f64>]) -> String {
        let list = |numbers: &[f64]| match numbers {
            [number] => number_text(*number),
            numbers => format!("[{}]", numbers.iter().map(|n| number_text(*n)).collect::<Vec<_>>().join(", ")),
        };
        let named = names.iter().zip(inputs).map(|((name, _), value)| format!("{name} is {}", list(value)));
        let named: Vec<String> = named.collect();
        if named.is_empty() {
            "correct the formula".into()
        } else {
            format!("change one of these: {}", named.join(", "))
        }
    }

    /// Returns the value of a name.
    fn named(&mut self, name: &str, text: &str, offset: usize, scope: &Rc<Scope<'d>>) -> Option<Named> {
        if let Some(own) = NAMES.iter().position(|own| *own == name) {
            return Some(Named::Own(own));
        }
        let Some((node, knob)) = name.split_once('.') else {
            let remedy = match nearest(name, NAMES) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "write knobs.NAME or NODE.KNOB".into(),
            };
            let found = format!("\"{}\" in the formula \"{}\"", shorten(name), shorten(text));
            self.error(offset, found, "frame, time, width, height, pi, a function, or a knob", remedy);
            return None;
        };
        let value = self.value_of(scope, node, knob, offset)?;
        match numbers(&value) {
            Some(numbers) => Some(Named::Numbers(numbers)),
            None => {
                let found =
                    format!("\"{}\", which is {}, in the formula \"{}\"", shorten(name), value.brief(), shorten(text));
                self.error(offset, found, "numbers", "link words, files and colors as they are: \"= NODE.KNOB\"");
                None
            }
        }
    }
}

/// Returns characters of a text.
fn slice(text: &str, part: Range<usize>) -> String {
    text.chars().skip(part.start).take(part.len()).collect()
}

/// Returns the names in a formula, each once: words that are no functions and not pi, with the word after a dot.
fn names_in(text: &str) -> Vec<String> {
    let characters: Vec<char> = text.chars().collect();
    let is_part = |at: usize| characters.get(at).is_some_and(|c| c.is_ascii_alphanumeric() || *c == '_');
    let (mut at, mut names) = (0, Vec::new());
    while at < characters.len() {
        let start = at;
        if !characters[at].is_ascii_alphabetic() && characters[at] != '_' {
            // The e of 1e3 is no name.
            while is_part(at) {
                at += 1;
            }
            at += usize::from(at == start);
            continue;
        }
        while is_part(at) {
            at += 1;
        }
        // The letters after a bracket pick components.
        let is_picked = start > 0 && characters[start - 1] == '.';
        let mut end = at;
        if characters.get(at) == Some(&'.') && is_part(at + 1) && !is_picked {
            end = at + 1;
            while is_part(end) {
                end += 1;
            }
        }
        let word: String = characters[start..at].iter().collect();
        let is_function = characters[at..].iter().find(|c| !c.is_whitespace()) == Some(&'(');
        let whole: String = characters[start..end].iter().collect();
        at = end;
        if !is_function && !is_picked && word != "pi" && is_word(&word) && !names.contains(&whole) {
            names.push(whole);
        }
    }
    names
}

/// Returns a value as numbers, constant or keyed.
pub(super) fn numbers(value: &Spanned) -> Option<Animated> {
    let several = |value: &Spanned| -> Option<Vec<f64>> {
        match &value.json {
            Json::Number(number) => Some(vec![*number]),
            Json::Array(items) if (1..=WIDTH).contains(&items.len()) => items
                .iter()
                .map(|item| if let Json::Number(number) = item.json { Some(number) } else { None })
                .collect(),
            _ => None,
        }
    };
    let Json::Object(entries) = &value.json else { return several(value).map(Animated::constant) };
    let interpolation = match find(entries, "interpolation") {
        Some(value) => word(value)?,
        None => Interpolation::default(),
    };
    let Json::Array(keys) = &find(entries, "keys")?.json else { return None };
    let key = |key: &Spanned| {
        let Json::Array(items) = &key.json else { return None };
        let [Spanned { json: Json::Number(frame), .. }, value, rest @ ..] = &items[..] else { return None };
        let plain = CurveKey::plain(*frame, several(value)?);
        match rest {
            [] => Some(plain),
            [Spanned { json: Json::Object(more), .. }] => {
                let handle = |side: &str| match find(more, side) {
                    None => Some(None),
                    Some(Spanned { json: Json::Array(pair), .. }) => match &pair[..] {
                        [Spanned { json: Json::Number(frames), .. }, change] => {
                            Some(Some(CurveHandle { frames: frames.abs(), change: several(change)? }))
                        }
                        _ => None,
                    },
                    Some(_) => None,
                };
                let interpolation = match find(more, "interpolation") {
                    Some(value) => Some(word(value)?),
                    None => None,
                };
                Some(CurveKey { handles: [handle("in")?, handle("out")?], interpolation, ..plain })
            }
            _ => None,
        }
    };
    Animated::keyed(keys.iter().map(key).collect::<Option<_>>()?, interpolation)
}

fn find<'e>(entries: &'e [Entry], key: &str) -> Option<&'e Spanned> {
    entries.iter().find(|entry| entry.key == key).map(|entry| &entry.value)
}

fn word(value: &Spanned) -> Option<Interpolation> {
    if let Json::String(name) = &value.json { Interpolation::from_name(name) } else { None }
}

/// Returns values at frames as they would be written: one value if they are the same at all frames, else keys.
fn written(keys: &[(i64, Vec<f64>)], offset: usize) -> Json {
    let spanned = |json: Json| Spanned { offset, json };
    let value = |numbers: &[f64]| match numbers {
        [number] => Json::Number(*number),
        numbers => Json::Array(numbers.iter().map(|number| spanned(Json::Number(*number))).collect()),
    };
    let Some((_, first)) = keys.first() else { return Json::Null };
    if keys.iter().all(|(_, value)| value == first) {
        return value(first);
    }
    let key = |(frame, numbers): &(i64, Vec<f64>)| {
        spanned(Json::Array(vec![spanned(Json::Number(*frame as f64)), spanned(value(numbers))]))
    };
    let keys = spanned(Json::Array(keys.iter().map(key).collect()));
    Json::Object(vec![Entry { key: "keys".into(), offset, value: keys }])
}
