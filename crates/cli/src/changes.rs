//! Changes to a document that the command line makes.

use std::path::PathBuf;

/// Options that change a document for one run.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Changes {
    /// Replace colors of the document's palette by those of the same names in this file, JSON or .gpl
    #[arg(long, value_name = "FILE")]
    pub(crate) palette: Option<PathBuf>,
    /// Set a knob or port, a part of one such as sky.stops[1].color, or palette.NAME; VALUE is JSON or a bare word, such
    /// as storm.height=3; may be repeated
    #[arg(long, value_name = "NODE.KNOB=VALUE")]
    pub(crate) set: Vec<String>,
}

impl Changes {
    /// Returns the changes as assignments: the palette first, so that single colors can still be set.
    pub(crate) fn assignments(&self) -> Vec<String> {
        let palette = self.palette.iter().map(|file| format!("palette={}", file.display()));
        palette.chain(self.set.iter().cloned()).collect()
    }
}
