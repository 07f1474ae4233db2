//! The twins in double precision against the Rust functions in double precision.

use brdf::gpu::{STACK_BINDINGS, layer_bytes};
use brdf::interval::WgslInterval;
use brdf::parity::{Draw, Twin, layers, twins};
use brdf::shader::Scalar;
use brdf::shader::interp::{Buffers, Cell, Known, Program, Shader};
use brdf::wgsl;

const SAMPLES: u64 = 4_000;

/// The text of a twin with all that it needs.
fn linked(twin: &Twin) -> String {
    let source = wgsl::link_function(twin.module, twin.function).expect("a library function links");
    if source.contains("stack_layer(") { format!("{source}\n{STACK_BINDINGS}") } else { source }
}

fn buffers() -> Buffers {
    Buffers::new().with(0, 3, layer_bytes(layers()))
}
fn known() -> Vec<(String, Known)> {
    [("sum_exact", Known::SumExact), ("product_exact", Known::ProductExact), 
     ("ln_one_plus", Known::LnOnePlus), ("angle", Known::Angle), ("erfcx", Known::Erfcx), ("unit_circle", Known::UnitCircle)].into_iter().map(|(n, k)| (wgsl::mangled("real", n), k)).collect()
}

#[test]
fn explore() {
    for twin in twins() {
        let source = linked(&twin).replace("87.0", "708.0");
        let shader = Shader::in_double(&source).unwrap_or_else(|error| panic!("{}::{}: {error}\n{source}", twin.module, twin.function));
        let program: Program<f64> = match Program::with_known(&shader, &wgsl::mangled(twin.module, twin.function), &known()[2..]) { Ok(p) => p, Err(e) => { println!("{}::{} {e}", twin.module, twin.function); continue; } };
        let leaves = program.signature().expect("a plain function").inputs();
        let rows: Vec<Vec<f64>> = (0..SAMPLES).map(|index| (twin.sample)(&mut Draw::new(index)).into_iter().map(|x| f64::from(x as f32)).collect()).collect();
        let cells: Vec<Cell<f64>> = rows.iter().flat_map(|row| row.iter().zip(&leaves).map(|(value, leaf)| match leaf.scalar {
            Scalar::F32 => Cell::Real(*value),
            _ => Cell::Word(*value as u32),
        })).collect();
        let start = std::time::Instant::now();
        let results = match program.run(&cells, &mut buffers()) { Ok(r) => r, Err(e) => { println!("{}::{} {e}", twin.module, twin.function); continue; } };
        let seconds = start.elapsed().as_secs_f64();
        let width = results.len() / rows.len();
        let mut worst = (0.0, Vec::new(), 0.0, 0.0);
        for (row, got) in rows.iter().zip(results.chunks(width)) {
            let want = (twin.double)(row);
            for (got, want) in got.iter().zip(want) {
                let Cell::Real(got) = got else { panic!() };
                let error = (got - want).abs() / want.abs().max(1e-300);
                if error > worst.0 || !error.is_finite() && *got != want { worst = (error, row.clone(), *got, want); }
            }
        }
        if worst.0 > 1e-15 { println!("{:>12}::{:28} {:9.2e} {:7.1} ns/row  {:?}", twin.module, twin.function, worst.0, 1e9 * seconds / rows.len() as f64, (worst.1, worst.2, worst.3)); }
    }
}

#[test]
fn explore_intervals() {
    for twin in twins() {
      for n in [2, 6] {
        let source = linked(&twin);
        let shader = Shader::in_double(&source).unwrap_or_else(|error| panic!("{}::{}: {error}\n{source}", twin.module, twin.function));
        let program: Program<WgslInterval> = match Program::with_known(&shader, &wgsl::mangled(twin.module, twin.function), &known()[..n]) { Ok(p) => p, Err(e) => { println!("{}::{} {e}", twin.module, twin.function); continue; } };
        let leaves = program.signature().expect("a plain function").inputs();
        let rows: Vec<Vec<f64>> = (0..SAMPLES).map(|index| (twin.sample)(&mut Draw::new(index)).into_iter().map(|x| f64::from(x as f32)).collect()).collect();
        let cells: Vec<Cell<WgslInterval>> = rows.iter().flat_map(|row| row.iter().zip(&leaves).map(|(value, leaf)| match leaf.scalar {
            Scalar::F32 => Cell::Real(WgslInterval::exactly(*value as f32)),
            _ => Cell::Word(*value as u32),
        })).collect();
        let start = std::time::Instant::now();
        let results = match program.run(&cells, &mut buffers()) { Ok(r) => r, Err(e) => { println!("{}::{} {e}", twin.module, twin.function); continue; } };
        let seconds = start.elapsed().as_secs_f64();
        let width = results.len() / rows.len();
        let (mut free, mut free_rust) = (0, 0);
        let mut ratios = Vec::new();
        for (row, got) in rows.iter().zip(results.chunks(width)) {
            let points: Vec<_> = row.iter().map(|x| WgslInterval::exactly(*x as f32)).collect();
            let want = (twin.allowed)(&points);
            for (got, want) in got.iter().zip(want) {
                let Cell::Real(got) = got else { panic!() };
                free += usize::from(!got.is_bounded());
                free_rust += usize::from(!want.is_bounded());
                if got.is_bounded() && want.is_bounded() { ratios.push((got.high() - got.low()).max(1e-300) / (want.high() - want.low()).max(1e-300)); }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let at = |p: f64| ratios.get(((ratios.len() as f64 - 1.0) * p) as usize).copied().unwrap_or(0.0);
        println!("{:>12}::{:28} {n} free {:5} {:5}  width ratio median {:.3} 99% {:.3} max {:.3e} min {:.3} {:7.1} ns/row", twin.module, twin.function, free, free_rust, at(0.5), at(0.99), at(1.0), at(0.0), 1e9 * seconds / rows.len() as f64);
      }
    }
}
