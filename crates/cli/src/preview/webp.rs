//! Animations: encoding, and their mark, XMP metadata that name the generator.

use crate::failure::{FAILED, Failure};
use std::path::Path;
use trochoid::{GENERATOR, VERSION};
use webp_animation::{ColorMode, Encoder, EncoderOptions, EncodingConfig};

/// Flag in the extended header for XMP metadata.
const XMP: u8 = 1 << 2;
/// Length of the file header: `RIFF`, the size, `WEBP`.
const HEADER: usize = 12;
/// Length of the extended header: `VP8X`, its size, flags, and the size of the picture.
const EXTENDED: usize = 18;

/// Returns an animation that loops forever. `times` are when each frame begins and the last one ends, in milliseconds; `next`
/// returns the interleaved bytes of a frame.
///
/// # Errors
/// A frame cannot be made or encoded.
pub(super) fn encoded(
    out: &Path,
    size: [u32; 2],
    quality: u8,
    times: &[i32],
    next: &mut dyn FnMut(usize) -> Result<Vec<u8>, Failure>,
) -> Result<Vec<u8>, Failure> {
    let cannot = |error: webp_animation::Error| Failure::new(FAILED, format!("{}: {error}", out.display()));
    let encoding = Some(EncodingConfig::new_lossy(f32::from(quality)));
    // Every frame is a keyframe: between frames that store only changes, slow drift stays below the threshold and appears
    // frozen.
    let options =
        EncoderOptions { encoding_config: encoding, color_mode: ColorMode::Rgb, kmax: 1, ..Default::default() };
    let mut encoder = Encoder::new_with_options((size[0], size[1]), options).map_err(cannot)?;
    let [begins @ .., end] = times else { return Err(Failure::new(FAILED, "an animation without frames")) };
    for (index, time) in begins.iter().enumerate() {
        encoder.add_frame(&next(index)?, *time).map_err(cannot)?;
    }
    let file = encoder.finalize(*end).map_err(cannot)?;
    Ok(marked(&file, size))
}

/// Returns a WebP file of this size in pixels with XMP metadata that name Trochoid as its generator.
fn marked(file: &[u8], size: [u32; 2]) -> Vec<u8> {
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
