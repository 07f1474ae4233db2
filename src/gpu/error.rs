//! What can go wrong between a WGSL function and its results.

use super::AdapterInfo;
use crate::shader::ShaderError;
use core::fmt;
use std::error::Error;

/// Why a kernel has no results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GpuError {
    /// No usable adapter matches.
    NoAdapter {
        /// The name that was asked for.
        wanted: Option<String>,
        /// Every adapter of the machine, unusable ones included.
        found: Vec<AdapterInfo>,
    },
    /// The driver refused to open the adapter.
    Device {
        /// The adapter, as it displays.
        adapter: String,
        /// What wgpu says.
        reason: String,
    },
    /// The WGSL is invalid, or has no such function that maps rows of words to rows of words.
    Shader(ShaderError),
    /// The arguments, or the storage buffer, do not fit the function or the device.
    Arguments {
        /// The function.
        function: String,
        /// What does not fit, and what would.
        reason: String,
    },
    /// More than the device binds at once.
    TooLarge {
        /// What it is, in the plural.
        what: String,
        /// The adapter, as it displays.
        adapter: String,
        /// How many bytes it takes.
        bytes: u64,
        /// How many the device binds at most.
        most: u64,
    },
    /// The device's validation refused the kernel or a call.
    Rejected {
        /// The adapter, as it displays.
        adapter: String,
        /// What wgpu says, over several lines.
        reason: String,
    },
    /// The device has too little memory.
    OutOfMemory {
        /// The adapter, as it displays.
        adapter: String,
    },
    /// The device was lost: reset by the driver, removed or destroyed.
    Lost {
        /// The adapter, as it displays.
        adapter: String,
        /// What wgpu says.
        reason: String,
    },
}

/// How to have an adapter on a machine without a GPU.
const INSTALL: &str = "a software Vulkan driver runs everywhere: \
    `apt-get install mesa-vulkan-drivers libvulkan1` (Debian, Ubuntu), \
    `dnf install mesa-vulkan-drivers vulkan-loader` (Fedora), \
    `pacman -S vulkan-swrast vulkan-icd-loader` (Arch), \
    `apk add mesa-vulkan-swrast vulkan-loader` (Alpine)";

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GpuError::NoAdapter { wanted, found } => {
                match wanted {
                    Some(wanted) => write!(f, "no usable GPU adapter matches `{wanted}`")?,
                    None => write!(f, "no usable GPU adapter")?,
                }
                write!(f, "; found: ")?;
                for (index, info) in found.iter().enumerate() {
                    write!(f, "{}{info}", if index == 0 { "" } else { ", " })?;
                    if let Some(reason) = &info.unusable {
                        write!(f, " (unusable: {reason})")?;
                    }
                }
                if found.is_empty() {
                    write!(f, "none")?;
                }
                if found.iter().any(|info| info.unusable.is_none()) {
                    write!(f, "; name one of these by part of its name or by its backend, or install another")?;
                }
                write!(f, "; {INSTALL}")
            }
            GpuError::Device { adapter, reason } => write!(f, "{adapter} does not open: {reason}"),
            GpuError::Shader(error) => error.fmt(f),
            GpuError::Arguments { function, reason } => write!(f, "`{function}`: {reason}"),
            GpuError::TooLarge { what, adapter, bytes, most } => {
                let [bytes, most] = [bytes, most].map(|bytes| *bytes as f64 / f64::from(1 << 20));
                write!(f, "{what} take {bytes:.1} MiB and {adapter} binds {most:.1} MiB at most: use smaller ones")
            }
            GpuError::Rejected { adapter, reason } => write!(f, "{adapter} refuses: {reason}"),
            GpuError::OutOfMemory { adapter } => {
                write!(f, "{adapter} is out of memory: run fewer rows at once (`Kernel::with_rows_per_dispatch`)")
            }
            GpuError::Lost { adapter, reason } => write!(f, "{adapter} was lost: {reason}; open it again"),
        }
    }
}

impl Error for GpuError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            GpuError::Shader(error) => Some(error),
            _ => None,
        }
    }
}

impl From<ShaderError> for GpuError {
    fn from(error: ShaderError) -> Self {
        GpuError::Shader(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_says_by_how_much() {
        let (what, adapter) = ("the images".to_owned(), "chip [Vulkan]".to_owned());
        let error = GpuError::TooLarge { what, adapter, bytes: 256 << 20, most: (1 << 27) - 1 };
        let said = "the images take 256.0 MiB and chip [Vulkan] binds 128.0 MiB at most: use smaller ones";
        assert_eq!(error.to_string(), said);
    }

    #[test]
    fn a_missing_adapter_says_what_to_do() {
        let error = GpuError::NoAdapter { wanted: Some("nvidia".to_owned()), found: Vec::new() }.to_string();
        assert!(error.starts_with("no usable GPU adapter matches `nvidia`; found: none; "), "{error}");
        for command in ["apt-get install mesa-vulkan-drivers libvulkan1", "dnf install", "pacman -S", "apk add"] {
            assert!(error.contains(command), "{error}");
        }
        assert_eq!(error.lines().count(), 1);
        let old = AdapterInfo {
            name: "old".to_owned(),
            backend: wgpu::Backend::Gl,
            device_type: wgpu::DeviceType::Other,
            driver: String::new(),
            driver_info: String::new(),
            bus: String::new(),
            unusable: Some("no compute shaders".to_owned()),
        };
        let error = GpuError::NoAdapter { wanted: None, found: vec![old] }.to_string();
        assert!(error.contains("found: old [GL] (unusable: no compute shaders); a software"), "{error}");
    }
}
