//! What is said of files that are refused: the line, the key and what is allowed.

use super::{albedo, cover, file, refused, second};

#[test]
fn what_is_not_understood_is_refused_with_its_place() {
    for (text, want) in [
        ("name = ", "line 1: not TOML"),
        ("", "part: missing, expected a list of tables"),
        ("nam = 1", "line 1, nam: unknown key, did you mean `name`?"),
        ("part = 3", "line 1, part: found a number, expected a list of tables"),
        ("part = []", "line 1, part: there are 0 parts"),
        ("name = 3\npart = []", "line 1, name: found a number, expected a string"),
        ("material = \"patna\"", "line 1, material: unknown material \"patna\", did you mean `patina`?"),
        ("material = 3", "line 1, material: found a number, expected a string"),
        ("material = \"patina\"\nparameters = 3", "line 2, parameters: found a number, expected a table of numbers"),
        (
            "material = \"patina\"\n[parameters]\nextend = 1",
            "line 3, parameters.extend: patina has no parameter `extend`; it has",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = 1e9",
            "line 3, parameters.extent: extent of patina is 1000000000, allowed is",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = nan",
            "line 3, parameters.extent: extent of patina is NaN, allowed is",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = \"x\"",
            "line 3, parameters.extent: found a string, expected a number",
        ),
        (
            "material = \"patina\"\npart = []",
            "line 2, part: a material is built-in or made of parts, and material on line 1 is given",
        ),
        ("parameters = {}\npart = []", "line 1, parameters: belongs to a built-in material"),
        ("[[part]]", "line 1, part[0]: missing one of `layer`, `brushed`, `stack`"),
        ("[[part]]\ncover = 1\nlayer = []", "line 2, part[0].cover: the first part is the ground"),
        ("[[part]]\nlayer = []", "line 1, part[0]: there are 0 layers, a part has 1 to 4"),
        ("[[part]]\nlayers = []", "line 2, part[0].layers: unknown key, did you mean `layer`?"),
    ] {
        let message = refused(text);
        assert!(message.starts_with(want), "{text:?}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn parts_are_refused_with_their_place() {
    let diffuse = "layer = [{ interface = { diffuse = { albedo = 0.5 } } }]";
    for (keys, want) in [
        (
            "brushed = { metal = \"iron\", along = 0.1, across = 0.2 }\nmodel = \"elek\"",
            "line 5, part[1].model: belongs to a part with `layer`, and part[1].brushed on line 4",
        ),
        ("layer = []\nstack = {}", "line 5, part[1].stack: a part is of one kind, and part[1].layer on line 4"),
        (
            &format!("{diffuse}\nmodel = \"coupled\""),
            "line 5, part[1].model: layers that vary take no model \"coupled\"",
        ),
        (&format!("{diffuse}\nmodel = \"elk\""), "line 5, part[1].model: unknown model \"elk\", did you mean `elek`?"),
        (&format!("{diffuse}\nwidths = \"thin\""), "line 5, part[1].widths: unknown rule \"thin\""),
        (&format!("{diffuse}\nreturns = 1"), "line 5, part[1].returns: found a number, expected true or false"),
        (&format!("{diffuse}\nscatter = -1"), "line 5, part[1].scatter: -1 is not allowed, it must be in [0, 1]"),
        (&format!("{diffuse}\nscatter = 1e30"), "line 5, part[1].scatter: 1e30 is not allowed, it must be in [0, 1]"),
        (
            &format!("{diffuse}\nreflectivity = [0, 1, 2]"),
            "line 5, part[1].reflectivity[2]: 2 is not allowed, it must be in [0, 1]",
        ),
        (&format!("{diffuse}\ncover = 1.5"), "line 5, part[1].cover: 1.5 is not allowed, it must be in [0, 1]"),
        ("layer = [3]", "line 4, part[1].layer[0]: found a number, expected a table with the key `interface`"),
        ("layer = [{}]", "line 4, part[1].layer[0].interface: missing"),
        ("layer = [{ interface = {} }]", "line 4, part[1].layer[0].interface: missing one of `dielectric`"),
        (
            "layer = [{ interface = { alpha = 0.1, dielectric = { n = 1.5 }, diffuse = {} } }]",
            "line 4, part[1].layer[0].interface.diffuse: an interface is of one kind",
        ),
        (
            "layer = [{ interface = { dielectric = { n = 0 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.dielectric.n: 0 is not allowed, it must be in [0.001, 1000]",
        ),
        ("layer = [{ interface = { dielectric = { n = 1.5 } } }]", "line 4, part[1].layer[0].interface.alpha: missing"),
        (
            "layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 0 } }]",
            "line 4, part[1].layer[0].interface.alpha: 0 is not allowed, it must be in [0.0001, 1]",
        ),
        (
            "layer = [{ interface = { conductor = { metal = \"cooper\" }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.metal: unknown metal \"cooper\", did you mean `copper`?",
        ),
        (
            "layer = [{ interface = { conductor = { metal = \"copper\", k = 1 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.k: give either this or the metal",
        ),
        (
            "layer = [{ interface = { conductor = { n = 1 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.k: missing",
        ),
        (
            "layer = [{ interface = { conductor = {}, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor: missing either `metal`",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 2 } } }]",
            "line 4, part[1].layer[0].interface.diffuse.albedo: 2 is not allowed, it must be in [0, 1]",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 1, sigma = 2 } } }]",
            "line 4, part[1].layer[0].interface.diffuse.sigma: 2 is not allowed, it must be in [0, 1.57",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 1 }, alpha = 1 } }]",
            "line 4, part[1].layer[0].interface.alpha: a diffuse base has no microfacet width",
        ),
        (
            "[[part.layer]]\ninterface = { diffuse = { albedo = 1 } }\n[[part.layer]]\ninterface = { diffuse = { albedo = 1 } }",
            "line 4, part[1].layer[0]: a diffuse base lets nothing through",
        ),
        (
            "[[part.layer]]\nmedium = { sigma = 1 }\ninterface = { diffuse = { albedo = 1 } }",
            "line 5, part[1].layer[0].medium.thickness: missing",
        ),
        (
            "[[part.layer]]\nmedium = { sigma = -1, thickness = 1 }\ninterface = { diffuse = { albedo = 1 } }",
            "line 5, part[1].layer[0].medium.sigma: -1 is not allowed",
        ),
        ("brushed = { metal = \"iron\", along = 0.1 }", "line 4, part[1].brushed.across: missing"),
        (
            "brushed = { metal = \"iron\", along = 0.1, across = 3 }",
            "line 4, part[1].brushed.across: 3 is not allowed, it must be in [0.0001, 1]",
        ),
        ("stack = 3", "line 4, part[1].stack: found a number, expected a table with the key `layer`"),
        (
            "stack = { layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 2 } }] }",
            "line 4, part[1].stack.layer[0].interface.alpha: 2 is not allowed",
        ),
        (
            "stack = { layer = [{ interface = { dielectric = { n = [1, 2] }, alpha = 1 } }] }",
            "line 4, part[1].stack.layer[0].interface.dielectric.n",
        ),
        ("relief = {}\nlayer = []", "line 5, part[1].layer"),
    ] {
        let message = refused(&second(keys));
        if keys.starts_with("relief = {}") {
            // Layers are read first; an empty list of them is found by the material as a whole, after the relief.
            assert!(message.starts_with("line 4, part[1].relief: missing `height` or `normals`"), "{message}");
        } else {
            assert!(message.starts_with(want), "{keys:?}\n  gives {message}\n   want {want}");
        }
    }
}

/// What would create light, or would be read and do nothing.
#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    let coated = |keys: &str, medium: &str, base: &str| {
        let coat = format!("{{ interface = {{ dielectric = {{ n = 1.77 }}, alpha = 0.01 }}, {medium} }}");
        second(&format!("{keys}\nlayer = [{coat}, {{ interface = {{ diffuse = {{ {base} }} }} }}]"))
    };
    let clear = "medium = { sigma = 0, thickness = 0 }";
    let diffuse = "interface = { diffuse = { albedo = 0.5 } }";
    let lost = "no light comes back through a medium under the last layer";
    for (text, want) in [
        (
            coated("returns = true", clear, "albedo = 1, sigma = 1"),
            "line 4, part[1].returns: needs a Lambertian base, over Oren–Nayar's it would create light",
        ),
        (
            coated("returns = true", clear, "albedo = 1, sigma = \"u\""),
            "line 4, part[1].returns: needs a Lambertian base",
        ),
        (
            coated("model = \"weidlich_wilkie\"\nreturns = true", clear, "albedo = 1"),
            "line 5, part[1].returns: goes with the model `conserving` alone",
        ),
        (
            coated("returns = true\nmodel = \"elek\"", clear, "albedo = 1"),
            "line 4, part[1].returns: goes with the model `conserving` alone",
        ),
        (
            coated("returns = true", "medium = { sigma = 1, thickness = \"u\" }", "albedo = 1"),
            "line 4, part[1].returns: needs a diffuse base under one clear dielectric",
        ),
        (
            coated("returns = true", clear, "albedo = 1").replace("n = 1.77", "n = 3.5"),
            "line 4, part[1].returns: needs a diffuse base under one clear dielectric of a constant index from 1 to 3",
        ),
        (
            second(&format!("returns = true\nlayer = [{{ {diffuse} }}]")),
            "line 4, part[1].returns: needs a diffuse base",
        ),
        (
            second(&format!("layer = [{{ {diffuse} }}]\nscatter = 0.3")),
            "line 5, part[1].scatter: the documents' diffuse term is that of a reflecting layer",
        ),
        (
            second(&format!("[[part.layer]]\n{diffuse}\nmedium = {{ sigma = 100, thickness = 100 }}")),
            &format!("line 6, part[1].layer[0].medium: {lost}"),
        ),
        (
            second(&format!("stack = {{ layer = [{{ {diffuse}, medium = {{ sigma = 1, thickness = 1 }} }}] }}")),
            &format!("line 4, part[1].stack.layer[0].medium: {lost}"),
        ),
    ] {
        let message = refused(&text);
        assert!(message.starts_with(want), "{text:?}\n  gives {message}\n   want {want}");
    }
    // What is there and does nothing is left alone.
    for text in [
        coated("returns = true", clear, "albedo = 1"),
        second(&format!("layer = [{{ {diffuse}, medium = {{ sigma = 0, thickness = 1 }} }}]")),
        second(&format!(
            "relief = {{ height = {{ sum = [\"occlusion\", \"u\"] }}, step = 0.01 }}\nlayer = [{{ {diffuse} }}]"
        )),
    ] {
        file(&text);
    }
}

#[test]
fn reliefs_and_flakes_are_refused_with_their_place() {
    let relief = |keys: &str| {
        refused(&second(&format!("relief = {keys}\nlayer = [{{ interface = {{ diffuse = {{ albedo = 1 }} }} }}]")))
    };
    for (keys, want) in [
        ("{ height = 1 }", ".step: missing"),
        ("{ height = 1, step = 0 }", ".step: 0 is not allowed, it must be in [0.00001, 1000000]"),
        ("{ height = \"u\", step = 1e-6 }", ".step: 0.000001 is not allowed, it must be in [0.00001, 1000000]"),
        ("{ height = \"occlusion\", step = 0.01 }", ": a step moves neither `occlusion` nor `distance`"),
        ("{ height = { product = [3, \"occlusion\", \"distance\"] }, step = 0.01 }", ": a step moves neither"),
        ("{ height = 1, step = 1, strength = 1 }", ".strength: does not belong to a relief of this kind"),
        ("{ height = 1, normals = {} }", ".normals: a relief is of one kind"),
        ("{ normals = {}, step = 1 }", ".step: does not belong"),
        ("{ normals = {} }", ".normals.image: missing"),
        (
            "{ normals = { image = \"a.png\" }, encoding = \"bgr\" }",
            ".encoding: unknown encoding \"bgr\", allowed: `rgb`, `alpha_green`",
        ),
        (
            "{ normals = { image = \"a.png\" }, strength = inf }",
            ".strength: inf is not allowed, it must be in [-1000000, 1000000]",
        ),
        (
            "{ normals = { image = \"a.png\" }, strength = 1e7 }",
            ".strength: 10000000 is not allowed, it must be in [-1000000, 1000000]",
        ),
    ] {
        let message = relief(keys);
        let want = format!("line 4, part[1].relief{want}");
        assert!(message.starts_with(&want), "{keys}\n  gives {message}\n   want {want}");
    }
    let flakes = |keys: &str| {
        let interface = "interface = { dielectric = { n = 1.5 }, alpha = 0.1 }";
        refused(&second(&format!("[[part.layer]]\n{interface}\nflakes = {keys}")))
    };
    for (keys, want) in [
        ("3", ": found a number"),
        ("{ resolution = 2 }", ".spacing: missing"),
        ("{ spacing = -1, resolution = 2 }", ".spacing: -1 is not allowed, it must be in [1e-30, 1e30]"),
        ("{ spacing = 1, resolution = 2.5 }", ".resolution: 2.5 is not allowed, it must be a whole number in [1, 8]"),
        ("{ spacing = 1, resolution = 9 }", ".resolution: 9 is not allowed"),
        (
            "{ spacing = 1, resolution = 2, seed = -1 }",
            ".seed: -1 is not allowed, it must be a whole number in [0, 4294967295]",
        ),
        ("{ normals = { image = \"a.png\" }, seed = 1 }", ".seed: give either this or a map of normals"),
    ] {
        let message = flakes(keys);
        let want = format!("line 6, part[1].layer[0].flakes{want}");
        assert!(message.starts_with(&want), "{keys}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn numbers_that_vary_are_refused_with_their_place() {
    let deep = format!("{}1{}", "{ of = ".repeat(40), " }".repeat(40));
    let many = format!("{{ sum = [{}] }}", "1, ".repeat(17));
    for (field, want) in [
        ("true", ": found true or false, expected a number, a property"),
        ("[]", ": found a list, expected a number, a property"),
        ("1979-05-27", ": found a date or time"),
        ("nan", ": NaN is not allowed, it must be in [0, 1]"),
        ("\"oclusion\"", ": unknown property \"oclusion\", did you mean `occlusion`?"),
        ("{}", ": found an empty table, expected a number"),
        ("{ noize = {} }", ".noize: unknown key, did you mean `noise`?"),
        ("{ noise = {} }", ".noise.frequency: missing"),
        ("{ noise = { frequency = 1, octave = 2 } }", ".noise.octave: unknown key, did you mean `octaves`?"),
        (
            "{ noise = { frequency = 1, octaves = 0 } }",
            ".noise.octaves: 0 is not allowed, it must be a whole number in [1, 12]",
        ),
        ("{ noise = { frequency = 1, octaves = 13 } }", ".noise.octaves: 13 is not allowed"),
        ("{ noise = { frequency = 1, seed = 1e10 } }", ".noise.seed: 10000000000 is not allowed"),
        ("{ noise = { frequency = [1, 2] } }", ".noise.frequency: found a list of 2, expected three numbers"),
        ("{ noise = { frequency = inf } }", ".noise.frequency: inf is not allowed, it must be in [-10000, 10000]"),
        (
            "{ ridged = { frequency = [1, 1e30, 1] } }",
            ".ridged.frequency[1]: 1e30 is not allowed, it must be in [-10000, 10000]",
        ),
        ("{ noise = { frequency = 1, gain = \"x\" } }", ".noise.gain: found a string, expected a number"),
        ("{ noise = { frequency = 1 }, ridged = {} }", ".ridged: unknown key, allowed: `noise`"),
        ("{ scratches = {} }", ".scratches.frequency: missing"),
        (
            "{ scratches = { frequency = -10001 } }",
            ".scratches.frequency: -10001 is not allowed, it must be in [-10000, 10000]",
        ),
        (
            "{ scratches = { frequency = 1, density = 2 } }",
            ".scratches.density: 2 is not allowed, it must be in [0, 1]",
        ),
        (
            "{ scratches = { frequency = 1, width = 1 } }",
            ".scratches.width: 1 is not allowed, it must be in [0, 0.375]",
        ),
        (
            "{ scratches = { frequency = 1, layers = 65 } }",
            ".scratches.layers: 65 is not allowed, it must be a whole number in [1, 64]",
        ),
        ("{ scratches = { frequency = 1, octaves = 2 } }", ".scratches.octaves: unknown key"),
        ("{ image = 3 }", ".image: found a number, expected a string"),
        ("{ image = \"\" }", ".image: found an empty name"),
        ("{ image = \"missing.png\" }", ".image: \"missing.png\" cannot be used: no such file"),
        (
            "{ image = \"broken.hdr\" }",
            ".image: \"broken.hdr\" cannot be used: the texel in column 1, row 0 is not finite",
        ),
        ("{ image = \"talkative.exr\" }", ".image: \"talkative.exr\" cannot be used: not an image, of any kind"),
        ("{ image = \"a.png\", channel = \"z\" }", ".channel: unknown channel \"z\""),
        ("{ image = \"a.png\", repeat = [1, 2, 3] }", ".repeat: found a list of 3, expected two"),
        (
            "{ image = \"a.png\", repeat = [1, 1e5] }",
            ".repeat[1]: 100000 is not allowed, it must be in [-10000, 10000]",
        ),
        ("{ image = \"a.png\", srgb = true }", ".srgb: unknown key, allowed: `image`, `channel`, `repeat`"),
        ("{ sum = [] }", ".sum: there are 0 terms, a list has 1 to 16"),
        (&many, ".sum: there are 17 terms"),
        ("{ sum = [1, \"w\"] }", ".sum[1]: unknown property \"w\""),
        ("{ product = 3 }", ".product: found a number, expected a list"),
        ("{ mix = [1], by = 1 }", ".mix: found a list of 1, expected two"),
        ("{ mix = [1, 2] }", ".by: missing"),
        ("{ levels = [0, 1] }", ".of: missing"),
        ("{ levels = [0, \"x\"], of = 1 }", ".levels[1]: found a string, expected a number"),
        ("{ above = 0.5, softness = -1, of = 1 }", ".softness: -1 is not allowed, it must be in [0, 1e30]"),
        ("{ extent = 0.5, transition = -1, of = 1 }", ".transition: -1 is not allowed"),
        ("{ of = 1, factor = 2 }", ".factor: unknown key, allowed: `of`, `scale`, `offset`"),
        (&deep, ".of.of"),
    ] {
        let message = refused(&cover(field));
        let want = format!("line 4, part[1].cover{want}");
        assert!(message.starts_with(&want), "{field}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn colours_are_refused_with_their_place() {
    let many = format!("{{ ramp = [{}], by = 1 }}", "1, ".repeat(65));
    for (colour, want) in [
        ("\"red\"", ": found a string, expected a number, a list of three numbers"),
        ("[1, 2]", ": found a list of 2, expected three numbers"),
        ("[0, 0, nan]", "[2]: NaN is not allowed, it must be in [0, 1]"),
        ("{ gray = 1 }", ".gray: unknown key, did you mean `grey`?"),
        ("{ ramp = [1] }", ".by: missing"),
        ("{ ramp = [], by = 1 }", ".ramp: there are 0 colours, a ramp has 1 to 64"),
        (&many, ".ramp: there are 65 colours"),
        ("{ ramp = [[1, 1, 2]], by = 1 }", ".ramp[0][2]: 2 is not allowed, it must be in [0, 1]"),
        ("{ ramp = [0, 1], at = [0], by = 1 }", ".at: there are 1 positions for 2 colours"),
        ("{ ramp = [0, 1], at = [1, 0], by = 1 }", ".at[1]: positioned below the colour before it"),
        ("{ ramp = [0, 1], at = [0, 1e99], by = 1 }", ".at[1]: 1e99 is not allowed"),
        ("{ bands = [0, 1], softness = -1, by = 1 }", ".softness: -1 is not allowed"),
        ("{ image = \"a.png\", srgb = 1 }", ".srgb: found a number, expected true or false"),
        ("{ image = \"missing.png\" }", ".image: \"missing.png\" cannot be used"),
        ("{ colour = 1 }", ".scale: missing"),
        ("{ mix = [0, 3], by = 1 }", ".mix[1]: 3 is not allowed, it must be in [0, 1]"),
        ("{ film = 3 }", ".film: found a number"),
        (
            "{ film = { absorption = 1, scattering = -1, thickness = 1, ground = 1 } }",
            ".film.scattering: -1 is not allowed",
        ),
        ("{ film = { absorption = 1, scattering = 1, ground = 1 } }", ".film.thickness: missing"),
        (
            "{ film = { absorption = 1, scattering = 1, thickness = -2, ground = 1 } }",
            ".film.thickness: -2 is not allowed",
        ),
    ] {
        let message = refused(&albedo(colour));
        let want = format!("line 4, part[1].layer[0].interface.diffuse.albedo{want}");
        assert!(message.starts_with(&want), "{colour}\n  gives {message}\n   want {want}");
    }
}
