//! The figures, in the order of the documents.

use super::Figure;
use super::panel::View;
use crate::failure::Failure;
use brdf::Vector;
use brdf::distribution;
use brdf::frame::half_vector;
use brdf::fresnel;
use brdf::layered::{Interface, Layer, Model, Stack, Widths};
use brdf::masking::v_cavity;
use brdf::material::built_in::paint::{CarPaint, Sparkle};
use brdf::material::built_in::patinated::{Patina, Timeline};
use brdf::material::built_in::rust::RustyIron;
use brdf::material::built_in::worn::{BrushedSteel, WornMetal};
use brdf::material::built_in::{self, BuiltIn};
use brdf::material::{Material, Scalar, metal};
use brdf::render::Film;
use brdf::table::{DistributionTable, FresnelTable, Half, Mapping, SIDE};
use brdf::walk;

/// Every figure.
pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "roughness",
        about: "E fig. 2: copper of α = .05 under a coat of α = .4. Its own width, the documents' clamp, the rule of variances, the walk",
        exposure: -0.5,
        panels: roughness,
    },
    Figure {
        name: "distribution_tables",
        about: "E fig. 4: the highlight of m = .01, enlarged. D tabulated evenly over the angle, over its eighth root, and evaluated",
        exposure: -11.0,
        panels: distribution_tables,
    },
    Figure {
        name: "tables",
        about: "E fig. 5: copper evaluated, by tables of F and D as printed, and ten times their difference",
        exposure: 0.0,
        panels: tables,
    },
    Figure {
        name: "flakes",
        about: "E fig. 7: car paint from 3, 6, 12 and 24 radii. Glints that conserve energy; the documents' flake normals",
        exposure: 0.0,
        panels: flakes,
    },
    Figure {
        name: "patina_growth",
        about: "E fig. 8: extent −.65, −.05, .15, .45, .75 and 1.65 at transition .65. By Kubelka and Munk; as printed",
        exposure: 0.0,
        panels: patina_growth,
    },
    Figure {
        name: "patina_edges",
        about: "E fig. 9: the map of growth, and its edges at transition .9 and .2",
        exposure: 0.0,
        panels: patina_edges,
    },
    Figure {
        name: "coats",
        about: "E fig. 10: sparkling car paint, orange and purple lacquers of varying thickness, concrete in a blue varnish",
        exposure: 0.0,
        panels: coats,
    },
    Figure {
        name: "components",
        about: "M fig. 31–33: reflection of the environment, highlight, both; and copper of α = .05, .15, .4",
        exposure: 0.0,
        panels: components,
    },
    Figure {
        name: "oren_nayar",
        about: "M fig. 39: Lambert, and Oren–Nayar of σ = .5 and 1, lit from the viewer",
        exposure: 0.0,
        panels: oren_nayar,
    },
    Figure {
        name: "rust",
        about: "M fig. 41–43: the height map, the mask, the rust's colours, and rusty iron",
        exposure: 0.3,
        panels: rust,
    },
    Figure {
        name: "patina_timeline",
        about: "M fig. 24: copper of age 0, .2, .4, .6, .8 and 1, in bands of five colours",
        exposure: 0.3,
        panels: patina_timeline,
    },
    Figure {
        name: "worn",
        about: "M fig. 11–16 and 36–38: scratched and dirty titanium, its mask, brushed steel, steel turned around its axis",
        exposure: 0.0,
        panels: worn,
    },
];

type Panels = Result<Vec<Vec<Film>>, Failure>;

fn copper() -> Result<&'static metal::Metal, Failure> {
    Ok(metal::by_name("copper").ok_or_else(|| "copper is in the table".to_owned())?)
}

fn built(of: &dyn BuiltIn) -> Result<Material, Failure> {
    Ok(of.material().map_err(|error| error.to_string())?)
}

fn named(name: &str) -> Result<Material, Failure> {
    Ok(built_in::with(name, &[]).map_err(|error| error.to_string())?)
}

fn roughness() -> Panels {
    let metal = copper()?;
    let layers =
        vec![Layer::new(Interface::dielectric(1.5, 0.4)), Layer::new(Interface::conductor(metal.n, metal.k, 0.05))];
    let stack = Stack::<f64, 3>::new(Model::Conserving, layers).map_err(|error| error.to_string())?;
    let mut row = Vec::new();
    for widths in Widths::ALL {
        let stack = stack.clone().with_widths(widths);
        row.push(View::lit(4.0).of_brdf(|wi, wo| stack.evaluate(wi, wo))?);
    }
    row.push(View::lit(4.0).of_brdf(|wi, wo| {
        // Each point its own walks: the noise of neighbours is independent.
        let bits = |x: f64| (x * 1e6) as i64 as u32;
        let seed = bits(wo.x).wrapping_mul(31).wrapping_add(bits(wo.y)).wrapping_add(bits(wi.x).wrapping_mul(17));
        let options = walk::Options { samples: 64, seed, threads: 1, ..walk::Options::default() };
        walk::evaluate(&stack, wi, wo, &options).mean
    })?);
    Ok(vec![row])
}

/// D of m = .01 by a table that is even in the angle, as a texture of 512 texels is.
fn even_in_angle(h: Vector<f64>, texels: &[f64]) -> f64 {
    let angle = h.sin_squared().sqrt().atan2(h.z);
    let place = angle / std::f64::consts::FRAC_PI_2 * (texels.len() - 1) as f64;
    let (low, share) = (place.floor(), place.fract());
    let texel = |at: f64| texels.get(at as usize).copied().unwrap_or(0.0);
    texel(low) * (1.0 - share) + texel(low + 1.0) * share
}

fn distribution_tables() -> Panels {
    const ALPHA: f64 = 0.01;
    let even: Vec<f64> = (0..SIDE)
        .map(|i| {
            let angle = i as f64 / (SIDE - 1) as f64 * std::f64::consts::FRAC_PI_2;
            distribution::beckmann(Vector::from_angles(angle, 0.0), ALPHA)
        })
        .collect();
    let eighth = DistributionTable::<Half>::new(SIDE, SIDE, 0.0023, Mapping::Angle).map_err(|e| e.to_string())?;
    let panel = |d: &(dyn Fn(Vector<f64>) -> f64 + Sync)| {
        let mut view = View::lit(1.0).close(1.0);
        // The light behind the viewer: the highlight is in the middle.
        view.lights =
            vec![brdf::render::light::Light::Directional { towards: view_direction(&view), irradiance: [1.0; 3] }];
        view.of_brdf(|wi, wo| [d(half_vector(wi, wo)); 3])
    };
    Ok(vec![vec![
        panel(&|h| even_in_angle(h, &even))?,
        panel(&|h| eighth.evaluate(h, ALPHA))?,
        panel(&|h| distribution::beckmann(h, ALPHA))?,
    ]])
}

/// Towards the viewer.
fn view_direction(view: &View) -> Vector<f64> {
    let (azimuth, elevation) = (view.orbit.azimuth.to_radians(), view.orbit.elevation.to_radians());
    Vector::new(azimuth.sin() * elevation.cos(), -azimuth.cos() * elevation.cos(), elevation.sin())
}

fn tables() -> Panels {
    let metal = copper()?;
    const ALPHA: f64 = 0.2;
    let f_table = FresnelTable::<3, u8>::new(metal.n, metal.k, 128, Mapping::Angle).map_err(|e| e.to_string())?;
    let d_table = DistributionTable::<Half>::new(SIDE, SIDE, 0.0023, Mapping::Angle).map_err(|e| e.to_string())?;
    let full = |wi: Vector<f64>, wo: Vector<f64>| -> [f64; 3] {
        let h = half_vector(wi, wo);
        let lobe = distribution::beckmann(h, ALPHA) * v_cavity(wi.z, wo.z, h).visibility;
        let cosine = brdf::microfacet::cos_half(wi, wo);
        std::array::from_fn(|c| lobe * fresnel::conductor(cosine, metal.n[c], metal.k[c]).reflectance)
    };
    let tabled = |wi: Vector<f64>, wo: Vector<f64>| -> [f64; 3] {
        let h = half_vector(wi, wo);
        let lobe = d_table.evaluate(h, ALPHA) * v_cavity(wi.z, wo.z, h).visibility;
        f_table.reflectance(brdf::microfacet::cos_half(wi, wo)).map(|f: f64| f * lobe)
    };
    let difference = |wi: Vector<f64>, wo: Vector<f64>| -> [f64; 3] {
        let (full, tabled) = (full(wi, wo), tabled(wi, wo));
        std::array::from_fn(|c| 10.0 * (full[c] - tabled[c]).abs())
    };
    Ok(vec![vec![View::lit(1.0).of_brdf(full)?, View::lit(1.0).of_brdf(tabled)?, View::lit(1.0).of_brdf(difference)?]])
}

fn flakes() -> Panels {
    let row = |sparkle: Sparkle| -> Result<Vec<Film>, Failure> {
        let material = built(&CarPaint { sparkle, ..CarPaint::default() })?;
        [3.0, 6.0, 12.0, 24.0].into_iter().map(|distance| View::studio()?.from(distance).of(material.clone())).collect()
    };
    Ok(vec![row(Sparkle::Glints)?, row(Sparkle::AsPrinted)?])
}

fn patina_growth() -> Panels {
    let row = |scattering| -> Result<Vec<Film>, Failure> {
        [-0.65, -0.05, 0.15, 0.45, 0.75, 1.65]
            .into_iter()
            .map(|extent| {
                let material = built(&Patina { extent, transition: 0.65, scattering, ..Patina::default() })?;
                View::studio()?.of_torus()?.of(material)
            })
            .collect()
    };
    use built_in::patinated::Scattering;
    Ok(vec![row(Scattering::KubelkaMunk)?, row(Scattering::AsPrinted)?])
}

/// A number at each point, as grey.
fn map_of(field: &Scalar, view: View) -> Result<Film, Failure> {
    view.of_colour(|point| [field.at(point, &[]); 3])
}

fn patina_edges() -> Panels {
    let with = |transition: f64| Patina { extent: 0.4, transition, ..Patina::default() };
    Ok(vec![vec![
        map_of(&with(0.5).growth(), View::studio()?.of_torus()?)?,
        View::studio()?.of_torus()?.of(built(&with(0.9))?)?,
        View::studio()?.of_torus()?.of(built(&with(0.2))?)?,
    ]])
}

fn coats() -> Panels {
    let names = ["car_paint", "orange_lacquer", "purple_lacquer", "varnished_concrete"];
    let row: Result<Vec<Film>, Failure> = names.into_iter().map(|name| View::studio()?.of(named(name)?)).collect();
    Ok(vec![row?])
}

fn components() -> Panels {
    let metal = copper()?;
    let of = |alpha: f64| -> Result<Material, Failure> {
        let layer = Layer::new(Interface::conductor(metal.n, metal.k, alpha));
        Ok(Stack::<f64, 3>::new(Model::Conserving, vec![layer]).map_err(|error| error.to_string())?.into())
    };
    let reflection = View { lights: Vec::new(), ..View::studio()? };
    Ok(vec![
        vec![reflection.of(of(0.15)?)?, View::lit(1.5).of(of(0.15)?)?, View::studio()?.of(of(0.15)?)?],
        vec![View::studio()?.of(of(0.05)?)?, View::studio()?.of(of(0.15)?)?, View::studio()?.of(of(0.4)?)?],
    ])
}

fn oren_nayar() -> Panels {
    let panel = |sigma: f64| {
        let mut view = View::lit(2.5);
        view.lights =
            vec![brdf::render::light::Light::Directional { towards: view_direction(&view), irradiance: [2.5; 3] }];
        let layer = Layer::new(Interface::diffuse([0.8, 0.7, 0.6], sigma));
        let stack = Stack::<f64, 3>::new(Model::Conserving, vec![layer]).map_err(|error| error.to_string())?;
        view.of(stack.into())
    };
    Ok(vec![vec![panel(0.0)?, panel(0.5)?, panel(1.0)?]])
}

fn rust() -> Panels {
    let rusty = RustyIron::default();
    let all = RustyIron { amount: 1.0, ..rusty.clone() };
    Ok(vec![vec![
        map_of(&rusty.relief(), View::studio()?)?,
        map_of(&rusty.mask(), View::studio()?)?,
        View::studio()?.of(built(&all)?)?,
        View::studio()?.of(built(&rusty)?)?,
    ]])
}

fn patina_timeline() -> Panels {
    let row: Result<Vec<Film>, Failure> = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
        .into_iter()
        .map(|age| View::studio()?.of_torus()?.of(built(&Timeline { age, ..Timeline::default() })?))
        .collect();
    Ok(vec![row?])
}

fn worn() -> Panels {
    let worn = WornMetal::default();
    Ok(vec![vec![
        View::studio()?.of(built(&worn)?)?,
        map_of(&worn.scratches(), View::studio()?)?,
        View::studio()?.of(built(&BrushedSteel::default())?)?,
        View::studio()?.of(built(&BrushedSteel { turn: 0.0, ..BrushedSteel::default() })?)?,
    ]])
}
