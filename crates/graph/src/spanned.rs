//! JSON values with their places in the text.
//!
//! `serde_json` checks the syntax and reports its faults; a second walk over the text then records the place of every
//! value. Objects keep duplicate keys, so that validation can report them.

use serde_json::value::RawValue;
use std::borrow::Cow;

/// Deepest nesting of a document; legal documents stay far below.
pub const MAX_DEPTH: usize = 32;
/// Largest number of values in a document, so that a small file cannot take much memory.
pub const MAX_VALUES: usize = 4_000_000;

/// A value and the byte offset at which it starts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spanned {
    /// Byte offset in the source text.
    pub offset: usize,
    /// The value.
    pub json: Json,
}

/// JSON value, with the entries of objects in the order of the text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Json {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number; infinite if it exceeds the range of f64.
    Number(f64),
    /// A string.
    String(String),
    /// An array.
    Array(Vec<Spanned>),
    /// An object in the order of the text, duplicate keys included.
    Object(Vec<Entry>),
}

/// One entry of an object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    /// The key.
    pub key: String,
    /// Byte offset of the key, or of its value if the key contains escapes.
    pub offset: usize,
    /// The value.
    pub value: Spanned,
}

impl Spanned {
    /// Describes the value in a few words, for "found …".
    pub(crate) fn brief(&self) -> String {
        match &self.json {
            Json::Null => "null".into(),
            Json::Bool(value) => value.to_string(),
            Json::Number(number) => number_text(*number),
            Json::String(text) => format!("\"{}\"", shorten(text)),
            Json::Array(items) => format!("a list of {}", items.len()),
            Json::Object(entries) => format!("an object with {} keys", entries.len()),
        }
    }
}

/// Shortens a text to at most 60 characters, so that messages do not grow with their input, and escapes control
/// characters, so that none of them breaks lines or controls a terminal.
pub(crate) fn shorten(text: &str) -> String {
    let length = if text.chars().nth(60).is_some() { 57 } else { 60 };
    let mut short = String::new();
    for c in text.chars().take(length) {
        if c.is_control() { short.extend(c.escape_default()) } else { short.push(c) }
    }
    if length < 60 {
        short.push_str("...");
    }
    short
}

/// Formats a number for messages, with an exponent if it would have many digits.
pub(crate) fn number_text(number: f64) -> String {
    if !number.is_finite() {
        return "a number beyond the range of f64".into();
    }
    let plain = number == 0.0 || (1e-5..1e15).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}

/// Reason why a text is not JSON within the limits.
#[derive(Debug)]
pub(crate) struct SyntaxError {
    /// Byte offset of the fault.
    pub offset: usize,
    /// Description of the fault.
    pub fault: SyntaxFault,
}

/// Fault in a text.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SyntaxFault {
    /// The text is not JSON.
    #[error("a syntax error ({})", without_place(.0))]
    NoJson(#[source] serde_json::Error),
    /// A string has an invalid escape.
    #[error("{}", without_place(.0))]
    Escape(#[source] serde_json::Error),
    /// A number cannot be parsed.
    #[error("\"{0}\", which is not a number")]
    NoNumber(String),
    /// Lists and objects are nested too deeply.
    #[error("values nested deeper than {MAX_DEPTH} levels")]
    TooDeep,
    /// The text holds too many values.
    #[error("more than {MAX_VALUES} values")]
    TooMany,
}

impl SyntaxFault {
    /// Whether the text ends too early.
    pub(crate) fn is_end(&self) -> bool {
        matches!(self, Self::NoJson(error) | Self::Escape(error) if error.is_eof())
    }

    /// Whether the text holds more than any document needs.
    pub(crate) fn is_excess(&self) -> bool {
        matches!(self, Self::TooDeep | Self::TooMany)
    }
}

/// Reads a JSON text.
///
/// # Errors
/// The text is not JSON, or exceeds the limits of depth or size.
pub(crate) fn parse(text: &str) -> Result<Spanned, SyntaxError> {
    // A raw value does not build the values inside of it, so this takes no memory for any text.
    let _: &RawValue = serde_json::from_str(text).map_err(|error| SyntaxError {
        offset: offset_of(text, error.line(), error.column()),
        fault: SyntaxFault::NoJson(error),
    })?;
    Reader { text, at: 0, left: MAX_VALUES }.value(0)
}

/// Walks a text that is known to be JSON, so that only limits and escapes can cause errors.
struct Reader<'t> {
    text: &'t str,
    at: usize,
    left: usize,
}

impl<'t> Reader<'t> {
    fn peek(&self) -> u8 {
        self.text.as_bytes().get(self.at).copied().unwrap_or(0)
    }

    fn skip(&mut self, is: impl Fn(u8) -> bool) {
        while self.text.as_bytes().get(self.at).is_some_and(|byte| is(*byte)) {
            self.at += 1;
        }
    }

    /// Skips white space and the punctuation between values.
    fn separators(&mut self) {
        self.skip(|byte| matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | b',' | b':'));
    }

    fn value(&mut self, depth: usize) -> Result<Spanned, SyntaxError> {
        self.separators();
        let offset = self.at;
        let error = |fault: SyntaxFault| SyntaxError { offset, fault };
        if depth > MAX_DEPTH {
            return Err(error(SyntaxFault::TooDeep));
        }
        self.left = self.left.checked_sub(1).ok_or_else(|| error(SyntaxFault::TooMany))?;
        let json = match self.peek() {
            b'"' => Json::String(self.string()?.into_owned()),
            b'[' => {
                self.at += 1;
                let mut items = Vec::new();
                self.separators();
                while self.peek() != b']' {
                    items.push(self.value(depth + 1)?);
                    self.separators();
                }
                self.at += 1;
                Json::Array(items)
            }
            b'{' => {
                self.at += 1;
                let mut entries = Vec::new();
                self.separators();
                while self.peek() != b'}' {
                    let opening = self.at;
                    let key = self.string()?;
                    let escaped = matches!(key, Cow::Owned(_));
                    let key = key.into_owned();
                    let value = self.value(depth + 1)?;
                    let offset = if escaped { value.offset } else { opening };
                    entries.push(Entry { key, offset, value });
                    self.separators();
                }
                self.at += 1;
                Json::Object(entries)
            }
            first => {
                self.skip(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.'));
                let slice = &self.text[offset..self.at];
                match first {
                    b'n' => Json::Null,
                    b't' => Json::Bool(true),
                    b'f' => Json::Bool(false),
                    _ => Json::Number(slice.parse().map_err(|_| error(SyntaxFault::NoNumber(shorten(slice))))?),
                }
            }
        };
        Ok(Spanned { offset, json })
    }

    /// Reads a string, borrowed from the text if it contains no escapes.
    fn string(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        let opening = self.at;
        let mut escaped = false;
        self.at += 1;
        loop {
            self.skip(|byte| byte != b'"' && byte != b'\\');
            if self.peek() != b'\\' {
                break;
            }
            escaped = true;
            self.at += 2;
        }
        self.at += 1;
        let slice = &self.text[opening..self.at];
        if !escaped {
            return Ok(Cow::Borrowed(&slice[1..slice.len() - 1]));
        }
        let string: serde_json::Result<String> = serde_json::from_str(slice);
        string.map(Cow::Owned).map_err(|error| SyntaxError { offset: opening, fault: SyntaxFault::Escape(error) })
    }
}

/// Returns the byte offset of a line and column (in bytes, both from 1), as `serde_json` counts them.
fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// Removes the place at the end of a message of `serde_json`, which the diagnostic already states.
fn without_place(error: &serde_json::Error) -> String {
    let (message, place) = (error.to_string(), format!(" at line {} column {}", error.line(), error.column()));
    message.strip_suffix(&place).map_or(message.clone(), String::from)
}

/// Returns line and column (in characters, both from 1) of a byte offset.
pub(crate) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1);
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    // Count the bytes that start a character; the offset may be inside of one.
    let column = before[line_start..].iter().filter(|&&b| b & 0xC0 != 0x80).count() + 1;
    (line, column)
}

/// Bytes between two known places.
const STRIDE: usize = 1024;

/// Line and column at regular offsets of a text, so that any place is found by a short walk: otherwise each of a
/// thousand warnings about a long document would read all of it.
#[derive(Clone, Debug)]
pub(crate) struct LineIndex(Vec<(usize, usize)>);

impl LineIndex {
    pub(crate) fn new(text: &str) -> Self {
        let mut known = Vec::with_capacity(text.len() / STRIDE + 1);
        let mut at = (1, 1);
        for chunk in text.as_bytes().chunks(STRIDE) {
            known.push(at);
            at = walk(at, chunk);
        }
        known.push(at);
        Self(known)
    }

    /// Returns line and column (in characters, both from 1) of a byte offset of the same text.
    pub(crate) fn find(&self, text: &str, offset: usize) -> (usize, usize) {
        let offset = offset.min(text.len());
        let start = offset / STRIDE;
        walk(self.0[start], &text.as_bytes()[start * STRIDE..offset])
    }
}

/// Returns line and column after some bytes.
fn walk(from: (usize, usize), bytes: &[u8]) -> (usize, usize) {
    bytes.iter().fold(from, |(line, column), &byte| match byte {
        b'\n' => (line + 1, 1),
        // Count the bytes that start a character.
        _ => (line, column + usize::from(byte & 0xC0 != 0x80)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_places_give_every_place() {
        let text = "é\n\n".repeat(700) + &"xé".repeat(2000) + "\nend";
        let lines = LineIndex::new(&text);
        for offset in (0..text.len() + 3).filter(|offset| *offset % 7 == 0 || text.len() - offset.min(&text.len()) < 3)
        {
            assert_eq!(lines.find(&text, offset), line_and_column(&text, offset), "{offset}");
        }
        assert_eq!(LineIndex::new("").find("", 0), (1, 1));
    }

    #[test]
    fn escapes_spaces_and_punctuation() {
        let text = " { \"a\\\"]\" :[ ] ,\"b\":{},\t\"c\" : [-1.5e+3 ,true,\nnull,\"\\\\\" , [false]] } ";
        let Json::Object(entries) = parse(text).expect("valid").json else { panic!("object") };
        let keys: Vec<&str> = entries.iter().map(|entry| entry.key.as_str()).collect();
        assert_eq!(keys, ["a\"]", "b", "c"]);
        assert_eq!(entries[0].offset, entries[0].value.offset, "keys with escapes stand where their value does");
        let Json::Array(items) = &entries[2].value.json else { panic!("array") };
        assert_eq!(items[0].json, Json::Number(-1500.0));
        assert_eq!((&items[1].json, &items[2].json), (&Json::Bool(true), &Json::Null));
        assert_eq!(items[3].json, Json::String("\\".into()));
        assert!(matches!(&items[4].json, Json::Array(inner) if inner[0].json == Json::Bool(false)));
        assert_eq!(text.as_bytes()[items[4].offset], b'[');
        assert!(parse("\"\\ud800\"").is_err(), "half a character");
    }

    #[test]
    fn places_are_exact() {
        let text = "{\n  \"é\": [1, {\"b\": \"x\"}],\n  \"a\\u0041\": 1e999 }";
        let root = parse(text).expect("valid");
        let Json::Object(entries) = &root.json else { panic!("object") };
        assert_eq!(line_and_column(text, entries[0].offset), (2, 3));
        let Json::Array(items) = &entries[0].value.json else { panic!("array") };
        assert_eq!(line_and_column(text, items[1].offset), (2, 12));
        assert_eq!(entries[1].key, "aA");
        assert_eq!(entries[1].value.json, Json::Number(f64::INFINITY));
    }

    #[test]
    fn duplicates_are_kept() {
        let Json::Object(entries) = parse(r#"{"a": 1, "a": 2}"#).expect("valid").json else { panic!("object") };
        assert_eq!(entries.len(), 2);
    }

    #[test]
    fn limits_stop_deep_and_broken_texts() {
        let deep = "[".repeat(100_000) + &"]".repeat(100_000);
        assert!(parse(&deep).expect_err("deep").fault.is_excess());
        let error = parse("{\"a\": 1,\n \"b\": }").expect_err("syntax");
        assert_eq!(line_and_column("{\"a\": 1,\n \"b\": }", error.offset).0, 2);
        assert!(parse("NaN").is_err());
        assert!(parse("").is_err());
    }
}
