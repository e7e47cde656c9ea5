//! Fields of nodes: the types into which `#[derive(Node)]` reads ports and knobs.

use crate::{Accepts, Item, Output, Setting, Source, Values};
use std::marker::PhantomData;
use std::ops::Deref;

/// Ports and knobs that are declared together: those of a node, of a record of a list, or a group that several nodes
/// share.
///
/// Made by `#[derive(Items)]`, and by `#[derive(Node)]`.
pub trait Items: Clone + Send + Sync + 'static {
    /// Declarations of the items, in display order.
    const ITEMS: &'static [Item];

    /// Reads the values of the items, in the order of [`Items::ITEMS`].
    fn read(reader: &mut Reader<'_>) -> Self;
}

/// A knob that takes one of several words. Made by `#[derive(Choice)]`.
pub trait Choice: ReadSetting + 'static {
    /// Words in documents; the first is the default.
    const WORDS: &'static [&'static str];

    /// Returns the word of the value.
    fn word(&self) -> &'static str;
}

/// The outputs of a node. Made by `#[derive(Outputs)]`.
pub trait OutputSet {
    /// Declarations of the outputs; a reference that names only the node means the first.
    const OUTPUTS: &'static [Output];
}

/// The only output of a node with one output: `outputs.take(SoleOutput, 0)`.
#[derive(Clone, Copy, Debug)]
pub struct SoleOutput;

impl From<SoleOutput> for usize {
    fn from(SoleOutput: SoleOutput) -> Self {
        0
    }
}

/// Name of a declared port, knob or list, such as `Mix::WEIGHT`: one constant per field of the declaring struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ItemName(&'static str);

impl ItemName {
    /// Makes a name in derived code, where all names are declared.
    #[doc(hidden)]
    pub const fn declared(name: &'static str) -> Self {
        Self(name)
    }

    /// Returns the key in documents.
    pub fn as_str(self) -> &'static str {
        self.0
    }
}

impl std::fmt::Display for ItemName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

/// Identifies one of a node's ports; ports within lists have no identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PortId {
    /// Index among the node's ports.
    index: usize,
    name: &'static str,
}

impl PortId {
    /// Makes the identifier of a port from its index among the node's ports and its name.
    pub fn new(index: usize, name: &'static str) -> Self {
        Self { index, name }
    }

    /// Returns the index among the node's ports.
    pub fn index(self) -> usize {
        self.index
    }

    /// Returns the key in documents.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Returns the name as an [`ItemName`], for faults.
    pub fn item(self) -> ItemName {
        ItemName(self.name)
    }
}

/// A type that says what a port accepts: `One<port::Mask>`.
pub trait Accepted: Send + Sync + 'static {
    /// The kind of connection as a value.
    const ACCEPTS: Accepts;
}

/// Types that say what ports accept.
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

/// A port of a node, with its connections.
pub trait Connected {
    /// Kinds of value that the port accepts.
    const ACCEPTS: Accepts;

    /// Returns the identifier of the port.
    fn id(&self) -> PortId;

    /// Returns the connections of the port, and the literals written instead of connections.
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
    /// A port with at most one connection.
    Optional holds Option<Source<Vec<f64>>>;
    /// A port with several connections.
    Many holds Vec<Source<Vec<f64>>>;
}

/// Storage for the connections of a port.
trait PortStorage {
    fn held(sources: &[Source<Vec<f64>>]) -> Self;
    fn all(&self) -> &[Source<Vec<f64>>];
}

impl PortStorage for Source<Vec<f64>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        // Validation reports required ports that are open.
        sources.first().cloned().unwrap_or(Source::Number(vec![0.0]))
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        std::slice::from_ref(self)
    }
}

impl PortStorage for Option<Source<Vec<f64>>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        sources.first().cloned()
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        self.as_slice()
    }
}

impl PortStorage for Vec<Source<Vec<f64>>> {
    fn held(sources: &[Source<Vec<f64>>]) -> Self {
        sources.to_vec()
    }

    fn all(&self) -> &[Source<Vec<f64>>] {
        self
    }
}

/// A port that a [`Reader`] can read.
pub trait ReadPort {
    /// Makes the port from its connections.
    fn read(id: PortId, sources: &[Source<Vec<f64>>]) -> Self;
}

/// A knob's value that a [`Reader`] can read.
///
/// Reading never fails: a setting that the knob does not take, which validation reports, gives some legal value.
pub trait ReadSetting: Clone + Send + Sync {
    /// Reads the value of a setting.
    fn read(setting: &Setting<Vec<f64>>) -> Self;
}

impl ReadSetting for f64 {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Numeric(values) = setting { values.first().copied().unwrap_or(0.0) } else { 0.0 }
    }
}

impl ReadSetting for i64 {
    /// Rounds an interpolated value to the nearest whole number.
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        f64::read(setting).round() as Self
    }
}

impl ReadSetting for bool {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        matches!(setting, Setting::Bool(true))
    }
}

impl ReadSetting for String {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Text(text) = setting { text.clone() } else { Self::new() }
    }
}

impl<const N: usize> ReadSetting for [f64; N] {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        let values = if let Setting::Numeric(values) = setting { values.as_slice() } else { &[] };
        std::array::from_fn(|index| values.get(index).copied().unwrap_or(0.0))
    }
}

impl ReadSetting for Vec<f64> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Numbers(numbers) = setting { numbers.clone() } else { Self::new() }
    }
}

impl ReadSetting for Vec<String> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Texts(texts) = setting { texts.clone() } else { Self::new() }
    }
}

impl<T: ReadSetting> ReadSetting for Option<T> {
    fn read(setting: &Setting<Vec<f64>>) -> Self {
        if let Setting::Unset = setting { None } else { Some(T::read(setting)) }
    }
}

/// Reads the values of a record one after another, in declaration order.
pub struct Reader<'r> {
    values: &'r Values,
    knobs: usize,
    ports: usize,
    lists: usize,
}

/// Takes the next element of a slice.
fn next<'r, T>(of: &'r [T], at: &mut usize) -> Option<&'r T> {
    *at += 1;
    of.get(*at - 1)
}

impl<'r> Reader<'r> {
    /// Starts at the first item of a record.
    pub fn new(values: &'r Values) -> Self {
        Self { values, knobs: 0, ports: 0, lists: 0 }
    }

    /// Reads the next knob.
    pub fn knob<T: ReadSetting>(&mut self) -> T {
        T::read(next(&self.values.knobs, &mut self.knobs).map_or(&Setting::Unset, |(_, setting)| setting))
    }

    /// Reads the next port.
    pub fn port<T: ReadPort>(&mut self) -> T {
        let index = self.ports;
        match next(&self.values.ports, &mut self.ports) {
            Some((name, sources)) => T::read(PortId { index, name }, sources),
            None => T::read(PortId { index, name: "" }, &[]),
        }
    }

    /// Reads the next list.
    pub fn list<T: Items>(&mut self) -> Vec<T> {
        let records = next(&self.values.lists, &mut self.lists).map_or(&[][..], |(_, records)| records);
        records.iter().map(|record| T::read(&mut Reader::new(record))).collect()
    }
}

/// Returns the total number of items in several groups.
#[doc(hidden)]
pub const fn count_items(groups: &[&[Item]]) -> usize {
    let (mut count, mut group) = (0, 0);
    while group < groups.len() {
        count += groups[group].len();
        group += 1;
    }
    count
}

/// Joins the items of several groups, in order.
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
