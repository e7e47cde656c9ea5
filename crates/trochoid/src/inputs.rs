//! Files that a document reads, which none of its runs may overwrite.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};
use trochoid_graph::{CheckedGraph, Item, KnobType, NodeId, resolved};

/// Two frame numbers that differ in every digit, so that the common part of their file names is the pattern.
const PROBES: [i64; 2] = [1_111_111_111_111_111, 2_222_222_222_222_222];

/// Files that any output of a document reads at any frame, and other files that a run reads.
///
/// A sequence is matched by its pattern, including frames outside the document's range, since another run may request
/// them. Links, including hard links, are matched by the file that they lead to.
#[derive(Debug)]
pub struct InputFiles {
    /// Files that exist.
    known: HashSet<Identity>,
    /// Resolved paths of files with the same name at all frames.
    paths: HashSet<PathBuf>,
    sequences: Vec<Sequence>,
}

/// Identity of an existing file, which does not depend on its name.
#[derive(Debug, PartialEq, Eq, Hash)]
enum Identity {
    #[cfg(unix)]
    Place { device: u64, inode: u64 },
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    /// Returns the identity of a file; `None` if it does not exist.
    fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let found = std::fs::metadata(path).ok()?;
            Some(Self::Place { device: found.dev(), inode: found.ino() })
        }
        #[cfg(not(unix))]
        {
            path.canonicalize().ok().map(Self::Path)
        }
    }
}

/// File names that contain the frame.
#[derive(Debug)]
struct Sequence {
    /// Folder of the path component that contains the frame.
    folder: PathBuf,
    /// Text before and after the frame in that component.
    around: [String; 2],
    /// Minimum number of digits of the frame.
    width: usize,
    /// Components after that one.
    rest: PathBuf,
}

impl Sequence {
    /// Returns the sequence of the names that `path` gives to frames; `None` if all frames have the same name.
    fn of(path: &dyn Fn(i64) -> PathBuf) -> Option<Self> {
        let [one, other] = PROBES.map(path);
        let (one, other): (Vec<Component<'_>>, Vec<Component<'_>>) =
            (one.components().collect(), other.components().collect());
        let at = one.iter().zip(&other).position(|(one, other)| one != other)?;
        let [a, b] = [one[at], other[at]].map(|part| part.as_os_str().to_string_lossy().into_owned());
        let shared = |count: usize| a.char_indices().nth(count).map_or(a.len(), |(at, _)| at);
        let before = shared(a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count());
        let behind = a.chars().rev().zip(b.chars().rev()).take_while(|(a, b)| a == b).count();
        let after = shared(a.chars().count() - behind);
        let around = [a[..before].to_owned(), a[after..].to_owned()];
        let zero = path(0).components().nth(at)?.as_os_str().to_string_lossy().into_owned();
        let width = zero.len().checked_sub(around[0].len() + around[1].len())?;
        let folder = resolved(&one[..at].iter().collect::<PathBuf>());
        Some(Self { folder, around, width, rest: one[at + 1..].iter().collect() })
    }

    /// Returns whether a name in the folder is that of a frame.
    fn is_frame(&self, name: &str) -> bool {
        let [before, after] = &self.around;
        let digits = name.strip_prefix(before.as_str()).and_then(|name| name.strip_suffix(after.as_str()));
        let Some((digits, frame)) = digits.and_then(|digits| Some((digits, digits.parse::<i64>().ok()?))) else {
            return false;
        };
        let (sign, width) = (if frame < 0 { "-" } else { "" }, self.width);
        digits == format!("{sign}{:0width$}", frame.unsigned_abs())
    }

    /// Returns whether a resolved path is that of a frame.
    fn has(&self, path: &Path) -> bool {
        let Ok(rest) = path.strip_prefix(&self.folder) else { return false };
        let mut parts = rest.components();
        let name = parts.next().and_then(|part| part.as_os_str().to_str());
        name.is_some_and(|name| self.is_frame(name)) && parts.as_path() == self.rest
    }

    /// Returns the existing files of the sequence.
    fn files(&self) -> impl Iterator<Item = PathBuf> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let named = entries.filter(|entry| entry.file_name().to_str().is_some_and(|name| self.is_frame(name)));
        named.map(|entry| if self.rest.as_os_str().is_empty() { entry.path() } else { entry.path().join(&self.rest) })
    }
}

impl InputFiles {
    /// Returns the inputs of a document; `also` has other files that the run reads, such as the document itself.
    pub fn new(graph: &CheckedGraph, also: &[&Path]) -> Self {
        let first = graph.frames().0;
        let connected = graph.upstream(graph.outputs().iter().map(|output| output.node));
        let begin = graph.frame_context(first, u64::MAX);
        let (mut fixed, mut sequences) = (also.iter().map(|path| path.to_path_buf()).collect::<Vec<_>>(), Vec::new());
        fixed.extend(graph.document_files().iter().cloned());
        for id in (0..graph.nodes().len()).filter(|index| connected[*index]).map(NodeId) {
            let node = graph.node(id);
            if node.disabled {
                continue;
            }
            fixed.extend(graph.files_of(id, &begin));
            let settled = graph.settle(id, first);
            for item in node.ty.declaration().items {
                let Item::Knob(knob) = item else { continue };
                if matches!(knob.takes, KnobType::Path) && settled.is_set(knob.name) {
                    let path = |frame| graph.frame_context(frame, u64::MAX).path(settled.text(knob.name));
                    sequences.extend(Sequence::of(&path));
                }
            }
        }
        let existing = sequences.iter().flat_map(Sequence::files);
        let known = existing.chain(fixed.iter().cloned()).filter_map(|path| Identity::of(&path)).collect();
        let paths = fixed.iter().map(|path| resolved(path)).collect();
        Self { known, paths, sequences }
    }

    /// Adds the inputs of another state of the document.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.known.extend(other.known);
        self.paths.extend(other.paths);
        self.sequences.extend(other.sequences);
        self
    }

    /// Returns whether a path leads to one of the inputs. The file need not exist.
    pub fn contains(&self, path: &Path) -> bool {
        if Identity::of(path).is_some_and(|found| self.known.contains(&found)) {
            return true;
        }
        let path = resolved(path);
        self.paths.contains(&path) || self.sequences.iter().any(|sequence| sequence.has(&path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const READS: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 },
        "nodes": { "seq": { "type": "Read", "as": "color", "file": "in/seq.####.png" },
                   "deep": { "type": "Read", "as": "color", "file": "shot.%03d/a.png" },
                   "one": { "type": "Read", "as": "color", "file": "one.png" },
                   "off": { "type": "Read", "as": "color", "file": "off.png", "disabled": true },
                   "mix": { "type": "Mix", "a": "seq", "b": "deep", "weight": 0.5 } },
        "outputs": { "a": { "color": "mix" }, "b": { "color": "one" } } }"##;

    fn inputs(folder: &Path) -> InputFiles {
        let graph = crate::parse("a.json", READS, folder, &[]).expect("valid").graph;
        InputFiles::new(&graph, &[&folder.join("a.json")])
    }

    #[test]
    fn every_frame_of_every_output_counts_whatever_the_run() {
        let held = tempfile::tempdir().expect("a folder");
        let folder = held.path();
        for name in ["in", "shot.007", "out"] {
            fs::create_dir(folder.join(name)).expect("made");
        }
        for name in ["in/seq.0002.png", "shot.007/a.png", "a.json"] {
            fs::write(folder.join(name), name).expect("written");
        }
        let inputs = inputs(folder);
        let read =
            ["in/seq.0002.png", "in/seq.0003.png", "in/seq.-0005.png", "in/seq.123456.png", "in/../in/seq.0001.png"];
        for name in read.iter().chain(&["shot.007/a.png", "shot.1000/a.png", "one.png", "a.json", "out/../one.png"]) {
            assert!(inputs.contains(&folder.join(name)), "{name}");
        }
        let free = ["in/seq.2.png", "in/seq.00002.png", "in/seq.+002.png", "in/seq.0002.exr", "seq.0002.png"];
        for name in free.iter().chain(&[
            "shot.007/b.png",
            "shot.7/a.png",
            "shot.007",
            "in/seq.0002.png/x",
            "off.png",
            "two.png",
        ]) {
            assert!(!inputs.contains(&folder.join(name)), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_the_files_that_they_are() {
        use std::os::unix::fs::symlink;
        let held = tempfile::tempdir().expect("a folder");
        let folder = held.path();
        fs::create_dir(folder.join("in")).expect("made");
        fs::write(folder.join("in/seq.0002.png"), "").expect("written");
        fs::write(folder.join("elsewhere.png"), "").expect("written");
        fs::hard_link(folder.join("in/seq.0002.png"), folder.join("hard.png")).expect("a link");
        symlink("in/seq.0002.png", folder.join("soft.png")).expect("a link");
        symlink("in", folder.join("alias")).expect("a link");
        symlink("../elsewhere.png", folder.join("in/seq.0004.png")).expect("a link");
        symlink("in/seq.0009.png", folder.join("not_yet.png")).expect("a link");
        let inputs = inputs(folder);
        for name in ["hard.png", "soft.png", "alias/seq.0002.png", "alias/seq.0007.png", "elsewhere.png", "not_yet.png"]
        {
            assert!(inputs.contains(&folder.join(name)), "{name}");
        }
        assert!(!inputs.contains(&folder.join("alias/other.png")));
    }
}
