//! The editor: performs actions (`act`) and receives evaluated pictures (`pictures`). Draws nothing itself.

mod act;
mod change;
mod colors;
mod dropped;
mod find;
mod groups;
mod help;
mod layouts;
mod leave;
mod painting;
mod parts;
mod pictures;
mod play;
mod presets;
mod rendering;
mod second;
mod transform;
mod welcome;

use crate::actions::{Action, Grant, Pane};
use crate::canvas::Canvas;
use crate::commands::Space;
use crate::curves::Curves;
use crate::document::keep::{Keeper, UnsavedCopy, discard, kept};
use crate::document::{Session, Sheet};
use crate::evaluate::{Graphics, Lane, Painter, Worker};
use crate::help::Help;
use crate::layout;
use crate::layouts::Layouts;
use crate::notices::Notices;
use crate::palette::Palette;
use crate::prompts::Prompts;
use crate::properties::Properties;
use crate::reach;
use crate::refusal;
use crate::render::Renderer;
use crate::report::Report;
use crate::state::State;
use crate::text_panel::TextPanel;
use crate::timeline::Timeline;
use crate::viewer::{SecondViewer, Viewer};
use crate::watch::Watcher;
use crate::waves::Waves;
use egui::{Context, Key};
use painting::LastPainting;
use pictures::LastRequest;
use play::Playback;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Editor for one document at a time.
pub struct Editor {
    pub(crate) state: State,
    pub(crate) tree: egui_tiles::Tree<Pane>,
    pub(crate) panels: Panels,
    pub(crate) prompts: Prompts,
    pub(crate) notices: Notices,
    /// Time of the last notice about text that is not JSON.
    complained: Option<Instant>,
    pub(crate) recent: Vec<PathBuf>,
    /// Layouts that the user kept.
    pub(crate) layouts: Layouts,
    /// Paths that every document may access in this run.
    allowed: Vec<PathBuf>,
    /// Permissions of this document, newest first; stored if the document has a file.
    pub(crate) answers: Vec<Grant>,
    pub(crate) worker: Worker,
    asked: LastRequest,
    second: second::Second,
    painter: Painter,
    painting: LastPainting,
    keeper: Option<Keeper>,
    kept: Backup,
    watcher: Watcher,
    /// Revision whose files are watched.
    watched: u64,
    renderer: Option<Renderer>,
    /// Nodes copied in this editor, and the folder that their paths are relative to.
    copied: Option<(String, PathBuf)>,
    playback: Playback,
    /// Memory limit for cached frames, in bytes.
    pub(crate) room: usize,
    /// The document at the last change.
    known: Arc<Sheet>,
    /// The viewed result, if it was deleted: undoing the deletion views it again.
    lost: Option<(String, usize)>,
    /// Revision, selected nodes, and selected output for which a refusal may be shown.
    refusing: (u64, BTreeSet<String>, Option<String>),
    /// Actions that wait until the focused field has committed its text.
    later: Vec<Action>,
    space: Space,
    closing: bool,
}

/// State of the backup of unsaved work.
#[derive(Default)]
struct Backup {
    /// Revision and typing count of the backup; `None` if there is none.
    what: Option<(u64, u64)>,
    /// Time when the first change since the backup was noticed.
    since: Option<Instant>,
}

/// State that panels do not share.
#[derive(Default)]
pub(crate) struct Panels {
    pub(crate) canvas: Canvas,
    pub(crate) viewer: Viewer,
    pub(crate) second: SecondViewer,
    pub(crate) properties: Properties,
    pub(crate) palette: Palette,
    pub(crate) timeline: Timeline,
    pub(crate) curves: Curves,
    pub(crate) waves: Waves,
    pub(crate) report: Report,
    pub(crate) text: TextPanel,
    pub(crate) help: Help,
}

impl Editor {
    /// Creates an editor for a document. `data` is the folder for backups of unsaved work and the list of recent files;
    /// `None` disables both.
    ///
    /// # Errors
    /// Fails if the system cannot start a thread.
    pub fn new(context: &Context, session: Session, data: Option<&Path>) -> std::io::Result<Self> {
        crate::theme::install(context);
        crate::fonts::install(context);
        crate::turns::install(context);
        let graphics = Graphics::default();
        let wake = context.clone();
        let worker = Worker::new(&graphics, move || wake.request_repaint())?;
        let wake = context.clone();
        let painter = Painter::new(&graphics, move || wake.request_repaint())?;
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
            layouts: data.map(Layouts::read).unwrap_or_default(),
            allowed: Vec::new(),
            answers: Vec::new(),
            worker,
            asked: LastRequest::default(),
            second: second::Second::default(),
            painter,
            painting: LastPainting::default(),
            keeper,
            kept: Backup::default(),
            watcher: Watcher::default(),
            watched: 0,
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
            state: State::new(session, graphics),
        };
        editor.opened(context);
        editor.offer();
        Ok(editor)
    }

    /// Offers to recover backups of this document. For a new document, also offers backups of unsaved or missing
    /// documents, and notifies the user about those of other documents.
    fn offer(&mut self) {
        let folder = self.prompts.data().map(|data| data.join("unsaved"));
        let file = self.state.session.file().map(reach::whole);
        let all = folder.as_deref().map(kept).unwrap_or_default();
        let (saved, all): (Vec<UnsavedCopy>, Vec<UnsavedCopy>) = all.into_iter().partition(UnsavedCopy::is_saved);
        saved.iter().for_each(discard);
        // No other document would offer a backup whose file no longer exists.
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
                let text = format!("Unsaved changes to {} can be recovered: open the file to do so", file.display());
                self.notices.info(text);
            }
        }
    }

    /// Offers backups of a document that cannot be opened.
    fn offer_lost(&mut self, file: &Path) {
        let (file, folder) = (reach::whole(file), self.prompts.data().map(|data| data.join("unsaved")));
        let mut lost = folder.as_deref().map(kept).unwrap_or_default();
        lost.retain(|kept| kept.file.as_deref().map(reach::whole).as_ref() == Some(&file));
        if !lost.is_empty() {
            self.prompts.recover(lost);
        }
    }

    /// Returns the shared state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the window layout, theme, and zoom for storage.
    pub fn kept_window(&self, context: &Context) -> String {
        layout::written(&self.tree, (context.options(|options| options.theme_preference), context.zoom_factor()))
    }

    /// Restores a stored window layout; an unreadable one is ignored.
    pub fn restore(&mut self, kept: &str, context: &Context) {
        if let Some((tree, (theme, zoom))) = layout::read(kept) {
            self.tree = tree;
            context.set_theme(theme);
            context.set_zoom_factor(zoom);
        }
    }

    /// Returns the window title.
    pub fn title(&self) -> String {
        let changed = if self.is_unsaved() { "• " } else { "" };
        format!("{changed}{} — Trochoid", self.state.session.title())
    }

    /// Returns whether there is work that is not in the document's file.
    pub fn is_unsaved(&self) -> bool {
        self.state.session.is_changed() || self.panels.text.pending().is_some()
    }

    /// Returns whether the window may close now.
    pub fn is_closing(&self) -> bool {
        self.closing
    }

    /// Requests to close the window: immediately, or after a question about unsaved changes.
    pub fn close(&mut self, context: &Context) {
        if context.text_edit_focused() {
            self.defer(Action::Quit, context);
        } else {
            self.act(Action::Quit, context);
        }
    }

    /// Performs an action as soon as the focused field has committed its text.
    fn defer(&mut self, action: Action, context: &Context) {
        if let Some(field) = context.memory(|memory| memory.focused()) {
            context.memory_mut(|memory| memory.surrender_focus(field));
        }
        self.later.push(action);
        context.request_repaint();
    }

    /// Prepares a frame before drawing: receives news and returns the actions of pressed keys.
    pub(crate) fn before(&mut self, context: &Context) -> Vec<Action> {
        self.hear(context);
        self.take_dropped(context);
        self.forgive(context);
        // A drag of a color whose end nothing has seen, because its panel is hidden, counts as cancelled.
        if self.state.colors.tint.is_some()
            && !context.input(|input| input.pointer.any_down() || input.pointer.any_released())
        {
            self.tint(None);
        }
        let mut actions = Vec::new();
        if self.prompts.is_open() || crate::dialogs::is_shown(context) {
            self.space = Space::default();
        } else {
            self.panels.curves.take_keys(context);
            self.panels.viewer.take_escape(context, &self.state);
            self.panels.second.viewer.take_escape(context, &self.state);
            crate::commands::pressed(context, &self.state, &mut actions);
            if self.space.plays(context) {
                actions.push(Action::Play(!self.state.playing));
            }
        }
        // Works wherever the pointer is.
        if self.state.dropper.is_some() && context.input(|input| input.key_pressed(Key::Escape)) {
            actions.push(Action::Dropper(None));
        }
        actions
    }

    /// Completes a frame after drawing: performs the actions and requests pictures. `typing` says whether a text field
    /// had the focus when drawing began.
    pub(crate) fn after(&mut self, actions: Vec<Action>, typing: bool, context: &Context) {
        let mut later = std::mem::take(&mut self.later);
        for action in actions {
            // Text in a field must be committed before the document is saved, rendered, or left.
            if typing && action.needs_all() {
                self.defer(action, context);
            } else {
                self.act(action, context);
            }
        }
        for action in later.drain(..) {
            // A refusal of the typed text must stay visible.
            if !(action.hides() && refusal::is_fresh(context)) {
                self.act(action, context);
            }
        }
        self.keep(context);
        self.play(context);
        self.ask();
        self.ask_second();
        self.ask_held();
        self.ask_blame();
        self.ask_mixture();
        self.ask_painting();
    }

    /// Allows every document of this run to access these files and folders, in addition to its own permissions.
    pub fn allow_all(&mut self, paths: &[PathBuf]) {
        self.allowed = paths.to_vec();
        self.grant();
    }

    /// Applies the permissions to the document.
    fn grant(&mut self) {
        let session = &mut self.state.session;
        session.set_access(reach::access(&session.folder(), &self.allowed, &self.answers));
    }

    /// Loads the stored permissions of the open document.
    fn remember(&mut self) {
        let known = self.state.session.file().zip(self.prompts.data());
        self.answers = known.map_or_else(Vec::new, |(file, data)| reach::remembered(data, file));
        self.grant();
    }

    /// Gives the document a permission, and stores it.
    fn allow(&mut self, grant: Grant) {
        if let Some((file, data)) = self.state.session.file().zip(self.prompts.data()) {
            reach::remember(data, file, &grant);
        }
        self.answers.retain(|known| *known != grant);
        self.answers.insert(0, grant);
        self.grant();
        self.changed();
    }

    /// Revokes a permission of the named document, or of the open one if none is named.
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
        let file = self.state.session.file().map(Path::to_path_buf);
        self.watch(file.as_deref(), context);
        if let (Some(file), Some(data)) = (self.state.session.file(), self.prompts.data()) {
            self.recent = crate::recent::add(data, file);
        }
        self.panels.canvas = Canvas::default();
        self.panels.curves = Curves::default();
        self.read_presets();
        self.forget_second();
        self.asked.what = None;
        self.asked.thumbnails = Default::default();
        context.request_repaint();
    }

    fn start(&mut self, session: Session, context: &Context) {
        self.keep_recent_picture();
        self.worker.stop(Lane::First);
        if let Some(keeper) = &self.keeper {
            keeper.forget();
        }
        self.kept = Backup::default();
        self.panels.text = TextPanel::default();
        self.notices.leave();
        self.known = session.sheet().clone();
        let transform = self.state.look.display.transform.clone();
        self.state = State::new(session, self.state.graphics.clone());
        self.show_through(&transform);
        self.forget_frames();
        (self.lost, self.playback) = (None, Playback::default());
        self.panels.viewer.forget();
        self.panels.palette.forget();
        self.painting = LastPainting::default();
        self.opened(context);
    }

    /// Backs up unsaved work within a second of a change.
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

    /// Backs up the current work, including typed text that is not applied yet.
    fn copy(&mut self) {
        let (session, source) = (&self.state.session, &self.panels.text);
        if let Some(keeper) = &self.keeper {
            keeper.keep(session.file(), source.pending().unwrap_or(session.text()));
            self.kept = Backup { what: Some((session.revision(), source.typings())), since: None };
        }
    }
}
