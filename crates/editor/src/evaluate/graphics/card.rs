//! A card: its device, its kernels, and how they run.

use super::error::CardError;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use wgpu::{
    Adapter, Backends, BindGroupDescriptor, BindGroupEntry, Buffer, BufferDescriptor, BufferUsages,
    CommandEncoderDescriptor, ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, Device,
    DeviceDescriptor, DeviceType, Instance, InstanceDescriptor, Limits, MapMode, PollType, Queue,
    ShaderModuleDescriptor, ShaderSource,
};

/// Invocations of a group, as the kernels say.
const GROUP: u64 = 64;
/// Most groups along an axis, on every card.
const GROUPS: u64 = 65_535;
/// Time after which a card that does not answer is given up.
const PATIENCE: Duration = Duration::from_secs(10);

/// Which cards will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cards {
    /// Real ones.
    Real,
    /// Drivers that compute on the processor, too: for tests.
    Any,
}

/// An open card.
#[derive(Debug)]
pub(super) struct Card {
    device: Device,
    queue: Queue,
    name: String,
    /// Most bytes of a buffer that a kernel reads.
    most: u64,
    /// What the driver complained about, which no call returns.
    fault: Arc<Mutex<Option<String>>>,
    /// Where the last picture was made, and where it was read.
    targets: Mutex<Option<[Buffer; 2]>>,
}

/// A compiled kernel.
#[derive(Debug)]
pub(super) struct Kernel(ComputePipeline);

impl Card {
    /// Opens the best card.
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub(super) fn open(which: Cards) -> Result<Self, CardError> {
        // Backends whose kernels read buffers of any size.
        let mut described = InstanceDescriptor::new_without_display_handle();
        described.backends = Backends::PRIMARY;
        let instance = Instance::new(described);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(Backends::PRIMARY));
        let rank = |adapter: &Adapter| match adapter.get_info().device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu | DeviceType::Other => 2,
            DeviceType::Cpu => 3,
        };
        adapters.sort_by_key(rank);
        let adapter = adapters.into_iter().next().ok_or(CardError::None)?;
        let info = adapter.get_info();
        if which == Cards::Real && info.device_type == DeviceType::Cpu {
            return Err(CardError::Software(info.name));
        }
        let own = adapter.limits();
        let limits = Limits {
            max_storage_buffer_binding_size: own.max_storage_buffer_binding_size,
            max_buffer_size: own.max_buffer_size,
            ..Limits::default()
        };
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let wanted = DeviceDescriptor { required_limits: limits, ..DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wanted))
            .map_err(|error| CardError::Refused(info.name.clone(), error.to_string()))?;
        let fault = Arc::new(Mutex::new(None));
        let told = fault.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            locked(&told).get_or_insert(error.to_string());
        }));
        let told = fault.clone();
        device.set_device_lost_callback(move |_, why| {
            locked(&told).get_or_insert(if why.is_empty() { "the device was lost".into() } else { why });
        });
        Ok(Self { device, queue, name: info.name, most, fault, targets: Mutex::new(None) })
    }

    /// Returns the name of the card.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Returns most bytes that a buffer may have.
    pub(super) fn most(&self) -> u64 {
        self.most
    }

    /// Compiles a kernel in WGSL, whose function is `main`.
    pub(super) fn kernel(&self, text: &str) -> Result<Kernel, CardError> {
        let source = ShaderSource::Wgsl(text.into());
        let module = self.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
        let pipeline = self.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        self.checked(Kernel(pipeline))
    }

    /// Copies data to the card, for kernels to read.
    pub(super) fn upload(&self, parts: &[&[u8]]) -> Result<Buffer, CardError> {
        let bytes = parts.iter().map(|part| part.len() as u64).sum();
        // Some bytes are bound even if there is nothing to read.
        let buffer = self.buffer(u64::max(bytes, 16), BufferUsages::STORAGE | BufferUsages::COPY_DST)?;
        let mut at = 0;
        for part in parts {
            self.queue.write_buffer(&buffer, at, part);
            at += part.len() as u64;
        }
        self.checked(buffer)
    }

    /// Copies the settings of a kernel to the card.
    pub(super) fn settings(&self, words: &[u32]) -> Result<Buffer, CardError> {
        let bytes: &[u8] = bytemuck::cast_slice(words);
        let buffer = self.buffer(bytes.len() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        self.checked(buffer)
    }

    /// Makes a buffer, unless it would be too large.
    fn buffer(&self, size: u64, usage: BufferUsages) -> Result<Buffer, CardError> {
        if size > self.most {
            return Err(CardError::Large { bytes: size, most: self.most });
        }
        let buffer =
            self.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        self.checked(buffer)
    }

    /// Runs a kernel for each of `count` words of a picture and returns their bytes. The picture is at the first binding,
    /// and `buffers` are at those that follow.
    pub(super) fn run(&self, kernel: &Kernel, count: usize, buffers: &[&Buffer]) -> Result<Vec<u8>, CardError> {
        let bytes = 4 * count as u64;
        let groups = (count as u64).div_ceil(GROUP);
        let rows = groups.div_ceil(GROUPS);
        if count == 0 {
            return Ok(Vec::new());
        }
        if rows > GROUPS {
            return Err(CardError::Large { bytes, most: self.most });
        }
        // Held until the picture is read, so that no other thread writes over it.
        let mut targets = locked(&self.targets);
        if targets.as_ref().is_none_or(|known| known[0].size() != bytes) {
            // The old ones go first.
            *targets = None;
            let made = self.buffer(bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
            let read = self.buffer(bytes, BufferUsages::COPY_DST | BufferUsages::MAP_READ)?;
            *targets = Some([made, read]);
        }
        let Some([made, read]) = &*targets else { unreachable!("they were made") };
        let bound = std::iter::once(&made).chain(buffers).enumerate();
        let entries =
            bound.map(|(at, buffer)| BindGroupEntry { binding: at as u32, resource: buffer.as_entire_binding() });
        let entries: Vec<BindGroupEntry<'_>> = entries.collect();
        let layout = kernel.0.get_bind_group_layout(0);
        let group =
            self.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let mut encoder = self.device.create_command_encoder(&CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            pass.set_pipeline(&kernel.0);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups.min(GROUPS) as u32, rows as u32, 1);
        }
        encoder.copy_buffer_to_buffer(made, 0, read, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let told = Arc::new(Mutex::new(None));
        let tell = told.clone();
        read.map_async(MapMode::Read, .., move |done| *locked(&tell) = Some(done));
        let waited = self.device.poll(PollType::Wait { submission_index: None, timeout: Some(PATIENCE) });
        self.checked(())?;
        waited.map_err(|error| self.failed(&error))?;
        match locked(&told).take() {
            Some(Ok(())) => {}
            Some(Err(error)) => return Err(self.failed(&error)),
            None => return Err(self.failed(&"it does not answer")),
        }
        let pixels = read.get_mapped_range(..).map_err(|error| self.failed(&error))?.to_vec();
        read.unmap();
        self.checked(pixels)
    }

    /// Returns a value unless the driver complained.
    fn checked<T>(&self, value: T) -> Result<T, CardError> {
        match locked(&self.fault).as_ref() {
            Some(why) => Err(self.failed(why)),
            None => Ok(value),
        }
    }

    fn failed(&self, why: &dyn std::fmt::Display) -> CardError {
        CardError::Failed(self.name.clone(), why.to_string())
    }

    /// Loses the device, as a driver that crashes does.
    #[cfg(test)]
    pub(super) fn lose(&self) {
        self.device.destroy();
    }
}

/// Locks what stays whole even if a thread panics.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
