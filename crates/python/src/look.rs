//! Looks.

use crate::arrays::{Runs, Strided, common, zeros};
use crate::errors;
use crate::given::Given;
use crate::options::{Options, assigned, begun, dictionary, listed};
use crate::picture::Picture;
use crate::watch::watched;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use trochoid::{Cache, Format, Kind, LookBuilder, Samples, ShadeError};
use trochoid_foreign::{ForeignShader, Input, Output};

/// Samples that are shaded at once; in between, signals are answered.
const PIECE: usize = 1 << 16;
/// Time between two answers.
const PAUSE: Duration = Duration::from_millis(50);

/// An input of a look.
#[pyclass(frozen, get_all, module = "trochoid")]
pub(crate) struct Slot {
    /// Name by which samples are given.
    name: String,
    /// "color", "mask", "weights" or "field".
    kind: &'static str,
    /// Number of channels: 3 for a color, 1 for a mask.
    channels: usize,
    /// Whether the output depends on it; if not, it need not be given.
    is_used: bool,
}

#[pymethods]
impl Slot {
    fn __repr__(&self) -> String {
        let Self { name, kind, channels, is_used } = self;
        let is_used = if *is_used { "True" } else { "False" };
        format!("Slot(name={name:?}, kind={kind:?}, channels={channels}, is_used={is_used})")
    }
}

fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "color",
        Kind::Weights(2) => "mask",
        Kind::Weights(_) => "weights",
        _ => "field",
    }
}

/// One output of a document, with inputs of yours. It never changes, and any threads may use it.
///
/// The document is a text or a dictionary; `Look.load` reads one from a file.
///
/// - `inputs`: what you supply samples of: nodes by their names; colors of the palette, "palette.NAME"; knobs of the
///   document that ports take as they are, "knobs.NAME"; literals at ports, "NODE.PORT".
/// - `output`: its name; a document with one output needs none.
/// - `set`: values of the document to change, such as {"knobs.storm": 0.5, "palette.foam": "#fff"}.
/// - `frame`: for documents with keys.
/// - `folder`: what the document's paths are relative to; files in it may be read. The current folder, unless told.
/// - `name`: what messages call the document.
/// - `samples`: how many you will shade in all, so that machine code is made only where it pays. Unless told, it is made.
/// - `illegal`: "refuse" or "clamp" samples that their kind does not allow.
/// - `allow`: files, and folders with all that is in them, that the document may read besides its own folder.
/// - `threads`: how many make a picture; one on each core unless told. Samples are shaded on the caller's.
///
/// Raises InvalidDocument, or InvalidLook if the document is sound but has no such output or inputs.
///
///     >>> look = trochoid.Look(
///     ...     {
///     ...         "trochoid": 1,
///     ...         "nodes": {
///     ...             "light": {"type": "ScreenX"},
///     ...             "water": {"type": "Mix", "a": "#000000", "b": "#ffffff", "weight": "light"},
///     ...         },
///     ...         "outputs": {"beauty": {"color": "water"}},
///     ...     },
///     ...     inputs=["light"],
///     ... )
///     >>> look.shade({"light": 1.0})
///     array([1., 1., 1.], dtype=float32)
#[pyclass(frozen, module = "trochoid")]
pub(crate) struct Look {
    look: trochoid::Look,
    builder: LookBuilder,
    /// Names of the inputs.
    names: Vec<Py<PyString>>,
    /// Shaders that no thread uses now.
    idle: Mutex<Vec<ForeignShader>>,
    cache: Mutex<Cache>,
}

/// Why a batch ended early.
enum Stop {
    /// A sample is illegal; the index of the first of those that were shaded with it.
    Refused(ShadeError, usize),
    /// The handler of a signal raised something.
    Raised(PyErr),
}

impl Look {
    fn build(py: Python<'_>, builder: LookBuilder) -> PyResult<Self> {
        let look = py.detach(|| builder.build()).map_err(|error| errors::of_look(py, error))?;
        let names = look.slots().iter().map(|slot| PyString::new(py, &slot.name).unbind()).collect();
        Ok(Self { look, builder, names, idle: Mutex::default(), cache: Mutex::new(Cache::new()) })
    }

    /// Returns what is given for each input: `None` for one that is not used.
    fn given<'p>(&self, inputs: &Bound<'p, PyDict>) -> PyResult<Vec<Option<Given<'p>>>> {
        let slots = self.look.slots().iter().zip(&self.names);
        let mut known = 0;
        let given = slots.map(|(slot, name)| {
            let value = inputs.get_item(name)?;
            known += usize::from(value.is_some());
            match value {
                Some(value) if slot.is_used => Given::new(slot, &value).map(Some),
                None if slot.is_used => Err(PyValueError::new_err(format!(
                    "found no \"{}\"; expected samples of it, because the output depends on it",
                    slot.name
                ))),
                _ => Ok(None),
            }
        });
        let given: PyResult<Vec<Option<Given<'p>>>> = given.collect();
        // A name that is misspelled says more than one that is missing.
        if given.is_err() || known < inputs.len() {
            self.refuse_unknown(inputs)?;
        }
        given
    }

    fn refuse_unknown(&self, inputs: &Bound<'_, PyDict>) -> PyResult<()> {
        for name in inputs.keys() {
            let name: String = name.extract()?;
            if self.look.slot(&name).is_none() {
                let known: Vec<&str> = self.look.slots().iter().map(|slot| slot.name.as_str()).collect();
                let remedy = match (trochoid::nearest(&name, known.iter().copied()), &known[..]) {
                    (Some(near), _) => format!("did you mean \"{near}\"?"),
                    (None, []) => "the look has none".into(),
                    (None, _) => format!("expected one of {}", known.join(", ")),
                };
                return Err(PyValueError::new_err(format!("found \"{name}\", which is no input: {remedy}")));
            }
        }
        Ok(())
    }

    /// Returns the common shape of what is given.
    fn shape(&self, given: &[Option<Given<'_>>]) -> PyResult<Vec<usize>> {
        let slots = self.look.slots().iter().zip(given);
        common(slots.filter_map(|(slot, given)| Some((slot.name.as_str(), given.as_ref()?.shape()))))
    }

    /// Returns the channels of all inputs over a shape.
    fn all_channels(&self, given: &[Option<Given<'_>>], shape: &[usize]) -> Vec<Strided> {
        let of = |(slot, given): (&trochoid::Slot, &Option<Given<'_>>)| match given {
            Some(given) => given.channels(shape),
            None => (0..slot.channels())
                .map(|_| Strided { first: std::ptr::null_mut(), strides: vec![0; shape.len()] })
                .collect(),
        };
        self.look.slots().iter().zip(given).flat_map(of).collect()
    }

    fn shader(&self, py: Python<'_>) -> PyResult<ForeignShader> {
        if let Some(idle) = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop() {
            return Ok(idle);
        }
        let shader = self.look.shader().map_err(|error| errors::of_shader(py, &error))?;
        Ok(ForeignShader::new(shader))
    }

    /// Shades all runs, and answers signals.
    ///
    /// # Safety
    /// The runs' pointers lead to as many samples, which stay, and which nothing else writes meanwhile.
    #[allow(unsafe_code)]
    unsafe fn shade_runs(shader: &mut ForeignShader, runs: &Runs) -> Result<(), Stop> {
        let (mut inputs, mut outputs): (Vec<Input>, Vec<Output>) = (Vec::new(), Vec::new());
        let (mut since, mut answered) = (0, Instant::now());
        for index in 0..runs.count() {
            for from in (0..runs.length).step_by(PIECE) {
                let count = PIECE.min(runs.length - from);
                runs.run(index, from, &mut inputs, &mut outputs);
                // SAFETY: the caller's promise.
                let done = unsafe { shader.shade(count, &inputs, &outputs) };
                done.map_err(|error| Stop::Refused(error, index * runs.length + from))?;
                since += count;
                if since >= PIECE && answered.elapsed() >= PAUSE {
                    Python::attach(|py| py.check_signals()).map_err(Stop::Raised)?;
                    (since, answered) = (0, Instant::now());
                }
            }
        }
        Ok(())
    }
}

#[pymethods]
impl Look {
    #[new]
    #[pyo3(signature = (document, *, inputs=vec![], output=None, set=None, frame=1, folder=None, name=None, samples=None, illegal="refuse", allow=vec![], threads=None))]
    #[expect(clippy::too_many_arguments, reason = "arguments by name")]
    fn new<'p>(
        document: &Bound<'p, PyAny>,
        #[pyo3(from_py_with = listed)] inputs: Vec<String>,
        output: Option<&str>,
        set: Option<Bound<'p, PyAny>>,
        frame: i64,
        folder: Option<PathBuf>,
        name: Option<&str>,
        samples: Option<usize>,
        illegal: &str,
        #[pyo3(from_py_with = listed)] allow: Vec<PathBuf>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let options = Options { output, inputs, set: set.as_ref(), frame, samples, illegal, allow, threads };
        Self::build(document.py(), options.apply(begun(document, folder, name)?)?)
    }

    /// Makes a look of a document in a file, with the arguments of Look.
    ///
    /// Raises InvalidDocument, InvalidLook, and OSError if the file cannot be read.
    ///
    ///     look = trochoid.Look.load("water.json", inputs=["light", "palette.mist"])
    #[staticmethod]
    #[pyo3(signature = (path, *, inputs=vec![], output=None, set=None, frame=1, samples=None, illegal="refuse", allow=vec![], threads=None))]
    #[expect(clippy::too_many_arguments, reason = "arguments by name")]
    fn load<'p>(
        py: Python<'p>,
        path: PathBuf,
        #[pyo3(from_py_with = listed)] inputs: Vec<String>,
        output: Option<&str>,
        set: Option<Bound<'p, PyAny>>,
        frame: i64,
        samples: Option<usize>,
        illegal: &str,
        #[pyo3(from_py_with = listed)] allow: Vec<PathBuf>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let builder = LookBuilder::open(&path).map_err(|error| errors::of_load(py, error))?;
        let options = Options { output, inputs, set: set.as_ref(), frame, samples, illegal, allow, threads };
        Self::build(py, options.apply(builder)?)
    }

    /// Returns a look of the same document with further values set, at a frame; at the same one unless told.
    ///
    ///     night = look.replace(set={"palette.deep": "#101a33"}, frame=36)
    #[pyo3(signature = (*, set=None, frame=None))]
    fn replace(&self, py: Python<'_>, set: Option<Bound<'_, PyAny>>, frame: Option<i64>) -> PyResult<Self> {
        let builder = assigned(self.builder.clone(), set.as_ref())?;
        Self::build(py, builder.frame(frame.unwrap_or(self.look.frame())))
    }

    /// The inputs, in the order in which they were named.
    #[getter]
    fn slots(&self) -> Vec<Slot> {
        let slot = |slot: &trochoid::Slot| Slot {
            name: slot.name.clone(),
            kind: word(slot.kind),
            channels: slot.channels(),
            is_used: slot.is_used,
        };
        self.look.slots().iter().map(slot).collect()
    }

    /// Name of the output.
    #[getter]
    fn output(&self) -> &str {
        self.look.output()
    }

    /// Kind of the output: "color", "mask", "weights" or "field".
    #[getter]
    fn kind(&self) -> &'static str {
        word(self.look.kind())
    }

    /// Number of channels of the output: 3 for a color.
    #[getter]
    fn channels(&self) -> usize {
        self.look.channels()
    }

    /// The frame.
    #[getter]
    fn frame(&self) -> i64 {
        self.look.frame()
    }

    fn __repr__(&self) -> String {
        let names: Vec<&str> = self.look.slots().iter().map(|slot| slot.name.as_str()).collect();
        format!("Look(output={:?}, inputs={names:?})", self.look.output())
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err(
            "a Look cannot be pickled, for it has machine code: make it anew in each process, of the same document by Look or \
             Look.load",
        ))
    }

    /// Shades samples.
    ///
    /// Each input is an array, a number for all samples, or a tuple with a number for each channel; the channels of a color
    /// are the last axis. Arrays of float32 are read where they are, whatever their strides; others are converted. All are
    /// extended to a common shape, as numpy does. Returns a float32 array of that shape, with the channels of the output as
    /// its last axis if it has several, in the working space of the document; or writes to `out`, which may have any strides
    /// and may be one of the inputs.
    ///
    /// Other threads run meanwhile; none may write to the arrays. Raises NotPointwise, and IllegalSample; then
    /// what is in `out` is undefined.
    ///
    ///     rgb = look.shade({"light": light, "rim": 0.5, "palette.mist": (0.25, 0.5, 0.75)})
    #[pyo3(signature = (inputs, out=None))]
    fn shade<'p>(
        &self,
        py: Python<'p>,
        inputs: &Bound<'p, PyAny>,
        out: Option<Bound<'p, PyAny>>,
    ) -> PyResult<Bound<'p, PyArrayDyn<f32>>> {
        let out = out.map(|out| {
            out.cast_into::<PyArrayDyn<f32>>().map_err(|error| {
                let found = error.into_inner();
                let found = match found.getattr("dtype") {
                    Ok(dtype) => format!("an array of {dtype}"),
                    Err(_) => found.get_type().to_string(),
                };
                PyTypeError::new_err(format!("out: found {found}; expected an array of float32"))
            })
        });
        let out = out.transpose()?;
        let mut given = self.given(&dictionary("inputs", inputs)?)?;
        let shape = self.shape(&given)?;
        let channels = self.look.channels();
        let mut full = shape.clone();
        if channels > 1 {
            full.push(channels);
        }
        let is_own = out.is_none();
        let out = match out {
            None => zeros(py, &full)?,
            Some(out) if out.shape() == full => {
                let writable: bool = out.getattr("flags")?.getattr("writeable")?.extract()?;
                if !writable {
                    return Err(PyValueError::new_err("out: found a read-only array; expected one to write to"));
                }
                out
            }
            Some(out) => {
                let found = out.shape();
                return Err(PyValueError::new_err(format!("out: found the shape {found:?}; expected {full:?}")));
            }
        };
        let strides = out.strides();
        let step = if channels > 1 { strides[shape.len()] } else { 0 };
        let outputs: Vec<Strided> = (0..channels)
            .map(|channel| Strided {
                first: out.data().wrapping_byte_offset(step * channel as isize),
                strides: strides[..shape.len()].to_vec(),
            })
            .collect();
        if !is_own {
            given.iter_mut().flatten().try_for_each(|given| given.apart_from(&outputs, &shape))?;
        }
        let runs = Runs::new(&shape, self.all_channels(&given, &shape), outputs);
        if runs.length == 0 || runs.count() == 0 {
            return Ok(out);
        }
        let mut shader = self.shader(py)?;
        // SAFETY: the arrays are kept alive by `given` and `out`, and have these samples by their shapes and strides. No
        // reference to them is made unless nothing overlaps. The documentation forbids to write to them meanwhile.
        #[allow(unsafe_code)]
        let done = py.detach(|| unsafe { Self::shade_runs(&mut shader, &runs) });
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(shader);
        match done {
            Ok(()) => Ok(out),
            Err(Stop::Refused(error, first)) => Err(errors::of_shade(py, error, first)),
            Err(Stop::Raised(error)) => Err(error),
        }
    }

    /// Makes a picture; filters and nodes that make passes of their own work, too.
    ///
    /// Inputs are as for `shade`, with rows and columns as their axes. `size`, (width, height), is needed only if they do
    /// not tell it. `samples`, 1, 4 or 16, are averaged in each pixel, as in a document's format: inputs are the same for all of
    /// them, passes that nodes make are not. `progress(done, total)` is called now and then; if it returns False, the work stops and Cancelled is
    /// raised. Ctrl-C stops it, too.
    ///
    ///     picture = look.picture({"light": passes[..., 0], "rim": passes[..., 1], "palette.mist": (0.25, 0.5, 0.75)})
    #[pyo3(signature = (inputs=None, *, size=None, samples=1, progress=None))]
    fn picture<'p>(
        &self,
        py: Python<'p>,
        inputs: Option<Bound<'p, PyAny>>,
        size: Option<(u32, u32)>,
        samples: u32,
        progress: Option<Bound<'p, PyAny>>,
    ) -> PyResult<Picture> {
        let inputs = inputs.map_or_else(|| Ok(PyDict::new(py)), |inputs| dictionary("inputs", &inputs))?;
        let given = self.given(&inputs)?;
        let shape = self.shape(&given)?;
        let (width, height) = match (size, &shape[..]) {
            (Some(size), _) => size,
            (None, &[height, width]) => match (u32::try_from(width), u32::try_from(height)) {
                (Ok(width), Ok(height)) => (width, height),
                _ => {
                    return Err(PyValueError::new_err(format!(
                        "found inputs of the shape {shape:?}; expected a picture"
                    )));
                }
            },
            (None, _) => {
                return Err(PyValueError::new_err(format!(
                    "found inputs of the shape {shape:?}; expected rows and columns, or a size=(width, height)"
                )));
            }
        };
        let whole = vec![height as usize, width as usize];
        let all = common([("inputs", &shape[..]), ("size", &whole[..])].into_iter());
        if !all.is_ok_and(|all| all == whole) {
            return Err(PyValueError::new_err(format!(
                "found inputs of the shape {shape:?}, rows by columns; expected {whole:?}, as the size of {width} x {height} has"
            )));
        }
        let format = Format::new(width, height, samples).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let channels = self.all_channels(&given, &whole);
        let is_uniform: Vec<bool> = channels.iter().map(Strided::is_uniform).collect();
        // The picture copies uniform channels, while the copies made here are still there.
        let copied = channels.iter().filter(|channel| !channel.first.is_null()).count();
        self.look.check_memory(format, copied).map_err(|error| errors::of_picture(py, error))?;
        let shapes = is_uniform.iter().map(|is_uniform| if *is_uniform { vec![1, 1] } else { whole.clone() });
        let planes: Vec<Vec<f32>> =
            channels.into_iter().zip(shapes).map(|(channel, shape)| plane(&shape, channel)).collect();
        let passes = planes.iter().zip(is_uniform).map(|(plane, is_uniform)| match &plane[..] {
            [value] if is_uniform => Samples::uniform(value),
            plane => Samples::new(plane),
        });
        let passes: Vec<Samples<'_>> = passes.collect();
        let made = watched(py, progress.as_ref(), |watch| {
            let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
            let made = self.look.picture(format, &passes, &mut cache, &**watch);
            cache.forget_unused();
            made
        })?;
        let frame = made.map_err(|error| errors::of_picture(py, error))?;
        Picture::new(frame, self.look.graph().space(), format)
    }
}

/// Copies a channel over a shape; none if there is no channel.
fn plane(shape: &[usize], channel: Strided) -> Vec<f32> {
    let mut plane = Vec::new();
    if channel.first.is_null() {
        return plane;
    }
    let runs = Runs::new(shape, vec![channel], Vec::new());
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for index in 0..runs.count() {
        runs.run(index, 0, &mut inputs, &mut outputs);
        // SAFETY: the caller keeps the array alive, and it has these samples.
        #[allow(unsafe_code)]
        plane.extend(unsafe { inputs[0].copied(runs.length) });
    }
    plane
}
