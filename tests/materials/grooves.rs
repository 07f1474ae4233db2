//! Which way the grooves of brushed metals run.

use super::point;
use brdf::material::finish::Body;
use brdf::material::{Point, built_in};
use brdf::{Frame, Vector};
use std::f64::consts::{FRAC_PI_2, TAU};

/// A point of the unit sphere at a polar angle and an azimuth: u runs around z, v from pole to pole.
fn on_the_sphere(theta: f64, phi: f64) -> Point<f64> {
    let position = Vector::<f64>::from_angles(theta, phi);
    let tangent = Vector::new(-phi.sin(), phi.cos(), 0.0);
    Point { position, tangent, bitangent: position.cross(tangent), ..Point::default() }
}

/// Highlights stretch across the grooves: along the meridian where they run around the axis, around it where they run along.
#[test]
fn highlights_stretch_across_the_grooves() {
    for (name, around) in [("turned_steel", true), ("brushed_steel", false)] {
        let material = built_in::by_name(name).unwrap().material().unwrap();
        for index in 0..20 {
            let at = point(index).cast::<f64>();
            let spot = material.at(&at);
            let frame = Frame { tangent: at.tangent, bitangent: at.bitangent, normal: at.position };
            // Light 20° from the mirror direction of a view along the normal: over the axis, or to its side.
            let lit = |towards: Vector<f64>| {
                let wi = frame.to_local(at.position * 20f64.to_radians().cos() + towards * 20f64.to_radians().sin());
                spot.reflected(wi, Vector::new(0.0, 0.0, 1.0))[1]
            };
            let up = at.position.cross(Vector::new(0.0, 0.0, 1.0)).cross(at.position).normalized();
            let aside = Vector::new(0.0, 0.0, 1.0).cross(at.position).normalized();
            let (along_axis, around_axis) = (lit(up), lit(aside));
            let (wide, narrow) = if around { (along_axis, around_axis) } else { (around_axis, along_axis) };
            assert!(wide > 2.0 * narrow, "{name}, {at:?}: {wide} across, {narrow} along");
        }
    }
}

/// Streaks differ from groove to groove, and little along one.
#[test]
fn streaks_follow_the_grooves() {
    for (name, around) in [("turned_steel", true), ("brushed_steel", false)] {
        let material = built_in::by_name(name).unwrap().material().unwrap();
        let Body::Brushed(metal) = &material.parts()[0].finish.body else { panic!("{name} is brushed") };
        let width = |theta: f64, phi: f64| metal.across.at::<f64>(&on_the_sphere(theta, phi), &[]);
        let (mut across, mut along) = (0.0, 0.0);
        for i in 0..400 {
            let phi = TAU * f64::from(i) / 400.0;
            // Around the axis everywhere; along it near the equator.
            let theta = if around { 0.4 + 2.3 * f64::from(i) / 400.0 } else { FRAC_PI_2 };
            let here = width(theta, phi);
            let over = (width(theta + 0.01, phi) - here).abs();
            let aside = (width(theta, phi + 0.01 / theta.sin()) - here).abs();
            let (a, b) = if around { (over, aside) } else { (aside, over) };
            across += a;
            along += b;
        }
        assert!(across > 10.0 * along, "{name}: {across} across, {along} along");
    }
}
