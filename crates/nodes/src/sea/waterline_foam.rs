//! WaterlineFoam: foam where objects pierce the water or lie just below it.

use super::check_same_camera;
use trochoid_graph::*;

/// A mask of foam along waterlines: where an object is close behind or below the water's surface.
///
/// # Formula
/// t = (d' − d)/(distance·(1 + edge)), with d and d' the depths of `view` and `behind`; with `measure` height, d' − d
/// is the height of the water above what is behind it. The mask is 1 up to t = `solid` and falls to 0 at t = 1.
///
/// # Edge cases
/// 0 where `view` sees no water, where something in `behind` hides the water, where nothing lies behind it, and where
/// 1 + edge ≤ 0. `solid` 1 gives a line with a hard edge; the source's line is distance 0.7, solid 1. If `view` also
/// contains the objects, foam covers all of them: use a view of the water alone.
///
/// # Source
/// Creation of a cartoon shader of water for the web, part 2: foamLine = clamp(screenDepth − worldDepth, 0, 1).
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, example = r#""behind": "shore""#, output(mask: Kind::MASK = "The foam."))]
pub(crate) struct WaterlineFoam {
    /// View of the water alone.
    view: One<port::View>,
    /// View of the other surfaces without the water, by the same camera.
    behind: One<port::View>,
    /// Relative widening of the foam; animated noise makes a ragged, lively edge. 0 if not connected.
    edge: Optional<port::Scalar>,
    /// Maximum distance behind the water at which objects make foam.
    #[knob(default = 1.0, range = 1e-9..=1e9, unit = "m")]
    distance: f64,
    /// Share of the distance up to which foam is solid.
    #[knob(default = 0.0, range = 0.0..=1.0)]
    solid: f64,
    /// Direction of the distance: "depth" measures along the view, as in the source; "height" measures straight down,
    /// the same from every side.
    measure: Measure,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Measure {
    Depth,
    Height,
}

impl WaterlineFoam {
    /// Returns the views of the water and of the surfaces behind it.
    fn views(&self) -> [&One<port::View>; 2] {
        [&self.view, &self.behind]
    }
}

impl Node for WaterlineFoam {
    fn check(&self, check: &mut Check<'_>) {
        check_same_camera(self.views(), check);
        if *self.view == *self.behind {
            let found = "the same view as \"view\", so foam would cover everything";
            let remedy = "connect a Render with the same camera and all surfaces but the water";
            check.error(Self::BEHIND, found, "a view without the water", remedy);
        }
    }
}

impl Stage for WaterlineFoam {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        match self.measure {
            Measure::Depth => Channel::Depth.into(),
            Measure::Height => ChannelSet::of(&[Channel::Depth, Channel::PositionY]),
        }
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let foam = Foam { distance: self.distance, solid: self.solid };
        Ok(Box::new(PreparedWaterlineFoam { node: self.clone(), foam }))
    }
}

#[derive(Clone, Copy, Debug)]
struct Foam {
    distance: f64,
    solid: f64,
}

impl Foam {
    /// Returns the mask at one sample, given the depths of the water and of what lies behind it, their distance apart,
    /// and the edge.
    fn mask(self, [water, behind]: [f64; 2], apart: f64, edge: f64) -> f64 {
        let reach = self.distance * (1.0 + edge).max(0.0);
        // Depth is +∞ where nothing is seen.
        if water == f64::INFINITY || behind == f64::INFINITY || behind < water || reach <= 0.0 {
            return 0.0;
        }
        let t = apart.max(0.0) / reach;
        if t <= self.solid {
            1.0
        } else if t < 1.0 {
            (1.0 - t) / (1.0 - self.solid)
        } else {
            0.0
        }
    }

    /// Returns the range of the mask for inputs that lie anywhere in the given spans.
    fn span(self, [water, behind]: [Span; 2], apart: Span, edge: Span) -> Span {
        if water.low == f64::INFINITY || behind.low == f64::INFINITY || behind.high < water.low {
            return Span::exactly(0.0);
        }
        if apart.low.is_nan() || apart.high.is_nan() || edge.low.is_nan() || edge.high.is_nan() {
            return Span::unclear(0.0, 1.0);
        }
        // Depths with the water in front: foam rises with the edge and falls with the distance.
        let nearer = [0.0, 1.0];
        let lost = LOST * (apart.low.abs() + apart.high.abs()).min(f64::MAX);
        let [thin, thick] = [apart.high + lost, apart.low - lost];
        let ends = [self.mask(nearer, thin, edge.low), self.mask(nearer, thick, edge.high)];
        let is_seen = water.high < f64::INFINITY && behind.high < f64::INFINITY && behind.low >= water.high;
        let low = if is_seen { ends[0] } else { 0.0 };
        if low == ends[1] && (low == 0.0 || low == 1.0) {
            return Span::exactly(low);
        }
        let clear = [water, behind, apart, edge].iter().all(|span| span.clear) && is_seen && self.solid < 1.0;
        Span { low, high: ends[1], clear }.wider(LOST / (1.0 - self.solid).max(LOST)).within(0.0, 1.0)
    }
}

/// Rounding error of a share.
const LOST: f64 = 1e-15;

struct PreparedWaterlineFoam {
    node: WaterlineFoam,
    foam: Foam,
}

impl Prepared for PreparedWaterlineFoam {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let planes = |channel| self.node.views().map(|view| inputs.view(view, channel));
        let depths = planes(Channel::Depth);
        let heights = match self.node.measure {
            Measure::Depth => None,
            Measure::Height => Some(planes(Channel::PositionY)),
        };
        let edge = inputs.all(&self.node.edge).first().and_then(|connection| connection.planes[0]);
        for (index, mask) in mask.iter_mut().enumerate() {
            let [water, behind] = depths.map(|plane| f64::from(plane[index]));
            let apart =
                heights.map_or(behind - water, |[water, behind]| f64::from(water[index]) - f64::from(behind[index]));
            let edge = edge.map_or(0.0, |plane| f64::from(plane[index]));
            *mask = self.foam.mask([water, behind], apart, edge) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            let of = |channel: Channel| {
                let background = Span::exactly(f64::from(channel.background()));
                let known = |view| bounding.known(view, channel as usize, sample).unwrap_or(background);
                self.node.views().map(known)
            };
            let depths = of(Channel::Depth);
            let apart = match self.node.measure {
                Measure::Depth => depths[1] - depths[0],
                Measure::Height => {
                    let [above, below] = of(Channel::PositionY);
                    above - below
                }
            };
            self.foam.span(depths, apart, bounding.known(&self.node.edge, 0, sample).unwrap_or(Span::exactly(0.0)))
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let of = |channel| self.node.views().map(|view| inputs.view(view, channel));
        let [water, behind] = of(Channel::Depth);
        let apart = match self.node.measure {
            Measure::Depth => behind - water,
            Measure::Height => {
                let [above, below] = of(Channel::PositionY);
                above - below
            }
        };
        let edge = self.node.edge.as_ref().map_or(0.0, |source| inputs.scalar(source));
        Ok(vec![Reference::Mask(self.foam.mask([water, behind], apart, edge))])
    }
}
