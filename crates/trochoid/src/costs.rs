//! What the nodes of an output take, and what leaving out saves.

use std::time::{Duration, Instant};
use trochoid_engine::{Buffers, Cache, EvalError, Frame, Monitor, Plan, PlanError, Settings, State, Switches};
use trochoid_graph::CheckedGraph;
use trochoid_image::Format;

/// What evaluating an output took, measured twice: as planned, and with nothing left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Costs {
    /// The format at which it was measured.
    pub format: Format,
    /// How often; all figures are the least of these.
    pub runs: usize,
    /// Seconds for the frame as planned.
    pub seconds: f64,
    /// Seconds for the frame with nothing left out.
    pub seconds_in_full: f64,
    /// By how many seconds runs of one kind differed.
    pub spread: f64,
    /// By node of the graph.
    pub nodes: Vec<Cost>,
}

/// What a node took, in seconds of all threads together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// As planned; `None` where it was left out.
    pub seconds: Option<f64>,
    /// With nothing left out; `None` where it is not connected to the output, or not chosen, and so never evaluated.
    pub seconds_in_full: Option<f64>,
    /// By how many seconds runs of one kind differed: a difference below that says nothing.
    pub spread: f64,
    /// Whether these are shares of the fused program's time, by the cost of the node's operations.
    pub estimated: bool,
}

impl Cost {
    /// What leaving out saved of this node: all of it, or the channels of it that nobody asked for. May be anything below
    /// [`Cost::spread`], even negative.
    pub fn saved(&self) -> Option<f64> {
        Some(self.seconds_in_full? - self.seconds.unwrap_or(0.0))
    }
}

/// Why costs cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// There is no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// It cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
}

/// Most runs of each kind, and after how long there is no further one.
const RUNS: usize = 3;
const PATIENCE: Duration = Duration::from_secs(10);

/// Evaluates an output at a frame, in turns as planned and with nothing left out, and says what each node took.
///
/// The picture is made smaller, so that neither side passes `largest` pixels; where that fails, since files of the size
/// of the picture are read, it is evaluated as large as it is. Nothing is kept between runs.
///
/// # Errors
/// There is no such output, or it cannot be evaluated.
///
/// ```
/// use trochoid::{Fate, LeftOut, Plan, Settings, Silent, measure, parse};
///
/// let document = r##"{
///   "trochoid": 1,
///   "format": { "width": 64, "height": 32 },
///   "nodes": {
///     "across": { "type": "ScreenX" },
///     "grain": { "type": "Grain" },
///     "old": { "type": "Mix", "a": "#222222", "b": "#885533", "weight": "grain" },
///     "beauty": { "type": "Mix", "a": "#ffffff", "b": "old", "weight": "never" },
///     "never": { "type": "Clamp", "field": "across", "min": 2, "max": 3 }
///   },
///   "outputs": { "beauty": { "color": "beauty" } }
/// }"##;
/// let graph = parse("old.json", document, std::path::Path::new("."), &[])?.graph;
/// let (_, accounts) = Plan::explained(&graph, &["beauty"], 1, &[], &Settings::default())?;
/// let grain = &accounts[graph.find("grain").unwrap().0];
/// assert_eq!(grain.fate, Fate::LeftOut(LeftOut::Weight("beauty".into())));
/// // The weight is 0 because "across", which is at most 1, never reaches 2.
/// assert_eq!((grain.proof[0].node.as_str(), grain.proof[0].interval.high), ("never", 0.0));
/// assert_eq!((grain.proof[1].node.as_str(), grain.proof[1].interval.high), ("across", 1.0));
/// let costs = measure(&graph, "beauty", 1, 32, &Silent)?;
/// let grain = costs.nodes[graph.find("grain").unwrap().0];
/// assert!(grain.seconds.is_none() && grain.saved() > Some(0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(
    graph: &CheckedGraph,
    output: &str,
    frame: i64,
    largest: u32,
    monitor: &dyn Monitor,
) -> Result<Costs, MeasureError> {
    let whole = graph.format();
    let scale = whole.width().max(whole.height()).div_ceil(largest.max(1));
    let size = [whole.width(), whole.height()].map(|side| (side / scale).max(1));
    let small = Format::new(size[0], size[1], whole.samples()).map(|format| format.with_shading(whole.shading()));
    match small {
        Ok(small) if scale > 1 => match at(&graph.clone().with_format(small), output, frame, monitor) {
            Err(MeasureError::Evaluate(EvalError::Node { .. })) => at(graph, output, frame, monitor),
            costs => costs,
        },
        _ => at(graph, output, frame, monitor),
    }
}

/// At the graph's own format.
fn at(graph: &CheckedGraph, output: &str, frame: i64, monitor: &dyn Monitor) -> Result<Costs, MeasureError> {
    let plan = |switches: Switches| {
        let mut settings = Settings::default();
        settings.switches = switches;
        Plan::new(graph, &[output], frame, &[], &settings)
    };
    // Only what leaves something out is switched off: the rest must run as fast as ever to be compared.
    let nothing = Switches { demand: false, prune: false, fold: false, merge: false, ..Switches::ALL };
    let plans = [plan(Switches::ALL)?, plan(nothing)?];
    let mut bounds: [Option<[Frame; 2]>; 2] = [None, None];
    let (started, mut runs) = (Instant::now(), 0);
    while runs < RUNS && (runs == 0 || started.elapsed() < PATIENCE) {
        for (plan, bounds) in plans.iter().zip(&mut bounds) {
            let found = plan.evaluate(&Buffers::new(), &mut Cache::new(), monitor)?;
            let [least, most] = bounds.take().unwrap_or_else(|| [found.clone(), found.clone()]);
            *bounds = Some([merged(least, &found, f64::min), merged(most, &found, f64::max)]);
        }
        runs += 1;
    }
    let [[planned, planned_most], [full, full_most]] = bounds.map(Option::unwrap_or_default);
    let seconds = |frame: &Frame| frame.seconds.prepare + frame.seconds.hull + frame.seconds.tiles;
    let spread = (seconds(&planned_most) - seconds(&planned)).max(seconds(&full_most) - seconds(&full));
    let of = |report: &trochoid_engine::NodeReport| match report.state {
        State::LeftOut(_) => None,
        _ => Some(report.seconds),
    };
    let nodes = (0..graph.nodes().len()).map(|node| {
        let [planned, planned_most, full, full_most] =
            [&planned, &planned_most, &full, &full_most].map(|frame| &frame.nodes[node]);
        Cost {
            seconds: of(planned),
            seconds_in_full: of(full),
            spread: (planned_most.seconds - planned.seconds).max(full_most.seconds - full.seconds),
            estimated: planned.estimated || full.estimated,
        }
    });
    Ok(Costs {
        format: graph.format(),
        runs,
        seconds: seconds(&planned),
        seconds_in_full: seconds(&full),
        spread,
        nodes: nodes.collect(),
    })
}

/// A frame with the times of each phase and node that `choose` takes of both.
fn merged(mut frame: Frame, other: &Frame, choose: fn(f64, f64) -> f64) -> Frame {
    let merge = |time: &mut f64, other: f64| *time = choose(*time, other);
    merge(&mut frame.seconds.prepare, other.seconds.prepare);
    merge(&mut frame.seconds.hull, other.seconds.hull);
    merge(&mut frame.seconds.tiles, other.seconds.tiles);
    for (node, other) in frame.nodes.iter_mut().zip(&other.nodes) {
        merge(&mut node.seconds, other.seconds);
    }
    frame
}
