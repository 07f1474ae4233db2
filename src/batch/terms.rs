//! A [`Kernel`] for each term: what varies from evaluation to evaluation comes in slices, the rest is a field.
//!
//! Slices come in the order of the term's arguments, a vector as its x, y and z; results in the order of the lists below.
//! Domains, units and conventions are those of the term that a kernel names; errors are in `docs/accuracy.md`, column
//! *batch*. [`fresnel::Fit`] and the tables are kernels themselves. A term of constants alone, such as [`diffuse::lambert`], has none.

use super::Kernel;
use crate::fresnel::conductor_carried;
use crate::microfacet::cos_half_carried;
use crate::table::{DistributionTable, FresnelTable, Texel};
use crate::twofold::Twofold;
use crate::{Real, Vector, absorption, diffuse, distribution, fresnel, masking, microfacet, phong, refraction};

/// Declares kernels: fields in braces, slices in brackets, then the number of results and their formula.
macro_rules! kernels {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident),* } [$($input:ident),*] -> $outputs:literal $body:block)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: f32,)*
        }
        impl Kernel<{ [$(stringify!($input)),*].len() }, $outputs> for $name {
            #[inline(always)]
            fn evaluate<R: Real<Wide = R>>(&self, [$($input),*]: [R; { [$(stringify!($input)),*].len() }]) -> [R; $outputs] {
                $(let $field = number::<R>(self.$field);)*
                $body
            }
        }
    )*};
}

/// A parameter as the kernel computes with it.
#[inline(always)]
fn number<R: Real>(x: f32) -> R {
    R::from_f64(f64::from(x))
}

#[inline(always)]
fn split<R: Real>(f: fresnel::Fresnel<R>) -> [R; 2] {
    [f.reflectance, f.transmittance]
}

#[inline(always)]
fn both<R: Real>(m: masking::Masking<R>) -> [R; 2] {
    [m.g, m.visibility]
}

// ------------------------------------------------------------------------------------------------------------- Fresnel

kernels! {
    /// [`fresnel::dielectric`]: cos_i → F, T.
    Dielectric {
        /// The relative index n_t/n_i > 0.
        eta
    } [cos_i] -> 2 { split(fresnel::dielectric(cos_i, eta)) }

    /// [`fresnel::refracted_square`]: cos_i → g².
    RefractedSquare {
        /// The relative index n_t/n_i > 0.
        eta
    } [cos_i] -> 1 { [fresnel::refracted_square(cos_i, eta)] }

    /// [`fresnel::conductor`]: cos_i → F, T.
    Conductor {
        /// The real part of the relative index, > 0.
        n,
        /// Its imaginary part, ≥ 0.
        k
    } [cos_i] -> 2 { split(fresnel::conductor(cos_i, n, k)) }

    /// [`fresnel::conductor_approx`]: cos_i → F.
    ConductorApprox {
        /// The real part of the relative index, > 0.
        n,
        /// Its imaginary part, ≥ 0.
        k
    } [cos_i] -> 1 { [fresnel::conductor_approx(cos_i, n, k)] }

    /// [`fresnel::normal_incidence`] of textured indices: n, k → F0.
    NormalIncidence {} [n, k] -> 1 { [fresnel::normal_incidence(n, k)] }

    /// [`fresnel::schlick`]: cos_i → F, T.
    Schlick {
        /// The reflectance at normal incidence, in [0, 1].
        f0
    } [cos_i] -> 2 { split(fresnel::schlick(cos_i, f0)) }

    /// [`fresnel::schlick_from_indices`]: cos_i → F, T.
    SchlickFromIndices {
        /// The index on the side that light comes from, > 0.
        n_i,
        /// The index on the other side, > 0.
        n_t
    } [cos_i] -> 2 { split(fresnel::schlick_from_indices(cos_i, n_i, n_t)) }

    /// [`fresnel::lazanyi_uncorrected`]: cos_i → F.
    LazanyiUncorrected {
        /// The real part of the relative index, > 0.
        n,
        /// Its imaginary part, ≥ 0.
        k
    } [cos_i] -> 1 { [fresnel::lazanyi_uncorrected(cos_i, n, k)] }

    /// [`fresnel::lazanyi`]: cos_i → F.
    Lazanyi {
        /// The real part of the relative index, > 0.
        n,
        /// Its imaginary part, ≥ 0.
        k,
        /// The factor of the correction, from [`fresnel::lazanyi_fit`].
        a,
        /// Its exponent > 0, from [`fresnel::lazanyi_fit`].
        exponent
    } [cos_i] -> 1 { [fresnel::lazanyi(cos_i, n, k, a, exponent)] }

    /// [`fresnel::f82_tint`]: cos_i → F.
    F82Tint {
        /// The reflectance at normal incidence, in [0, 1].
        f0,
        /// The tint at 82°, in [0, 1].
        tint
    } [cos_i] -> 1 { [fresnel::f82_tint(cos_i, f0, tint)] }
}

/// The fitted Fresnel equations: cos_i → F of each channel.
impl<const C: usize, const N: usize> Kernel<1, C> for fresnel::Fit<C, N> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [cos_i]: [R; 1]) -> [R; C] {
        self.reflectance(cos_i)
    }
}

/// A table of F: cos_i → F of each channel.
impl<const C: usize, T: Texel + Sync> Kernel<1, C> for FresnelTable<C, T> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [cos_i]: [R; 1]) -> [R; C] {
        self.reflectance(cos_i)
    }
}

/// A table of D: h, α → D in sr⁻¹.
impl<T: Texel + Sync> Kernel<4, 1> for DistributionTable<T> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x, y, z, alpha]: [R; 4]) -> [R; 1] {
        [DistributionTable::evaluate(self, Vector::new(x, y, z), alpha)]
    }
}

// ------------------------------------------------------------------------------------------------------- distributions

kernels! {
    /// [`distribution::beckmann`]: h → D in sr⁻¹.
    Beckmann {
        /// The width, in [1e-4, 1].
        alpha
    } [x, y, z] -> 1 { [distribution::beckmann(Vector::new(x, y, z), alpha)] }

    /// [`distribution::beckmann_anisotropic`]: h → D in sr⁻¹.
    BeckmannAnisotropic {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [x, y, z] -> 1 { [distribution::beckmann_anisotropic(Vector::new(x, y, z), alpha_x, alpha_y)] }

    /// [`distribution::ggx`]: h → D in sr⁻¹.
    Ggx {
        /// The width, in [1e-4, 1].
        alpha
    } [x, y, z] -> 1 { [distribution::ggx(Vector::new(x, y, z), alpha)] }

    /// [`distribution::ggx_anisotropic`]: h → D in sr⁻¹.
    GgxAnisotropic {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [x, y, z] -> 1 { [distribution::ggx_anisotropic(Vector::new(x, y, z), alpha_x, alpha_y)] }

    /// [`distribution::blinn`]: h → D in sr⁻¹.
    Blinn {
        /// The width, in [1e-4, 1].
        alpha
    } [x, y, z] -> 1 { [distribution::blinn(Vector::new(x, y, z), alpha)] }

    /// [`distribution::blinn_anisotropic`]: h → D in sr⁻¹.
    BlinnAnisotropic {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [x, y, z] -> 1 { [distribution::blinn_anisotropic(Vector::new(x, y, z), alpha_x, alpha_y)] }

    /// [`distribution::gaussian`]: h → D in sr⁻¹.
    Gaussian {
        /// The width, in [1e-4, 1].
        alpha,
        /// The constant c of that width, from [`distribution::gaussian_normalisation`].
        normalisation
    } [x, y, z] -> 1 { [distribution::gaussian(Vector::new(x, y, z), alpha, normalisation)] }
}

// ------------------------------------------------------------------------------------------------------------- masking

kernels! {
    /// [`masking::v_cavity`] of the half vector h = wi + wo: wi, wo → G, V.
    VCavity {} [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::v_cavity(iz, oz, Vector::new(ix, iy, iz) + Vector::new(ox, oy, oz)))
    }

    /// [`masking::smith_ggx`]: wi, wo → G, V.
    SmithGgx {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::smith_ggx(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), alpha_x, alpha_y))
    }

    /// [`masking::smith_ggx_separable`]: wi, wo → G, V.
    SmithGgxSeparable {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::smith_ggx_separable(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), alpha_x, alpha_y))
    }

    /// [`masking::smith_beckmann`]: wi, wo → G, V.
    SmithBeckmann {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::smith_beckmann(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), alpha_x, alpha_y))
    }

    /// [`masking::smith_beckmann_separable`]: wi, wo → G, V.
    SmithBeckmannSeparable {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::smith_beckmann_separable(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), alpha_x, alpha_y))
    }

    /// [`masking::kelemen`] of the half vector h = wi + wo: wi, wo → G, V.
    Kelemen {} [ix, iy, iz, ox, oy, oz] -> 2 {
        both(masking::kelemen(iz, oz, Vector::new(ix, iy, iz) + Vector::new(ox, oy, oz)))
    }

    /// [`masking::projected_area_ggx`]: w → σ.
    ProjectedAreaGgx {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [x, y, z] -> 1 { [masking::projected_area_ggx(Vector::new(x, y, z), alpha_x, alpha_y)] }

    /// [`masking::projected_area_beckmann`]: w → σ.
    ProjectedAreaBeckmann {
        /// The width along the tangent, in [1e-4, 1].
        alpha_x,
        /// The width along the bitangent, in [1e-4, 1].
        alpha_y
    } [x, y, z] -> 1 { [masking::projected_area_beckmann(Vector::new(x, y, z), alpha_x, alpha_y)] }
}

// ------------------------------------------------------------------------------------------------ diffuse, and through

kernels! {
    /// [`diffuse::oren_nayar`]: wi, wo → the direct part and the interreflection, for [`diffuse::OrenNayar`].
    OrenNayar {
        /// The standard deviation of the slope angle in radians.
        sigma
    } [ix, iy, iz, ox, oy, oz] -> 2 {
        let f = diffuse::oren_nayar(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), sigma);
        [f.direct, f.interreflection]
    }

    /// [`diffuse::oren_nayar_qualitative`]: wi, wo → f in sr⁻¹.
    OrenNayarQualitative {
        /// The standard deviation of the slope angle in radians.
        sigma,
        /// The reflectance of the facets, in [0, 1].
        albedo
    } [ix, iy, iz, ox, oy, oz] -> 1 {
        [diffuse::oren_nayar_qualitative(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), sigma, albedo)]
    }

    /// [`refraction::cos_t`]: cos_i → cos_t.
    CosT {
        /// The relative index n_t/n_i > 0.
        eta
    } [cos_i] -> 1 { [refraction::cos_t(cos_i, eta)] }

    /// [`refraction::refract`]: w → w′.
    Refract {
        /// The relative index n_t/n_i > 0.
        eta
    } [x, y, z] -> 3 { refraction::refract(Vector::new(x, y, z), eta).into() }

    /// [`refraction::refract_about`]: w, m → w′.
    RefractAbout {
        /// The relative index n_t/n_i > 0.
        eta
    } [wx, wy, wz, mx, my, mz] -> 3 {
        refraction::refract_about(Vector::new(wx, wy, wz), Vector::new(mx, my, mz), eta).into()
    }

    /// [`absorption::transmittance`]: cos_i, cos_o → a.
    Transmittance {
        /// The absorption coefficient ≥ 0 in 1/length.
        sigma,
        /// The thickness ≥ 0 in that length.
        thickness
    } [cos_i, cos_o] -> 1 { [absorption::transmittance(sigma, thickness, cos_i, cos_o)] }
}

// --------------------------------------------------------------------------------------------------------- whole BRDFs

kernels! {
    /// [`phong::phong`]: wi, wo → f in sr⁻¹.
    Phong {
        /// The exponent ≥ 0.
        exponent
    } [ix, iy, iz, ox, oy, oz] -> 1 {
        [phong::phong(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), exponent)]
    }

    /// [`phong::blinn_phong`]: wi, wo → f in sr⁻¹.
    BlinnPhong {
        /// The exponent ≥ 0.
        exponent
    } [ix, iy, iz, ox, oy, oz] -> 1 {
        [phong::blinn_phong(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), exponent)]
    }

    /// [`microfacet::cos_half`]: wi, wo → V·H.
    CosHalf {} [ix, iy, iz, ox, oy, oz] -> 1 {
        [microfacet::cos_half(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz))]
    }

    /// [`microfacet::facets`]: wi, wo → the lobe D·G/(4·NL·NV) in sr⁻¹, D in sr⁻¹, G.
    Facets {
        /// The width, in [1e-4, 1].
        alpha
    } [ix, iy, iz, ox, oy, oz] -> 3 {
        let facets = microfacet::facets(Vector::new(ix, iy, iz), Vector::new(ox, oy, oz), alpha);
        [facets.lobe, facets.d, facets.g]
    }
}

/// [`microfacet::torrance_sparrow`] for C channels, which share the facets: wi, wo → f in sr⁻¹ of each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorranceSparrow<const C: usize> {
    /// The real part of each channel's index relative to the medium above, > 0.
    pub n: [f32; C],
    /// Its imaginary part, ≥ 0.
    pub k: [f32; C],
    /// The width, in [1e-4, 1].
    pub alpha: f32,
}

impl<const C: usize> Kernel<6, C> for TorranceSparrow<C> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [ix, iy, iz, ox, oy, oz]: [R; 6]) -> [R; C] {
        let (wi, wo) = (Vector::new(ix, iy, iz), Vector::new(ox, oy, oz));
        let cosine = cos_half_carried(wi, wo);
        let lobe = microfacet::facets(wi, wo, number(self.alpha)).lobe;
        let mut f = [R::ZERO; C];
        // A loop around so much is not unrolled before lanes are made of it: the usual channels by hand.
        if C > 0 {
            f[0] = channel(cosine, self.n[0], self.k[0]) * lobe;
        }
        if C > 1 {
            f[1] = channel(cosine, self.n[1], self.k[1]) * lobe;
        }
        if C > 2 {
            f[2] = channel(cosine, self.n[2], self.k[2]) * lobe;
        }
        if C > 3 {
            f[3] = channel(cosine, self.n[3], self.k[3]) * lobe;
        }
        for (f, (n, k)) in f.iter_mut().zip(self.n.into_iter().zip(self.k)).skip(4) {
            *f = channel(cosine, n, k) * lobe;
        }
        f
    }
}

/// The reflectance of one channel.
#[inline(always)]
fn channel<R: Real<Wide = R>>(cosine: Twofold<R>, n: f32, k: f32) -> R {
    conductor_carried::<R, R>(cosine, number(n), number(k)).reflectance
}
