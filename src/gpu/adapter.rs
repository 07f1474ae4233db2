//! The adapters of this machine, and which of them can run kernels.

use core::fmt;

/// The storage buffers that a kernel needs: arguments, results and the module's own.
const STORAGE_BUFFERS: u32 = 3;

/// One adapter through one backend. Displays as `llvmpipe (LLVM 15.0.6, 256 bits) [Vulkan]`.
///
/// The same hardware, or the same software renderer, is one entry for each backend that reaches it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    /// The name that the driver gives.
    pub name: String,
    /// The programming interface that it is reached through.
    pub backend: wgpu::Backend,
    /// Discrete, integrated, virtual or software.
    pub device_type: wgpu::DeviceType,
    /// The driver's name; may be empty.
    pub driver: String,
    /// The driver's version and the like; may be empty.
    pub driver_info: String,
    /// The PCI address, which tells two equal cards apart; may be empty.
    pub bus: String,
    /// Why no kernel can run on it.
    pub unusable: Option<String>,
}

impl AdapterInfo {
    /// The backend as the industry spells it.
    pub fn backend_name(&self) -> &'static str {
        match self.backend {
            wgpu::Backend::Vulkan => "Vulkan",
            wgpu::Backend::Metal => "Metal",
            wgpu::Backend::Dx12 => "DX12",
            wgpu::Backend::Gl => "GL",
            wgpu::Backend::BrowserWebGpu => "WebGPU",
            wgpu::Backend::Noop => "Noop",
        }
    }

    /// True where every word of `wanted` is this backend or part of this name, whatever the case.
    ///
    /// A word that is any backend's name is looked for in the backend only: `gl` is not part of "Google SwiftShader".
    pub fn matches(&self, wanted: &str) -> bool {
        let name = self.name.to_lowercase();
        let backend = self.backend_name().to_lowercase();
        wanted.to_lowercase().split_whitespace().all(|word| match word.trim_matches(['[', ']']) {
            word @ ("vulkan" | "metal" | "dx12" | "gl" | "webgpu") => backend == word,
            _ => name.contains(word),
        })
    }

    /// Sorts the adapter most worth taking first, and is the same for every run on the same machine.
    fn rank(&self) -> (u8, u8, &str, &str, &str) {
        let device = match self.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        let backend = match self.backend {
            wgpu::Backend::Vulkan => 0,
            wgpu::Backend::Metal => 1,
            wgpu::Backend::Dx12 => 2,
            wgpu::Backend::BrowserWebGpu => 3,
            wgpu::Backend::Gl => 4,
            wgpu::Backend::Noop => 5,
        };
        (device, backend, &self.name, &self.driver_info, &self.bus)
    }
}

impl From<wgpu::AdapterInfo> for AdapterInfo {
    fn from(info: wgpu::AdapterInfo) -> Self {
        AdapterInfo {
            name: info.name,
            backend: info.backend,
            device_type: info.device_type,
            driver: info.driver,
            driver_info: info.driver_info,
            bus: info.device_pci_bus_id,
            unusable: None,
        }
    }
}

impl fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}]", self.name, self.backend_name())
    }
}

/// Every adapter of every backend, the one most worth taking first, always in the same order.
///
/// Those that cannot run a kernel are there too and say why. Empty where there is no driver.
pub fn adapters() -> Vec<AdapterInfo> {
    enumerate().into_iter().map(|(info, _)| info).collect()
}

pub(super) fn enumerate() -> Vec<(AdapterInfo, wgpu::Adapter)> {
    // `Instance::new` panics where the target has no backend.
    if wgpu::Instance::enabled_backend_features().is_empty() {
        return Vec::new();
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        // The same in debug and release builds: validation layers would change what is measured.
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let mut found: Vec<_> = adapters
        .into_iter()
        .map(|adapter| {
            let mut info = AdapterInfo::from(adapter.get_info());
            info.unusable = unusable(&adapter);
            (info, adapter)
        })
        .collect();
    found.sort_by(|(a, _), (b, _)| a.rank().cmp(&b.rank()));
    found
}

fn unusable(adapter: &wgpu::Adapter) -> Option<String> {
    let limits = adapter.limits();
    let buffers = limits.max_storage_buffers_per_shader_stage;
    if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        Some("no compute shaders".to_owned())
    } else if buffers < STORAGE_BUFFERS {
        Some(format!("{buffers} storage buffers in a compute shader, {STORAGE_BUFFERS} are needed"))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, backend: wgpu::Backend, device_type: wgpu::DeviceType) -> AdapterInfo {
        let (driver, driver_info, bus) = Default::default();
        AdapterInfo { name: name.to_owned(), backend, device_type, driver, driver_info, bus, unusable: None }
    }

    #[test]
    fn words_match_name_and_backend() {
        let info = adapter("llvmpipe (LLVM 15.0.6, 256 bits)", wgpu::Backend::Vulkan, wgpu::DeviceType::Cpu);
        for wanted in ["", "vulkan", "VULKAN", "llvm", "LLVMpipe vulkan", &info.to_string()] {
            assert!(info.matches(wanted), "{wanted}");
        }
        for wanted in ["gl", "nvidia", "llvmpipe gl"] {
            assert!(!info.matches(wanted), "{wanted}");
        }
        let swift = adapter("Google SwiftShader", wgpu::Backend::Vulkan, wgpu::DeviceType::Cpu);
        assert!(!swift.matches("gl") && swift.matches("google"));
    }

    #[test]
    fn the_best_comes_first() {
        use wgpu::{Backend, DeviceType};
        let mut all = [
            adapter("llvmpipe", Backend::Gl, DeviceType::Cpu),
            adapter("llvmpipe", Backend::Vulkan, DeviceType::Cpu),
            adapter("card", Backend::Gl, DeviceType::DiscreteGpu),
            adapter("chip", Backend::Vulkan, DeviceType::IntegratedGpu),
            adapter("card", Backend::Vulkan, DeviceType::DiscreteGpu),
        ];
        all.sort_by(|a, b| a.rank().cmp(&b.rank()));
        let order = all.map(|info| info.to_string());
        assert_eq!(order, ["card [Vulkan]", "card [GL]", "chip [Vulkan]", "llvmpipe [Vulkan]", "llvmpipe [GL]"]);
    }
}
