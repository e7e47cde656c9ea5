//! The work of a run, which is checked before anything is evaluated, and then done frame by frame.

use super::accuracy::Accuracy;
use super::args::Args;
use super::certify::{self, CertifyContext, Companions, HalfMonitor};
use super::chosen::Chosen;
use super::files::RequestedFiles;
use super::line;
use super::tally::Tally;
use crate::failure::{FAILED, Failure, INTERRUPTED, Message};
use crate::progress::Progress;
use crate::shell::printable;
use crate::{frames, interrupt};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use trochoid::certificate::PrivateKey;
use trochoid::io::{Claim, Claims};
use trochoid::{
    Cache, CheckedGraph, EvalError, FileSink, Fingerprints, Frame, Guarantee, Heap, Keep, Monitor, NodeReport,
    OutputError, OutputFile, Pictures, Plan, ReferenceError, Repair, RunReport, Settings, Sink, Switches, Work,
    clear_partial_files, expand_frame, frame_report, misses, quoted, write_output,
};

/// Function that evaluates a plan to a frame; tests replace it.
pub(super) type Evaluate<'e> =
    dyn Fn(&Plan<'_>, Option<&dyn Sink>, &mut Cache, &dyn Monitor) -> Result<Frame, EvalError> + 'e;

/// Work of a run.
pub(super) struct Job<'a> {
    graph: &'a CheckedGraph,
    chosen: &'a Chosen,
    args: &'a Args,
    required: Option<Guarantee>,
    settings: Settings,
    frames: Vec<i64>,
    /// Folders of the files to write.
    folders: BTreeSet<PathBuf>,
    accuracy: Accuracy,
    /// Key that signs certificates, if requested.
    key: Option<PrivateKey>,
}

/// Time in which a run on a file system without locks must give a sign of life, or its frame is taken over.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause before frames are asked for again that other runs have.
const PAUSE: Duration = Duration::from_millis(200);

/// Result of a frame.
struct FrameResult {
    report: Value,
    line: String,
    /// Messages about missed requirements.
    misses: Vec<String>,
    /// Nodes in which illegal values were replaced.
    replaced: Vec<Replaced>,
    /// Names of views and of surfaces of which nothing is in their pictures.
    unseen: Vec<(String, String)>,
    skipped: bool,
}

/// Illegal values of a node that were replaced.
struct Replaced {
    node: String,
    count: u64,
    first: Option<Repair>,
}

impl<'a> Job<'a> {
    /// Chooses frames, and checks every file to be written; adds all faults to `faults`.
    pub(super) fn new(chosen: &'a Chosen, args: &'a Args, frames: Option<Vec<i64>>, faults: &mut Vec<Failure>) -> Self {
        let graph = &chosen.graph;
        let frames = frames.unwrap_or_else(|| frames::all(graph, args.frames.is_some(), faults));
        let mut settings = Settings::default();
        settings.threads = usize::from(args.threads);
        (settings.region, settings.local) = (args.region, args.region.is_some());
        let picture = graph.format().window();
        if let Some(region) = args.region.filter(|region| region.intersect(picture) != *region) {
            let message = format!("--region: found pixels {region}; expected some of the picture's, {picture}");
            faults.push(Failure::usage(message, "choose a region within the picture"));
        }
        if args.unoptimized {
            settings.switches = Switches::NONE;
        } else if frames.len() > 1 {
            settings.keep = Keep::ForFrames;
        }
        let (required, accuracy) = (args.required(), Accuracy::default());
        let key = args.sign.as_ref().map(|path| PrivateKey::read(path)).transpose();
        let key = key.unwrap_or_else(|error| {
            faults.push(error.into());
            None
        });
        let folders = BTreeSet::new();
        let mut job = Self { graph, chosen, args, required, settings, frames, folders, accuracy, key };
        job.folders =
            RequestedFiles { graph, chosen, args, outputs: &chosen.outputs, frames: &job.frames }.check(faults);
        job
    }

    /// Returns the job with these accuracy settings, which the graph contains already.
    pub(super) fn with(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// Returns the settings that a tolerance or a plan requires.
    pub(super) fn accuracy(&self) -> Result<Accuracy, Failure> {
        Accuracy::settle(self.args, self.graph, &self.chosen.outputs, &self.frames, &self.settings)
    }

    fn files(&self, frame: i64) -> Result<Vec<OutputFile>, Failure> {
        self.chosen.files(self.graph, self.args, frame, self.frames.len() > 1)
    }

    /// Returns the companions of each file of a frame.
    fn companions(&self, files: &[OutputFile], frame: i64) -> Result<Vec<Companions>, Failure> {
        Companions::of(self.graph, self.args, files, frame, self.frames.len() > 1)
    }

    fn certifies(&self) -> bool {
        self.args.certificate.is_some() || self.args.error.is_some() || self.accuracy.error().is_some()
    }

    /// Returns notes on frames beyond those of the document, and on file names of a still in which `#` may not have
    /// been meant as the frame.
    pub(super) fn notes(&self) -> Vec<String> {
        if let Some(note) = frames::beyond(self.graph, &self.frames) {
            return vec![note];
        }
        let (first, last) = self.graph.frames();
        let [frame] = self.frames[..] else { return Vec::new() };
        let Args { out, recipe, certificate, error, .. } = self.args;
        let named = [("--out", out), ("--recipe", recipe), ("--certificate", certificate), ("--error", error)];
        let note = |(option, pattern): (&str, &Option<String>)| note_of_sign(option, pattern.as_deref()?, frame);
        if first == last { named.into_iter().filter_map(note).collect() } else { Vec::new() }
    }

    /// Returns warnings for nodes whose first frame takes long, except for those that checking has warned of.
    pub(super) fn warnings(&self) -> Vec<String> {
        let known = self.graph.heavy(self.graph.frames().0);
        let begin = self.frames.first().copied().unwrap_or_default();
        let outputs = self.graph.outputs();
        let feeds = self.graph.upstream(self.chosen.outputs.iter().map(|index| outputs[*index].node));
        let is_needed = |name: &str| self.graph.find(name).is_some_and(|id| feeds[id.0]);
        let news = self.graph.heavy(begin).into_iter();
        let news = news.filter(|(name, _)| is_needed(name) && !known.iter().any(|(known, _)| known == name));
        let text = |(name, work): (&str, Work)| {
            let (found, expected) = (work.found(), Work::expected());
            let id = self.graph.find(name);
            let at = id.map_or(String::new(), |id| format!("{}: ", self.graph.place_of(id, Some(work.item.as_str()))));
            let place = format!("{at}frame {begin}: node \"{name}\", {}", work.item);
            format!("warning: {place}: found {found}; expected {expected}\n  remedy: {}", work.remedy)
        };
        news.map(text).collect()
    }

    /// Returns the warning for a node in which illegal values were replaced, unless its author requested that.
    fn warning_of_replaced(&self, replaced: &Replaced, frame: i64) -> Option<String> {
        let Replaced { node: name, count, first } = replaced;
        let id = self.graph.find(name)?;
        let asked = |item: &str| matches!(item, "repair" | "nan");
        if self.graph.node(id).places.iter().any(|(item, _)| asked(item)) {
            return None;
        }
        let values = if *count == 1 { "illegal value (NaN), which was" } else { "illegal values (NaN), which were" };
        let first = first.as_ref().map_or(String::new(), |Repair { pixel: [x, y], cause }| {
            format!(", {} pixel {x}, {y} by {}", if *count == 1 { "at" } else { "first at" }, printable(cause))
        });
        Some(format!(
            "warning: {}: node \"{name}\", frame {frame}: found {count} {values} replaced{first}; expected numbers\n  \
             remedy: correct the inputs of the node, or set \"nan\" of a FieldMath to the value to use instead",
            self.graph.place_of(id, None)
        ))
    }

    /// Returns the warning for a surface of which nothing is in the picture.
    fn warning_of_unseen(&self, name: &str, surface: &str, frame: i64) -> Option<String> {
        let id = self.graph.find(name)?;
        Some(format!(
            "warning: {}: node \"{name}\", frame {frame}: found nothing of the surface \"{surface}\" in the picture; \
             expected some of it, because the view lists it\n  remedy: look at the camera's position and target; nothing \
             is drawn beyond 10,000 km",
            self.graph.place_of(id, Some("surfaces"))
        ))
    }

    /// Renders all frames in order.
    pub(super) fn run(&self, evaluate: &Evaluate<'_>, mut cache: Cache, report: &mut RunReport) -> Result<(), Failure> {
        let mut progress = Progress::of(self.args.progress, self.frames.len(), self.args.quiet);
        let mut fingerprints = Fingerprints::with(&self.settings).by_reference(self.accuracy.by_reference());
        // Runs that were killed while writing left partial files.
        let clear = || self.folders.iter().for_each(|folder| clear_partial_files(folder));
        clear();
        if self.frames.len() > 1 {
            // All frames take the same memory.
            Heap::use_large_pages();
        }
        let mut tally = Tally::default();
        let claims = self.args.share.then(|| Claims::new(PATIENCE));
        let mut open = self.frames.clone();
        while !open.is_empty() {
            let (mut taken, done) = (Vec::new(), tally.done);
            for frame in open {
                let claim = match &claims {
                    Some(claims) => self.claim(claims, frame)?,
                    None => None,
                };
                if claims.is_some() && claim.is_none() {
                    taken.push(frame);
                    continue;
                }
                progress.begin(tally.done, frame);
                let made = self.frame(frame, evaluate, &mut cache, &mut fingerprints, &progress);
                cache.forget_unused();
                self.tell(frame, made, &mut tally, &progress, report)?;
            }
            open = taken;
            if tally.done == done {
                stop_if_asked()?;
                std::thread::sleep(PAUSE);
            }
        }
        if claims.is_some() {
            // Others may have been killed in the meantime.
            clear();
        }
        progress.finish();
        tally.outcome()
    }

    /// Claims a frame that several runs may render; `None` if another one has it.
    fn claim(&self, claims: &Claims, frame: i64) -> Result<Option<Claim>, Failure> {
        stop_if_asked()?;
        let files = self.files(frame)?;
        // All runs have the same files, so the first one stands for all.
        let file = files.first().ok_or_else(|| Failure::new(FAILED, format!("frame {frame}: has no file")))?;
        Ok(trochoid::claim(claims, file)?)
    }

    /// Tells what became of a frame.
    fn tell(
        &self,
        frame: i64,
        made: Result<FrameResult, Failure>,
        tally: &mut Tally,
        progress: &Progress,
        report: &mut RunReport,
    ) -> Result<(), Failure> {
        tally.done += 1;
        let done = match made {
            Ok(done) => done,
            Err(failure) => {
                if self.args.json && failure.code != INTERRUPTED {
                    let messages: Vec<&str> = failure.messages.iter().map(Message::text).collect();
                    let line = json!({ "frame": frame, "failed": messages.join("\n"), "code": failure.code });
                    progress.print(&format!("{line}\n"))?;
                }
                if !self.args.keep_going || failure.code == INTERRUPTED {
                    return Err(failure);
                }
                progress.tell(&failure.messages.iter().map(ToString::to_string).collect::<Vec<_>>());
                tally.failed.push((frame, failure.code));
                return Ok(());
            }
        };
        if done.skipped {
            progress.skip();
        }
        if self.args.json {
            progress.print(&format!("{}\n", done.report))?;
        } else if !self.args.quiet && !self.args.report_on_stdout() {
            progress.print(&done.line)?;
        }
        tally.missed += usize::from(!done.misses.is_empty());
        progress.tell(&done.misses);
        let news = done.replaced.iter().filter(|replaced| tally.told.insert(replaced.node.clone()));
        let news = news.filter_map(|replaced| self.warning_of_replaced(replaced, frame));
        progress.tell(&news.collect::<Vec<_>>());
        let news = done.unseen.into_iter().filter(|unseen| tally.unseen.insert(unseen.clone()));
        let news = news.filter_map(|(name, surface)| self.warning_of_unseen(&name, &surface, frame));
        progress.tell(&news.collect::<Vec<_>>());
        report.push(done.report);
        Ok(())
    }

    fn frame(
        &self,
        number: i64,
        evaluate: &Evaluate<'_>,
        cache: &mut Cache,
        fingerprints: &mut Fingerprints,
        progress: &Progress,
    ) -> Result<FrameResult, Failure> {
        let started = Instant::now();
        stop_if_asked()?;
        let all = self.files(number)?;
        let companions = self.companions(&all, number)?;
        type PairedFiles = Vec<(OutputFile, Companions)>;
        let (current, open): (PairedFiles, PairedFiles) =
            all.into_iter().zip(companions).partition(|(file, companions)| {
                self.args.resumes()
                    && fingerprints.is_current(self.graph, file, number, self.required)
                    && (!self.certifies()
                        || companions.is_current(self.graph, file, number, fingerprints, self.key.as_ref()))
            });
        let up_to_date =
            || current.iter().map(|(file, companions)| self.describe(file, "up to date", Some(companions)));
        if open.is_empty() {
            let files: Vec<Value> = up_to_date().collect();
            let report = json!({ "frame": number, "skipped": true, "files": files });
            let current: Vec<OutputFile> = current.into_iter().map(|(file, _)| file).collect();
            let line = line::skipped(self.graph, number, &current);
            return Ok(FrameResult {
                report,
                line,
                misses: Vec::new(),
                replaced: Vec::new(),
                unseen: Vec::new(),
                skipped: true,
            });
        }
        let (open, companions): (Vec<OutputFile>, Vec<Companions>) = open.into_iter().unzip();
        let names: Vec<&str> = open
            .iter()
            .flat_map(|file| &file.outputs)
            .map(|index| self.graph.outputs()[*index].name.as_str())
            .collect();
        let failed = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("frame {number}: {error}"));
        let plan =
            Plan::new(self.chosen.evaluated(), &names, number, &[], &self.settings).map_err(|error| failed(&error))?;
        let mut made_from =
            || -> Vec<String> { open.iter().map(|file| fingerprints.of(self.graph, file, number)).collect() };
        let before = made_from();
        // EXR files are written while their rows are computed; other files need the whole picture.
        let sink = FileSink::create(self.chosen.evaluated(), &plan, &open)?;
        if sink.is_none() || self.certifies() {
            let account = plan.memory(Pictures::Files);
            let refused = plan.check_memory(&account).err();
            refused.map_or(Ok(()), |error| Err(Failure::evaluated(&format!("frame {number}: "), &error)))?;
        }
        let [rendering, certifying] = [false, true].map(|second| HalfMonitor { monitor: progress, second });
        let monitor: &dyn Monitor = if self.certifies() { &rendering } else { progress };
        let into = sink.as_ref().map(|sink| sink as &dyn Sink);
        let frame = if self.accuracy.by_reference() {
            match plan.evaluate_by_reference(into, cache, monitor) {
                Ok(frame) => Ok(frame),
                Err(ReferenceError::Eval(error)) => Err(error),
                Err(ReferenceError::Plan(error)) => return Err(failed(&error)),
            }
        } else {
            evaluate(&plan, into, cache, monitor)
        };
        let frame = frame.map_err(|error| match error {
            EvalError::Cancelled => Failure::interrupted(),
            EvalError::Sink(error) => error.downcast_ref::<OutputError>().map_or_else(|| failed(&error), Failure::from),
            error => Failure::evaluated(&format!("frame {number}: "), &error),
        })?;
        stop_if_asked()?;
        if made_from() != before {
            // It is unknown which version was read.
            let message = "found an input that changed during rendering; expected the same files from start to end; \
                           nothing is written\n  remedy: render the frame again, for example with --resume";
            return Err(failed(&message));
        }
        let taken = started.elapsed().as_secs_f64();
        let misses = misses(self.graph, &frame, self.required);
        let writing = Instant::now();
        let keeps = |file: &OutputFile| !misses.iter().any(|miss| file.outputs.contains(&miss.output));
        match sink {
            Some(sink) => {
                sink.finish(|file| keeps(file).then(|| fingerprints.metadata(self.graph, file, &frame)))?;
            }
            None => {
                for file in open.iter().filter(|file| keeps(file)) {
                    let metadata = fingerprints.metadata(self.graph, file, &frame);
                    write_output(self.chosen.evaluated(), &frame, file, &metadata)?;
                }
            }
        }
        let mut report = frame_report(self.graph, &frame, writing.elapsed().as_secs_f64());
        let (mut certified, mut proven) = (Vec::new(), Vec::new());
        if self.certifies() {
            let certifying_started = Instant::now();
            let kept: Vec<(&OutputFile, &Companions)> =
                open.iter().zip(&companions).filter(|(file, _)| keeps(file) && !self.chosen.is_recipe(file)).collect();
            let (graph, settings, over) = (self.graph, &self.settings, self.args.files.over);
            let run = CertifyContext { graph, settings, key: self.key.as_ref(), over };
            (certified, proven) = run.run(&frame, &kept, &self.accuracy, cache, fingerprints, &certifying)?;
            report["seconds"]["certify"] = json!(certifying_started.elapsed().as_secs_f64());
            for certified in &certified {
                let name = &self.graph.outputs()[certified.output].name;
                report["outputs"][name]["certified"] = certify::described(self.graph, certified);
            }
        }
        let described = open.iter().zip(&companions).map(|(file, companions)| match keeps(file) {
            true => self.describe(file, "written", Some(companions)),
            false => self.describe(file, "required guarantee missed", None),
        });
        let described: Vec<Value> = described.chain(up_to_date()).collect();
        report["files"] = json!(described);
        let files: Vec<(OutputFile, bool)> = open.iter().map(|file| (file.clone(), keeps(file))).collect();
        let line = line::rendered(self.graph, &frame, &files, &proven, started.elapsed().as_secs_f64());
        if self.accuracy.asked.is_some() || !self.accuracy.set.is_empty() {
            report["accuracy"] = self.accuracy.described(number, taken);
        }
        let misses = misses.iter().map(|miss| {
            format!(
                "error: {miss}\n  remedy: its file was not written; to inspect the picture, render it without the \
                 requirement"
            )
        });
        let misses = misses.chain(self.accuracy.misses(self.graph, number, &certified));
        let replaced = frame.nodes.iter().filter(|node| node.repaired > 0).map(|node| Replaced {
            node: node.name.clone(),
            count: node.repaired,
            first: node.first_repaired.clone(),
        });
        let replaced = replaced.collect();
        let of = |node: &NodeReport| {
            let name = node.name.clone();
            node.unseen.clone().into_iter().map(move |surface| (name.clone(), surface))
        };
        let unseen = frame.nodes.iter().flat_map(of).collect();
        Ok(FrameResult { report, line, misses: misses.collect(), replaced, unseen, skipped: false })
    }

    fn describe(&self, file: &OutputFile, state: &str, companions: Option<&Companions>) -> Value {
        let outputs: Vec<&str> = file.outputs.iter().map(|index| self.graph.outputs()[*index].name.as_str()).collect();
        let mut entry = json!({ "path": file.path.display().to_string(), "outputs": outputs, "state": state });
        companions.into_iter().for_each(|companions| companions.describe(&mut entry));
        entry
    }
}

/// Returns a note on a lone `#` in a pattern at a place where a frame number is unlikely, such as in `take #3.png`.
fn note_of_sign(option: &str, pattern: &str, frame: i64) -> Option<String> {
    let at = pattern.match_indices('#').map(|(at, _)| at).find(|at| !pattern[..*at].ends_with('\\'))?;
    let (before, after) = (pattern[..at].chars().next_back(), pattern[at + 1..].chars().next());
    let ends = |side: Option<char>| matches!(side, Some('.' | '_' | '-' | '#'));
    if after == Some('#') || (ends(before) && ends(after)) {
        return None;
    }
    let written = quoted(&expand_frame(pattern, frame));
    let meant = quoted(&format!("{}\\{}", &pattern[..at], &pattern[at..]));
    Some(format!(
        "note: {option} {}: the # stands for the frame, so the file is {written}\n  remedy: if the # is part of the name: \
         {option} {meant}",
        quoted(pattern)
    ))
}

fn stop_if_asked() -> Result<(), Failure> {
    if interrupt::asked() { Err(Failure::interrupted()) } else { Ok(()) }
}
