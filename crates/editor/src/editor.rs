//! The editor: what is asked for is done here, and what is evaluated comes back here. It draws nothing itself.

use crate::actions::Action;
use crate::canvas::Canvas;
use crate::document::keep::{Keeper, Kept, kept};
use crate::document::{Edit, Session, edit};
use crate::evaluate::{Job, News, Question, Subject, Worker};
use crate::layout::{self, Pane};
use crate::prompts::Prompts;
use crate::properties::Properties;
use crate::render::Renderer;
use crate::report::Report;
use crate::source::Source;
use crate::state::{Past, State};
use crate::timeline::Timeline;
use crate::viewer::Viewer;
use crate::watch::Watcher;
use crate::waves::Waves;
use egui::{Context, Ui};
use egui_notify::Toasts;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The editor of one document.
pub struct Editor {
    pub(crate) state: State,
    pub(crate) tree: egui_tiles::Tree<Pane>,
    pub(crate) panels: Panels,
    pub(crate) prompts: Prompts,
    pub(crate) toasts: Toasts,
    pub(crate) recent: Vec<PathBuf>,
    worker: Worker,
    asked: Asked,
    keeper: Option<Keeper>,
    /// The revision that is kept, and when the first change since was made.
    kept: (u64, Option<Instant>),
    watcher: Watcher,
    renderer: Option<Renderer>,
    /// Since when, and from which frame, pictures follow each other.
    clock: Option<(Instant, i64)>,
    closing: bool,
}

/// What panels hold besides what all see.
#[derive(Default)]
pub(crate) struct Panels {
    pub(crate) canvas: Canvas,
    pub(crate) viewer: Viewer,
    pub(crate) properties: Properties,
    pub(crate) timeline: Timeline,
    pub(crate) waves: Waves,
    pub(crate) report: Report,
    pub(crate) source: Source,
}

/// What was asked of the worker last.
#[derive(Default)]
struct Asked {
    generation: u64,
    what: Option<What>,
    display: crate::evaluate::Display,
    thumbnails: u64,
    ahead: Option<(u64, i64)>,
    /// Picture, frame and place.
    blame: Option<(u64, i64, [f32; 2])>,
}

/// What a picture is of: revision, node, output, frame, proxy, region.
type What = (u64, String, usize, i64, u32, Option<[f32; 4]>);

/// Most memory for pictures of frames, bytes.
const FRAMES: usize = 2 << 30;

impl Editor {
    /// An editor of a document. `data` is where copies of unsaved work and the list of recent files are kept; nowhere if
    /// `None`.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(context: &Context, session: Session, data: Option<&Path>) -> std::io::Result<Self> {
        crate::theme::install(context);
        let wake = context.clone();
        let worker = Worker::new(move || wake.request_repaint())?;
        let folder = data.map(|data| data.join("unsaved"));
        let orphans = folder.as_deref().map(kept).unwrap_or_default();
        let keeper = folder.as_deref().and_then(|folder| Keeper::new(folder).ok());
        let recent = data.map(crate::recent::read).unwrap_or_default();
        let mut editor = Self {
            tree: layout::first(),
            panels: Panels::default(),
            prompts: Prompts::new(data),
            toasts: Toasts::default(),
            recent,
            worker,
            asked: Asked::default(),
            keeper,
            kept: (session.revision(), None),
            watcher: Watcher::default(),
            renderer: None,
            clock: None,
            closing: false,
            state: State::new(session),
        };
        editor.opened(context);
        if !orphans.is_empty() {
            editor.prompts.recover(orphans);
        }
        Ok(editor)
    }

    /// What is open, chosen and seen.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        let changed = if self.state.session.is_changed() { "● " } else { "" };
        format!("{changed}{} — Trochoid", self.state.session.title())
    }

    /// Whether the window may close now.
    pub fn is_closing(&self) -> bool {
        self.closing
    }

    /// Asks to close the window: at once, or after a question about unsaved changes.
    pub fn close(&mut self, context: &Context) {
        self.act(Action::Quit, context);
    }

    /// Draws everything, and does what was asked for.
    pub fn ui(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        self.hear(&context);
        let mut actions = Vec::new();
        if !self.prompts.is_open() {
            crate::commands::pressed(&context, &self.state, &mut actions);
        }
        crate::window::window_ui(self, ui, &mut actions);
        for action in actions {
            self.act(action, &context);
        }
        self.keep(&context);
        self.play(&context);
        self.ask();
        self.ask_blame();
    }

    fn opened(&mut self, context: &Context) {
        self.watcher.watch(self.state.session.file(), context);
        if let (Some(file), Some(data)) = (self.state.session.file(), self.prompts.data()) {
            self.recent = crate::recent::add(data, file);
        }
        self.panels.canvas = Canvas::default();
        self.asked.what = None;
        self.asked.thumbnails = 0;
        context.request_repaint();
    }

    fn start(&mut self, session: Session, context: &Context) {
        self.worker.stop();
        if let Some(keeper) = &self.keeper {
            keeper.forget();
        }
        self.kept = (session.revision(), None);
        self.state = State::new(session);
        self.opened(context);
    }

    /// Does what was asked for.
    pub fn act(&mut self, action: Action, context: &Context) {
        let state = &mut self.state;
        let names: Vec<String> = state.selection.iter().cloned().collect();
        let sheet = state.sheet().clone();
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::Seal => state.session.seal(),
            Action::Rewrite(text) => {
                state.session.replace(&text, "Edit the text");
                self.changed();
            }
            Action::Undo => {
                if let Some(label) = state.session.undo() {
                    self.toasts.basic(format!("Undone: {label}")).duration(Some(Duration::from_millis(1500)));
                    self.changed();
                }
            }
            Action::Redo => {
                if let Some(label) = state.session.redo() {
                    self.toasts.basic(format!("Redone: {label}")).duration(Some(Duration::from_millis(1500)));
                    self.changed();
                }
            }
            Action::Select(names) => state.selection = names,
            Action::Look(node, output) => state.look.node = Some((node, output)),
            Action::Slot(slot) => {
                if let Some(name) = state.chosen().map(String::from) {
                    state.look.slots[slot] = Some(name);
                }
                if let Some(name) = state.look.slots[slot].clone().filter(|name| sheet.find(name).is_some()) {
                    state.look.node = Some((name, 0));
                }
            }
            Action::Display(display) => state.look.display = display,
            Action::Proxy(proxy) => state.look.proxy = proxy.clamp(1, 8),
            Action::Region(region) => state.look.region = region,
            Action::Pick(pick) => state.look.pick = pick,
            Action::Dropper(place) => state.dropper = place,
            Action::Frame(frame) => {
                state.frame = frame.clamp(-10_000_000, 10_000_000);
                self.clock = None;
            }
            Action::Play(playing) => {
                state.playing = playing;
                self.clock = None;
            }
            Action::Range(first, last) => state.range = (first.min(last), first.max(last)),
            Action::New => self.leave(After::New, context),
            Action::Open => self.leave(After::Ask, context),
            Action::OpenFile(file) => self.leave(After::Open(file), context),
            Action::Quit => self.leave(After::Close, context),
            Action::Save => match state.session.file().map(Path::to_path_buf) {
                Some(file) => self.save(&file),
                None => self.prompts.ask_save(&state.session, None),
            },
            Action::SaveAs => self.prompts.ask_save(&state.session, None),
            Action::Reload => match state.session.reload() {
                Ok(()) => self.changed(),
                Err(error) => {
                    self.toasts.error(error);
                }
            },
            Action::Copy | Action::Cut => {
                context.copy_text(edit::copied(&crate::canvas::placed(&sheet), &names));
                if action == Action::Cut {
                    self.edit(edit::deleted(&sheet, &names));
                }
            }
            Action::Paste(text, at) => match edit::pasted(&sheet, &text, at) {
                Some((edit, names)) => {
                    self.edit(crate::canvas::freezing(&sheet, edit));
                    self.state.selection = names.into_iter().collect();
                }
                None => {
                    self.toasts.warning("The clipboard holds no nodes: copy some from a graph, or their JSON");
                }
            },
            Action::Duplicate => {
                let sheet = crate::canvas::placed(&sheet);
                let text = edit::copied(&sheet, &names);
                let corner = names.iter().filter_map(|name| sheet.node(name)).map(|node| node.at);
                let corner = corner.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]).unwrap_or_default();
                self.act(Action::Paste(text, [corner[0] + 40.0, corner[1] + 40.0]), context);
            }
            Action::Delete => {
                self.panels.canvas.forget_cursor();
                self.edit(edit::deleted(&sheet, &names));
                self.state.selection.clear();
            }
            Action::Disable => self.edit(edit::disabled(&sheet, &names)),
            Action::SelectAll => state.selection = sheet.nodes.iter().map(|node| node.name.clone()).collect(),
            Action::Arrange => {
                let places = crate::canvas::arrange(&sheet, &state.selection);
                self.edit(edit::laid_out(&sheet, &places));
            }
            Action::Backdrop => {
                if let Some(edit) = crate::canvas::backdrop(&sheet, &state.selection) {
                    self.edit(edit);
                }
            }
            Action::Frames => self.panels.canvas.frame(),
            Action::AddNode => self.panels.canvas.search(),
            Action::Render => self.render(context),
            Action::CancelRender => {
                if let Some(renderer) = &self.renderer {
                    renderer.cancel();
                }
            }
            Action::Palette => self.prompts.palette(),
            Action::Panel(pane) => layout::bring(&mut self.tree, pane),
            Action::ResetPanels => self.tree = layout::first(),
            Action::Theme => {
                let dark = context.theme() == egui::Theme::Dark;
                context.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
            Action::Notice(text) => {
                self.toasts.info(text);
            }
        }
    }

    fn edit(&mut self, edit: Edit) {
        if !self.state.session.meaning().readable {
            self.toasts.error("The text is not JSON: correct it in the panel \"Text\" first");
            return;
        }
        match self.state.session.edit(edit) {
            Ok(()) => self.changed(),
            Err(error) => {
                self.toasts.error(error.to_string());
            }
        }
    }

    /// What follows from a change of the document.
    fn changed(&mut self) {
        let sheet = self.state.session.sheet().clone();
        self.state.selection.retain(|name| sheet.find(name).is_some());
        self.state.seen.frames.clear();
        self.asked.ahead = None;
        if self.state.look.node.as_ref().is_some_and(|(name, _)| sheet.find(name).is_none()) {
            self.state.look.node = State::first_output(&sheet);
        }
    }

    /// Leaves this document for something else, unless there is unsaved work: then a question comes first.
    fn leave(&mut self, after: After, context: &Context) {
        if self.state.session.is_changed() {
            self.prompts.unsaved(after);
        } else {
            self.go(after, context);
        }
    }

    /// Goes on to something else, whatever is unsaved.
    pub(crate) fn go(&mut self, after: After, context: &Context) {
        match after {
            After::New => self.start(Session::new(crate::document::session::NEW.into(), None), context),
            After::Ask => self.prompts.ask_open(&self.state.session),
            After::Open(file) => match Session::open(&file) {
                Ok(session) => self.start(session, context),
                Err(error) => {
                    self.toasts.error(error);
                }
            },
            After::Close => {
                self.closing = true;
                context.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// Saves to a file; whether it worked.
    pub(crate) fn save(&mut self, file: &Path) {
        // The watcher tells of this write too; it is what we know already then.
        match self.state.session.save(file) {
            Ok(()) => {
                self.toasts.success(format!("Saved {}", file.display())).duration(Some(Duration::from_millis(1500)));
                if let Some(data) = self.prompts.data() {
                    self.recent = crate::recent::add(data, file);
                }
            }
            Err(error) => {
                self.toasts.error(error).duration(None);
            }
        }
    }

    /// Takes what was kept of an editor that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: &Kept, context: &Context) {
        let session = kept.file.as_deref().and_then(|file| Session::open(file).ok());
        let mut session = session.unwrap_or_else(|| Session::new(String::new(), kept.file.clone()));
        session.recover(&kept.text);
        self.start(session, context);
        // It is not in the file yet, so it is kept again before the old copy goes.
        if let Some(keeper) = &self.keeper {
            keeper.keep(self.state.session.file(), self.state.session.text());
        }
        crate::document::keep::discard(kept);
    }

    /// Keeps a copy of unsaved work within a second of a change.
    fn keep(&mut self, context: &Context) {
        let session = &self.state.session;
        let Some(keeper) = &self.keeper else { return };
        if session.revision() == self.kept.0 {
            return;
        }
        if !session.is_changed() {
            keeper.forget();
            self.kept = (session.revision(), None);
            return;
        }
        let since = *self.kept.1.get_or_insert_with(Instant::now);
        match crate::document::keep::AFTER.checked_sub(since.elapsed()) {
            Some(left) if !left.is_zero() => context.request_repaint_after(left),
            _ => {
                keeper.keep(session.file(), session.text());
                self.kept = (session.revision(), None);
            }
        }
    }

    /// Goes to the frame that belongs to the time, as far as pictures are there.
    fn play(&mut self, context: &Context) {
        let state = &mut self.state;
        if !state.playing {
            return;
        }
        let (first, last) = state.range;
        let fps = state.sheet().frames.2;
        let (since, from) = *self.clock.get_or_insert((Instant::now(), state.frame.clamp(first, last)));
        let count = last - first + 1;
        let due = from + (since.elapsed().as_secs_f64() * fps) as i64;
        let due = first + (due - first).rem_euclid(count);
        let next = if state.frame >= last { first } else { state.frame + 1 };
        if due != state.frame {
            if state.seen.frames.contains_key(&due) {
                state.frame = due;
            } else {
                // What is not there yet is waited for: every frame is shown once.
                self.clock = Some((Instant::now(), next));
                state.frame = next;
            }
        }
        if state.seen.frames.contains_key(&state.frame) {
            context.request_repaint_after(Duration::from_secs_f64(0.5 / fps));
        }
    }

    /// What the viewer should show.
    fn subject(&self) -> Option<Subject> {
        let (name, output) = self.state.look.node.as_ref()?;
        let sheet = self.state.sheet().clone();
        let node = sheet.find(name)?;
        let output = (*output).min(sheet.nodes[node].makes.len().saturating_sub(1));
        let session = &self.state.session;
        Some(Subject {
            sheet,
            revision: session.revision(),
            node,
            output,
            name: session.name(),
            folder: session.folder(),
        })
    }

    /// Asks the worker for what is not there yet.
    fn ask(&mut self) {
        let Some(subject) = self.subject() else {
            if self.asked.what.take().is_some() {
                self.worker.stop();
                self.state.seen.result = None;
                self.state.seen.progress = None;
            }
            return;
        };
        let look = &self.state.look;
        let name = subject.sheet.nodes[subject.node].name.clone();
        let what = (subject.revision, name, subject.output, self.state.frame, look.proxy, look.region);
        let job = |generation: u64, frame: i64, progressive: bool| Job {
            generation,
            subject: subject.clone(),
            frame,
            proxy: look.proxy,
            region: look.region,
            display: look.display,
            progressive,
        };
        if self.asked.what.as_ref() != Some(&what) {
            let same_but_frame =
                self.asked.what.as_ref().is_some_and(|old| {
                    (old.0, &old.1, old.2, old.4, old.5) == (what.0, &what.1, what.2, what.4, what.5)
                });
            if !same_but_frame {
                self.state.seen.frames.clear();
            }
            self.asked.generation += 1;
            self.asked.what = Some(what);
            self.asked.display = look.display;
            match self.state.seen.frames.get(&self.state.frame).filter(|seen| seen.display == look.display) {
                Some(ready) => {
                    self.state.seen.result = Some(ready.clone());
                    self.state.seen.failed = None;
                    self.state.seen.progress = None;
                }
                None => {
                    self.worker.evaluate(job(self.asked.generation, self.state.frame, !self.state.playing));
                    self.state.seen.progress = Some(0.0);
                    self.asked.ahead = None;
                    self.asked.blame = None;
                }
            }
        } else if self.asked.display != look.display {
            self.asked.display = look.display;
            self.state.seen.frames.clear();
            if let Some(result) = &self.state.seen.result {
                let space = result.lens.graph.space();
                self.worker.show(self.asked.generation, result.picture.clone(), space, look.display);
            }
        }
        if self.state.seen.progress.is_some() {
            return;
        }
        let revision = subject.revision;
        if self.asked.thumbnails != revision && !self.state.playing {
            self.asked.thumbnails = revision;
            self.worker.thumbnails(subject.clone(), self.state.frame);
        }
        // Once there is nothing else to do, the frames that come next.
        if self.state.playing && self.asked.ahead != Some((revision, self.state.frame)) {
            self.asked.ahead = Some((revision, self.state.frame));
            let (first, last) = self.state.range;
            let count = (last - first + 1).min(64);
            let next = (1..count).map(|step| first + (self.state.frame - first + step).rem_euclid(last - first + 1));
            let missing = next.filter(|frame| !self.state.seen.frames.contains_key(frame)).take(8);
            let jobs: Vec<Job> = missing.map(|frame| job(self.asked.generation, frame, false)).collect();
            self.worker.ahead(jobs);
        }
    }

    /// Asks what the pixel that is inspected is made of, once its picture is finished.
    fn ask_blame(&mut self) {
        let Some(at) = self.state.look.pick else {
            self.asked.blame = None;
            self.state.seen.blame = None;
            return;
        };
        let result = self.state.seen.result.as_ref();
        let Some(result) = result.filter(|result| result.finished && self.state.seen.progress.is_none()) else {
            return;
        };
        let what = Some((result.generation, result.frame, at));
        if result.picture.kind == trochoid::Kind::Color && self.asked.blame != what && !self.state.playing {
            self.asked.blame = what;
            self.worker.blame(Question {
                generation: result.generation,
                subject: result.subject.clone(),
                frame: result.frame,
                shrunk: result.shrunk,
                at,
            });
        }
    }

    /// Takes in what has happened elsewhere.
    fn hear(&mut self, context: &Context) {
        let news: Vec<News> = self.worker.news().collect();
        let seen = &mut self.state.seen;
        for news in news {
            match news {
                News::Picture(result) if result.generation == self.asked.generation => {
                    let result = Arc::new(*result);
                    seen.failed = None;
                    if result.finished {
                        seen.progress = None;
                        let audit = &result.picture.audit;
                        seen.past.push(Past {
                            node: result.subject.sheet.nodes[result.subject.node].name.clone(),
                            frame: result.frame,
                            shrunk: result.shrunk,
                            seconds: [result.seconds.0.prepare, result.seconds.1],
                            exits: result.picture.guarantee.map(|_| audit.hull_exits + audit.nan_count),
                        });
                        let most = seen.past.len().saturating_sub(100);
                        seen.past.drain(..most);
                        seen.nodes = result.nodes.iter().map(|node| (node.name.clone(), node.clone())).collect();
                        keep_frame(&mut seen.frames, &result, self.state.frame);
                    }
                    seen.result = Some(result);
                }
                News::Ahead(result) if result.generation == self.asked.generation => {
                    keep_frame(&mut seen.frames, &Arc::new(*result), self.state.frame);
                    self.asked.ahead = None;
                }
                News::Shown { generation, display, screen } if generation == self.asked.generation => {
                    if let Some(result) = &seen.result {
                        let mut result = crate::evaluate::Result::clone(result);
                        (result.display, result.screen) = (display, screen);
                        seen.result = Some(Arc::new(result));
                    }
                }
                News::Progress { generation, share }
                    if generation == self.asked.generation && seen.progress.is_some() =>
                {
                    seen.progress = Some(share);
                }
                News::Failed { generation, message } if generation == self.asked.generation => {
                    seen.failed = Some(message);
                    seen.progress = None;
                    seen.result = None;
                }
                News::Blame(blamed) if self.asked.blame == Some((blamed.generation, blamed.frame, blamed.at)) => {
                    seen.blame = Some(*blamed);
                }
                News::Thumbnails(all) => {
                    seen.thumbnails = all.into_iter().map(|one| (one.node, Arc::new(one.screen))).collect();
                }
                _ => {}
            }
        }
        if self.watcher.changed() && self.state.session.differs_on_disk() == Some(true) {
            self.prompts.external();
        }
        self.hear_render(context);
    }

    fn render(&mut self, context: &Context) {
        let Some(graph) = self.state.session.meaning().graph.clone() else {
            self.toasts.warning("The document has errors: correct them before rendering");
            return;
        };
        match Renderer::start(graph, self.state.range, context.clone()) {
            Ok(renderer) => {
                self.state.render = Some(renderer.progress());
                self.renderer = Some(renderer);
            }
            Err(error) => {
                self.toasts.error(error).duration(None);
            }
        }
    }

    fn hear_render(&mut self, context: &Context) {
        let Some(renderer) = &mut self.renderer else { return };
        self.state.render = Some(renderer.progress());
        let Some(outcome) = renderer.outcome() else {
            return context.request_repaint_after(Duration::from_millis(200));
        };
        self.renderer = None;
        self.state.render = None;
        match outcome {
            Ok(message) => {
                self.toasts.success(message).duration(None);
            }
            Err(message) => {
                self.toasts.error(message).duration(None);
            }
        }
    }

    /// Chooses nodes; what tests and prompts use.
    pub fn select(&mut self, names: &[&str]) {
        self.state.selection = names.iter().map(|name| (*name).to_string()).collect::<BTreeSet<String>>();
    }
}

/// What comes after this document.
#[derive(Clone, Debug, PartialEq)]
pub enum After {
    /// A new document.
    New,
    /// A question for a document to open.
    Ask,
    /// This document.
    Open(PathBuf),
    /// Nothing: the window closes.
    Close,
}

/// Keeps a frame's picture for playing, and lets go of those furthest from the present frame.
fn keep_frame(
    frames: &mut std::collections::BTreeMap<i64, Arc<crate::evaluate::Result>>,
    result: &Arc<crate::evaluate::Result>,
    present: i64,
) {
    frames.insert(result.frame, result.clone());
    let size = |result: &crate::evaluate::Result| {
        result.screen.pixels.len() + result.picture.planes.iter().map(|plane| 4 * plane.samples().len()).sum::<usize>()
    };
    let mut bytes: usize = frames.values().map(|result| size(result)).sum();
    while bytes > FRAMES && frames.len() > 1 {
        let Some(far) = frames.keys().copied().max_by_key(|frame| (frame - present).abs()) else { break };
        bytes -= frames.remove(&far).map_or(0, |result| size(&result));
    }
}
