//! What one rough interface does to one direction: densities, kernels and the sampling of visible normals.
//!
//! Twin: `wgsl/walk.wgsl`. Everything is seen from the side that the walk arrives from: `a`, the direction back along the
//! path, has `a.z` > 0, also below an interface, where z is mirrored; `b` has `b.z` > 0 for reflection and `b.z` < 0
//! for transmission. `n_a` and `n_b` are the indices of the media on the side of `a` and on the other.
//!
//! # Which microsurface
//!
//! The stacks of this crate are Beckmann's distribution under V-cavities ([`crate::microfacet::facets`]), so that is
//! what the walk takes by default. In a V-cavity a facet m of height 1 faces its mirror image (−x, −y, z). From above
//! the *top* G1(a, m) = min(1, 2·m_z·a_z/(a·m)) of it is in view, so two directions on one side see the smaller of
//! their two parts: G2 = min(G1(a), G1(b)). From below the cavities stand on their heads, and the *bottom* G1(b, m) is in
//! view: a direction above and one below share G2 = max(0, G1(a) + G1(b) − 1) (Heitz & d'Eon 2014, "Importance Sampling
//! Microfacet-Based BSDFs using the Distribution of Visible Normals", eq. 5 and 6). Both are symmetric and ≤ G1(a).

use crate::distribution;
use crate::frame::Vector;
use crate::masking;
use crate::microfacet;
use crate::real::Real;
use crate::refraction;

/// What the walk takes the microfacets to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Microsurface {
    /// Beckmann's distribution under V-cavities: what every model of this crate evaluates. The default.
    #[default]
    VCavities,
    /// Beckmann's distribution under Smith's masking: height-correlated in reflection, the product of both in transmission.
    SmithBeckmann,
    /// GGX under Smith's masking, likewise.
    SmithGgx,
}

/// A pair of directions at an interface, for F = 1 or T = 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair<R> {
    /// The kernel without its Fresnel factor: f in sr⁻¹ for reflection, f̂ for transmission (per étendue n²·cos·dω).
    pub lobe: R,
    /// The density in sr⁻¹ with which `b` is sampled from `a`.
    pub density: R,
    /// The cosine of `a` to the microfacet, for the Fresnel terms.
    pub cos_a: R,
}

/// The part of facet `m` that direction `w` sees, in [0, 1], under V-cavities.
///
/// $$G_1 = \min\left(1, \frac{2\,m_z\,|w_z|}{|w\cdot m|}\right)$$
///
/// In plain text: G1 = min(1, 2·m_z·|w_z|/|w·m|). `m` of any length with `m.z` > 0; `w` unit, not perpendicular to m.
///
/// Error in f32: ≤ 8 ULP of the terms of w·m. Source: Torrance & Sparrow 1967; Heitz & d'Eon 2014, eq. 4.
#[inline]
pub fn visible_part<R: Real>(w: Vector<R>, m: Vector<R>) -> R {
    let facing = w.dot(m).abs();
    let usable = facing.gt(R::ZERO);
    // m.z/(w·m) is the same for every length of m.
    let part = R::TWO * m.z * w.z.abs() / R::select(usable, facing, R::ONE);
    R::select(usable, part.min(R::ONE), R::ONE)
}

/// A point on the unit circle, (cos 2πu, sin 2πu) turned by an eighth, for `turn` = u in [0, 1).
///
/// The quadrant is split off exactly; the rest is a Taylor series on [−π/4, π/4] whose first dropped term is below 1e-16.
/// Error in f32: ≤ 3 ULP of 1.
#[inline]
pub fn circle<R: Real>(turn: R) -> [R; 2] {
    let quarters = turn * R::from_f64(4.0);
    let [first, second, third] = [1.0, 2.0, 3.0].map(|edge| quarters.lt(R::from_f64(edge)));
    let centre = R::select(
        first,
        R::HALF,
        R::select(second, R::from_f64(1.5), R::select(third, R::from_f64(2.5), R::from_f64(3.5))),
    );
    let x = (quarters - centre) * R::from_f64(core::f64::consts::FRAC_PI_2);
    let z = x * x;
    let mut sine = R::ZERO;
    let mut cosine = R::ZERO;
    // Σ (−z)^k/(2k+1)! and Σ (−z)^k/(2k)! by Horner's rule.
    for k in (1..=8u32).rev() {
        let (even, odd) = (f64::from(2 * k), f64::from(2 * k + 1));
        sine = -z * R::from_f64(1.0 / (even * odd)) * (R::ONE + sine);
        cosine = -z * R::from_f64(1.0 / (even * (even - 1.0))) * (R::ONE + cosine);
    }
    let (c, s) = (R::ONE + cosine, x * (R::ONE + sine));
    let pick = |one: R, two: R, three: R, four: R| {
        R::select(first, one, R::select(second, two, R::select(third, three, four)))
    };
    [pick(c, -s, -c, s), pick(s, c, -s, -c)]
}

/// A unit normal drawn from those that `w` sees, under V-cavities: density G1(w, m)·(w·m)·D(m)/w_z.
///
/// A normal is drawn from D·cos, and given up for its mirror image (−x, −y, z) in proportion to the areas that `w` sees
/// of the two. `w.z` > 0, `alpha` in [1e-4, 1], `u` three independent numbers in [0, 1).
///
/// Source: Heitz & d'Eon 2014, algorithm 3; D·cos of Beckmann: Walter et al. 2007, eq. 28.
#[inline]
pub fn visible_normal<R: Real>(w: Vector<R>, alpha: R, u: [R; 3]) -> Vector<R> {
    let slope = alpha * (-(-u[0]).ln_one_plus()).max(R::ZERO).sqrt();
    let [x, y] = circle(u[1]);
    let m = Vector::new(slope * x, slope * y, R::ONE).normalized();
    let (along, across) = (w.z * m.z, w.x * m.x + w.y * m.y);
    let (here, there) = ((along + across).max(R::ZERO), (along - across).max(R::ZERO));
    let stays = (u[2] * (here + there)).lt(here);
    let side = R::select(stays, R::ONE, -R::ONE);
    Vector::new(side * m.x, side * m.y, m.z)
}

/// The reflection from `a` to `b` at a rough interface, for F = 1.
///
/// f = D·G2/(4·a_z·b_z); density G1(a)·D/(4·a_z); cosine a·m = |a+b|/2. `a`, `b` unit, 0 where a cosine is ≤ 0.
///
/// Source: Torrance & Sparrow 1967 ([`microfacet::facets`]); Heitz & d'Eon 2014, eq. 12.
#[inline]
pub fn reflection<R: Real>(a: Vector<R>, b: Vector<R>, alpha: R) -> Pair<R> {
    let shared = microfacet::facets(a, b, alpha);
    let lit = a.z.gt(R::ZERO) & b.z.gt(R::ZERO);
    let guarded = Vector::new(a.x, a.y, R::select(lit, a.z, R::ONE));
    let part = visible_part(guarded, crate::frame::half_vector(a, b));
    let density = part * shared.d / (R::from_f64(4.0) * guarded.z);
    Pair { lobe: shared.lobe, density: R::select(lit, density, R::ZERO), cos_a: microfacet::cos_half(a, b) }
}

/// The normal that refracts `a` to `b`, not normalised, with m_z > 0 where there is one: ±(n_a·a + n_b·b).
///
/// Source: Walter et al. 2007, eq. 16.
#[inline]
pub fn refracting_normal<R: Real>(a: Vector<R>, b: Vector<R>, n_a: R, n_b: R) -> Vector<R> {
    let m = a * n_a + b * n_b;
    let side = R::select(m.z.lt(R::ZERO), -R::ONE, R::ONE);
    m * side
}

/// The transmission from `a` to `b` through a rough interface, for T = 1.
///
/// $$\hat f = \frac{D\,G_2\,|a\cdot m||b\cdot m|}{|a_z||b_z|(n_a\,a\cdot m+n_b\,b\cdot m)^2},\quad p = \frac{G_1(a)\,|a\cdot m|D}{|a_z|}\,\frac{n_b^2|b\cdot m|}{(n_a\,a\cdot m+n_b\,b\cdot m)^2}$$
///
/// In plain text: f̂ = D·G2·|a·m||b·m|/(|a_z||b_z|·(n_a·a·m + n_b·b·m)²), symmetric in both directions; p = D_v·n_b²·|b·m|
/// over the same square. 0 where no facet that faces both sides the right way refracts one to the other.
///
/// `a.z` > 0, `b.z` < 0; `n_a` ≠ `n_b`, both > 0. Source: Walter et al. 2007, eq. 16, 17 and 21, with f̂ = f_t/n_o².
#[inline]
pub fn transmission<R: Real>(a: Vector<R>, b: Vector<R>, n_a: R, n_b: R, alpha: R) -> Pair<R> {
    transmission_by(a, b, n_a, n_b, |m| {
        let (part_a, part_b) = (visible_part(a, m), visible_part(b, m));
        (distribution::beckmann(m, alpha), part_a, (part_a + part_b - R::ONE).max(R::ZERO))
    })
}

/// [`transmission`] with D, G1(a) and G2 of any microsurface, each for a normal that need not be unit.
#[inline]
fn transmission_by<R: Real>(
    a: Vector<R>,
    b: Vector<R>,
    n_a: R,
    n_b: R,
    surface: impl Fn(Vector<R>) -> (R, R, R),
) -> Pair<R> {
    let half = refracting_normal(a, b, n_a, n_b);
    let m = half.normalized();
    let (cos_a, cos_b) = (a.dot(m), -b.dot(m));
    let lit = a.z.gt(R::ZERO) & b.z.lt(R::ZERO) & cos_a.gt(R::ZERO) & cos_b.gt(R::ZERO) & half.z.gt(R::ZERO);
    let guard = |x: R| R::select(lit, x, R::ONE);
    let (d, part, both) = surface(Vector::new(m.x, m.y, guard(m.z)));
    // (n_a a·m + n_b b·m)² = |n_a a + n_b b|²: m lies along the sum.
    let jacobian = cos_b / guard(half.length_squared());
    let seen = d * cos_a / guard(a.z) * jacobian;
    Pair {
        lobe: R::select(lit, seen * both / guard(-b.z), R::ZERO),
        density: R::select(lit, seen * part * n_b * n_b, R::ZERO),
        cos_a: R::select(lit, cos_a, R::ZERO),
    }
}

/// `a` mirrored by a facet of unit normal `m`.
#[inline]
pub fn reflected<R: Real>(a: Vector<R>, m: Vector<R>) -> Vector<R> {
    m * (R::TWO * a.dot(m)) - a
}

/// `a` refracted by a facet of unit normal `m` to the other side, `eta` = n_b/n_a, `cos_a` = a·m ≥ 0, and the cosine
/// there, 0 on total reflection.
///
/// b = (a·m/η − c)·m − a/η with c = cos_t(a·m, η). Source: Walter et al. 2007, eq. 40.
#[inline]
pub fn refracted<R: Real>(a: Vector<R>, m: Vector<R>, eta: R) -> (Vector<R>, R) {
    let cos_a = a.dot(m);
    let cos_b = refraction::cos_t(cos_a, eta);
    (m * (cos_a / eta - cos_b) - a * (R::ONE / eta), cos_b)
}

impl Microsurface {
    /// A unit normal drawn from those that `w` sees.
    #[inline]
    pub(super) fn normal<R: Real<Mask = bool>>(self, w: Vector<R>, alpha: R, u: [R; 3]) -> Vector<R> {
        match self {
            Microsurface::VCavities => visible_normal(w, alpha, u),
            Microsurface::SmithBeckmann => visible_normal_beckmann(w, alpha, u),
            Microsurface::SmithGgx => visible_normal_ggx(w, alpha, u),
        }
    }

    /// The reflection from `a` to `b`, for F = 1.
    #[inline]
    pub(super) fn reflection<R: Real<Mask = bool>>(self, a: Vector<R>, b: Vector<R>, alpha: R) -> Pair<R> {
        if self == Microsurface::VCavities {
            return reflection(a, b, alpha);
        }
        let h = crate::frame::half_vector(a, b);
        let lit = a.z.gt(R::ZERO) & b.z.gt(R::ZERO);
        if !lit {
            return Pair::default();
        }
        let d = self.distribution(h, alpha);
        let shadow = match self {
            Microsurface::SmithGgx => masking::smith_ggx(a, b, alpha, alpha),
            _ => masking::smith_beckmann(a, b, alpha, alpha),
        };
        Pair {
            lobe: d * shadow.visibility,
            density: d / (R::from_f64(4.0) * self.projected_area(a, alpha)),
            cos_a: microfacet::cos_half(a, b),
        }
    }

    /// The transmission from `a` to `b`, for T = 1.
    #[inline]
    pub(super) fn transmission<R: Real<Mask = bool>>(
        self,
        a: Vector<R>,
        b: Vector<R>,
        n_a: R,
        n_b: R,
        alpha: R,
    ) -> Pair<R> {
        if self == Microsurface::VCavities {
            return transmission(a, b, n_a, n_b, alpha);
        }
        transmission_by(a, b, n_a, n_b, |m| {
            let part = a.z / self.projected_area(a, alpha);
            let below = Vector::new(b.x, b.y, -b.z);
            (self.distribution(m, alpha), part, part * below.z / self.projected_area(below, alpha))
        })
    }

    /// G2/G1(a) for facet `m`, where `b` is on the side of `a` or not.
    #[inline]
    pub(super) fn shadowing<R: Real<Mask = bool>>(self, a: Vector<R>, b: Vector<R>, m: Vector<R>, alpha: R) -> R {
        let above = b.z.gt(R::ZERO);
        if self == Microsurface::VCavities {
            let (part_a, part_b) = (visible_part(a, m), visible_part(b, m));
            let both = if above { part_a.min(part_b) } else { (part_a + part_b - R::ONE).max(R::ZERO) };
            return both / part_a;
        }
        let b = Vector::new(b.x, b.y, b.z.abs());
        let (area_a, area_b) = (self.projected_area(a, alpha), self.projected_area(b, alpha));
        if above {
            // cos_b·σ_a/(cos_b·σ_a + cos_a·σ_b − cos_a·cos_b), G2/G1 of correlated heights.
            b.z * area_a / (b.z * area_a + a.z * area_b - a.z * b.z)
        } else {
            b.z / area_b
        }
    }

    fn distribution<R: Real>(self, h: Vector<R>, alpha: R) -> R {
        match self {
            Microsurface::SmithGgx => distribution::ggx(h, alpha),
            _ => distribution::beckmann(h, alpha),
        }
    }

    fn projected_area<R: Real>(self, w: Vector<R>, alpha: R) -> R {
        match self {
            Microsurface::SmithGgx => masking::projected_area_ggx(w, alpha, alpha),
            _ => masking::projected_area_beckmann(w, alpha, alpha),
        }
    }
}

/// Visible normals of GGX under Smith's masking, by a cap of the sphere. Source: Dupuy & Benyoub 2023, listing 3.
fn visible_normal_ggx<R: Real>(w: Vector<R>, alpha: R, u: [R; 3]) -> Vector<R> {
    let stretched = Vector::new(alpha * w.x, alpha * w.y, w.z).normalized();
    let [x, y] = circle(u[0]);
    let z = (R::ONE - u[1]) * (R::ONE + stretched.z) - stretched.z;
    let sine = ((R::ONE - z) * (R::ONE + z)).max(R::ZERO).sqrt();
    let h = Vector::new(sine * x, sine * y, z) + stretched;
    Vector::new(alpha * h.x, alpha * h.y, h.z.max(R::ZERO)).normalized()
}

/// Visible normals of Beckmann's distribution under Smith's masking. Source: Heitz & d'Eon 2014, §4: the slope along
/// `w` has the density (c + s·x)·exp(−x²) above −c/s in the stretched frame, found by Newton's method; the other is normal.
fn visible_normal_beckmann<R: Real<Mask = bool>>(w: Vector<R>, alpha: R, u: [R; 3]) -> Vector<R> {
    let stretched = Vector::new(alpha * w.x, alpha * w.y, w.z).normalized();
    let (s, c) = (stretched.sin_squared().sqrt(), stretched.z);
    let erfc = |x: R| {
        let positive = x.abs().erfcx() * (-(x * x)).exp();
        if x.lt(R::ZERO) { R::TWO - positive } else { positive }
    };
    let frac_1_sqrt_pi = R::from_f64(0.564_189_583_547_756_286_95);
    // ∫ₓ^∞ (c + s·t)·exp(−t²) dt·2/√π.
    let above = |x: R| c * erfc(x) + s * frac_1_sqrt_pi * (-(x * x)).exp();
    let limit = R::from_f64(6.0);
    let mut low = if c.lt(limit * s) { -c / s } else { -limit };
    let mut high = limit;
    let wanted = (R::ONE - u[0]) * above(low);
    let mut along = R::HALF * (low + high);
    // Newton's steps, halving where they leave the bracket: 5 to 8 are enough, 60 halvings alone would be.
    for _ in 0..60 {
        let excess = above(along) - wanted;
        if excess.gt(R::ZERO) {
            low = along;
        } else {
            high = along;
        }
        let slope = R::TWO * frac_1_sqrt_pi * (c + s * along) * (-(along * along)).exp();
        let newton = along + excess / if slope.gt(R::ZERO) { slope } else { R::ONE };
        let inside = slope.gt(R::ZERO) && newton.gt(low) && newton.lt(high);
        let next = if inside { newton } else { R::HALF * (low + high) };
        let moved = (next - along).abs();
        along = next;
        if moved.le(R::from_f64(8.0) * R::EPSILON) {
            break;
        }
    }
    let [x, _] = circle(u[1]);
    let across = x * (-(-u[2]).ln_one_plus()).max(R::ZERO).sqrt();
    let (cos_phi, sin_phi) = if s.gt(R::ZERO) { (stretched.x / s, stretched.y / s) } else { (R::ONE, R::ZERO) };
    let slope = Vector::new(cos_phi * along - sin_phi * across, sin_phi * along + cos_phi * across, R::ONE);
    Vector::new(alpha * slope.x, alpha * slope.y, R::ONE).normalized()
}
