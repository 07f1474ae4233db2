//! A function of a WGSL module, compiled for one device and mapped over rows.

use super::{Gpu, GpuError};
use crate::shader::{Module, STORAGE_BINDING, Scalar, ShaderError, Signature, map_kernel};
use std::sync::mpsc;

/// The invocations of a workgroup: a multiple of every subgroup size in use, and within every device's limit.
const WORKGROUP: u32 = 64;

/// The bytes of arguments, and of results, in one dispatch. Larger buffers are no faster, and each exists twice.
const DISPATCH_BYTES: u64 = 64 << 20;

/// A WGSL function that maps rows of arguments to rows of results on one device.
#[derive(Clone, Debug)]
pub struct Kernel {
    gpu: Gpu,
    signature: Signature,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// The bindings of the storage buffers that the module reads, in ascending order.
    storage: Vec<u32>,
    rows_per_dispatch: usize,
}

impl Kernel {
    /// Compiles a function of a WGSL module.
    ///
    /// `bindings` is WGSL that completes the module, where it calls functions that it leaves to its embedder. Read-only
    /// storage buffers declared there (or in the source) in group 0, at binding 3 and above, are filled by [`Kernel::run`]:
    ///
    /// ```wgsl
    /// @group(0) @binding(3) var<storage, read> stack_layers: array<layered_Layer>;
    /// fn stack_layer(index: u32) -> layered_Layer { return stack_layers[index]; }
    /// ```
    ///
    /// # Errors
    /// [`GpuError::Shader`] for invalid WGSL, with line and column, for a function that is missing, takes or returns
    /// nothing, or has types other than 32-bit scalars; [`GpuError::Rejected`] for what only this device refuses.
    pub fn new(gpu: &Gpu, source: &str, function: &str, bindings: Option<&str>) -> Result<Self, GpuError> {
        let bindings = bindings.unwrap_or_default();
        let module = Module::parse(&format!("{source}\n{bindings}"))?;
        let signature = module.function(function)?;
        if signature.parameters.is_empty() || signature.result.is_none() {
            let lack = if signature.result.is_none() { "returns nothing" } else { "takes no arguments" };
            return Err(ShaderError::plain(format!("`{function}` {lack}: it cannot be mapped over rows")).into());
        }
        let mut storage = module.bindings(0);
        storage.retain(|binding| *binding >= STORAGE_BINDING);
        let text = map_kernel(source, &signature, bindings, WORKGROUP);
        let (layout, pipeline) = gpu.attempt(|| {
            let compiled = compile(gpu.device(), function, text, &storage);
            // wgpu keeps silent where it compiles for a device that is lost.
            if gpu.alive() { Ok(compiled) } else { Err(gpu.lost("it compiles nothing any more")) }
        })?;
        let rows_per_dispatch =
            most_rows(&gpu.device().limits(), signature.input_words().max(signature.output_words()));
        Ok(Kernel { gpu: gpu.clone(), signature, layout, pipeline, storage, rows_per_dispatch })
    }

    /// Sets the most rows that one dispatch may take, at least 1 and no more than fit the device.
    ///
    /// A driver with a watchdog (two seconds on Windows) resets a device that one dispatch keeps busy for longer.
    pub fn with_rows_per_dispatch(mut self, rows: usize) -> Self {
        self.rows_per_dispatch = rows.clamp(1, self.rows_per_dispatch);
        self
    }

    /// What the function takes and returns.
    pub fn signature(&self) -> &Signature {
        &self.signature
    }

    /// The device that the kernel runs on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The results of the function for every row of arguments, in the same order.
    ///
    /// Rows are as [`Signature::inputs`] and [`Signature::outputs`] list them, one after the other; no rows give no
    /// results. `storage` is the content of each of the module's storage buffers, in WGSL's memory layout, by ascending
    /// binding.
    ///
    /// # Errors
    /// [`GpuError::Arguments`] where `inputs` are not whole rows, or a storage buffer is missing, superfluous, empty, not
    /// whole words or too large; [`GpuError::Rejected`], [`GpuError::OutOfMemory`], [`GpuError::Lost`] from the device.
    pub fn run(&self, inputs: &[u32], storage: &[&[u8]]) -> Result<Vec<u32>, GpuError> {
        let (input_words, output_words) = (self.signature.input_words(), self.signature.output_words());
        if !inputs.len().is_multiple_of(input_words) {
            let names: Vec<_> = self.signature.inputs().into_iter().map(|leaf| leaf.name).collect();
            let (words, names) = (inputs.len(), names.join(", "));
            return Err(self.misfit(format!("{words} words are no whole rows of {input_words} ({names})")));
        }
        self.check_storage(storage)?;
        let rows = inputs.len() / input_words;
        if rows == 0 {
            return Ok(Vec::new());
        }
        let mut outputs = vec![0; rows * output_words];
        self.gpu.attempt(|| {
            let buffers = self.buffers(rows.min(self.rows_per_dispatch), storage);
            let inputs = inputs.chunks(self.rows_per_dispatch * input_words);
            for (input, output) in inputs.zip(outputs.chunks_mut(self.rows_per_dispatch * output_words)) {
                self.dispatch(&buffers, input, output)?;
            }
            Ok(())
        })?;
        Ok(outputs)
    }

    /// [`Kernel::run`] for a function of f32 alone.
    ///
    /// # Errors
    /// Those of [`Kernel::run`], and [`GpuError::Arguments`] where an argument or result is not of f32.
    pub fn run_f32(&self, inputs: &[f32], storage: &[&[u8]]) -> Result<Vec<f32>, GpuError> {
        let leaves = [self.signature.inputs(), self.signature.outputs()].concat();
        if let Some(leaf) = leaves.iter().find(|leaf| leaf.scalar != Scalar::F32) {
            return Err(self.misfit(format!("`{}` is {}, not f32: pass words", leaf.name, leaf.scalar)));
        }
        let outputs = self.run(bytemuck::cast_slice(inputs), storage)?;
        Ok(outputs.into_iter().map(f32::from_bits).collect())
    }

    fn misfit(&self, reason: String) -> GpuError {
        misfit(&self.signature.name, reason)
    }

    fn check_storage(&self, storage: &[&[u8]]) -> Result<(), GpuError> {
        let most = self.gpu.device().limits().max_storage_buffer_binding_size;
        if let Some(missing) = self.storage.get(storage.len()) {
            return Err(self.misfit(format!("the module reads a storage buffer (binding {missing}): none given")));
        }
        if storage.len() > self.storage.len() {
            let next = self.storage.last().map_or(STORAGE_BINDING, |binding| binding + 1);
            return Err(self.misfit(format!("the module declares no storage buffer at binding {next}")));
        }
        for bytes in storage {
            let size = bytes.len();
            if size == 0 || !size.is_multiple_of(4) {
                return Err(self.misfit(format!("a storage buffer of {size} bytes: whole 32-bit words are needed")));
            }
            if size as u64 > most {
                return Err(self.misfit(format!("a storage buffer of {size} bytes: the device takes {most}")));
            }
        }
        Ok(())
    }

    fn buffers(&self, rows: usize, storage: &[&[u8]]) -> Buffers {
        use wgpu::BufferUsages as Usage;
        let device = self.gpu.device();
        let buffer = |label, bytes: usize, usage| {
            let size = bytes as u64;
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let input = buffer("arguments", 4 * rows * self.signature.input_words(), Usage::STORAGE | Usage::COPY_DST);
        let output = buffer("results", 4 * rows * self.signature.output_words(), Usage::STORAGE | Usage::COPY_SRC);
        let back = buffer("results to read", output.size() as usize, Usage::MAP_READ | Usage::COPY_DST);
        let shape = buffer("shape", 16, Usage::UNIFORM | Usage::COPY_DST);
        let fill = |bytes: &&[u8]| {
            let own = buffer("storage", bytes.len(), Usage::STORAGE | Usage::COPY_DST);
            self.gpu.queue().write_buffer(&own, 0, bytes);
            own
        };
        let own: Vec<_> = storage.iter().map(fill).collect();
        let bound = [&input, &output, &shape].into_iter().zip(0..).chain(own.iter().zip(self.storage.iter().copied()));
        let entries: Vec<_> = bound
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.signature.name),
            layout: &self.layout,
            entries: &entries,
        });
        Buffers { input, output, back, shape, bind_group }
    }

    /// Runs one chunk of rows, and waits for its results.
    fn dispatch(&self, buffers: &Buffers, input: &[u32], output: &mut [u32]) -> Result<(), GpuError> {
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let rows = (input.len() / self.signature.input_words()) as u32;
        let (x, y) = grid(rows, device.limits().max_compute_workgroups_per_dimension);
        queue.write_buffer(&buffers.input, 0, bytemuck::cast_slice(input));
        queue.write_buffer(&buffers.shape, 0, bytemuck::cast_slice(&[rows, x * WORKGROUP, 0, 0]));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &buffers.bind_group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
        let bytes = size_of_val(output) as u64;
        encoder.copy_buffer_to_buffer(&buffers.output, 0, &buffers.back, 0, bytes);
        queue.submit([encoder.finish()]);

        let mapped = await_bytes(&self.gpu, &buffers.back, bytes)?;
        bytemuck::cast_slice_mut(output).copy_from_slice(&mapped);
        drop(mapped);
        buffers.back.unmap();
        Ok(())
    }
}

/// Waits for the work on a device, and maps the start of a buffer that it wrote.
pub(super) fn await_bytes(gpu: &Gpu, buffer: &wgpu::Buffer, bytes: u64) -> Result<wgpu::BufferView, GpuError> {
    let (sender, receiver) = mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, 0..bytes, move |mapped| {
        // The receiver is gone only where this call has returned.
        let _ = sender.send(mapped);
    });
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).map_err(|error| gpu.lost(&error.to_string()))?;
    match receiver.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(gpu.lost(&error.to_string())),
        Err(error) => return Err(gpu.lost(&format!("the results were not mapped: {error}"))),
    }
    buffer.get_mapped_range(0..bytes).map_err(|error| gpu.lost(&error.to_string()))
}

/// Arguments that do not fit a function.
pub(super) fn misfit(function: &str, reason: String) -> GpuError {
    GpuError::Arguments { function: function.to_owned(), reason }
}

/// What one run allocates, sized for its largest dispatch.
struct Buffers {
    input: wgpu::Buffer,
    output: wgpu::Buffer,
    back: wgpu::Buffer,
    shape: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

fn compile(
    device: &wgpu::Device,
    label: &str,
    text: String,
    storage: &[u32],
) -> (wgpu::BindGroupLayout, wgpu::ComputePipeline) {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let own = [Storage { read_only: true }, Storage { read_only: false }, Uniform].into_iter().zip(0..);
    let entries: Vec<_> = own
        .chain(storage.iter().map(|binding| (Storage { read_only: true }, *binding)))
        .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let label = Some(label);
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let module = device
        .create_shader_module(wgpu::ShaderModuleDescriptor { label, source: wgpu::ShaderSource::Wgsl(text.into()) });
    let bind_group_layouts = &[Some(&layout)];
    let whole =
        device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor { label, bind_group_layouts, immediate_size: 0 });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&whole),
        module: &module,
        entry_point: Some("brdf_map"),
        compilation_options: Default::default(),
        cache: None,
    });
    (layout, pipeline)
}

/// The most rows of at most `words` words that fit one dispatch on a device.
fn most_rows(limits: &wgpu::Limits, words: usize) -> usize {
    let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(DISPATCH_BYTES);
    let workgroups = u64::from(limits.max_compute_workgroups_per_dimension).pow(2);
    let rows = (bytes / (4 * words.max(1) as u64)).min(workgroups.saturating_mul(u64::from(WORKGROUP)));
    rows.max(1) as usize
}

/// The workgroups along x and y that cover the rows, with no more than `most` along either.
fn grid(rows: u32, most: u32) -> (u32, u32) {
    let groups = rows.div_ceil(WORKGROUP);
    let x = groups.min(most.max(1));
    (x, groups.div_ceil(x.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_cover_all_rows() {
        let most = 65535;
        for rows in [1, 63, 64, 65, most * WORKGROUP, most * WORKGROUP + 1, 1 << 24] {
            let (x, y) = grid(rows, most);
            assert!(x <= most && y <= most);
            assert!(x * y * WORKGROUP >= rows, "{rows}: {x}×{y}");
        }
        assert_eq!(grid(65, most), (2, 1));
        assert_eq!(grid(most * WORKGROUP + 1, most), (most, 2));
    }

    #[test]
    fn dispatches_fit_the_limits() {
        let mut limits = wgpu::Limits::default();
        assert_eq!(most_rows(&limits, 1), 1 << 24);
        limits.max_buffer_size = 4096;
        assert_eq!(most_rows(&limits, 8), 128);
        limits.max_compute_workgroups_per_dimension = 1;
        assert_eq!(most_rows(&limits, 1), 64);
        assert_eq!(most_rows(&limits, 1 << 20), 1);
    }
}
