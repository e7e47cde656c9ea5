//! List of recently opened documents.

use std::path::{Path, PathBuf};

/// Maximum number of documents in the list.
const MOST: usize = 12;

/// Maximum size of the stored list, in bytes; paths are short.
const MOST_BYTES: u64 = 1 << 20;

fn list(data: &Path) -> PathBuf {
    data.join("recent.json")
}

/// Returns the recently opened documents, newest first. Some may be gone.
pub(crate) fn read(data: &Path) -> Vec<PathBuf> {
    let text = trochoid::io::read_text(list(data), MOST_BYTES).unwrap_or_default();
    let mut files: Vec<PathBuf> = serde_json::from_str(&text).unwrap_or_default();
    files.truncate(MOST);
    files
}

/// Moves a document to the front of the list.
pub(crate) fn add(data: &Path, file: &Path) -> Vec<PathBuf> {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.into());
    let mut files = read(data);
    files.retain(|known| *known != file);
    files.insert(0, file);
    files.truncate(MOST);
    write(data, &files);
    files
}

/// Removes a document from the list.
pub(crate) fn remove(data: &Path, file: &Path) -> Vec<PathBuf> {
    let mut files = read(data);
    files.retain(|known| known != file);
    write(data, &files);
    files
}

fn write(data: &Path, files: &[PathBuf]) {
    if let Ok(text) = serde_json::to_string_pretty(files) {
        // Failing to store the list must not interrupt the user.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
}
