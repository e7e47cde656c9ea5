//! Fields of nodes: what `#[derive(Node)]` reads ports and knobs into.

use crate::{Accepts, Item, Output, Setting, Source, Values};
use std::marker::PhantomData;
use std::ops::Deref;

/// Ports and knobs that are declared together: those of a node, of a record of a list, or what several nodes share.
///
/// Made by `#[derive(Items)]`, and by `#[derive(Node)]`.
pub trait Items: Clone + Send + Sync + 'static {
    /// What they are, in the order in which they are shown.
    const ITEMS: &'static [Item];

    /// Their values, in that order.
    fn read(reader: &mut Reader<'_>) -> Self;
}

/// A knob that takes one of several words. Made by `#[derive(Choice)]`.
pub trait Choice: Read + 'static {
    /// The words in documents; the first is the default.
    const WORDS: &'static [&'static str];

    /// The word of a value.
    fn word(&self) -> &'static str;
}

/// The outputs of a node. Made by `#[derive(Outputs)]`.
pub trait OutputSet {
    /// What they are; the first is meant where a reference names the node alone.
    const OUTPUTS: &'static [Output];
}

/// The output of a node that has one: `outputs.take(Only, 0)`.
#[derive(Clone, Copy, Debug)]
pub struct Only;

impl From<Only> for usize {
    fn from(Only: Only) -> Self {
        0
    }
}

/// The name of a declared port, knob or list: `Mix::WEIGHT`, one a field of the struct that declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ItemName(&'static str);

impl ItemName {
    /// For derived code, which alone knows what is declared.
    #[doc(hidden)]
    pub const fn declared(name: &'static str) -> Self {
        Self(name)
    }

    /// The key in documents.
    pub fn as_str(self) -> &'static str {
        self.0
    }
}

impl std::fmt::Display for ItemName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

/// One of a node's ports: those within lists have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PortId {
    /// Its place among the node's ports.
    index: usize,
    name: &'static str,
}

impl PortId {
    /// The port of that name, which stands at a place among its node's ports.
    pub fn new(index: usize, name: &'static str) -> Self {
        Self { index, name }
    }

    /// Its place among the node's ports.
    pub fn index(self) -> usize {
        self.index
    }

    /// The key in documents.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The same, as faults name it.
    pub fn item(self) -> ItemName {
        ItemName(self.name)
    }
}

/// What a port takes, as a type: `One<port::Mask>`.
pub trait Accepted: Send + Sync + 'static {
    /// The same as a value.
    const ACCEPTS: Accepts;
}

/// What ports take, as types.
pub mod port {
    macro_rules! kinds {
        ($($name:ident)*) => {$(
            #[doc = concat!("[`Accepts::", stringify!($name), "`](crate::Accepts::", stringify!($name), ").")]
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub enum $name {}

            impl super::Accepted for $name {
                const ACCEPTS: crate::Accepts = crate::Accepts::$name;
            }
        )*};
    }

    kinds! { Color Mask Weights Scalar Field Direction Image Surface Camera Light View }
}

/// A port of a node.
pub trait Connected {
    /// What it takes.
    const ACCEPTS: Accepts;

    /// Which of the node's ports it is.
    fn id(&self) -> PortId;

    /// What is connected to it, or written in its place.
    fn sources(&self) -> &[Source<Vec<f64>>];
}

macro_rules! ports {
    ($($(#[$doc:meta])* $name:ident holds $held:ty;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name<A> {
            id: PortId,
            held: $held,
            accepts: PhantomData<A>,
        }

        impl<A> Deref for $name<A> {
            type Target = $held;

            fn deref(&self) -> &$held {
                &self.held
            }
        }

        impl<A: Accepted> ReadPort for $name<A> {
            fn read(id: PortId, sources: &[Source<Vec<f64>>]) -> Self {
                Self { id, held: <$held>::held(sources), accepts: PhantomData }
            }
        }

        impl<A: Accepted> Connected for $name<A> {
            const ACCEPTS: Accepts = A::ACCEPTS;

            fn id(&self) -> PortId {
                self.id
            }

            fn sources(&self) -> &[Source<Vec<f64>>] {
                self.held.all()
            }
        }
    )*};
}

ports! {
    /// A port with one connection.
    One holds Source<Vec<f64>>;
    /// A port with one connection, or none.
    Optional holds Option<Source<Vec<f64>>>;
    /// A port with several connections.
    Many holds Vec<Source<Vec<f64>>>;
}

/// How a port holds what is connected to it.
trait Held {
    fn held(sources: &[Source<Vec<f64>>]) -> Self;
    fn all(&self) -> &[Source<Vec<f64>>];
}

impl Held for Source<Vec<f64>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        // A port that is open though it must not be is a fault of its document, which is told elsewhere.
        sources.first().cloned().unwrap_or(Source::Number(vec![0.0]))
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        std::slice::from_ref(self)
    }
}

impl Held for Option<Source<Vec<f64>>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        sources.first().cloned()
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        self.as_slice()
    }
}

impl Held for Vec<Source<Vec<f64>>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        sources.to_vec()
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        self
    }
}

/// A port as a [`Reader`] reads it.
pub trait ReadPort {
    /// The port, of what is connected to it.
    fn read(id: PortId, sources: &[Source<Vec<f64>>]) -> Self;
}

/// A knob's value as a [`Reader`] reads it.
///
/// Any setting is read: of one that the knob does not take, which is a fault of its document, something legal.
pub trait Read: Clone + Send + Sync {
    /// The value of a setting.
    fn read(setting: &Setting<Vec<f64>>) -> Self;
}

impl Read for f64 {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Numeric(values) = setting { values.first().copied().unwrap_or(0.0) } else { 0.0 }
    }
}

impl Read for i64 {
    /// A keyed one is rounded to the nearest.
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        f64::read(setting).round() as Self
    }
}

impl Read for bool {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        matches!(setting, Setting::Bool(true))
    }
}

impl Read for String {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Text(text) = setting { text.clone() } else { Self::new() }
    }
}

impl<const N: usize> Read for [f64; N] {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        let values = if let Setting::Numeric(values) = setting { values.as_slice() } else { &[] };
        std::array::from_fn(|index| values.get(index).copied().unwrap_or(0.0))
    }
}

impl Read for Vec<f64> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Numbers(numbers) = setting { numbers.clone() } else { Self::new() }
    }
}

impl Read for Vec<String> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Texts(texts) = setting { texts.clone() } else { Self::new() }
    }
}

impl<T: Read> Read for Option<T> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Unset = setting { None } else { Some(T::read(setting)) }
    }
}

/// Hands the values of a record on, one after the other, in the order in which they are declared.
pub struct Reader<'r> {
    values: &'r Values,
    knobs: usize,
    ports: usize,
    lists: usize,
}

/// Takes the next of several.
fn next<'r, T>(of: &'r [T], at: &mut usize) -> Option<&'r T> {
    *at += 1;
    of.get(*at - 1)
}

impl<'r> Reader<'r> {
    /// All items of a record.
    pub fn new(values: &'r Values) -> Self {
        Self { values, knobs: 0, ports: 0, lists: 0 }
    }

    /// The next knob.
    pub fn knob<T: Read>(&mut self) -> T {
        T::read(next(&self.values.knobs, &mut self.knobs).map_or(&Setting::Unset, |(_, setting)| setting))
    }

    /// The next port.
    pub fn port<T: ReadPort>(&mut self) -> T {
        let index = self.ports;
        match next(&self.values.ports, &mut self.ports) {
            Some((name, sources)) => T::read(PortId { index, name }, sources),
            None => T::read(PortId { index, name: "" }, &[]),
        }
    }

    /// The next list.
    pub fn list<T: Items>(&mut self) -> Vec<T> {
        let records = next(&self.values.lists, &mut self.lists).map_or(&[][..], |(_, records)| records);
        records.iter().map(|record| T::read(&mut Reader::new(record))).collect()
    }
}

/// How many items several groups have together.
#[doc(hidden)]
pub const fn count_items(groups: &[&[Item]]) -> usize {
    let (mut count, mut group) = (0, 0);
    while group < groups.len() {
        count += groups[group].len();
        group += 1;
    }
    count
}

/// All items of several groups, in order.
#[doc(hidden)]
pub const fn join_items<const COUNT: usize>(groups: &[&[Item]]) -> [Item; COUNT] {
    const UNSET: Item = Item::List(crate::List { name: "", help: "", items: &[], min: 0, max: 0 });
    let mut items = [UNSET; COUNT];
    let (mut count, mut group) = (0, 0);
    while group < groups.len() {
        let mut index = 0;
        while index < groups[group].len() {
            items[count] = groups[group][index];
            (count, index) = (count + 1, index + 1);
        }
        group += 1;
    }
    items
}
