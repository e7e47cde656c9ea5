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

/// The key that tells of what kind a picture is, where it is none of an output.
const KIND: &str = "trochoid:kind";

/// Keys of picture files' metadata begin so.
pub(crate) const KEY: &str = "trochoid:";

/// What the text of our JSON files says of itself at the top.
#[derive(Deserialize)]
struct Marked {
    /// The version of what wrote it; of a document, which people write, a number.
    trochoid: Option<Version>,
    trochoid_plan: Option<IgnoredAny>,
    /// Of certificates alone.
    digest: Option<IgnoredAny>,
    /// Of reports of runs alone.
    status: Option<IgnoredAny>,
    /// Of reports of measurements alone.
    rungs: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Version {
    Text(#[expect(dead_code, reason = "that there is one is all")] String),
    Other(IgnoredAny),
}

/// The files that Trochoid writes, as they are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A picture as EXR.
    Exr,
    /// A picture as PNG.
    Png,
    /// A picture made small, as PNG.
    Preview,
    /// How far a picture may lie from the references, as EXR.
    Error,
    /// A map of stability, as PNG.
    Map,
    /// An animation.
    WebP,
    /// A picture of a graph.
    Svg,
    /// A page.
    Page,
    /// A table.
    Table,
    /// A plan.
    Plan,
    /// A certificate.
    Certificate,
    /// A report of a run, or of measurements.
    Report,
}

impl Form {
    /// How metadata tell of pictures that are none of an output.
    fn kind(self) -> Option<&'static str> {
        match self {
            Self::Preview => Some("preview"),
            Self::Error => Some("error"),
            Self::Map => Some("map"),
            _ => None,
        }
    }

    /// Of a picture, by its name's ending.
    pub fn of_picture(path: &Path) -> Self {
        let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
        if is_png { Self::Png } else { Self::Exr }
    }
}

/// Whether Trochoid wrote a file, and in this form, by a mark in what it holds; an empty file counts as well: there is
/// nothing to lose.
///
/// EXR and PNG have metadata `trochoid:…`, which tell also where the rest is cut off; reports, certificates and plans their own keys; pages, pictures of graphs and
/// animations name what generated them; a table has our header. Anything else is somebody else's, documents included.
pub fn is_ours(path: &Path, form: Form) -> bool {
    open_file(path).is_ok_and(|found| found.length == 0 || form_of(path, found).is_ok_and(|found| found == Some(form)))
}

/// The form in which Trochoid wrote a file; `None` for others.
fn form_of(path: &Path, found: OpenFile) -> std::io::Result<Option<Form>> {
    let OpenFile { mut file, length } = found;
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
            b'R' => says(&tail, "<xmp:CreatorTool>").then_some(Form::WebP),
            _ if says(&head, "<meta name=\"generator\" content=\"") => Some(Form::Page),
            _ => says(&tail, "<!-- ").then_some(Form::Svg),
        });
    }
    if head.starts_with(b"{") {
        file.seek(SeekFrom::Start(0))?;
        let marked: Option<Marked> = serde_json::from_reader(BufReader::new(file)).ok();
        return Ok(marked.and_then(|marked| match marked {
            Marked { trochoid_plan: Some(_), .. } => Some(Form::Plan),
            Marked { trochoid: Some(Version::Text(_)), digest: Some(_), .. } => Some(Form::Certificate),
            Marked { trochoid: Some(Version::Text(_)), status: Some(_), .. }
            | Marked { trochoid: Some(Version::Text(_)), rungs: Some(_), .. } => Some(Form::Report),
            _ => None,
        }));
    }
    if head.starts_with(TABLE.as_bytes()) {
        return Ok(Some(Form::Table));
    }
    let metadata = trochoid_io::readable_metadata(path);
    if !metadata.iter().any(|(key, _)| key.starts_with(KEY)) {
        return Ok(None);
    }
    let kind = metadata.iter().find(|(key, _)| key == KIND).map(|(_, kind)| kind.as_str());
    let other = [Form::Preview, Form::Error, Form::Map].into_iter().find(|form| kind.is_some() && form.kind() == kind);
    Ok(Some(other.unwrap_or(if head.starts_with(b"\x89PNG") { Form::Png } else { Form::Exr })))
}

/// The metadata of a picture, with the mark where they lack it.
pub(crate) fn with_mark(metadata: &[(String, String)]) -> Vec<(String, String)> {
    let mark = (!metadata.iter().any(|(key, _)| key.starts_with(KEY))).then(mark);
    metadata.iter().cloned().chain(mark).collect()
}

/// The same of a form.
pub(crate) fn with_marks(metadata: &[(String, String)], form: Form) -> Vec<(String, String)> {
    let kind = marks(form).into_iter().filter(|(key, _)| key == KIND);
    // First, so that it is there as long as any mark is, wherever the file is cut off.
    kind.chain(with_mark(metadata)).collect()
}

/// The metadata that every picture has at least.
pub fn mark() -> (String, String) {
    (format!("{KEY}version"), crate::VERSION.into())
}

/// The metadata that a picture of a form has at least.
pub fn marks(form: Form) -> Vec<(String, String)> {
    let kind = form.kind().map(|kind| (KIND.into(), kind.into()));
    [mark()].into_iter().chain(kind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_io::{ExrChannel, ExrImage, PngImage};

    const FORMS: [Form; 12] = [
        Form::Exr,
        Form::Png,
        Form::Preview,
        Form::Error,
        Form::Map,
        Form::WebP,
        Form::Svg,
        Form::Page,
        Form::Table,
        Form::Plan,
        Form::Certificate,
        Form::Report,
    ];

    #[test]
    fn our_files_are_told_from_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        let forms = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            FORMS.into_iter().filter(|form| is_ours(&path, *form)).collect::<Vec<_>>()
        };
        let page = format!("<!DOCTYPE html>\n<meta name=\"generator\" content=\"{GENERATOR}0.1.0\">");
        let svg = format!("<svg>{}</svg>\n<!-- {GENERATOR}0.1.0 -->\n", " ".repeat(9000));
        let webp = format!("RIFF....WEBP{}<xmp:CreatorTool>{GENERATOR}0.1.0</xmp:CreatorTool>", " ".repeat(9000));
        let ours = [
            (r#"{"digest": "0", "document": {"trochoid": 1}, "trochoid": "0.1.0"}"#, Form::Certificate),
            (r#"{"status": "done", "trochoid": "0.1.0"}"#, Form::Report),
            (r#"{"trochoid_plan": 1, "set": {}}"#, Form::Plan),
            (&format!("{TABLE}is_method\r\n"), Form::Table),
            (&page, Form::Page),
            (&svg, Form::Svg),
            (&webp, Form::WebP),
        ];
        for (text, form) in ours {
            assert_eq!(forms(text.as_bytes()), [form], "{text}");
        }
        assert_eq!(forms(b""), FORMS, "there is nothing to lose");
        let others = [
            "text",
            r#"{"trochoid": 1, "nodes": {}}"#,
            r#"{"trochoid_model": 1, "patches": []}"#,
            r#"{"dependencies": {"trochoid": "0.1.0"}}"#,
            r#"{"trochoid": "0.1.0""#,
            r#"{"trochoid": "1", "nodes": {}}"#,
            "scene,output\n",
            "<svg/>",
            "<!-- about Trochoid 1 --><svg/>",
            "RIFF....WEBP",
            "RIFF",
            "\u{89}PNG\r\n\u{1a}\n",
        ];
        for text in others {
            assert_eq!(forms(text.as_bytes()), [], "{text}");
        }
        assert!(!is_ours(folder.path(), Form::Exr) && !is_ours(&folder.path().join("none"), Form::Exr));
    }

    #[test]
    fn pictures_are_ours_as_what_they_are() {
        let folder = tempfile::tempdir().expect("a folder");
        let window = trochoid_image::Window::sized(1, 1);
        let channel = || trochoid_io::Samples::contiguous(&[0.5]);
        let png = PngImage { metadata: vec![mark()], ..PngImage::new(1, 1, [channel(), channel(), channel()]) };
        let channels = vec![ExrChannel::half("Y", channel())];
        let exr = ExrImage { metadata: vec![mark()], channels, ..ExrImage::new(window) };
        // Whatever their names say.
        let paths = ["a.exr", "b.png"].map(|name| folder.path().join(name));
        trochoid_io::write_png8(&paths[0], &png).expect("written");
        trochoid_io::write_exr(&paths[1], &exr).expect("written");
        assert!(is_ours(&paths[0], Form::Png) && is_ours(&paths[1], Form::Exr));
        assert!(!paths.iter().any(|path| is_ours(path, Form::of_picture(path))));
        let small = PngImage { metadata: marks(Form::Preview), ..png };
        trochoid_io::write_png8(&paths[0], &small).expect("written");
        assert!(is_ours(&paths[0], Form::Preview) && !is_ours(&paths[0], Form::Png) && !is_ours(&paths[0], Form::Map));
    }
}
