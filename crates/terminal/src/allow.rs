use std::path::PathBuf;
use trochoid::quoted_path;

/// Returns warnings about paths given to `--allow` that do not exist.
pub fn missing(allow: &[PathBuf]) -> Vec<String> {
    let missing = allow.iter().filter(|path| !path.exists());
    let texts = missing.map(|path| {
        format!(
            "warning: --allow {}: found nothing there; expected a file or folder\n  remedy: correct the path, which is \
             relative to the current folder, unless it is to be made",
            quoted_path(path)
        )
    });
    texts.collect()
}
