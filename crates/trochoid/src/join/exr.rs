//! EXR tiles, joined band by band on all threads.

use super::{JoinError, Tile};
use crate::OutputError;
use crate::stream::RESERVED;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_engine::Monitor;
use trochoid_image::Window;
use trochoid_io::{BandBuffer, EncodeScratch, ExrHeader, ExrReader, ExrWriter, Limits, Selection, Target};

/// Reusable memory of a thread.
#[derive(Default)]
struct Scratch {
    encoding: EncodeScratch,
    band: BandBuffer,
    /// Samples of the picture's band, by channel.
    channels: Vec<Vec<f32>>,
}

/// Writes the picture.
pub(super) fn write(
    tiles: &[Tile],
    whole: Window,
    metadata: &[(String, String)],
    target: Target,
    monitor: &dyn Monitor,
) -> Result<(), JoinError> {
    let reserved = tiles[0].entry(RESERVED).and_then(|bytes| bytes.parse().ok());
    let reserved =
        reserved.ok_or_else(|| tiles[0].fault("a picture that is no tile", "one of `trochoid render --region`"))?;
    let channels = tiles[0].channels();
    let selection = Selection::channels(channels.iter().map(|(name, _)| name.as_str()));
    let open = |tile: &Tile| ExrReader::open(&tile.path, &selection, &Limits::default());
    let readers = tiles.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let chromaticities = tiles[0].part.chromaticities;
    let header = ExrHeader { channels, late_metadata: reserved, chromaticities, ..ExrHeader::new(whole) };
    let unwritten = |error: trochoid_io::Error| JoinError::from(OutputError::from(error));
    let writer = ExrWriter::create(target, &header).map_err(unwritten)?;
    let done = AtomicUsize::new(0);
    writer.each_band(|band, scratch: &mut Scratch| {
        if monitor.cancelled() {
            return Err(JoinError::Cancelled);
        }
        let window = writer.band_window(band);
        scratch.channels.resize_with(header.channels.len(), Vec::new);
        scratch.channels.iter_mut().for_each(|samples| samples.resize(window.area(), 0.0));
        for reader in &readers {
            copy(reader, window, &mut scratch.band, &mut scratch.channels)?;
        }
        let rows: Vec<&[f32]> = scratch.channels.iter().map(Vec::as_slice).collect();
        let encoded = writer.encode(band, &rows, &mut scratch.encoding).map_err(unwritten)?;
        writer.push(encoded).map_err(unwritten)?;
        monitor.progress(done.fetch_add(1, Ordering::Relaxed) + 1, writer.bands());
        Ok(())
    })?;
    writer.finish(metadata).map_err(unwritten)
}

/// Copies the rows of a tile that lie in a band of the picture.
fn copy(
    reader: &ExrReader,
    window: Window,
    buffer: &mut BandBuffer,
    channels: &mut [Vec<f32>],
) -> Result<(), trochoid_io::Error> {
    let part = reader.info().data.intersect(window);
    let (Some(first), Some(last)) = (reader.band_at(part.y0), reader.band_at(part.y1 - 1)) else { return Ok(()) };
    for band in first..=last {
        reader.decode(band, buffer)?;
        let rows = buffer.window().intersect(part);
        for y in rows.y0..rows.y1 {
            let start = (y - window.y0) as usize * window.width() + (part.x0 - window.x0) as usize;
            for (channel, samples) in channels.iter_mut().enumerate() {
                buffer.row_f32(channel, y, part.x0, &mut samples[start..start + part.width()]);
            }
        }
    }
    Ok(())
}
