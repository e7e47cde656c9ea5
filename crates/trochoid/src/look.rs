//! Makes looks from documents.

use crate::asked::Asked;
use crate::load::{LoadError, Loaded, Parsed, document_of, list, parse_as, registry};
use crate::{Access, Diagnostic, Illegal, Look, PlanError, Registry, Settings};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why a look cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LookError {
    /// The document cannot be read or is invalid.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The document is sound, but has not what the look asks of it: every fault of its output, its inputs and the values
    /// that are set. One without a line is about what the look asks, and its `port` says where: `output`, or `inputs[1]`
    /// for the second input that is bound.
    #[error("{}", list(.0))]
    Asked(Vec<Diagnostic>),
    /// The output cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

impl LookError {
    /// Returns every fault, and the warnings beside them; none if a file cannot be read.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        match self {
            Self::Load(LoadError::Invalid(all)) | Self::Asked(all) => all,
            Self::Load(LoadError::Io(_)) | Self::Plan(_) => &[],
        }
    }
}

/// Makes a [`Look`] from a document: which output, with which inputs, at which frame.
///
/// ```
/// use trochoid::{LookBuilder, Samples, SamplesMut};
///
/// let document = r##"{
///   "trochoid": 1,
///   "palette": { "deep": "#274e53", "foam": "#ece6c2" },
///   "nodes": {
///     "light": { "type": "ScreenX" },
///     "water": { "type": "Mix", "a": "palette.deep", "b": "palette.foam", "weight": "light" }
///   },
///   "outputs": { "beauty": { "color": "water" } }
/// }"##;
/// let look = LookBuilder::new(document).bind("light").bind("palette.foam").build()?;
/// // On any thread:
/// let mut shader = look.shader()?;
/// let (light, foam, mut rgb) = ([0.0, 0.5, 1.0], [1.0, 0.9, 0.8], [0.0; 9]);
/// let [r, g, b] = foam.each_ref().map(Samples::uniform);
/// let (red, rest) = rgb.split_at_mut(3);
/// let (green, blue) = rest.split_at_mut(3);
/// shader.shade(3, &[Samples::new(&light), r, g, b], &mut [red, green, blue].map(SamplesMut::new))?;
/// assert_eq!([rgb[2], rgb[5], rgb[8]], foam);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LookBuilder {
    name: String,
    text: Arc<str>,
    folder: PathBuf,
    access: Option<Access>,
    allowed: Vec<PathBuf>,
    registry: &'static Registry,
    set: Vec<String>,
    output: Option<String>,
    inputs: Vec<String>,
    frame: i64,
    samples: Option<usize>,
    illegal: Illegal,
    settings: Settings,
}

impl LookBuilder {
    /// Begins with the text of a document, whose paths are relative to the current folder.
    pub fn new(text: impl Into<Arc<str>>) -> Self {
        Self {
            name: "look".into(),
            text: text.into(),
            folder: PathBuf::from("."),
            access: None,
            allowed: Vec::new(),
            registry: registry(),
            set: Vec::new(),
            output: None,
            inputs: Vec::new(),
            frame: 1,
            samples: None,
            illegal: Illegal::Refuse,
            settings: Settings::default(),
        }
    }

    /// Begins with a document in a file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        let text = document_of(path)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        Ok(Self::new(text).named(&path.display().to_string()).within(folder))
    }

    /// Sets the name by which messages call the document.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Sets the folder that the document's paths are relative to. Files in it may be read.
    #[must_use]
    pub fn within(self, folder: &Path) -> Self {
        Self { folder: folder.into(), ..self }
    }

    /// Sets which files the document may read and write, instead of those of [`load`](crate::load).
    #[must_use]
    pub fn with_access(self, access: Access) -> Self {
        Self { access: Some(access), ..self }
    }

    /// Lets the document read and write one more file, or all files in a folder.
    #[must_use]
    pub fn allow(mut self, path: &Path) -> Self {
        self.allowed.push(path.into());
        self
    }

    /// Sets the node types, for documents with some of your own: [`registry`](crate::registry)`().with(&MINE)`.
    #[must_use]
    pub fn with_registry(self, registry: &'static Registry) -> Self {
        Self { registry, ..self }
    }

    /// Names the output; a document with one output needs no name.
    #[must_use]
    pub fn output(self, name: &str) -> Self {
        Self { output: Some(name.into()), ..self }
    }

    /// Adds an input, for which you supply samples: a node by its name, or a color or number that changes from batch to
    /// batch. Those are a color of the palette, `palette.NAME`; a knob of the document that ports take as it is,
    /// `knobs.NAME`; or a literal at a port, `NODE.PORT`, such as `water.weight` or `water.stops[1].color`.
    #[must_use]
    pub fn bind(mut self, name: &str) -> Self {
        self.inputs.push(name.into());
        self
    }

    /// Sets a value of the document, such as `water.smooth=true`, `knobs.storm=0.5` or `palette.foam=#fff`, in the forms of
    /// [`load`](crate::load).
    #[must_use]
    pub fn set(mut self, assignment: &str) -> Self {
        self.set.push(assignment.into());
        self
    }

    /// Sets the frame, for documents with keys; 1 unless told.
    #[must_use]
    pub fn frame(self, frame: i64) -> Self {
        Self { frame, ..self }
    }

    /// Tells how many samples the look will shade in all, so that machine code is made only where it pays (from
    /// [`Settings::compile_from`] on). Unless told, it is made.
    #[must_use]
    pub fn expecting(self, samples: usize) -> Self {
        Self { samples: Some(samples), ..self }
    }

    /// Sets what happens to illegal samples; unless told, they are refused.
    #[must_use]
    pub fn illegal(self, illegal: Illegal) -> Self {
        Self { illegal, ..self }
    }

    /// Sets the number of threads that make a picture; 0, which it is unless told, takes all cores.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.settings.threads = threads;
        self
    }

    /// Sets how it is planned and run.
    #[must_use]
    pub fn settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }

    /// Loads the document. One without a format gets one of a single pixel.
    ///
    /// # Errors
    /// The document is invalid.
    pub fn load(&self) -> Result<Loaded, LoadError> {
        self.parsed()?.sound()
    }

    fn parsed(&self) -> Result<Parsed, LoadError> {
        let access = self.access.clone().unwrap_or_else(|| Access::usual(&self.folder));
        let access = self.allowed.iter().fold(access, |access, path| access.allowing(path));
        let Self { name, text, folder, set, registry, .. } = self;
        parse_as(name, text, folder, set, access, registry, Some([1, 1]))
    }

    /// Makes the look. It takes well under a millisecond for a small document, and a few tenths of one more for machine
    /// code.
    ///
    /// # Errors
    /// The document is invalid, or has not what the look asks of it: every fault.
    pub fn build(&self) -> Result<Look, LookError> {
        let Parsed { graph, mut faults, .. } = self.parsed()?;
        let Some(mut graph) = graph else { return Err(LoadError::Invalid(faults).into()) };
        let asked = Asked { output: self.output.as_deref(), inputs: &self.inputs, set: &self.set };
        let output = asked.of(&mut graph, &mut faults);
        let Some(output) = output.filter(|_| faults.is_empty()) else { return Err(LookError::Asked(faults)) };
        let mut settings = self.settings.clone();
        if self.samples.is_none_or(|samples| samples >= settings.compile_from) {
            settings.compile_from = 0;
        } else {
            settings.compile_from = usize::MAX;
        }
        let inputs: Vec<&str> = self.inputs.iter().map(String::as_str).collect();
        let look = Look::new(graph, &output, self.frame, &inputs, &settings);
        Ok(look.map_err(|error| asked.of_plan(&self.name, error))?.with_illegal(self.illegal))
    }
}
