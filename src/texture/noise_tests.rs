//! Noise against what it must be at lattice points, over symmetric cells and at the bound of its sum.

use super::*;
use alloc::vec::Vec;

const SEEDS: [u32; 4] = [0, 1, 7, u32::MAX];

fn point(x: f64, y: f64, z: f64) -> Vector<f64> {
    Vector::new(x, y, z)
}

/// Points of a low-discrepancy sequence in a cube of this size about the origin.
fn points(count: u32, size: f64) -> impl Iterator<Item = Vector<f64>> {
    // The generalised golden ratio of three dimensions (Roberts 2018).
    let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
    (0..count).map(move |i| {
        let [x, y, z] = steps.map(|step| ((f64::from(i) + 0.5) * step).fract() * size - 0.5 * size);
        point(x, y, z)
    })
}

/// The gradient at a lattice point, from the hash itself.
fn corner(x: i32, y: i32, z: i32, seed: u32) -> Vector<f64> {
    let [x, y, z, ..] = gradients([x, y, z], seed);
    point(x, y, z)
}

#[test]
fn lattice_points_are_zero_with_the_slope_of_their_gradient() {
    for seed in SEEDS {
        for (x, y, z) in [(0, 0, 0), (1, 2, 3), (-1, 0, 5), (-7, -8, -9), (1000, -2000, 3000), (i32::MAX, 0, i32::MIN)]
        {
            let p = point(f64::from(x), f64::from(y), f64::from(z));
            assert_eq!(gradient(p, seed), 0.0);
            let want = corner(x, y, z, seed) * SCALE;
            assert_eq!(gradient_slope(p, seed), want, "{p:?} {seed}");
            assert!([want.x, want.y, want.z].iter().filter(|c| **c == 0.0).count() == 1);
        }
    }
}

#[test]
fn the_slope_is_the_derivative() {
    // Central differences: h²/6 of the third derivative, which is below 400 (60·max of the fade's, times heights ≤ 2, by three axes),
    // and ε/h of rounding.
    let h = 1e-5;
    let room = h * h / 6.0 * 400.0 + 4.0 * f64::EPSILON / h;
    for p in points(3000, 40.0) {
        let slope = gradient_slope(p, 3);
        let axes = [point(h, 0.0, 0.0), point(0.0, h, 0.0), point(0.0, 0.0, h)];
        let difference = axes.map(|step| (gradient(p + step, 3) - gradient(p - step, 3)) / (2.0 * h));
        for (got, want) in [slope.x, slope.y, slope.z].into_iter().zip(difference) {
            assert!((got - want).abs() < room, "{p:?}: {got} {want}");
        }
    }
}

#[test]
fn two_derivatives_are_continuous_across_the_faces_of_cells() {
    // From both sides of each face the value and the slope meet, and so do one-sided differences of the slope.
    let step = 1e-7;
    for (i, p) in points(600, 20.0).enumerate() {
        let axis = i % 3;
        let face = |x: f64, along: usize| if along == axis { x.round() } else { x };
        let on = point(face(p.x, 0), face(p.y, 1), face(p.z, 2));
        let aside = |by: f64| {
            let by = |along: usize| if along == axis { by } else { 0.0 };
            on + point(by(0), by(1), by(2))
        };
        let [below, above] = [aside(-step), aside(step)];
        // The slope ≤ 3.62 along each axis, the second derivative below 60 and the third below 400.
        assert!((gradient(above, 9) - gradient(below, 9)).abs() <= 2.0 * step * 3.62);
        let [low, here, high] = [below, on, above].map(|p| gradient_slope(p, 9));
        let component = |v: Vector<f64>| [v.x, v.y, v.z][axis];
        assert!((component(high) - component(low)).abs() <= 2.0 * step * 60.0);
        let second = [component(here) - component(low), component(high) - component(here)].map(|d| d / step);
        let room = 2.0 * step * 400.0 + 8.0 * f64::EPSILON / step;
        assert!((second[0] - second[1]).abs() <= room, "{on:?}: {second:?}");
    }
}

/// The largest sum that any choice of gradients gives at a point of a cell, before the scale.
fn highest(f: [f64; 3]) -> f64 {
    (0..8)
        .map(|corner| {
            let step = |axis: usize| f64::from(corner >> axis & 1);
            let weight: f64 =
                (0..3).map(|axis| if step(axis) == 1.0 { fade(f[axis]) } else { 1.0 - fade(f[axis]) }).product();
            let mut sides: [f64; 3] = core::array::from_fn(|axis| (f[axis] - step(axis)).abs());
            sides.sort_by(f64::total_cmp);
            weight * (sides[1] + sides[2])
        })
        .sum()
}

#[test]
fn the_bound_of_the_sum_is_what_the_scale_takes() {
    // Branch and bound over the eighth of the cell that its mirrors repeat: nothing is more than 2e-3 above the maximum below. Along
    // an axis the sum changes by at most 1 (the sides) and 15/8·2 (the fade, times the difference of two sums in [0, 2]) a unit: 4.75.
    const LIPSCHITZ: f64 = 4.75;
    let (mut best, mut open) = (0.0f64, Vec::from([([0.25; 3], 0.25)]));
    while let Some((centre, half)) = open.pop() {
        let value = highest(centre);
        best = best.max(value);
        if value + 3.0 * LIPSCHITZ * half < 1.036_353_9 + 2e-3 {
            continue;
        }
        for child in 0..8 {
            let part = |axis: usize| if child >> axis & 1 == 1 { 0.5 * half } else { -0.5 * half };
            open.push((core::array::from_fn(|axis| centre[axis] + part(axis)), 0.5 * half));
        }
    }
    assert!(best <= 1.036_353_9 && best > 1.036, "{best}");
    // At the maximum itself, to the digits that the scale keeps.
    let most = highest([0.355_256_7, 0.481_492_2, 0.5]);
    assert!((most - 1.036_353_811).abs() < 1e-8 && most * SCALE < 1.0 - 1e-6, "{most}");
}

#[test]
fn samples_stay_within_one_and_come_near_it() {
    let (mut low, mut high, mut steep) = (0.0f64, 0.0f64, 0.0f64);
    for p in points(400_000, 97.0) {
        let value = gradient(p, 5);
        (low, high) = (low.min(value), high.max(value));
        let Vector { x, y, z } = gradient_slope(p, 5);
        steep = steep.max(x.abs()).max(y.abs()).max(z.abs());
    }
    assert!(-1.0 <= low && high <= 1.0 && low < -0.8 && high > 0.8, "{low} {high}");
    assert!(steep <= 3.62 && steep > 2.5, "{steep}");
}

#[test]
fn the_slope_is_bounded_by_the_best_gradients() {
    // The sum along x is Σ g·v with v = W·x̂ + ∂W/∂x·(f − c): its largest for the two largest parts of each v. On a grid of 1/64, with
    // the second derivative (below 60) over half a cell of the grid along each axis.
    let mut most = 0.0f64;
    for i in 0..64 * 64 * 64 {
        let f: [f64; 3] = [i % 64, i / 64 % 64, i / 4096].map(|k| (f64::from(k) + 0.5) / 64.0);
        let mut sum = 0.0;
        for corner in 0..8 {
            let step = |axis: usize| f64::from(corner >> axis & 1);
            let weight = |axis: usize| if step(axis) == 1.0 { fade(f[axis]) } else { 1.0 - fade(f[axis]) };
            let across = weight(1) * weight(2);
            let slope = (2.0 * step(0) - 1.0) * fade_slope(f[0]) * across;
            let mut parts: [f64; 3] = core::array::from_fn(|axis| {
                let own = if axis == 0 { weight(0) * across } else { 0.0 };
                (own + slope * (f[axis] - step(axis))).abs()
            });
            parts.sort_by(f64::total_cmp);
            sum += parts[1] + parts[2];
        }
        most = most.max(sum);
    }
    assert!(most * SCALE <= 3.62 && most * SCALE > 3.6, "{most}");
}

#[test]
fn the_twelve_gradients_are_equally_frequent_and_cancel() {
    let mut counts = [[[0u32; 3]; 3]; 3];
    let total = 120_000u32;
    let mut sum = point(0.0, 0.0, 0.0);
    for i in 0..total {
        let g = corner((i % 50) as i32 - 25, (i / 50 % 50) as i32 - 25, (i / 2500) as i32 - 24, 11);
        let place = |c: f64| (c + 1.0) as usize;
        counts[place(g.x)][place(g.y)][place(g.z)] += 1;
        sum = sum + g;
    }
    let counts: Vec<_> = counts.as_flattened().as_flattened().iter().copied().filter(|count| *count > 0).collect();
    assert_eq!(counts.len(), 12);
    let expected = f64::from(total) / 12.0;
    let chi: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
    // 11 degrees of freedom: beyond 31.3 in one of a thousand.
    assert!(chi < 31.3, "{chi} {counts:?}");
    // Each component is ±1 in two thirds of the draws: a standard deviation of √(2·total/3).
    let deviation = (2.0 / 3.0 * f64::from(total)).sqrt();
    assert!([sum.x, sum.y, sum.z].iter().all(|c| c.abs() < 4.0 * deviation), "{sum:?}");
}

#[test]
fn the_mean_over_a_cell_is_that_of_its_gradients() {
    // ∫ w(c, t)·(t − c) dt over [0, 1] is ±1/7 and ∫ w = 1/2 along the other axes: the mean is Σ over corners of g·(±1/7)/4. Noise in a
    // cell is a polynomial of degree 6 along each axis: Gauss's rule with four points is exact.
    let nodes =
        [(0.339_981_043_584_856_26, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_86)];
    let rule = nodes.map(|(x, weight)| [(0.5 - 0.5 * x, 0.5 * weight), (0.5 + 0.5 * x, 0.5 * weight)]);
    let rule = rule.as_flattened();
    for (x, y, z) in [(0, 0, 0), (4, -3, 2), (-1, -1, -1)] {
        let mut mean = 0.0;
        for (i, j, k) in (0..64).map(|i| (i % 4, i / 4 % 4, i / 16)) {
            let [(fx, wx), (fy, wy), (fz, wz)] = [rule[i], rule[j], rule[k]];
            mean += wx * wy * wz * gradient(point(f64::from(x) + fx, f64::from(y) + fy, f64::from(z) + fz), 2);
        }
        let want: f64 = (0..8)
            .map(|c| {
                let g = corner(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2 & 1), 2);
                let side = |axis: i32| if c >> axis & 1 == 1 { -1.0 } else { 1.0 };
                (g.x * side(0) + g.y * side(1) + g.z * side(2)) / 28.0
            })
            .sum();
        // 64 terms ≤ 1 of weights that sum to 1, from points rounded to 2⁻⁵¹ at a slope of 3.6.
        assert!((mean - SCALE * want).abs() < 64.0 * f64::EPSILON, "{mean} {}", SCALE * want);
    }
}

#[test]
fn the_mean_over_space_is_zero() {
    // Variance 0.07 a point; correlated within a cell, so that 1000³ cells sampled at 2e5 points are nearly independent.
    let count = 200_000;
    let (mut sum, mut squares) = (0.0f64, 0.0f64);
    for p in points(count, 1000.0) {
        let value = gradient(p, 23);
        sum += value;
        squares += value * value;
    }
    let deviation = (squares / f64::from(count)).sqrt();
    assert!(sum.abs() / f64::from(count) < 4.0 * deviation / f64::from(count).sqrt(), "{sum} {deviation}");
    assert!(deviation > 0.2 && deviation < 0.35, "{deviation}");
}

#[test]
fn seeds_are_unrelated() {
    let count = 50_000;
    for (a, b) in [(0, 1), (1, 2), (5, 5 << 16)] {
        let (mut product, mut squares) = (0.0f64, [0.0f64; 2]);
        for p in points(count, 500.0) {
            let [x, y] = [a, b].map(|seed| gradient(p, seed));
            product += x * y;
            squares = [squares[0] + x * x, squares[1] + y * y];
        }
        let correlation = product / (squares[0] * squares[1]).sqrt();
        assert!(correlation.abs() < 4.0 / f64::from(count).sqrt(), "{a} {b}: {correlation}");
    }
}

#[test]
fn f32_is_f64_to_the_rounding_of_the_sum() {
    // Coordinates are exact, the fraction loses 2⁻²⁵; the heights (≤ 2), the fade and seven blends lose 2⁻²⁴ of numbers ≤ 2 each,
    // the fade magnified 15/8·2: 40·2⁻²⁴ in all.
    for p in points(20_000, 60.0) {
        let single: Vector<f32> = p.cast();
        let want = gradient(single.cast::<f64>(), 4);
        let got = f64::from(gradient(single, 4));
        assert!((got - want).abs() < 40.0 * 2f64.powi(-24), "{p:?}: {got} {want}");
    }
}

#[test]
fn octaves_add_up() {
    let p = point(0.3, -1.7, 2.2);
    for (seed, frequency) in [(0, 1.0), (9, 3.5)] {
        assert_eq!(fractal(p, seed, 0.75, frequency, 1, 0.5, 2.0), 0.75 * gradient(p * frequency, seed));
        let second = p * (2.0 * frequency) + SHIFT;
        let want = 0.75 * gradient(p * frequency, seed) + 0.375 * gradient(second, seed + 1);
        assert_eq!(fractal(p, seed, 0.75, frequency, 2, 0.5, 2.0), want);
        let ridge = |n: f64| 1.0 - n.abs();
        let want = 0.75 * ridge(gradient(p * frequency, seed)) + 0.375 * ridge(gradient(second, seed + 1));
        assert_eq!(ridged(p, seed, 0.75, frequency, 2, 0.5, 2.0), want);
    }
    assert_eq!(fractal(p, 0, 1.0, 1.0, 0, 0.5, 2.0), 0.0);
    assert_eq!(fractal(p, 0, 1.0, 1.0, u32::MAX, 0.5, 2.0), fractal(p, 0, 1.0, 1.0, 32, 0.5, 2.0));
    // Where the first octave is 0 the others are not.
    assert!(fractal(point(1.0, 2.0, 3.0), 0, 1.0, 1.0, 4, 0.5, 2.0).abs() > 1e-3);
}

#[test]
fn fractal_sums_stay_within_their_bounds_and_have_their_slope() {
    let (gain, octaves) = (0.6, 6);
    let bound = 0.8 * (1.0 - gain * gain * gain * gain * gain * gain) / (1.0 - gain);
    for p in points(20_000, 12.0) {
        assert!(fractal(p, 1, 0.8, 1.5, octaves, gain, 2.1).abs() <= bound);
        assert!((0.0..=bound).contains(&ridged(p, 1, 0.8, 1.5, octaves, gain, 2.1)));
    }
    let h = 1e-6;
    for p in points(300, 12.0) {
        let slope = fractal_slope(p, 1, 0.8, 1.5, 3, gain, 2.1);
        let at = |x: f64| fractal(p + point(x, 0.0, 0.0), 1, 0.8, 1.5, 3, gain, 2.1);
        // The third derivative grows with the cube of the frequency: 400·(1.5³ + 0.6·3.15³ + 0.36·6.6³)·0.8 = 4e4.
        let room = h * h / 6.0 * 4e4 + 8.0 * f64::EPSILON / h;
        assert!((slope.x - (at(h) - at(-h)) / (2.0 * h)).abs() < room, "{p:?}");
    }
}

#[test]
fn what_is_not_finite_is_a_corner() {
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX, 1e20, -0.0, 1e-45] {
        let p = Vector::new(x, 0.25, -x);
        for value in [gradient(p, 0), fractal(p, 0, 1.0, 1.0, 3, 0.5, 2.0), ridged(p, 0, 1.0, 1.0, 3, 0.5, 2.0)] {
            assert!(value.is_finite(), "{x}: {value}");
        }
        assert!(gradient_slope(p, 0).length_squared().is_finite());
        // A subnormal distance from the corner, at a slope of 2.
        assert!(gradient(Vector::new(x, x, x), 0).abs() <= 1e-44, "{x}");
    }
}
