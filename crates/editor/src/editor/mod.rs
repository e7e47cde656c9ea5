//! The editor: what is asked for is done here (`act`), and what is evaluated comes back here (`pictures`). It draws nothing
//! itself.

mod act;
mod change;
mod leave;
mod pictures;
mod play;
mod rendering;

use crate::actions::{Action, Grant, Pane};
use crate::canvas::Canvas;
use crate::commands::Space;
use crate::document::keep::{Keeper, UnsavedCopy, discard, kept};
use crate::document::{Session, Sheet};
use crate::evaluate::Worker;
use crate::layout;
use crate::notices::Notices;
use crate::prompts::Prompts;
use crate::properties::Properties;
use crate::reach;
use crate::refusal;
use crate::render::Renderer;
use crate::report::Report;
use crate::state::State;
use crate::text_panel::TextPanel;
use crate::timeline::Timeline;
use crate::viewer::Viewer;
use crate::watch::Watcher;
use crate::waves::Waves;
use egui::{Context, Key};
use pictures::LastRequest;
use play::Playback;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// The editor of one document.
pub struct Editor {
    pub(crate) state: State,
    pub(crate) tree: egui_tiles::Tree<Pane>,
    pub(crate) panels: Panels,
    pub(crate) prompts: Prompts,
    pub(crate) notices: Notices,
    /// The complaint about the text that was shown last, and when.
    complained: Option<Instant>,
    pub(crate) recent: Vec<PathBuf>,
    /// What this run lets every document reach besides its own.
    allowed: Vec<PathBuf>,
    /// What this document was allowed, the newest first: remembered where it has a file.
    pub(crate) answers: Vec<Grant>,
    pub(crate) worker: Worker,
    asked: LastRequest,
    keeper: Option<Keeper>,
    kept: Backup,
    watcher: Watcher,
    renderer: Option<Renderer>,
    /// Nodes that were copied here, and the folder that their paths are relative to.
    copied: Option<(String, PathBuf)>,
    playback: Playback,
    /// Most memory for pictures of frames, bytes.
    pub(crate) room: usize,
    /// The document as it was when it changed last.
    known: Arc<Sheet>,
    /// What was looked at before it was deleted: undo brings both back.
    lost: Option<(String, usize)>,
    /// The revision, the nodes and the output of which a value may stand refused.
    refusing: (u64, BTreeSet<String>, Option<String>),
    /// What waits until a number that is being typed has been taken.
    later: Vec<Action>,
    space: Space,
    closing: bool,
}

/// What there is a copy of, in case that the editor ends unexpectedly.
#[derive(Default)]
struct Backup {
    /// The revision, and how much had been typed; `None` where there is no copy.
    what: Option<(u64, u64)>,
    /// When the first change since was seen.
    since: Option<Instant>,
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
    pub(crate) text: TextPanel,
}

impl Editor {
    /// An editor of a document. `data` is where copies of unsaved work and the list of recent files are kept; nowhere if
    /// `None`.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(context: &Context, session: Session, data: Option<&Path>) -> std::io::Result<Self> {
        crate::theme::install(context);
        crate::turns::install(context);
        let wake = context.clone();
        let worker = Worker::new(move || wake.request_repaint())?;
        let folder = data.map(|data| data.join("unsaved"));
        let keeper = folder.as_deref().and_then(|folder| Keeper::new(folder).ok());
        let recent = data.map(crate::recent::read).unwrap_or_default();
        let mut editor = Self {
            tree: layout::first(),
            panels: Panels::default(),
            prompts: Prompts::new(data),
            notices: Notices::default(),
            complained: None,
            recent,
            allowed: Vec::new(),
            answers: Vec::new(),
            worker,
            asked: LastRequest::default(),
            keeper,
            kept: Backup::default(),
            watcher: Watcher::default(),
            renderer: None,
            copied: None,
            playback: Playback::default(),
            room: pictures::FRAMES,
            known: session.sheet().clone(),
            lost: None,
            refusing: Default::default(),
            later: Vec::new(),
            space: Space::default(),
            closing: false,
            state: State::new(session),
        };
        editor.opened(context);
        editor.offer();
        Ok(editor)
    }

    /// Offers work of this document that was kept of editors that ended unexpectedly; beside one that is nowhere yet, also of
    /// documents that are gone, and tells of others.
    fn offer(&mut self) {
        let folder = self.prompts.data().map(|data| data.join("unsaved"));
        let file = self.state.session.file().map(reach::whole);
        let all = folder.as_deref().map(kept).unwrap_or_default();
        let (saved, all): (Vec<UnsavedCopy>, Vec<UnsavedCopy>) = all.into_iter().partition(UnsavedCopy::is_saved);
        saved.iter().for_each(discard);
        // Of a document that is not there any more nobody else asks.
        let is_homeless =
            |kept: &UnsavedCopy| file.is_none() && kept.file.as_deref().is_none_or(|file| !file.is_file());
        let is_own = |kept: &UnsavedCopy| is_homeless(kept) || kept.file.as_deref().map(reach::whole) == file;
        let (own, others): (Vec<UnsavedCopy>, Vec<UnsavedCopy>) = all.into_iter().partition(is_own);
        if !own.is_empty() {
            self.prompts.recover(own);
        }
        if file.is_none() {
            let files: BTreeSet<&Path> = others.iter().filter_map(|kept| kept.file.as_deref()).collect();
            for file in files {
                let text = format!("Unsaved work of {} was kept: open it to recover that", file.display());
                self.notices.info(text);
            }
        }
    }

    /// Offers work that was kept of a document that cannot be opened.
    fn offer_lost(&mut self, file: &Path) {
        let (file, folder) = (reach::whole(file), self.prompts.data().map(|data| data.join("unsaved")));
        let mut lost = folder.as_deref().map(kept).unwrap_or_default();
        lost.retain(|kept| kept.file.as_deref().map(reach::whole).as_ref() == Some(&file));
        if !lost.is_empty() {
            self.prompts.recover(lost);
        }
    }

    /// What is open, chosen and seen.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What is kept of the window until the editor starts next.
    pub fn kept_window(&self, context: &Context) -> String {
        layout::written(&self.tree, (context.options(|options| options.theme_preference), context.zoom_factor()))
    }

    /// Lays the window out as it was kept; one that cannot be read stays as it is at first.
    pub fn restore(&mut self, kept: &str, context: &Context) {
        if let Some((tree, (theme, zoom))) = layout::read(kept) {
            self.tree = tree;
            context.set_theme(theme);
            context.set_zoom_factor(zoom);
        }
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        let changed = if self.is_unsaved() { "• " } else { "" };
        format!("{changed}{} — Trochoid", self.state.session.title())
    }

    /// Whether there is work that is not in the document's file.
    pub fn is_unsaved(&self) -> bool {
        self.state.session.is_changed() || self.panels.text.pending().is_some()
    }

    /// Whether the window may close now.
    pub fn is_closing(&self) -> bool {
        self.closing
    }

    /// Asks to close the window: at once, or after a question about unsaved changes.
    pub fn close(&mut self, context: &Context) {
        if context.text_edit_focused() {
            self.defer(Action::Quit, context);
        } else {
            self.act(Action::Quit, context);
        }
    }

    /// Does something as soon as what is being typed has been taken.
    fn defer(&mut self, action: Action, context: &Context) {
        if let Some(field) = context.memory(|memory| memory.focused()) {
            context.memory_mut(|memory| memory.surrender_focus(field));
        }
        self.later.push(action);
        context.request_repaint();
    }

    /// What comes before anything is drawn: what has happened since is heard. Gives what keys ask for.
    pub(crate) fn before(&mut self, context: &Context) -> Vec<Action> {
        self.hear(context);
        self.forgive(context);
        let mut actions = Vec::new();
        if self.prompts.is_open() {
            self.space = Space::default();
        } else {
            crate::commands::pressed(context, &self.state, &mut actions);
            if self.space.plays(context) {
                actions.push(Action::Play(!self.state.playing));
            }
        }
        // Wherever the pointer is.
        if self.state.dropper.is_some() && context.input(|input| input.key_pressed(Key::Escape)) {
            actions.push(Action::Dropper(None));
        }
        actions
    }

    /// What comes after everything is drawn: what was asked for is done, and pictures are asked for. `typing` says whether
    /// something was being typed when drawing began.
    pub(crate) fn after(&mut self, actions: Vec<Action>, typing: bool, context: &Context) {
        let mut later = std::mem::take(&mut self.later);
        for action in actions {
            // What is typed and not entered yet counts before the document is written, rendered or left.
            if typing && action.needs_all() {
                self.defer(action, context);
            } else {
                self.act(action, context);
            }
        }
        for action in later.drain(..) {
            // What was typed is refused: that stays to be seen.
            if !(action.hides() && refusal::is_fresh(context)) {
                self.act(action, context);
            }
        }
        self.keep(context);
        self.play(context);
        self.ask();
        self.ask_held();
        self.ask_blame();
    }

    /// Lets every document of this run reach these files and folders, besides what it may and what it was allowed.
    pub fn allow_all(&mut self, paths: &[PathBuf]) {
        self.allowed = paths.to_vec();
        self.grant();
    }

    /// Lets the document reach what it was allowed before.
    fn grant(&mut self) {
        let session = &mut self.state.session;
        session.set_access(reach::access(&session.folder(), &self.allowed, &self.answers));
    }

    /// Takes up what was answered for the document that is open now.
    fn remember(&mut self) {
        let known = self.state.session.file().zip(self.prompts.data());
        self.answers = known.map_or_else(Vec::new, |(file, data)| reach::remembered(data, file));
        self.grant();
    }

    /// Allows the document something, and remembers it.
    fn allow(&mut self, grant: Grant) {
        if let Some((file, data)) = self.state.session.file().zip(self.prompts.data()) {
            reach::remember(data, file, &grant);
        }
        self.answers.retain(|known| *known != grant);
        self.answers.insert(0, grant);
        self.grant();
        self.changed();
    }

    /// Takes back what a document was allowed; the one that is open where none is named.
    fn forbid(&mut self, document: Option<&Path>, grant: &Grant) {
        if let Some((document, data)) = document.or(self.state.session.file()).zip(self.prompts.data()) {
            reach::forget(data, document, grant);
        }
        let own = self.state.session.file().map(reach::whole);
        if document.is_none() || document.map(reach::whole) == own {
            self.answers.retain(|known| known != grant);
            self.grant();
            self.changed();
        }
    }

    fn opened(&mut self, context: &Context) {
        self.remember();
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
        self.kept = Backup::default();
        self.panels.text = TextPanel::default();
        self.notices.leave();
        self.known = session.sheet().clone();
        self.state = State::new(session);
        self.forget_frames();
        (self.lost, self.playback) = (None, Playback::default());
        self.panels.viewer.forget();
        self.opened(context);
    }

    /// Keeps a copy of unsaved work within a second of a change, as long as there is some.
    fn keep(&mut self, context: &Context) {
        let Some(keeper) = &self.keeper else { return };
        if !self.is_unsaved() {
            if std::mem::take(&mut self.kept).what.is_some() {
                keeper.forget();
            }
            return;
        }
        let what = Some((self.state.session.revision(), self.panels.text.typings()));
        if self.kept.what == what {
            return;
        }
        let since = *self.kept.since.get_or_insert_with(Instant::now);
        match crate::document::keep::AFTER.checked_sub(since.elapsed()) {
            Some(left) if !left.is_zero() => context.request_repaint_after(left),
            _ => self.copy(),
        }
    }

    /// Copies the work as it is: what is typed and not applied is what it will be.
    fn copy(&mut self) {
        let (session, source) = (&self.state.session, &self.panels.text);
        if let Some(keeper) = &self.keeper {
            keeper.keep(session.file(), source.pending().unwrap_or(session.text()));
            self.kept = Backup { what: Some((session.revision(), source.typings())), since: None };
        }
    }
}
