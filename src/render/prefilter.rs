//! Environments blurred beforehand, for shading without rays: what a lobe of width α sees around each direction.
//!
//! The documents' local model looks the environment up once for each lobe ("an adequately blurred environment map", Elek 2010, §3). A level
//! holds, for each direction r, the mean of the radiance over the light that Beckmann's facets of one α reflect to V = N = r:
//! ∫ L(l)·D(h)·cosθ_h dω_h, l being V mirrored at h, of what stays above the horizon, over the same of 1. So a constant environment stays constant.
//! The first level is the environment itself, the last the mean under the cosine: the irradiance over π of a diffuse base, which α = 1 means.
//! Between levels lookups are linear in α, within them bilinear. Twin: `wgsl/environment.wgsl`; the same texels.
//!
//! A level is summed, not sampled. Texels of an octahedral map differ by 3√3 in solid angle, so rays that suit one fall between others; instead every
//! part of the sphere counts once, in squares of a pyramid that are at most a quarter of the lobe wide where it counts, each from where its light has its
//! centre. What remains is the square of that quarter, under 1 % of a lobe's peak, and what bilinear texels leave out.

use super::environment::Environment;
use super::octahedral::Map;
use crate::frame::Vector;
use crate::real::Real;
use rayon::prelude::*;

/// The widths of the levels: of the environment itself, of Beckmann's lobes, and 1 for the cosine.
pub const ALPHAS: [f64; 10] = [0.0, 0.02, 0.05, 0.1, 0.18, 0.3, 0.45, 0.65, 0.85, 1.0];

/// Texels to a side: about three to the width of a lobe. Where texels are largest that leaves 9 % of the peak of a point's image under the narrowest lobe,
/// 6 % under the second and 2 % from there on; the cosine has more texels, as it bends at the horizon.
const SIDES: [usize; 10] = [0, 256, 128, 128, 64, 64, 32, 32, 32, 64];

/// Squares to a side of the finest level of the pyramid: under a quarter of the narrowest lobe.
const FINEST: usize = 512;

/// Squares to a side of the coarsest.
const COARSEST: usize = 8;

/// Texels to a side of a block, which are summed over one list of squares.
const BLOCK: usize = 4;

/// An environment at every width.
#[derive(Clone, Debug, PartialEq)]
pub struct Prefiltered {
    levels: Vec<Map>,
}

impl Prefiltered {
    /// All levels of an environment, on the threads of the current pool: half a second.
    pub fn new(environment: &Environment) -> Self {
        let pyramid = if environment.shines() { pyramid(environment.map()) } else { Vec::new() };
        let level = |(alpha, side): (&f64, &usize)| {
            if *side == 0 || !environment.shines() {
                environment.map().clone()
            } else {
                blurred(&pyramid, *alpha, *side)
            }
        };
        Prefiltered { levels: ALPHAS.iter().zip(&SIDES).map(level).collect() }
    }

    /// The levels, in the order of [`ALPHAS`].
    pub fn levels(&self) -> &[Map] {
        &self.levels
    }

    /// The mean radiance that a lobe of width `alpha` around a direction sees.
    #[inline]
    pub fn look<R: Real>(&self, w: Vector<R>, alpha: R) -> [R; 3] {
        let alpha = alpha.saturate();
        let width = alpha.to_f64();
        let above = ALPHAS.iter().position(|level| width <= *level).unwrap_or(ALPHAS.len() - 1).max(1);
        let at = |level: usize| self.levels.get(level).map_or([R::ZERO; 3], |map| map.look(w).0);
        let (low, high) = (ALPHAS[above - 1], ALPHAS[above]);
        let share = (alpha - R::from_f64(low)) / R::from_f64(high - low);
        let (a, b) = (at(above - 1), at(above));
        core::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
    }
}

/// A square of the map as a source of light.
#[derive(Clone, Copy, Debug, Default)]
struct Square {
    /// The centre of its light; of its directions where it is dark.
    towards: [f32; 3],
    /// The centre of its directions.
    middle: [f32; 3],
    /// Whether the two differ by more than a hundredth of its width.
    uneven: bool,
    /// Radiance times solid angle.
    power: [f32; 3],
    solid: f32,
}

/// Adds up the squares or texels that make a square.
#[derive(Default)]
struct Sum {
    lit: Vector<f64>,
    even: Vector<f64>,
    power: [f64; 3],
    solid: f64,
}

impl Sum {
    fn add(&mut self, towards: Vector<f64>, middle: Vector<f64>, power: [f64; 3], solid: f64) {
        self.lit = self.lit + towards * power.iter().sum::<f64>();
        self.even = self.even + middle * solid;
        self.power = [0, 1, 2].map(|c: usize| self.power[c] + power[c]);
        self.solid += solid;
    }

    fn square(&self) -> Square {
        let middle = self.even.normalized();
        let towards = if self.power.iter().sum::<f64>() > 0.0 { self.lit.normalized() } else { middle };
        let single = |v: Vector<f64>| <[f64; 3]>::from(v).map(|x| x as f32);
        Square {
            towards: single(towards),
            middle: single(middle),
            uneven: (towards - middle).length_squared() > 1e-4 * self.solid,
            power: self.power.map(|x| x as f32),
            solid: self.solid as f32,
        }
    }
}

/// The squares of a side, row by row, each the sum of 2×2 of the side before; the finest first.
fn pyramid(map: &Map) -> Vec<(usize, Vec<Square>)> {
    // A map may be finer than the finest level or coarser: then it is what it looks like between its texels.
    let fine = map.side().max(FINEST);
    let each = fine / FINEST;
    let square = |i: usize| {
        let mut sum = Sum::default();
        for j in 0..each * each {
            let (column, row) = (i % FINEST * each + j % each, i / FINEST * each + j / each);
            let (w, solid) = Map::centre(fine, column, row);
            let radiance = if map.side() == fine {
                let [r, g, b, _] = map.texel(column, row).map(f64::from);
                [r, g, b]
            } else {
                map.look(w).0
            };
            sum.add(w, w, radiance.map(|x| x * solid), solid);
        }
        sum.square()
    };
    let mut all = vec![(FINEST, (0..FINEST * FINEST).into_par_iter().map(square).collect::<Vec<_>>())];
    while let Some((side, squares)) = all.last().filter(|(side, _)| *side > COARSEST) {
        let half = side / 2;
        let square = |i: usize| {
            let mut sum = Sum::default();
            for child in children(half, i).into_iter().filter_map(|child| squares.get(child)) {
                let [towards, middle] = [child.towards, child.middle].map(|w| Vector::from(w.map(f64::from)));
                sum.add(towards, middle, child.power.map(f64::from), f64::from(child.solid));
            }
            sum.square()
        };
        let coarse = (half, (0..half * half).map(square).collect());
        all.push(coarse);
    }
    all
}

/// Where the four squares lie that make the square of this index on a level of this side.
fn children(side: usize, index: usize) -> [usize; 4] {
    let first = 4 * (index / side) * side + 2 * (index % side);
    [first, first + 1, first + 2 * side, first + 2 * side + 1]
}

/// Texels of a block.
const LANES: usize = BLOCK * BLOCK;

/// The exponent beyond which a lobe's weight does not fall: e⁻¹².
const DEEPEST: f64 = 12.0;

/// A lobe around a direction.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    alpha: f64,
}

impl Lobe {
    /// What light counts for whose direction is this far, squared, from the lobe's; 1 in the middle. Of many at once, to 1e-6.
    ///
    /// Of a facet's normal at θ_h, with V = N at the lobe's middle, the light is at 2θ_h and |l − r|² = d = 4·sin²θ_h: tan² is d/(4−d), and D/4 the
    /// density over light: exp(−d/(4−d)/α²)·16/(4−d)². The cosine of the light is 1 − d/2, which is the weight of α = 1.
    ///
    /// e^−y is the sixteenth power of Padé's approximant of e^−z at z = y/16 ≤ 1, which is off by z⁵/720.
    #[inline(always)]
    fn weights(self, squared: [f32; LANES]) -> [f32; LANES] {
        if self.alpha >= 1.0 {
            return squared.map(|squared| (1.0 - 0.5 * squared).max(0.0));
        }
        let scale = (1.0 / (16.0 * self.alpha * self.alpha)) as f32;
        squared.map(|squared| {
            // At least 2 above the horizon.
            let inverse = 1.0 / (4.0 - squared).max(2.0);
            let z = (squared * inverse * scale).min(1.0);
            let (even, odd) = (1.0 + z * z * (1.0 / 12.0), 0.5 * z);
            let root = (even - odd) / (even + odd);
            let (second, above) = (root * root, if squared < 2.0 { 16.0 } else { 0.0 });
            let eighth = second * second * second * second;
            eighth * eighth * inverse * inverse * above
        })
    }

    /// The distance of directions beyond which nothing counts: the horizon, or what the deepest exponent leaves.
    fn reach(self) -> f64 {
        let sine = (self.alpha * DEEPEST.sqrt()).atan().sin();
        if self.alpha >= 1.0 { core::f64::consts::SQRT_2 } else { (2.0 * sine).min(core::f64::consts::SQRT_2) }
    }

    /// How wide a square may be that is at least this far: a quarter of the angle 2α at which 1/e is left, more where less counts, and little enough to
    /// follow the horizon.
    fn grain(self, apart: f64) -> f64 {
        let squared = apart * apart;
        let exponent =
            if self.alpha >= 1.0 { 0.0 } else { squared / ((4.0 - squared).max(2.0) * self.alpha * self.alpha) };
        (0.5 * self.alpha * (exponent / 3.0).min(4.0).exp()).min(WIDEST)
    }
}

/// The widest square that is counted.
const WIDEST: f64 = 0.07;

/// The squares that light around a block of texels comes from, each fine enough. Distances are those of points on the unit sphere.
fn around(pyramid: &[(usize, Vec<Square>)], lobe: Lobe, middle: Vector<f64>, radius: f64) -> Vec<Square> {
    let mut found = Vec::new();
    let last = pyramid.len().saturating_sub(1);
    let mut waiting: Vec<(usize, usize)> =
        (0..pyramid.last().map_or(0, |level| level.1.len())).map(|i| (last, i)).collect();
    let reach = lobe.reach() + radius;
    while let Some((level, index)) = waiting.pop() {
        let Some((side, square)) = pyramid.get(level).and_then(|level| Some((level.0, level.1.get(index)?))) else {
            continue;
        };
        let width = f64::from(square.solid).sqrt();
        let apart = (middle - Vector::from(square.towards.map(f64::from))).length_squared().sqrt();
        let fine = || width <= WIDEST && width <= lobe.grain((apart - radius - width).max(0.0));
        if level == 0 || fine() {
            if apart <= reach {
                found.push(*square);
            }
        // A square is a rhombus of up to 60°, whose longer diagonal is 1.86 of its width; its light may lie at one end.
        } else if apart <= reach + 2.0 * width {
            waiting.extend(children(side, index).map(|child| (level - 1, child)));
        }
    }
    found
}

fn blurred(pyramid: &[(usize, Vec<Square>)], alpha: f64, side: usize) -> Map {
    let lobe = Lobe { alpha };
    let blocks = side / BLOCK;
    let block = |block: usize| {
        let texel =
            |i: usize| Map::centre(side, block % blocks * BLOCK + i % BLOCK, block / blocks * BLOCK + i / BLOCK).0;
        let texels: [Vector<f64>; LANES] = core::array::from_fn(texel);
        let middle = texels.iter().fold(Vector::default(), |sum, w| sum + *w).normalized();
        let radius = texels.iter().map(|w| (middle - *w).length_squared()).fold(0.0, f64::max).sqrt();
        let [x, y, z] = [|w: &Vector<f64>| w.x, |w: &Vector<f64>| w.y, |w: &Vector<f64>| w.z]
            .map(|axis| texels.each_ref().map(|w| axis(w) as f32));
        let (mut sums, mut total) = ([[0.0f32; LANES]; 3], [0.0f32; LANES]);
        for square in around(pyramid, lobe, middle, radius) {
            let weights = |[to_x, to_y, to_z]: [f32; 3]| {
                lobe.weights(core::array::from_fn(|i| {
                    let (dx, dy, dz) = (to_x - x[i], to_y - y[i], to_z - z[i]);
                    dx * dx + dy * dy + dz * dz
                }))
            };
            // The weight of its light, and of its directions: what a constant light would have.
            let weights_of_light = weights(square.towards);
            let weights_of_all = if square.uneven { weights(square.middle) } else { weights_of_light };
            for i in 0..LANES {
                total[i] += weights_of_all[i] * square.solid;
                for c in 0..3 {
                    sums[c][i] += weights_of_light[i] * square.power[c];
                }
            }
        }
        core::array::from_fn::<[f32; 3], LANES, _>(|i| {
            let inverse = if total[i] > 0.0 { 1.0 / f64::from(total[i]) } else { 0.0 };
            [0, 1, 2].map(|c: usize| (f64::from(sums[c][i]) * inverse) as f32)
        })
    };
    let texels: Vec<[[f32; 3]; LANES]> = (0..blocks * blocks).into_par_iter().map(block).collect();
    Map::new(side, |column, row| {
        let block = texels.get(row / BLOCK * blocks + column / BLOCK);
        block.map_or([0.0; 3], |block| block[row % BLOCK * BLOCK + column % BLOCK])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`Lobe::weights`] by its formula.
    fn weight(alpha: f64, squared: f64) -> f64 {
        let cosine = 1.0 - 0.5 * squared;
        if alpha >= 1.0 || cosine <= 0.0 {
            // Below the horizon there is no light.
            return cosine.max(0.0);
        }
        let inverse = 1.0 / (4.0 - squared);
        // 16 makes the middle's weight 1.
        16.0 * (-squared * inverse / (alpha * alpha)).exp() * inverse * inverse
    }

    #[test]
    fn a_constant_environment_stays_constant() {
        let all = Prefiltered::new(&Environment::furnace());
        for alpha in [0.0, 0.01, 0.1, 0.5, 0.9, 1.0] {
            for x in all.look(Vector::from_angles(0.7, 2.0), alpha) {
                assert!((x - 1.0f64).abs() < 1e-6, "{alpha}: {x}");
            }
        }
    }

    #[test]
    fn the_last_level_is_the_irradiance() {
        // L = max(z, 0): E(n)/π is known at the poles: ∫z·z dω/π = 2/3 up, 0 down; sideways ∫ max(z,0)·max(x,0) dω/π = 2/(3π).
        let all = Prefiltered::new(&Environment::from_radiance(256, |w| [w.z.max(0.0); 3]));
        let at = |x, y, z| all.look(Vector::<f64>::new(x, y, z), 1.0)[0];
        // Squares of .05 rad: a twelfth of their square, and the bilinear texels of .1 rad, an eighth of theirs.
        for (got, want) in [(at(0.0, 0.0, 1.0), 2.0 / 3.0), (at(1.0, 0.0, 0.0), 2.0 / (3.0 * core::f64::consts::PI))] {
            assert!((got - want).abs() < 2e-3, "{got} {want}");
        }
        assert!(at(0.0, 0.0, -1.0) < 2e-3);
    }

    /// The sum over all texels of a map as it looks between them, four points to a texel: what a level approximates.
    fn exactly(environment: &Environment, alpha: f64, around: Vector<f64>) -> f64 {
        let side = 2 * environment.map().side();
        let (mut sum, mut total) = (0.0, 0.0);
        for i in 0..side * side {
            let (w, solid) = Map::centre(side, i % side, i / side);
            let weight = weight(alpha, (w - around).length_squared()) * solid;
            sum += weight * environment.map().look(w).0[1];
            total += weight;
        }
        sum / total
    }

    #[test]
    fn weights_are_those_of_the_lobe() {
        for alpha in ALPHAS.into_iter().skip(1) {
            for i in 0..200 {
                let squared = (f64::from(i) / 100.0).powi(4) * 0.25;
                let got = f64::from(Lobe { alpha }.weights([squared as f32; LANES])[3]);
                // The last digits of f32, and where z = 1 the approximant's e⁻¹⁶.
                assert!((got - weight(alpha, squared)).abs() < 2e-6, "{alpha}, {squared}: {got}");
            }
        }
    }

    #[test]
    fn a_small_lamp_is_as_bright_wherever_it_stands() {
        // At an axis, where texels are smallest, at the middle of a face, where they are 5.2 times as large, and at 31° as a sun: one texel.
        let side = 256;
        let face = Vector::new(1.0, 1.0, 1.0).normalized();
        for lamp in [Vector::new(0.0, 0.0, 1.0), face, Vector::new(0.6, 0.62, 0.505).normalized()] {
            let ([x, y], _) = super::super::octahedral::square(lamp);
            let column = |x: f64| (((x + 1.0) * 0.5 * side as f64) as usize).min(side - 1);
            let (at, solid) = Map::centre(side, column(x), column(y));
            let environment = Environment::from_radiance(side, |w| {
                [if (w - at).length_squared() < 1e-12 { 1.0 / solid } else { 0.0 }; 3]
            });
            let all = Prefiltered::new(&environment);
            // Lambert: E/π = cos θ/π of a lamp of power 1, whose tent of bilinear texels is no point but has its centre there.
            for apart in [0.0, 0.5, 1.0, 1.4] {
                let frame = crate::frame::Frame::from_normal(at);
                let normal = frame.to_world(Vector::from_angles(apart, 0.7));
                let (got, want) = (all.look(normal, 1.0)[0], apart.cos() * core::f64::consts::FRAC_1_PI);
                // Texels of .1 rad between which the cosine is linear, the horizon's bend at 1.4 rad among them.
                assert!((got - want).abs() < 4e-3, "{lamp:?}, {apart}: {got} {want}");
            }
            for (alpha, tolerance) in [(0.02, 0.09), (0.05, 0.06), (0.1, 0.02), (0.3, 0.02), (0.65, 0.02)] {
                let peak = exactly(&environment, alpha, at);
                for apart in [0.0, alpha, 2.0 * alpha] {
                    let around = crate::frame::Frame::from_normal(at).to_world(Vector::from_angles(apart, 2.0));
                    let (got, want) = (all.look(around, alpha)[0], exactly(&environment, alpha, around));
                    assert!(
                        (got - want).abs() < tolerance * peak,
                        "{lamp:?}, {alpha}, {apart}: {got} {want} of {peak}"
                    );
                }
            }
        }
    }

    #[test]
    fn lambert_under_the_sky_is_its_irradiance() {
        let sky = super::super::sources::by_name("sky").expect("built in");
        let all = Prefiltered::new(&sky);
        let most = exactly(&sky, 1.0, Vector::new(-0.5, -0.6, 0.624_499_8));
        for i in 0..24 {
            let normal = Vector::<f64>::from_angles(0.13 * f64::from(i), 0.9 * f64::from(i));
            let (got, want) = (all.look(normal, 1.0)[1], exactly(&sky, 1.0, normal));
            // An eighth of the texels' square, and where the sun sets a quarter of a texel's share of it.
            assert!((got - want).abs() < 6e-3 * most, "{normal:?}: {got} {want} of {most}");
        }
    }

    #[test]
    fn a_lobe_has_the_width_of_its_alpha() {
        // A small lamp at +z: the blurred radiance falls as Beckmann's D of half the angle, D(θ/2)/D(0).
        let lamp = |w: Vector<f64>| if w.z > 0.9995 { [1.0; 3] } else { [0.0; 3] };
        let all = Prefiltered::new(&Environment::from_radiance(512, lamp));
        let alpha = 0.3;
        let peak = all.look(Vector::<f64>::new(0.0, 0.0, 1.0), alpha)[0];
        let side = all.look(Vector::<f64>::from_angles(0.5, 1.0), alpha)[0] / peak;
        // D(θ_h) = exp(−tan²/α²)/cos⁴.
        let tan = 0.25f64.tan();
        let want = (-(tan / alpha).powi(2)).exp() / 0.25f64.cos().powi(4);
        // The lamp's own radius of .03 rad, and bilinear texels.
        assert!((side - want).abs() < 0.01, "{side} {want}");
    }
}
