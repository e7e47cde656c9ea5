//! Test support for nodes: evaluates small documents at one sample, by the reference and by the lowered program.

use std::path::Path;
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_memory::Scratch;
use trochoid_nodes::inside::{Holding, prepare_read};
use trochoid_weights::arithmetic;

/// Checks a document with these nodes and the output `"out"` of kind `key`. If it has errors, returns their messages.
pub(crate) fn graph(key: &str, nodes: &str, folder: &Path) -> Result<CheckedGraph, String> {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 3 }}, "nodes": {{ {nodes} }},
            "outputs": {{ "out": {{ "{key}": "out" }} }} }}"#
    );
    let document = Document::parse("test.json", &text).map_err(|faults| format!("{faults:?}"))?;
    let registry = Registry::new(trochoid_nodes::all());
    let (graph, faults) = check(&document, &registry, folder);
    let text: Vec<String> = faults.iter().map(|fault| format!("{fault:?}")).collect();
    graph.ok_or_else(|| text.join("\n"))
}

/// The first frame of a graph, with all stages prepared.
pub(crate) struct Frame {
    pub(crate) graph: CheckedGraph,
    pub(crate) context: FrameContext,
    pub(crate) prepared: Vec<Option<Box<dyn Prepared>>>,
}

impl Frame {
    /// Prepares every stage, with all channels requested.
    pub(crate) fn new(graph: CheckedGraph) -> Result<Self, NodeError> {
        Self::near(graph, None)
    }

    /// Prepares every stage likewise, for a part of the picture if one is given.
    pub(crate) fn near(graph: CheckedGraph, part: Option<Window>) -> Result<Self, NodeError> {
        Self::prepared(graph, part, |stage, _, prepare| stage.prepare(prepare))
    }

    /// Prepares every stage likewise, with pictures held so.
    pub(crate) fn held(graph: CheckedGraph, holding: Holding) -> Result<Self, NodeError> {
        Self::prepared(graph, None, |stage, settled, prepare| {
            prepare_read(settled, prepare, holding).unwrap_or_else(|| stage.prepare(prepare))
        })
    }

    fn prepared(
        graph: CheckedGraph,
        part: Option<Window>,
        of: impl Fn(&dyn Stage, &Settled, &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError>,
    ) -> Result<Self, NodeError> {
        let context = graph.frame_context(graph.frames().0, 1 << 30);
        let mut prepared: Vec<Option<Box<dyn Prepared>>> = graph.nodes().iter().map(|_| None).collect();
        let pool = Pool::new();
        for &id in graph.order() {
            let (node, settled) = (graph.node(id), graph.settle(id, context.frame));
            let Some(stage) = settled.stage() else { continue };
            let wanted: Vec<Vec<bool>> = node.kinds.iter().map(|kind| vec![true; kind.channels()]).collect();
            let handles = |id: NodeId| prepared[id.0].as_ref().and_then(|prepared| prepared.handle());
            let prepare = Prepare::new(&context, &node.kinds, &wanted, &handles, &|| false, &pool)
                .with_purpose(Purpose::References)
                .with_part(part);
            let made = of(stage, &settled, &prepare)?;
            prepared[id.0] = Some(made);
        }
        Ok(Self { graph, context, prepared })
    }

    /// Returns the prepared stage of the node with this name.
    pub(crate) fn node(&self, name: &str) -> &dyn Prepared {
        self.prepared[self.graph.find(name).unwrap().0].as_deref().unwrap()
    }

    /// Returns the references of the outputs of the stage "out", whose inputs from other nodes, by their names, are
    /// `given`.
    pub(crate) fn given(&self, at: [f64; 2], given: &dyn Fn(&str, [f64; 2]) -> Reference) -> Vec<Reference> {
        let inputs = |source: &Source<Vec<f64>>, at: [f64; 2]| match source {
            Source::Output { node, .. } => given(&self.graph.node(*node).name, at),
            _ => unreachable!("literals are evaluated where they stand"),
        };
        self.node("out").reference(&References::new(&self.context, at, &inputs)).unwrap()
    }

    /// Returns the mask of the stage "out" by its reference, with inputs that are the same everywhere.
    pub(crate) fn mask_of(&self, given: &dyn Fn(&str) -> Reference) -> f64 {
        match self.given([0.5; 2], &|name, _| given(name))[..] {
            [Reference::Mask(mask)] => mask,
            _ => panic!("\"out\" is no mask"),
        }
    }

    /// Returns the reference value of a node's output, in f64.
    pub(crate) fn reference(&self, id: NodeId, output: usize, at: [f64; 2]) -> Reference {
        let inputs = |source: &Source<Vec<f64>>, at: [f64; 2]| match source {
            Source::Output { node, output } => self.reference(*node, *output, at),
            _ => unreachable!("literals are evaluated where they stand"),
        };
        let references = References::new(&self.context, at, &inputs);
        match (self.graph.settle(id, self.context.frame).pointwise(), &self.prepared[id.0]) {
            (Some(node), _) => node.reference(&references),
            (_, Some(prepared)) => prepared.reference(&references).unwrap().swap_remove(output),
            _ => unreachable!("every stage is prepared"),
        }
    }

    /// Returns the reference value of the node "out" as numbers: the channels of a color, one weight per control, or
    /// the components of a field.
    pub(crate) fn truth(&self, at: [f64; 2]) -> Vec<f64> {
        numbers(self.reference(self.graph.find("out").unwrap(), 0, at))
    }

    /// Returns the value of the node "out" by the lowered program, in f32.
    pub(crate) fn lowered(&self, at: [f64; 2]) -> Vec<f32> {
        let mut program = Program::default();
        let mut values: Vec<Option<Value>> = vec![None; self.graph.nodes().len()];
        for &id in self.graph.order() {
            let value = match self.graph.settle(id, self.context.frame).pointwise() {
                Some(pointwise) => {
                    let inputs = |source: &Source<Vec<f64>>| match source {
                        Source::Output { node, .. } => values[node.0].clone().unwrap(),
                        _ => unreachable!("literals are lowered where they stand"),
                    };
                    let mut lowering = Lowering::new(Builder::new(&mut program, id), &inputs);
                    pointwise.lower(&mut lowering)
                }
                None => load(&mut program, id, 0, self.graph.node(id).kinds[0]).unwrap(),
            };
            values[id.0] = Some(value);
        }
        let out = self.graph.find("out").unwrap();
        let rows: Vec<u32> = match values[out.0].clone().unwrap() {
            Value::Layers(colors) => colors.iter().map(|color| color.0).collect(),
            Value::Color(color) => vec![color.0],
            Value::Field(components) => components.iter().map(|component| component.0).collect(),
            Value::Weights(weights) => {
                (0..weights.ways()).map(|i| Builder::new(&mut program, out).weight(&weights, i).field().0).collect()
            }
        };
        let results = self.run(&program, at);
        rows.into_iter().flat_map(|row| results[row as usize].clone()).collect()
    }

    /// Fills every plane of a stage over the whole picture, which forces files to be read and checked.
    pub(crate) fn fill_all(&self, name: &str) -> Result<(), NodeError> {
        let id = self.graph.find(name).unwrap();
        let block = Block::of(self.context.format.window(), [0.5; 2]);
        let plane = |_| vec![f32::NAN; block.window.area()];
        let kinds = &self.graph.node(id).kinds;
        let mut memory: Vec<Vec<Vec<f32>>> =
            kinds.iter().map(|kind| (0..kind.channels()).map(plane).collect()).collect();
        let planes = memory.iter_mut().map(|planes| planes.iter_mut().map(|plane| Some(&mut plane[..])));
        self.node(name).fill(&block, &Inputs::new(&[]), &mut Outputs::new(planes))
    }

    /// Fills the first channel of a stage at one sample in each pixel of a window.
    pub(crate) fn filled_window(&self, id: NodeId, window: Window, offset: [f64; 2]) -> Vec<f32> {
        let mut plane = vec![f32::NAN; window.area()];
        let prepared = self.prepared[id.0].as_ref().unwrap();
        let outputs = Outputs::new([[Some(&mut plane[..])]]);
        prepared.fill(&Block::of(window, offset), &Inputs::new(&[]), &mut { outputs }).unwrap();
        plane
    }

    /// Fills one channel of a stage at one sample.
    pub(crate) fn filled(&self, id: NodeId, output: usize, channel: usize, at: [f64; 2]) -> f32 {
        let (x, y) = (at[0].floor() as i64, at[1].floor() as i64);
        let block = Block::of(Window::new(x, y, x + 1, y + 1), [at[0].fract(), at[1].fract()]);
        let mut plane = [f32::NAN];
        let mut planes: Vec<Vec<Option<&mut [f32]>>> = Vec::new();
        for kind in &self.graph.node(id).kinds {
            planes.push((0..kind.channels()).map(|_| None).collect());
        }
        planes[output][channel] = Some(&mut plane);
        let prepared = self.prepared[id.0].as_ref().unwrap();
        let ports: Vec<_> = self.graph.node(id).record.ports().map(|_| Scratch::new()).collect();
        prepared.fill(&block, &Inputs::new(&ports), &mut Outputs::new(planes)).unwrap();
        plane[0]
    }

    fn run(&self, program: &Program, at: [f64; 2]) -> Vec<Vec<f32>> {
        let mut results: Vec<Vec<f32>> = Vec::new();
        for (op, _) in program.ops() {
            let row = |position: u32| results[position as usize].clone();
            let one = |scalar: &Scalar| results[scalar.0 as usize][0];
            let result = match op {
                Op::Load(slot) => vec![self.filled(slot.node, slot.output, slot.channel, at)],
                Op::Constant(value) => vec![*value],
                Op::Clamp { x, min, max } => vec![arithmetic::clamp(one(x), *min, *max)],
                Op::Smooth(t) => vec![arithmetic::smooth(one(t))],
                Op::Power { t, p } => vec![arithmetic::power(one(t), *p)],
                Op::Step { x, threshold } => vec![arithmetic::step(one(x), *threshold)],
                Op::Complement(t) => vec![arithmetic::complement(one(t))],
                Op::Product(t, u) => vec![arithmetic::product(one(t), one(u))],
                Op::Partition(weights) => {
                    let mut weights: Vec<f32> = weights.iter().map(one).collect();
                    arithmetic::round_partition(&mut weights);
                    weights
                }
                Op::Normalize { values, floor } => {
                    let values: Vec<f32> = values.iter().map(one).collect();
                    let mut weights = vec![0.0; values.len() + 1];
                    arithmetic::normalize(&values, *floor, &mut weights);
                    weights
                }
                Op::Weight(partition, i) => vec![row(partition.0)[*i]],
                Op::LoadColor(slot) => (0..3).map(|c| self.filled(slot.node, slot.output, c, at)).collect(),
                Op::ConstantColor(color) => color.to_vec(),
                Op::Mix { a, b, t } => {
                    let pairs = row(a.0).into_iter().zip(row(b.0));
                    pairs.map(|(a, b)| arithmetic::mix(a, b, one(t))).collect()
                }
                Op::Blend { colors, weights } => {
                    let weights = row(weights.0);
                    let channel = |c: usize| -> Vec<f32> { colors.iter().map(|color| row(color.0)[c]).collect() };
                    (0..3).map(|c| arithmetic::blend(&channel(c), &weights)).collect()
                }
            };
            results.push(result);
        }
        results
    }
}

/// Prepares a stage that no other feeds, with all channels requested, and with pictures held so if it is a Read.
pub(crate) fn prepare(
    graph: &CheckedGraph,
    name: &str,
    context: &FrameContext,
    holding: Option<Holding>,
    pool: &Pool,
) -> Result<Box<dyn Prepared>, NodeError> {
    let settled = graph.settle(graph.find(name).unwrap(), context.frame);
    let kinds = settled.kinds();
    let wanted: Vec<Vec<bool>> = kinds.iter().map(|kind| vec![true; kind.channels()]).collect();
    let prepare = Prepare::new(context, &kinds, &wanted, &|_| None, &|| false, pool);
    match holding {
        Some(holding) => prepare_read(&settled, &prepare, holding).expect("a Read"),
        None => settled.stage().unwrap().prepare(&prepare),
    }
}

/// Returns the reference of the only output of a stage that no other feeds.
pub(crate) fn sole_reference(
    prepared: &dyn Prepared,
    context: &FrameContext,
    at: [f64; 2],
) -> Result<Vec<f64>, NodeError> {
    let nothing = |_: &Source<Vec<f64>>, _: [f64; 2]| unreachable!("nothing is connected");
    let reference = prepared.reference(&References::new(context, at, &nothing))?.swap_remove(0);
    Ok(numbers(reference))
}

fn numbers(reference: Reference) -> Vec<f64> {
    match reference {
        Reference::Color(color) => color.to_vec(),
        Reference::Mask(t) => vec![1.0 - t, t],
        Reference::Weights(values) | Reference::Field(values) | Reference::View(values) => values,
        Reference::Handle(_) => Vec::new(),
    }
}

/// Returns a view that is covered, with some channels.
pub(crate) fn view(channels: &[(Channel, f64)]) -> Reference {
    let mut numbers: Vec<f64> = Channel::ALL.iter().map(|channel| f64::from(channel.background())).collect();
    for (channel, value) in [(Channel::Coverage, 1.0)].iter().chain(channels) {
        numbers[*channel as usize] = *value;
    }
    Reference::View(numbers)
}

/// Checks and prepares a document with these nodes, which must be valid.
pub(crate) fn frame(key: &str, nodes: &str) -> Frame {
    Frame::new(graph(key, nodes, Path::new(".")).unwrap()).unwrap()
}

/// Asserts that the lowered program agrees with the reference all over the picture, including subpixel samples.
pub(crate) fn agrees(key: &str, nodes: &str) {
    let frame = frame(key, nodes);
    for y in 0..12 {
        for x in 0..16 {
            let at = [f64::from(x) / 4.0 + 0.125, f64::from(y) / 4.0 + 0.125];
            let (truth, found) = (frame.truth(at), frame.lowered(at));
            assert_eq!(truth.len(), found.len());
            if key == "weights" {
                let sum: f32 = found.iter().sum();
                assert!((sum - 1.0).abs() < 1e-6, "{found:?} at {at:?}");
            }
            for (truth, found) in truth.iter().zip(&found) {
                assert!((truth - f64::from(*found)).abs() < 2e-6, "{truth} and {found} at {at:?} of {nodes}");
            }
        }
    }
}

/// Returns numbers from −1 to 1.
pub(crate) fn draws(count: usize, salt: u32) -> Vec<f32> {
    let mut state = salt;
    let mut draw = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| draw()).collect()
}

/// Returns the errors of a document, which must have some.
pub(crate) fn refused(key: &str, nodes: &str) -> String {
    match graph(key, nodes, Path::new(".")) {
        Err(faults) => faults,
        Ok(_) => panic!("accepted: {nodes}"),
    }
}
