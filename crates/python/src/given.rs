//! What is given for an input: an array, or numbers.

use crate::arrays::Strided;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};
use trochoid::Slot;

/// What is given for an input.
pub(crate) enum Given<'p> {
    /// An array of f32, kept alive, with the channels along its last axis if there are several.
    Array { array: Bound<'p, PyArrayDyn<f32>>, channels: usize },
    /// A number for each channel, for all samples.
    Uniform(Vec<f32>),
}

impl<'p> Given<'p> {
    /// Takes an array, a number, a number for each channel, or what numpy makes an array of.
    pub(crate) fn new(slot: &Slot, value: &Bound<'p, PyAny>) -> PyResult<Self> {
        let channels = slot.channels();
        if let Ok(array) = value.cast::<PyArrayDyn<f32>>() {
            return Self::array(slot, array.clone());
        }
        if channels == 1 && (value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>()) {
            return Ok(Self::Uniform(vec![value.extract::<f64>()? as f32]));
        }
        if channels > 1
            && (value.is_instance_of::<PyTuple>() || value.is_instance_of::<PyList>())
            && let Ok(numbers) = value.extract::<Vec<f64>>()
            && numbers.len() == channels
        {
            return Ok(Self::Uniform(numbers.into_iter().map(|number| number as f32).collect()));
        }
        let none = |found: &str| {
            let name = &slot.name;
            PyTypeError::new_err(format!("\"{name}\": found {found}; expected samples of it: an array, or numbers"))
        };
        if value.is_none() {
            return Err(none("None"));
        }
        let numpy = value.py().import("numpy")?;
        let asarray = |arguments| {
            let made = numpy.call_method1("asarray", arguments);
            made.map_err(|error| PyTypeError::new_err(format!("\"{}\": expected numbers: {error}", slot.name)))
        };
        let found = asarray((value, value.py().None()))?;
        let is_objects = found.getattr("dtype")?.getattr("kind")?.extract::<char>()? == 'O';
        // Numpy would make NaN of it.
        if is_objects && found.getattr("flat")?.try_iter()?.any(|item| item.is_ok_and(|item| item.is_none())) {
            return Err(none("None among others"));
        }
        let array = asarray((&found, numpy.getattr("float32")?.unbind()))?;
        Self::array(slot, array.cast_into::<PyArrayDyn<f32>>()?)
    }

    fn array(slot: &Slot, array: Bound<'p, PyArrayDyn<f32>>) -> PyResult<Self> {
        let channels = slot.channels();
        if channels > 1 && array.shape().last() != Some(&channels) {
            let (shape, kind) = (array.shape(), slot.kind);
            return Err(PyValueError::new_err(format!(
                "\"{}\": found the shape {shape:?}; a {kind} has {channels} channels along its last axis",
                slot.name
            )));
        }
        Ok(Self::Array { array, channels })
    }

    /// Returns the shape of the samples.
    pub(crate) fn shape(&self) -> &[usize] {
        match self {
            Self::Uniform(_) => &[],
            Self::Array { array, channels: 1 } => array.shape(),
            Self::Array { array, .. } => &array.shape()[..array.shape().len() - 1],
        }
    }

    /// Returns the channels over a shape that this one extends to.
    pub(crate) fn channels(&self, shape: &[usize]) -> Vec<Strided> {
        let (array, channels) = match self {
            Self::Uniform(numbers) => {
                let one = |number: &f32| Strided {
                    first: std::ptr::from_ref(number).cast_mut(),
                    strides: vec![0; shape.len()],
                };
                return numbers.iter().map(one).collect();
            }
            Self::Array { array, channels } => (array, *channels),
        };
        let (own, strides) = (self.shape(), array.strides());
        let over = |axis: usize| match axis.checked_sub(shape.len() - own.len()) {
            Some(own_axis) if own[own_axis] > 1 => strides[own_axis],
            // The same along this axis.
            _ => 0,
        };
        let strides_over: Vec<isize> = (0..shape.len()).map(over).collect();
        let step = if channels > 1 { strides[own.len()] } else { 0 };
        let first = array.data();
        let channel = |channel: usize| Strided {
            first: first.wrapping_byte_offset(step * channel as isize),
            strides: strides_over.clone(),
        };
        (0..channels).map(channel).collect()
    }

    /// Copies the array if results, which are written sample by sample, would be written over samples that are still to be
    /// read.
    pub(crate) fn apart_from(&mut self, outputs: &[Strided], shape: &[usize]) -> PyResult<()> {
        let channels = self.channels(shape);
        let Self::Array { array, .. } = self else { return Ok(()) };
        if channels.iter().any(|input| outputs.iter().any(|output| input.is_hit_by(output, shape))) {
            *array = array.call_method0("copy")?.cast_into::<PyArrayDyn<f32>>()?;
        }
        Ok(())
    }
}
