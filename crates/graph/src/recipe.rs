//! Recipes: graphs whose colors carry, beside themselves, the weights of all controls that they are mixed from.
//!
//! A picture is Σ ωᵢCᵢ, and its weights ω do not depend on its colors C. So a color that is 1 in one channel, and mixed
//! like any other color, becomes the weight of one control. In a graph with recipes each color has *layers* of three
//! channels, which share all their masks: layer 0 is the color itself; the layers after it hold the weights, three to a
//! layer, of each control and then of all control images together; the last layer, if there are images, is what they
//! contribute to the color. Nodes see a color of more channels and need not know.

use crate::{
    Animated, Arity, CheckedGraph, CheckedNode, Diagnostic, Item, Kind, KnobType, NodeId, OutputSpec, PaletteColor,
    Precision, Record, Setting, Severity, Source, Values,
};

/// A color that pictures are mixed from.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Name in the palette, or else the node and the place in it, such as `sea.stops[1].color`.
    pub name: String,
    /// The color in the working space.
    pub color: Animated,
}

/// What the layers of the colors of a graph with recipes hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipes {
    controls: Vec<Control>,
    has_images: bool,
    /// By node: the layers in which its color may differ from 0.
    reached: Vec<Vec<bool>>,
}

impl Recipes {
    /// Returns the controls, in the order of their weights.
    pub fn controls(&self) -> &[Control] {
        &self.controls
    }

    /// Whether control images contribute to pictures. Then the weight after those of the controls is theirs.
    pub fn has_images(&self) -> bool {
        self.has_images
    }

    /// Returns the number of weights.
    pub fn weights(&self) -> usize {
        self.controls.len() + usize::from(self.has_images)
    }

    /// Returns the number of layers of a color.
    pub fn layers(&self) -> usize {
        1 + self.weights().div_ceil(3) + usize::from(self.has_images)
    }

    /// Returns the layer of what images contribute.
    pub fn image_layer(&self) -> Option<usize> {
        self.has_images.then(|| self.layers() - 1)
    }

    /// Returns a layer of the color of an image, if it is a constant; otherwise it is the image.
    pub fn layer_of_image(&self, layer: usize) -> Option<[f64; 3]> {
        let is_itself = layer == 0 || Some(layer) == self.image_layer();
        (!is_itself).then(|| {
            let unit = self.unit(self.has_images.then_some(self.controls.len()));
            [0, 1, 2].map(|channel| unit[3 * (layer - 1) + channel])
        })
    }

    /// Whether a layer of the color of a node may differ from 0.
    pub fn is_reached(&self, node: NodeId, layer: usize) -> bool {
        self.reached[node.0][layer]
    }

    /// Returns the channels after the color itself of a color that is the control of weight `index`; 0 for none.
    fn unit(&self, index: Option<usize>) -> Vec<f64> {
        let mut unit = vec![0.0; 3 * (self.layers() - 1)];
        if let Some(index) = index {
            unit[index] = 1.0;
        }
        unit
    }
}

impl CheckedGraph {
    /// Returns what the layers of the colors hold, if the graph is one [with recipes](Self::with_recipes).
    pub fn recipes(&self) -> Option<&Recipes> {
        self.recipes.as_ref()
    }

    /// Whether some outputs are recipes.
    pub fn has_recipe(&self, outputs: &[usize]) -> bool {
        outputs.iter().any(|index| self.outputs[*index].is_recipe)
    }

    /// Adds an output with the recipe of another output's color, in halves or floats, and returns its index.
    pub fn add_recipe(&mut self, of: usize, is_float: bool) -> usize {
        let spec = &self.outputs[of];
        let plain = format!("{}-recipe", spec.name);
        let others = (2..).map(|n: usize| format!("{plain}-{n}"));
        let is_free = |name: &String| !self.outputs.iter().any(|output| output.name == *name);
        let name = std::iter::once(plain.clone()).chain(others).find(is_free).unwrap_or_default();
        let precision = is_float.then_some(Precision::Float);
        self.outputs.push(OutputSpec {
            name,
            is_recipe: true,
            file: None,
            layer: None,
            precision,
            require: None,
            ..spec.clone()
        });
        self.outputs.len() - 1
    }

    /// Returns the graph in which those of the given outputs that are recipes are computed, each with all controls of all
    /// of them. Nodes, outputs and their indices stay the same, and so do all other pictures, bit for bit.
    ///
    /// # Errors
    /// The picture is no function of its controls in a way that a recipe can hold.
    pub fn with_recipes(mut self, outputs: &[usize]) -> Result<Self, Vec<Diagnostic>> {
        let roots = outputs.iter().map(|index| &self.outputs[*index]).filter(|spec| spec.is_recipe);
        let upstream = self.upstream(roots.map(|spec| spec.node));
        let colors: Vec<Vec<(String, Animated)>> = self.nodes.iter().map(CheckedNode::colors).collect();
        let mixes: Vec<bool> = (0..self.nodes.len()).map(|index| self.mixes(NodeId(index))).collect();
        let faults: Vec<Diagnostic> = self.recipe_faults(&upstream, &mixes);
        if !faults.is_empty() {
            return Err(faults);
        }
        let is_image = |id: NodeId| self.nodes[id.0].kinds.contains(&Kind::Color) && !mixes[id.0];
        let mut recipes = Recipes {
            has_images: upstream.iter().enumerate().any(|(index, needed)| *needed && is_image(NodeId(index))),
            ..Recipes::default()
        };
        let weights;
        (recipes.controls, weights) = self.numbered(&upstream, &mixes, &colors);
        recipes.reached = self.reached(&recipes, &weights, &mixes);
        for (index, node) in self.nodes.iter_mut().enumerate().filter(|(index, _)| mixes[*index]) {
            let mut weights = weights[index].iter();
            each_color(&mut node.record, node.ty.declaration().items, "", &mut |_, color| {
                let unit = recipes.unit(weights.next().copied().flatten());
                *color = color.map(|values| [values, &unit].concat());
            });
            node.kinds.iter_mut().filter(|kind| **kind == Kind::Color).for_each(|kind| {
                *kind = Kind::Layers(recipes.layers());
            });
        }
        for index in outputs {
            let spec = &mut self.outputs[*index];
            if spec.is_recipe {
                spec.kind = Kind::Layers(recipes.layers() - 1);
            }
        }
        self.recipes = Some(recipes);
        Ok(self)
    }

    /// Returns the colors that the document names or writes for an output's color, each once, and the nodes whose images it
    /// takes colors from.
    pub fn controls(&self, output: usize) -> (Vec<Control>, Vec<&str>) {
        let spec = &self.outputs[output];
        if !matches!(spec.kind, Kind::Color | Kind::Layers(_)) {
            return Default::default();
        }
        let upstream = self.upstream([spec.node]);
        let colors: Vec<Vec<(String, Animated)>> = self.nodes.iter().map(CheckedNode::colors).collect();
        let mixes: Vec<bool> = (0..self.nodes.len()).map(|index| self.mixes(NodeId(index))).collect();
        let (mut controls, _) = self.numbered(&upstream, &mixes, &colors);
        // In a graph with recipes, weights follow.
        controls.iter_mut().for_each(|control| control.color = control.color.map(|values| values[..3].to_vec()));
        let images = self
            .nodes
            .iter()
            .enumerate()
            .filter(|(index, node)| upstream[*index] && !mixes[*index] && node.kinds.contains(&Kind::Color));
        (controls, images.map(|(_, node)| &*node.name).collect())
    }

    /// Lists the colors of the nodes upstream that mix colors: those of the palette, then those that nodes have of their
    /// own. Also returns, by node, the index of each of its literal colors.
    fn numbered(
        &self,
        upstream: &[bool],
        mixes: &[bool],
        colors: &[Vec<(String, Animated)>],
    ) -> (Vec<Control>, Vec<Vec<Option<usize>>>) {
        let mut controls = Vec::new();
        let mut numbers: Vec<Vec<Option<usize>>> = colors.iter().map(|colors| vec![None; colors.len()]).collect();
        let places = |named: &PaletteColor| -> Vec<(usize, usize)> {
            let place = |(node, item): (NodeId, &str)| {
                let at = colors[node.0].iter().position(|(name, _)| name == item)?;
                (upstream[node.0] && mixes[node.0]).then_some((node.0, at))
            };
            named.uses.iter().filter_map(|used| place((used.node, &used.item))).collect()
        };
        for named in &self.palette {
            let places = places(named);
            if !places.is_empty() {
                places.iter().for_each(|(node, at)| numbers[*node][*at] = Some(controls.len()));
                controls.push(Control { name: named.name.clone(), color: named.color.clone() });
            }
        }
        for (index, node) in self.nodes.iter().enumerate().filter(|(index, _)| upstream[*index] && mixes[*index]) {
            for ((item, color), number) in colors[index].iter().zip(&mut numbers[index]) {
                if number.is_none() {
                    *number = Some(controls.len());
                    controls.push(Control { name: format!("{}.{item}", node.name), color: color.clone() });
                }
            }
        }
        (controls, numbers)
    }

    /// Whether a node makes a color of other colors, or of a control: then it has layers. Other colors are images.
    fn mixes(&self, id: NodeId) -> bool {
        let is_color = |kind: &Kind| matches!(kind, Kind::Color | Kind::Layers(_));
        let node = self.node(id);
        let takes_color = node.record.sources().into_iter().any(|source| match source {
            Source::Color(_) => true,
            Source::Output { node, output } => is_color(&self.node(*node).kinds[*output]),
            _ => false,
        });
        let is_color = node.kinds.iter().any(is_color);
        is_color && (takes_color || self.settle(id, self.first).pointwise().is_some())
    }

    /// Finds colors of the palette on which pictures do not depend as on a control.
    fn recipe_faults(&self, upstream: &[bool], mixes: &[bool]) -> Vec<Diagnostic> {
        let mut faults = Vec::new();
        for named in &self.palette {
            for used in named.uses.iter().filter(|used| upstream[used.node.0]) {
                let node = self.node(used.node);
                if !node.kinds.contains(&Kind::Color) || (used.is_whole && mixes[used.node.0]) {
                    continue;
                }
                let (found, remedy) = if mixes[used.node.0] {
                    ("in a key", "key the color in the palette, and use its name alone here".into())
                } else {
                    ("as part of an image", format!("write the color itself, {}, or leave it out", used.item))
                };
                let item = used.item.split(['[', '.']).next().unwrap_or_default();
                let place = self.place_of(used.node, Some(item));
                faults.push(Diagnostic {
                    severity: Severity::Error,
                    file: place.document.to_string(),
                    is_assigned: false,
                    line: place.line,
                    column: place.column,
                    node: Some(node.name.clone()),
                    port: Some(used.item.clone()),
                    found: format!("\"palette.{}\" {found}, in a picture with a recipe", named.name),
                    expected: "colors that are mixed, each by one name".into(),
                    remedy,
                    means: None,
                    used: None,
                });
            }
        }
        faults
    }

    /// Finds the layers in which the color of each node may differ from 0.
    fn reached(&self, recipes: &Recipes, weights: &[Vec<Option<usize>>], mixes: &[bool]) -> Vec<Vec<bool>> {
        let mut reached = vec![vec![false; recipes.layers()]; self.nodes.len()];
        for &id in &self.order {
            let node = self.node(id);
            if !node.kinds.contains(&Kind::Color) {
                continue;
            }
            let mut own = vec![false; recipes.layers()];
            own[0] = true;
            weights[id.0].iter().flatten().for_each(|weight| own[1 + weight / 3] = true);
            if !mixes[id.0] {
                own.iter_mut().enumerate().for_each(|(layer, own)| {
                    *own = recipes.layer_of_image(layer).is_none_or(|color| color != [0.0; 3]);
                });
            }
            node.record.each_node(|input| {
                own.iter_mut().zip(&reached[input.0]).for_each(|(own, input)| *own |= input);
            });
            reached[id.0] = own;
        }
        reached
    }
}

impl CheckedNode {
    /// Returns the literal colors of the node, each with its place.
    fn colors(&self) -> Vec<(String, Animated)> {
        let mut found = Vec::new();
        let mut record = self.record.clone();
        each_color(&mut record, self.ty.declaration().items, "", &mut |place, color| {
            found.push((place, color.clone()));
        });
        found
    }
}

/// Calls `f` with every literal color of a node, and its place, such as `stops[1].color`.
fn each_color<N>(record: &mut Record<N>, items: &[Item], within: &str, f: &mut impl FnMut(String, &mut N)) {
    let is_color = |name: &str| {
        let mut knobs = items.iter().filter_map(|item| if let Item::Knob(knob) = item { Some(knob) } else { None });
        knobs.any(|knob| knob.name == name && matches!(knob.takes, KnobType::Color))
    };
    for (name, setting) in record.knobs.iter_mut().filter(|(name, _)| is_color(name)) {
        if let Setting::Numeric(color) = setting {
            f(format!("{within}{name}"), color);
        }
    }
    for (name, sources) in &mut record.ports {
        let is_list = items.iter().any(|item| match item {
            Item::Port(port) => port.name == *name && matches!(port.arity, Arity::Many { .. }),
            _ => false,
        });
        for (index, source) in sources.iter_mut().enumerate() {
            if let Source::Color(color) = source {
                f(if is_list { format!("{within}{name}[{index}]") } else { format!("{within}{name}") }, color);
            }
        }
    }
    for (name, records) in &mut record.lists {
        let list = items.iter().find_map(|item| match item {
            Item::List(list) if list.name == *name => Some(list.items),
            _ => None,
        });
        for (index, record) in records.iter_mut().enumerate() {
            each_color(record, list.unwrap_or_default(), &format!("{within}{name}[{index}]."), f);
        }
    }
}

impl Values {
    /// Returns the values of a node in one layer of its colors.
    pub(crate) fn of_layer(mut self, items: &[Item], layer: usize) -> Self {
        each_color(&mut self, items, "", &mut |_, color| *color = color[3 * layer..3 * layer + 3].to_vec());
        self
    }
}
