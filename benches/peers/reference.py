"""The models that Mitsuba evaluates, in f64 with numpy, from the formulas of the papers.

Directions are arrays of shape (3, count) in the local frame, normal +z. f is a BRDF in 1/sr, without the cosine.
"""

import math

import numpy as np

_erf = np.vectorize(math.erf, otypes=[np.float64])


def fresnel_conductor(cos, n, k):
    """F of an index n + ik, unpolarised (Born & Wolf, section 14.2)."""
    # Fresnel's amplitudes themselves, with complex numbers: unlike the sums of squares that programs use.
    index_squared = (n + 1j * k) ** 2
    g = np.sqrt(index_squared - (1 - cos * cos))
    rs = (cos - g) / (cos + g)
    rp = (index_squared * cos - g) / (index_squared * cos + g)
    return 0.5 * (np.abs(rs) ** 2 + np.abs(rp) ** 2)


def fresnel_dielectric(cos, eta):
    """F at eta = n_t/n_i > 1, unpolarised (Walter et al. 2007, eq. 22)."""
    g = np.sqrt(eta * eta - 1 + cos * cos)
    a = (g - cos) / (g + cos)
    b = (cos * (g + cos) - 1) / (cos * (g - cos) + 1)
    return 0.5 * a * a * (1 + b * b)


def _tan_squared(w):
    return (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2])


def d_beckmann(h, alpha):
    """Beckmann's distribution (Walter et al. 2007, eq. 25). h may have any length."""
    tan2 = _tan_squared(h)
    return np.exp(-tan2 / alpha**2) * (1 + tan2) ** 2 / (math.pi * alpha**2)


def d_ggx(h, alpha):
    """GGX (Walter et al. 2007, eq. 33). h may have any length."""
    tan2 = _tan_squared(h)
    return (1 + tan2) ** 2 * alpha**2 / (math.pi * (alpha**2 + tan2) ** 2)


def g1_beckmann(w, alpha):
    """Smith's masking of one direction, exact (Heitz 2014, eq. 65 and 66)."""
    a = 1 / (alpha * np.sqrt(np.maximum(_tan_squared(w), 1e-300)))
    # Past 30 exp(-a*a) is 0.
    a = np.minimum(a, 30.0)
    shadow = (_erf(a) - 1) / 2 + np.exp(-a * a) / (2 * a * math.sqrt(math.pi))
    return 1 / (1 + shadow)


def g1_ggx(w, alpha):
    """Smith's masking of one direction (Walter et al. 2007, eq. 34; Heitz 2014, eq. 72)."""
    return 2 / (1 + np.sqrt(1 + alpha**2 * _tan_squared(w)))


DISTRIBUTIONS = {"beckmann": (d_beckmann, g1_beckmann), "ggx": (d_ggx, g1_ggx)}


def lobe(distribution, wi, wo, alpha):
    """D·G/(4·cos_i·cos_o) with separable Smith masking (Walter et al. 2007, eq. 20 and 23), and the cosine at the facet."""
    d, g1 = DISTRIBUTIONS[distribution]
    h = wi + wo
    cos = np.einsum("ij,ij->j", wi, h) / np.sqrt(np.einsum("ij,ij->j", h, h))
    return d(h, alpha) * g1(wi, alpha) * g1(wo, alpha) / (4 * wi[2] * wo[2]), np.minimum(cos, 1.0)


def rough_conductor(distribution, wi, wo, n, k, alpha):
    """f for each channel of n and k, shape (channels, count)."""
    shape, cos = lobe(distribution, wi, wo, alpha)
    return np.stack([shape * fresnel_conductor(cos, n, k) for n, k in zip(n, k)])


def rough_dielectric_coat(distribution, wi, wo, eta, alpha):
    """f of what a rough dielectric reflects, the same in three channels."""
    shape, cos = lobe(distribution, wi, wo, alpha)
    return np.stack([shape * fresnel_dielectric(cos, eta)] * 3)


def errors(f, exact, floor):
    """The largest and the 99.9th percentile of |f - exact|/exact where exact > floor."""
    counted = exact > floor
    relative = np.abs(f[counted] - exact[counted]) / exact[counted]
    p999 = np.percentile(relative, 99.9, method="lower")
    return {"max": float(relative.max()), "p999": float(p999), "count": int(relative.size)}
