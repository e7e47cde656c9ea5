use std::path::Path;

use trochoid_image::{MAX_PIXELS, Window};

use crate::Error;

/// The largest picture that is read, checked against a file's header before anything is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Pixels of a data window or a display window.
    pub pixels: u64,
    /// Bytes of decoded samples: what [`Picture`](crate::Picture) will hold, and what one step of decoding needs.
    pub bytes: u64,
}

impl Default for Limits {
    /// 2³¹ pixels and 4 GiB.
    fn default() -> Self {
        Self { pixels: MAX_PIXELS, bytes: 4 << 30 }
    }
}

impl Limits {
    /// Refuses a window with too many pixels.
    pub(crate) fn check_window(&self, path: &Path, place: &str, window: Window) -> Result<(), Error> {
        self.check(path, place, "pixels", window.area() as u64, self.pixels)
    }

    /// Refuses `channels` f32 planes over `window` if they hold too many bytes.
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

/// Reserves room for `count` samples, so that too little memory is an error and not an abort.
pub(crate) fn reserve<T>(path: &Path, place: &str, count: usize) -> Result<Vec<T>, Error> {
    let mut samples = Vec::new();
    trochoid_memory::fallible(|| samples.try_reserve_exact(count)).map_err(|_| Error::OutOfMemory {
        path: path.into(),
        place: place.into(),
        bytes: (count as u64).saturating_mul(size_of::<T>() as u64),
    })?;
    Ok(samples)
}

/// `count` zeros, which take memory only where they are written; too little of it is an error, as far as the system tells.
pub(crate) fn zeroed<T: Clone + Default>(path: &Path, place: &str, count: usize) -> Result<Vec<T>, Error> {
    // Pages of zeros come from the system untouched only through `vec!`, which would abort: so it is asked before.
    drop(reserve::<T>(path, place, count)?);
    Ok(vec![T::default(); count])
}

/// Makes a reused buffer at least this long, without its contents; else gives the bytes that are lacking.
pub(crate) fn grow<T: Clone + Default>(buffer: &mut Vec<T>, count: usize) -> Result<(), u64> {
    if buffer.len() < count {
        *buffer = Vec::new();
        *buffer = zeroed(Path::new(""), "", count).map_err(|_| (count as u64).saturating_mul(size_of::<T>() as u64))?;
    }
    Ok(())
}
