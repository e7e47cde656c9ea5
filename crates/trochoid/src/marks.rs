//! Which files are Trochoid's own, so that no other is replaced unasked.

use serde::Deserialize;
use serde::de::IgnoredAny;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use trochoid_io::{OpenFile, open_file};

/// How long a beginning and an end of a file are looked at for a mark.
const LOOKED_AT: u64 = 4096;

/// How the mark begins with which pages (`generator`), pictures of graphs (a comment) and animations (`CreatorTool`) say
/// what made them; the version follows.
pub const GENERATOR: &str = "Trochoid ";

/// The first columns of the table of a report: its header is its mark, since CSV has no comments.
pub const TABLE: &str = "scene,output,frame,settings,";

/// Keys of picture files' metadata begin so.
pub(crate) const KEY: &str = "trochoid:";

/// What the text of our JSON files says of itself at the top.
#[derive(Deserialize)]
struct Marked {
    /// The version of what wrote it; of a document, which people write, a number.
    trochoid: Option<Version>,
    trochoid_plan: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Version {
    Text(#[expect(dead_code, reason = "that there is one is all")] String),
    Other(IgnoredAny),
}

/// Whether Trochoid wrote a file, by a mark in what it holds; an empty file counts as well: there is nothing to lose.
///
/// EXR and PNG have metadata `trochoid:…`, which tell also where the rest is cut off; reports, certificates and plans their own keys; pages, pictures of graphs and
/// animations name what generated them; a table has our header. Anything else is somebody else's, documents included.
pub fn is_ours(path: &Path) -> bool {
    marked(path).unwrap_or(false)
}

fn marked(path: &Path) -> std::io::Result<bool> {
    let Ok(OpenFile { mut file, length }) = open_file(path) else { return Ok(false) };
    if length == 0 {
        return Ok(true);
    }
    let mut head = Vec::new();
    file.by_ref().take(LOOKED_AT).read_to_end(&mut head)?;
    let says = |bytes: &[u8], before: &str| {
        let mark = format!("{before}{GENERATOR}");
        bytes.windows(mark.len()).any(|window| window == mark.as_bytes())
    };
    if head.starts_with(b"RIFF") || head.starts_with(b"<") {
        file.seek(SeekFrom::Start(length.saturating_sub(LOOKED_AT)))?;
        let mut tail = Vec::new();
        file.take(LOOKED_AT).read_to_end(&mut tail)?;
        return Ok(match head[0] {
            b'R' => says(&tail, "<xmp:CreatorTool>"),
            _ => says(&head, "<meta name=\"generator\" content=\"") || says(&tail, "<!-- "),
        });
    }
    if head.starts_with(b"{") {
        file.seek(SeekFrom::Start(0))?;
        let marked: Option<Marked> = serde_json::from_reader(BufReader::new(file)).ok();
        return Ok(marked.is_some_and(|m| m.trochoid_plan.is_some() || matches!(m.trochoid, Some(Version::Text(_)))));
    }
    let metadata = trochoid_io::readable_metadata(path);
    Ok(head.starts_with(TABLE.as_bytes()) || metadata.iter().any(|(key, _)| key.starts_with(KEY)))
}

/// The metadata of a picture, with the mark where they lack it.
pub(crate) fn with_mark(metadata: &[(String, String)]) -> Vec<(String, String)> {
    let mark = (!metadata.iter().any(|(key, _)| key.starts_with(KEY))).then(mark);
    metadata.iter().cloned().chain(mark).collect()
}

/// The metadata that every picture has at least.
pub fn mark() -> (String, String) {
    (format!("{KEY}version"), crate::VERSION.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_files_are_told_from_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let is = |bytes: &[u8]| {
            let path = folder.path().join("file");
            std::fs::write(&path, bytes).expect("written");
            is_ours(&path)
        };
        let page = format!("<!DOCTYPE html>\n<meta name=\"generator\" content=\"{GENERATOR}0.1.0\">");
        let svg = format!("<svg>{}</svg>\n<!-- {GENERATOR}0.1.0 -->\n", " ".repeat(9000));
        let webp = format!("RIFF....WEBP{}<xmp:CreatorTool>{GENERATOR}0.1.0</xmp:CreatorTool>", " ".repeat(9000));
        let ours = [
            "",
            r#"{"digest": "0", "document": {"trochoid": 1}, "trochoid": "0.1.0"}"#,
            r#"{"trochoid_plan": 1, "set": {}}"#,
            &format!("{TABLE}is_method\r\n"),
            &page,
            &svg,
            &webp,
        ];
        for text in ours {
            assert!(is(text.as_bytes()), "{text}");
        }
        let others = [
            "text",
            r#"{"trochoid": 1, "nodes": {}}"#,
            r#"{"trochoid_model": 1, "patches": []}"#,
            r#"{"dependencies": {"trochoid": "0.1.0"}}"#,
            r#"{"trochoid": "0.1.0""#,
            "scene,output\n",
            "<svg/>",
            "<!-- about Trochoid 1 --><svg/>",
            "RIFF....WEBP",
            "RIFF",
            "\u{89}PNG\r\n\u{1a}\n",
        ];
        for text in others {
            assert!(!is(text.as_bytes()), "{text}");
        }
        assert!(!is_ours(folder.path()) && !is_ours(&folder.path().join("none")));
    }
}
