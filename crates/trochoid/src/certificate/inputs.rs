//! Hashes of files, and paths relative to a certificate's folder.

use super::{CertificateError, InputHash};
use std::path::{Component, Path, PathBuf};
use trochoid_graph::CheckedGraph;

/// Returns the files that these outputs depend on at a frame.
pub(super) fn files(graph: &CheckedGraph, outputs: &[usize], frame: i64) -> Vec<PathBuf> {
    let roots = outputs.iter().map(|index| graph.outputs()[*index].node);
    graph.files(&graph.dependencies(roots, frame), &graph.frame_context(frame, u64::MAX))
}

/// Hashes a file; its path is relative to a folder.
pub(super) fn hashed(path: &Path, folder: &Path) -> Result<InputHash, CertificateError> {
    let mut hasher = blake3::Hasher::new();
    let file = trochoid_io::open_file(path).map_err(CertificateError::Read)?;
    let cannot = |source| trochoid_io::Error::Io { path: path.into(), action: "be read", source };
    let bytes =
        std::io::copy(&mut file.reader(), &mut hasher).map_err(|error| CertificateError::Read(cannot(error)))?;
    Ok(InputHash { bytes, hash: hasher.finalize().to_hex().to_string(), path: seen_from(folder, path) })
}

/// Returns the folder of a file: the current one for a bare name.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).into()
}

/// Returns a path without redundant `.` components.
pub(super) fn plain(path: &Path) -> PathBuf {
    path.components().filter(|part| *part != Component::CurDir).collect()
}

/// Returns a path relative to a folder, with `/` as separator; the absolute path if they have no common root.
pub(super) fn seen_from(folder: &Path, path: &Path) -> String {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    // Links are resolved, because `..` after a link leads elsewhere.
    let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
    let (Ok(from), Ok(to)) = (absolute(folder), absolute(path)) else { return path.display().to_string() };
    let same = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let is_root = |part: &Component<'_>| matches!(part, Component::Prefix(_) | Component::RootDir);
    if !from.components().take(same).any(|part| is_root(&part)) {
        return to.display().to_string();
    }
    let up = from.components().skip(same).map(|_| "..".to_string());
    let down = to.components().skip(same).map(|part| part.as_os_str().to_string_lossy().into_owned());
    let parts: Vec<String> = up.chain(down).collect();
    if parts.is_empty() { ".".into() } else { parts.join("/") }
}

/// Returns whether two paths lead to the same file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_a_folder() {
        let root = tempfile::tempdir().expect("a folder");
        let at = |name: &str| root.path().join(name);
        for folder in ["a/b", "c"] {
            std::fs::create_dir_all(at(folder)).expect("made");
        }
        std::fs::write(at("c/x"), "abc").expect("written");
        assert_eq!(seen_from(&at("a/b"), &at("c/x")), "../../c/x");
        assert_eq!(seen_from(&at("c"), &at("c/x")), "x");
        assert_eq!(seen_from(&at("c"), &at("c")), ".");
        let input = hashed(&at("c/x"), &at("a")).expect("read");
        assert_eq!((input.bytes, &*input.path), (3, "../c/x"));
        assert_eq!(input.hash, blake3::hash(b"abc").to_hex().to_string());
        assert!(is_same(&at("c/x"), &at("a/../c/x")) && !is_same(&at("c/x"), &at("c/y")));
    }
}
