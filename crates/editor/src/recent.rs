//! List of recently opened documents, with a small picture of each that was seen.

use crate::evaluate::Screen;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Maximum number of documents in the list.
const MOST: usize = 12;

/// Maximum size of the stored list and of each picture, in bytes; paths are short.
const MOST_BYTES: u64 = 1 << 20;

fn list(data: &Path) -> PathBuf {
    data.join("recent.json")
}

/// Returns the file that has the picture of a document.
fn picture(data: &Path, file: &Path) -> PathBuf {
    // If the hash is another one some day, the picture is missing until the document is seen again.
    let mut hash = DefaultHasher::new();
    file.hash(&mut hash);
    data.join("recent").join(format!("{:016x}.png", hash.finish()))
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
    for old in files.drain(MOST.min(files.len())..) {
        let _ = std::fs::remove_file(picture(data, &old));
    }
    write(data, &files);
    files
}

/// Removes a document from the list.
pub(crate) fn remove(data: &Path, file: &Path) -> Vec<PathBuf> {
    let mut files = read(data);
    files.retain(|known| known != file);
    write(data, &files);
    let _ = std::fs::remove_file(picture(data, file));
    files
}

fn write(data: &Path, files: &[PathBuf]) {
    if let Ok(text) = serde_json::to_string_pretty(files) {
        // Failing to store the list must not interrupt the user.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
}

/// Keeps the picture of a document in the list.
pub(crate) fn keep_picture(data: &Path, file: &Path, screen: &Screen) {
    let [width, height] = screen.size.map(|side| side as u32);
    let Some(pixels) = image::RgbaImage::from_raw(width, height, screen.pixels.clone()) else { return };
    let mut png = std::io::Cursor::new(Vec::new());
    if pixels.write_to(&mut png, image::ImageFormat::Png).is_ok() {
        // As with the list, nobody is told.
        let _ = std::fs::create_dir_all(data.join("recent"));
        let _ = trochoid::write_whole(&picture(data, file), png.get_ref());
    }
}

/// Returns the picture of a document, if it was seen.
pub(crate) fn picture_of(data: &Path, file: &Path) -> Option<Screen> {
    let bytes = trochoid::io::read_bytes(picture(data, file), MOST_BYTES).ok()?;
    let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).ok()?.to_rgba8();
    Some(Screen { size: [picture.width() as usize, picture.height() as usize], pixels: picture.into_raw() })
}
