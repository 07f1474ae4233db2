//! Fields that leave their range, and edges that are as wide as their documentation says.

use super::point;
use brdf::layered::{Model, Widths};
use brdf::material::field::{Colour, Lookup, Noise, Property, Scalar, Scratches};
use brdf::material::finish::{Body, BrushedMetal, Coat, Finish, Layers, Relief, STEEPEST};
use brdf::material::{Material, Part, Point, built_in};
use brdf::texture::image::Image;
use brdf::{Vector, material};

/// A field that is this number, but not a constant.
fn varying(number: f64) -> Scalar {
    Scalar::Of(Property::X).scaled(number, 0.0)
}

/// Where the fields above are what they say.
fn here() -> Point<f64> {
    Point { position: Vector::new(1.0, 0.0, 0.0), ..Point::default() }
}

fn lit(material: &Material) -> [f64; 3] {
    material.at(&here()).reflected(Vector::from_angles(0.5, 0.3), Vector::from_angles(0.4, 2.9))
}

#[test]
fn whole_turns_of_grooves_change_nothing() {
    let brushed = |turn: Scalar| {
        let metal = material::metal::by_name("chromium").unwrap();
        let body = BrushedMetal { n: metal.n.into(), k: metal.k.into(), along: 0.08.into(), across: 0.35.into(), turn };
        lit(&Material::plain(Finish::new(Body::Brushed(Box::new(body)))).unwrap())
    };
    for turn in [0.0, 0.25, 0.625] {
        for whole in [-3.0, -1.0, 1.0, 1024.0] {
            assert_eq!(brushed((turn + whole).into()), brushed(turn.into()), "{turn} + {whole}");
            assert_eq!(brushed(varying(turn + whole)), brushed(turn.into()), "{turn} + {whole}");
        }
    }
    assert_ne!(brushed(0.25.into()), brushed(0.0.into()));
}

#[test]
fn a_film_thinner_than_nothing_is_its_ground() {
    let film = |thickness: Scalar, ground: Colour| {
        let film = Colour::Film { absorption: [1.0; 3], scattering: [8.0; 3], thickness, ground: Box::new(ground) };
        film.at::<f64>(&here(), &[])
    };
    for thickness in [-1e9, -0.1, 0.0] {
        assert_eq!(film(varying(thickness), 0.5.into()), [0.5; 3]);
    }
    // A ground brighter than white, or darker than black.
    let bright = |ground: f64| film(varying(0.1), Colour::Grey(varying(ground)));
    assert_eq!([bright(3.0), bright(-2.0)], [bright(1.0), bright(0.0)]);
    assert!(bright(1.0)[0] < 1.0 && bright(0.0)[0] > 0.0);
}

#[test]
fn a_mixture_is_between_what_is_mixed() {
    for (share, want) in [(-1.0, 1.0), (0.0, 1.0), (0.25, 1.25), (1.0, 2.0), (7.0, 2.0)] {
        assert_eq!(Scalar::mix(1.0, 2.0, varying(share)).at::<f64>(&here(), &[]), want);
        assert_eq!(Colour::mix(1.0, 2.0, varying(share)).at::<f64>(&here(), &[]), [want; 3]);
    }
}

#[test]
fn softness_is_half_the_width_of_an_edge() {
    let mask = |value: f64| varying(value).above(0.5, 0.125).at::<f64>(&here(), &[]);
    assert_eq!([0.375, 0.5, 0.625].map(mask), [0.0, 0.5, 1.0]);
    assert!(mask(0.38) > 0.0 && mask(0.62) < 1.0);
}

/// Nothing is covered at 0 and everything at 1, at every softness.
#[test]
fn growth_goes_from_none_to_all() {
    for (name, stage) in [("patina_over_time", "age"), ("rusty_iron", "amount")] {
        for softness in [0.0, 1e-3, 0.05, 0.3, 1.0] {
            let covers = |at: f64| -> Vec<f64> {
                let mut named = built_in::by_name(name).unwrap();
                named.set(stage, at).unwrap();
                named.set("softness", softness).unwrap();
                let material = named.material().unwrap();
                (0..3000)
                    .map(|index| {
                        let occlusion = [0.0, 0.5, 1.0][index as usize % 3];
                        let place = Point { occlusion, ..point(index).cast::<f64>() };
                        material.parts()[1].cover.at::<f64>(&place, material.images())
                    })
                    .collect()
            };
            assert!(covers(0.0).iter().all(|cover| *cover == 0.0), "{name}, {softness}");
            assert!(covers(1.0).iter().all(|cover| *cover == 1.0), "{name}, {softness}");
            // Of what lies open half the growth covers half, as noise is even about its middle; hidden places are earlier. Some 50 cells of noise
            // on the sphere leave a standard deviation of .07: three of them.
            let open: Vec<f64> = covers(0.5).into_iter().step_by(3).collect();
            let half = open.iter().sum::<f64>() / open.len() as f64;
            assert!((half - 0.5).abs() < 0.21, "{name}, {softness}: {half}");
        }
    }
}

#[test]
fn the_printed_diffuse_term_is_never_negative() {
    let scattering = |sigma: Colour| {
        let coats = vec![Coat::dielectric(1.5, 0.3), Coat::conductor([0.2; 3], [3.0; 3], 0.3)];
        let scatter = Some(sigma);
        let layers = Layers { model: Model::Elek, widths: Widths::Own, coats, returns: false, scatter };
        let material = Material::plain(Finish::new(Body::Layers(layers))).unwrap();
        let mut mirrored = 0.0;
        material.at(&here()).mirrored(Vector::from_angles(0.4, 2.9), &mut |mirror| {
            assert!(mirror.weight.iter().all(|weight| (0.0..=1.0).contains(weight)), "{mirror:?}");
            mirrored += mirror.weight[0];
        });
        (lit(&material), mirrored)
    };
    let of = |sigma: f64| scattering(Colour::Grey(varying(sigma)));
    assert_eq!([of(1e30), of(-7.0)], [of(1.0), of(0.0)]);
    // In the local model too: the less it absorbs, the brighter.
    assert!(of(0.0).0[0] > of(1.0).0[0] && of(0.0).1 > of(0.5).1 + 0.3);
}

#[test]
fn slopes_are_clamped() {
    for height in [1e30, -1e30, 1e12, -1e8] {
        let relief = Relief::Height { height: Scalar::Of(Property::X).scaled(height, 0.0), step: 1e-5 };
        let point = Point { tangent: Vector::new(1.0, 0.0, 0.0), ..here() };
        let normal = relief.normal::<f64>(&point, &[]);
        let want = Vector::new(-height.signum() * STEEPEST, 0.0, 1.0).normalized();
        assert!((normal - want).length_squared() < 1e-30, "{height}: {normal:?}");
        let single = relief.normal::<f32>(&point.cast(), &[]).cast::<f64>();
        assert!((single - want).length_squared() < 1e-13, "{height}: {single:?}");
    }
}

/// What the file reader says with its line, said of a material made by hand.
#[test]
fn what_cannot_be_meant_is_refused() {
    let refused = |finish: Finish| Material::plain(finish).expect_err("no material").to_string();
    let coated = |model, sigma: f64, returns, scatter: Option<Colour>| {
        let coats = vec![Coat::dielectric(1.5, 0.1), Coat::diffuse(1.0, sigma)];
        Finish::new(Body::Layers(Layers { model, widths: Widths::Own, coats, returns, scatter }))
    };
    assert!(Material::plain(coated(Model::Conserving, 0.0, true, None)).is_ok());
    let oren_nayar = refused(coated(Model::Conserving, 0.5, true, None));
    assert!(oren_nayar.starts_with("part[0].returns: needs a Lambertian base"), "{oren_nayar}");
    for model in [Model::Elek, Model::WeidlichWilkie] {
        let message = refused(coated(model, 0.0, true, None));
        assert!(message.starts_with("part[0].returns: goes with the model `conserving` alone"), "{message}");
    }
    let base = Coat::diffuse(0.5, 0.0);
    let buried = refused(Finish::layers(vec![base.clone().over([1.0; 3], 1.0)]));
    assert!(buried.starts_with("part[0].layer[0].medium: no light comes back"), "{buried}");
    let relief = |height: Scalar, step| Finish::layers(vec![base.clone()]).with_relief(Relief::Height { height, step });
    let flat = refused(relief(Scalar::Of(Property::Occlusion).scaled(2.0, 1.0), 0.01));
    assert!(flat.starts_with("part[0].relief: a step moves neither"), "{flat}");
    for step in [1e-30, 1e-6, 1e7, f64::NAN] {
        let message = refused(relief(Scalar::Fractal(Noise::new(1, 2.0)), step));
        assert!(message.starts_with("part[0].relief: the step of a height is"), "{message}");
    }
}

/// What is finer than the numbers that places are made of.
#[test]
fn cells_that_nothing_resolves_are_refused() {
    let material = |cover| {
        let part = |cover| Part { cover, finish: Finish::layers(vec![Coat::diffuse(0.5, 0.0)]) };
        let image = Image::new(1, 1, 1, vec![0.5]).expect("valid");
        Material::new(vec![part(Scalar::Constant(1.0)), part(cover)], vec![image])
    };
    let finest = Noise { lacunarity: 3.0, ..Noise::new(1, 1e4) }.octaves(12);
    let lookup = |repeat| Scalar::Image(Lookup { image: 0, repeat: [1.0, repeat] }, 0);
    for fine in [Scalar::Fractal(finest), Scalar::Scratches(Scratches::new(1, -1e4)), lookup(1e4)] {
        assert!(material(fine).is_ok());
    }
    let octaves = Noise { lacunarity: 3.1, ..finest };
    for (cover, says) in [
        (Scalar::Fractal(Noise::new(1, 1e30)), "the frequency of a noise is 1e30, it must be in [-10000, 10000]"),
        (Scalar::Ridged(octaves), "the last octave of a noise has 2.54"),
        (Scalar::Scratches(Scratches::new(1, -2e4)), "the frequency of scratches is -2e4, it must be in"),
        (lookup(1e9), "the repetition of an image is 1e9, it must be in"),
    ] {
        let message = material(cover).expect_err("too fine").to_string();
        assert!(message.contains(says), "{message}");
    }
}
