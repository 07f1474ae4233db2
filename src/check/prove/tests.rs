//! Known truths.

use super::*;
use crate::check::family::Scale;
use crate::distribution;

/// Cosines from 0.05, the view at azimuth 0.
fn isotropic(boxes: usize) -> Options {
    Options { directions: Directions { isotropic: true, ..Directions::default() }, boxes }
}

fn alpha(low: f64) -> Parameter {
    Parameter { name: "alpha".into(), low, high: 1.0, default: 0.5, scale: Scale::Logarithmic }
}

/// A formula of the cosine of the light alone.
macro_rules! of_light {
    ($name:ident, $x:ident, $R:ident, $value:expr) => {
        struct $name;
        impl Formula for $name {
            fn evaluate<$R: Real>(&self, wi: Vector<$R>, _: Vector<$R>, _: &[$R]) -> $R {
                let $x = wi.z;
                $value
            }
        }
    };
}

of_light!(Lambert, _x, R, R::FRAC_1_PI);
of_light!(Dent, x, R, (x - R::from_f64(0.62)).squared() - R::from_f64(1e-6));
of_light!(Pole, x, R, R::ONE / (x - R::from_f64(0.3)));
of_light!(DoublePole, x, R, R::ONE / (x - R::from_f64(0.3)).squared());
of_light!(Root, x, R, (x - R::from_f64(0.5)).sqrt());
of_light!(Masked, x, R, (x - R::from_f64(0.5)).ln().max(R::ZERO).min(R::ONE));
of_light!(Cancelling, x, R, {
    let twin = x;
    let zero = x - twin;
    zero.abs() - (twin - x).abs()
});
of_light!(Touching, x, R, (x - R::from_f64(0.4)) * (x - R::from_f64(0.4)));

struct Ggx;
impl Formula for Ggx {
    fn evaluate<R: Real>(&self, wi: Vector<R>, wo: Vector<R>, parameters: &[R]) -> R {
        distribution::ggx(crate::half_vector(wi, wo), parameters[0])
    }
}

/// As shaders write it: the cosine of the normalised half vector, clamped.
struct Written;
impl Formula for Written {
    fn evaluate<R: Real>(&self, wi: Vector<R>, wo: Vector<R>, parameters: &[R]) -> R {
        let cosine = crate::half_vector(wi, wo).normalized().z.saturate();
        let a = parameters[0].squared();
        let d = cosine.squared() * (a - R::ONE) + R::ONE;
        a / (R::PI * d.squared())
    }
}

#[test]
fn lambert_is_proved_in_one_box() {
    let proof = formula("Lambert", &Lambert, &[], &Options::default());
    assert_eq!((&proof.sign, &proof.finite, proof.boxes), (&Answer::Proved, &Answer::Proved, 1));
    assert_eq!(proof.verdict(), Verdict::Pass);
    assert_eq!(proof.domain.describe(), "cos_i in 0.05..1, cos_o in 0.05..1, phi_i in 0..360, phi_o in 0..360");
}

#[test]
fn ggx_is_proved() {
    for proof in [
        formula("GGX", &Ggx, &[alpha(0.1)], &isotropic(100_000)),
        formula("GGX as written", &Written, &[alpha(0.1)], &isotropic(100_000)),
    ] {
        assert_eq!((&proof.sign, &proof.finite), (&Answer::Proved, &Answer::Proved), "{}", proof.subject);
    }
}

#[test]
fn a_dent_is_found_inside() {
    let Answer::Disproved(witness) = formula("dent", &Dent, &[], &isotropic(100_000)).sign else { panic!() };
    // The dent is 0.002 wide, and the roundest of it is its middle.
    assert!(witness.wi.z == 0.62 && witness.value < 0.0, "{witness:?}");
}

#[test]
fn poles_are_disproved() {
    let proof = formula("pole", &Pole, &[], &isotropic(100_000));
    let (Answer::Disproved(sign), Answer::Disproved(finite)) = (proof.sign, proof.finite) else { panic!() };
    assert!(sign.wi.z < 0.3 && sign.value < 0.0, "{sign:?}");
    assert!(finite.wi.z == 0.3 && finite.value.is_infinite(), "{finite:?}");
    // Never negative, and infinite at one cosine.
    let proof = formula("double pole", &DoublePole, &[], &isotropic(100_000));
    let Answer::Disproved(finite) = proof.finite else { panic!() };
    assert_eq!(finite.wi.z, 0.3);
    assert!(!matches!(proof.sign, Answer::Disproved(_)), "{:?}", proof.sign);
}

#[test]
fn what_has_no_value_is_not_finite() {
    let Answer::Disproved(root) = formula("root", &Root, &[], &isotropic(1000)).finite else { panic!() };
    assert!(root.value.is_nan() && root.wi.z < 0.5, "{root:?}");
    // A clamp hides it from f64, and a proof must not be had.
    let masked = formula("masked", &Masked, &[], &isotropic(1000));
    assert_eq!(masked.sign, Answer::Proved);
    let Answer::Undecided(rest) = masked.finite else { panic!() };
    // Below 0.5 of 0.05..1, and the boxes on its edge.
    assert!(rest.share > 0.45 / 0.95 && rest.share < 0.55, "{rest:?}");
}

#[test]
fn what_bounds_cannot_know_stays_undecided() {
    for proof in [
        formula("cancelling", &Cancelling, &[], &isotropic(3000)),
        formula("touching", &Touching, &[], &isotropic(3000)),
    ] {
        assert_eq!(proof.finite, Answer::Proved, "{}", proof.subject);
        let Answer::Undecided(rest) = &proof.sign else { panic!("{:?}", proof.sign) };
        assert!(rest.share > 0.0 && rest.count >= rest.worst.len() && !rest.worst.is_empty());
        assert_eq!(proof.verdict(), Verdict::Inconclusive);
    }
    // Enough boxes leave less of what touches 0 at one cosine alone, and all of x − x.
    let share = |boxes| match formula("touching", &Touching, &[], &isotropic(boxes)).sign {
        Answer::Undecided(rest) => rest.share,
        other => panic!("{other:?}"),
    };
    assert!(share(40) < 0.1 && share(3000) < share(40) / 100.0);
}

/// Points of boxes whose bounds say that there is no violation must have none, and lie between the bounds.
#[test]
fn bounds_hold_random_points() {
    let domain = Domain::new(&[alpha(0.01)], Directions { least_cosine: 0.01, isotropic: false });
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let (parameters, mut bounded) = ([alpha(0.01)], 0);
    let ggx = Named { name: "", formula: &Ggx, parameters: &parameters };
    let written = Named { name: "", formula: &Written, parameters: &parameters };
    for round in 0..3000 {
        let size = 0.5f64.powi(round % 12);
        let mut point = Vec::new();
        let mut region = domain.whole();
        for edge in &mut region {
            let span = (edge.high - edge.low) * size;
            let low = edge.low + random() * (edge.high - edge.low - span);
            *edge = Edge { low, high: low + span };
            point.push(low + random() * span);
        }
        let [wi, wo] = domain.pair(&point);
        for subject in [&ggx as &dyn Provable, &written] {
            let bounds = subject.enclose(&domain.row(&region), 1)[0];
            let value = subject.value(wi, wo, &point[..1]);
            bounded += usize::from(bounds.is_total());
            // What f64 itself rounds, some ten operations of a condition below 1e4, is not the bounds' matter.
            let room = 1e-10 * value.abs();
            assert!(bounds.low() - room <= value && value <= bounds.high() + room, "{region:?} {point:?} {bounds:?}");
        }
    }
    assert!(bounded > 1000, "{bounded}");
}

#[test]
fn proofs_print_their_box_and_witness() {
    let text = formula("dent", &Dent, &[], &isotropic(100_000)).to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "dent");
    assert_eq!(lines[1], "  box           cos_i in 0.05..1, cos_o in 0.05..1, phi_i in 0..360, phi_o = 0");
    assert!(lines[2].starts_with("  not negative  DISPROVED -1e-6 at cos_i = 0.62, "), "{text}");
    assert!(lines[3].starts_with("  again         --at wi="), "{text}");
    assert_eq!(lines[4], "  finite        PROVED");
    let text = formula("masked", &Masked, &[], &isotropic(100)).to_string();
    assert!(text.contains("  finite        UNDECIDED on ") && text.contains("the largest of"), "{text}");
}

#[test]
fn answers_repeat() {
    let prove = || formula("GGX", &Ggx, &[alpha(0.001)], &isotropic(2000));
    assert_eq!(prove(), prove());
}

#[cfg(feature = "shader")]
mod shaders {
    use super::*;
    use crate::check::shader::{Options as Reading, ShaderFamily};

    fn proof(source: &str, ranges: &[&str], boxes: usize) -> Proof {
        let ranges = ranges.iter().map(|range| (*range).to_owned()).collect();
        let options = Reading { function: "f".into(), ranges, ..Reading::default() };
        let family = ShaderFamily::from_source("f.wgsl", source, &options).unwrap();
        prove(&ShaderFormula::new(&family).unwrap(), &isotropic(boxes))
    }

    #[test]
    fn ggx_in_wgsl() {
        let source = "fn f(NoH: f32, roughness: f32) -> f32 {
            let c = saturate(NoH);
            let a = roughness * roughness;
            let d = c * c * (a - 1.0) + 1.0;
            return a / (3.14159265 * d * d);
        }";
        let proof = proof(source, &["roughness=0.1..1"], 100_000);
        assert_eq!((&proof.sign, &proof.finite), (&Answer::Proved, &Answer::Proved));
    }

    #[test]
    fn branches_and_channels() {
        // The second channel is negative where the branch is taken.
        let source = "fn f(NoL: f32, NoV: f32) -> vec3<f32> {
            if NoL > 0.9 && NoV < 0.1 { return vec3<f32>(1.0, -1.0, 1.0); }
            return vec3<f32>(1.0);
        }";
        let found = proof(source, &[], 10_000);
        assert_eq!(found.finite, Answer::Proved);
        let Answer::Disproved(witness) = found.sign else { panic!() };
        assert!(witness.wi.z > 0.9 && witness.wo.z < 0.1 && witness.value == -1.0, "{witness:?}");
        // Both ways of the branch are fine, wherever it lies.
        let source = "fn f(NoL: f32) -> f32 { if NoL > 0.37 { return 1.0; } return 2.0; }";
        let found = proof(source, &[], 10);
        assert_eq!((found.sign, found.finite, found.boxes), (Answer::Proved, Answer::Proved, 1));
    }

    #[test]
    fn infinity_times_nothing_is_not_finite() {
        let found = proof("fn f(NoL: f32) -> f32 { return 0.0 * (1.0 / (NoL - 0.3)); }", &[], 10_000);
        let Answer::Disproved(witness) = found.finite else { panic!("{:?}", found.finite) };
        assert!(witness.wi.z == 0.3 && witness.value.is_nan(), "{witness:?}");
    }

    #[test]
    fn loops_over_bounds_end() {
        let source = "fn f(NoL: f32) -> f32 {
            var x = NoL;
            loop { if x > 0.5 { break; } x = x * 1.01; }
            return x;
        }";
        let found = proof(source, &[], 200);
        assert!(!matches!(found.sign, Answer::Disproved(_)), "{:?}", found.sign);
    }
}
