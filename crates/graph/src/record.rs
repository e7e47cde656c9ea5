//! Knobs and connections of a node: over all frames, and at one frame.

use crate::Animated;
use trochoid_key::{ContentKey, Key, KeyHasher};

/// Index of a node in its graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub usize);

/// Source of a port's value.
#[derive(Clone, Debug, PartialEq)]
pub enum Source<N = Animated> {
    /// An output of another node.
    Output {
        /// The node.
        node: NodeId,
        /// Index of its output.
        output: usize,
    },
    /// A literal number.
    Number(N),
    /// A literal color in the working space.
    Color(N),
    /// Literal weights of a partition, divided by their sum.
    Numbers(Vec<f64>),
}

/// Value of a knob. Numbers have type `N`: animated in a checked graph, plain at one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting<N = Animated> {
    /// Number, whole number, color or vector.
    Numeric(N),
    /// Boolean value.
    Bool(bool),
    /// Word, string or path.
    Text(String),
    /// List of numbers.
    Numbers(Vec<f64>),
    /// List of strings.
    Texts(Vec<String>),
    /// No value: not set, and without a default.
    Unset,
}

/// Knobs, ports and lists of a node, or of one record of a list, in declaration order.
#[derive(Clone, Debug, PartialEq)]
pub struct Record<N = Animated> {
    pub(crate) knobs: Vec<(&'static str, Setting<N>)>,
    pub(crate) ports: Vec<(&'static str, Vec<Source<N>>)>,
    pub(crate) lists: Vec<(&'static str, Vec<Record<N>>)>,
}

impl<N> Default for Record<N> {
    fn default() -> Self {
        Self { knobs: Vec::new(), ports: Vec::new(), lists: Vec::new() }
    }
}

/// A record with every key evaluated at one frame.
pub type Values = Record<Vec<f64>>;

impl<N> Record<N> {
    /// Returns the ports and their connections, without the ports within lists.
    pub fn ports(&self) -> impl Iterator<Item = (&'static str, &[Source<N>])> {
        self.ports.iter().map(|(name, sources)| (*name, sources.as_slice()))
    }

    /// Returns every connection, including those within lists, in declaration order.
    pub fn sources(&self) -> Vec<&Source<N>> {
        let mut sources = Vec::new();
        self.each_source(&mut |source| sources.push(source));
        sources
    }

    /// Calls `f` with every connection, including those within lists, in declaration order.
    pub fn each_source<'r>(&'r self, f: &mut impl FnMut(&'r Source<N>)) {
        self.ports.iter().flat_map(|(_, sources)| sources).for_each(&mut *f);
        for record in self.lists.iter().flat_map(|(_, records)| records) {
            record.each_source(f);
        }
    }

    /// Calls `f` with every connected node, once per connection.
    pub fn each_node(&self, mut f: impl FnMut(NodeId)) {
        self.each_source(&mut |source| {
            if let Source::Output { node, .. } = source {
                f(*node);
            }
        });
    }

    /// Returns the connections of a port: none if an optional port is open.
    ///
    /// # Panics
    /// The node type declares no such port.
    pub fn all(&self, port: &str) -> &[Source<N>] {
        find::<Vec<_>>(&self.ports, port)
    }

    /// Returns the records of a list.
    ///
    /// # Panics
    /// The node type declares no such list.
    pub fn list(&self, name: &str) -> &[Self] {
        find::<Vec<_>>(&self.lists, name)
    }

    fn setting(&self, knob: &str) -> &Setting<N> {
        find(&self.knobs, knob)
    }

    /// Whether the knob has a value.
    pub fn is_set(&self, knob: &str) -> bool {
        !matches!(self.setting(knob), Setting::Unset)
    }

    /// Returns a Boolean value; `false` if unset.
    pub fn bool(&self, knob: &str) -> bool {
        matches!(self.setting(knob), Setting::Bool(true))
    }

    /// Returns a word, string or path; empty if unset.
    pub fn text(&self, knob: &str) -> &str {
        if let Setting::Text(text) = self.setting(knob) { text } else { "" }
    }

    /// Returns a list of numbers; empty if unset.
    pub fn numbers(&self, knob: &str) -> &[f64] {
        if let Setting::Numbers(numbers) = self.setting(knob) { numbers } else { &[] }
    }

    /// Returns a list of strings; empty if unset.
    pub fn texts(&self, knob: &str) -> &[String] {
        if let Setting::Texts(texts) = self.setting(knob) { texts } else { &[] }
    }
}

impl<N: Clone> Record<N> {
    /// Returns the record with another word for a choice.
    pub(crate) fn with_word(&self, choice: &str, word: &str) -> Self {
        let mut record = self.clone();
        for (_, setting) in record.knobs.iter_mut().filter(|(name, _)| *name == choice) {
            *setting = Setting::Text(word.into());
        }
        record
    }
}

/// Looks up a declared name. Validation fills in every declared item, so a missing one means that a node asks for an
/// item that it does not declare: a bug in the node, which its first test finds.
fn find<'a, T>(items: &'a [(&'static str, T)], name: &str) -> &'a T {
    match items.iter().find(|item| item.0 == name) {
        Some((_, value)) => value,
        None => unreachable!("the node type does not declare \"{name}\""),
    }
}

impl Record {
    /// Evaluates every animated value at a frame.
    pub fn settle(&self, frame: f64) -> Values {
        Record {
            knobs: self.knobs.iter().map(|(name, setting)| (*name, setting.settle(frame))).collect(),
            ports: self
                .ports
                .iter()
                .map(|(name, sources)| (*name, sources.iter().map(|source| source.settle(frame)).collect()))
                .collect(),
            lists: self
                .lists
                .iter()
                .map(|(name, records)| (*name, records.iter().map(|record| record.settle(frame)).collect()))
                .collect(),
        }
    }

    /// Returns every frame that has a key in this record, and those where a curve turns between keys.
    pub(crate) fn key_frames(&self) -> Vec<f64> {
        let knobs = self.knobs.iter().filter_map(|(_, setting)| match setting {
            Setting::Numeric(animated) => Some(animated),
            _ => None,
        });
        let literals = self.ports.iter().flat_map(|(_, sources)| sources).filter_map(|source| match source {
            Source::Number(animated) | Source::Color(animated) => Some(animated),
            _ => None,
        });
        let of = |animated: &Animated| -> Vec<f64> {
            animated.frames().chain(animated.turns().into_iter().map(|(frame, _)| frame)).collect()
        };
        let mut frames: Vec<f64> = knobs.chain(literals).flat_map(of).collect();
        frames.extend(self.lists.iter().flat_map(|(_, records)| records).flat_map(Record::key_frames));
        frames
    }
}

impl Values {
    /// Redirects every connection to the node that `to` returns for its node.
    pub fn redirect(&mut self, to: &dyn Fn(NodeId) -> NodeId) {
        for source in self.ports.iter_mut().flat_map(|(_, sources)| sources) {
            if let Source::Output { node, .. } = source {
                *node = to(*node);
            }
        }
        self.lists.iter_mut().flat_map(|(_, records)| records).for_each(|record| record.redirect(to));
    }

    fn numeric(&self, knob: &str) -> &[f64] {
        if let Setting::Numeric(values) = self.setting(knob) { values } else { &[] }
    }

    /// Returns a number; 0 if unset.
    pub fn number(&self, knob: &str) -> f64 {
        self.numeric(knob).first().copied().unwrap_or(0.0)
    }

    /// Returns a whole number: an interpolated value is rounded to the nearest.
    pub fn integer(&self, knob: &str) -> i64 {
        self.number(knob).round() as i64
    }

    /// Returns a color in the working space, or a vector of three numbers; 0 if unset.
    pub fn vector3(&self, knob: &str) -> [f64; 3] {
        let values = self.numeric(knob);
        [0, 1, 2].map(|i| values.get(i).copied().unwrap_or(0.0))
    }

    /// Feeds the record to a hash, with the keys of the connected nodes: equal hashes mean equal records.
    pub(crate) fn feed(&self, keys: &[Key], hasher: &mut KeyHasher) {
        let Self { knobs, ports, lists } = self;
        // Every item is fed with its name, and every list after its length, so that none runs into the next.
        knobs.feed(hasher);
        ports.len().feed(hasher);
        for (name, sources) in ports {
            (name, sources.len()).feed(hasher);
            sources.iter().for_each(|source| source.feed(keys, hasher));
        }
        lists.len().feed(hasher);
        for (name, records) in lists {
            (name, records.len()).feed(hasher);
            records.iter().for_each(|record| record.feed(keys, hasher));
        }
    }
}

impl Setting {
    fn settle(&self, frame: f64) -> Setting<Vec<f64>> {
        match self {
            Self::Numeric(animated) => Setting::Numeric(animated.at(frame)),
            Self::Bool(value) => Setting::Bool(*value),
            Self::Text(text) => Setting::Text(text.clone()),
            Self::Numbers(numbers) => Setting::Numbers(numbers.clone()),
            Self::Texts(texts) => Setting::Texts(texts.clone()),
            Self::Unset => Setting::Unset,
        }
    }
}

impl ContentKey for Setting<Vec<f64>> {
    fn feed(&self, hasher: &mut KeyHasher) {
        match self {
            Self::Numeric(values) => (0_u8, values).feed(hasher),
            Self::Numbers(values) => (1_u8, values).feed(hasher),
            Self::Bool(value) => (2_u8, value).feed(hasher),
            Self::Text(word) => (3_u8, word).feed(hasher),
            Self::Texts(words) => (4_u8, words).feed(hasher),
            Self::Unset => 5_u8.feed(hasher),
        }
    }
}

impl Source {
    fn settle(&self, frame: f64) -> Source<Vec<f64>> {
        match self {
            Self::Output { node, output } => Source::Output { node: *node, output: *output },
            Self::Number(animated) => Source::Number(animated.at(frame)),
            Self::Color(animated) => Source::Color(animated.at(frame)),
            Self::Numbers(numbers) => Source::Numbers(numbers.clone()),
        }
    }
}

impl Source<Vec<f64>> {
    /// Returns the number if the source is a literal number.
    pub fn number(&self) -> Option<f64> {
        if let Self::Number(values) = self { values.first().copied() } else { None }
    }

    /// Returns the color if the source is a literal color.
    pub fn color(&self) -> Option<[f64; 3]> {
        if let Self::Color(values) = self { Some([values[0], values[1], values[2]]) } else { None }
    }

    fn feed(&self, keys: &[Key], hasher: &mut KeyHasher) {
        match self {
            Self::Output { node, output } => (0_u8, keys[node.0], output).feed(hasher),
            Self::Number(values) => (1_u8, values).feed(hasher),
            Self::Color(values) => (2_u8, values).feed(hasher),
            Self::Numbers(values) => (3_u8, values).feed(hasher),
        }
    }
}
