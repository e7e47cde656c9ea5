//! The mark of an animation: XMP metadata that name its generator.

use trochoid::{GENERATOR, VERSION};

/// Flag in the extended header for XMP metadata.
const XMP: u8 = 1 << 2;
/// Length of the file header: `RIFF`, the size, `WEBP`.
const HEADER: usize = 12;
/// Length of the extended header: `VP8X`, its size, flags, and the size of the picture.
const EXTENDED: usize = 18;

/// Returns a WebP file of this size in pixels with XMP metadata that name Trochoid as its generator.
pub(crate) fn marked(file: &[u8], size: [u32; 2]) -> Vec<u8> {
    let (head, mut chunks) = file.split_at(HEADER.min(file.len()));
    // An animation has an extended header, and it comes first: `VP8X`, its size, its flags. A single frame has none.
    let mut extended = [b"VP8X\x0a\0\0\0\0\0\0\0".as_slice()].concat();
    if chunks.starts_with(b"VP8X") && chunks.len() >= EXTENDED {
        extended = chunks[..EXTENDED].to_vec();
        chunks = &chunks[EXTENDED..];
    } else {
        size.iter().for_each(|side| extended.extend(&(side - 1).to_le_bytes()[..3]));
    }
    extended[8] |= XMP;
    let mut marked = [head, &extended, chunks].concat();
    let text = format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"><xmp:CreatorTool>{GENERATOR}{VERSION}\
         </xmp:CreatorTool></rdf:Description></rdf:RDF></x:xmpmeta>"
    );
    marked.extend(b"XMP ");
    marked.extend((text.len() as u32).to_le_bytes());
    marked.extend(text.as_bytes());
    // Chunks have even lengths.
    marked.extend(vec![0; text.len() % 2]);
    let size = (marked.len() - 8) as u32;
    marked[4..8].copy_from_slice(&size.to_le_bytes());
    marked
}
