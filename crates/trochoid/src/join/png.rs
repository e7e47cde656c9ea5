//! PNG tiles, joined in memory.

use super::{JoinError, Tile};
use crate::OutputError;
use trochoid_engine::Monitor;
use trochoid_image::Window;
use trochoid_io::{Limits, PngImage, SampleType, Samples, Selection, Target, write_png8, write_png16};

/// Writes the picture.
pub(super) fn write(
    tiles: &[Tile],
    whole: Window,
    metadata: &[(String, String)],
    target: Target,
    monitor: &dyn Monitor,
) -> Result<(), JoinError> {
    let channels = tiles[0].channels();
    let mut samples: Vec<Vec<f32>> = vec![Vec::new(); channels.len()];
    let bytes = whole.area() as u64 * 4 * channels.len() as u64;
    for samples in &mut samples {
        samples.try_reserve_exact(whole.area()).map_err(|_| JoinError::Memory(bytes))?;
        samples.resize(whole.area(), 0.0);
    }
    let selection = Selection::channels(channels.iter().map(|(name, _)| name.as_str()));
    for (done, tile) in tiles.iter().enumerate() {
        if monitor.cancelled() {
            return Err(JoinError::Cancelled);
        }
        let picture = trochoid_io::read(&tile.path, &selection, &Limits::default())?;
        let Window { x0, y0, .. } = tile.region;
        for (samples, channel) in samples.iter_mut().zip(&picture.channels) {
            let rows = channel.plane.samples().chunks_exact(tile.region.width());
            for (row, values) in rows.enumerate() {
                let start = (y0 as usize + row) * whole.width() + x0 as usize;
                samples[start..start + values.len()].copy_from_slice(values);
            }
        }
        monitor.progress(done + 1, tiles.len() + 1);
    }
    let samples: Vec<Samples<'_>> = samples.iter().map(|samples| Samples::contiguous(samples)).collect();
    let mut image = PngImage::new(whole.width() as u32, whole.height() as u32, samples);
    image.metadata = metadata.to_vec();
    let written = match channels.first() {
        Some((_, SampleType::U16)) => write_png16(target, &image),
        _ => write_png8(target, &image),
    };
    Ok(written.map_err(OutputError::from)?)
}
