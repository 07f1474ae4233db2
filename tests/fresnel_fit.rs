//! `fresnel::Fit` against the exact equations.

use brdf::fresnel::{self, Fit};
use brdf::material::metal::METALS;

#[test]
fn table() {
    let mut all: Vec<(String, [f64; 3], [f64; 3])> = METALS.iter().map(|m| (m.name.to_owned(), m.n, m.k)).collect();
    for n in [1.33, 1.5, 2.42] {
        all.push((format!("n {n}"), [n; 3], [0.0; 3]));
    }
    all.push(("coats".into(), [1.33, 1.5, 2.42], [0.0; 3]));
    for n in [1.0, 1.0001, 1.01, 1.1, 4.0, 0.9, 0.6667, 0.3] {
        all.push((format!("n {n}"), [n; 3], [0.0; 3]));
    }
    all.push(("0.5+.1i".into(), [0.5; 3], [0.1; 3]));
    all.push(("0.5+.5i".into(), [0.5; 3], [0.5; 3]));
    all.push(("0.02+12i".into(), [0.02; 3], [12.0; 3]));
    all.push(("8+12i".into(), [8.0; 3], [12.0; 3]));
    for (name, n, k) in all {
        let t = std::time::Instant::now();
        let eight = Fit::<3, 8>::new(n, k).unwrap();
        let ms = t.elapsed().as_secs_f64() * 1e3;
        let twelve = Fit::<3, 12>::new(n, k).unwrap();
        let big = eight.coefficients.as_flattened().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        println!(
            "{name:24} {:.2} {} | {:.2} {}  {ms:.1} ms, coef {big:.1}",
            eight.bend, list(eight.max_error), twelve.bend, list(twelve.max_error)
        );
        let _ = fresnel::conductor(0.5, n[0], k[0]);
    }
}

fn list(errors: [f64; 3]) -> String {
    errors.map(|e| format!("{e:.1e}")).join(" ")
}
