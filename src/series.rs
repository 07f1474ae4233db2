//! The series that the elementary functions of [`real`](crate::real) are summed from.
//!
//! `wgsl/real.wgsl` holds the same sums; for the angle of a triangle a shorter one.

use crate::real::Real;

/// Chebyshev coefficients of (1+2x)·exp(x²)·erfc(x) in u = (x−3.75)/(x+3.75), computed with 50 digits.
///
/// The variable is that of Shepherd & Laframboise 1981, "Chebyshev approximation of (1+2x)exp(x²)erfc x in 0 ≤ x < ∞".
/// 25 coefficients leave an error below 4e-18, the first 13 one below 7e-9.
pub(crate) const ERFCX: [f64; 25] = [
    1.177_578_934_567_401_754_1,
    -0.004_590_054_580_646_477_330_9,
    -0.084_249_133_366_517_915_584,
    0.059_209_939_998_191_890_498,
    -0.026_658_668_435_305_752_277,
    0.009_074_997_670_705_265_093_9,
    -0.002_413_163_540_417_608_191_1,
    0.000_490_775_836_525_808_632_29,
    -0.000_069_169_733_025_012_063_671,
    4.139_027_986_073_010_167_5e-6,
    7.740_383_066_198_490_668_6e-7,
    -2.188_640_104_923_439_546_1e-7,
    1.076_499_946_591_036_107_7e-8,
    4.521_959_811_218_286_897_9e-9,
    -7.754_400_208_831_351_106_5e-10,
    -6.318_088_340_886_684_494_5e-11,
    2.868_795_010_930_669_898_1e-11,
    1.945_586_854_577_734_723e-13,
    -9.654_696_748_433_438_905_9e-13,
    3.252_548_148_148_739_841_5e-14,
    3.347_811_948_286_805_387_8e-14,
    -1.864_562_880_419_313_101_4e-15,
    -1.250_795_053_068_864_708_4e-15,
    7.418_235_256_624_043_466_7e-17,
    5.068_148_904_796_111_313_2e-17,
];

/// The first 13 terms of the series as a polynomial in u, rounded to single precision.
const ERFCX_SINGLE: [f32; 13] = {
    // Tₙ₊₁ = 2u·Tₙ − Tₙ₋₁.
    let (mut before, mut this) = ([0.0f64; 13], [0.0f64; 13]);
    before[0] = 1.0;
    this[1] = 1.0;
    let mut sum = [0.0f64; 13];
    sum[0] = ERFCX[0];
    let mut n = 1;
    while n < 13 {
        let mut next = [0.0f64; 13];
        let mut i = 0;
        while i < 13 {
            sum[i] += ERFCX[n] * this[i];
            next[i] = (if i > 0 { 2.0 * this[i - 1] } else { 0.0 }) - before[i];
            i += 1;
        }
        (before, this) = (this, next);
        n += 1;
    }
    let mut single = [0.0; 13];
    let mut i = 0;
    while i < 13 {
        single[i] = sum[i] as f32;
        i += 1;
    }
    single
};

/// The series in f32 throughout. Error: ≤ 6 ULP.
#[inline(always)]
pub(crate) fn erfcx_single<R: Real>(x: R) -> R {
    let k = R::from_f64(3.75);
    // At x = ∞ the quotient would be NaN; u → 1 there.
    let u = R::select(x.lt(R::from_f64(1e30)), (x - k) / (x + k), R::ONE);
    horner(u, &ERFCX_SINGLE) / (R::ONE + R::TWO * x)
}

/// atan(r)/r on [0, 1] as a polynomial in r² of least relative error, 6.3e-15 (Remez's exchange in 50 digits): enough for
/// the sums of both signs that angles go into in single precision.
const ANGLE: [f64; 17] = [
    0.999_999_999_999_993_73,
    -0.333_333_333_329_601_13,
    0.199_999_999_630_021_77,
    -0.142_857_128_286_392_09,
    0.111_110_807_622_036_41,
    -0.090_905_231_268_003_577,
    0.076_890_434_765_787_148,
    -0.066_472_557_453_416_537,
    0.057_979_880_139_343_544,
    -0.049_874_471_403_633_256,
    0.040_690_610_816_867_708,
    -0.029_820_877_704_752_875,
    0.018_424_006_231_319_216,
    -0.008_946_934_935_415_015_8,
    0.003_136_742_620_472_529_6,
    -0.000_696_832_218_156_067_96,
    0.000_073_048_170_981_731_951,
];

/// The angle of a right triangle by the polynomial, of either side of the diagonal.
#[inline(always)]
pub(crate) fn angle_polynomial(opposite: f64, adjacent: f64) -> f64 {
    let (larger, smaller) = (opposite.max(adjacent), opposite.min(adjacent));
    let r = smaller / if larger > 0.0 { larger } else { 1.0 };
    let square = r * r;
    let odd = r * ANGLE.iter().rev().fold(0.0, |sum, c| sum * square + c);
    if opposite > adjacent { core::f64::consts::FRAC_PI_2 - odd } else { odd }
}

/// [`ANGLE`] for f32 throughout, relative error 2.9e-9: that of `wgsl/real.wgsl`.
pub(crate) const ANGLE_SINGLE: [f32; 10] = [
    0.999_999_997_161,
    -0.333_332_762_92,
    0.199_980_752_811,
    -0.142_600_160_828,
    0.109_323_415_013,
    -0.083_497_249_683,
    0.057_089_555_930_3,
    -0.030_351_864_785_8,
    0.010_487_649_254_9,
    -0.001_701_170_064_07,
];

/// The angle of a right triangle by the shorter polynomial. Error over [`Single`](crate::single::Single): ≤ 3 ULP.
#[inline(always)]
pub(crate) fn angle_short<R: Real>(opposite: R, adjacent: R) -> R {
    let (larger, smaller) = (opposite.max(adjacent), opposite.min(adjacent));
    let r = smaller / R::select(larger.gt(R::ZERO), larger, R::ONE);
    let odd = r * horner(r * r, &ANGLE_SINGLE);
    R::select(opposite.gt(adjacent), R::HALF * R::PI - odd, odd)
}

/// Σ coefficients[i]·xⁱ.
#[inline(always)]
pub(crate) fn horner<R: Real>(x: R, coefficients: &[f32]) -> R {
    // A loop, not a fold: what runs over vectors must be inlined whole, and closures are inlined as the compiler sees fit.
    let number = coefficients.len();
    let mut sum = if number > 0 { R::from_f64(f64::from(coefficients[number - 1])) } else { R::ZERO };
    for i in (0..number.saturating_sub(1)).rev() {
        sum = sum.mul_add(x, R::from_f64(f64::from(coefficients[i])));
    }
    sum
}

/// (eʳ − 1 − r)/r² on |r| ≤ ln2/2, relative error of eʳ 2e-8 (Moshier's Cephes 2.8, expf).
pub(crate) const EXP_SINGLE: [f32; 6] =
    [5.000_000_1e-1, 1.666_666_5e-1, 4.166_579_6e-2, 8.333_452e-3, 1.398_199_9e-3, 1.987_569_1e-4];

/// (ln(1+x) − x + x²/2)/x³ on 1+x in [√½, √2] (Moshier's Cephes 2.8, logf).
pub(crate) const LN_SINGLE: [f32; 9] = [
    3.333_333_1e-1,
    -2.499_999_4e-1,
    2.000_071_5e-1,
    -1.666_805_8e-1,
    1.424_932_3e-1,
    -1.242_014_1e-1,
    1.167_699_9e-1,
    -1.151_461e-1,
    7.037_683_6e-2,
];

/// Clenshaw's sum of the series above, divided by (1+2x).
#[inline(always)]
pub(crate) fn erfcx_chebyshev<R: Real>(x: R, coefficients: &[R]) -> R {
    let k = R::from_f64(3.75);
    // At x = ∞ the quotient would be NaN; u → 1 there.
    let u = R::select(x.lt(R::from_f64(1e30)), (x - k) / (x + k), R::ONE);
    let (mut b1, mut b2) = (R::ZERO, R::ZERO);
    for i in (1..coefficients.len()).rev() {
        (b1, b2) = (R::TWO * u * b1 - b2 + coefficients[i], b1);
    }
    (u * b1 - b2 + coefficients[0]) / (R::ONE + R::TWO * x)
}

/// The Taylor coefficients (−1)ʲ(π/2)²ʲ⁺¹/(2j+1)! of sin(πr/2)/r in r². On |r| ≤ 1/2 nine leave an error below 1e-19 of
/// the sine, the first five one of 2.5e-9.
pub(crate) const SINE: [f64; 9] = [
    core::f64::consts::FRAC_PI_2,
    -0.645_964_097_506_246_253_66,
    0.079_692_626_246_167_045_121,
    -0.004_681_754_135_318_688_100_7,
    0.000_160_441_184_787_359_821_87,
    -3.598_843_235_212_085_340_5e-6,
    5.692_172_921_967_926_811_8e-8,
    -6.688_035_109_811_467_232_5e-10,
    6.066_935_731_106_195_667_1e-12,
];

/// The Taylor coefficients (−1)ʲ(π/2)²ʲ/(2j)! of cos(πr/2) in r². Nine leave an error below 3e-18, the first six 1.2e-10.
pub(crate) const COSINE: [f64; 9] = [
    1.0,
    -1.233_700_550_136_169_827_4,
    0.253_669_507_901_048_013_64,
    -0.020_863_480_763_352_960_873,
    0.000_919_260_274_839_426_580_24,
    -0.000_025_202_042_373_060_605_481,
    4.710_874_778_818_171_503_7e-7,
    -6.386_603_083_791_852_241_1e-9,
    6.565_963_114_979_472_362_2e-11,
];

/// As many of them as f32 takes.
pub(crate) const SINE_SINGLE: [f32; 5] = rounded(&SINE);
pub(crate) const COSINE_SINGLE: [f32; 6] = rounded(&COSINE);

const fn rounded<const N: usize>(series: &[f64; 9]) -> [f32; N] {
    let mut first = [0.0; N];
    let mut i = 0;
    while i < N {
        first[i] = series[i] as f32;
        i += 1;
    }
    first
}

/// The nearest quarter to a turn in [0, 1], and what is left of the turn in quarters, in [−1/2, 1/2]: both exact.
#[inline(always)]
pub(crate) fn quarter_turns(turn: f64) -> (u32, f64) {
    let quarters = 4.0 * turn.saturate();
    let nearest = (quarters + 0.5) as u32;
    (nearest, quarters - f64::from(nearest))
}

/// cos and sin of a quarter turn and a rest, from the series of the rest.
#[inline(always)]
pub(crate) fn circle<R: Real>(quarter: u32, rest: R, sine: &[R], cosine: &[R]) -> (R, R) {
    let square = rest * rest;
    let horner = |series: &[R]| series.iter().rev().fold(R::ZERO, |sum, c| sum * square + *c);
    let (c, s) = (horner(cosine), rest * horner(sine));
    match quarter & 3 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}
