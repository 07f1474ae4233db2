//! Lights of no extent: from infinitely far away, and from a point.

use crate::frame::Vector;
use crate::real::Real;
use core::str::FromStr;

/// How the light of a point thins out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Falloff {
    /// 1/d², which conserves energy.
    #[default]
    InverseSquare,
    /// 1/d, as Mihaylov's eq. 4.3 prints it (erratum 25): what is lit at distance 1 is the same, what is farther is brighter.
    Inverse,
}

/// The largest number of a position or a power that is read: its square, over a narrow lobe's density, still fits f32.
pub const MOST: f64 = 1e9;

/// A light of no extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From one direction.
    Directional {
        /// Towards the light, unit.
        towards: Vector<f64>,
        /// W/m² on a surface that faces it.
        irradiance: [f64; 3],
    },
    /// From one point.
    Point {
        /// Where it is.
        position: Vector<f64>,
        /// W/sr: the irradiance of a surface that faces it at distance 1.
        intensity: [f64; 3],
        /// How it thins out.
        falloff: Falloff,
    },
}

/// What arrives at a point from a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arriving<R> {
    /// Towards the light, unit.
    pub towards: Vector<R>,
    /// How far the light is; the largest number for a directional one.
    pub distance: R,
    /// W/m² on a surface that faces it.
    pub irradiance: [R; 3],
}

impl Light {
    /// What arrives at a point.
    #[inline(always)]
    pub fn at<R: Real>(&self, point: Vector<R>) -> Arriving<R> {
        match self {
            Light::Directional { towards, irradiance } => Arriving {
                towards: towards.cast(),
                distance: R::from_f64(f64::from(f32::MAX)),
                irradiance: irradiance.map(R::from_f64),
            },
            Light::Point { position, intensity, falloff } => {
                let way = position.cast::<R>() - point;
                let squared = way.length_squared().max(R::EPSILON * R::EPSILON);
                let distance = squared.sqrt();
                let divisor = match falloff {
                    Falloff::InverseSquare => squared,
                    Falloff::Inverse => distance,
                };
                let scale = R::ONE / divisor;
                let irradiance = intensity.map(|x| R::from_f64(x) * scale);
                Arriving { towards: way * (R::ONE / distance), distance, irradiance }
            }
        }
    }
}

impl FromStr for Light {
    type Err = String;

    /// `directional:X,Y,Z[,E]` or `directional:X,Y,Z,R,G,B`: towards the light, and the irradiance (π by default, which shows a white
    /// diffuse surface that faces it as 1). `point:X,Y,Z[,I]`, `point:X,Y,Z,R,G,B`: a position and the intensity; `point/d:…` thins
    /// out as 1/d. Directions have any length > 0; positions and powers are at most [`MOST`].
    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a light is directional:X,Y,Z[,E] or point:X,Y,Z[,I] (point/d: thins out as 1/d), E and I one number ≥ 0 or R,G,B";
        let (kind, rest) = text.split_once(':').ok_or_else(|| format!("`{text}`: {form}"))?;
        let numbers: Vec<f64> = rest
            .split(',')
            .map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite()))
            .collect::<Option<_>>()
            .ok_or_else(|| format!("`{text}`: `{rest}` holds what is no finite number; {form}"))?;
        let (place, power) = match numbers.as_slice() {
            [x, y, z] => (Vector::new(*x, *y, *z), [core::f64::consts::PI; 3]),
            [x, y, z, all] => (Vector::new(*x, *y, *z), [*all; 3]),
            [x, y, z, r, g, b] => (Vector::new(*x, *y, *z), [*r, *g, *b]),
            _ => return Err(format!("`{text}`: {} numbers; {form}", numbers.len())),
        };
        if power.iter().any(|x| *x < 0.0) {
            return Err(format!("`{text}`: a negative light; {form}"));
        }
        let Vector { x, y, z } = place;
        let most = x.abs().max(y.abs()).max(z.abs());
        if power.iter().any(|x| *x > MOST) || kind != "directional" && most > MOST {
            let (what, found) = if most > MOST && kind != "directional" {
                ("coordinate", most)
            } else {
                ("power", power.into_iter().fold(0.0, f64::max))
            };
            return Err(format!(
                "`{text}`: a {what} of {found:e}; a picture holds at most {MOST:e}: choose a larger unit"
            ));
        }
        let point = |falloff| Ok(Light::Point { position: place, intensity: power, falloff });
        match kind {
            // Scaled before it is squared, which would overflow or vanish.
            "directional" if most > 0.0 => {
                let towards = Vector::new(x / most, y / most, z / most).normalized();
                Ok(Light::Directional { towards, irradiance: power })
            }
            "directional" => Err(format!("`{text}`: 0,0,0 is no direction; {form}")),
            "point" => point(Falloff::InverseSquare),
            "point/d" => point(Falloff::Inverse),
            _ => Err(format!("`{kind}` is no kind of light; {form}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_thin_out() {
        let light = |falloff| Light::Point { position: Vector::new(0.0, 0.0, 5.0), intensity: [8.0; 3], falloff };
        let at = |falloff| light(falloff).at(Vector::<f64>::new(0.0, 0.0, 1.0));
        let square = at(Falloff::InverseSquare);
        assert_eq!((square.distance, square.irradiance), (4.0, [0.5; 3]));
        assert_eq!(at(Falloff::Inverse).irradiance, [2.0; 3]);
    }

    #[test]
    fn lights_are_read() {
        assert!(matches!("directional:0,0,2,3".parse(), Ok(Light::Directional { irradiance: [3.0, ..], .. })));
        assert!(matches!("point/d:1,2,3".parse(), Ok(Light::Point { falloff: Falloff::Inverse, .. })));
        for length in [1e-310, 1e-200, 1.0, 1e200] {
            let light: Light = format!("directional:0,{length:e},0").parse().expect("a direction");
            assert!(matches!(light, Light::Directional { towards: Vector { y: 1.0, .. }, .. }), "{light:?}");
        }
        for (wrong, said) in [
            ("point:0,0,1e60", "a coordinate of 1e60"),
            ("point:0,0,2,1e60", "a power of 1e60"),
            ("directional:0,0,1,1e10", "at most 1e9"),
        ] {
            let error = wrong.parse::<Light>().expect_err(wrong);
            assert!(error.contains(said) && error.lines().count() == 1, "{error}");
        }
        for wrong in ["", "sun", "directional:0,0,0", "point:1,2", "point:1,2,3,-1", "point:1,2,NaN", "lamp:1,2,3"] {
            let error = wrong.parse::<Light>().expect_err(wrong);
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
}
