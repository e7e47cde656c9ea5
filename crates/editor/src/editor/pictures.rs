//! Requests pictures from the worker and receives them.

use super::Editor;
use crate::evaluate::{Job, Lane, News, Question, Subject};
use crate::state::PastEvaluation;
use egui::Context;
use std::collections::BTreeSet;
use std::sync::Arc;

/// State of the last requests to the worker.
#[derive(Default)]
pub(super) struct LastRequest {
    pub(super) generation: u64,
    pub(super) what: Option<What>,
    pub(super) display: crate::evaluate::Display,
    /// Revision and sheet whose nodes have thumbnails.
    pub(super) thumbnails: (u64, String),
    /// Frame from which frames are being evaluated ahead, and the range.
    pub(super) ahead: Option<(i64, (i64, i64))>,
    /// Generation number shared by all frames evaluated ahead for the viewed result.
    pub(super) series: u64,
    /// Frames that could not be evaluated ahead.
    pub(super) failed: BTreeSet<i64>,
    /// The held picture, and the display it was requested with.
    pub(super) held: Option<(u64, crate::evaluate::Display)>,
    /// Picture generation, frame, and place.
    pub(super) blame: Option<(u64, i64, [f32; 2])>,
}

/// First generation number of frames evaluated ahead; numbers of single pictures are smaller.
const SERIES: u64 = 1 << 48;

/// Identity of a picture: revision, node, output, frame, proxy, region.
type What = (u64, String, usize, i64, u32, Option<[f32; 4]>);

/// Memory limit for cached frames, in bytes.
pub(super) const FRAMES: usize = 5 << 26;

impl Editor {
    /// Returns the viewer of the last requests.
    fn lane(&self) -> Lane {
        Lane::of(self.asked.generation)
    }

    /// Returns the subject that the viewer should show.
    pub(super) fn subject(&self) -> Option<Subject> {
        let (sheet, node, output) = self.state.looked()?;
        let output = output.min(sheet.nodes[node].makes.len().saturating_sub(1));
        let session = &self.state.session;
        Some(Subject {
            root: session.sheet().clone(),
            sheet: sheet.clone(),
            revision: session.revision(),
            node,
            output,
            name: session.name(),
            folder: session.folder(),
            access: session.access().clone(),
        })
    }

    /// Requests whatever the viewer lacks.
    pub(super) fn ask(&mut self) {
        if !self.state.session.meaning().readable {
            return self.ask_nothing();
        }
        let Some(subject) = self.subject() else {
            // Also clears the message about a text that was not JSON.
            if self.asked.what.take().is_some() || self.state.evaluated.failed.is_some() {
                self.worker.stop(self.lane());
                let seen = &mut self.state.evaluated;
                (seen.result, seen.last, seen.progress, seen.failed) = (None, None, None, None);
                self.forget_frames();
            }
            return;
        };
        let look = self.state.look.clone();
        let name = subject.whole_name();
        let what = (subject.revision, name, subject.output, self.state.frame, look.proxy, look.region);
        // Frames that were played have no values behind them.
        let is_bare = self.state.evaluated.result.as_ref().is_some_and(|result| result.is_bare());
        let lacks = is_bare && !self.state.playing && self.state.evaluated.progress.is_none();
        if self.asked.what.as_ref() != Some(&what) || lacks {
            let same_but_frame =
                self.asked.what.as_ref().is_some_and(|old| {
                    (old.0, &old.1, old.2, old.4, old.5) == (what.0, &what.1, what.2, what.4, what.5)
                });
            self.asked.generation += 1;
            if !same_but_frame {
                self.forget_frames();
            }
            self.asked.what = Some(what);
            self.asked.display = look.display.clone();
            let seen = &mut self.state.evaluated;
            let ready = seen.frames.get(&self.state.frame).filter(|made| made.display == look.display).cloned();
            if let Some(ready) = &ready {
                (seen.result, seen.whole) = (Some(ready.clone()), Some(ready.clone()));
                (seen.last, seen.failed, seen.progress) = (None, None, None);
            }
            if ready.as_ref().is_none_or(|ready| ready.is_bare() && !self.state.playing) {
                // A coarse picture would hide the one that is there.
                let progressive = !self.state.playing && ready.is_none();
                let job = self.job(subject.clone(), self.asked.generation, self.state.frame, progressive);
                // A picture of which only colors changed is painted at once.
                let weighs = self.lane() == Lane::First && self.weighs();
                self.worker.evaluate(job, weighs);
                self.state.evaluated.progress = Some(0.0);
                self.asked.ahead = None;
                self.asked.blame = None;
            }
        } else if self.asked.display != look.display {
            self.asked.display = look.display.clone();
            self.forget_frames();
            // One without values is evaluated again as soon as playback ends.
            if let Some(result) = self.state.evaluated.result.as_ref().filter(|result| !result.is_bare()) {
                let space = result.lens.graph.space();
                self.worker.show(self.asked.generation, result.picture.clone(), space, look.display);
            }
        }
        if self.state.evaluated.progress.is_some() || self.lane() == Lane::Second {
            return;
        }
        let drawn = (subject.revision, self.state.sheet().prefix());
        if self.asked.thumbnails != drawn && !self.state.playing {
            self.asked.thumbnails = drawn;
            let subject = Subject { sheet: self.state.sheet().clone(), ..subject.clone() };
            self.worker.thumbnails(subject, self.state.frame);
        }
        // When idle, evaluate the upcoming frames, nearest first.
        let present = Some((self.state.frame, self.state.range));
        if self.state.playing && self.asked.ahead != present {
            self.asked.ahead = present;
            let series = self.asked.series;
            let jobs = self.missing().into_iter().map(|frame| self.job(subject.clone(), series, frame, false));
            self.worker.ahead(jobs.collect::<Vec<_>>());
        }
    }

    /// Returns the request for a picture as the viewer looks at it.
    pub(super) fn job(&self, subject: Subject, generation: u64, frame: i64, progressive: bool) -> Job {
        let look = &self.state.look;
        let (proxy, region, display) = (look.proxy, look.region, look.display.clone());
        Job { generation, subject, frame, proxy, region, display, progressive }
    }

    /// Handles a text that is not JSON: the canvas and the viewer keep showing the previous document, marked as past.
    fn ask_nothing(&mut self) {
        if self.asked.what.take().is_some() {
            self.worker.stop(self.lane());
            // Pictures still being evaluated belong to the previous document.
            self.asked.generation += 1;
            self.forget_frames();
        }
        let why = self.state.session.meaning().errors().next().map(|fault| fault.found.clone()).unwrap_or_default();
        let evaluated = &mut self.state.evaluated;
        evaluated.failed = Some(format!("found text that is not JSON: {why}"));
        (evaluated.culprit, evaluated.broken, evaluated.progress) = (None, false, None);
        evaluated.refused.clear();
        evaluated.last = evaluated.result.take().or(evaluated.last.take());
    }

    /// Returns whether the last requested picture is this frame of the current document.
    pub(super) fn is_asked(&self, frame: i64) -> bool {
        let revision = self.state.session.revision();
        self.asked.what.as_ref().is_some_and(|what| (what.0, what.3) == (revision, frame))
    }

    /// Drops cached frames, because they show something other than the viewed result.
    pub(super) fn forget_frames(&mut self) {
        self.state.evaluated.frames.clear();
        self.worker.hold(0);
        self.asked.failed.clear();
        self.asked.ahead = None;
        self.asked.series = (self.asked.series + 1).max(SERIES);
    }

    /// Requests the held picture with the display of the current one.
    pub(super) fn ask_held(&mut self) {
        let Some(result) = &self.state.evaluated.result else { return };
        let Some((number, picture, space, display)) = self.panels.viewer.held_wanted(result) else {
            self.asked.held = None;
            return;
        };
        let wanted = Some((number, display.clone()));
        if self.asked.held != wanted {
            self.asked.held = wanted;
            self.worker.show_held(number, picture, space, display);
        }
    }

    /// Requests the composition of the inspected pixel, once its picture is finished.
    pub(super) fn ask_blame(&mut self) {
        let Some(at) = self.state.look.pick else {
            self.asked.blame = None;
            self.state.evaluated.blame = None;
            return;
        };
        let result = self.state.evaluated.result.as_ref();
        let Some(result) = result.filter(|result| result.finished && self.state.evaluated.progress.is_none()) else {
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

    /// Receives news from the worker and the file watcher.
    pub(super) fn hear(&mut self, context: &Context) {
        let news: Vec<News> = self.worker.news().collect();
        self.hear_paintings();
        for news in news {
            match news.lane() {
                Lane::First => self.hear_news(news),
                Lane::Second => self.on_second(|editor| editor.hear_news(news)),
            }
        }
        self.hear_files(context);
        self.hear_render(context);
    }

    /// Receives news of a viewer.
    fn hear_news(&mut self, news: News) {
        // The second viewer does not play, so it keeps the frames that it shows and no others.
        let room = if self.lane() == Lane::First { self.room } else { 0 };
        let seen = &mut self.state.evaluated;
        match news {
            News::Picture(result) if result.generation == self.asked.generation => {
                let result = Arc::new(*result);
                seen.failed = None;
                seen.last = None;
                // If the display has changed in the meantime, `ask` requests it again.
                self.asked.display = result.display.clone();
                if result.finished {
                    seen.progress = None;
                    let audit = &result.picture.audit;
                    seen.past.push(PastEvaluation {
                        node: result.subject.whole_name(),
                        frame: result.frame,
                        shrunk: result.shrunk,
                        seconds: [result.seconds.0.prepare, result.seconds.1],
                        exits: result.picture.guarantee.map(|_| audit.hull_exits),
                    });
                    let most = seen.past.len().saturating_sub(100);
                    seen.past.drain(..most);
                    seen.nodes = result.nodes.iter().map(|node| (node.name.clone(), node.clone())).collect();
                    let range = self.state.playing.then_some(self.state.range);
                    keep_frame(&mut seen.frames, result.played(), self.state.frame, range, room);
                    self.worker.hold(seen.frames.values().map(|made| made.bytes()).sum());
                    seen.whole = Some(result.clone());
                }
                seen.result = Some(result);
            }
            News::Ahead(result) if result.generation == self.asked.series => {
                if result.display == self.state.look.display {
                    let range = self.state.playing.then_some(self.state.range);
                    keep_frame(&mut seen.frames, result.played(), self.state.frame, range, room);
                    self.worker.hold(seen.frames.values().map(|made| made.bytes()).sum());
                }
                self.asked.ahead = None;
            }
            News::AheadFailed { generation, frame } if generation == self.asked.series => {
                self.asked.failed.insert(frame);
                self.asked.ahead = None;
            }
            News::Shown { generation, display, screen } if generation == self.asked.generation => {
                if let Some(result) = &seen.result {
                    let mut result = crate::evaluate::Result::clone(result);
                    (result.display, result.screen) = (display, screen);
                    seen.result = Some(Arc::new(result));
                }
            }
            News::Held { number, display, screen } => self.panels.viewer.take_held(number, display, screen),
            News::Progress { generation, share } if generation == self.asked.generation && seen.progress.is_some() => {
                seen.progress = Some(share);
            }
            News::Failed { generation, why, begun, refused } if generation == self.asked.generation => {
                (seen.failed, seen.refused) = (Some(why.to_string()), refused);
                (seen.culprit, seen.broken) = (why.node().map(String::from), begun);
                seen.progress = None;
                // The last picture stays visible until there is another.
                seen.last = seen.result.take().or(seen.last.take());
            }
            News::Blame(blamed) if self.asked.blame == Some((blamed.generation, blamed.frame, blamed.at)) => {
                seen.blame = Some(*blamed);
            }
            News::Mixture(mixture) => self.take_mixture(*mixture),
            News::Mixing { generation, share } if generation == self.asked.generation && seen.mixing.is_some() => {
                seen.mixing = Some(share);
            }
            News::UnknownMixture { generation } => self.take_unknown(generation),
            News::Unmixed { generation, why } => self.take_unmixed(generation, why),
            News::Thumbnails(all) => {
                // Those outside of the group that is entered are needed again.
                let prefix = &self.asked.thumbnails.1;
                let is_elsewhere = |own: &str| own.contains('/');
                seen.thumbnails.retain(|name, _| name.strip_prefix(prefix.as_str()).is_none_or(is_elsewhere));
                seen.thumbnails.extend(all.into_iter().map(|one| (one.node, Arc::new(one.screen))));
            }
            _ => {}
        }
    }
}

/// Caches a frame for playback and drops the frames needed last: while playing, those furthest ahead in playback order,
/// otherwise those furthest from the current frame. Two frames always stay, whatever their size: the one shown and the
/// next.
fn keep_frame(
    frames: &mut std::collections::BTreeMap<i64, Arc<crate::evaluate::Result>>,
    result: crate::evaluate::Result,
    present: i64,
    range: Option<(i64, i64)>,
    room: usize,
) {
    frames.insert(result.frame, Arc::new(result));
    let mut taken: usize = frames.values().map(|result| result.bytes()).sum();
    let away = |frame: i64| match range {
        Some(range) => super::play::ahead(frame, present, range),
        None => (frame - present).abs(),
    };
    while taken > room && frames.len() > 2 {
        let Some(last) = frames.keys().copied().max_by_key(|frame| away(*frame)) else { break };
        taken -= frames.remove(&last).map_or(0, |result| result.bytes());
    }
}
