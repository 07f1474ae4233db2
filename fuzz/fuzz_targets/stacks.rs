//! Stacks of any layers: refused with an error, or evaluated and sampled without a panic, NaN, infinity or negative value;
//! reciprocal; and a sample's density is the density of its direction.

#![no_main]

use arbitrary::Arbitrary;
use brdf::layered::{Interface, Layer, Model, Stack, Widths};
use brdf::{Real, Vector};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
enum Number {
    /// As it comes: most are refused.
    Wild(f64),
    /// A share of the range.
    Share(u16),
    /// 10 to minus a share of six.
    Small(u16),
}

impl Number {
    fn within(&self, low: f64, high: f64) -> f64 {
        match self {
            Number::Wild(x) => *x,
            Number::Share(bits) => low + (high - low) * f64::from(*bits) / 65535.0,
            Number::Small(bits) => low + (high - low) * 10f64.powf(-6.0 * f64::from(*bits) / 65535.0),
        }
    }
}

#[derive(Arbitrary, Debug)]
struct Written {
    diffuse: bool,
    n: [Number; 2],
    k: [Number; 2],
    alpha: Number,
    sigma: [Number; 2],
    thickness: Number,
}

impl Written {
    fn layer(&self) -> Layer<f64, 2> {
        let both = |of: &[Number; 2], low, high| [of[0].within(low, high), of[1].within(low, high)];
        let interface = if self.diffuse {
            Interface::diffuse(both(&self.n, 0.0, 1.0), self.alpha.within(0.0, std::f64::consts::FRAC_PI_2))
        } else {
            Interface::conductor(both(&self.n, 0.02, 8.0), both(&self.k, 0.0, 12.0), self.alpha.within(1e-4, 1.0))
        };
        Layer::new(interface).over(both(&self.sigma, 0.0, 10.0), self.thickness.within(0.0, 10.0))
    }
}

#[derive(Arbitrary, Debug)]
struct Input {
    layers: Vec<Written>,
    model: u8,
    widths: u8,
    wi: (i16, u16),
    wo: (i16, u16),
    u: [u16; 3],
    wild: [f64; 6],
}

fn direction((height, phi): (i16, u16)) -> Vector<f64> {
    let (cos, phi) = (f64::from(height) / 32768.0, f64::from(phi) / 65536.0 * std::f64::consts::TAU);
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
}

fn judge<R: Real>(stack: &Stack<R, 2>, input: &Input) {
    let (wi, wo) = (direction(input.wi).cast::<R>(), direction(input.wo).cast::<R>());
    let (f, back) = (stack.evaluate(wi, wo), stack.evaluate(wo, wi));
    for (f, back) in f.into_iter().zip(back) {
        let (f, back) = (f.to_f64(), back.to_f64());
        assert!(f >= 0.0 && f.is_finite(), "{stack:?} {wi:?} {wo:?}: {f}");
        // Every formula treats the two directions alike, so that even rounding does.
        assert!(f == back, "{stack:?} {wi:?} {wo:?}: {f} {back}");
    }
    let pdf = stack.pdf(wi, wo).to_f64();
    assert!(pdf >= 0.0 && pdf.is_finite(), "{stack:?} {wi:?} {wo:?}: pdf {pdf}");
    let u = input.u.map(|bits| R::from_f64(f64::from(bits) / 65536.0));
    if let Some(sample) = stack.sample(wo, u) {
        let (drawn, again) = (sample.pdf.to_f64(), stack.pdf(sample.wi, wo).to_f64());
        assert!(drawn > 0.0 && drawn.is_finite() && (drawn - again).abs() <= 1e-12 * drawn, "{stack:?}: {drawn} {again}");
    }
    let [a, b, c, d, e, g] = input.wild.map(R::from_f64);
    let (u, v) = (Vector::new(a, b, c), Vector::new(d, e, g));
    let _ = (stack.evaluate(u, v), stack.pdf(u, v), stack.sample(u, [d, e, g]));
}

fuzz_target!(|input: Input| {
    if input.layers.len() > 6 {
        return;
    }
    let layers: Vec<_> = input.layers.iter().map(Written::layer).collect();
    let model = Model::CLOSED_FORM[usize::from(input.model) % Model::CLOSED_FORM.len()];
    let Ok(stack) = Stack::new(model, layers) else { return };
    let stack = stack.with_widths(Widths::ALL[usize::from(input.widths) % Widths::ALL.len()]);
    judge::<f64>(&stack, &input);
    // What f32 rounds to may lie outside the range; then it is refused as anything else.
    let single = stack.layers().iter().map(Layer::cast::<f32>).collect();
    if let Ok(single) = Stack::new(model, single) {
        judge::<f32>(&single, &input);
    }
});
