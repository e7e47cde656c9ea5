//! A folder with a document, and commands that run in it.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;
use trochoid::io::{ExrChannel, ExrImage, Picture, Samples, Selection, info, read, write_exr};
use trochoid::{Plane, Window};

/// Temporary folder with the document `a.json`.
pub(crate) struct Scene {
    folder: TempDir,
}

/// Result of a command.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// A document with three frames of a color and of a mask.
pub(crate) const SCENE: &str = r##"{ "trochoid": 1,
  "format": { "width": 16, "height": 8 }, "frames": { "first": 1, "last": 3 },
  "nodes": { "across": { "type": "ScreenX" },
             "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "across" } },
  "outputs": { "beauty": { "color": "mix", "file": "out/beauty.####.exr", "require": { "guarantee": "hull" } },
               "mask": { "weights": "across", "file": "out/mask.####.png" } } }"##;

/// A document that reads `in.exr`.
pub(crate) const READS: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 },
  "nodes": { "in": { "type": "Read", "file": "in.exr", "as": "color" } },
  "outputs": { "beauty": { "color": "in", "file": "out.exr" } } }"##;

/// Returns [`SCENE`] with an unused node.
pub(crate) fn with_unused() -> String {
    SCENE.replace("\"across\": {", "\"lost\": { \"type\": \"ScreenY\" }, \"across\": {")
}

impl Scene {
    pub(crate) fn new(document: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.json"), document).unwrap();
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Reads all channels of an EXR file, whatever layers they are in.
    pub(crate) fn layers(&self, name: &str) -> Picture {
        let found = info(self.path(name), &Default::default()).unwrap();
        let names = found.parts[0].channels.iter().map(|channel| channel.full_name.clone());
        read(self.path(name), &Selection::channels(names), &Default::default()).unwrap()
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trochoid"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        for variable in ["NO_COLOR", "CLICOLOR_FORCE", "CLICOLOR", "COLUMNS", "LINES"] {
            command.env_remove(variable);
        }
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        Run::of(&mut self.command(arguments))
    }

    /// Returns all files under the folder except for the document, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { walk(&path, found) } else { found.push(path) }
            }
        }
        let mut found = Vec::new();
        walk(self.folder.path(), &mut found);
        let names = found.iter().map(|path| path.strip_prefix(self.folder.path()).unwrap().display().to_string());
        let mut names: Vec<String> = names.filter(|name| name != "a.json").collect();
        names.sort();
        names
    }

    #[track_caller]
    pub(crate) fn has_no_files(&self) {
        assert_eq!(self.files(), [""; 0]);
    }

    /// Writes a picture of 4 × 2 pixels of a single gray.
    pub(crate) fn write_picture(&self, name: &str, value: f32) {
        let plane = Plane::filled(Window::sized(4, 2), value);
        let channels = ["R", "G", "B"].map(|name| ExrChannel::float(name, Samples::plane(&plane))).into();
        write_exr(self.path(name), &ExrImage { channels, ..ExrImage::new(Window::sized(4, 2)) }).unwrap();
    }
}

impl Run {
    pub(crate) fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) }
    }

    #[track_caller]
    pub(crate) fn code(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stdout: {}\nstderr: {}", self.out, self.err);
        assert!(!self.err.contains("panicked"), "{}", self.err);
        self
    }

    /// Asserts that the command failed with this code, these words on stderr, and nothing on stdout.
    #[track_caller]
    pub(crate) fn fails(self, code: i32, words: &[&str]) {
        let run = self.code(code);
        assert_eq!(run.out, "");
        for word in words {
            assert!(run.err.contains(word), "no \"{word}\" in: {}", run.err);
        }
    }

    /// Asserts that stdout contains all of these words.
    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.out.contains(word), "no \"{word}\" in: {}", self.out);
        }
        self
    }

    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }
}
