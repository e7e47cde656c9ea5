//! Pictures.

use crate::arrays::zeros;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use trochoid::io::{PngImage, Samples, encode_png8};
use trochoid::{Format, Frame, Kind, WorkingSpace};

/// What was counted on a picture.
#[pyclass(frozen, get_all, module = "trochoid")]
pub(crate) struct Audit {
    /// Number of pixels.
    pixels: u64,
    /// Number of pixels that are judged, whether they are in the hull of the control colors: all of a color, none of an
    /// output that is no color.
    judged: u64,
    /// Number of judged pixels outside of the hull of the control colors.
    hull_exits: u64,
    /// Number of pixels with a value that is NaN.
    nan_count: u64,
    /// Number of control colors, which the output mixes: the different ones of the document, and of each input or file with
    /// colors the corners of the hull of its pixels; one if it is the same everywhere.
    control_count: usize,
}

#[pymethods]
impl Audit {
    fn __repr__(&self) -> String {
        let Self { pixels, judged, hull_exits, nan_count, control_count } = self;
        format!(
            "Audit(pixels={pixels}, judged={judged}, hull_exits={hull_exits}, nan_count={nan_count}, \
             control_count={control_count})"
        )
    }
}

/// What became of a node in a picture.
#[pyclass(frozen, get_all, module = "trochoid")]
pub(crate) struct Node {
    /// Its name.
    name: String,
    /// Its type.
    r#type: String,
    /// Whether it was computed, and if not, why.
    state: String,
    /// Time that it took, in seconds.
    seconds: f64,
}

#[pymethods]
impl Node {
    fn __repr__(&self) -> String {
        let Self { name, r#type, state, seconds } = self;
        format!("Node(name={name:?}, type={type:?}, state={state:?}, seconds={seconds:.6})")
    }
}

/// A picture, with what was counted on it. Notebooks show it.
#[pyclass(frozen, module = "trochoid")]
pub(crate) struct Picture {
    frame: Frame,
    space: WorkingSpace,
    format: Format,
}

impl Picture {
    pub(crate) fn new(frame: Frame, space: WorkingSpace, format: Format) -> PyResult<Self> {
        if frame.pictures.len() != 1 {
            return Err(PyValueError::new_err(format!("found {} pictures; expected one", frame.pictures.len())));
        }
        Ok(Self { frame, space, format })
    }

    fn only(&self) -> &trochoid::Picture {
        &self.frame.pictures[0]
    }
}

#[pymethods]
impl Picture {
    /// Returns the values as an array of rows, columns and, if there are several, channels: float32, in the working space of
    /// the document.
    fn numpy<'p>(&self, py: Python<'p>) -> PyResult<Bound<'p, PyArrayDyn<f32>>> {
        let picture = self.only();
        let channels = picture.planes.len();
        let mut shape = vec![self.format.height() as usize, self.format.width() as usize];
        if channels > 1 {
            shape.push(channels);
        }
        let array = zeros(py, &shape)?;
        {
            let mut write = array.try_readwrite().map_err(|error| PyValueError::new_err(error.to_string()))?;
            let pixels = write.as_slice_mut().map_err(|error| PyValueError::new_err(error.to_string()))?;
            for (channel, plane) in picture.planes.iter().enumerate() {
                let places = pixels.iter_mut().skip(channel).step_by(channels);
                places.zip(plane.samples()).for_each(|(to, from)| *to = *from);
            }
        }
        Ok(array)
    }

    /// For numpy.asarray.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'p>(
        &self,
        py: Python<'p>,
        dtype: Option<Bound<'p, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'p, PyAny>> {
        if copy == Some(false) {
            return Err(PyValueError::new_err("found copy=False; the values of a picture are always copied"));
        }
        let array = self.numpy(py)?.into_any();
        match dtype {
            Some(dtype) => array.call_method1("astype", (dtype,)),
            None => Ok(array),
        }
    }

    /// What was counted on it.
    #[getter]
    fn audit(&self) -> Audit {
        let picture = self.only();
        Audit {
            pixels: picture.audit.pixels,
            judged: picture.audit.judged,
            hull_exits: picture.audit.hull_exits,
            nan_count: picture.audit.nan_count,
            control_count: picture.control_count,
        }
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.format.width(), self.format.height())
    }

    /// Number of threads that it was made on.
    #[getter]
    fn threads(&self) -> usize {
        self.frame.threads
    }

    /// The nodes of the document, with what became of them.
    #[getter]
    fn nodes(&self) -> Vec<Node> {
        let node = |node: &trochoid::NodeReport| Node {
            name: node.name.clone(),
            r#type: node.ty.to_string(),
            state: node.state.name().to_string(),
            seconds: node.seconds,
        };
        self.frame.nodes.iter().map(node).collect()
    }

    /// Returns the picture as PNG of 8 bits, encoded for display. A field is shown from its least value, black, to its
    /// greatest.
    fn png<'p>(&self, py: Python<'p>) -> PyResult<Bound<'p, PyBytes>> {
        let bytes = py.detach(|| {
            let shown = self.shown();
            let channels: Vec<Samples<'_>> = shown.iter().map(|plane| Samples::contiguous(plane)).collect();
            let mut image = PngImage::new(self.format.width(), self.format.height(), channels);
            image.clamp = true;
            encode_png8(&image)
        });
        Ok(PyBytes::new(py, &bytes.map_err(|error| PyValueError::new_err(error.to_string()))?))
    }

    fn _repr_png_<'p>(&self, py: Python<'p>) -> PyResult<Bound<'p, PyBytes>> {
        self.png(py)
    }

    fn __repr__(&self) -> String {
        let [width, height] = [self.format.width(), self.format.height()];
        match self.only().audit {
            audit if audit.judged > 0 => {
                format!("Picture({width} x {height}, {} outside of the palette)", audit.hull_exits)
            }
            _ => format!("Picture({width} x {height})"),
        }
    }
}

impl Picture {
    /// Returns one or three channels as they are shown.
    fn shown(&self) -> Vec<Vec<f32>> {
        let picture = self.only();
        let mut shown: Vec<Vec<f32>> = picture.planes.iter().take(3).map(|plane| plane.samples().to_vec()).collect();
        if let (Kind::Color, [r, g, b]) = (picture.kind, &mut shown[..]) {
            for ((r, g), b) in r.iter_mut().zip(g).zip(b) {
                let color = self.space.to_display([*r, *g, *b].map(f64::from));
                [*r, *g, *b] = color.map(|value| value as f32);
            }
        }
        if matches!(picture.kind, Kind::Field(_)) {
            let finite = || shown.iter().flatten().copied().filter(|value| value.is_finite());
            let (low, high) = (finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max));
            let gain = if low < high { 1.0 / (f64::from(high) - f64::from(low)) } else { 0.0 };
            let share = |value: f32| ((f64::from(value) - f64::from(low)) * gain) as f32;
            shown.iter_mut().flatten().for_each(|value| *value = share(*value));
        }
        if shown.len() == 2 {
            shown.push(vec![0.0; shown[0].len()]);
        }
        for value in shown.iter_mut().flatten().filter(|value| value.is_nan()) {
            *value = 0.0;
        }
        shown
    }
}
