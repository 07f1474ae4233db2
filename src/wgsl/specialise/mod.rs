//! The WGSL of one stack, or of a scene of stacks: what their plans compute, and nothing else.
//!
//! Every stage of a [`Plan`] prints its statements, with its constants as literals: no loop over layers, no storage buffer, no
//! branch on what a layer is. Channels that share their directions are computed together, as vectors from where they differ.
//!
//! The formulas are those of the plan's stages without the low parts of sums, which WGSL has no exact way to carry: a
//! specialised module means what its plan means, and rounds as WGSL allows its own text to.

mod helper;

use crate::fresnel::Fit;
use crate::layered::Model;
use crate::plan::chain::{Chain, Stage, Surface, Way};
use crate::plan::interface::{AnyConductor, AnyDielectric, Conductor, Dielectric, Each, Fitted, Grey, Metal};
use crate::plan::stage::{Absorption, Base, Lobe, Passage};
use crate::plan::{Chains, Plan};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use helper::Helper;

/// The library's items that a specialised module may import, each with the path that it is called by.
const LIBRARY: [(&str, &str); 4] = [
    ("diffuse::", "brdf::diffuse"),
    ("exp_limit", "brdf::distribution::exp_limit"),
    ("fresnel::", "brdf::fresnel"),
    ("refracted_square(", "brdf::fresnel::refracted_square"),
];

/// The WGSL of a plan: a module with the function `name(wi: vec3f, wo: vec3f) -> vec3f`, f of a pair of local unit directions
/// above the horizon, else 0. [`link`](super::link) resolves its imports.
///
/// `name` must be an identifier of WGSL that does not begin with `plan_` or `_` ([`identifier`] makes one).
///
/// ```
/// use brdf::layered::{Interface, Layer, Model, Stack};
/// use brdf::plan::Plan;
/// use brdf::wgsl;
///
/// let copper = Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], 0.3));
/// let plan = Plan::new(&Stack::<f64, 3>::new(Model::Conserving, vec![copper])?)?;
/// let linked = wgsl::link(&wgsl::specialise(&plan, "copper"))?;
/// assert!(linked.contains("fn copper(wi: vec3f, wo: vec3f) -> vec3f"));
/// assert!(!linked.contains("for (") && !linked.contains("refract"));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn specialise(plan: &Plan<3>, name: &str) -> String {
    let mut module = Module::default();
    module.function(plan, name);
    module.finish()
}

/// The WGSL of a scene: a function for each plan under its name, and `scene(material: u32, wi: vec3f, wo: vec3f) -> vec3f`, f of
/// the plan at an index, 0 past the last. The functions share what they call; what no plan needs is not there.
///
/// Names as in [`specialise`], each different and none of them `scene`.
pub fn specialise_scene(plans: &[(&str, Plan<3>)]) -> String {
    let mut module = Module::default();
    let mut cases = String::new();
    for (index, (name, plan)) in plans.iter().enumerate() {
        module.function(plan, name);
        cases += &format!("        case {index}u: {{ return {name}(wi, wo); }}\n");
    }
    module.text += &format!(
        "\n// f of the material at this index.\nfn scene(material: u32, wi: vec3f, wo: vec3f) -> vec3f {{\n    switch material \
         {{\n{cases}        default: {{ return vec3f(0.0); }}\n    }}\n}}\n"
    );
    module.finish()
}

/// An identifier of WGSL from any name: other characters than letters, digits and `_` become `_`.
pub fn identifier(name: &str) -> String {
    let mut result: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    // No keyword has this ending, nor do names that naga would change.
    let fits = result.starts_with(|c: char| c.is_ascii_alphabetic()) && !result.starts_with("plan_");
    if !fits {
        result.insert_str(0, "stack_");
    }
    if result.ends_with(|c: char| c.is_ascii_digit()) || RESERVED.contains(&result.as_str()) {
        result.push_str("_stack");
    }
    result
}

/// Words that are no identifiers of a material's function, of those that a name may well be.
const RESERVED: [&str; 30] = [
    "scene", "wi", "wo", "f32", "vec3f", "select", "sqrt", "min", "max", "exp", "let", "var", "fn", "if", "else",
    "return", "switch", "case", "default", "struct", "alias", "const", "true", "false", "loop", "material", "brdf",
    "package", "glass", "metal",
];

/// A number as a literal of f32's range.
fn literal(x: f64) -> String {
    let most = f64::from(f32::MAX);
    let x = x.clamp(-most, most);
    // What f32 would take for 0 or a subnormal number is 0 on adapters that flush.
    format!("{x:?}")
}

/// A constant of each channel: one literal where all are equal.
fn constant<const K: usize>(values: [f64; K]) -> Value {
    let wide = values != [values[0]; K];
    Value { text: if wide { vector(values) } else { literal(values[0]) }, wide }
}

fn vector<const K: usize>(values: [f64; K]) -> String {
    if K == 1 { literal(values[0]) } else { format!("vec3f({})", values.map(literal).join(", ")) }
}

/// A value in the text, and whether it is a vector over the channels.
#[derive(Clone, Debug)]
struct Value {
    text: String,
    wide: bool,
}

impl Value {
    fn narrow(text: impl Into<String>) -> Self {
        Value { text: text.into(), wide: false }
    }
}

/// Calls a helper: with vectors where any constant differs between the channels.
macro_rules! call {
    ($function:expr, $helper:ident, ($($argument:expr),*), $($constants:expr),*) => {{
        let lists = [$($constants),*];
        let wide = lists.iter().any(|values| values.iter().any(|x| *x != values[0]));
        let mut arguments: Vec<String> = alloc::vec![$($argument.to_string()),*];
        arguments.extend(lists.iter().map(|values| if wide { vector(*values) } else { literal(values[0]) }));
        let name = $function.helper(&helper::$helper, wide);
        Value { text: format!("{name}({})", arguments.join(", ")), wide }
    }};
}

/// A module in the making.
#[derive(Default)]
struct Module {
    /// The helpers in use, each over numbers or over vectors.
    helpers: Vec<(&'static Helper, bool)>,
    text: String,
}

impl Module {
    fn function(&mut self, plan: &Plan<3>, name: &str) {
        match plan.chains() {
            Chains::Together(chain) => {
                let about = "// f in sr⁻¹; 0 at and below the horizon.";
                self.chain(chain, &format!("\n{about}\nfn {name}(wi: vec3f, wo: vec3f) -> vec3f {{\n"), true);
            }
            Chains::Apart(chains) => {
                let mut calls = Vec::new();
                for (chain, channel) in chains.iter().zip(["red", "green", "blue"]) {
                    self.chain(chain, &format!("\nfn {name}_{channel}(wi: vec3f, wo: vec3f) -> f32 {{\n"), false);
                    calls.push(format!("{name}_{channel}(wi, wo)"));
                }
                self.text += &format!(
                    "\n// f in sr⁻¹ of channels that refract differently; 0 at and below the horizon.\n\
                     fn {name}(wi: vec3f, wo: vec3f) -> vec3f {{\n    return vec3f({});\n}}\n",
                    calls.join(", ")
                );
            }
        }
    }

    fn chain<const K: usize>(&mut self, chain: &Chain<K>, head: &str, rgb: bool) {
        self.text += head;
        let mut function = Function::new(self);
        for stage in &chain.stages {
            function.stage(stage);
        }
        function.finish(rgb);
    }

    /// The imports, the helpers, and the functions.
    fn finish(self) -> String {
        let mut body = String::new();
        for (helper, wide) in &self.helpers {
            body += "\n";
            body += &helper.text(*wide);
        }
        body += &self.text;
        let mut text = String::new();
        for (call, path) in LIBRARY {
            if body.contains(call) {
                text += &format!("import {path};\n");
            }
        }
        text + &body
    }
}

/// A function over the channels of a chain in the making: the names of what a [`Ray`](crate::plan::stage::Ray) holds.
struct Function<'a> {
    module: &'a mut Module,
    /// Counts the media, for names.
    medium: usize,
    /// n·cosθ of both directions, and their sum.
    cos_i: String,
    cos_o: String,
    h_z: String,
    /// (n·VH)².
    half_squared: String,
    /// tan² of the half vector, and (n·VH)²/h_z; empty where they have not been computed yet.
    tan: String,
    edge: String,
    weight: Option<Value>,
    f: Option<Value>,
}

impl<'a> Function<'a> {
    fn new(module: &'a mut Module) -> Self {
        module.text += "    let lit = min(wi.z, wo.z) > 1e-18;
    let cos_i = select(1.0, wi.z, lit);
    let cos_o = select(1.0, wo.z, lit);
    let h_x = wi.x + wo.x;
    let h_y = wi.y + wo.y;
    let across = h_x * h_x + h_y * h_y;
    let h_z = cos_i + cos_o;
    let half_squared = 0.25 * (h_z * h_z + across);
";
        let name = |name: &str| name.to_string();
        Function {
            module,
            medium: 0,
            cos_i: name("cos_i"),
            cos_o: name("cos_o"),
            h_z: name("h_z"),
            half_squared: name("half_squared"),
            tan: String::new(),
            edge: String::new(),
            weight: None,
            f: None,
        }
    }

    fn line(&mut self, line: impl AsRef<str>) {
        self.module.text += "    ";
        self.module.text += line.as_ref();
        self.module.text += "\n";
    }

    /// Declares a name of the present medium.
    fn declare(&mut self, name: &str, value: &str) -> String {
        let full = self.name(name);
        self.line(format!("let {full} = {value};"));
        full
    }

    /// A name in the present medium.
    fn name(&self, name: &str) -> String {
        if self.medium == 0 { name.to_string() } else { format!("m{}_{name}", self.medium) }
    }

    fn helper(&mut self, helper: &'static Helper, wide: bool) -> String {
        let used = (helper, wide);
        if !self.module.helpers.contains(&used) {
            self.module.helpers.push(used);
        }
        helper.full_name(wide)
    }

    fn finish(mut self, rgb: bool) {
        let zero = if rgb { "vec3f(0.0)" } else { "0.0" };
        match self.f.take() {
            None => self.line(format!("return {zero};")),
            Some(f) if rgb && !f.wide => self.line(format!("return vec3f(select(0.0, {}, lit));", f.text)),
            Some(f) => self.line(format!("return select({zero}, {}, lit);", f.text)),
        }
        self.module.text += "}\n";
    }

    /// tan² of the half vector and the edge of its cavity, where they are not there yet.
    fn aim(&mut self) {
        if !self.edge.is_empty() {
            return;
        }
        let inverse = self.declare("inverse_z", &format!("1.0 / {}", self.h_z));
        if self.tan.is_empty() {
            self.tan = self.declare("tan_squared", &format!("across * ({inverse} * {inverse})"));
        }
        self.edge = self.declare("edge", &format!("{} * {inverse}", self.half_squared));
    }

    /// n·VH and its square, at most n.
    fn half(&mut self, n: f64) -> (String, String) {
        let squared = format!("min({}, {})", self.half_squared, literal(n * n));
        let squared = self.declare("vh_squared", &squared);
        let half = self.declare("vh", &format!("sqrt({squared})"));
        (squared, half)
    }

    /// Adds to f what is reflected, times the weight.
    fn add(&mut self, name: &str, value: Value) {
        let (mut text, mut wide) = (value.text, value.wide);
        if let Some(weight) = &self.weight {
            text = format!("{} * {text}", weight.text);
            wide |= weight.wide;
        }
        if let Some(f) = &self.f {
            // A sum of a number and a vector is one of vectors.
            text = format!("{} + {text}", f.text);
            wide |= f.wide;
        }
        let text = self.declare(name, &text);
        self.f = Some(Value { text, wide });
    }

    /// Multiplies the weight.
    fn weigh(&mut self, name: &str, through: Value) {
        let (text, wide) = match &self.weight {
            Some(weight) => (format!("{} * {}", weight.text, through.text), weight.wide || through.wide),
            None => (through.text, through.wide),
        };
        let text = self.declare(name, &text);
        self.weight = Some(Value { text, wide });
    }

    /// Ends the light where a condition does not hold.
    fn stop_unless(&mut self, goes_on: &str) {
        if let Some(Value { text, wide }) = self.weight.take() {
            let zero = if wide { "vec3f(0.0)" } else { "0.0" };
            let text = self.declare("arriving", &format!("select({zero}, {text}, {goes_on})"));
            self.weight = Some(Value { text, wide });
        }
    }

    fn stage<const K: usize>(&mut self, stage: &Stage<K>) {
        match stage {
            Stage::Reflect { lobe, surface } => self.reflect(lobe, surface),
            Stage::Pass { passage, way, model: Model::Elek } => {
                self.documents(passage, way);
                if let Some(goes_on) = self.refract(passage) {
                    self.stop_unless(&goes_on);
                }
            }
            Stage::Pass { passage, way, model: Model::WeidlichWilkie } => {
                self.documents(passage, way);
                self.refract_about(passage);
            }
            Stage::Pass { passage, way, .. } => self.conserve(passage, way),
            Stage::Absorb(medium) => self.absorb(medium),
            Stage::Lambert(base) => {
                let f = base.albedo.map(|albedo| albedo * base.scale() * core::f64::consts::FRAC_1_PI);
                self.add("f_base", constant(f));
            }
            Stage::OrenNayar { base, about_half } => self.oren_nayar(base, *about_half),
        }
    }

    fn reflect<const K: usize>(&mut self, lobe: &Lobe, surface: &Surface<K>) {
        self.aim();
        let (inverse_square, scale) = ([lobe.inverse_square], [lobe.scale]);
        let [tan, edge, cos_i, cos_o] = [&self.tan, &self.edge, &self.cos_i, &self.cos_o].map(String::clone);
        let shape = call!(self, LOBE, (tan, edge, cos_i, cos_o), inverse_square, scale);
        let shape = self.declare("lobe", &shape.text);
        let fresnel = self.reflectance(surface, lobe.n_above);
        self.add("f", Value { text: format!("({shape} * {})", fresnel.text), wide: fresnel.wide });
    }

    /// F of an interface at V·H.
    fn reflectance<const K: usize>(&mut self, surface: &Surface<K>, n_above: f64) -> Value {
        let (squared, vh) = self.half(n_above);
        let above = literal(n_above * n_above);
        match surface {
            Surface::Dielectric(Dielectric { step, square, above }) => {
                call!(self, DIELECTRIC, (squared, vh), [*step], [*square], [*above])
            }
            Surface::AnyDielectric(any) => Value::narrow(format!("{}.reflectance", any_dielectric(&vh, any))),
            Surface::GreyMetal(Grey(metal)) => self.metals([*metal], &squared, &vh, &above),
            Surface::Metals(Each(metals)) => self.metals(*metals, &squared, &vh, &above),
            Surface::Conductors(Each(conductors)) => {
                let offset = conductors.map(|Conductor { real, .. }| real);
                let product = conductors.map(|Conductor { product, .. }| product);
                let twice_squared = product.map(|product| 4.0 * product * product);
                call!(self, CONDUCTOR, (squared, vh, above), offset, product, twice_squared)
            }
            Surface::AnyConductors(Each(all)) => {
                each(all, |one| format!("{}.reflectance", any_conductor(&optical(&vh, one.n_above), one)))
            }
            Surface::Fit8(fit) => self.one_less(fit, &vh),
            Surface::Fit10(fit) => self.one_less(fit, &vh),
            Surface::Fit12(fit) => self.one_less(fit, &vh),
        }
    }

    fn metals<const K: usize>(&mut self, metals: [Metal; K], squared: &str, vh: &str, above: &str) -> Value {
        let half_real = metals.map(|metal| metal.half_real);
        let product_squared = metals.map(|metal| metal.product * metal.product);
        let twice_product = metals.map(|metal| 2.0 * metal.product);
        call!(self, METAL, (squared, vh, above), half_real, product_squared, twice_product)
    }

    /// 1 - T of a fit at an optical cosine.
    fn one_less<const K: usize, const N: usize>(&mut self, fitted: &Fitted<K, N>, vh: &str) -> Value {
        let fitted = self.fit("fit_vh", &fitted.fit, &optical(vh, fitted.n_above));
        Value { text: format!("(1.0 - {})", fitted.text), wide: fitted.wide }
    }

    /// T of a fit at a cosine.
    fn fit<const K: usize, const N: usize>(&mut self, name: &str, fit: &Fit<K, N>, cosine: &str) -> Value {
        let stretched = call!(self, STRETCHED, (cosine), [fit.bend], [1.0 + fit.bend]);
        let t = self.declare(&format!("{name}_t"), &stretched.text);
        let u = self.declare(&format!("{name}_u"), &format!("2.0 * {t} - 1.0"));
        let (last, others) = match fit.coefficients.split_last() {
            Some((last, others)) => (vector(*last), others),
            None => (vector([0.0; K]), &[][..]),
        };
        let open = "(".repeat(others.len());
        let rest: String = others.iter().rev().map(|row| format!(" * {u} + {})", vector(*row))).collect();
        let unit = if K == 1 { ("0.0", "1.0") } else { ("vec3f(0.0)", "vec3f(1.0)") };
        let text = self.declare(name, &format!("clamp({t} * {open}{last}{rest}, {}, {})", unit.0, unit.1));
        Value { text, wide: K > 1 }
    }

    /// The energy-conserving way: the transmittance of either direction.
    fn conserve<const K: usize>(&mut self, passage: &Passage, way: &Way<K>) {
        let above = [self.cos_i.clone(), self.cos_o.clone()];
        let goes_on = self.refract(passage);
        let below = [self.cos_i.clone(), self.cos_o.clone()];
        let through = match way {
            Way::Dielectric(Dielectric { square, above: n, .. }) => {
                let mut one =
                    |at: usize| call!(self, TRANSMITTED, (above[at], below[at]), [*square], [*n], [square * n]).text;
                Value::narrow(format!("({} * {})", one(0), one(1)))
            }
            Way::AnyDielectric(any) => {
                let one = |cosine: &String| format!("{}.transmittance", any_dielectric(cosine, any));
                Value::narrow(format!("({} * {})", one(&above[0]), one(&above[1])))
            }
            Way::AnyConductors(Each(all)) => each(all, |one| {
                let split = |cosine: &String| any_conductor(&optical(cosine, one.n_above), one);
                format!("({}.transmittance * {}.transmittance)", split(&above[0]), split(&above[1]))
            }),
            Way::Fit8(fit) => self.both(fit, &above),
            Way::Fit10(fit) => self.both(fit, &above),
            Way::Fit12(fit) => self.both(fit, &above),
        };
        self.weigh("weight", through);
        if let Some(goes_on) = goes_on {
            self.stop_unless(&goes_on);
        }
    }

    fn both<const K: usize, const N: usize>(&mut self, fitted: &Fitted<K, N>, above: &[String; 2]) -> Value {
        let i = self.fit("fit_i", &fitted.fit, &optical(&above[0], fitted.n_above));
        let o = self.fit("fit_o", &fitted.fit, &optical(&above[1], fitted.n_above));
        Value { text: format!("({} * {})", i.text, o.text), wide: i.wide }
    }

    /// What the documents let through: T·t, both at V·H.
    fn documents<const K: usize>(&mut self, passage: &Passage, way: &Way<K>) {
        self.aim();
        let (cos_i, cos_o, edge) = (self.cos_i.clone(), self.cos_o.clone(), self.edge.clone());
        let (squared, vh) = self.passed_half();
        let cosine = optical(&vh, passage.n_above);
        let transmitted = match way {
            Way::Dielectric(Dielectric { square, above, step }) => {
                let below = format!("sqrt({squared} + {})", literal(*step));
                call!(self, TRANSMITTED, (vh, below), [*square], [*above], [square * above])
            }
            Way::AnyDielectric(any) => Value::narrow(format!("{}.transmittance", any_dielectric(&vh, any))),
            Way::AnyConductors(Each(all)) => {
                each(all, |one| format!("{}.transmittance", any_conductor(&optical(&vh, one.n_above), one)))
            }
            Way::Fit8(fit) => self.fit("fit", &fit.fit, &cosine),
            Way::Fit10(fit) => self.fit("fit", &fit.fit, &cosine),
            Way::Fit12(fit) => self.fit("fit", &fit.fit, &cosine),
        };
        let internal = self.helper(&helper::INTERNAL, transmitted.wide);
        let text = format!("{internal}({}, {cos_i}, {cos_o}, {edge})", transmitted.text);
        self.weigh("weight", Value { text, wide: transmitted.wide });
    }

    /// The half vector's length as the interface that is passed has declared it.
    fn passed_half(&self) -> (String, String) {
        (self.name("vh_squared"), self.name("vh"))
    }

    /// Refracts both directions about the macro normal. The condition that they go on, where they may not.
    fn refract(&mut self, passage: &Passage) -> Option<String> {
        self.medium += 1;
        let goes_on = if passage.excess >= 0.0 {
            let below = |cosine: &str| format!("sqrt({cosine} * {cosine} + {})", literal(passage.excess));
            self.cos_i = self.declare("cos_i", &below("cos_i"));
            self.cos_o = self.declare("cos_o", &below("cos_o"));
            None
        } else {
            let n = literal(passage.n);
            let i = self.declare("square_i", &format!("refracted_square(cos_i, {n})"));
            let o = self.declare("square_o", &format!("refracted_square(cos_o, {n})"));
            let goes_on = self.declare("goes_on", &format!("min({i}, {o}) > 0.0"));
            self.cos_i = self.declare("cos_i", &format!("sqrt(select(1.0, {i}, {goes_on}))"));
            self.cos_o = self.declare("cos_o", &format!("sqrt(select(1.0, {o}, {goes_on}))"));
            Some(goes_on)
        };
        self.h_z = self.declare("h_z", &format!("{} + {}", self.cos_i, self.cos_o));
        self.half_squared = self.declare("half_squared", &format!("0.25 * ({0} * {0} + across)", self.h_z));
        self.tan.clear();
        self.edge.clear();
        goes_on
    }

    /// Refracts both directions about the half vector, whose direction stays.
    fn refract_about(&mut self, passage: &Passage) {
        let (squared, vh) = self.passed_half();
        let (cos_i, cos_o, h_z) = (self.cos_i.clone(), self.cos_o.clone(), self.h_z.clone());
        self.medium += 1;
        let below_squared = self.declare("below_squared", &format!("{squared} + {}", literal(passage.step)));
        let ratio = self.declare("ratio", &format!("sqrt(max({below_squared}, 0.0)) / {vh}"));
        let lift = self.declare("lift", &format!("0.5 * {h_z} * ({ratio} - 1.0)"));
        let i = self.declare("lifted_i", &format!("{cos_i} + {lift}"));
        let o = self.declare("lifted_o", &format!("{cos_o} + {lift}"));
        let goes_on = self.declare("goes_on", &format!("min({below_squared}, min({i}, {o})) > 0.0"));
        self.cos_i = self.declare("cos_i", &format!("select(1.0, {i}, {goes_on})"));
        self.cos_o = self.declare("cos_o", &format!("select(1.0, {o}, {goes_on})"));
        self.h_z = self.declare("h_z", &format!("select(1.0, {h_z} * {ratio}, {goes_on})"));
        self.half_squared = self.declare("half_squared", &format!("select(1.0, {below_squared}, {goes_on})"));
        self.edge.clear();
        self.stop_unless(&goes_on);
    }

    fn absorb<const K: usize>(&mut self, medium: &Absorption<K>) {
        let path = self.declare("path", &format!("{} / ({} * {})", self.h_z, self.cos_i, self.cos_o));
        let absorbed = call!(self, ABSORBED, (path), medium.depth);
        self.weigh("dimmed", absorbed);
    }

    fn oren_nayar<const K: usize>(&mut self, base: &Base<K>, about_half: bool) {
        let inverse = literal(1.0 / base.n_above);
        let moved = about_half && self.medium > 0;
        if moved {
            let length = self.declare("length_above", "sqrt(half_squared)");
            let bend = format!("0.5 * (sqrt({}) - {length}) / {length}", self.half_squared);
            self.declare("bend", &bend);
        }
        let bend = self.name("bend");
        let (cos_i, cos_o) = (self.cos_i.clone(), self.cos_o.clone());
        let mut below = |w: &str, cosine: &str| {
            let across = |axis: &str| match moved {
                true => format!("({w}.{axis} + h_{axis} * {bend}) * {inverse}"),
                false => format!("{w}.{axis} * {inverse}"),
            };
            let direction = format!("vec3f({}, {}, {cosine} * {inverse})", across("x"), across("y"));
            self.declare(&format!("{w}_below"), &direction)
        };
        let (wi, wo) = (below("wi", &cos_i), below("wo", &cos_o));
        let shape = format!("diffuse::oren_nayar({wi}, {wo}, {})", literal(base.sigma));
        let shape = self.declare("shape", &shape);
        let share = base.albedo.map(|albedo| albedo * base.scale() * core::f64::consts::FRAC_1_PI);
        let f = call!(self, BASE, (shape), base.albedo, share);
        self.add("f_base", f);
    }
}

/// The cosine of an optical one.
fn optical(cosine: &str, n_above: f64) -> String {
    if n_above == 1.0 { cosine.to_string() } else { format!("{cosine} * {}", literal(1.0 / n_above)) }
}

fn any_dielectric(cosine: &str, any: &AnyDielectric) -> String {
    format!("fresnel::dielectric({}, {})", optical(cosine, any.n_above), literal(any.eta))
}

fn any_conductor(cosine: &str, any: &AnyConductor) -> String {
    format!("fresnel::conductor({cosine}, {}, {})", literal(any.eta), literal(any.kappa))
}

/// A term of each channel: one where all are equal.
fn each<T: PartialEq, const K: usize>(all: &[T; K], one: impl Fn(&T) -> String) -> Value {
    if all.iter().all(|other| *other == all[0]) {
        return Value::narrow(one(&all[0]));
    }
    let parts: Vec<String> = all.iter().map(one).collect();
    Value { text: format!("vec3f({})", parts.join(", ")), wide: true }
}
