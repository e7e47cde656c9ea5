//! Messages of commands, compared with stored ones.

use crate::scene::{Run, Scene};
use crate::stored;
use std::path::{Path, PathBuf};

/// Stored messages of the commands of one test: a folder with one text per command.
pub(crate) struct Told {
    folder: PathBuf,
    faults: Vec<String>,
}

impl Told {
    pub(crate) fn new(group: &str) -> Self {
        Self { folder: Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/told").join(group), faults: Vec::new() }
    }

    /// Checks that a command ends with this code, prints nothing on stdout, and prints the stored text on stderr.
    pub(crate) fn is(&mut self, name: &str, code: i32, scene: &Scene, arguments: &[&str]) {
        let run = scene.run(arguments);
        if !run.out.is_empty() {
            self.faults
                .push(format!("{name}: {arguments:?}: found on stdout, where nothing was expected: {}", run.out));
        }
        self.stands(name, code, &run, scene);
    }

    /// Checks that a run ended with this code and the stored text on stderr, whatever it printed on stdout.
    pub(crate) fn stands(&mut self, name: &str, code: i32, run: &Run, scene: &Scene) {
        if run.code != code || run.err.contains("panicked") {
            self.faults.push(format!("{name}: found the code {}; expected {code}: {}", run.code, run.err));
            return;
        }
        let path = self.folder.join(format!("{name}.txt"));
        self.faults.extend(stored::holds_said(&path, &run.err, &scene.path("")).err());
    }

    /// Asserts that all messages are the stored ones.
    #[track_caller]
    pub(crate) fn ends(self) {
        assert!(self.faults.is_empty(), "{}", self.faults.join("\n"));
    }
}
