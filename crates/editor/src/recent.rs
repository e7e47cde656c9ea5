//! Documents opened lately.

use std::path::{Path, PathBuf};

/// How many are remembered.
const MOST: usize = 12;

/// Most bytes of the list: paths are short.
const MOST_BYTES: u64 = 1 << 20;

fn list(data: &Path) -> PathBuf {
    data.join("recent.json")
}

/// The documents opened lately that are still there, the newest first.
pub(crate) fn read(data: &Path) -> Vec<PathBuf> {
    let text = trochoid::io::read_text(list(data), MOST_BYTES).unwrap_or_default();
    let files: Vec<PathBuf> = serde_json::from_str(&text).unwrap_or_default();
    files.into_iter().filter(|file| file.exists()).take(MOST).collect()
}

/// Puts a document before all others.
pub(crate) fn add(data: &Path, file: &Path) -> Vec<PathBuf> {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.into());
    let mut files = read(data);
    files.retain(|known| *known != file);
    files.insert(0, file);
    files.truncate(MOST);
    if let Ok(text) = serde_json::to_string_pretty(&files) {
        // A list that cannot be kept is no reason to stop.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
    files
}
