//! Directional albedos by the walk, for each microsurface, and what a walk costs.
//!
//! `cargo run --release --example walk_tables`

use brdf::Vector;
use brdf::layered::{Interface, Layer, Model, Stack, StackError};
use brdf::material::stack::built_in;
use brdf::walk::{self, Microsurface, Options};
use std::time::Instant;

fn main() -> Result<(), StackError> {
    let coat = || Layer::new(Interface::dielectric(1.5, 0.1));
    let bases = [
        ("diffuse .5, m = .1", Interface::diffuse([0.5], 0.0)),
        ("Cu.r, m = .1/.1", Interface::conductor([0.213], [4.05], 0.1)),
    ];
    println!("directional albedo ± standard error at 0°, 60°, 80°");
    for (name, base) in bases {
        let stack = Stack::new(Model::Conserving, vec![coat(), Layer::new(base)])?;
        for microsurface in [Microsurface::VCavities, Microsurface::SmithBeckmann, Microsurface::SmithGgx] {
            print!("{name:20} {:14}", format!("{microsurface:?}"));
            for theta in [0.0f64, 60.0, 80.0] {
                let options = Options { samples: 1 << 19, microsurface, ..Options::default() };
                let albedo = walk::albedo(&stack, Vector::from_angles(theta.to_radians(), 0.0), &options);
                print!("  {:.4} ± {:.4}", albedo.mean[0], albedo.standard_error[0]);
            }
            println!();
        }
    }
    println!("\nevaluate at 20°/50°, three channels, one thread: relative standard deviation of a walk, and its cost");
    for material in built_in().into_iter().filter(|material| material.stack.layers().len() > 1) {
        let options = Options { samples: 1 << 16, threads: 1, ..Options::default() };
        let [wi, wo] = [(20.0f64, 0.0f64), (50.0, 100.0)]
            .map(|(theta, phi)| Vector::from_angles(theta.to_radians(), phi.to_radians()));
        let start = Instant::now();
        let f = walk::evaluate(&material.stack, wi, wo, &options);
        let cost = start.elapsed().as_nanos() as f64 / f64::from(f.samples);
        let spread = f.standard_error[0] * f64::from(f.samples).sqrt() / f.mean[0];
        println!("{:28} {spread:8.2} {cost:8.0} ns", material.name);
    }
    Ok(())
}
