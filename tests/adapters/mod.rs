//! The adapters that integration tests run on, under the policy of `BRDF_GPU`.

use brdf::gpu::{Gpu, GpuError, Policy, policy};
use std::io::Write;

/// Every adapter of the machine, opened; empty, after a line `SKIPPED: reason`, where the policy allows that.
///
/// Panics, and so fails the test, where an adapter does not open, or where one is required and there is none.
pub(crate) fn adapters_for_tests() -> Vec<Gpu> {
    let skipped = |reason: &str| {
        // Written past the test harness, which would swallow `println!` of a test that passes.
        let _ = writeln!(std::io::stderr(), "SKIPPED: {}: {reason}", std::thread::current().name().unwrap_or("test"));
        Vec::new()
    };
    let policy = policy();
    if policy == Policy::Off {
        return skipped("BRDF_GPU=off");
    }
    let opened: Result<Vec<Gpu>, GpuError> = Gpu::open_all().into_iter().collect();
    match opened {
        Err(error) => panic!("{error}"),
        Ok(gpus) if !gpus.is_empty() => gpus,
        Ok(_) => {
            let reason = GpuError::NoAdapter { wanted: None, found: brdf::gpu::adapters() }.to_string();
            assert!(policy == Policy::Auto, "BRDF_GPU=require: {reason}");
            skipped(&reason)
        }
    }
}
