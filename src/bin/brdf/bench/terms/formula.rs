//! The formulas that are timed: one source for the scalar, the batched and the double-precision run of a variant.

use brdf::batch::Kernel;
use brdf::frame::half_vector;
use brdf::fresnel::{self, Fit};
use brdf::material::metal::Metal;
use brdf::table::{ENTRIES, FresnelTable, Mapping, Texel};
use brdf::{Real, Vector, diffuse, distribution, masking, microfacet};
use std::error::Error;
use std::sync::Arc;

/// The constants that every formula reads, f32 numbers all but the fits.
#[derive(Clone)]
pub(super) struct Constants {
    pub(super) n: [f32; 3],
    pub(super) k: [f32; 3],
    /// Of Schlick's approximation and F82-tint.
    f0: [f32; 3],
    tint: [f32; 3],
    /// Of Lazányi's correction.
    a: [f32; 3],
    exponent: [f32; 3],
    eight: Fit<3, 8>,
    twelve: Fit<3, 12>,
    /// As printed: 128 entries of 8 bits over the angle.
    bytes: Arc<FresnelTable<3, u8>>,
    /// 128 entries over the root of the cosine.
    roots: Arc<FresnelTable<3>>,
    pub(super) alpha: f32,
    /// Of the Gaussian distribution.
    normalisation: f32,
    /// Of Oren and Nayar.
    sigma: f32,
    albedo: f32,
}

impl Constants {
    pub(super) fn metal(metal: &Metal) -> Result<Self, Box<dyn Error>> {
        Self::new(metal.n, metal.k)
    }

    pub(super) fn new(n: [f64; 3], k: [f64; 3]) -> Result<Self, Box<dyn Error>> {
        let single = |numbers: [f64; 3]| numbers.map(|x| x as f32);
        let double = |numbers: [f32; 3]| numbers.map(f64::from);
        let (n, k) = (single(n), single(k));
        let (wide_n, wide_k) = (double(n), double(k));
        let each = |f: &dyn Fn(f64, f64) -> f64| single([0, 1, 2].map(|i| f(wide_n[i], wide_k[i])));
        // The angle at which a tint is exact.
        let dip = 1.0 / 7.0;
        let tint = |n: f64, k: f64| {
            let f0 = fresnel::normal_incidence(n, k);
            fresnel::conductor(dip, n, k).reflectance / fresnel::schlick(dip, f0).reflectance
        };
        let lazanyi = [0, 1, 2].map(|i| fresnel::lazanyi_fit(wide_n[i], wide_k[i]));
        let alpha = 0.3f32;
        Ok(Constants {
            n,
            k,
            f0: each(&fresnel::normal_incidence),
            tint: each(&|n, k| tint(n, k).min(1.0)),
            a: single(lazanyi.map(|fit| fit.a)),
            exponent: single(lazanyi.map(|fit| fit.exponent)),
            eight: Fit::new(wide_n, wide_k)?,
            twelve: Fit::new(wide_n, wide_k)?,
            bytes: Arc::new(FresnelTable::new(wide_n, wide_k, ENTRIES, Mapping::Angle)?),
            roots: Arc::new(FresnelTable::new(wide_n, wide_k, ENTRIES, Mapping::Root)?),
            alpha,
            normalisation: distribution::gaussian_normalisation(f64::from(alpha)) as f32,
            sigma: 0.3,
            albedo: 0.5,
        })
    }

    /// What the WGSL variants read: rows of four numbers, as [`WGSL`] names them.
    pub(super) fn rows(&self) -> Vec<[f32; 4]> {
        let row = |[r, g, b]: [f32; 3], w| [r, g, b, w];
        let mut rows = vec![
            row(self.n, self.alpha),
            row(self.k, self.normalisation),
            row(self.f0, self.sigma),
            row(self.tint, self.albedo),
            row(self.a, 0.0),
            row(self.exponent, 0.0),
        ];
        rows.extend(self.eight.rows());
        rows.extend(self.twelve.rows());
        rows.extend(self.bytes.entries().iter().map(|entry| row(entry.map(|x| x.decode() as f32), 0.0)));
        rows.extend(self.roots.entries().iter().map(|entry| row(*entry, 0.0)));
        rows
    }
}

/// The names of [`Constants::rows`], and the terms of three channels. Reads the storage buffer `material`.
pub(super) const WGSL: &str = "
import brdf::fresnel;
import brdf::fresnel_fit;
import brdf::distribution;
import brdf::masking;
import brdf::diffuse;
import brdf::microfacet;
import brdf::table;

fn fresnel_texel(column: u32, row: u32) -> vec3f { return material[26u + 128u * row + column].xyz; }

fn _n() -> vec3f { return material[0].xyz; }
fn _k() -> vec3f { return material[1].xyz; }
fn _f0() -> vec3f { return material[2].xyz; }
fn _tint() -> vec3f { return material[3].xyz; }
fn _a() -> vec3f { return material[4].xyz; }
fn _exponent() -> vec3f { return material[5].xyz; }
fn _alpha() -> f32 { return material[0].w; }
fn _normalisation() -> f32 { return material[1].w; }
fn _sigma() -> f32 { return material[2].w; }
fn _albedo() -> f32 { return material[3].w; }

fn _conductor(c: f32) -> vec3f {
    let n = _n();
    let k = _k();
    return vec3f(
        fresnel::conductor(c, n.x, k.x).reflectance,
        fresnel::conductor(c, n.y, k.y).reflectance,
        fresnel::conductor(c, n.z, k.z).reflectance,
    );
}
fn _dielectric(c: f32) -> vec3f {
    let n = _n();
    return vec3f(
        fresnel::dielectric(c, n.x).reflectance,
        fresnel::dielectric(c, n.y).reflectance,
        fresnel::dielectric(c, n.z).reflectance,
    );
}
fn _fit_eight(c: f32) -> vec3f {
    let fit = fresnel_fit::Fit(array<vec4f, 8>(
        material[6], material[7], material[8], material[9], material[10], material[11], material[12], material[13],
    ));
    return fresnel_fit::evaluate(c, fit).reflectance;
}
fn _fit_twelve(c: f32) -> vec3f {
    let fit = fresnel_fit::FineFit(array<vec4f, 12>(
        material[14], material[15], material[16], material[17], material[18], material[19], material[20],
        material[21], material[22], material[23], material[24], material[25],
    ));
    return fresnel_fit::evaluate_fine(c, fit).reflectance;
}
fn _table_bytes(c: f32) -> vec3f { return table::fresnel_over_angle(c, 0u, 128u); }
fn _table_roots(c: f32) -> vec3f { return table::fresnel_over_root(c, 1u, 128u); }
fn _lazanyi(c: f32) -> vec3f {
    let n = _n();
    let k = _k();
    let a = _a();
    let e = _exponent();
    return vec3f(
        fresnel::lazanyi(c, n.x, k.x, a.x, e.x),
        fresnel::lazanyi(c, n.y, k.y, a.y, e.y),
        fresnel::lazanyi(c, n.z, k.z, a.z, e.z),
    );
}
fn _lazanyi_uncorrected(c: f32) -> vec3f {
    let n = _n();
    let k = _k();
    return vec3f(
        fresnel::lazanyi_uncorrected(c, n.x, k.x),
        fresnel::lazanyi_uncorrected(c, n.y, k.y),
        fresnel::lazanyi_uncorrected(c, n.z, k.z),
    );
}
fn _conductor_approx(c: f32) -> vec3f {
    let n = _n();
    let k = _k();
    return vec3f(
        fresnel::conductor_approx(c, n.x, k.x),
        fresnel::conductor_approx(c, n.y, k.y),
        fresnel::conductor_approx(c, n.z, k.z),
    );
}
fn _schlick(c: f32) -> vec3f {
    let f0 = _f0();
    return vec3f(
        fresnel::schlick(c, f0.x).reflectance,
        fresnel::schlick(c, f0.y).reflectance,
        fresnel::schlick(c, f0.z).reflectance,
    );
}
fn _tinted(c: f32) -> vec3f {
    let f0 = _f0();
    let t = _tint();
    return vec3f(fresnel::f82_tint(c, f0.x, t.x), fresnel::f82_tint(c, f0.y, t.y), fresnel::f82_tint(c, f0.z, t.z));
}
";

/// One evaluation of a variant over any of the crate's numbers.
pub(super) trait Formula<const I: usize, const O: usize>: Sync {
    fn at<R: Real>(&self, x: [R; I]) -> [R; O];
}

/// A formula as a batch runs it.
pub(super) struct Batched<'a, F>(pub(super) &'a F);

impl<F: Formula<I, O>, const I: usize, const O: usize> Kernel<I, O> for Batched<'_, F> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, x: [R; I]) -> [R; O] {
        self.0.at(x)
    }
}

#[inline(always)]
fn number<R: Real>(x: f32) -> R {
    R::from_f64(f64::from(x))
}

/// The three channels of a term, written out: a closure would not be compiled for the level that it runs at.
macro_rules! rgb {
    ($i:ident => $channel:expr) => {
        [
            {
                let $i = 0;
                $channel
            },
            {
                let $i = 1;
                $channel
            },
            {
                let $i = 2;
                $channel
            },
        ]
    };
}

/// Defines formulas over [`Constants`] `m`.
macro_rules! formulas {
    ($($name:ident($m:ident, $x:pat) [$inputs:literal -> $outputs:literal] $body:expr;)*) => {$(
        pub(super) struct $name(pub(super) Constants);
        impl Formula<$inputs, $outputs> for $name {
            #[inline(always)]
            fn at<R: Real>(&self, $x: [R; $inputs]) -> [R; $outputs] {
                let $m = &self.0;
                $body
            }
        }
    )*};
}

#[inline(always)]
fn conductor<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::conductor(c, number(m.n[i]), number(m.k[i])).reflectance)
}
#[inline(always)]
fn fit_twelve<R: Real>(m: &Constants, c: R) -> [R; 3] {
    m.twelve.reflectance(c)
}
#[inline(always)]
fn fit_eight<R: Real>(m: &Constants, c: R) -> [R; 3] {
    m.eight.reflectance(c)
}
#[inline(always)]
fn lazanyi<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::lazanyi(c, number(m.n[i]), number(m.k[i]), number(m.a[i]), number(m.exponent[i])))
}
#[inline(always)]
fn lazanyi_uncorrected<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::lazanyi_uncorrected(c, number(m.n[i]), number(m.k[i])))
}
#[inline(always)]
fn conductor_approx<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::conductor_approx(c, number(m.n[i]), number(m.k[i])))
}
#[inline(always)]
fn schlick<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::schlick(c, number(m.f0[i])).reflectance)
}
#[inline(always)]
fn tinted<R: Real>(m: &Constants, c: R) -> [R; 3] {
    rgb!(i => fresnel::f82_tint(c, number(m.f0[i]), number(m.tint[i])))
}

/// Torrance and Sparrow's BRDF with a Fresnel term of three channels, by name for the same reason.
macro_rules! rough {
    ($m:ident, $x:ident, $fresnel:ident) => {{
        let (wi, wo) = vectors($x);
        let lobe = microfacet::facets(wi, wo, number($m.alpha)).lobe;
        let [r, g, b] = $fresnel($m, microfacet::cos_half(wi, wo));
        [r * lobe, g * lobe, b * lobe]
    }};
}

#[inline(always)]
fn vectors<R: Real>([ix, iy, iz, ox, oy, oz]: [R; 6]) -> (Vector<R>, Vector<R>) {
    (Vector::new(ix, iy, iz), Vector::new(ox, oy, oz))
}

formulas! {
    Conductor(m, [c]) [1 -> 3] conductor(m, c);
    Dielectric(m, [c]) [1 -> 3] rgb!(i => fresnel::dielectric(c, number(m.n[i])).reflectance);
    FitTwelve(m, [c]) [1 -> 3] fit_twelve(m, c);
    FitEight(m, [c]) [1 -> 3] fit_eight(m, c);
    TableBytes(m, [c]) [1 -> 3] m.bytes.reflectance(c);
    TableRoots(m, [c]) [1 -> 3] m.roots.reflectance(c);
    Lazanyi(m, [c]) [1 -> 3] lazanyi(m, c);
    LazanyiUncorrected(m, [c]) [1 -> 3] lazanyi_uncorrected(m, c);
    ConductorApprox(m, [c]) [1 -> 3] conductor_approx(m, c);
    Schlick(m, [c]) [1 -> 3] schlick(m, c);
    Tinted(m, [c]) [1 -> 3] tinted(m, c);

    Beckmann(m, [x, y, z]) [3 -> 1] [distribution::beckmann(Vector::new(x, y, z), number(m.alpha))];
    Ggx(m, [x, y, z]) [3 -> 1] [distribution::ggx(Vector::new(x, y, z), number(m.alpha))];
    Blinn(m, [x, y, z]) [3 -> 1] [distribution::blinn(Vector::new(x, y, z), number(m.alpha))];
    Gaussian(m, [x, y, z]) [3 -> 1]
        [distribution::gaussian(Vector::new(x, y, z), number(m.alpha), number(m.normalisation))];

    VCavity(_m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::v_cavity(wi.z, wo.z, half_vector(wi, wo)).visibility]
    };
    Kelemen(_m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::kelemen(wi.z, wo.z, half_vector(wi, wo)).visibility]
    };
    SmithGgx(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::smith_ggx(wi, wo, number(m.alpha), number(m.alpha)).visibility]
    };
    SmithGgxSeparable(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::smith_ggx_separable(wi, wo, number(m.alpha), number(m.alpha)).visibility]
    };
    SmithBeckmann(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::smith_beckmann(wi, wo, number(m.alpha), number(m.alpha)).visibility]
    };
    SmithBeckmannSeparable(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [masking::smith_beckmann_separable(wi, wo, number(m.alpha), number(m.alpha)).visibility]
    };

    OrenNayar(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [diffuse::oren_nayar(wi, wo, number(m.sigma)).f(number(m.albedo))]
    };
    OrenNayarQualitative(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        [diffuse::oren_nayar_qualitative(wi, wo, number(m.sigma), number(m.albedo))]
    };
    // Reads a cosine, so that it is a function of its inputs: 0 where no light comes from.
    Lambert(m, x) [6 -> 1] {
        let (wi, wo) = vectors(x);
        let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
        [R::select(lit, diffuse::lambert(number(m.albedo)), R::ZERO)]
    };

    RoughConductor(m, x) [6 -> 3] rough!(m, x, conductor);
    RoughFitTwelve(m, x) [6 -> 3] rough!(m, x, fit_twelve);
    RoughFitEight(m, x) [6 -> 3] rough!(m, x, fit_eight);
    RoughLazanyi(m, x) [6 -> 3] rough!(m, x, lazanyi);
    RoughTinted(m, x) [6 -> 3] rough!(m, x, tinted);
    RoughConductorApprox(m, x) [6 -> 3] rough!(m, x, conductor_approx);
    RoughLazanyiUncorrected(m, x) [6 -> 3] rough!(m, x, lazanyi_uncorrected);
    RoughSchlick(m, x) [6 -> 3] rough!(m, x, schlick);
}
