use std::path::Path;

use trochoid_image::{MAX_PIXELS, Window};

use crate::Error;

/// Limits on the pictures that are read, which are checked against a file's header before anything is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of pixels in a data window or a display window.
    pub pixels: u64,
    /// Maximum bytes of decoded samples: the size of the [`Picture`](crate::Picture), and the memory for one step of
    /// decoding.
    pub bytes: u64,
}

impl Default for Limits {
    /// Returns limits of 2³¹ pixels and 4 GiB.
    fn default() -> Self {
        Self { pixels: MAX_PIXELS, bytes: 4 << 30 }
    }
}

impl Limits {
    /// Refuses a window with too many pixels.
    pub(crate) fn check_window(&self, path: &Path, place: &str, window: Window) -> Result<(), Error> {
        self.check(path, place, "pixels", window.area() as u64, self.pixels)
    }

    /// Refuses `channels` f32 planes over `window` if they need too many bytes.
    pub(crate) fn check_planes(&self, path: &Path, place: &str, window: Window, channels: usize) -> Result<(), Error> {
        let samples = (window.area() as u64).saturating_mul(channels as u64);
        self.check_bytes(path, place, samples.saturating_mul(4))
    }

    /// Refuses a step of decoding that needs too many bytes.
    pub(crate) fn check_bytes(&self, path: &Path, place: &str, bytes: u64) -> Result<(), Error> {
        self.check(path, place, "bytes of decoded samples", bytes, self.bytes)
    }

    fn check(&self, path: &Path, place: &str, what: &'static str, found: u64, limit: u64) -> Result<(), Error> {
        if found <= limit {
            return Ok(());
        }
        Err(Error::TooLarge { path: path.into(), place: place.into(), what, found, limit })
    }
}

/// Reserves memory for `count` samples, so that a lack of memory is an error and not an abort.
pub(crate) fn reserve<T>(path: &Path, place: &str, count: usize) -> Result<Vec<T>, Error> {
    let mut samples = Vec::new();
    trochoid_memory::fallible(|| samples.try_reserve_exact(count)).map_err(|_| Error::OutOfMemory {
        path: path.into(),
        place: place.into(),
        bytes: (count as u64).saturating_mul(size_of::<T>() as u64),
    })?;
    Ok(samples)
}

/// Returns `count` zeros, which use physical memory only once they are written; a lack of memory is an error, as far as
/// the system reports it.
pub(crate) fn zeroed<T: Clone + Default>(path: &Path, place: &str, count: usize) -> Result<Vec<T>, Error> {
    // Only `vec!` takes untouched pages of zeros from the system, but it aborts on failure: so memory is requested
    // before.
    drop(reserve::<T>(path, place, count)?);
    Ok(vec![T::default(); count])
}

/// Grows a reused buffer to at least this length, without keeping its contents; the error has the number of bytes that
/// are not available.
pub(crate) fn grow<T: Clone + Default>(buffer: &mut Vec<T>, count: usize) -> Result<(), u64> {
    if buffer.len() < count {
        *buffer = Vec::new();
        *buffer = zeroed(Path::new(""), "", count).map_err(|_| (count as u64).saturating_mul(size_of::<T>() as u64))?;
    }
    Ok(())
}
