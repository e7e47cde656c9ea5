//! Commands of the program.

use crate::errors::{Cancelled, command_error};
use crate::watch::watched;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Exit code of a command that was cancelled.
const CANCELLED: u8 = 130;

/// What a command printed.
#[pyclass(frozen, get_all, module = "trochoid")]
pub(crate) struct Output {
    /// The result, which the program prints on stdout.
    text: String,
    /// What the program prints on stderr: warnings and notes, some with a second line "  remedy: ...".
    messages: Vec<String>,
}

#[pymethods]
impl Output {
    /// Returns the text as values; for commands with --json.
    fn json<'p>(&self, py: Python<'p>) -> PyResult<Bound<'p, PyAny>> {
        py.import("json")?.call_method1("loads", (&self.text,))
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("Output({} characters, {} messages)", self.text.chars().count(), self.messages.len())
    }
}

/// Runs a command of the program in this process, with the arguments of its command line.
///
/// Relative paths are relative to the current folder. Commands run one after another: a second one waits. All but `edit`
/// can be run.
///
/// `progress(done, total)` is called now and then; if it returns False, the command stops and Cancelled is raised, and so
/// does Ctrl-C. Finished files stay, and no partial ones. Raises CommandError if the command fails, with the exit code of
/// the program.
///
///     >>> output = trochoid.run(["nodes", "Mix"])
///     >>> output.text.splitlines()[0]
///     'Mix (back end)'
#[pyfunction]
#[pyo3(signature = (arguments, *, progress=None))]
pub(crate) fn run(py: Python<'_>, arguments: Vec<PathBuf>, progress: Option<Bound<'_, PyAny>>) -> PyResult<Output> {
    let arguments: Vec<OsString> = arguments.into_iter().map(PathBuf::into_os_string).collect();
    let outcome = watched(py, progress.as_ref(), |watch| trochoid_cli::run(arguments, watch.clone()))?;
    match outcome.code {
        0 => Ok(Output { text: outcome.text, messages: outcome.messages }),
        CANCELLED => Err(Cancelled::new_err(outcome.messages.join("\n"))),
        _ => Err(command_error(py, outcome)),
    }
}
