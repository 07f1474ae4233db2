// A film that scatters and absorbs, over a ground. Twin of src/material/kubelka_munk.rs, which derives the form.

import package::real;

// The weight beside which any other is nothing.
const _most: f32 = 1e30;

// (1-R_g(A-B·coth BSX))/(A-R_g+B·coth BSX), A = 1+K/S, B² = A²-1, as the mean of A-B and R_g.
fn film(absorption: f32, scattering: f32, thickness: f32, ground: f32) -> f32 {
    let rate = sqrt(absorption * (absorption + 2.0 * scattering));
    let twice = 2.0 * rate;
    let sum = rate + absorption + scattering;
    let deep = scattering / select(1.0, sum, sum > 0.0);
    let depth = twice * thickness;
    let faded = real::exp_product(twice, thickness);
    // (1-exp(-d))/(2·rate), the thickness where the film is thin.
    let thin = depth < 0.5;
    let reached = select((1.0 - faded) / select(twice, 1.0, thin), thickness * _fading(select(0.0, depth, thin)), thin);
    let hidden = min(reached * (rate + absorption + (1.0 - ground) * scattering), _most);
    let total = hidden + faded;
    return (deep * hidden + ground * faded) / select(1.0, total, total > 0.0);
}

// (1-exp(-d))/d for d in [0, 1/2]: Taylor's series, to double precision.
fn _fading(depth: f32) -> f32 {
    var rest = 1.0 - depth * (1.0 / 14.0);
    rest = 1.0 - depth * (1.0 / 13.0) * rest;
    rest = 1.0 - depth * (1.0 / 12.0) * rest;
    rest = 1.0 - depth * (1.0 / 11.0) * rest;
    rest = 1.0 - depth * (1.0 / 10.0) * rest;
    rest = 1.0 - depth * (1.0 / 9.0) * rest;
    rest = 1.0 - depth * (1.0 / 8.0) * rest;
    rest = 1.0 - depth * (1.0 / 7.0) * rest;
    rest = 1.0 - depth * (1.0 / 6.0) * rest;
    rest = 1.0 - depth * (1.0 / 5.0) * rest;
    rest = 1.0 - depth * 0.25 * rest;
    rest = 1.0 - depth * (1.0 / 3.0) * rest;
    return 1.0 - depth * 0.5 * rest;
}
