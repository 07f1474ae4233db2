//! WGSL functions run on a wgpu adapter, row by row.
//!
//! [`Gpu::open`] takes an adapter, or [`Gpu::from_device`] a device that the caller has; [`Kernel::new`] compiles a
//! function of a WGSL module, and [`Kernel::run`] maps it over any number of rows of arguments. Calls block until the
//! results are there. Whatever a driver refuses comes back as a [`GpuError`].
//!
//! ```no_run
//! use brdf::gpu::{Gpu, Kernel, columns, rows};
//!
//! let gpu = Gpu::open(None)?;
//! let kernel = Kernel::new(&gpu, "fn scale(x: f32, by: f32) -> f32 { return x * by; }", "scale", None)?;
//! let results = kernel.run(&rows(&[&[1.0, 2.0, 3.0], &[0.5, 0.5, 0.5]])?, &[])?;
//! assert_eq!(columns(&results, 1), [[0.5, 1.0, 1.5]]);
//! # Ok::<(), brdf::gpu::GpuError>(())
//! ```
//!
//! # Floating point
//!
//! wgpu 30 offers no switch for IEEE semantics: WGSL's own rules hold, in which a compiler may contract `a * b + c`,
//! flush subnormals and assume that there is neither NaN nor infinity. Words of `u32` and `i32` pass unchanged. llvmpipe through Vulkan (Mesa
//! 22.3) folds `x != x` to false: a kernel that looks for NaN must compare bits.

mod adapter;
mod error;
mod kernel;
mod layers;
mod policy;
mod rows;
mod stopwatch;

pub use adapter::{AdapterInfo, adapters};
pub use error::GpuError;
pub use kernel::Kernel;
pub use layers::{
    DISTRIBUTION_BINDINGS, FRESNEL_BINDINGS, RAMP_BINDINGS, STACK_BINDINGS, StackBuffers, StackPlace, TABLE_BINDINGS,
    TEXEL_BINDINGS, layer_bytes, texel_bytes,
};
pub use policy::{Policy, policy};
pub use rows::{columns, rows};
pub use stopwatch::{Lap, Stopwatch};
pub use wgpu;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// An open device on one adapter. Clones share it.
#[derive(Clone, Debug)]
pub struct Gpu {
    info: AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Why the device was lost, where it was and this crate opened it.
    fault: Arc<Mutex<Option<String>>>,
    /// One run at a time: wgpu's GL back-end panics when it waits more than six seconds for another thread.
    turn: Arc<Mutex<()>>,
}

impl Gpu {
    /// Opens the best adapter whose name and backend contain every word of `name`, whatever the case.
    ///
    /// A word that is a backend (`vulkan`, `metal`, `dx12`, `gl`) selects by that alone; any adapter's own [`Display`] form
    /// selects that adapter. Best means discrete before integrated, virtual and CPU, then Vulkan, Metal and DX12 before
    /// GL: the first usable one in the order of [`adapters`]. The device has all limits of its adapter.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], or [`GpuError::Device`] where the driver refuses to open it.
    ///
    /// [`Display`]: core::fmt::Display
    pub fn open(name: Option<&str>) -> Result<Self, GpuError> {
        let found = adapter::enumerate();
        let matches = |info: &AdapterInfo| info.unusable.is_none() && name.is_none_or(|name| info.matches(name));
        match found.iter().find(|(info, _)| matches(info)) {
            Some((info, adapter)) => Self::request(info, adapter),
            None => Err(GpuError::NoAdapter {
                wanted: name.map(str::to_owned),
                found: found.into_iter().map(|(info, _)| info).collect(),
            }),
        }
    }

    /// Opens every usable adapter, in the order of [`adapters`]; empty where there is none.
    ///
    /// # Errors
    /// Each adapter by itself may fail with [`GpuError::Device`].
    pub fn open_all() -> Vec<Result<Self, GpuError>> {
        let found = adapter::enumerate();
        let usable = found.iter().filter(|(info, _)| info.unusable.is_none());
        usable.map(|(info, adapter)| Self::request(info, adapter)).collect()
    }

    /// Takes a device that the caller opened, with this crate's [`wgpu`]. Its limits and error handlers stay as they are.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let info = AdapterInfo::from(device.adapter_info());
        Gpu { info, device, queue, fault: Arc::default(), turn: Arc::default() }
    }

    /// The adapter that the device is on.
    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    fn request(info: &AdapterInfo, adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("brdf"),
            // For `Stopwatch`, which does without where there are none.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::Device { adapter: info.to_string(), reason: error.to_string() })?;
        let fault = Arc::<Mutex<Option<String>>>::default();
        let slot = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            *lock(&slot) = Some(if message.is_empty() { format!("{reason:?}") } else { message });
        });
        Ok(Gpu { info: info.clone(), device, queue, fault, turn: Arc::default() })
    }

    /// Runs work on the device, and turns whatever goes wrong into an error.
    fn attempt<T>(&self, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        let _turn = lock(&self.turn);
        let filters = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        // `Device::poll` panics where the device is lost (wgpu_core.rs: `handle_error_fatal`), as do some drivers' paths.
        let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            Err(self.lost(text.unwrap_or("wgpu panicked")))
        });
        // An error in a scope is the cause; a failed outcome after it the consequence. Scopes close last first.
        let mut cause = None;
        for scope in scopes.into_iter().rev() {
            cause = pollster::block_on(scope.pop()).or(cause);
        }
        if let Some(reason) = lock(&self.fault).clone() {
            return Err(self.lost(&reason));
        }
        match cause {
            Some(wgpu::Error::OutOfMemory { .. }) => Err(GpuError::OutOfMemory { adapter: self.info.to_string() }),
            Some(error) if !self.alive() => Err(self.lost(&error.to_string())),
            Some(error) => Err(GpuError::Rejected { adapter: self.info.to_string(), reason: error.to_string() }),
            None => outcome,
        }
    }

    /// Refuses what is larger than the device binds at once.
    pub(crate) fn bindable(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if bytes <= most {
            return Ok(());
        }
        Err(GpuError::TooLarge { what: what(), adapter: self.info.to_string(), bytes, most })
    }

    fn lost(&self, reason: &str) -> GpuError {
        GpuError::Lost { adapter: self.info.to_string(), reason: reason.to_owned() }
    }

    /// False where the device no longer makes even the smallest buffer.
    ///
    /// A lost device reports nothing of its own when it is used: only that things made on it since are invalid.
    fn alive(&self) -> bool {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let usage = wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: None, size: 4, usage, mapped_at_creation: false };
        self.queue.write_buffer(&self.device.create_buffer(&descriptor), 0, &[0; 4]);
        pollster::block_on(scope.pop()).is_none()
    }
}

/// The mutex's content, also after a panic elsewhere.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
