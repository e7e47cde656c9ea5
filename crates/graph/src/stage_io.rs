//! What stages are given, and what they fill.

use crate::{BadData, Channel, Connected, Found, FrameContext, Handle, Kind, NodeError, NodeId, Source};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use trochoid_image::Window;
use trochoid_key::{ContentKey, Key};

/// What stages share beside their connections, such as a file that several of them read.
///
/// Nothing is kept that nobody holds, so an engine may use one pool for as long as it likes.
#[derive(Default)]
pub struct Pool {
    made: Mutex<HashMap<(TypeId, Key), Weak<dyn Any + Send + Sync>>>,
}

impl Pool {
    /// An empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// The `T` that someone holds of what has the same content, else what `make` makes.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get<T: Any + Send + Sync>(
        &self,
        of: &impl ContentKey,
        make: impl FnOnce() -> Result<T, NodeError>,
    ) -> Result<Arc<T>, NodeError> {
        // Whole steps alone are done under the lock, so what a panic left is whole too.
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

/// What [`Stage::prepare`](crate::Stage::prepare) is given.
pub struct Prepare<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// The kind of each output.
    pub kinds: &'a [Kind],
    /// For each output, which of its channels are wanted.
    pub wanted: &'a [Vec<bool>],
    handles: &'a dyn Fn(NodeId) -> Option<Handle>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
    pool: &'a Pool,
    bounded: bool,
}

impl<'a> Prepare<'a> {
    /// Made by the engine.
    pub fn new(
        frame: &'a FrameContext,
        kinds: &'a [Kind],
        wanted: &'a [Vec<bool>],
        handles: &'a dyn Fn(NodeId) -> Option<Handle>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        pool: &'a Pool,
    ) -> Self {
        Self { frame, kinds, wanted, handles, cancelled, pool, bounded: false }
    }

    /// The same where [`Prepared::bound`](crate::Prepared::bound) will be asked.
    #[must_use]
    pub fn with_bounds(self, bounded: bool) -> Self {
        Self { bounded, ..self }
    }

    /// Whether [`Prepared::bound`](crate::Prepared::bound) will be asked, for what it alone needs.
    pub fn bounded(&self) -> bool {
        self.bounded
    }

    /// What all nodes share that ask for a `T` of what has the same content.
    ///
    /// # Errors
    /// Those of `make`, which is called where no node holds one yet.
    pub fn shared<T: Any + Send + Sync>(
        &self,
        of: &impl ContentKey,
        make: impl FnOnce() -> Result<T, NodeError>,
    ) -> Result<Arc<T>, NodeError> {
        self.pool.get(of, make)
    }

    /// The handles of everything connected to a port, as `T`.
    ///
    /// # Errors
    /// The connected node hands on something else: a bug of that node, reported rather than hidden.
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

    /// The handle of the first node connected to a port, whatever it holds; `None` where the port is open.
    pub fn handle_of(&self, port: &impl Connected) -> Option<Handle> {
        match port.sources().first() {
            Some(Source::Output { node, .. }) => (self.handles)(*node),
            _ => None,
        }
    }

    /// Whether the user has asked to stop.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }

    /// Whether a stage may go on, for `?` in all that may take long.
    ///
    /// # Errors
    /// The user has asked to stop.
    pub fn go_on(&self) -> Result<(), NodeError> {
        if self.cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
    }

    /// The same for threads that a stage starts.
    pub fn cancellation(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.cancelled
    }
}

/// A block of samples: one sample of each pixel of a window, or of single pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block<'a> {
    /// The pixels. Of single pixels, which only stages are given that are not of [`Rate::Sample`](crate::Rate), a row
    /// of as many somewhere: see [`Block::pixels`].
    pub window: Window,
    /// Where in its pixel the sample lies, from the upper left corner, in pixels.
    pub offset: [f64; 2],
    /// The pixels where they are single ones.
    pub scattered: Option<&'a [[i64; 2]]>,
}

impl<'a> Block<'a> {
    /// One sample of each pixel of a window.
    pub fn of(window: Window, offset: [f64; 2]) -> Self {
        Self { window, offset, scattered: None }
    }

    /// One sample of each of these pixels.
    pub fn scattered(pixels: &'a [[i64; 2]], offset: [f64; 2]) -> Self {
        Self { window: Window::new(0, 0, pixels.len() as i64, 1), offset, scattered: Some(pixels) }
    }

    /// The pixels, in the order of the planes.
    pub fn pixels(&self) -> impl Iterator<Item = [i64; 2]> + use<'a> {
        let window = if self.scattered.is_some() { Window::default() } else { self.window };
        let row = move |y: i64| (window.x0..window.x1).map(move |x| [x, y]);
        (window.y0..window.y1).flat_map(row).chain(self.scattered.unwrap_or_default().iter().copied())
    }

    /// The places of the samples in the picture, in pixels.
    pub fn places(&self) -> impl Iterator<Item = [f64; 2]> + use<'a> {
        let [right, down] = self.offset;
        self.pixels().map(move |[x, y]| [x as f64 + right, y as f64 + down])
    }

    /// A pixel by its index in the planes, where there is one.
    pub fn pixel(&self, index: usize) -> Option<[i64; 2]> {
        if let Some(pixels) = self.scattered {
            return pixels.get(index).copied();
        }
        let width = self.window.width();
        (index < self.window.area())
            .then(|| [self.window.x0 + (index % width) as i64, self.window.y0 + (index / width) as i64])
    }
}

/// One connection of a stage over a block.
#[derive(Clone, Debug, Default)]
pub struct Connection<'a> {
    /// The channels, each where asked for: the samples of `window`, row by row.
    pub planes: Vec<Option<&'a [f32]>>,
    /// The pixels of the planes: the block's, or the region of interest as far as the image reaches.
    pub window: Window,
    /// How far the whole image reaches. Beyond it, and so beyond `window`, the nearest pixel repeats.
    pub extent: Window,
}

/// The planes connected to a stage's ports over a block.
pub struct Inputs<'a> {
    ports: &'a [Vec<Connection<'a>>],
    cancelled: &'a (dyn Fn() -> bool + Sync),
    found: Option<&'a Found>,
}

impl<'a> Inputs<'a> {
    /// Made by the engine: for each port its connections.
    pub fn new(ports: &'a [Vec<Connection<'a>>]) -> Self {
        Self { ports, cancelled: &|| false, found: None }
    }

    /// The same with what was found once for several samples.
    #[must_use]
    pub fn with_found(self, found: Option<&'a Found>) -> Self {
        Self { found, ..self }
    }

    /// What the stage found once for several samples, where the document shades by the pixel.
    pub fn found<T: Any>(&self) -> Option<&'a T> {
        self.found?.downcast_ref()
    }

    /// The same with what tells whether the user has asked to stop.
    #[must_use]
    pub fn with_cancellation(self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { cancelled, ..self }
    }

    /// Whether the user has asked to stop: then a stage that takes long may return an error, which nobody sees.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }

    /// Whether a stage may go on, for `?` in all that may take long.
    ///
    /// # Errors
    /// The user has asked to stop.
    pub fn go_on(&self) -> Result<(), NodeError> {
        if self.cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
    }

    /// The same for threads that a stage starts.
    pub fn cancellation(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.cancelled
    }

    /// The connections of a port: none where an optional port is open.
    pub fn all(&self, port: &impl Connected) -> &'a [Connection<'a>] {
        self.ports.get(port.id().index()).map_or(&[], Vec::as_slice)
    }

    /// The channels of connection `index` of a port.
    ///
    /// # Panics
    /// The port has no such connection.
    pub fn planes(&self, port: &impl Connected, index: usize) -> &[Option<&'a [f32]>] {
        &self.all(port)[index].planes
    }

    /// A channel of the view connected to a port that the node prefers, where the view supplies it.
    pub fn view_if_any(&self, port: &impl Connected, channel: Channel) -> Option<&'a [f32]> {
        self.planes(port, 0)[channel as usize]
    }

    /// A channel of the view connected to a port.
    ///
    /// # Panics
    /// The node did not ask for it: a bug of that node, caught by its first test.
    pub fn view(&self, port: &impl Connected, channel: Channel) -> &'a [f32] {
        match self.planes(port, 0)[channel as usize] {
            Some(plane) => plane,
            None => unreachable!("the node did not ask for {channel:?}"),
        }
    }
}

/// The planes that a stage is to fill over a block.
pub struct Outputs<'a> {
    planes: Vec<Vec<Option<&'a mut [f32]>>>,
}

impl<'a> Outputs<'a> {
    /// Made by the engine: for each output, for each channel, its plane where wanted.
    pub fn new(planes: Vec<Vec<Option<&'a mut [f32]>>>) -> Self {
        Self { planes }
    }

    /// Takes the plane of a channel of a node with one output, or `None` where nobody wants it.
    pub fn only(&mut self, channel: usize) -> Option<&'a mut [f32]> {
        self.take(0_usize, channel)
    }

    /// Takes the plane of an output's channel, or `None` where nobody wants it.
    pub fn take(&mut self, output: impl Into<usize>, channel: usize) -> Option<&'a mut [f32]> {
        self.planes.get_mut(output.into())?.get_mut(channel)?.take()
    }
}
