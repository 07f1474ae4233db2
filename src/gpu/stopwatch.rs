//! The run time of a compute entry point on one device.

use super::kernel::{await_bytes, misfit};
use super::{Gpu, GpuError};
use std::time::Instant;

/// A compute entry point whose dispatches are timed.
///
/// Group 0 holds a writable storage buffer at binding 0, and read-only ones at the bindings after it; the module uses each.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    gpu: Gpu,
    pipeline: wgpu::ComputePipeline,
    output: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    inputs: Vec<wgpu::Buffer>,
}

/// The time of one dispatch, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lap {
    /// By the host's clock, from submission to completion.
    pub wall_ns: f64,
    /// By the device's own, before and after the kernel; none where it writes no timestamps, or ones that cannot be.
    pub device_ns: Option<f64>,
}

impl Stopwatch {
    /// Compiles an entry point, and fills the buffers that it reads.
    ///
    /// # Errors
    /// [`GpuError::Arguments`] for an empty buffer; [`GpuError::Rejected`], [`GpuError::OutOfMemory`], [`GpuError::Lost`] from
    /// the device.
    pub fn new(gpu: &Gpu, source: &str, entry: &str, output_words: usize, inputs: &[&[u8]]) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Usage;
        if output_words == 0 || inputs.iter().any(|bytes| bytes.is_empty() || !bytes.len().is_multiple_of(4)) {
            return Err(misfit(entry, "every storage buffer must have whole words, at least one".to_owned()));
        }
        gpu.attempt(|| {
            let device = gpu.device();
            let source = wgpu::ShaderSource::Wgsl(source.into());
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(entry), source });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            });
            let buffer = |bytes: u64, usage| {
                let usage = Usage::STORAGE | usage;
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: bytes,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let output = buffer(4 * output_words as u64, Usage::COPY_SRC);
            let fill = |bytes: &&[u8]| {
                let buffer = buffer(bytes.len() as u64, Usage::COPY_DST);
                gpu.queue().write_buffer(&buffer, 0, bytes);
                buffer
            };
            let inputs: Vec<_> = inputs.iter().map(fill).collect();
            let bound = std::iter::once(&output).chain(&inputs).zip(0..);
            let entries: Vec<_> = bound
                .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            let layout = &pipeline.get_bind_group_layout(0);
            let descriptor = wgpu::BindGroupDescriptor { label: Some(entry), layout, entries: &entries };
            let bind_group = device.create_bind_group(&descriptor);
            Ok(Stopwatch { gpu: gpu.clone(), pipeline, output, bind_group, inputs })
        })
    }

    /// Replaces the content of the read-only buffer at this binding, counted from 1.
    ///
    /// # Errors
    /// [`GpuError::Arguments`] where there is none, or it has another size.
    pub fn write(&self, binding: usize, bytes: &[u8]) -> Result<(), GpuError> {
        match binding.checked_sub(1).and_then(|index| self.inputs.get(index)) {
            Some(buffer) if buffer.size() == bytes.len() as u64 => {
                self.gpu.attempt(|| {
                    self.gpu.queue().write_buffer(buffer, 0, bytes);
                    Ok(())
                })?;
                Ok(())
            }
            _ => Err(misfit("write", format!("no buffer of {} bytes at binding {binding}", bytes.len()))),
        }
    }

    /// Runs this many workgroups, waits for them, and says how long the device took.
    ///
    /// # Errors
    /// [`GpuError::Rejected`] or [`GpuError::Lost`] from the device.
    pub fn lap(&self, workgroups: u32) -> Result<Lap, GpuError> {
        self.gpu.attempt(|| {
            let (device, queue) = (self.gpu.device(), self.gpu.queue());
            let stamped = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
            let ty = wgpu::QueryType::Timestamp;
            let queries =
                stamped.then(|| device.create_query_set(&wgpu::QuerySetDescriptor { label: None, ty, count: 2 }));
            let buffer = |usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: 16,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
            let back = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let timestamp_writes = queries.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: Some(1),
                });
                let mut pass =
                    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &self.bind_group, &[]);
                pass.dispatch_workgroups(workgroups, 1, 1);
            }
            match &queries {
                Some(queries) => {
                    encoder.resolve_query_set(queries, 0..2, &resolved, 0);
                    encoder.copy_buffer_to_buffer(&resolved, 0, &back, 0, 16);
                }
                // Something to wait for that the kernel wrote.
                None => encoder.copy_buffer_to_buffer(&self.output, 0, &back, 0, 4),
            }
            let commands = encoder.finish();
            let start = Instant::now();
            queue.submit([commands]);
            let bytes = await_bytes(&self.gpu, &back, 16)?;
            let wall = start.elapsed().as_nanos() as f64;
            let stamp = |at: usize| bytemuck::pod_read_unaligned::<u64>(&bytes[at..at + 8]);
            let (first, last) = (stamp(0), stamp(8));
            let ns = last.wrapping_sub(first) as f64 * f64::from(queue.get_timestamp_period());
            // A software renderer may stamp when it records, and a driver may stamp nothing at all.
            let sane = stamped && ns <= 1.01 * wall + 1e4 && ns >= 0.1 * (wall - 2e6);
            Ok(Lap { wall_ns: wall, device_ns: sane.then_some(ns) })
        })
    }
}
