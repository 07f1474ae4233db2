//! The tables in textures, on every adapter: read by `textureLoad` through the twins, and by a filtering sampler.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::Vector;
use brdf::gpu::Gpu;
use brdf::gpu::wgpu::{self, BufferUsages as Usage, TextureFormat as Format};
use brdf::interval::WgslInterval;
use brdf::material::metal::METALS;
use brdf::parity::Draw;
use brdf::table::{DistributionTable, ENTRIES, FresnelAtlas, FresnelTable, Half, Mapping};
use brdf::wgsl;

const SAMPLES: usize = 4096;
const SIZE: (usize, usize) = (200, 300);

/// What a renderer writes: textures, and the two functions by which `table` reads them.
const LOADED: &str = "
import brdf::table;

@group(0) @binding(0) var<storage, read> inputs: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> outputs: array<vec4f>;
@group(0) @binding(2) var<uniform> shape: table::Shape;
@group(0) @binding(3) var fresnel_atlas: texture_2d<f32>;
@group(0) @binding(4) var widths: texture_2d<f32>;

fn fresnel_texel(column: u32, row: u32) -> vec3f {
    return textureLoad(fresnel_atlas, vec2i(vec2u(column, row)), 0).xyz;
}
fn distribution_texel(column: u32, row: u32) -> f32 {
    return textureLoad(widths, vec2i(vec2u(column, row)), 0).x;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let h = inputs[2u * id.x].xyz;
    let cosine_row = inputs[2u * id.x + 1u].xy;
    let f = table::fresnel_over_MAPPING(cosine_row.x, u32(cosine_row.y), 128u);
    outputs[id.x] = vec4f(f, table::beckmann_over_MAPPING(h, inputs[2u * id.x].w, shape));
}
";

/// The same over the root, by a sampler that interpolates: one fetch each.
const SAMPLED: &str = "
struct Shape { columns: u32, rows: u32, least: f32, rate: f32 }
@group(0) @binding(0) var<storage, read> inputs: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> outputs: array<vec4f>;
@group(0) @binding(2) var<uniform> shape: Shape;
@group(0) @binding(3) var fresnel_atlas: texture_2d<f32>;
@group(0) @binding(4) var widths: texture_2d<f32>;
@group(0) @binding(5) var linear: sampler;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let h = inputs[2u * id.x].xyz;
    let m = max(inputs[2u * id.x].w, shape.least);
    let cosine_row = inputs[2u * id.x + 1u].xy;
    let size = vec2f(textureDimensions(fresnel_atlas));
    let f = textureSampleLevel(fresnel_atlas, linear, (vec2f(sqrt(cosine_row.x) * 127.0, cosine_row.y) + 0.5) / size, 0.0);
    let s = h.x * h.x + h.y * h.y;
    let place = vec2f(sqrt(sqrt(sqrt(s / (s + h.z * h.z)))), sqrt(sqrt(m))) * vec2f(f32(shape.columns - 1u), f32(shape.rows - 1u));
    let d = textureSampleLevel(widths, linear, (place + 0.5) / vec2f(f32(shape.columns), f32(shape.rows)), 0.0);
    outputs[id.x] = vec4f(f.xyz, d.x / (3.14159265 * m * m));
}
";

/// A half vector and a width, then a cosine and a row of the atlas.
fn inputs() -> Vec<[f32; 8]> {
    let input = |index| {
        let mut d = Draw::new(index);
        let alpha = d.width();
        let (h, cos, row) = (d.half_vector(alpha), d.fraction(), (d.unit() * METALS.len() as f64).floor());
        [h.x, h.y, h.z, alpha, cos, row, 0.0, 0.0].map(|x| x as f32)
    };
    (0..SAMPLES as u64).map(input).collect()
}

struct Tables {
    fresnel: FresnelAtlas<u8>,
    distribution: DistributionTable<Half>,
}

fn tables(mapping: Mapping) -> Tables {
    let mut fresnel = FresnelAtlas::new(ENTRIES, mapping).expect("a length within the range");
    for metal in METALS {
        let table = FresnelTable::new(metal.n, metal.k, ENTRIES, mapping).expect("a built-in metal");
        fresnel.push(table).expect("a table of this length");
    }
    let distribution = DistributionTable::new(SIZE.0, SIZE.1, 2.3e-3, mapping).expect("within the ranges");
    Tables { fresnel, distribution }
}

fn texture(gpu: &Gpu, format: Format, (width, height): (usize, usize), bytes: &[u8]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 };
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = Some((bytes.len() / height) as u32);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    gpu.queue().write_texture(texture.as_image_copy(), bytes, layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// F and D of every input, by a shader that reads the tables as textures.
fn run(gpu: &Gpu, source: &str, tables: &Tables, inputs: &[[f32; 8]]) -> Vec<[f32; 4]> {
    let (device, queue) = (gpu.device(), gpu.queue());
    let atlas = tables.fresnel.texels();
    let atlas =
        texture(gpu, Format::Rgba8Unorm, (ENTRIES, tables.fresnel.tables().len()), bytemuck::cast_slice(&atlas));
    let widths = texture(gpu, Format::R16Float, SIZE, bytemuck::cast_slice(tables.distribution.texels()));
    let filter = wgpu::FilterMode::Linear;
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: filter,
        min_filter: filter,
        ..wgpu::SamplerDescriptor::default()
    });
    let buffer = |size: usize, usage| {
        let size = size as u64;
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    };
    let bytes = 16 * inputs.len();
    let input = buffer(2 * bytes, Usage::STORAGE | Usage::COPY_DST);
    let output = buffer(bytes, Usage::STORAGE | Usage::COPY_SRC);
    let back = buffer(bytes, Usage::MAP_READ | Usage::COPY_DST);
    let shape = buffer(16, Usage::UNIFORM | Usage::COPY_DST);
    queue.write_buffer(&input, 0, bytemuck::cast_slice(inputs));
    queue.write_buffer(&shape, 0, bytemuck::bytes_of(&tables.distribution.shape()));

    let samples = source.contains("sampler");
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let mut entries: Vec<_> = (0..)
        .zip([&input, &output, &shape])
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    for (binding, view) in [(3, &atlas), (4, &widths)] {
        entries.push(wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) });
    }
    if samples {
        entries.push(wgpu::BindGroupEntry { binding: 5, resource: wgpu::BindingResource::Sampler(&sampler) });
    }
    let layout = pipeline.get_bind_group_layout(0);
    let bind_group =
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(inputs.len() as u32 / 64, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &back, 0, bytes as u64);
    queue.submit([encoder.finish()]);
    back.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("results are mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
    let mapped = back.get_mapped_range(..).expect("results are mapped");
    bytemuck::pod_collect_to_vec(&mapped)
}

/// The twins through `textureLoad`: each result lies in the interval that WGSL's rules allow the formula.
#[test]
fn twins_read_textures() {
    let inputs = inputs();
    for gpu in adapters_for_tests() {
        for (mapping, name) in [(Mapping::Angle, "angle"), (Mapping::Root, "root")] {
            let tables = tables(mapping);
            let source = wgsl::link(&LOADED.replace("MAPPING", name)).expect("the shader links");
            let results = run(&gpu, &source, &tables, &inputs);
            for (input, [r, g, b, d]) in inputs.iter().zip(results) {
                let [x, y, z, alpha, cos] = [0, 1, 2, 3, 4].map(|i| WgslInterval::exactly(input[i]));
                let table = &tables.fresnel.tables()[input[5] as usize];
                // What a texture unit adds where it turns a byte into an f32: an ULP of a number below 1.
                let slack = 2f64.powi(-24);
                for (got, allowed) in [r, g, b].into_iter().zip(table.reflectance(cos)) {
                    let allowed = (allowed.low() - slack)..=(allowed.high() + slack);
                    assert!(allowed.contains(&f64::from(got)), "{}: F {name} {input:?}: {got} {allowed:?}", gpu.info());
                }
                let allowed = tables.distribution.evaluate(Vector::new(x, y, z), alpha);
                assert!(allowed.contains(d), "{}: D {name} {input:?}: {d} {allowed:?}", gpu.info());
            }
        }
    }
}

/// A filtering sampler, whose fractions have 8 bits and which may filter bytes in bytes: a step of 1/255, and 1/128 of the
/// difference between neighbours.
#[test]
fn a_sampler_reads_the_tables_in_one_fetch() {
    let inputs = inputs();
    let tables = tables(Mapping::Root);
    for gpu in adapters_for_tests() {
        let results = run(&gpu, SAMPLED, &tables, &inputs);
        let mut worst = [0.0f64; 2];
        for (input, [r, g, b, d]) in inputs.iter().zip(results) {
            let [x, y, z, alpha, cos] = [0, 1, 2, 3, 4].map(|i| f64::from(input[i]));
            let table = &tables.fresnel.tables()[input[5] as usize];
            for (got, want) in [r, g, b].into_iter().zip(table.reflectance(cos)) {
                worst[0] = worst[0].max((f64::from(got) - want).abs());
            }
            let m = alpha.max(2.3e-3);
            let scale = std::f64::consts::PI * m * m;
            let want = tables.distribution.evaluate(Vector::new(x, y, z), alpha);
            worst[1] = worst[1].max((f64::from(d) - want).abs() * scale);
        }
        println!("{}: F within {:.1e}, D within {:.1e} of its peak", gpu.info(), worst[0], worst[1]);
        let steps = tables.fresnel.tables().iter().flat_map(|table| table.entries().windows(2));
        let step = steps.flat_map(|w| [0, 1, 2].map(|c| w[0][c].abs_diff(w[1][c]))).max().unwrap_or(0);
        assert!(worst[0] <= (1.0 + f64::from(step) / 128.0) / 255.0, "{}: {worst:?}", gpu.info());
        // Along both axes.
        let texel = |i: usize| tables.distribution.texels()[i].to_f64();
        let (columns, count) = (SIZE.0, SIZE.0 * SIZE.1);
        let along = |by: usize| (0..count - by).map(|i| (texel(i) - texel(i + by)).abs()).fold(0.0, f64::max);
        let across = (0..count - 1).filter(|i| (i + 1) % columns != 0);
        let across = across.map(|i| (texel(i) - texel(i + 1)).abs()).fold(0.0, f64::max);
        assert!(worst[1] <= (across + along(columns)) / 128.0, "{}: {worst:?}", gpu.info());
    }
}
