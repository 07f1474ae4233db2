//! Stack files: what they mean, and what is said of those that are refused.
#![cfg(feature = "toml")]

use brdf::layered::description::{Description, Node, Value};
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::metal;

/// The example of the design.
const EXAMPLE: &str = r#"name  = "clear coat over copper"
model = "conserving"            # elek | weidlich_wilkie | conserving | coupled | walk
[[layer]]
interface = { dielectric = { n = 1.5 }, alpha = 0.1 }
medium    = { sigma = [0.0, 0.0, 0.0], thickness = 0.5 }
[[layer]]
interface = { conductor = { metal = "copper" }, alpha = 0.3 }   # or n = [..], k = [..]
# a base may be: interface = { diffuse = { albedo = [..], sigma = 0.3 } }
"#;

/// Every construct, some in sub-tables and with dotted keys.
const EVERYTHING: &str = r#"model = 'elek'
name = """every "construct" """

[[layer]]
interface.alpha = 0.05
interface.dielectric.n = [1.5, 1.51, 1_5.2e-1]
medium.sigma = 0x1
medium.thickness = +0.4

[[layer]]
[layer.interface]
alpha = 3e-1
[layer.interface.conductor]
n = [
    2.83,   # red
    3.10,
    3.06,
]
k = 0.19

[[layer]]
interface = { diffuse = { albedo = [0.55, 0.53, 1], sigma = 0.5 } }
"#;

fn file(text: &str) -> Description {
    Description::from_toml(text).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> String {
    let error = Description::from_toml(text).expect_err(text);
    let message = error.to_string();
    assert!(!message.contains(['\n', '\r']), "{message:?}");
    message
}

/// The message for one layer whose `interface` and `medium` start on lines 2 and 3.
fn layer(keys: &str) -> String {
    refused(&format!("[[layer]]\n{keys}\n"))
}

/// The message for one interface, on line 2, with the place taken off.
fn interface(table: &str) -> String {
    let message = layer(&format!("interface = {table}"));
    message.strip_prefix("line 2, layer[0].interface").unwrap_or_else(|| panic!("{message}")).to_owned()
}

fn from_json(value: &serde_json::Value) -> Node {
    Node::from(match value {
        serde_json::Value::Null => Value::Other("null".to_owned()),
        serde_json::Value::Bool(flag) => Value::Flag(*flag),
        serde_json::Value::Number(number) => Value::Number(number.as_f64().unwrap()),
        serde_json::Value::String(text) => Value::Text(text.clone()),
        serde_json::Value::Array(items) => Value::List(items.iter().map(from_json).collect()),
        serde_json::Value::Object(map) => Value::Table(map.iter().map(|(k, v)| (k.clone(), from_json(v))).collect()),
    })
}

#[test]
fn the_example_is_the_stack_built_by_hand() {
    let copper = metal::by_name("copper").unwrap();
    let layers = vec![
        Layer::new(Interface::dielectric(1.5, 0.1)).over([0.0; 3], 0.5),
        Layer::new(Interface::conductor(copper.n, copper.k, 0.3)),
    ];
    let by_hand = Stack::new(Model::Conserving, layers).unwrap();
    let description = file(EXAMPLE);
    assert_eq!(description.name.as_deref(), Some("clear coat over copper"));
    assert_eq!((description.model, description.channels()), (Some(Model::Conserving), 3));
    let stack = description.stack::<f64, 3>().unwrap();
    assert_eq!(stack, by_hand);
    assert_eq!(description.stack::<f32, 3>().unwrap(), by_hand.cast());
    let (wi, wo) = ([0.36, 0.48, 0.8], [-0.6, 0.0, 0.8]);
    assert_eq!(stack.evaluate(wi, wo), by_hand.evaluate(wi, wo));
    assert!(stack.evaluate(wi, wo).iter().all(|f| *f > 0.0));
}

#[test]
fn every_construct_is_understood() {
    let layers = vec![
        Layer::new(Interface::Microfacet { n: [1.5, 1.51, 1.52], k: [0.0; 3], alpha: 0.05 }).over([1.0; 3], 0.4),
        Layer::new(Interface::conductor([2.83, 3.10, 3.06], [0.19; 3], 0.3)),
        Layer::new(Interface::diffuse([0.55, 0.53, 1.0], 0.5)),
    ];
    let description = file(EVERYTHING);
    assert_eq!(description.name.as_deref(), Some("every \"construct\" "));
    assert_eq!(description.stack::<f64, 3>(), Ok(Stack::new(Model::Elek, layers).unwrap()));
    // Windows line ends and an inline list of layers change nothing.
    assert_eq!(file(&EVERYTHING.replace('\n', "\r\n")), description);
    let inline = r#"layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 1e-4 } },
        { interface = { diffuse = { albedo = 1 } } }]"#;
    let base = [Layer::new(Interface::dielectric(1.5, 1e-4)), Layer::new(Interface::diffuse([1.0; 4], 0.0))];
    let description = file(inline);
    assert_eq!((&description.name, description.model, description.channels()), (&None, None, 1));
    assert_eq!(description.stack::<f64, 4>(), Ok(Stack::new(Model::Conserving, base.to_vec()).unwrap()));
    assert!(description.stack::<f32, 1>().is_ok());
}

#[test]
fn json_is_the_same_tree() {
    let json = r#"{"model": "elek", "layer": [
        {"interface": {"alpha": 0.05, "dielectric": {"n": [1.5, 1.51, 1.52]}},
         "medium": {"sigma": 1, "thickness": 0.4}},
        {"interface": {"conductor": {"n": [2.83, 3.10, 3.06], "k": 0.19}, "alpha": 0.3}},
        {"interface": {"diffuse": {"albedo": [0.55, 0.53, 1], "sigma": 0.5}}}]}"#;
    let description = Description::from_node(&from_json(&serde_json::from_str(json).unwrap())).unwrap();
    assert_eq!(description.stack::<f64, 3>().unwrap(), file(EVERYTHING).stack().unwrap());

    let refused =
        |json: &str| Description::from_node(&from_json(&serde_json::from_str(json).unwrap())).unwrap_err().to_string();
    assert_eq!(refused("[]"), "found a list, expected a table with the key `layer`");
    assert_eq!(refused(r#"{"name": null, "layer": []}"#), "name: found null, expected a string");
    assert_eq!(
        refused(&json.replace("0.05", "2")),
        "layer[0].interface.alpha: 2 is not allowed, it must be in [0.0001, 1]"
    );
    assert_eq!(
        refused(&json.replace("0.19", "[1, 2]")),
        "layer[1].interface.conductor.k: 2 channels, but layer[0].interface.dielectric.n has 3 channels"
    );
    let twice = Value::Table(vec![
        ("name".to_owned(), Value::Text("a".to_owned()).into()),
        ("name".to_owned(), Value::Text("b".to_owned()).into()),
    ]);
    assert_eq!(Description::from_node(&twice.into()).unwrap_err().to_string(), "name: given twice, first as name");
}

#[test]
fn numbers_are_refused_as_a_stack_refuses_them() {
    let dielectric = |n: &str, alpha: &str| interface(&format!("{{ dielectric = {{ n = {n} }}, alpha = {alpha} }}"));
    for (alpha, shown) in [("2", "2"), ("0", "0"), ("9e-5", "0.00009"), ("1e-9", "1e-9"), ("-1e300", "-1e300")] {
        assert_eq!(dielectric("1.5", alpha), format!(".alpha: {shown} is not allowed, it must be in [0.0001, 1]"));
    }
    for (alpha, shown) in [("nan", "NaN"), ("-nan", "NaN"), ("inf", "inf"), ("-inf", "-inf"), ("1e999", "inf")] {
        let expected = format!(".alpha: {shown} is not allowed, it must be finite and in [0.0001, 1]");
        assert_eq!(dielectric("1.5", alpha), expected);
    }
    assert_eq!(dielectric("0", "0.1"), ".dielectric.n: 0 is not allowed, it must be in [0.001, 1000]");
    assert_eq!(dielectric("[1, -2.5]", "0.1"), ".dielectric.n[1]: -2.5 is not allowed, it must be in [0.001, 1000]");
    assert_eq!(
        dielectric("[1, 1, nan]", "0.1"),
        ".dielectric.n[2]: NaN is not allowed, it must be finite and in [0.001, 1000]"
    );
    assert_eq!(
        interface("{ conductor = { n = 1, k = [0, -1] }, alpha = 0.1 }"),
        ".conductor.k[1]: -1 is not allowed, it must be in [0, 1000]"
    );
    assert_eq!(
        interface("{ diffuse = { albedo = 1.5 } }"),
        ".diffuse.albedo: 1.5 is not allowed, it must be in [0, 1]"
    );
    assert_eq!(
        interface("{ diffuse = { albedo = 1, sigma = 2 } }"),
        ".diffuse.sigma: 2 is not allowed, it must be in [0, π/2]"
    );
    let medium = |medium: &str| {
        layer(&format!("interface = {{ dielectric = {{ n = 1.5 }}, alpha = 0.1 }}\nmedium = {{ {medium} }}"))
    };
    assert_eq!(
        medium("sigma = -1, thickness = 1"),
        "line 3, layer[0].medium.sigma: -1 is not allowed, it must be 0 or greater"
    );
    assert_eq!(
        medium("sigma = 1, thickness = -0.5"),
        "line 3, layer[0].medium.thickness: -0.5 is not allowed, it must be 0 or greater"
    );
    // The topmost layer that is at fault is named, whichever channel it is.
    let two = EVERYTHING.replace("0.53", "-2").replace("3.06", "-3");
    assert_eq!(
        refused(&two),
        "line 17, layer[1].interface.conductor.n[2]: -3 is not allowed, it must be in [0.001, 1000]"
    );
}

#[test]
fn a_medium_under_the_last_layer_is_refused() {
    let last = |keys: &str| format!("[[layer]]\ninterface = {{ diffuse = {{ albedo = 0.5 }} }}\n{keys}\n");
    let message = "line 3, layer[0].medium: no light comes back through a medium under the last layer: leave it out, or put a layer under it";
    let medium = "medium = { sigma = [0, 100, 0], thickness = 100 }";
    assert_eq!(refused(&last(medium)), message);
    // One that absorbs nothing is no mistake, and one under another layer is seen.
    file(&last("medium = { sigma = 0, thickness = 100 }"));
    let coat = format!("[[layer]]\ninterface = {{ dielectric = {{ n = 1.5 }}, alpha = 0.1 }}\n{medium}\n");
    file(&(coat + &last("")));
}

#[test]
fn numbers_that_only_f64_holds_are_refused_in_f32() {
    let stack = |sigma: &str| {
        let interface = "interface = { dielectric = { n = 1.5 }, alpha = 1e-4 }";
        let base = "[[layer]]\ninterface = { diffuse = { albedo = 0.5 } }";
        let text = format!("[[layer]]\n{interface}\nmedium = {{ sigma = [1, {sigma}], thickness = 1 }}\n{base}");
        assert!(file(&text).stack::<f64, 2>().is_ok());
        file(&text).stack::<f32, 2>().map_err(|error| error.to_string())
    };
    assert!(stack("1.5").is_ok() && stack("1e-60").is_ok());
    let place = "line 3, layer[0].medium.sigma[1]";
    assert_eq!(stack("1e300"), Err(format!("{place}: 1e300 is inf in f32, it must be finite and 0 or greater")));
}

#[test]
fn layers_are_required_and_a_base_is_the_last() {
    for text in ["", "\n# nothing\n", "name = \"nothing\"\n"] {
        assert_eq!(refused(text), "layer: a stack needs at least one layer");
    }
    assert_eq!(refused("\nlayer = []\n"), "line 2, layer: a stack needs at least one layer");
    assert_eq!(
        refused("[layer]"),
        "line 1, layer: found a table, expected a list of tables, in TOML each under [[layer]]"
    );
    assert_eq!(refused("layer = [\n1]"), "line 2, layer[0]: found a number, expected a table with the key `interface`");
    let base = "[[layer]]\ninterface = { diffuse = { albedo = 0.5 } }\n";
    assert_eq!(
        refused(&base.repeat(2)),
        "line 2, layer[0].interface.diffuse: a diffuse base is opaque, so it must be the last layer"
    );
}

#[test]
fn channels_agree() {
    let text = EVERYTHING.replace("k = 0.19", "k = [0.1, 0.2]");
    assert_eq!(
        refused(&text),
        "line 19, layer[1].interface.conductor.k: 2 channels, but layer[0].interface.dielectric.n on line 6 has 3 channels"
    );
    let metal = EXAMPLE.replace("[0.0, 0.0, 0.0]", "[1]");
    assert_eq!(
        refused(&metal),
        "line 7, layer[1].interface.conductor.metal: 3 channels, but layer[0].medium.sigma on line 5 has 1 channel"
    );
    let error = file(EXAMPLE).stack::<f64, 1>().unwrap_err().to_string();
    assert_eq!(error, "line 5, layer[0].medium.sigma: this gives the stack 3 channels, 1 asked for");
    assert_eq!(
        interface("{ dielectric = { n = [] }, alpha = 0.1 }"),
        ".dielectric.n: found an empty list, expected a number, or a list of one number for each channel"
    );
}

#[test]
fn unknown_keys_and_names_are_refused_with_the_nearest() {
    assert_eq!(
        refused("title = 1\n[[layer]]"),
        "line 1, title: unknown key, allowed: `name`, `model`, `widths`, `layer`"
    );
    assert_eq!(
        refused("[[layers]]"),
        "line 1, layers: unknown key, did you mean `layer`? Allowed: `name`, `model`, `widths`, `layer`"
    );
    assert_eq!(
        refused(&EXAMPLE.replace("thickness", "thicknes")),
        "line 5, layer[0].medium.thicknes: unknown key, did you mean `thickness`? Allowed: `sigma`, `thickness`"
    );
    assert_eq!(interface("{ dielectric = { n = 1.5, alpha = 0.1 } }"), ".dielectric.alpha: unknown key, allowed: `n`");
    assert_eq!(
        interface("{ dielectric = { n = 1.5 }, \"al\\npha\" = 0.1 }"),
        ".\"al\\npha\": unknown key, did you mean `alpha`? Allowed: `dielectric`, `conductor`, `diffuse`, `alpha`"
    );
    // The first in the file, not in the alphabet.
    assert!(refused("zeta = 1\nbeta = 2\n").starts_with("line 1, zeta: unknown key"));
    assert_eq!(
        refused("model = \"Elec\""),
        "line 1, model: unknown model \"Elec\", did you mean `elek`? Allowed: `elek`, `weidlich_wilkie`, `conserving`, `coupled`, `walk`"
    );
    let unknown = refused(&EXAMPLE.replace("\"copper\"", "\"Aluminum\\n\""));
    let place = "line 7, layer[1].interface.conductor.metal";
    let start =
        format!("{place}: unknown metal \"Aluminum\\n\", did you mean `aluminium`? Allowed: `copper`, `gold`, ");
    assert!(unknown.starts_with(&start), "{unknown}");
    assert!(metal::METALS.iter().all(|metal| unknown.contains(&format!("`{}`", metal.name))));
}

#[test]
fn missing_and_superfluous_keys_are_refused() {
    assert_eq!(
        layer(""),
        "line 1, layer[0].interface: missing, expected a table such as { dielectric = { n = 1.5 }, alpha = 0.1 }"
    );
    assert_eq!(interface("{}"), ": missing one of `dielectric`, `conductor`, `diffuse`");
    assert_eq!(
        interface("{ dielectric = { n = 1.5 } }"),
        ".alpha: missing, expected a number, the width of the microfacets, beside `dielectric` or `conductor`"
    );
    let channels = "a number, or a list of one number for each channel";
    assert_eq!(interface("{ dielectric = {}, alpha = 1 }"), format!(".dielectric.n: missing, expected {channels}"));
    assert_eq!(
        interface("{ conductor = { n = 1 }, alpha = 1 }"),
        format!(".conductor.k: missing, expected {channels}")
    );
    assert_eq!(
        interface("{ conductor = { k = 1 }, alpha = 1 }"),
        format!(".conductor.n: missing, expected {channels}")
    );
    assert_eq!(interface("{ conductor = {}, alpha = 1 }"), ".conductor: missing either `metal` or `n` and `k`");
    assert_eq!(interface("{ diffuse = {} }"), format!(".diffuse.albedo: missing, expected {channels}"));
    assert_eq!(
        interface("{ diffuse = { albedo = 1 }, alpha = 1 }"),
        ".alpha: a diffuse base has no microfacet width; its roughness is `diffuse.sigma`"
    );
    assert_eq!(
        interface("{ conductor = { metal = \"gold\", k = 1 }, alpha = 1 }"),
        ".conductor.k: give either this or the metal, and layer[0].interface.conductor.metal on line 2 is given"
    );
    assert_eq!(
        interface("{ diffuse = { albedo = 1 }, dielectric = { n = 1 }, alpha = 1 }"),
        ".dielectric: an interface is of one kind, and layer[0].interface.diffuse on line 2 is given already"
    );
    let medium = |medium: &str| refused(&format!("{EXAMPLE}\nmedium = {medium}\n"));
    assert_eq!(medium("{ sigma = 1 }"), "line 10, layer[1].medium.thickness: missing, expected a number");
    assert_eq!(medium("{ thickness = 1 }"), format!("line 10, layer[1].medium.sigma: missing, expected {channels}"));
}

#[test]
fn wrong_types_are_refused() {
    assert_eq!(refused("name = 1"), "line 1, name: found a number, expected a string");
    assert_eq!(
        refused("widths = \"varience\""),
        "line 1, widths: unknown rule \"varience\", did you mean `variance`? Allowed: `own`, `clamp`, `variance`"
    );
    assert_eq!(refused("model = [1]"), "line 1, model: found a list, expected a string");
    for (value, found) in [
        ("\"0.1\"", "a string"),
        ("true", "true or false"),
        ("[0.1]", "a list"),
        ("{}", "a table"),
        ("1979-05-27", "a date or time"),
        ("0xFFFFFFFFFFFFFFFFF", "an integer of more than 64 bits"),
    ] {
        let message = interface(&format!("{{ dielectric = {{ n = 1 }}, alpha = {value} }}"));
        assert_eq!(message, format!(".alpha: found {found}, expected a number"));
    }
    assert_eq!(
        interface("{ dielectric = { n = [1, \"2\"] }, alpha = 1 }"),
        ".dielectric.n[1]: found a string, expected a number"
    );
    assert_eq!(
        interface("{ dielectric = 1.5, alpha = 1 }"),
        ".dielectric: found a number, expected a table such as { n = 1.5 }"
    );
    assert_eq!(
        interface("\"glass\""),
        ": found a string, expected a table such as { dielectric = { n = 1.5 }, alpha = 0.1 }"
    );
    assert_eq!(
        interface("{ diffuse = { albedo = 1, sigma = [1] } }"),
        ".diffuse.sigma: found a list, expected a number"
    );
}

#[test]
fn lines_are_those_of_the_keys() {
    let edits = [
        ("interface.alpha = 0.05", "interface.alpha = 5", "line 5, layer[0].interface.alpha: "),
        ("interface.dielectric.n", "interface.dielectric.x", "line 6, layer[0].interface.dielectric.x: "),
        ("medium.thickness = +0.4", "", "line 7, layer[0].medium.thickness: missing"),
        ("alpha = 3e-1", "", "line 11, layer[1].interface.alpha: missing"),
        ("alpha = 3e-1", "alpha = true", "line 12, layer[1].interface.alpha: found"),
        ("3.10", "-3.10", "line 16, layer[1].interface.conductor.n[1]: -3.1 is"),
        ("3.10", "'3'", "line 16, layer[1].interface.conductor.n[1]: found"),
        ("k = 0.19", "", "line 13, layer[1].interface.conductor.k: missing"),
        ("1], sigma = 0.5", "1],\n sigma = -0.5", "line 23, layer[2].interface.diffuse.sigma: -0.5 is"),
    ];
    for (from, to, expected) in edits {
        assert!(EVERYTHING.contains(from), "{from}");
        let text = EVERYTHING.replacen(from, to, 1);
        for text in [text.clone(), text.replace('\n', "\r\n")] {
            let message = refused(&text);
            assert!(message.starts_with(expected), "{message}, expected {expected}");
        }
    }
}

#[test]
fn what_is_not_toml_is_refused_with_the_line() {
    let message = refused(&EXAMPLE.replace("0.3 }", "0.3"));
    assert!(message.starts_with("line 7: not TOML: "), "{message}");
    let message = refused("name = \"a\"\nname = \"b\"\n");
    assert_eq!(message, "line 2: not TOML: duplicate key");
    assert_eq!(refused("name = \"a\nb\""), "line 1: not TOML: invalid basic string, expected `\"`");
    let expected = "line 2: not TOML: invalid unquoted key, expected letters, numbers, `-`, `_`";
    assert_eq!(refused("[[layer]]\n\u{0}"), expected);
}

/// A generator that is good enough to break files (Steele, Lea & Flood 2014, SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % end as u64) as usize
    }
}

/// Loads what may be anything: no panic, one line where it is refused, a valid stack where not.
fn load(bytes: &[u8]) -> bool {
    match Description::from_toml(&String::from_utf8_lossy(bytes)) {
        Ok(description) => {
            if description.channels() == 1 {
                description.stack::<f64, 1>().unwrap();
            }
            let _ = description.stack::<f32, 3>();
            true
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{:?}", error.to_string());
            false
        }
    }
}

#[test]
fn nothing_panics() {
    for text in [EXAMPLE, EVERYTHING] {
        for end in 0..text.len() {
            load(&text.as_bytes()[..end]);
        }
        // The bytes that TOML gives a meaning to, and some that it does not.
        let bytes = b"[]{}=.,\"'#\n\r\t \\0123456789-+_einfxtrualsmkdo\x00\x7f\x80\xff\xc3";
        let mut random = Random(1);
        let mut accepted = 0;
        for _ in 0..20_000 {
            let mut mutant = text.as_bytes().to_vec();
            for _ in 0..=random.below(4) {
                let at = random.below(mutant.len());
                let byte = bytes[random.below(bytes.len())];
                match random.below(4) {
                    0 => mutant[at] = byte,
                    1 => mutant.insert(at, byte),
                    2 => drop(mutant.remove(at)),
                    _ => {
                        let end = (at + random.below(20)).min(mutant.len());
                        let part = mutant[at..end].to_vec();
                        let to = random.below(mutant.len());
                        mutant.splice(to..to, part);
                    }
                }
            }
            accepted += usize::from(load(&mutant));
        }
        assert!((100..19_900).contains(&accepted), "{accepted} of 20000 mutants are stack files");
    }
}

#[test]
fn depth_and_length_do_no_harm() {
    let dotted = vec!["a"; 79].join(".");
    for text in [
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{ a = ".repeat(100_000)),
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        format!("layer = {}1{}", "[".repeat(79), "]".repeat(79)),
        // Keys within keys within tables, as deep as the parser lets pass.
        format!("[{dotted}]\n{dotted} = {}1{}", format!("{{ {dotted} = ").repeat(79), " }".repeat(79)),
        format!("a = {}", format!("{{ {dotted} = ").repeat(79)),
        format!("layer = [{}]", "{}, ".repeat(100_000)),
        format!("{} = 1", "a".repeat(1_000_000)),
    ] {
        assert!(Description::from_toml(&text).is_err());
    }
    let sigma = "1,".repeat(10_000);
    let long = format!(
        "[[layer]]\ninterface = {{ dielectric = {{ n = 1 }}, alpha = 1 }}\nmedium = {{ thickness = 1, sigma = [{sigma}] }}\n\
         [[layer]]\ninterface = {{ diffuse = {{ albedo = 1 }} }}"
    );
    assert_eq!(file(&long).channels(), 10_000);
}
