//! Exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use trochoid::{BufferFault, Diagnostic, EvalError, LoadError, Look, LookError, PictureError, ShadeError};
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
        LoadError::Io(_) => PyOSError::new_err(text),
        LoadError::Invalid(faults) => {
            with(py, InvalidDocument::new_err(text), |value| value.setattr("diagnostics", dictionaries(py, &faults)?))
        }
    }
}

pub(crate) fn of_look(py: Python<'_>, error: LookError) -> PyErr {
    match error {
        LookError::Load(error) => of_load(py, error),
        error => PyValueError::new_err(error.to_string()),
    }
}

fn illegal(py: Python<'_>, text: String, name: &str, slot: Option<usize>, sample: usize) -> PyErr {
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
            illegal(py, text, &name, Some(slot), first + sample)
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

pub(crate) fn of_picture(py: Python<'_>, look: &Look, error: PictureError) -> PyErr {
    let text = error.to_string();
    match error {
        PictureError::Evaluate(EvalError::Cancelled) => Cancelled::new_err(text),
        PictureError::Passes(error) => of_shade(py, error, 0),
        PictureError::Evaluate(EvalError::Buffer {
            node,
            reason: BufferFault::Value { sample, .. } | BufferFault::Sum { sample, .. },
        }) => {
            let slot = look.slots().iter().position(|slot| slot.name == node);
            illegal(py, text, &node, slot, sample)
        }
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
