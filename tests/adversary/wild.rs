//! Finite inputs outside the terms' domains.

use crate::strategy::Search;
use crate::stacks::decades;
use crate::terms::{Term, terms};
use crate::{generations, in_parallel};

/// What each argument of a term is, in order.
///
/// v: a direction or half vector (three numbers); c: a cosine; n: an index; k: its imaginary part; a: a width; s: a share of
/// 1 or an angle; x: any number ≥ 0.
fn kinds(term: &Term) -> &'static str {
    match (term.module, term.function) {
        ("fresnel", "dielectric" | "refracted_square") | ("refraction", "cos_t") => "cn",
        ("fresnel", "conductor" | "conductor_approx" | "lazanyi_uncorrected") => "cnk",
        ("fresnel", "normal_incidence") => "nk",
        ("fresnel", "schlick") => "cs",
        ("fresnel", "schlick_from_indices") => "cnn",
        ("fresnel", "lazanyi") => "cnksx",
        ("fresnel", "f82_tint") => "css",
        ("distribution", "beckmann" | "ggx" | "blinn") => "va",
        ("distribution", "gaussian") => "vax",
        ("distribution", _) => "vaa",
        ("masking", "v_cavity" | "kelemen") => "vv",
        ("masking", "projected_area_ggx" | "projected_area_beckmann") => "vaa",
        ("masking", _) => "vvaa",
        ("diffuse", "lambert") => "s",
        ("diffuse", "oren_nayar") => "vvs",
        ("diffuse", "oren_nayar_qualitative") => "vvss",
        ("refraction", "refract") => "vn",
        ("refraction", "refract_about") => "vvn",
        ("absorption", _) => "xxcc",
        ("phong", _) => "vvx",
        ("microfacet", "cos_half") => "vv",
        ("microfacet", "facets") => "vva",
        ("microfacet", _) => "vvnka",
        ("layered", "internal_reflection") => "ss",
        ("layered", _) => "vvnaxxnka",
        ("real", "erfcx") => "x",
        ("real", _) => "xx",
        (module, function) => panic!("{module}::{function} has no kinds"),
    }
}

fn scalar(kind: char, gene: f64, wild: bool) -> f64 {
    if !wild {
        return match kind {
            'c' => decades(gene, 1e-6, 1.0),
            'n' => decades(gene, 1e-3, 1e3),
            'k' => if gene < 0.25 { 0.0 } else { decades(gene, 1e-3, 1e3) },
            'a' => decades(gene, 1e-4, 1.0),
            's' => gene,
            _ => decades(gene, 1e-6, 1e6),
        };
    }
    match kind {
        'c' => [0.0, -1.0, 2.0, -0.0, 1e-30, 1e30, -1e30][(gene * 6.99) as usize],
        's' => [0.0, -1.0, 2.0, -0.0, 1e-30, 1e30, -1e30][(gene * 6.99) as usize],
        'n' => [0.0, -1.5, 1e-30, 1e6, 1e15, 1e30][(gene * 5.99) as usize],
        'k' => [0.0, -1.5, 1e-30, 1e6, 1e15, 1e30][(gene * 5.99) as usize],
        'a' => [0.0, -0.5, 1e-30, 1e-10, 1e10][(gene * 4.99) as usize],
        _ => [0.0, -1.0, 1e-30, 1e30][(gene * 3.99) as usize],
    }
}

#[test]
fn explore() {
    // class: 'l' lengths, 'h' horizon, else scalar kind made wild
    let g = generations(20);
    for line in in_parallel(terms(), |term| {
        let kinds = kinds(&term);
        let mut out = format!("{}\n", term.name());
        for class in "lhcnkasx".chars() {
            if !(kinds.contains(class) || (kinds.contains('v') && "lh".contains(class))) { continue; }
            for (double, label) in [(false, "f32"), (true, "f64")] {
                let row = |genes: &[f64]| {
                    let mut row = Vec::new();
                    let mut at = 0;
                    for kind in kinds.chars() {
                        if kind == 'v' {
                            let cos = if class == 'h' { 2.0 * genes[at] - 1.0 } else { decades(genes[at], 1e-6, 1.0) };
                            let cos = if genes[at] == 0.5 { 0.0 } else { cos };
                            let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
                            let phi = 6.283185307179586 * (genes[at + 1] * 8.0).floor() / 8.0;
                            let length = if class == 'l' { decades(genes[at + 2], 1e-20, 1e20) } else { 1.0 };
                            row.extend([sin * phi.cos() * length, sin * phi.sin() * length, cos * length]);
                            at += 3;
                        } else {
                            row.push(scalar(kind, genes[at], class == kind));
                            at += 1;
                        }
                    }
                    row
                };
                let values = |row: &[f64]| -> Vec<f64> {
                    if double { (term.double)(row)[..term.results.len()].to_vec() } else {
                        let narrow: Vec<f32> = row.iter().map(|x| *x as f32).collect();
                        (term.single)(&narrow)[..term.results.len()].iter().map(|x| f64::from(*x)).collect()
                    }
                };
                for (what, test) in [("NaN", (|v: f64| v.is_nan()) as fn(f64) -> bool), ("inf", |v| v.is_infinite()), ("neg", |v| v < 0.0)] {
                    if what == "neg" && term.signed { continue; }
                    let search = Search { genes: 27, generations: g, restarts: 2, seed: 3 };
                    let find = search.run(|genes| { let v = values(&row(genes)); if v.iter().any(|v| test(*v)) { f64::INFINITY } else { v.iter().map(|v| if what == "neg" { -v } else { v.abs() }).fold(-1e300, f64::max) } });
                    if find.fitness == f64::INFINITY { let r = row(&find.genes); out += &format!("    {class} {label} {what}: {:?} {:?}\n", r, values(&r)); }
                }
            }
        }
        out
    }) { print!("{line}"); }
}
