//! Files as sources of bytes, read with the place in every error.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::open::{OpenFile, open_file};
use crate::{Error, FileKind, describe};

/// File with a name for messages and the length that claims are checked against.
pub(crate) struct SourceFile {
    pub(crate) path: PathBuf,
    pub(crate) length: u64,
    pub(crate) reader: BufReader<File>,
}

/// Opens a regular file.
pub(crate) fn open(path: &Path) -> Result<SourceFile, Error> {
    let OpenFile { file, length } = open_file(path)?;
    Ok(SourceFile { path: path.into(), length, reader: BufReader::new(file) })
}

/// Bytes that many threads can read at once, each at its own position.
pub(crate) trait ReadAt: Send + Sync {
    /// Fills `bytes` from `position` on.
    fn read_at(&self, bytes: &mut [u8], position: u64) -> std::io::Result<()>;
}

#[cfg(unix)]
impl ReadAt for File {
    fn read_at(&self, bytes: &mut [u8], position: u64) -> std::io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, bytes, position)
    }
}

/// Fallback for systems that cannot read files at a position: one thread reads at a time.
#[cfg(not(unix))]
impl ReadAt for std::sync::Mutex<File> {
    fn read_at(&self, bytes: &mut [u8], position: u64) -> std::io::Result<()> {
        let mut file = self.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.seek(SeekFrom::Start(position))?;
        file.read_exact(bytes)
    }
}

impl SourceFile {
    /// Returns the same bytes without a position, for threads to share.
    pub(crate) fn share(self) -> Arc<dyn ReadAt> {
        #[cfg(unix)]
        return Arc::new(self.reader.into_inner());
        #[cfg(not(unix))]
        return Arc::new(std::sync::Mutex::new(self.reader.into_inner()));
    }

    /// Returns the kind of image file by the first bytes, whatever the name of the file.
    pub(crate) fn kind(&mut self) -> Result<FileKind, Error> {
        let mut magic = Vec::new();
        self.seek(0)?;
        let read = (&mut self.reader).take(64).read_to_end(&mut magic);
        read.map_err(Error::io(&self.path, "read the file"))?;
        self.seek(0)?;
        FileKind::of(&magic).ok_or_else(|| Error::NoPicture { path: self.path.clone(), found: describe(&magic) })
    }

    pub(crate) fn seek(&mut self, position: u64) -> Result<(), Error> {
        self.reader.seek(SeekFrom::Start(position)).map_err(Error::io(&self.path, "read the file"))?;
        Ok(())
    }

    /// Reads exactly `count` bytes; memory grows with the bytes that exist, not with `count`.
    pub(crate) fn bytes(&mut self, count: u64, place: &str) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let read = (&mut self.reader).take(count).read_to_end(&mut bytes);
        read.map_err(Error::io(&self.path, "read the file"))?;
        if (bytes.len() as u64) < count {
            let found = format!("the end of the file after {} bytes", bytes.len());
            return Err(Error::invalid(&self.path, place, found, format!("{count} bytes")));
        }
        Ok(bytes)
    }
}
