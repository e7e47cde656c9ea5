//! Documents, and what is said of them by name.

use crate::errors;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;
use trochoid::{Illegal, LookBuilder};

/// How a look is made.
pub(crate) struct Options<'a, 'p> {
    pub(crate) output: Option<&'a str>,
    pub(crate) inputs: Vec<String>,
    pub(crate) set: Option<&'a Bound<'p, PyAny>>,
    pub(crate) frame: i64,
    pub(crate) samples: Option<usize>,
    pub(crate) illegal: &'a str,
    pub(crate) allow: Vec<PathBuf>,
    pub(crate) threads: Option<usize>,
}

impl Options<'_, '_> {
    pub(crate) fn apply(self, mut builder: LookBuilder) -> PyResult<LookBuilder> {
        if let Some(output) = self.output {
            builder = builder.output(output);
        }
        builder = self.inputs.iter().fold(builder, |builder, name| builder.bind(name));
        builder = assigned(builder, self.set)?;
        if let Some(samples) = self.samples {
            builder = builder.expecting(samples);
        }
        let illegal = match self.illegal {
            "refuse" => Illegal::Refuse,
            "clamp" => Illegal::Clamp,
            other => {
                return Err(PyValueError::new_err(format!(
                    "found illegal={other:?}; expected \"refuse\" or \"clamp\""
                )));
            }
        };
        builder = self.allow.iter().fold(builder, |builder, path| builder.allow(path));
        Ok(builder.frame(self.frame).illegal(illegal).threads(self.threads.unwrap_or(0)))
    }
}

/// Takes a list of names or paths. A single one, whose letters Python would take one by one, is refused.
pub(crate) fn listed<'p, T: FromPyObjectOwned<'p>>(value: &Bound<'p, PyAny>) -> PyResult<Vec<T>> {
    if value.is_instance_of::<PyString>() {
        let one = value.repr()?;
        return Err(PyTypeError::new_err(format!("found {one}; expected a list, such as [{one}]")));
    }
    value.extract()
}

/// Returns a mapping as a dictionary.
pub(crate) fn dictionary<'p>(what: &str, mapping: &Bound<'p, PyAny>) -> PyResult<Bound<'p, PyDict>> {
    if let Ok(dictionary) = mapping.cast::<PyDict>() {
        return Ok(dictionary.clone());
    }
    let made = mapping.py().get_type::<PyDict>().call1((mapping,)).map_err(|_| {
        let found = mapping.get_type();
        PyTypeError::new_err(format!("{what}: found {found}; expected a dictionary with names as keys"))
    })?;
    Ok(made.cast_into::<PyDict>()?)
}

/// Returns a value as JSON.
fn json(value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.py().import("trochoid._json")?.call_method1("text", (value,))?.extract()
}

/// Applies assignments: values are those of JSON.
pub(crate) fn assigned(mut builder: LookBuilder, set: Option<&Bound<'_, PyAny>>) -> PyResult<LookBuilder> {
    let Some(set) = set else { return Ok(builder) };
    for (path, value) in dictionary("set", set)? {
        let text = json(&value)?;
        builder = builder.set(&format!("{}={text}", path.extract::<String>()?));
    }
    Ok(builder)
}

/// Whether a text is more likely a path than a document, which begins with a brace.
fn is_path(text: &str) -> bool {
    let is_document = text.trim_start_matches('\u{feff}').trim_start().starts_with('{');
    !is_document && !text.is_empty() && !text.contains('\n')
}

/// Begins with a document that is given as text or as a dictionary.
pub(crate) fn begun(document: &Bound<'_, PyAny>, folder: Option<PathBuf>, name: Option<&str>) -> PyResult<LookBuilder> {
    let text: String = if let Ok(text) = document.cast::<PyString>() {
        let text: String = text.extract()?;
        if is_path(&text) {
            let path = document.repr()?;
            return Err(PyValueError::new_err(format!(
                "found {path}; expected the text of a document, or a dictionary: Look.load({path}) reads a file"
            )));
        }
        text
    } else if document.is_instance_of::<PyDict>() {
        json(document)?
    } else {
        let found = document.get_type();
        let load = if document.hasattr("__fspath__")? { ": Look.load reads a file" } else { "" };
        return Err(PyTypeError::new_err(format!(
            "found {found}; expected the text of a document, or a dictionary{load}"
        )));
    };
    let mut builder = LookBuilder::new(text);
    if let Some(folder) = folder {
        builder = builder.within(&folder);
    }
    Ok(match name {
        Some(name) => builder.named(name),
        None => builder,
    })
}

/// Checks a document that is given as text or as a dictionary.
#[pyfunction]
#[pyo3(signature = (document, *, set=None, folder=None, name=None))]
pub(crate) fn check<'p>(
    document: &Bound<'p, PyAny>,
    set: Option<Bound<'p, PyAny>>,
    folder: Option<PathBuf>,
    name: Option<&str>,
) -> PyResult<Bound<'p, PyAny>> {
    let py = document.py();
    let builder = assigned(begun(document, folder, name)?, set.as_ref())?;
    let loaded = py.detach(|| {
        let mut loaded = builder.load()?;
        loaded.warnings.extend(trochoid::missing_files(&loaded.graph));
        Ok(loaded)
    });
    errors::dictionaries(py, &loaded.map_err(|error| errors::of_load(py, error))?.warnings)
}
