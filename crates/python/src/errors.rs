//! Exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use std::path::Path;
use trochoid::io;
use trochoid::{BufferFault, Diagnostic, EvalError, LoadError, LookError, PictureError, ShadeError};
use trochoid_cli::Outcome;

create_exception!(trochoid, Error, PyException, "Base class of what Trochoid raises.");
create_exception!(
    trochoid,
    InvalidDocument,
    Error,
    "The document is invalid.\n\n`diagnostics` lists every fault and warning, as dictionaries with \"severity\", \"file\", \
     \"line\", \"column\", \"node\", \"port\", \"found\", \"expected\" and \"remedy\"."
);
create_exception!(
    trochoid,
    InvalidLook,
    Error,
    "The document is sound, but has not what the look asks of it.\n\n`diagnostics` lists every fault of the output, the \
     inputs and the values that are set, in the form of InvalidDocument. Where \"line\" is 0, \"port\" is the argument, such \
     as \"inputs[1]\"."
);
create_exception!(
    trochoid,
    NotPointwise,
    Error,
    "The output needs a picture: nodes that are no inputs need more than one sample at a time.\n\n`diagnostics` has a fault \
     for each of these nodes, in the form of InvalidDocument."
);
create_exception!(
    trochoid,
    IllegalSample,
    Error,
    "A sample of an input is illegal for its kind.\n\n`name` is the input, `slot` its index, and `sample` the index of the \
     sample, counted in C order over the common shape of the inputs."
);
create_exception!(
    trochoid,
    CommandError,
    Error,
    "A command has failed.\n\n`code` is the exit code of the program: 1 input, output or the evaluation failed, or input \
     data are bad; 2 wrong usage or an invalid document; 3 a required guarantee or tolerance is not met, or a certificate \
     does not hold. `messages` are what the program prints on stderr, and `text` is what it prints on stdout."
);
create_exception!(trochoid, Cancelled, Error, "The progress function returned False.");

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    module.add("InvalidDocument", py.get_type::<InvalidDocument>())?;
    module.add("InvalidLook", py.get_type::<InvalidLook>())?;
    module.add("NotPointwise", py.get_type::<NotPointwise>())?;
    module.add("IllegalSample", py.get_type::<IllegalSample>())?;
    module.add("CommandError", py.get_type::<CommandError>())?;
    module.add("Cancelled", py.get_type::<Cancelled>())
}

/// Returns diagnostics as a list of dictionaries.
pub(crate) fn dictionaries<'p>(py: Python<'p>, faults: &[Diagnostic]) -> PyResult<Bound<'p, PyAny>> {
    let text = serde_json::Value::Array(faults.iter().map(Diagnostic::to_json).collect()).to_string();
    py.import("json")?.call_method1("loads", (text,))
}

/// Gives an exception its attributes.
fn with(py: Python<'_>, raised: PyErr, attributes: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>) -> PyErr {
    match attributes(raised.value(py)) {
        Ok(()) => raised,
        Err(other) => other,
    }
}

pub(crate) fn of_load(py: Python<'_>, error: LoadError) -> PyErr {
    let text = error.to_string();
    match error {
        LoadError::Io(error) => of_file(py, &error),
        LoadError::Invalid(faults) => listed(py, InvalidDocument::new_err(text), &faults),
    }
}

/// Returns what `open` of Python would raise, such as FileNotFoundError with its `errno` and `filename`, in our words.
fn of_file(py: Python<'_>, error: &io::Error) -> PyErr {
    let text = error.to_string();
    // Python adds the path itself, and the number is the errno.
    let words = |path: &Path| {
        let text = text.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&text);
        text.split(" (os error ").next().unwrap_or(text).to_owned()
    };
    match error {
        io::Error::Io { path, source, .. } if let Some(code) = source.raw_os_error() => {
            if cfg!(windows) {
                return PyOSError::new_err((0, words(path), path.as_os_str().to_owned(), code));
            }
            PyOSError::new_err((code, words(path), path.as_os_str().to_owned()))
        }
        io::Error::NotAFile { path, .. } if path.is_dir() => {
            match py.import("errno").and_then(|errno| errno.getattr("EISDIR")?.extract::<i32>()) {
                Ok(code) => PyOSError::new_err((code, words(path), path.as_os_str().to_owned())),
                Err(other) => other,
            }
        }
        _ => PyOSError::new_err(text),
    }
}

pub(crate) fn of_look(py: Python<'_>, error: LookError) -> PyErr {
    match error {
        LookError::Load(error) => of_load(py, error),
        error => listed(py, InvalidLook::new_err(error.to_string()), error.diagnostics()),
    }
}

/// Gives an exception its faults.
fn listed(py: Python<'_>, raised: PyErr, faults: &[Diagnostic]) -> PyErr {
    with(py, raised, |value| value.setattr("diagnostics", dictionaries(py, faults)?))
}

pub(crate) fn of_shader(py: Python<'_>, error: &trochoid::NotPointwise) -> PyErr {
    listed(py, NotPointwise::new_err(error.to_string()), &error.faults)
}

fn illegal(py: Python<'_>, text: String, name: &str, slot: usize, sample: usize) -> PyErr {
    with(py, IllegalSample::new_err(text), |value| {
        value.setattr("name", name)?;
        value.setattr("slot", slot)?;
        value.setattr("sample", sample)
    })
}

/// `first` is the index of the first sample of what was shaded, in all.
pub(crate) fn of_shade(py: Python<'_>, error: ShadeError, first: usize) -> PyErr {
    match error {
        ShadeError::Illegal { slot, name, sample, fault } => {
            // As counted by the caller.
            let text = format!("\"{name}\": {}", at(fault, first));
            illegal(py, text, &name, slot, first + sample)
        }
        error => PyValueError::new_err(error.to_string()),
    }
}

/// Returns a fault of a sample whose index is counted from `first`.
fn at(mut fault: BufferFault, first: usize) -> BufferFault {
    if let BufferFault::Value { sample, .. } | BufferFault::Sum { sample, .. } = &mut fault {
        *sample += first;
    }
    fault
}

pub(crate) fn of_picture(py: Python<'_>, error: PictureError) -> PyErr {
    let text = error.to_string();
    match error {
        PictureError::Evaluate(EvalError::Cancelled) => Cancelled::new_err(text),
        PictureError::Passes(error) => of_shade(py, error, 0),
        PictureError::Evaluate(EvalError::TooMuchMemory { .. } | EvalError::Memory { .. }) => {
            PyMemoryError::new_err(text)
        }
        PictureError::Evaluate(_) => PyOSError::new_err(text),
        error => PyValueError::new_err(error.to_string()),
    }
}

pub(crate) fn command_error(py: Python<'_>, outcome: Outcome) -> PyErr {
    let text = if outcome.messages.is_empty() { outcome.text.clone() } else { outcome.messages.join("\n") };
    with(py, CommandError::new_err(text), |value| {
        value.setattr("code", outcome.code)?;
        value.setattr("messages", outcome.messages)?;
        value.setattr("text", outcome.text)
    })
}
