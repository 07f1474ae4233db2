//! The judge on materials: what is blended of plausible stacks is plausible.

use super::{materials, point};
use brdf::check::{self, Family, MaterialFamily, Verdict};
use brdf::frame::Vector;
use brdf::material::{Finish, Material, Part};

/// Without normals of their own, whose parts are BRDFs about other normals than the surface's.
fn flat(material: &Material) -> Material {
    let part = |part: &Part| Part { finish: Finish { relief: None, ..part.finish.clone() }, ..part.clone() };
    Material::new(material.parts().iter().map(part).collect(), material.images().to_vec()).expect("the same parts")
}

/// At a point where every part has a share.
#[test]
fn blends_are_plausible() {
    for (name, material) in materials() {
        let material = flat(&material);
        let is_blend = |index: &u32| {
            let cover = |part: &Part| part.cover.at::<f64>(&point(*index).cast(), material.images());
            material.parts().iter().skip(1).all(|part| (0.2..0.8).contains(&cover(part)))
        };
        let index =
            (0..200_000).find(is_blend).unwrap_or_else(|| panic!("{name}: a point where every part has a share"));
        let place = point(index).cast::<f64>();
        let spot = material.at(&place);
        let subject = check::from_fn(name, 3, |wi: Vector<f64>, wo, f: &mut [f64]| {
            let cosine = if wi.z > 0.0 { wi.z } else { 1.0 };
            for (f, reflected) in f.iter_mut().zip(spot.reflected(wi, wo)) {
                *f = reflected / cosine;
            }
        });
        let report = check::check(&subject, &check::Options::default());
        println!("{name:24} at {index:4}: {:?}", report.verdict());
        // The documents' own forms are there to be compared with: their judge finds the gain.
        let expected = if name.ends_with("as_printed") { Verdict::Fail } else { Verdict::Pass };
        assert_eq!(report.verdict(), expected, "{name}: {report:#?}");
    }
}

/// Over every point and all that each of their numbers may be; what the judge is asked by `brdf check NAME`.
#[test]
fn built_in_materials_are_plausible_whatever_their_numbers() {
    for named in brdf::material::built_in::all() {
        let family = MaterialFamily::built_in(named.name).expect(named.name);
        assert!(family.parameters().len() >= 3, "{}", named.name);
        let report = check::check_family(&family, &check::Options::default());
        println!("{:24} {}", named.name, report.verdict());
        let expected = if named.name.ends_with("as_printed") { Verdict::Fail } else { Verdict::Pass };
        assert_eq!((report.verdict(), family.error()), (expected, None), "{}: {report}", named.name);
    }
}
