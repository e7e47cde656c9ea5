//! Marks that identify files written by Trochoid, so that no other file is replaced without a request.

use serde::Deserialize;
use serde::de::IgnoredAny;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use trochoid_io::{OpenFile, open_file};

/// Number of bytes at the start and at the end of a file that are searched for a mark.
const LOOKED_AT: u64 = 4096;

/// Start of the mark of pages (in `generator`), graph drawings and shaders (in a comment) and animations (in
/// `CreatorTool`); the version follows.
pub const GENERATOR: &str = "Trochoid ";

/// First columns of the table of a report, whose header is its mark, since CSV has no comments.
pub const TABLE: &str = "scene,output,frame,settings,";

/// Metadata key for the kind of a picture that does not show an output.
const KIND: &str = "trochoid:kind";

/// Prefix of all metadata keys in picture files.
pub(crate) const KEY: &str = "trochoid:";

/// Top-level fields that identify our JSON files.
#[derive(Deserialize)]
struct MarkerFields {
    /// Version of the program that wrote the file; a number in documents, which users write.
    trochoid: Option<Version>,
    trochoid_plan: Option<IgnoredAny>,
    trochoid_palette: Option<IgnoredAny>,
    /// Present in certificates only.
    digest: Option<IgnoredAny>,
    /// Present in reports of runs only.
    status: Option<IgnoredAny>,
    /// Present in reports of measurements only.
    rungs: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Version {
    Text(#[expect(dead_code, reason = "only its presence matters")] String),
    Other(IgnoredAny),
}

/// Kind of a file that Trochoid writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Picture as EXR.
    Exr,
    /// Picture as PNG.
    Png,
    /// Picture of reduced size as PNG.
    Preview,
    /// Error bounds of a picture against the references, as EXR.
    Error,
    /// Stability map as PNG.
    Map,
    /// Contact sheet as PNG.
    Sheet,
    /// Animation as WebP.
    WebP,
    /// Movie as MP4.
    Mp4,
    /// Graph drawing as SVG.
    Svg,
    /// Page of a report as HTML.
    Page,
    /// Table of a report as CSV.
    Table,
    /// Shader for another program: GLSL, OSL, MaterialX or WGSL.
    Shader,
    /// Plan as JSON.
    Plan,
    /// Palette as JSON.
    Palette,
    /// Palette of GIMP.
    Gimp,
    /// Picture of a palette's colors as PNG.
    Swatches,
    /// Table of colors for other programs, .cube.
    Cube,
    /// Document; one that is there is never ours, but its author's.
    Document,
    /// Certificate as JSON.
    Certificate,
    /// Report of a run or of measurements as JSON.
    Report,
}

impl Form {
    /// Returns the metadata value for pictures that do not show an output.
    fn kind(self) -> Option<&'static str> {
        match self {
            Self::Preview => Some("preview"),
            Self::Error => Some("error"),
            Self::Map => Some("map"),
            Self::Sheet => Some("sheet"),
            Self::Swatches => Some("swatches"),
            _ => None,
        }
    }

    /// Returns the form of a picture by its extension.
    pub fn of_picture(path: &Path) -> Self {
        let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
        if is_png { Self::Png } else { Self::Exr }
    }
}

/// Returns whether Trochoid wrote a file in this form, judging by a mark in its contents. An empty file counts as ours,
/// because nothing can be lost.
///
/// EXR and PNG have metadata `trochoid:…`, which are found even if the rest is cut off. Reports, certificates, plans and
/// palettes have their own keys, palettes of GIMP, tables of colors and shaders a comment; pages, graph drawings and animations name
/// their generator; a table has our header. All other files, including documents, are foreign.
pub fn is_ours(path: &Path, form: Form) -> bool {
    open_file(path).is_ok_and(|found| found.length == 0 || form_of(path, found).is_ok_and(|found| found == Some(form)))
}

/// Returns the form in which Trochoid wrote a file; `None` for foreign files.
fn form_of(path: &Path, found: OpenFile) -> std::io::Result<Option<Form>> {
    let OpenFile { mut file, length } = found;
    let mut head = Vec::new();
    file.by_ref().take(LOOKED_AT).read_to_end(&mut head)?;
    let says = |bytes: &[u8], before: &str| {
        let mark = format!("{before}{GENERATOR}");
        bytes.windows(mark.len()).any(|window| window == mark.as_bytes())
    };
    let is_mp4 = head.get(4..8) == Some(b"ftyp");
    if is_mp4 || head.starts_with(b"RIFF") || head.starts_with(b"<") {
        file.seek(SeekFrom::Start(length.saturating_sub(LOOKED_AT)))?;
        let mut tail = Vec::new();
        file.take(LOOKED_AT).read_to_end(&mut tail)?;
        return Ok(match head[0] {
            _ if is_mp4 => says(&tail, "free").then_some(Form::Mp4),
            b'R' => says(&tail, "<xmp:CreatorTool>").then_some(Form::WebP),
            _ if says(&head, "<meta name=\"generator\" content=\"") => Some(Form::Page),
            _ if says(&head, "<!-- ") && head.windows(10).any(|window| window == b"<materialx") => Some(Form::Shader),
            _ => says(&tail, "<!-- ").then_some(Form::Svg),
        });
    }
    if head.starts_with(b"{") {
        file.seek(SeekFrom::Start(0))?;
        let marked: Option<MarkerFields> = serde_json::from_reader(BufReader::new(file)).ok();
        return Ok(marked.and_then(|marked| match marked {
            MarkerFields { trochoid_plan: Some(_), .. } => Some(Form::Plan),
            MarkerFields { trochoid_palette: Some(_), .. } => Some(Form::Palette),
            MarkerFields { trochoid: Some(Version::Text(_)), digest: Some(_), .. } => Some(Form::Certificate),
            MarkerFields { trochoid: Some(Version::Text(_)), status: Some(_), .. }
            | MarkerFields { trochoid: Some(Version::Text(_)), rungs: Some(_), .. } => Some(Form::Report),
            _ => None,
        }));
    }
    if head.starts_with(b"# ") && head[2..].starts_with(GENERATOR.as_bytes()) {
        return Ok(Some(Form::Cube));
    }
    if head.starts_with(b"// ") && head[3..].starts_with(GENERATOR.as_bytes()) {
        return Ok(Some(Form::Shader));
    }
    if head.starts_with(b"GIMP Palette") {
        return Ok(says(&head, "# ").then_some(Form::Gimp));
    }
    if head.starts_with(TABLE.as_bytes()) {
        return Ok(Some(Form::Table));
    }
    let metadata = trochoid_io::readable_metadata(path);
    if !metadata.iter().any(|(key, _)| key.starts_with(KEY)) {
        return Ok(None);
    }
    let kind = metadata.iter().find(|(key, _)| key == KIND).map(|(_, kind)| kind.as_str());
    let other = [Form::Preview, Form::Error, Form::Map, Form::Sheet, Form::Swatches]
        .into_iter()
        .find(|form| kind.is_some() && form.kind() == kind);
    Ok(Some(other.unwrap_or(if head.starts_with(b"\x89PNG") { Form::Png } else { Form::Exr })))
}

/// Returns the metadata of a picture, with the mark added if missing.
pub(crate) fn with_mark(metadata: &[(String, String)]) -> Vec<(String, String)> {
    let mark = (!metadata.iter().any(|(key, _)| key.starts_with(KEY))).then(mark);
    metadata.iter().cloned().chain(mark).collect()
}

/// Returns the metadata of a picture of this form, with its marks added.
pub(crate) fn with_marks(metadata: &[(String, String)], form: Form) -> Vec<(String, String)> {
    let kind = marks(form).into_iter().filter(|(key, _)| key == KIND);
    // The kind comes first, so that a truncated file with a mark has it, too.
    kind.chain(with_mark(metadata)).collect()
}

/// Returns the metadata entry that every picture has.
pub fn mark() -> (String, String) {
    (format!("{KEY}version"), crate::VERSION.into())
}

/// Returns the metadata entries that every picture of this form has.
pub fn marks(form: Form) -> Vec<(String, String)> {
    let kind = form.kind().map(|kind| (KIND.into(), kind.into()));
    [mark()].into_iter().chain(kind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_io::{ExrChannel, ExrImage, PngImage};

    const FORMS: [Form; 17] = [
        Form::Exr,
        Form::Png,
        Form::Preview,
        Form::Error,
        Form::Map,
        Form::Sheet,
        Form::WebP,
        Form::Mp4,
        Form::Svg,
        Form::Page,
        Form::Table,
        Form::Shader,
        Form::Plan,
        Form::Certificate,
        Form::Report,
        Form::Cube,
        Form::Document,
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
        let mp4 = format!("....ftypisom{}....free{GENERATOR}0.1.0", " ".repeat(9000));
        let ours = [
            (r#"{"digest": "0", "document": {"trochoid": 1}, "trochoid": "0.1.0"}"#, Form::Certificate),
            (r#"{"status": "done", "trochoid": "0.1.0"}"#, Form::Report),
            (r#"{"trochoid_plan": 1, "set": {}}"#, Form::Plan),
            (&format!("{TABLE}is_method\r\n"), Form::Table),
            (&format!("# {GENERATOR}0.1.0\nTITLE \"a\"\n"), Form::Cube),
            (&format!("// {GENERATOR}0.1.0\nfloat a() {{ return 0.0; }}\n"), Form::Shader),
            (&format!("<?xml version=\"1.0\"?>\n<!-- {GENERATOR}0.1.0 -->\n<materialx/>"), Form::Shader),
            (&page, Form::Page),
            (&svg, Form::Svg),
            (&webp, Form::WebP),
            (&mp4, Form::Mp4),
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
            "<materialx/>",
            "// about Trochoid 1",
            "<!-- about Trochoid 1 --><svg/>",
            "RIFF....WEBP",
            "....ftypisom....free",
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
        // The names of the files do not matter.
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
