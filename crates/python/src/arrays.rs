//! Channels in arrays: strides along several axes, what numpy calls broadcasting, and the runs that a shader takes.

use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use trochoid_foreign::{Input, Output};

/// Size of a sample in bytes.
const SAMPLE: isize = size_of::<f32>() as isize;

/// A channel in an array: its first sample, and the distance of samples along each axis in bytes.
pub(crate) struct Strided {
    pub(crate) first: *mut f32,
    pub(crate) strides: Vec<isize>,
}

impl Strided {
    /// Whether all samples are the same one.
    pub(crate) fn is_uniform(&self) -> bool {
        !self.first.is_null() && self.strides.iter().all(|stride| *stride == 0)
    }

    /// Returns the addresses of the first byte and of that behind the last one, over a shape.
    fn extent(&self, shape: &[usize]) -> (isize, isize) {
        let (mut low, mut high) = (self.first.addr() as isize, self.first.addr() as isize + SAMPLE);
        for (stride, length) in self.strides.iter().zip(shape) {
            let reach = stride * (length.saturating_sub(1) as isize);
            (low, high) = (low + reach.min(0), high + reach.max(0));
        }
        (low, high)
    }

    /// Whether writing a sample of `output` may change another sample of this channel.
    fn may_be_hit(&self, output: &Self, shape: &[usize]) -> bool {
        let (own, other) = (self.extent(shape), output.extent(shape));
        own.0 < other.1 && other.0 < own.1
    }

    /// Whether writing a sample of `output` changes another sample of this channel than the one from which it is computed.
    pub(crate) fn is_hit_by(&self, output: &Self, shape: &[usize]) -> bool {
        if !self.may_be_hit(output, shape) {
            return false;
        }
        // Where both go on at the same strides, and lie within one step of each other, only the same sample is near.
        let apart = (self.first.addr() as isize - output.first.addr() as isize).abs();
        let long = shape.iter().zip(&self.strides).zip(&output.strides).filter(|((length, _), _)| **length > 1);
        !long.into_iter().all(|((_, own), other)| own == other && apart + SAMPLE <= own.abs())
    }
}

/// Returns an array of zeros. Numpy makes it: where memory does not suffice, it raises MemoryError.
pub(crate) fn zeros<'p>(py: Python<'p>, shape: &[usize]) -> PyResult<Bound<'p, PyArrayDyn<f32>>> {
    let numpy = py.import("numpy")?;
    Ok(numpy.call_method1("zeros", (shape, numpy.getattr("float32")?))?.cast_into::<PyArrayDyn<f32>>()?)
}

/// Returns the shape over which all of some shapes extend, as numpy extends them.
pub(crate) fn common<'s>(shapes: impl Iterator<Item = (&'s str, &'s [usize])>) -> PyResult<Vec<usize>> {
    let mut all: Vec<usize> = Vec::new();
    // What has a length, by axis.
    let mut owners: Vec<&str> = Vec::new();
    for (name, shape) in shapes {
        while all.len() < shape.len() {
            all.insert(0, 1);
            owners.insert(0, name);
        }
        let offset = all.len() - shape.len();
        for (axis, length) in shape.iter().enumerate() {
            let known = &mut all[offset + axis];
            if *known == 1 {
                *known = *length;
                owners[offset + axis] = name;
            } else if *length != 1 && length != known {
                let (known, owner) = (*known, owners[offset + axis]);
                return Err(PyValueError::new_err(format!(
                    "\"{name}\": found the shape {shape:?}, with a length of {length} where \"{owner}\" has {known}; expected \
                     shapes that fit, as those that numpy broadcasts"
                )));
            }
        }
    }
    Ok(all)
}

/// Samples of a shape that are shaded run by run: within a run, each channel's have one stride.
pub(crate) struct Runs {
    /// Lengths of the axes over which runs are repeated.
    outer: Vec<usize>,
    /// Number of samples of a run.
    pub(crate) length: usize,
    inputs: Vec<Strided>,
    outputs: Vec<Strided>,
}

// SAFETY: the pointers lead to arrays that the caller keeps alive, and are followed only by one thread at a time.
#[allow(unsafe_code)]
unsafe impl Send for Runs {}
// SAFETY: nothing is changed or followed through a shared reference.
#[allow(unsafe_code)]
unsafe impl Sync for Runs {}

impl Runs {
    /// Joins axes along which every channel goes on at its stride, from the last one on.
    pub(crate) fn new(shape: &[usize], inputs: Vec<Strided>, outputs: Vec<Strided>) -> Self {
        let mut runs = Self { outer: shape.to_vec(), length: 1, inputs, outputs };
        // Axes of one sample go nowhere.
        for axis in (0..shape.len()).rev().filter(|axis| shape[*axis] == 1) {
            runs.outer.remove(axis);
            runs.each(|strided| _ = strided.strides.remove(axis));
        }
        let Some(last) = runs.outer.pop() else {
            runs.each(|strided| strided.strides = vec![0]);
            return runs;
        };
        runs.length = last;
        while let Some(length) = runs.outer.last().copied() {
            let (axis, along) = (runs.outer.len() - 1, runs.length as isize);
            let mut all = runs.inputs.iter().chain(&runs.outputs);
            if !all.all(|strided| strided.strides[axis] == strided.strides[axis + 1] * along) {
                break;
            }
            runs.outer.pop();
            runs.length *= length;
            runs.each(|strided| _ = strided.strides.remove(axis));
        }
        runs
    }

    fn each(&mut self, mut change: impl FnMut(&mut Strided)) {
        self.inputs.iter_mut().chain(&mut self.outputs).for_each(&mut change);
    }

    /// Returns the number of runs.
    pub(crate) fn count(&self) -> usize {
        self.outer.iter().product()
    }

    /// Writes the channels of a run, from one of its samples on, to lists.
    pub(crate) fn run(&self, index: usize, from: usize, inputs: &mut Vec<Input>, outputs: &mut Vec<Output>) {
        let stride = |strided: &Strided| strided.strides.last().copied().unwrap_or_default();
        let start = |strided: &Strided| {
            let mut rest = index;
            let mut at = strided.first.wrapping_byte_offset(stride(strided) * from as isize);
            for (axis, length) in self.outer.iter().enumerate().rev() {
                at = at.wrapping_byte_offset(strided.strides[axis] * (rest % length) as isize);
                rest /= length;
            }
            at
        };
        inputs.clear();
        outputs.clear();
        inputs.extend(
            self.inputs.iter().map(|strided| Input { samples: start(strided).cast_const(), stride: stride(strided) }),
        );
        outputs.extend(self.outputs.iter().map(|strided| Output { samples: start(strided), stride: stride(strided) }));
    }
}
