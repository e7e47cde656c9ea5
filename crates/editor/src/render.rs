//! Renders the outputs of a range of frames to their files, on a separate thread.

use crate::document::edit::count;
use crate::state::Render;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, InputFiles, Miss, Monitor, OutputError, Plan, PlanError, RefusedFile,
    Settings, check_destinations, check_replaced, misses, output_files, refused_files, write_output,
};

/// A rendering in progress.
pub(crate) struct Renderer {
    shared: Arc<RunState>,
    total: usize,
    thread: Option<JoinHandle<Result<RunOutcome, RunError>>>,
}

/// Reason why rendering does not start.
#[derive(Debug)]
pub(crate) enum Obstacle {
    /// Files that the document has no permission to read or write.
    Refused(Vec<RefusedFile>),
    /// Any other reason, as a sentence.
    Because(Hindrance),
}

/// What else keeps a run from starting.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Hindrance {
    #[error("no output has a \"file\": add one, for example \"beauty.####.png\"")]
    NoFile,
    #[error("{}: is the document, or a file that it reads; give the output another", .0.display())]
    Input(PathBuf),
    #[error(transparent)]
    File(OutputError),
    #[error(transparent)]
    Thread(std::io::Error),
}

impl From<Hindrance> for Obstacle {
    fn from(why: Hindrance) -> Self {
        Self::Because(why)
    }
}

/// How a run ended that nothing hindered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RunOutcome {
    /// How many frames are done.
    frames: usize,
    /// Whether there were to be more.
    is_stopped: bool,
    /// Where their files are.
    folder: Option<PathBuf>,
}

impl fmt::Display for RunOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.is_stopped { "Stopped after" } else { "Rendered" };
        write!(f, "{what} {}", count(self.frames, "frame"))?;
        self.folder.as_ref().map_or(Ok(()), |folder| write!(f, " into {}", folder.display()))
    }
}

/// Why a run did not make what was asked for.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    #[error("Frame {frame}: {source}")]
    Frame { frame: i64, source: FrameError },
    /// All is written, and a picture misses what its output requires.
    #[error("Rendered {}, but {miss}", count(*frames, "frame"))]
    Missed { frames: usize, miss: Miss },
    #[error("the run ended unexpectedly")]
    Panicked,
}

/// Why a frame could not be made or written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameError {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Evaluate(#[from] EvalError),
    #[error(transparent)]
    Write(#[from] OutputError),
}

impl From<OutputError> for Obstacle {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Refused(refused) => Self::Refused(vec![*refused]),
            error => Self::Because(Hindrance::File(error)),
        }
    }
}

#[derive(Default)]
struct RunState {
    stop: AtomicBool,
    done: AtomicUsize,
    /// Progress of the current frame, in thousandths.
    share: AtomicU32,
    context: Mutex<Option<egui::Context>>,
}

impl RunState {
    fn wake(&self) {
        if let Some(context) = self.context.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
            context.request_repaint();
        }
    }
}

impl Monitor for RunState {
    fn progress(&self, done: usize, total: usize) {
        self.share.store((1000 * done / total.max(1)) as u32, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Renderer {
    /// Starts rendering these frames.
    ///
    /// # Errors
    /// Fails if no output has a file, or if a file cannot be written or accessed; nothing is evaluated then.
    pub(crate) fn start(graph: Arc<CheckedGraph>, range: (i64, i64), context: egui::Context) -> Result<Self, Obstacle> {
        let outputs: Vec<usize> =
            (0..graph.outputs().len()).filter(|&index| graph.outputs()[index].file.is_some()).collect();
        if outputs.is_empty() {
            return Err(Hindrance::NoFile.into());
        }
        let frames: Vec<i64> = (range.0..=range.1).collect();
        let mut named: Vec<PathBuf> = Vec::new();
        for &frame in &frames {
            let files = output_files(&graph, &outputs, frame, frames.len() > 1, None)?;
            named.extend(files.into_iter().map(|file| file.path));
        }
        let inputs = InputFiles::new(&graph, &[Path::new(graph.name())]);
        if let Some(path) = named.iter().find(|path| inputs.contains(path)) {
            return Err(Hindrance::Input(path.clone()).into());
        }
        let refused = refused_files(&graph, &outputs, &frames);
        if !refused.is_empty() {
            return Err(Obstacle::Refused(refused));
        }
        named.iter().try_for_each(|path| check_replaced(path, false))?;
        if let Some(fault) = check_destinations(named.iter().map(PathBuf::as_path)).into_iter().next() {
            return Err(fault.into());
        }
        let shared = Arc::new(RunState { context: Mutex::new(Some(context)), ..RunState::default() });
        let (theirs, total) = (shared.clone(), frames.len());
        let run = move || {
            let outcome = run(&graph, &outputs, &frames, &theirs);
            theirs.wake();
            outcome
        };
        let thread = std::thread::Builder::new().name("render".into()).spawn(run).map_err(Hindrance::Thread)?;
        Ok(Self { shared, total, thread: Some(thread) })
    }

    /// Stops rendering as soon as possible. Finished frames are kept.
    pub(crate) fn cancel(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Returns the progress.
    pub(crate) fn progress(&self) -> Render {
        Render {
            done: (self.shared.done.load(Ordering::Relaxed), self.total),
            share: self.shared.share.load(Ordering::Relaxed) as f32 / 1000.0,
        }
    }

    /// Returns the outcome once rendering has ended; later calls return `None`.
    pub(crate) fn outcome(&mut self) -> Option<Result<RunOutcome, RunError>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        Some(thread.join().unwrap_or_else(|_| Err(RunError::Panicked)))
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        self.cancel();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn run(graph: &CheckedGraph, outputs: &[usize], frames: &[i64], shared: &RunState) -> Result<RunOutcome, RunError> {
    let names: Vec<&str> = outputs.iter().map(|&index| graph.outputs()[index].name.as_str()).collect();
    // Checking the document has made sure that it has recipes.
    let with_recipes = graph.has_recipe(outputs).then(|| graph.clone().with_recipes(outputs).ok()).flatten();
    let graph = with_recipes.as_ref().unwrap_or(graph);
    let mut cache = Cache::new();
    let (mut missed, mut folder): (Option<Miss>, Option<PathBuf>) = (None, None);
    for (index, &frame) in frames.iter().enumerate() {
        let at = |source: FrameError| RunError::Frame { frame, source };
        let plan = Plan::new(graph, &names, frame, &[], &Settings::default()).map_err(|error| at(error.into()))?;
        let evaluated = match plan.evaluate(&Buffers::new(), &mut cache, shared) {
            Ok(evaluated) => evaluated,
            Err(EvalError::Cancelled) => return Ok(RunOutcome { frames: index, is_stopped: true, folder }),
            Err(error) => return Err(at(error.into())),
        };
        let files = output_files(graph, outputs, frame, frames.len() > 1, None).map_err(|error| at(error.into()))?;
        for file in &files {
            write_output(graph, &evaluated, file, &[]).map_err(|error| at(error.into()))?;
        }
        folder = files.first().and_then(|file| std::path::absolute(&file.path).ok()?.parent().map(Path::to_path_buf));
        missed = missed.or_else(|| misses(graph, &evaluated, None).into_iter().next());
        cache.forget_unused();
        shared.done.store(index + 1, Ordering::Relaxed);
        shared.share.store(0, Ordering::Relaxed);
        shared.wake();
    }
    match missed {
        None => Ok(RunOutcome { frames: frames.len(), is_stopped: false, folder }),
        Some(miss) => Err(RunError::Missed { frames: frames.len(), miss }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;

    #[test]
    fn a_run_that_is_stopped_says_where_its_files_are() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new.json");
        let text = crate::testing::RAMP.replace("1280", "32").replace("720", "18");
        std::fs::write(&file, text.replace("beauty.####.png", "made/beauty.####.png")).unwrap();
        std::fs::create_dir(folder.path().join("made")).unwrap();
        let graph = Session::open(&file).unwrap().meaning().graph.clone().unwrap();
        let mut renderer = Renderer::start(graph, (1, 50_000), egui::Context::default()).unwrap();
        let since = std::time::Instant::now();
        while renderer.progress().done.0 < 2 {
            assert!(since.elapsed().as_secs() < 60 && renderer.thread.is_some());
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        renderer.cancel();
        let outcome = loop {
            match renderer.outcome() {
                Some(outcome) => break outcome.unwrap(),
                None => std::thread::sleep(std::time::Duration::from_millis(1)),
            }
        };
        let made = std::fs::read_dir(folder.path().join("made")).unwrap().count();
        assert_eq!(
            outcome.to_string(),
            format!("Stopped after {made} frames into {}", folder.path().join("made").display())
        );
    }
}
