// Elementary functions that WGSL lacks or gives too few digits. Twin of src/real.rs.

// The largest f32. WGSL lets a compiler reassociate, and Mesa does: (a + b) - a becomes b. A minimum with this number
// changes no value and hides where it came from.
const largest: f32 = 0x1.fffffep+127;

// a + b without error, as the rounded sum and its rounding error (Knuth 1969).
fn sum_exact(a: f32, b: f32) -> vec2f {
    let sum = min(a + b, largest);
    let part = min(sum - a, largest);
    return vec2f(sum, (a - (sum - part)) + (b - part));
}

// a·b without error, as the rounded product and its rounding error (Dekker 1971): the factors are split into 12 bits
// each by masking, so that every partial product is exact, fused or not.
fn product_exact(a: f32, b: f32) -> vec2f {
    let product = a * b;
    let a_high = bitcast<f32>(bitcast<u32>(a) & 0xfffff000u);
    let b_high = bitcast<f32>(bitcast<u32>(b) & 0xfffff000u);
    let a_low = a - a_high;
    let b_low = b - b_high;
    return vec2f(product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low);
}

// ln(1+x) for x > -1. On [-1/2, 1] as 2·artanh(x/(2+x)) by its series, whose first dropped term is below 1.4e-8 of the
// sum; outside, 1+x is not in [1/2, 2], where WGSL's log is good to 3 ULP.
fn ln_one_plus(x: f32) -> f32 {
    let near = x >= -0.5 && x <= 1.0;
    let s = select(0.0, x, near) / (2.0 + select(0.0, x, near));
    let z = s * s;
    let series = 2.0 * s * (1.0 + z * (1.0 / 3.0 + z * (1.0 / 5.0 + z * (1.0 / 7.0
        + z * (1.0 / 9.0 + z * (1.0 / 11.0 + z * (1.0 / 13.0)))))));
    return select(log(select(1.0 + x, 1.0, near)), series, near);
}

// The angle in [0, pi/2] of the right triangle with these opposite and adjacent sides, both >= 0; 0 where both are 0.
// atan(r)/r on [0, 1] as a polynomial in r², relative error 2.9e-9.
fn angle(opposite: f32, adjacent: f32) -> f32 {
    let larger = max(opposite, adjacent);
    let r = min(opposite, adjacent) / select(1.0, larger, larger > 0.0);
    let z = r * r;
    let odd = r * (0.999999997161 + z * (-0.33333276292 + z * (0.199980752811 + z * (-0.142600160828
        + z * (0.109323415013 + z * (-0.083497249683 + z * (0.0570895559303 + z * (-0.0303518647858
        + z * (0.0104876492549 + z * -0.00170117006407)))))))));
    return select(odd, 1.57079632679489662 - odd, opposite > adjacent);
}

// exp(x²)·erfc(x) for x >= 0. Chebyshev series in (x-3.75)/(x+3.75) (Shepherd & Laframboise 1981), error 7e-9.
fn erfcx(x: f32) -> f32 {
    const series = array<f32, 13>(
        1.1775789345674017541, -0.0045900545806464773309, -0.084249133366517915584, 0.059209939998191890498,
        -0.026658668435305752277, 0.0090749976707052650939, -0.0024131635404176081909, 0.00049077583652580863229,
        -0.000069169733025012063671, 4.1390279860730101675e-6, 7.7403830661984906686e-7, -2.1886401049234395461e-7,
        1.0764999465910371077e-8);
    let u = select(1.0, (x - 3.75) / (x + 3.75), x < 1e30);
    var b = vec2f(0.0, 0.0);
    for (var i = 12; i > 0; i--) {
        b = vec2f(2.0 * u * b.x - b.y + series[i], b.x);
    }
    return (u * b.x - b.y + series[0]) / (1.0 + 2.0 * x);
}

// exp(-a·b) for a, b >= 0, with the rounding error of the product carried into the result.
fn exp_product(a: f32, b: f32) -> f32 {
    // Beyond 87 the result is subnormal; a bounded argument keeps the split of product_exact finite.
    let inside = a * b <= 87.0;
    let p = product_exact(select(0.0, a, inside), select(0.0, b, inside));
    let value = exp(-p.x);
    return select(0.0, value - value * p.y, inside);
}

// cos and sin of a number of turns in [0, 1], clamped there. A quarter turn is split off exactly; the rest r, at most half a
// quarter, goes through the Taylor polynomials of sin(r·pi/2)/r and cos(r·pi/2) in r², errors 2.5e-9 and 1.2e-10.
fn unit_circle(turn: f32) -> vec2f {
    let quarters = 4.0 * clamp(turn, 0.0, 1.0);
    let nearest = u32(quarters + 0.5);
    let r = quarters - f32(nearest);
    let z = r * r;
    let s = r * (1.57079632679489662 + z * (-0.645964097506246254 + z * (0.0796926262461670451
        + z * (-0.00468175413531868810 + z * 0.000160441184787359822))));
    let c = 1.0 + z * (-1.23370055013616983 + z * (0.253669507901048014 + z * (-0.0208634807633529609
        + z * (0.000919260274839426580 + z * -0.0000252020423730606055))));
    let turned = select(vec2f(c, s), vec2f(-s, c), (nearest & 1u) == 1u);
    return select(turned, -turned, (nearest & 2u) == 2u);
}
