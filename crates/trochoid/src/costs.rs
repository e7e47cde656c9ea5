//! Measured costs of the nodes of an output, and the time saved by leaving work out.

use std::time::{Duration, Instant};
use trochoid_engine::{Buffers, Cache, EvalError, Frame, Monitor, Plan, PlanError, Settings, State, Switches};
use trochoid_graph::CheckedGraph;
use trochoid_image::Format;

/// Measured cost of evaluating an output: as planned, and with nothing left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Costs {
    /// Format of the measured picture.
    pub format: Format,
    /// Number of runs of each kind; all times are the minimum over the runs.
    pub runs: usize,
    /// Seconds for the frame as planned.
    pub seconds: f64,
    /// Seconds for the frame with nothing left out.
    pub seconds_in_full: f64,
    /// Seconds by which runs of one kind differed.
    pub spread: f64,
    /// Cost of each node of the graph.
    pub nodes: Vec<Cost>,
}

/// Measured cost of a node, in seconds summed over all threads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// As planned; `None` if the node was left out.
    pub seconds: Option<f64>,
    /// With nothing left out; `None` if the node is never evaluated, because it is not connected to the output or not
    /// chosen.
    pub seconds_in_full: Option<f64>,
    /// Seconds by which runs of one kind differed; smaller differences are not significant.
    pub spread: f64,
    /// Whether the times are shares of the fused program's time, estimated from the cost of the node's operations.
    pub estimated: bool,
}

impl Cost {
    /// Returns the seconds saved by leaving out the node, or its unrequested channels. Values below [`Cost::spread`]
    /// are not significant, and may be negative.
    pub fn saved(&self) -> Option<f64> {
        Some(self.seconds_in_full? - self.seconds.unwrap_or(0.0))
    }
}

/// Reason that costs cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// The output cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The output cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
}

/// Maximum number of runs of each kind, and the time after which no further run starts.
const RUNS: usize = 3;
const PATIENCE: Duration = Duration::from_secs(10);

/// Evaluates an output at a frame, alternately as planned and with nothing left out, and measures the time of each
/// node.
///
/// The picture is reduced so that neither side exceeds `largest` pixels. If that fails because the document reads files
/// that must have the size of the picture, it is evaluated at full size. Nothing is cached between runs.
///
/// # Errors
/// The output does not exist or cannot be evaluated.
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
    let small = Format::new(size[0], size[1], whole.samples()).map(|format| format.sampled_like(whole));
    match small {
        Ok(small) if scale > 1 => match at(&graph.clone().with_format(small), output, frame, monitor) {
            Err(MeasureError::Evaluate(EvalError::Node { .. })) => at(graph, output, frame, monitor),
            costs => costs,
        },
        _ => at(graph, output, frame, monitor),
    }
}

/// Measures at the graph's own format.
fn at(graph: &CheckedGraph, output: &str, frame: i64, monitor: &dyn Monitor) -> Result<Costs, MeasureError> {
    let plan = |switches: Switches| {
        let mut settings = Settings::default();
        settings.switches = switches;
        Plan::new(graph, &[output], frame, &[], &settings)
    };
    // Only optimizations that leave something out are disabled: the rest must run at full speed to be comparable.
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

/// Returns a frame with the times of each phase and node that `choose` selects from two frames.
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
