//! How fast the evaluator of WGSL is beside the native functions, by the size of a block. Prints millions of rows a second.
//!
//! `cargo run --release --features cli --example interp_speed`

use brdf::gpu::{STACK_BINDINGS, layer_bytes};
use brdf::layered::{Model, Stack};
use brdf::parity::Draw;
use brdf::shader::interp::{Buffers, Cell, Program, Shader};
use brdf::{Vector, distribution, material, wgsl};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

const ROWS: u64 = 1 << 16;

/// Millions of rows a second, the best of seven.
fn rate(mut run: impl FnMut()) -> f64 {
    let best = (0..7).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    ROWS as f64 / best.fold(f64::INFINITY, f64::min) / 1e6
}

fn main() -> Result<(), Box<dyn Error>> {
    let halves: Vec<[f32; 4]> = (0..ROWS)
        .map(|index| {
            let draw = &mut Draw::new(index);
            let alpha = draw.width();
            let h = draw.half_vector(alpha).cast::<f32>();
            [h.x, h.y, h.z, alpha as f32]
        })
        .collect();
    let native = rate(|| {
        for [x, y, z, alpha] in &halves {
            black_box(distribution::ggx(Vector::new(*x, *y, *z), *alpha));
        }
    });
    let source = wgsl::link_function("distribution", "ggx")?;
    let cells: Vec<_> = halves.iter().flatten().map(|x| Cell::Real(*x)).collect();
    report("distribution::ggx", native, &source, "distribution_ggx", &cells, &Buffers::new())?;

    for material in material::stack::built_in().into_iter().take(3) {
        let stack: Stack<f32, 3> = material.stack.cast::<f32>().with_model(Model::Conserving);
        let pairs: Vec<[Vector<f32>; 2]> =
            (0..ROWS).map(|index| Draw::new(index).pair(0.3).map(Vector::cast::<f32>)).collect();
        let native = rate(|| {
            for [wi, wo] in &pairs {
                black_box(stack.evaluate(*wi, *wo));
            }
        });
        let source = format!("{}\n{STACK_BINDINGS}", wgsl::link_function("layered", "conserving")?);
        let range = [Cell::Word(0), Cell::Word(stack.layers().len() as u32)];
        let directions = |[wi, wo]: &[Vector<f32>; 2]| [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(Cell::Real);
        let cells: Vec<_> = pairs.iter().flat_map(|pair| range.into_iter().chain(directions(pair))).collect();
        let buffers = Buffers::new().with(0, 3, layer_bytes(stack.layers()));
        let name = format!("layered::conserving, {}", material.name);
        report(&name, native, &source, "layered_conserving", &cells, &buffers)?;
    }
    Ok(())
}

fn report(
    name: &str,
    native: f64,
    source: &str,
    function: &str,
    cells: &[Cell<f32>],
    buffers: &Buffers,
) -> Result<(), Box<dyn Error>> {
    println!("{name}: native {native:.2}");
    let shader = Shader::parse(source)?;
    for block in [64, 128, 256, 512, 1024] {
        let program = Program::<f32>::new(&shader, function)?.with_block(block);
        let mut buffers = buffers.clone();
        let mut failure = None;
        let rate = rate(|| match program.run(cells, &mut buffers) {
            Ok(results) => drop(black_box(results)),
            Err(error) => failure = Some(error),
        });
        if let Some(error) = failure {
            return Err(error.into());
        }
        println!("  block {block:4}: {rate:.2}, 1/{:.1} of native", native / rate);
    }
    Ok(())
}
