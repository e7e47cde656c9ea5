//! Inputs and outputs of stages: what the engine passes to them, and the planes that they fill.

use crate::{BadData, Channel, Connected, FrameContext, Handle, Kind, NodeError, NodeId, SharedResult, Source, Store};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use trochoid_image::Window;
use trochoid_key::{ContentKey, Key, content_key};
use trochoid_memory::Scratch;

/// Values that stages share apart from their connections, such as a file that several of them read.
///
/// The pool keeps a value only as long as someone holds it, so an engine may use one pool for any length of time.
#[derive(Default)]
pub struct Pool {
    made: Mutex<HashMap<(TypeId, Key), Weak<dyn Any + Send + Sync>>>,
}

impl Pool {
    /// Makes an empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the shared `T` for a content key if someone still holds it, else the one that `make` makes.
    ///
    /// # Errors
    /// The errors of `make`.
    pub fn get<T: Any + Send + Sync>(
        &self,
        of: &impl ContentKey,
        make: impl FnOnce() -> Result<T, NodeError>,
    ) -> Result<Arc<T>, NodeError> {
        // The map is consistent between any two steps under the lock, so it may be used after a panic.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (TypeId::of::<T>(), of.key());
        let held = made.get(&key).and_then(Weak::upgrade);
        if let Some(held) = held.and_then(|held| held.downcast::<T>().ok()) {
            return Ok(held);
        }
        made.retain(|_, held| held.strong_count() > 0);
        let new = Arc::new(make()?);
        let any: Arc<dyn Any + Send + Sync> = new.clone();
        made.insert(key, Arc::downgrade(&any));
        Ok(new)
    }
}

impl std::fmt::Debug for Pool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pool").finish_non_exhaustive()
    }
}

/// What a stage is prepared for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Planes alone ([`Prepared::fill`](crate::Prepared::fill)).
    #[default]
    Pictures,
    /// References ([`Prepared::reference`](crate::Prepared::reference)).
    References,
    /// Planes with their bounds ([`Prepared::bound`](crate::Prepared::bound)), and references.
    Bounds,
}

content_key!(
    enum Purpose {
        Pictures,
        References,
        Bounds,
    }
);

/// Arguments of [`Stage::prepare`](crate::Stage::prepare).
pub struct Prepare<'a> {
    /// Data that all nodes of the frame share.
    pub frame: &'a FrameContext,
    /// Kind of each output.
    pub kinds: &'a [Kind],
    /// Whether each channel is wanted, by output.
    pub wanted: &'a [Vec<bool>],
    handles: &'a dyn Fn(NodeId) -> Option<Handle>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
    pool: &'a Pool,
    store: Option<&'a Arc<dyn Store>>,
    part: Option<Window>,
    purpose: Purpose,
}

impl<'a> Prepare<'a> {
    /// Makes the arguments; called by the engine.
    pub fn new(
        frame: &'a FrameContext,
        kinds: &'a [Kind],
        wanted: &'a [Vec<bool>],
        handles: &'a dyn Fn(NodeId) -> Option<Handle>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        pool: &'a Pool,
    ) -> Self {
        Self { frame, kinds, wanted, handles, cancelled, pool, store: None, part: None, purpose: Purpose::Pictures }
    }

    /// Sets what the stage is prepared for; pictures by default.
    #[must_use]
    pub fn with_purpose(self, purpose: Purpose) -> Self {
        Self { purpose, ..self }
    }

    /// Sets the store; none by default.
    #[must_use]
    pub fn with_store(self, store: Option<&'a Arc<dyn Store>>) -> Self {
        Self { store, ..self }
    }

    /// Returns the store in which the stage may leave what it prepares for other processes.
    pub fn store(&self) -> Option<Arc<dyn Store>> {
        self.store.cloned()
    }

    /// Sets the part of the picture for which a stage may prepare; all of it by default.
    #[must_use]
    pub fn with_part(self, part: Option<Window>) -> Self {
        Self { part, ..self }
    }

    /// Returns the part of the picture where most pixels are filled, if it is not all of it. Other pixels may be filled,
    /// too.
    pub fn part(&self) -> Option<Window> {
        self.part
    }

    /// Whether [`Prepared::bound`](crate::Prepared::bound) will be called, so that data for it alone must be prepared.
    pub fn bounded(&self) -> bool {
        self.purpose == Purpose::Bounds
    }

    /// Whether [`Prepared::reference`](crate::Prepared::reference) or [`Prepared::bound`](crate::Prepared::bound) will
    /// be called, so that what they need must be prepared.
    pub fn referenced(&self) -> bool {
        self.purpose != Purpose::Pictures
    }

    /// Returns the `T` that all nodes share that request it for the same content key.
    ///
    /// # Errors
    /// The errors of `make`, which is called if no node holds the value yet.
    pub fn shared<T: Any + Send + Sync>(
        &self,
        of: &impl ContentKey,
        make: impl FnOnce() -> Result<T, NodeError>,
    ) -> Result<Arc<T>, NodeError> {
        self.pool.get(of, make)
    }

    /// Returns the handles of everything connected to a port, as `T`.
    ///
    /// # Errors
    /// The handle of a connected node has another type: a bug in that node, reported rather than hidden.
    pub fn handles<T: Clone + 'static>(&self, port: &impl Connected) -> Result<Vec<T>, NodeError> {
        let item = port.id().item();
        port.sources()
            .iter()
            .filter_map(|source| if let Source::Output { node, .. } = source { Some(*node) } else { None })
            .map(|id| {
                (self.handles)(id).and_then(|handle| handle.downcast_ref::<T>().cloned()).ok_or_else(|| {
                    BadData::new("an incompatible output", "one of the port's kind", "connect another node")
                        .of_item(item)
                        .into()
                })
            })
            .collect()
    }

    /// Returns the handle of the first node connected to a port, whatever its type; `None` if the port is open.
    pub fn handle_of(&self, port: &impl Connected) -> Option<Handle> {
        match port.sources().first() {
            Some(Source::Output { node, .. }) => (self.handles)(*node),
            _ => None,
        }
    }

    /// Whether the user has cancelled the evaluation.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }

    /// Fails if the evaluation is cancelled: for `?` in everything that may take long.
    ///
    /// # Errors
    /// The user has cancelled the evaluation.
    pub fn check_cancelled(&self) -> Result<(), NodeError> {
        if self.cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
    }

    /// Returns the test for cancellation, for threads that a stage starts.
    pub fn cancellation(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.cancelled
    }
}

/// A block of samples: one sample in each pixel of a window, or in each of several single pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block<'a> {
    /// Window of the pixels. For single pixels, which only [pixelwise](crate::Stage::is_pixelwise) stages get, a row of the
    /// same number of pixels at an arbitrary position; [`Block::pixels`] has the real ones.
    pub window: Window,
    /// Position of the sample in its pixel, from the upper left corner, in pixels.
    pub offset: [f64; 2],
    /// Positions of single pixels; `None` for a window.
    pub scattered: Option<&'a [[i64; 2]]>,
    /// Whether each pixel of the window counts; all of them for `None`. The others may get any value, and so may the inputs
    /// beyond the region of interest of those that count.
    pub only: Option<&'a [bool]>,
}

impl<'a> Block<'a> {
    /// Makes a block of one sample in each pixel of a window.
    pub fn of(window: Window, offset: [f64; 2]) -> Self {
        Self { window, offset, scattered: None, only: None }
    }

    /// Makes a block of one sample in each of several single pixels.
    pub fn scattered(pixels: &'a [[i64; 2]], offset: [f64; 2]) -> Self {
        Self { window: Window::new(0, 0, pixels.len() as i64, 1), offset, scattered: Some(pixels), only: None }
    }

    /// Says which pixels of a window count.
    #[must_use]
    pub fn with_only(self, only: Option<&'a [bool]>) -> Self {
        Self { only, ..self }
    }

    /// Returns whether the pixel at an index in the planes counts.
    #[inline]
    pub fn counts(&self, index: usize) -> bool {
        self.only.is_none_or(|only| only[index])
    }

    /// Returns the pixels, in the order of the planes.
    pub fn pixels(&self) -> impl Iterator<Item = [i64; 2]> + use<'a> {
        let window = if self.scattered.is_some() { Window::default() } else { self.window };
        let row = move |y: i64| (window.x0..window.x1).map(move |x| [x, y]);
        (window.y0..window.y1).flat_map(row).chain(self.scattered.unwrap_or_default().iter().copied())
    }

    /// Returns the positions of the samples in the picture, in pixels.
    pub fn places(&self) -> impl Iterator<Item = [f64; 2]> + use<'a> {
        let [right, down] = self.offset;
        self.pixels().map(move |[x, y]| [x as f64 + right, y as f64 + down])
    }

    /// Returns the pixel at an index in the planes, if there is one.
    pub fn pixel(&self, index: usize) -> Option<[i64; 2]> {
        if let Some(pixels) = self.scattered {
            return pixels.get(index).copied();
        }
        let width = self.window.width();
        (index < self.window.area())
            .then(|| [self.window.x0 + (index % width) as i64, self.window.y0 + (index / width) as i64])
    }
}

/// The planes of one connection of a stage over a block.
#[derive(Clone, Debug, Default)]
pub struct Connection<'a> {
    /// The requested channels, `None` for others: the samples of `window`, row by row.
    pub planes: Scratch<Option<&'a [f32]>>,
    /// Pixels of the planes: those of the block, or the region of interest clipped to the image, or whole rows around it
    /// ([`Stage::takes_whole_rows`](crate::Stage::takes_whole_rows)).
    pub window: Window,
    /// Extent of the whole image. Outside of it the nearest pixel repeats.
    pub extent: Window,
}

/// The planes connected to the ports of a stage over a block.
pub struct Inputs<'a> {
    ports: &'a [Scratch<Connection<'a>>],
    cancelled: &'a (dyn Fn() -> bool + Sync),
    found: Option<&'a SharedResult>,
}

impl<'a> Inputs<'a> {
    /// Makes the inputs from the connections of each port; called by the engine.
    pub fn new(ports: &'a [Scratch<Connection<'a>>]) -> Self {
        Self { ports, cancelled: &|| false, found: None }
    }

    /// Sets the result of [`Prepared::find`](crate::Prepared::find).
    #[must_use]
    pub fn with_found(self, found: Option<&'a SharedResult>) -> Self {
        Self { found, ..self }
    }

    /// Returns the result of [`Prepared::find`](crate::Prepared::find) that several samples share, if the document
    /// shades per pixel.
    pub fn found<T: Any>(&self) -> Option<&'a T> {
        self.found?.downcast_ref()
    }

    /// Sets the test for cancellation.
    #[must_use]
    pub fn with_cancellation(self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { cancelled, ..self }
    }

    /// Whether the user has cancelled the evaluation: then a slow stage may return an error, which is not shown.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }

    /// Fails if the evaluation is cancelled: for `?` in everything that may take long.
    ///
    /// # Errors
    /// The user has cancelled the evaluation.
    pub fn check_cancelled(&self) -> Result<(), NodeError> {
        if self.cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
    }

    /// Returns the test for cancellation, for threads that a stage starts.
    pub fn cancellation(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.cancelled
    }

    /// Returns the connections of a port: none if an optional port is open.
    pub fn all(&self, port: &impl Connected) -> &'a [Connection<'a>] {
        self.ports.get(port.id().index()).map_or(&[], |connections| connections)
    }

    /// Returns the channels of connection `index` of a port.
    ///
    /// # Panics
    /// The port has no such connection.
    pub fn planes(&self, port: &impl Connected, index: usize) -> &[Option<&'a [f32]>] {
        &self.all(port)[index].planes
    }

    /// Returns a channel, which the node [prefers](crate::Stage::optional_channels), of the view connected to a port; `None` if
    /// the view does not supply it.
    pub fn view_if_any(&self, port: &impl Connected, channel: Channel) -> Option<&'a [f32]> {
        self.planes(port, 0)[channel as usize]
    }

    /// Returns a channel of the view connected to a port.
    ///
    /// # Panics
    /// The node did not [ask](crate::Stage::required_channels) for the channel: a bug in the node, which its first test finds.
    pub fn view(&self, port: &impl Connected, channel: Channel) -> &'a [f32] {
        match self.planes(port, 0)[channel as usize] {
            Some(plane) => plane,
            None => unreachable!("the node did not ask for {channel:?}"),
        }
    }
}

/// The planes that a stage is to fill over a block.
pub struct Outputs<'a> {
    planes: Scratch<Scratch<Option<&'a mut [f32]>>>,
}

impl<'a> Outputs<'a> {
    /// Makes the outputs from planes by output and channel, `None` for unwanted channels; called by the engine.
    pub fn new(planes: impl IntoIterator<Item: IntoIterator<Item = Option<&'a mut [f32]>>>) -> Self {
        Self { planes: planes.into_iter().map(|channels| channels.into_iter().collect()).collect() }
    }

    /// Takes the plane of a channel of a node with one output; `None` if the channel is unwanted.
    pub fn only(&mut self, channel: usize) -> Option<&'a mut [f32]> {
        self.take(0_usize, channel)
    }

    /// Takes the plane of a channel of an output; `None` if the channel is unwanted.
    pub fn take(&mut self, output: impl Into<usize>, channel: usize) -> Option<&'a mut [f32]> {
        self.planes.get_mut(output.into())?.get_mut(channel)?.take()
    }
}
