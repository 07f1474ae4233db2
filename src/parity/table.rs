//! Every public WGSL function with the Rust function that is its twin and the inputs they are compared on.

use super::draw::Draw;
use super::textures;
use crate::frame::Vector;
use crate::gpu::{StackBuffers, StackPlace};
use crate::interval::WgslInterval;
use crate::layered::{self, Interface, Layer, Model, Stack};
use crate::material::{brushed, flake, glint, kubelka_munk, metal::METALS, patina, stack::built_in};
use crate::real::Real;
use crate::table::{DistributionTable, ENTRIES, FresnelTable, Mapping, SIDE};
use crate::{
    absorption, diffuse, distribution, fresnel, masking, microfacet, phong, random, refraction, sampling, walk,
};
use std::sync::OnceLock;

/// How a twin's results are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judge {
    /// Each result lies in the interval that WGSL's rules allow.
    Allowed,
    /// The two results are a rounded value and its error, whose sum is exact.
    ErrorFree,
}

/// A WGSL function and its Rust twin over three number types. Arguments and results are flat, in order of declaration.
#[derive(Clone, Copy, Debug)]
pub struct Twin {
    /// The module of `wgsl/`.
    pub module: &'static str,
    /// The name of the function in both languages.
    pub function: &'static str,
    /// How many parameters both functions take; a stack counts as two, its first layer and its length.
    pub arity: usize,
    /// How results are judged.
    pub judge: Judge,
    /// The arguments of a sample.
    pub sample: fn(&mut Draw) -> Vec<f64>,
    /// The Rust function in f32.
    pub single: fn(&[f32]) -> Vec<f32>,
    /// The Rust function in f64: the oracle.
    pub double: fn(&[f64]) -> Vec<f64>,
    /// The Rust function under WGSL's accuracy rules: the tolerance.
    pub allowed: fn(&[WgslInterval]) -> Vec<WgslInterval>,
}

macro_rules! twin {
    ($module:ident::$function:ident / $arity:literal, $judge:ident, $sample:expr, |$a:ident| $body:expr) => {{
        fn evaluate<R: Real>($a: &[R]) -> Vec<R> {
            Vec::from($body)
        }
        Twin {
            module: stringify!($module),
            function: stringify!($function),
            arity: $arity,
            judge: Judge::$judge,
            sample: $sample,
            single: evaluate::<f32>,
            double: evaluate::<f64>,
            allowed: evaluate::<WgslInterval>,
        }
    }};
    ($module:ident::$function:ident / $arity:literal, $sample:expr, |$a:ident| $body:expr) => {
        twin!($module::$function / $arity, Allowed, $sample, |$a| $body)
    };
}

/// The vector that starts at an argument.
pub(super) fn at<R: Real>(arguments: &[R], start: usize) -> Vector<R> {
    Vector::new(arguments[start], arguments[start + 1], arguments[start + 2])
}

/// Numbers and vectors as one flat list.
macro_rules! flat {
    ($($value:expr),+ $(,)?) => {{
        let mut list = Vec::new();
        $(Flat::extend($value, &mut list);)+
        list
    }};
}

pub(super) trait Flat {
    fn extend(self, list: &mut Vec<f64>);
}
impl Flat for f64 {
    fn extend(self, list: &mut Vec<f64>) {
        list.push(self);
    }
}
impl Flat for Vector<f64> {
    fn extend(self, list: &mut Vec<f64>) {
        list.extend([self.x, self.y, self.z]);
    }
}
impl<T: Flat, const N: usize> Flat for [T; N] {
    fn extend(self, list: &mut Vec<f64>) {
        self.into_iter().for_each(|value| value.extend(list));
    }
}

fn split<R: Real>(f: fresnel::Fresnel<R>) -> [R; 2] {
    [f.reflectance, f.transmittance]
}

fn shadow<R: Real>(m: masking::Masking<R>) -> [R; 2] {
    [m.g, m.visibility]
}

fn pair<R: Real>(p: walk::Pair<R>) -> [R; 3] {
    [p.lobe, p.density, p.cos_a]
}

/// A cosine and the rows of the fit of a built-in metal or a dielectric.
fn fit_arguments<const N: usize>(d: &mut Draw) -> Vec<f64> {
    static FITS: OnceLock<[Vec<Vec<f64>>; 2]> = OnceLock::new();
    fn rows<const N: usize>() -> Vec<Vec<f64>> {
        let metals = METALS.iter().map(|metal| (metal.n, metal.k));
        let dielectrics = [1.01, 1.33, 1.5, 2.42].map(|n| ([n; 3], [0.0; 3]));
        let fits = metals.chain(dielectrics).flat_map(|(n, k)| fresnel::Fit::<3, N>::new(n, k));
        fits.map(|fit| fit.rows().into_iter().flatten().map(f64::from).collect()).collect()
    }
    let fits = &FITS.get_or_init(|| [rows::<8>(), rows::<12>()])[usize::from(N == 12)];
    let mut arguments = flat![d.cosine()];
    arguments.extend(&fits[((d.unit() * fits.len() as f64) as usize).min(fits.len() - 1)]);
    arguments
}

/// Reflectance and transmittance from a cosine and the rows of a fit.
fn fitted<R: Real, const N: usize>(a: &[R]) -> Vec<R> {
    let number = |place: usize| a[1 + place].to_f64();
    let coefficients = std::array::from_fn(|i| std::array::from_fn(|channel| number(4 * i + channel)));
    let split = fresnel::Fit::<3, N> { bend: number(3), coefficients, max_error: [0.0; 3] }.evaluate(a[0]);
    split.iter().map(|f| f.reflectance).chain(split.iter().map(|f| f.transmittance)).collect()
}

pub(super) fn coordinates<R: Real>(v: Vector<R>) -> [R; 3] {
    v.into()
}

/// Two directions and the cosines and half vector that the masking terms take.
fn cosines_and_half(d: &mut Draw) -> Vec<f64> {
    let width = d.width();
    let [wi, wo] = d.pair(width).map(|w| w.cast::<f32>());
    // The half vector of the rounded directions, as a shader would form it.
    flat![f64::from(wi.z), f64::from(wo.z), (wi + wo).cast::<f64>()]
}

fn pair_and_widths(d: &mut Draw) -> Vec<f64> {
    let (x, y) = (d.width(), d.width());
    flat![d.pair(x.max(y)), x, y]
}

fn pair_metal_and_widths(d: &mut Draw) -> Vec<f64> {
    let (x, y) = (d.width(), d.width());
    let (n, k) = ([d.index(), d.index(), d.index()], [d.extinction(), d.extinction(), d.extinction()]);
    flat![d.pair(x.max(y)), n, k, x, y]
}

/// The words of a cell, a number of flakes, and a leaf of a square of leaves.
fn flakes_of_a_leaf(d: &mut Draw) -> Vec<f64> {
    let (resolution, count) = (1.0 + (8.0 * d.unit()).floor(), d.between(0.0, 400.0));
    let mut index = || (resolution.exp2() * d.unit()).floor();
    let (column, row) = (index(), index());
    flat![[d.word(), d.word(), d.word(), d.word()], count, resolution, column, row]
}

/// A half vector and its width, flakes, a place and a footprint. No count or ratio of lengths is a whole number, at which the
/// rules leave open to which side rounding falls.
fn half_flakes_and_place(d: &mut Draw) -> Vec<f64> {
    let (width, spacing) = (d.width(), 0.01 + d.unit());
    let (count, resolution) = (0.3 + 3.0 * d.unit(), 1.0 + (6.0 * d.unit()).floor());
    let position = [d.between(-3.0, 3.1), d.between(-3.0, 3.1), d.between(-3.0, 3.1)];
    let footprint = spacing * 10f64.powf(3.0 * d.unit() - 0.5);
    flat![d.half_vector(width), width, spacing, count, resolution, d.word(), position, footprint]
}

fn half_and_width(d: &mut Draw) -> Vec<f64> {
    let width = d.width();
    flat![d.half_vector(width), width]
}

fn half_and_widths(d: &mut Draw) -> Vec<f64> {
    let (x, y) = (d.width(), d.width());
    flat![d.half_vector(x.max(y)), x, y]
}

/// A stack's first layer and length, and a pair of directions on the scale of its narrowest lobe.
fn stack_and_pair(d: &mut Draw) -> Vec<f64> {
    let (stack, place) = pick_stack(d);
    flat![f64::from(place.first), f64::from(place.count), d.pair(narrowest(stack.layers()))]
}

/// The width of the narrowest lobe of a stack, 1 where it has none.
pub(super) fn narrowest(layers: &[Layer<f32, 3>]) -> f64 {
    let width = |layer: &Layer<f32, 3>| match layer.interface {
        Interface::Microfacet { alpha, .. } => f64::from(alpha),
        Interface::Diffuse { .. } => 1.0,
    };
    layers.iter().map(width).fold(1.0, f64::min)
}

/// As [`stack_and_pair`], with the first row of the stack's table.
fn stack_table_and_pair(d: &mut Draw) -> Vec<f64> {
    let mut arguments = stack_and_pair(d);
    let table = coupled_table().place(arguments[0]).map_or(0, |(_, place)| place.table);
    arguments.insert(2, f64::from(table));
    arguments
}

fn stack_channel_and_pair(d: &mut Draw) -> Vec<f64> {
    let mut arguments = stack_and_pair(d);
    let channel = (d.unit() * 3.0).floor();
    arguments.insert(2, channel);
    arguments
}

/// As [`stack_and_pair`], under any of the models that sampling knows.
fn stack_model_and_pair(d: &mut Draw) -> Vec<f64> {
    let mut arguments = stack_and_pair(d);
    arguments.insert(2, (4.0 * d.unit()).floor());
    arguments
}

fn stack_model_and_view(d: &mut Draw) -> Vec<f64> {
    let mut arguments = stack_model_and_pair(d);
    arguments.truncate(6);
    arguments
}

fn stack_view_and_numbers(d: &mut Draw) -> Vec<f64> {
    let mut arguments = stack_model_and_view(d);
    arguments.extend(numbers(d));
    arguments
}

/// What a sample is made of.
fn numbers(d: &mut Draw) -> [f64; 3] {
    [d.number(), d.number(), d.number()]
}

/// The model that the constants of `wgsl/sampling.wgsl` name.
fn model<R: Real>(argument: R) -> Model {
    [Model::Conserving, Model::WeidlichWilkie, Model::Elek, Model::Coupled][argument.to_f64() as usize]
}

fn pick_stack(d: &mut Draw) -> &'static (Stack<f32, 3>, StackPlace) {
    let all = &stack_table().stacks;
    &all[((d.unit() * all.len() as f64) as usize).min(all.len() - 1)]
}

/// The stacks that are compared, and where they lie in the buffers that twins read.
#[derive(Default)]
struct StackTable {
    buffers: StackBuffers,
    stacks: Vec<(Stack<f32, 3>, StackPlace)>,
}

impl StackTable {
    fn new(model: Model) -> Self {
        let mut table = StackTable::default();
        let built_in = built_in().into_iter().map(|material| material.stack.cast::<f32>().with_model(model));
        let corners = corner_stacks().into_iter().flat_map(|layers| Stack::new(model, layers));
        for stack in built_in.chain(corners) {
            let place = table.buffers.push(&stack);
            table.stacks.push((stack, place));
        }
        table
    }

    /// The stack whose first layer has this index.
    fn place(&self, first: f64) -> Option<&(Stack<f32, 3>, StackPlace)> {
        self.stacks.iter().find(|(_, place)| f64::from(place.first) == first)
    }
}

fn stack_table() -> &'static StackTable {
    static TABLE: OnceLock<StackTable> = OnceLock::new();
    TABLE.get_or_init(|| StackTable::new(Model::Conserving))
}

/// The same stacks with their tables, whose walks take seconds.
fn coupled_table() -> &'static StackTable {
    static TABLE: OnceLock<StackTable> = OnceLock::new();
    TABLE.get_or_init(|| StackTable::new(Model::Coupled))
}

/// What a linked twin reads of the stacks and texels that are compared.
pub fn buffers(source: &str) -> &'static StackBuffers {
    if source.contains("coupled_row(") {
        &coupled_table().buffers
    } else if source.contains("fresnel_texel(") || source.contains("distribution_texel(") {
        let mapping = if source.contains("_over_root(") { Mapping::Root } else { Mapping::Angle };
        &texel_table(mapping).buffers
    } else if source.contains("material_texel(") || source.contains("ramp_stop(") {
        textures::buffers()
    } else {
        &stack_table().buffers
    }
}

/// Tables of F and of D of a mapping that are compared, and their texels.
struct TexelTable {
    buffers: StackBuffers,
    fresnel: Vec<FresnelTable<3>>,
    distribution: Vec<DistributionTable>,
}

impl TexelTable {
    fn new(mapping: Mapping, columns: usize, rows: usize, least: f64) -> Self {
        let metals = METALS.iter().map(|metal| (metal.n, metal.k));
        let dielectrics = [1.01, 1.33, 2.42].map(|n| ([n; 3], [0.0; 3]));
        let materials = metals.chain(dielectrics).zip([ENTRIES, ENTRIES, 37, 2].into_iter().cycle());
        let fresnel = materials.flat_map(|((n, k), entries)| FresnelTable::new(n, k, entries, mapping)).collect();
        let distribution = DistributionTable::new(columns, rows, least, mapping).into_iter().collect();
        let mut table = TexelTable { buffers: StackBuffers::default(), fresnel, distribution };
        // Smaller tables too lie in rows as long as those of the printed ones.
        for (row, one) in (1..).zip(&table.fresnel) {
            let texels = one.entries().iter().map(|[r, g, b]| [*r, *g, *b, 1.0].map(f64::from));
            table.buffers.fresnel.extend(texels);
            table.buffers.fresnel.resize(row * ENTRIES, [0.0; 4]);
        }
        let texels = table.distribution.iter().flat_map(|one| one.texels().chunks(columns));
        for (row, texels) in (1..).zip(texels) {
            table.buffers.distribution.extend(texels.iter().copied().map(f64::from));
            table.buffers.distribution.resize(row * SIDE, 0.0);
        }
        table
    }
}

fn texel_table(mapping: Mapping) -> &'static TexelTable {
    static TABLES: [OnceLock<TexelTable>; 2] = [const { OnceLock::new() }; 2];
    match mapping {
        Mapping::Angle => TABLES[0].get_or_init(|| TexelTable::new(mapping, SIDE, SIDE, 2.3e-3)),
        Mapping::Root => TABLES[1].get_or_init(|| TexelTable::new(mapping, 300, 200, 1e-4)),
    }
}

/// A cosine, the row of a table of F and its entries.
fn cosine_and_row(d: &mut Draw, mapping: Mapping) -> Vec<f64> {
    let tables = &texel_table(mapping).fresnel;
    let row = ((d.unit() * tables.len() as f64) as usize).min(tables.len() - 1);
    flat![d.fraction(), row as f64, tables[row].entries().len() as f64]
}

fn tabulated_fresnel<R: Real>(a: &[R], mapping: Mapping) -> [R; 3] {
    texel_table(mapping).fresnel[a[1].to_f64() as usize].reflectance(a[0])
}

/// A half vector, a width, and the shape of the table of D.
fn half_width_and_shape(d: &mut Draw, mapping: Mapping) -> Vec<f64> {
    let mut arguments = half_and_width(d);
    for shape in texel_table(mapping).distribution.iter().map(DistributionTable::shape) {
        arguments.extend(flat![f64::from(shape.columns), f64::from(shape.rows)]);
        arguments.extend(flat![f64::from(shape.least), f64::from(shape.rate)]);
    }
    arguments
}

fn tabulated_distribution<R: Real>(a: &[R], mapping: Mapping) -> Vec<R> {
    texel_table(mapping).distribution.iter().map(|table| table.evaluate(at(a, 0), a[3])).collect()
}

/// The value of the coupled model; 0 where no stack begins at `first`.
fn coupled<R: Real>(first: R, wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let found = coupled_table().place(first.to_f64());
    found.map_or([R::ZERO; 3], |(stack, _)| stack.cast::<R>().evaluate(wi, wo))
}

/// Stacks that the built-in ones leave out: matched indices, total reflection, smooth over rough, five layers.
fn corner_stacks() -> [Vec<Layer<f32, 3>>; 5] {
    let coat = |n, alpha| Layer::new(Interface::dielectric(n, alpha));
    let metal = |alpha| Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], alpha));
    [
        vec![coat(1.0, 0.1), metal(0.3)],
        vec![coat(1.5, 0.1), coat(1.0, 0.2), metal(0.3)],
        vec![coat(1.5, 0.5).over([0.1, 1.0, 10.0], 1.0), coat(1.5, 1e-3), metal(0.05)],
        vec![coat(1.1, 0.9), coat(1.2, 0.7), coat(1.3, 0.5), coat(1.4, 0.3), metal(0.1)],
        vec![coat(1.33, 1e-4), Layer::new(Interface::diffuse([0.9, 0.5, 0.0], 1.0))],
    ]
}

/// The layers of a stack over another number type.
fn stack_of<R: Real>(first: R) -> Vec<Layer<R, 3>> {
    let found = stack_table().place(first.to_f64());
    found.map_or(Vec::new(), |(stack, _)| stack.layers().iter().map(Layer::cast).collect())
}

/// The channel that an argument names.
fn channel<R: Real>(values: [R; 3], channel: R) -> [R; 1] {
    [values[channel.to_f64() as usize]]
}

/// Two directions on either side of an interface, in most samples one refracted to the other, and the two indices.
fn refraction_pair(d: &mut Draw) -> Vec<f64> {
    let (a, m, other) = (d.direction(), d.half_vector(0.3).normalized(), d.direction());
    let (n_a, n_b) = (d.ratio(), d.ratio());
    let (b, cos_b) = walk::refracted(a, m, n_b / n_a);
    let refracts = a.dot(m) > 0.0 && cos_b > 0.0 && b.z < 0.0;
    flat![a, if refracts { b } else { -other }, n_a, n_b]
}

/// The whole walk. A decision that rounding turns leads to another walk, so that no bound holds for a single one but that
/// it is finite; `tests/walk_gpu.rs` compares means.
fn walk_twin() -> Twin {
    fn evaluate<R: Real<Mask = bool>>(a: &[R]) -> Vec<R> {
        let word = |x: R| x.to_f64() as u32;
        let layers = stack_of(a[0]);
        vec![walk::sample(&layers, word(a[2]) as usize, at(a, 3), at(a, 6), word(a[9]), word(a[10]))]
    }
    Twin {
        module: "walk",
        function: "sample",
        arity: 7,
        judge: Judge::Allowed,
        sample: |d| {
            let mut arguments = stack_channel_and_pair(d);
            arguments.extend([d.word(), d.word()]);
            arguments
        },
        single: evaluate::<f32>,
        double: evaluate::<f64>,
        allowed: |_| vec![WgslInterval::ONE / WgslInterval::ZERO],
    }
}

/// Every twin.
#[rustfmt::skip]
pub fn twins() -> Vec<Twin> {
    let mut twins = vec![
        twin!(real::sum_exact / 2, ErrorFree, |d| flat![d.between(-4.0, 4.0), d.between(-1e-3, 1e-3)], |a| {
            let (sum, error) = a[0].sum_exact(a[1]);
            [sum, error]
        }),
        twin!(real::product_exact / 2, ErrorFree, |d| flat![d.between(-4.0, 4.0), d.between(-90.0, 90.0)], |a| {
            let (product, error) = a[0].product_exact(a[1]);
            [product, error]
        }),
        twin!(real::ln_one_plus / 1, |d| {
            let (x, side) = (d.positive(), d.unit());
            flat![if side < 0.4 { -x.min(0.999) } else { x }]
        }, |a| [a[0].ln_one_plus()]),
        twin!(real::angle / 2, |d| { let c = d.cosine(); flat![((1.0 - c) * (1.0 + c)).sqrt(), c] }, |a| [a[0].angle(a[1])]),
        twin!(real::erfcx / 1, |d| flat![d.positive()], |a| [a[0].erfcx()]),
        twin!(real::exp_product / 2, |d| flat![d.depth(), d.depth()], |a| [a[0].exp_product(a[1])]),
        twin!(real::unit_circle / 1, |d| flat![d.fraction()], |a| {
            let (cosine, sine) = a[0].unit_circle();
            [cosine, sine]
        }),

        twin!(fresnel::dielectric / 2, |d| flat![d.cosine_and_ratio()], |a| split(fresnel::dielectric(a[0], a[1]))),
        twin!(fresnel::refracted_square / 2, |d| flat![d.cosine_and_ratio()], |a| [fresnel::refracted_square(a[0], a[1])]),
        twin!(fresnel::conductor / 3, |d| flat![d.cosine(), d.index(), d.extinction()],
            |a| split(fresnel::conductor(a[0], a[1], a[2]))),
        twin!(fresnel::conductor_approx / 3, |d| flat![d.cosine(), d.index(), d.extinction()],
            |a| [fresnel::conductor_approx(a[0], a[1], a[2])]),
        twin!(fresnel::normal_incidence / 2, |d| flat![d.index(), d.extinction()], |a| [fresnel::normal_incidence(a[0], a[1])]),
        twin!(fresnel::schlick / 2, |d| flat![d.cosine(), d.fraction()], |a| split(fresnel::schlick(a[0], a[1]))),
        twin!(fresnel::schlick_from_indices / 3, |d| flat![d.cosine(), d.ratio(), d.ratio()],
            |a| split(fresnel::schlick_from_indices(a[0], a[1], a[2]))),
        twin!(fresnel::lazanyi_uncorrected / 3, |d| flat![d.cosine(), d.index(), d.extinction()],
            |a| [fresnel::lazanyi_uncorrected(a[0], a[1], a[2])]),
        twin!(fresnel::lazanyi / 5, |d| flat![d.cosine(), d.index(), d.extinction(), d.between(0.0, 3.0), d.between(1.0, 12.0)],
            |a| [fresnel::lazanyi(a[0], a[1], a[2], a[3], a[4])]),
        twin!(fresnel::f82_tint / 3, |d| flat![d.cosine(), d.fraction(), d.fraction()],
            |a| [fresnel::f82_tint(a[0], a[1], a[2])]),

        twin!(fresnel_fit::evaluate / 2, fit_arguments::<8>, |a| fitted::<R, 8>(a)),
        twin!(fresnel_fit::evaluate_fine / 2, fit_arguments::<12>, |a| fitted::<R, 12>(a)),

        twin!(distribution::beckmann / 2, half_and_width, |a| [distribution::beckmann(at(a, 0), a[3])]),
        twin!(distribution::beckmann_anisotropic / 3, half_and_widths,
            |a| [distribution::beckmann_anisotropic(at(a, 0), a[3], a[4])]),
        twin!(distribution::ggx / 2, half_and_width, |a| [distribution::ggx(at(a, 0), a[3])]),
        twin!(distribution::ggx_anisotropic / 3, half_and_widths, |a| [distribution::ggx_anisotropic(at(a, 0), a[3], a[4])]),
        twin!(distribution::blinn / 2, half_and_width, |a| [distribution::blinn(at(a, 0), a[3])]),
        twin!(distribution::blinn_anisotropic / 3, half_and_widths,
            |a| [distribution::blinn_anisotropic(at(a, 0), a[3], a[4])]),
        twin!(distribution::gaussian / 3, |d| {
            let width = d.width();
            flat![d.half_vector(width), width, distribution::gaussian_normalisation(width)]
        }, |a| [distribution::gaussian(at(a, 0), a[3], a[4])]),

        twin!(masking::v_cavity / 3, cosines_and_half, |a| shadow(masking::v_cavity(a[0], a[1], at(a, 2)))),
        twin!(masking::kelemen / 3, cosines_and_half, |a| shadow(masking::kelemen(a[0], a[1], at(a, 2)))),
        twin!(masking::smith_ggx / 4, pair_and_widths, |a| shadow(masking::smith_ggx(at(a, 0), at(a, 3), a[6], a[7]))),
        twin!(masking::smith_ggx_separable / 4, pair_and_widths,
            |a| shadow(masking::smith_ggx_separable(at(a, 0), at(a, 3), a[6], a[7]))),
        twin!(masking::smith_beckmann / 4, pair_and_widths,
            |a| shadow(masking::smith_beckmann(at(a, 0), at(a, 3), a[6], a[7]))),
        twin!(masking::smith_beckmann_separable / 4, pair_and_widths,
            |a| shadow(masking::smith_beckmann_separable(at(a, 0), at(a, 3), a[6], a[7]))),
        twin!(masking::projected_area_ggx / 3, |d| flat![d.direction(), d.width(), d.width()],
            |a| [masking::projected_area_ggx(at(a, 0), a[3], a[4])]),
        twin!(masking::projected_area_beckmann / 3, |d| flat![d.direction(), d.width(), d.width()],
            |a| [masking::projected_area_beckmann(at(a, 0), a[3], a[4])]),

        twin!(diffuse::lambert / 1, |d| flat![d.fraction()], |a| [diffuse::lambert(a[0])]),
        twin!(diffuse::oren_nayar / 3, |d| flat![d.pair(1.0), d.deviation()], |a| {
            let parts = diffuse::oren_nayar(at(a, 0), at(a, 3), a[6]);
            [parts.direct, parts.interreflection]
        }),
        twin!(diffuse::oren_nayar_qualitative / 4, |d| flat![d.pair(1.0), d.deviation(), d.fraction()],
            |a| [diffuse::oren_nayar_qualitative(at(a, 0), at(a, 3), a[6], a[7])]),

        twin!(refraction::cos_t / 2, |d| flat![d.cosine_and_ratio()], |a| [refraction::cos_t(a[0], a[1])]),
        twin!(refraction::refract / 2, |d| flat![d.direction(), d.ratio()], |a| coordinates(refraction::refract(at(a, 0), a[3]))),

        twin!(refraction::refract_about / 3, |d| {
            let [wi, wo] = d.pair(0.3);
            flat![wi, (wi + wo).normalized(), d.ratio()]
        }, |a| coordinates(refraction::refract_about(at(a, 0), at(a, 3), a[6]))),

        twin!(absorption::transmittance / 4, |d| flat![d.depth(), d.depth(), d.cosine(), d.cosine()],
            |a| [absorption::transmittance(a[0], a[1], a[2], a[3])]),

        twin!(phong::phong / 3, |d| flat![d.pair(0.1), d.exponent()], |a| [phong::phong(at(a, 0), at(a, 3), a[6])]),
        twin!(phong::blinn_phong / 3, |d| flat![d.pair(0.1), d.exponent()], |a| [phong::blinn_phong(at(a, 0), at(a, 3), a[6])]),

        twin!(microfacet::torrance_sparrow / 5, |d| {
            let width = d.width();
            flat![d.pair(width), d.index(), d.extinction(), width]
        }, |a| {
            let whole = microfacet::torrance_sparrow(at(a, 0), at(a, 3), a[6], a[7], a[8]);
            [whole.f, whole.reflectance, whole.transmittance, whole.d, whole.g]
        }),
        twin!(microfacet::cos_half / 2, |d| flat![d.pair(0.1)], |a| [microfacet::cos_half(at(a, 0), at(a, 3))]),
        twin!(microfacet::facets / 3, |d| { let width = d.width(); flat![d.pair(width), width] }, |a| {
            let shared = microfacet::facets(at(a, 0), at(a, 3), a[6]);
            [shared.lobe, shared.d, shared.g]
        }),

        twin!(layered::internal_reflection / 2, |d| flat![d.fraction(), d.fraction()],
            |a| [layered::internal_reflection(a[0], a[1])]),
        twin!(layered::elek / 4, stack_and_pair, |a| layered::elek(&stack_of(a[0]), at(a, 2), at(a, 5))),
        twin!(layered::elek_channel / 5, stack_channel_and_pair,
            |a| channel(layered::elek(&stack_of(a[0]), at(a, 3), at(a, 6)), a[2])),
        twin!(layered::weidlich_wilkie / 4, stack_and_pair,
            |a| layered::weidlich_wilkie(&stack_of(a[0]), at(a, 2), at(a, 5))),
        twin!(layered::weidlich_wilkie_channel / 5, stack_channel_and_pair,
            |a| channel(layered::weidlich_wilkie(&stack_of(a[0]), at(a, 3), at(a, 6)), a[2])),
        twin!(layered::conserving / 4, stack_and_pair, |a| layered::conserving(&stack_of(a[0]), at(a, 2), at(a, 5))),
        twin!(layered::conserving_channel / 5, stack_channel_and_pair,
            |a| channel(layered::conserving(&stack_of(a[0]), at(a, 3), at(a, 6)), a[2])),
        twin!(layered::coupled / 5, stack_table_and_pair, |a| coupled(a[0], at(a, 3), at(a, 6))),

        twin!(sampling::sample / 5, stack_view_and_numbers, |a| {
            let drawn = sampling::draw(&stack_of(a[0]), model(a[2]), at(a, 3), [a[6], a[7], a[8]]);
            [drawn.wi.x, drawn.wi.y, drawn.wi.z, drawn.pdf]
        }),
        twin!(sampling::pdf / 5, stack_model_and_pair,
            |a| [sampling::pdf(&stack_of(a[0]), model(a[2]), at(a, 3), at(a, 6))]),
        twin!(sampling::ceiling / 4, stack_model_and_view,
            |a| [sampling::ceiling(&stack_of(a[0]), model(a[2]), at(a, 3))]),
        twin!(sampling::reflect_visible / 3, |d| flat![d.direction(), d.width(), numbers(d)],
            |a| coordinates(sampling::reflect_visible(at(a, 0), a[3], [a[4], a[5], a[6]]))),
        twin!(sampling::reflect_visible_pdf / 3, |d| { let width = d.width(); flat![d.pair(width), width] },
            |a| [sampling::reflect_visible_pdf(at(a, 0), at(a, 3), a[6])]),
        twin!(sampling::cosine_hemisphere / 1, |d| flat![d.number(), d.number()],
            |a| coordinates(sampling::cosine_hemisphere([a[0], a[1]]))),
        twin!(sampling::uniform_hemisphere / 1, |d| flat![d.number(), d.number()],
            |a| coordinates(sampling::uniform_hemisphere([a[0], a[1]]))),
        // Numbers without rounding: the interval is a point.
        twin!(random::random / 3, |d| flat![d.word(), d.word(), d.word()],
            |a| random::random(a[0].to_f64() as u32, a[1].to_f64() as u32, a[2].to_f64() as u32)),
        twin!(walk::visible_part / 2, |d| flat![d.direction(), d.half_vector(0.5)], |a| [walk::visible_part(at(a, 0), at(a, 3))]),
        twin!(walk::visible_normal / 3, |d| flat![d.direction(), d.width(), [d.unit(), d.unit(), d.unit()]],
            |a| coordinates(walk::visible_normal(at(a, 0), a[3], [a[4], a[5], a[6]]))),
        twin!(walk::reflection / 3, |d| { let width = d.width(); flat![d.pair(width), width] },
            |a| pair(walk::reflection(at(a, 0), at(a, 3), a[6]))),
        twin!(walk::refracting_normal / 4, refraction_pair,
            |a| coordinates(walk::refracting_normal(at(a, 0), at(a, 3), a[6], a[7]))),
        twin!(walk::transmission / 5, |d| {
            let mut arguments = refraction_pair(d);
            arguments.push(d.width());
            arguments
        }, |a| pair(walk::transmission(at(a, 0), at(a, 3), a[6], a[7], a[8]))),
        twin!(walk::reflected / 2, |d| flat![d.direction(), d.half_vector(0.5).normalized()],
            |a| coordinates(walk::reflected(at(a, 0), at(a, 3)))),
        twin!(walk::refracted / 3, |d| flat![d.direction(), d.half_vector(0.5).normalized(), d.ratio()], |a| {
            let (b, cosine) = walk::refracted(at(a, 0), at(a, 3), a[6]);
            [b.x, b.y, b.z, cosine]
        }),
        walk_twin(),

        twin!(table::fresnel_over_angle / 3, |d| cosine_and_row(d, Mapping::Angle), |a| tabulated_fresnel(a, Mapping::Angle)),
        twin!(table::fresnel_over_root / 3, |d| cosine_and_row(d, Mapping::Root), |a| tabulated_fresnel(a, Mapping::Root)),
        twin!(table::beckmann_over_angle / 3, |d| half_width_and_shape(d, Mapping::Angle),
            |a| tabulated_distribution(a, Mapping::Angle)),
        twin!(table::beckmann_over_root / 3, |d| half_width_and_shape(d, Mapping::Root),
            |a| tabulated_distribution(a, Mapping::Root)),

        twin!(patina::patina_extent / 3, |d| flat![d.between(-1.0, 2.0), d.fraction(), d.fraction()],
            |a| [patina::patina_extent(a[0], a[1], a[2])]),
        twin!(patina::diffuse_as_printed / 3, |d| flat![d.between(0.0, 2.0), d.fraction(), d.between(-1.0, 1.0)],
            |a| [patina::diffuse_as_printed(a[0], a[1], a[2])]),
        twin!(kubelka_munk::film / 4, |d| flat![d.depth(), d.depth(), d.depth(), d.fraction()],
            |a| [kubelka_munk::film(a[0], a[1], a[2], a[3])]),
        twin!(flake::flake_normal / 3, |d| flat![d.direction(), d.between(0.0, 20.0), [d.unit(), d.unit(), 0.5 + 0.5 * d.unit()]],
            |a| coordinates(flake::flake_normal(at(a, 0), a[3], at(a, 4)))),

        twin!(brushed::ggx / 4, pair_and_widths, |a| [brushed::ggx(at(a, 0), at(a, 3), a[6], a[7])]),
        twin!(brushed::beckmann / 4, pair_and_widths, |a| [brushed::beckmann(at(a, 0), at(a, 3), a[6], a[7])]),
        twin!(brushed::evaluate_ggx / 6, pair_metal_and_widths,
            |a| brushed::evaluate_ggx(at(a, 0), at(a, 3), [a[6], a[7], a[8]], [a[9], a[10], a[11]], a[12], a[13])),
        twin!(brushed::evaluate_beckmann / 6, pair_metal_and_widths,
            |a| brushed::evaluate_beckmann(at(a, 0), at(a, 3), [a[6], a[7], a[8]], [a[9], a[10], a[11]], a[12], a[13])),
        twin!(brushed::reflect_visible_ggx / 4, |d| flat![d.direction(), d.width(), d.width(), d.number(), d.number()],
            |a| coordinates(brushed::reflect_visible_ggx(at(a, 0), a[3], a[4], [a[5], a[6]]))),
        twin!(brushed::reflect_visible_ggx_pdf / 4, pair_and_widths,
            |a| [brushed::reflect_visible_ggx_pdf(at(a, 0), at(a, 3), a[6], a[7])]),
        twin!(brushed::reflect_visible_beckmann / 4, |d| flat![d.direction(), d.width(), d.width(), numbers(d)],
            |a| coordinates(brushed::reflect_visible_beckmann(at(a, 0), a[3], a[4], [a[5], a[6], a[7]]))),
        twin!(brushed::reflect_visible_beckmann_pdf / 4, pair_and_widths,
            |a| [brushed::reflect_visible_beckmann_pdf(at(a, 0), at(a, 3), a[6], a[7])]),

        // Up to 128 flakes without rounding, but for the halving: the interval is a point.
        twin!(glint::leaf / 5, flakes_of_a_leaf, |a| {
            let word = |place: usize| a[place].to_f64() as u32;
            [glint::leaf([word(0), word(1), word(2), word(3)], a[4], word(5), word(6), word(7))]
        }),
        twin!(glint::factor / 5, half_flakes_and_place, |a| {
            let (resolution, seed) = (a[6].to_f64() as u32, a[7].to_f64() as u32);
            let flakes = glint::Flakes { spacing: a[4], count: a[5], resolution, seed };
            [glint::factor(at(a, 0), a[3], &flakes, at(a, 8), a[11])]
        }),
    ];
    twins.extend(textures::twins());
    twins
}
