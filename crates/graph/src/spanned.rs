//! JSON with the place of every value, read through `serde_json`.
//!
//! `serde_json` hands out each value as a slice of the source text (`RawValue`); the slice's position is the
//! value's place. Objects keep duplicate keys, so that validation can refuse them.

use serde::Deserialize;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// Deepest nesting of a document; no legal document comes near.
pub const MAX_DEPTH: usize = 32;
/// Most values in a document, so that a small file cannot take much memory.
pub const MAX_VALUES: usize = 4_000_000;

/// A value and the byte offset at which it starts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spanned {
    /// Byte offset in the source text.
    pub offset: usize,
    /// The value.
    pub json: Json,
}

/// JSON, with numbers and objects kept as written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Json {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number; infinite where it exceeds the range of f64.
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
    /// Byte offset of the key (of its value, where the key holds escapes).
    pub offset: usize,
    /// The value.
    pub value: Spanned,
}

impl Spanned {
    /// The value in a few words, for "found …".
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

/// At most 60 characters of a text, so that no message grows with its input; control characters escaped, so that none
/// of them breaks its lines or steers a terminal.
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

/// A number for messages, with an exponent where digits would be many.
pub(crate) fn number_text(number: f64) -> String {
    if !number.is_finite() {
        return "a number beyond the range of f64".into();
    }
    let plain = number == 0.0 || (1e-5..1e15).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}

/// Why a text is not JSON within the limits.
#[derive(Debug)]
pub(crate) struct SyntaxError {
    /// Byte offset of the fault.
    pub offset: usize,
    /// What is wrong there.
    pub message: String,
}

/// Reads a JSON text.
///
/// # Errors
/// Not JSON, or nested deeper or larger than the limits.
pub(crate) fn parse(text: &str) -> Result<Spanned, SyntaxError> {
    let raw: &RawValue = serde_json::from_str(text).map_err(|error| SyntaxError {
        offset: offset_of(text, error.line(), error.column()),
        message: format!("a syntax error ({})", strip_place(&error.to_string())),
    })?;
    let mut reader = Reader { text, left: MAX_VALUES };
    reader.value(raw, 0)
}

struct Reader<'t> {
    text: &'t str,
    left: usize,
}

impl<'t> Reader<'t> {
    /// Where a slice of the text starts. Both are slices of one string, so the difference is its place.
    fn offset(&self, slice: &str) -> usize {
        (slice.as_ptr() as usize).wrapping_sub(self.text.as_ptr() as usize)
    }

    fn value(&mut self, raw: &'t RawValue, depth: usize) -> Result<Spanned, SyntaxError> {
        let slice = raw.get();
        let offset = self.offset(slice);
        let error = |message: String| SyntaxError { offset, message };
        if depth > MAX_DEPTH {
            return Err(error(format!("values are nested deeper than {MAX_DEPTH} levels")));
        }
        self.left = self
            .left
            .checked_sub(1)
            .ok_or_else(|| error(format!("the document holds more than {MAX_VALUES} values")))?;
        let inner = |e: serde_json::Error| error(strip_place(&e.to_string()));
        let json = match slice.as_bytes().first() {
            Some(b'n') => Json::Null,
            Some(b't') => Json::Bool(true),
            Some(b'f') => Json::Bool(false),
            Some(b'"') => Json::String(serde_json::from_str(slice).map_err(inner)?),
            Some(b'[') => {
                let items: Items<'t> = self.bounded(slice).map_err(inner)?;
                let items: Result<_, _> = items.0.into_iter().map(|item| self.value(item, depth + 1)).collect();
                Json::Array(items?)
            }
            Some(b'{') => {
                let entries: Entries<'t> = self.bounded(slice).map_err(inner)?;
                let mut object = Vec::with_capacity(entries.0.len());
                for (key, value) in entries.0 {
                    let value = self.value(value, depth + 1)?;
                    let offset = match key {
                        // The opening quote stands one byte before the borrowed key.
                        Cow::Borrowed(key) => self.offset(key).saturating_sub(1),
                        Cow::Owned(_) => value.offset,
                    };
                    object.push(Entry { key: key.into_owned(), offset, value });
                }
                Json::Object(object)
            }
            _ => Json::Number(slice.parse().map_err(|_| error(format!("\"{}\" is not a number", shorten(slice))))?),
        };
        Ok(Spanned { offset, json })
    }

    /// Parses one level of a container.
    fn bounded<T: Deserialize<'t>>(&self, slice: &'t str) -> serde_json::Result<T> {
        serde_json::from_str(slice)
    }
}

struct Items<'t>(Vec<&'t RawValue>);
struct Entries<'t>(Vec<(Cow<'t, str>, &'t RawValue)>);

fn too_many<E: serde::de::Error>() -> E {
    E::custom(format_args!("the document holds more than {MAX_VALUES} values"))
}

impl<'de> Deserialize<'de> for Items<'de> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Seq;
        impl<'de> Visitor<'de> for Seq {
            type Value = Items<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Self::Value, A::Error> {
                let mut items = Vec::new();
                while let Some(item) = access.next_element()? {
                    if items.len() == MAX_VALUES {
                        return Err(too_many());
                    }
                    items.push(item);
                }
                Ok(Items(items))
            }
        }
        deserializer.deserialize_seq(Seq)
    }
}

/// A key, borrowed from the text where it holds no escapes.
struct Key<'t>(Cow<'t, str>);

impl<'de> Deserialize<'de> for Key<'de> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl<'de> Visitor<'de> for Text {
            type Value = Key<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a key")
            }
            fn visit_borrowed_str<E>(self, text: &'de str) -> Result<Self::Value, E> {
                Ok(Key(Cow::Borrowed(text)))
            }
            fn visit_str<E>(self, text: &str) -> Result<Self::Value, E> {
                Ok(Key(Cow::Owned(text.into())))
            }
        }
        deserializer.deserialize_str(Text)
    }
}

impl<'de> Deserialize<'de> for Entries<'de> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Map;
        impl<'de> Visitor<'de> for Map {
            type Value = Entries<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some((key, value)) = access.next_entry::<Key<'de>, &'de RawValue>()? {
                    if entries.len() == MAX_VALUES {
                        return Err(too_many());
                    }
                    entries.push((key.0, value));
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Map)
    }
}

/// The byte offset of a line and column (bytes, both from 1) as `serde_json` counts them.
fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// `serde_json` ends its messages with the place; the diagnostic states it already.
fn strip_place(message: &str) -> String {
    message.split(" at line ").next().unwrap_or(message).into()
}

/// Line and column (in characters, both from 1) of a byte offset.
pub(crate) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1);
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    // Count the bytes that start a character; the offset may lie within one.
    let column = before[line_start..].iter().filter(|&&b| b & 0xC0 != 0x80).count() + 1;
    (line, column)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(parse(&deep).expect_err("deep").message.contains("nested"));
        let error = parse("{\"a\": 1,\n \"b\": }").expect_err("syntax");
        assert_eq!(line_and_column("{\"a\": 1,\n \"b\": }", error.offset).0, 2);
        assert!(parse("NaN").is_err());
        assert!(parse("").is_err());
    }
}
