//! `--at`: one place of one subject, evaluated again.

use super::subjects::Loaded;
use super::twins::{Twins, left_out};
use crate::output::complain;
use brdf::Vector;
use brdf::check::{self, Check, Effort, Fixed, Place, Profile, Subject, Verdict, albedo, reciprocity};
use std::io::{self, Write};

/// A place to see again, of one member.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct At {
    pub(super) directions: Directions,
    /// Values of parameters, by name; the others have their defaults.
    pub(super) parameters: Vec<(String, f64)>,
}

/// The directions of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Directions {
    /// A fixed direction in degrees, whose albedo is integrated.
    Marginal { theta: f64, phi: f64, fixed: Fixed },
    /// A pair of directions.
    Pair { wi: Vector<f64>, wo: Vector<f64> },
}

impl At {
    /// Reads `theta=80,phi=0,light` or `wi=X:Y:Z,wo=X:Y:Z`, and `NAME=VALUE` of parameters.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let wrong = |what: &str| {
            format!("{what}; want theta=80,phi=0,light (or view), or wi=X:Y:Z,wo=X:Y:Z; and NAME=VALUE of parameters")
        };
        let (mut theta, mut phi, mut fixed) = (None, None, None);
        let [mut wi, mut wo] = [None, None];
        let mut parameters: Vec<(String, f64)> = Vec::new();
        for word in text.split(',') {
            let number = |value: &str| {
                let number = value.parse::<f64>().ok().filter(|x| x.is_finite());
                number.ok_or_else(|| wrong(&format!("`{value}` in `{word}` is no number")))
            };
            let vector = |value: &str| {
                let parts: Vec<f64> = value.split(':').map(number).collect::<Result<_, _>>()?;
                match parts[..] {
                    [x, y, z] => {
                        let length = f64::hypot(f64::hypot(x, y), z);
                        // What was printed is one to the last digit; what was typed may have been cut.
                        if !(0.99..=1.01).contains(&length) {
                            return Err(wrong(&format!("`{word}` has the length {length}, a direction has 1")));
                        }
                        let scale = if (length - 1.0).abs() < 1e-9 { 1.0 } else { 1.0 / length };
                        Ok(Some(Vector::new(x, y, z) * scale))
                    }
                    _ => Err(wrong(&format!("`{word}` has {} components", parts.len()))),
                }
            };
            match word.split_once('=') {
                // The place comes first: what it has already, or has no use for, is a parameter of that name.
                Some(("theta", value)) if theta.is_none() && wi.is_none() => theta = Some(number(value)?),
                Some(("phi", value)) if phi.is_none() && wi.is_none() => phi = Some(number(value)?),
                Some(("wi", value)) if wi.is_none() && theta.is_none() => wi = vector(value)?,
                Some(("wo", value)) if wo.is_none() && theta.is_none() => wo = vector(value)?,
                Some((name, _)) if parameters.iter().any(|(known, _)| known == name) => {
                    return Err(wrong(&format!("`{name}` is given twice")));
                }
                Some((name, value)) if !name.is_empty() => parameters.push((name.to_owned(), number(value)?)),
                None if word == "light" => fixed = Some(Fixed::Light),
                None if word == "view" => fixed = Some(Fixed::View),
                _ => return Err(wrong(&format!("`{word}` is not understood"))),
            }
        }
        let directions = match (theta, fixed, wi, wo) {
            (Some(theta), Some(fixed), None, None) if (0.0..90.0).contains(&theta) => {
                Directions::Marginal { theta, phi: phi.unwrap_or(0.0), fixed }
            }
            (Some(_), Some(_), None, None) => return Err(wrong("theta lies in [0, 90)")),
            (None, None, Some(wi), Some(wo)) => Directions::Pair { wi, wo },
            _ => return Err(wrong(&format!("`{text}` is no place"))),
        };
        Ok(At { directions, parameters })
    }
}

/// More than a check spends on one direction: this is the only one.
const EFFORT: Effort = Effort { target: 2e-5, evaluations: 300_000, replicates: 16, samples: 2048, seed: 1 };

/// Evaluates the place and prints what is there; returns the verdict on that alone, as the settings judge it.
pub(super) fn print(
    out: &mut impl Write,
    loaded: &Loaded,
    values: &[f64],
    at: &At,
    settings: &check::Options<'_>,
    twins: &Twins,
) -> io::Result<Verdict> {
    loaded.judged.member(values, |subject| {
        writeln!(out, "{}", subject.name())?;
        match at.directions {
            Directions::Marginal { theta, phi, fixed } => marginal(out, subject, theta, phi, fixed, settings),
            Directions::Pair { wi, wo } => {
                let gpu = loaded.on_gpu(values, twins, &[(wi.cast(), wo.cast())]).transpose();
                let gpu = gpu.unwrap_or_else(|reason| {
                    complain(&left_out(&reason));
                    None
                });
                pair(out, subject, wi, wo, gpu.as_deref(), settings)
            }
        }
    })
}

fn marginal(
    out: &mut impl Write,
    subject: &dyn Subject,
    theta: f64,
    phi: f64,
    fixed: Fixed,
    settings: &check::Options<'_>,
) -> io::Result<Verdict> {
    let albedo = albedo(subject, theta, phi, fixed, &Effort { seed: settings.seed, ..EFFORT });
    let mut verdict = Verdict::Pass;
    writeln!(out, "  albedo at θ={theta}° φ={phi}° [{} fixed]", fixed.name())?;
    for (channel, (&value, &error)) in albedo.value.iter().zip(&albedo.error).enumerate() {
        let judged = Verdict::of(value, error, 1.0, settings.tolerance);
        let name = subject.channel_name(channel);
        writeln!(out, "  {name:12} {value:.6} ± {error:.1e} {judged}")?;
        verdict = verdict.max(judged);
    }
    if !albedo.agrees {
        writeln!(
            out,
            "  cubature and its cross-check disagree: {:?} ± {:?}",
            albedo.cross_check, albedo.standard_error
        )?;
        verdict = verdict.max(Verdict::Inconclusive);
    }
    if albedo.non_finite > 0 {
        writeln!(out, "  {} samples were not finite and count as 0", albedo.non_finite)?;
        verdict = verdict.max(Verdict::Inconclusive);
    }
    let place = Place::Marginal { theta, phi, fixed };
    advise(out, settings.profile, verdict, settings.profile.binds(Check::Energy, place))
}

/// The verdict that counts, and a line where what was found only advises.
fn advise(out: &mut impl Write, profile: Profile, found: Verdict, binds: bool) -> io::Result<Verdict> {
    if binds || found == Verdict::Pass {
        return Ok(found);
    }
    writeln!(out, "  {found}, which only advises under --profile {}", profile.name())?;
    Ok(Verdict::Pass)
}

/// What rounds to a negative number in f32 is no fault of the model's.
const ROUNDING: f64 = 1e-4;

fn pair(
    out: &mut impl Write,
    subject: &dyn Subject,
    wi: Vector<f64>,
    wo: Vector<f64>,
    gpu: Option<&[f32]>,
    settings: &check::Options<'_>,
) -> io::Result<Verdict> {
    let channels = subject.channels();
    let (mut forth, mut back, mut single) = (vec![0.0; channels], vec![0.0; channels], vec![0.0f32; channels]);
    subject.evaluate(wi, wo, &mut forth);
    subject.evaluate(wo, wi, &mut back);
    // What a measurement may be below 0 by is its own matter.
    let below = if settings.profile == Profile::Measured { settings.tolerance } else { 0.0 };
    let mut sound = forth.iter().all(|f| f.is_finite() && *f >= -below.max(1e-12));
    let list = |f: &[f64]| f.iter().map(|f| format!("{f}")).collect::<Vec<_>>().join(", ");
    let narrow = |f: &[f32]| f.iter().map(|f| format!("{f}")).collect::<Vec<_>>().join(", ");
    writeln!(out, "  f(wi, wo) f64  {}", list(&forth))?;
    if subject.evaluate_single(wi.cast(), wo.cast(), &mut single) {
        sound &= single.iter().all(|f| f.is_finite() && f64::from(*f) >= -below.max(ROUNDING));
        writeln!(out, "  f(wi, wo) f32  {}", narrow(&single))?;
    }
    if let Some(gpu) = gpu {
        writeln!(out, "  f(wi, wo) GPU  {}", narrow(gpu))?;
    }
    writeln!(out, "  f(wo, wi) f64  {}", list(&back))?;
    let relative = |(f, g): (&f64, &f64)| (f - g).abs() / f.abs().max(g.abs()).max(reciprocity::FLOOR);
    let difference = forth.iter().zip(&back).map(relative).filter(|d| d.is_finite()).fold(0.0, f64::max);
    if forth.iter().chain(&back).all(|f| f.is_finite()) {
        writeln!(out, "  relative difference of both orders {difference:.2e}")?;
    } else {
        writeln!(out, "  both orders cannot be compared: not finite")?;
    }
    let verdict = |fine| if fine { Verdict::Pass } else { Verdict::Fail };
    let binds = settings.profile.binds(Check::Reciprocity, Place::Pair { wi, wo });
    let mutual = advise(out, settings.profile, verdict(difference <= reciprocity::TOLERANCE), binds)?;
    Ok(verdict(sound).max(mutual))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read() {
        let directions = Directions::Marginal { theta: 80.0, phi: 0.0, fixed: Fixed::Light };
        let want = At { directions, parameters: Vec::new() };
        assert_eq!(At::parse("theta=80,phi=0,light").as_ref(), Ok(&want));
        assert_eq!(At::parse("light,theta=80").as_ref(), Ok(&want));
        let parameters = vec![("a.r".to_owned(), 0.3)];
        assert_eq!(At::parse("light,a.r=0.3,theta=80"), Ok(At { parameters, ..want }));
        let (wi, wo) = (Vector::new(0.6, -0.0, 0.8), Vector::new(0.0, 1e-7, 1.0));
        let pair = At::parse("wi=0.6:-0:0.8,wo=0:1e-7:1").map(|at| at.directions);
        assert_eq!(pair, Ok(Directions::Pair { wi, wo }));
        // The names of a place are free again behind it.
        let parameters = vec![("theta".to_owned(), 9.0), ("phi".to_owned(), 2.0), ("wi".to_owned(), 1.0)];
        let named = At::parse("theta=80,phi=0,light,theta=9,phi=2,wi=1").map(|at| at.parameters);
        assert_eq!(named, Ok(parameters.clone()));
        let named = At::parse("wi=0:0:1,wo=0:0:1,theta=9,phi=2,wi=1").map(|at| at.parameters);
        assert_eq!(named, Ok(parameters));
        for bad in [
            "",
            "wi=0:0:0,wo=0:0:1",
            "wi=0:0:1e308,wo=0:0:1",
            "theta=0,view,a=1,a=2",
            "theta=90,light",
            "theta=x,light",
            "theta=3",
            "wi=0:0:1",
            "wi=0:1,wo=0:0:1",
            "up",
            "theta=NaN,view",
            "=1,theta=0,view",
        ] {
            let error = At::parse(bad).expect_err(bad);
            assert!(error.contains("want theta="), "{bad}: {error}");
        }
    }
}
