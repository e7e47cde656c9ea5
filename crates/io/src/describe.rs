//! Recognition of files by their first bytes, for messages about files of the wrong kind.

/// Describes a file by its first bytes, such as "a GIF picture". More than 64 bytes give no better result.
///
/// ```
/// assert_eq!(trochoid_io::describe(b"GIF89a"), "a GIF picture");
/// assert_eq!(trochoid_io::describe(b"v 0 0 0\n"), "text");
/// assert_eq!(trochoid_io::describe(&[1, 2, 3]), "a file of an unknown kind, which begins with 01 02 03");
/// ```
pub fn describe(start: &[u8]) -> String {
    if start.is_empty() {
        return "an empty file".into();
    }
    if let Some((_, name)) = KNOWN.iter().find(|(known, _)| start.starts_with(known)) {
        return (*name).into();
    }
    match start {
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => return "a WebP picture".into(),
        // The two reserved words of a BMP header are 0.
        [b'B', b'M', _, _, _, _, 0, 0, 0, 0, ..] => return "a BMP picture".into(),
        [_, _, _, _, b'f', b't', b'y', b'p', rest @ ..] => {
            let picture =
                [&b"avif"[..], b"avis", b"heic", b"heix", b"mif1"].iter().any(|brand| rest.starts_with(brand));
            return if picture { "an AVIF or HEIF picture" } else { "a video" }.into();
        }
        _ => {}
    }
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        // A character that is cut off at the end is still text.
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&start[..error.valid_up_to()]).unwrap_or_default()
        }
        Err(_) => "",
    };
    let text = text.trim_start_matches('\u{feff}');
    if text.is_empty() || text.chars().any(|c| c.is_control() && !c.is_whitespace()) {
        let bytes: Vec<String> = start.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        return format!("a file of an unknown kind, which begins with {}", bytes.join(" "));
    }
    match text.trim_start().chars().next() {
        Some('{' | '[') => "JSON".into(),
        Some('<') => "XML or HTML".into(),
        _ => "text".into(),
    }
}

const KNOWN: &[(&[u8], &str)] = &[
    (&[0x76, 0x2f, 0x31, 0x01], "an EXR picture"),
    (b"\x89PNG", "a PNG picture"),
    (&[0xff, 0xd8, 0xff], "a JPEG picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"II+\0", "a BigTIFF picture"),
    (b"MM\0+", "a BigTIFF picture"),
    (b"GIF8", "a GIF picture"),
    (b"8BPS", "a Photoshop picture"),
    (b"#?RADIANCE", "a Radiance HDR picture"),
    (b"#?RGBE", "a Radiance HDR picture"),
    (b"SDPX", "a DPX picture"),
    (b"XPDS", "a DPX picture"),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
    (&[0xff, 0x0a], "a JPEG XL picture"),
    (b"DDS ", "a DDS picture"),
    (b"glTF", "a binary glTF mesh"),
    (b"Kaydara FBX", "an FBX mesh"),
    (b"ply\n", "a PLY mesh"),
    (b"solid ", "an STL mesh"),
    (b"BLENDER", "a Blender scene"),
    (b"PXR-USDC", "a USD scene"),
    (b"#usda", "a USD scene"),
    (b"%PDF", "a PDF"),
    (b"PK\x03\x04", "a ZIP archive"),
    (&[0x1f, 0x8b], "a compressed file (gzip)"),
    (&[0x1a, 0x45, 0xdf, 0xa3], "a video"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_apart_by_how_they_begin() {
        for (start, name) in [
            (&b""[..], "an empty file"),
            (b"RIFF\x10\0\0\0WEBPVP8 ", "a WebP picture"),
            (b"BM\x10\0\0\0\0\0\0\0", "a BMP picture"),
            (b"BMX is text", "text"),
            (b"\0\0\0\x1cftypavif", "an AVIF or HEIF picture"),
            (b"\0\0\0\x1cftypisom", "a video"),
            (b"\xef\xbb\xbf {\"a\": 1}", "JSON"),
            (b"<svg", "XML or HTML"),
            ("größe".as_bytes(), "text"),
            (&"größe".as_bytes()[..3], "text"),
        ] {
            assert_eq!(describe(start), name, "{start:02x?}");
        }
        // Every prefix of every kind, and random bytes, get a description.
        for byte in 0..=255u8 {
            assert!(!describe(&[byte, 0, byte, 200]).is_empty());
        }
        assert!(describe(&[0; 64]).contains("00 00 00 00 00 00 00 00"));
    }
}
