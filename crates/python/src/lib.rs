//! The Python interface: looks over numpy arrays, and the commands of the program.
//!
//! It translates between Python, [`trochoid::Look`] and [`trochoid_cli::run`], and decides nothing itself. The package
//! around it, `python/trochoid`, has the types for editors, and a function for each of the commands that are used most.

mod arrays;
mod command;
mod errors;
mod given;
mod look;
mod options;
mod picture;
mod watch;

use pyo3::prelude::*;
use trochoid::Heap;

/// A compositor whose pictures cannot leave their palette.
#[pymodule]
fn _trochoid(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Python allocates for itself, so nothing is bounded: frames that would take more are refused before they begin.
    Heap::bound(usize::try_from(trochoid::memory_share()).unwrap_or(usize::MAX));
    module.add("__version__", trochoid::VERSION)?;
    module.add_class::<look::Look>()?;
    module.add_class::<look::Slot>()?;
    module.add_class::<picture::Picture>()?;
    module.add_class::<picture::Audit>()?;
    module.add_class::<picture::Node>()?;
    module.add_class::<command::Output>()?;
    module.add_function(wrap_pyfunction!(options::check, module)?)?;
    module.add_function(wrap_pyfunction!(command::run, module)?)?;
    errors::add(module)
}
