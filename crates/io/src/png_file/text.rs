//! Text chunks of PNG: tEXt for Latin-1 keywords with ASCII text, iTXt for all other text.

use std::path::Path;

use crate::Error;
use crate::source::SourceFile;

/// Size of the signature and the first chunk, in bytes; other chunks may follow.
pub(super) const HEADER: usize = 8 + 12 + 13;
/// Maximum number of bytes of text that are read.
const MAX_TEXT: u64 = 64 << 20;

/// Writes an sRGB mark, and one text chunk for each pair.
pub(super) fn chunks(path: &Path, metadata: &[(String, String)]) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    // Rendering intent: perceptual.
    push(&mut bytes, *b"sRGB", &[0]);
    for (key, value) in metadata {
        let latin: Option<Vec<u8>> = key.chars().map(|c| u8::try_from(c).ok().filter(|_| !c.is_control())).collect();
        let Some(mut chunk) = latin.filter(|latin| (1..=79).contains(&latin.len()) && key.trim() == key) else {
            let found = format!("the metadata keyword \"{}\"", crate::error::printable(key));
            return Err(Error::unwritable(path, found, "PNG takes 1 to 79 printable Latin-1 characters"));
        };
        if value.contains('\0') || value.len() > i32::MAX as usize - 256 {
            let found = format!("the metadata text of \"{key}\"");
            return Err(Error::unwritable(path, found, "PNG takes less than 2 GiB without zero characters"));
        }
        if value.is_ascii() {
            chunk.push(0);
            chunk.extend(value.as_bytes());
            push(&mut bytes, *b"tEXt", &chunk);
        } else {
            // Not compressed, method 0, no language, no translated keyword.
            chunk.extend([0, 0, 0, 0, 0]);
            chunk.extend(value.as_bytes());
            push(&mut bytes, *b"iTXt", &chunk);
        }
    }
    Ok(bytes)
}

fn push(bytes: &mut Vec<u8>, kind: [u8; 4], data: &[u8]) {
    bytes.extend((data.len() as u32).to_be_bytes());
    bytes.extend(kind);
    bytes.extend(data);
    bytes.extend(crc(&[&kind, data]).to_be_bytes());
}

/// Reads the keywords and texts of all uncompressed text chunks, in order. Compressed ones, which this crate never
/// writes, are skipped.
pub(crate) fn read_text(source: &mut SourceFile) -> Result<Vec<(String, String)>, Error> {
    let mut found = Vec::new();
    walk(source, &mut found)?;
    Ok(found)
}

/// Reads keywords and texts as far as that is possible.
pub(crate) fn readable_text(source: &mut SourceFile) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let _ = walk(source, &mut found);
    found
}

/// Checks that the file ends with its end mark.
pub(crate) fn check_whole(source: &mut SourceFile) -> Result<(), Error> {
    let expected = "the end mark IEND, and nothing after it";
    match walk(source, &mut Vec::new())? {
        Some(end) if end == source.length => Ok(()),
        Some(end) => {
            let found = format!("{} bytes after the end", source.length - end);
            Err(Error::invalid(&source.path, format!("byte {end}"), found, expected))
        }
        None => Err(Error::invalid(&source.path, "last bytes", "no end mark", expected)),
    }
}

/// Collects texts chunk by chunk; returns the position after the end mark. Some writers omit the mark, and the decoder
/// of the pixels judges whether anything is missing.
fn walk(source: &mut SourceFile, found: &mut Vec<(String, String)>) -> Result<Option<u64>, Error> {
    let mut position = 8;
    let mut total = 0;
    source.seek(position)?;
    while position < source.length {
        let place = format!("chunk at byte {position}");
        let head = source.bytes(8, &place)?;
        let (length, kind) = head.split_at(4);
        let length = length.iter().fold(0_u64, |sum, &byte| sum << 8 | u64::from(byte));
        let rest = source.length - position;
        if length + 12 > rest {
            let claim = format!("a chunk of {} bytes", length + 12);
            return Err(Error::invalid(&source.path, place, claim, format!("at most the {rest} bytes that follow")));
        }
        if matches!(kind, b"tEXt" | b"iTXt") {
            total += length;
            if total > MAX_TEXT {
                let (path, what) = (source.path.clone(), "bytes of text");
                return Err(Error::TooLarge { path, place, what, found: total, limit: MAX_TEXT });
            }
            let data = source.bytes(length + 4, &place)?;
            let (data, sum) = data.split_at(length as usize);
            if sum != crc(&[kind, data]).to_be_bytes() {
                return Err(Error::invalid(
                    &source.path,
                    place,
                    "text that does not fit its checksum",
                    "a whole chunk",
                ));
            }
            found.extend(parse(kind, data));
        } else {
            // Seeking stays within the buffer for small chunks, of which a hostile file can have millions.
            let skip = source.reader.seek_relative(length as i64 + 4);
            skip.map_err(Error::io(&source.path, "read the file"))?;
        }
        position += length + 12;
        if kind == b"IEND" {
            return Ok(Some(position));
        }
    }
    Ok(None)
}

fn parse(kind: &[u8], data: &[u8]) -> Option<(String, String)> {
    let latin = |bytes: &[u8]| bytes.iter().map(|&byte| char::from(byte)).collect::<String>();
    let end = data.iter().position(|&byte| byte == 0)?;
    let (key, rest) = (latin(&data[..end]), &data[end + 1..]);
    if kind == b"tEXt" {
        return Some((key, latin(rest)));
    }
    let [0, _, rest @ ..] = rest else { return None };
    let mut fields = rest.splitn(3, |&byte| byte == 0);
    let (_language, _translated, text) = (fields.next()?, fields.next()?, fields.next()?);
    Some((key, String::from_utf8_lossy(text).into_owned()))
}

/// Returns the CRC-32 of bytes by annex D of the PNG specification.
fn crc(pieces: &[&[u8]]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut n = 0;
        while n < 256 {
            let mut c = n as u32;
            let mut bit = 0;
            while bit < 8 {
                c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
                bit += 1;
            }
            table[n] = c;
            n += 1;
        }
        table
    };
    let step = |c: u32, &byte: &u8| TABLE[((c ^ u32::from(byte)) & 0xff) as usize] ^ (c >> 8);
    !pieces.iter().flat_map(|piece| piece.iter()).fold(!0, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_standard_one() {
        assert_eq!(crc(&[b"1234", b"56789"]), 0xcbf4_3926);
        assert_eq!(crc(&[b"IEND"]), 0xae42_6082);
    }

    #[test]
    fn compressed_text_is_skipped() {
        assert_eq!(parse(b"iTXt", b"key\0\x01\0\0\0zzz"), None);
        assert_eq!(parse(b"tEXt", b"no end"), None);
        assert_eq!(parse(b"iTXt", b"key\0\0\0de\0Wort\0a\0b"), Some(("key".into(), "a\0b".into())));
    }
}
