#!/usr/bin/env python3
"""Writes audit.csv: every term by its textbook form in 80 digits, at inputs that are f32 numbers.

    python3 tests/accuracy/audit.py [POINTS] > tests/accuracy/audit.csv

POINTS per term, 120 in the committed file. Needs mpmath (1.3.0 was used). Each form is written out from its source, not
from the crate: it may cancel as it likes, 80 digits are enough for that. Arguments and results are in the order of the
table in terms.rs. A direction is read as its components: cos = z, sin = sqrt(x^2+y^2).
"""

import random
import struct
import sys
import zlib

from mpmath import acos, atan2, cos, erf, exp, log, mp, mpc, mpf, pi, sin, sqrt, tan

mp.dps = 80
POINTS = int(sys.argv[1]) if len(sys.argv) > 1 else 120
rng = random.Random()


def single(x):
    """The nearest f32."""
    return struct.unpack("<f", struct.pack("<f", float(x)))[0]


# ------------------------------------------------------------------------------------------------------------- inputs


def between(low, high):
    return rng.uniform(low, high)


def spaced(low, high):
    """Uniform in the logarithm."""
    return low * (high / low) ** rng.random()


def cosine():
    kind = rng.randrange(8)
    if kind == 0:
        return rng.choice([1e-6, 1.0, 0.5])
    if kind < 4:
        return spaced(1e-6, 1)
    return between(1e-6, 1) if kind < 6 else 1 - spaced(1e-8, 0.5)


def share():
    return rng.choice([0.0, 1.0, rng.random(), rng.random(), spaced(1e-6, 1)])


def eta():
    kind = rng.randrange(4)
    return [1 + spaced(1e-7, 1), 1 - spaced(1e-7, 0.5), spaced(0.25, 4), spaced(0.25, 4)][kind]


def incidence():
    e = single(eta())
    if e < 1 and rng.random() < 0.5:
        critical = (1 - e * e) ** 0.5
        side = rng.choice([-1, 1])
        return [max(1e-6, min(1, critical * (1 + side * spaced(1e-8, 0.5)))), e]
    return [cosine(), e]


def index():
    n = rng.choice([1, 1 + spaced(1e-7, 1), 1 - spaced(1e-7, 0.5), spaced(0.02, 8), spaced(0.02, 8), between(0.02, 8)])
    k = rng.choice([0, spaced(1e-12, 1e-3), between(0, 12), spaced(1e-3, 12)])
    return [min(max(n, 0.02001), 8), k]


def conductor_incidence():
    n, k = map(single, index())
    if n < 1 and rng.random() < 0.3:
        critical = (1 - n * n) ** 0.5
        return [max(1e-6, min(1, critical * (1 + rng.choice([-1, 1]) * spaced(1e-8, 0.5)))), n, rng.choice([0, k, spaced(1e-12, 1e-3)])]
    return [cosine(), n, k]


def alpha():
    return min(max(spaced(1e-4, 1), 1.0001e-4), 1)


def direction(c=None, phi=None):
    c = cosine() if c is None else c
    phi = between(0, 6.283185307179586) if phi is None else phi
    c = mpf(c)
    s = sqrt((1 - c) * (1 + c))
    return [float(s * cos(phi)), float(s * sin(phi)), float(c)]


def half(a):
    t = min(1e6, a * (spaced(1e-3, 9) if rng.random() < 0.8 else spaced(1, 1e4)))
    phi, scale = between(0, 6.283185307179586), 2 * max(cosine(), 1e-3) / (1 + t * t) ** 0.5
    return [float(t * cos(phi) * scale), float(t * sin(phi) * scale), scale]


def pair(a):
    wi = direction()
    if rng.random() < 0.3:
        return wi + direction()
    t, phi = a * spaced(1e-3, 4), between(0, 6.283185307179586)
    m = [float(t * cos(phi)), float(t * sin(phi)), 1.0]
    length = sum(x * x for x in m) ** 0.5
    m = [x / length for x in m]
    d = 2 * sum(x * y for x, y in zip(wi, m))
    wo = [d * y - x for x, y in zip(wi, m)]
    length = sum(x * x for x in wo) ** 0.5
    return wi + ([x / length for x in wo] if wo[2] > 1e-6 else direction())


# -------------------------------------------------------------------------------------------------------------- terms


def snell(c, e):
    return sqrt(max(e * e - 1 + c * c, mpf(0))) / e


def dielectric(c, e):
    """Born & Wolf, 1.5.2, eq. 21."""
    if e * e - 1 + c * c <= 0:
        return [mpf(1), mpf(0)]
    t = snell(c, e)
    rs, rp = (c - e * t) / (c + e * t), (e * c - t) / (e * c + t)
    f = (rs * rs + rp * rp) / 2
    return [f, 1 - f]


def conductor(c, n, k):
    """The complex Fresnel equations, Born & Wolf, 14.2."""
    index = mpc(n, k)
    root = sqrt(index * index - (1 - c * c))
    if root.imag < 0:
        root = -root
    rs = (c - root) / (c + root) if c + root != 0 else mpf(0)
    rp = (index * index * c - root) / (index * index * c + root) if c + root != 0 else mpf(0)
    f = (abs(rs) ** 2 + abs(rp) ** 2) / 2
    return [f, 1 - f]


def conductor_approx(c, n, k):
    s = ((n - c) ** 2 + k * k) / ((n + c) ** 2 + k * k)
    p = ((n * c - 1) ** 2 + k * k * c * c) / ((n * c + 1) ** 2 + k * k * c * c)
    return [(s + p) / 2]


def normal_incidence(n, k):
    return [((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k)]


def schlick(c, f0):
    f = f0 + (1 - f0) * (1 - c) ** 5
    return [f, 1 - f]


def schlick_from_indices(c, a, b):
    return schlick(c, ((b - a) / (b + a)) ** 2)


def lazanyi_uncorrected(c, n, k):
    return [((n - 1) ** 2 + 4 * n * (1 - c) ** 5 + k * k) / ((n + 1) ** 2 + k * k)]


def lazanyi(c, n, k, a, e):
    return [max(mpf(0), lazanyi_uncorrected(c, n, k)[0] - a * c * ((1 - c) ** e if c < 1 else 0))]


def f82_tint(c, f0, t):
    bar = mpf(1) / 7
    fs = lambda c: f0 + (1 - f0) * (1 - c) ** 5
    return [max(mpf(0), fs(c) - fs(bar) * (1 - t) / (bar * (1 - bar) ** 6) * c * (1 - c) ** 6)]


def cos_squared(x, y, z):
    return z * z / (x * x + y * y + z * z)


LIMIT = 87


def cut(x, value):
    return [value if x <= LIMIT else mpf(0)]


def beckmann(x, y, z, a):
    c2 = cos_squared(x, y, z)
    e = (1 - c2) / c2 / (a * a)
    return cut(e, exp(-e) / (pi * a * a * c2 * c2))


def beckmann_anisotropic(x, y, z, ax, ay):
    c2 = cos_squared(x, y, z)
    e = ((x / ax) ** 2 + (y / ay) ** 2) / (z * z)
    return cut(e, exp(-e) / (pi * ax * ay * c2 * c2))


def ggx(x, y, z, a):
    c2 = cos_squared(x, y, z)
    return [a * a / (pi * (1 - c2 + a * a * c2) ** 2)]


def ggx_anisotropic(x, y, z, ax, ay):
    length = x * x + y * y + z * z
    return [length**2 / (pi * ax * ay * ((x / ax) ** 2 + (y / ay) ** 2 + z * z) ** 2)]


def blinn(x, y, z, a):
    c2 = cos_squared(x, y, z)
    e = (1 / (a * a) - 1) * -log(c2)
    return cut(e, exp(-e) / (pi * a * a))


def blinn_anisotropic(x, y, z, ax, ay):
    s2 = x * x + y * y
    mean = ((x / ax) ** 2 + (y / ay) ** 2) / s2
    e = (mean - 1) * -log(cos_squared(x, y, z))
    return cut(e, exp(-e) / (pi * ax * ay))


def gaussian(x, y, z, a, c):
    e = (atan2(sqrt(x * x + y * y), z) / a) ** 2
    return cut(e, c * exp(-e))


def v_cavity(ix, iy, iz, ox, oy, oz):
    hx, hy, hz = ix + ox, iy + oy, iz + oz
    vh = sqrt(hx * hx + hy * hy + hz * hz) / 2
    nh = hz / (2 * vh)
    g = min(mpf(1), 2 * nh * iz / vh, 2 * nh * oz / vh)
    return [g, g / (4 * iz * oz)]


def kelemen(ix, iy, iz, ox, oy, oz):
    v = 1 / ((ix + ox) ** 2 + (iy + oy) ** 2 + (iz + oz) ** 2)
    return [4 * iz * oz * v, v]


def slope(w, ax, ay):
    return sqrt((ax * w[0]) ** 2 + (ay * w[1]) ** 2) / w[2]


def lambda_ggx(w, ax, ay):
    return (sqrt(1 + slope(w, ax, ay) ** 2) - 1) / 2


def lambda_beckmann(w, ax, ay):
    s = slope(w, ax, ay)
    if s == 0:
        return mpf(0)
    a = 1 / s
    # With the digits that 1-erf(a) loses.
    with mp.workdps(80 + int(min(a * a, 4000))):
        return +((erf(a) - 1 + exp(-a * a) / (a * sqrt(pi))) / 2)


def smith(shape, separable):
    def term(ix, iy, iz, ox, oy, oz, ax, ay):
        i, o = shape((ix, iy, iz), ax, ay), shape((ox, oy, oz), ax, ay)
        g = 1 / ((1 + i) * (1 + o)) if separable else 1 / (1 + i + o)
        return [g, g / (4 * iz * oz)]

    return term


def lambert(albedo):
    return [albedo / pi]


def oren_nayar(ix, iy, iz, ox, oy, oz, sigma):
    """Oren & Nayar 1994, eq. 27 to 29; 1-sin of the larger angle and 1-|cos| of the azimuth by their unit-length forms."""
    v = sigma * sigma
    si, so = sqrt(ix * ix + iy * iy), sqrt(ox * ox + oy * oy)
    (sa, ca), (sb, cb) = ((si, iz), (so, oz)) if iz < oz else ((so, oz), (si, iz))
    a, b = atan2(sa, ca), atan2(sb, cb)
    c = (ix * ox + iy * oy) / (si * so) if si * so > 0 else mpf(0)
    c = max(mpf(-1), min(mpf(1), c))
    cross = (ix * oy - iy * ox) / (si * so) if si * so > 0 else mpf(1)
    sideways = cross**2 / (1 + abs(c)) if si * so > 0 else mpf(1)
    c1 = 1 - v / (2 * (v + mpf("0.33")))
    c2 = mpf("0.45") * v / (v + mpf("0.09"))
    if c >= 0:
        c2 *= (ix * ox + iy * oy) / cb
    else:
        # The sine of a direction that is not quite of unit length, from its cosine.
        c2 *= c * sb / cb * (1 - ca * ca / (1 + sa) - (2 * b / pi) ** 3)
    c3 = mpf("0.125") * v / (v + mpf("0.09")) * (4 * a * b / pi**2) ** 2 * sideways * (sa + sb) / (ca + cb)
    second = mpf("0.17") * v / (v + mpf("0.13")) * (1 - c * (2 * b / pi) ** 2)
    return [c1 + c2 + c3, second]


def oren_nayar_qualitative(ix, iy, iz, ox, oy, oz, sigma, albedo):
    v = sigma * sigma
    a = 1 - v / (2 * (v + mpf("0.57")))
    b = mpf("0.45") * v / (v + mpf("0.09"))
    return [albedo / pi * (a + b * max(mpf(0), ix * ox + iy * oy) / max(iz, oz))]


def transmittance(sigma, d, i, o):
    x = sigma * d * (1 / i + 1 / o)
    return cut(x, exp(-x))


def phong(ix, iy, iz, ox, oy, oz, n):
    deficit = ((ix + ox) ** 2 + (iy + oy) ** 2 + (iz - oz) ** 2) / 2
    if deficit >= 1:
        return [mpf(0)]
    return cut(-n * log(1 - deficit), (n + 2) / (2 * pi) * (1 - deficit) ** n)


def blinn_phong(ix, iy, iz, ox, oy, oz, n):
    c2 = cos_squared(ix + ox, iy + oy, iz + oz)
    factor = (n + 2) * (n + 4) / (8 * pi * (n + mpf(2) ** (-n / 2)))
    return cut(-n / 2 * log(c2), factor * sqrt(c2) ** n)


def torrance_sparrow(ix, iy, iz, ox, oy, oz, n, k, a):
    h = [ix + ox, iy + oy, iz + oz]
    cos_h = min(mpf(1), sqrt(h[0] ** 2 + h[1] ** 2 + h[2] ** 2) / 2)
    return [conductor(cos_h, n, k)[0] * beckmann(*h, a)[0] * v_cavity(ix, iy, iz, ox, oy, oz)[1]]


def stack(ix, iy, iz, ox, oy, oz, n1, a1, sigma, d, n2, k2, a2):
    """A coat over a conductor, conserving: f1 + T(i)T(o)/n1^2 exp(-sd(1/i'+1/o')) f2."""
    f1 = torrance_sparrow(ix, iy, iz, ox, oy, oz, n1, mpf(0), a1)[0]
    i, o = snell(iz, n1), snell(oz, n1)
    t = dielectric(iz, n1)[1] * dielectric(oz, n1)[1] / (n1 * n1)
    absorbed = exp(-sigma * d * (1 / i + 1 / o))
    return [f1 + t * absorbed * torrance_sparrow(ix / n1, iy / n1, i, ox / n1, oy / n1, o, n2 / n1, k2 / n1, a2)[0]]


def with_width(make):
    a = alpha()
    return make(a) + [a]


def phong_inputs():
    n = rng.choice([0, spaced(0.01, 1e6), spaced(0.01, 1e6)])
    return pair((2 / (n + 2)) ** 0.5) + [n]


def gaussian_inputs():
    a = single(alpha())
    return half(a) + [a, 1 / (3.141592653589793 * a * a)]


def two_widths(make):
    a, b = alpha(), alpha()
    return make(a) + [a, b]


def smith_inputs():
    return direction() + direction() + [alpha(), alpha()]


def stack_inputs():
    a = max(alpha(), 1e-3)
    return pair(a) + [between(1.1, 2.5), a, spaced(1e-3, 10), spaced(1e-3, 1)] + index() + [max(alpha(), 1e-3)]


TERMS = {
    "fresnel::dielectric": (incidence, dielectric),
    "fresnel::conductor": (conductor_incidence, conductor),
    "fresnel::conductor_approx": (lambda: [cosine()] + index(), conductor_approx),
    "fresnel::normal_incidence": (index, normal_incidence),
    "fresnel::schlick": (lambda: [cosine(), share()], schlick),
    "fresnel::schlick_from_indices": (lambda: [cosine(), spaced(1, 3), spaced(1, 3)], schlick_from_indices),
    "fresnel::lazanyi_uncorrected": (lambda: [cosine()] + index(), lazanyi_uncorrected),
    "fresnel::lazanyi": (lambda: [cosine()] + index() + [between(-1, 3), between(1, 12)], lazanyi),
    "fresnel::f82_tint": (lambda: [cosine(), share(), share()], f82_tint),
    "distribution::beckmann": (lambda: with_width(half), beckmann),
    "distribution::beckmann_anisotropic": (lambda: two_widths(half), beckmann_anisotropic),
    "distribution::ggx": (lambda: with_width(half), ggx),
    "distribution::ggx_anisotropic": (lambda: two_widths(half), ggx_anisotropic),
    "distribution::blinn": (lambda: with_width(half), blinn),
    "distribution::blinn_anisotropic": (lambda: two_widths(half), blinn_anisotropic),
    "distribution::gaussian": (gaussian_inputs, gaussian),
    "masking::v_cavity": (lambda: pair(alpha()), v_cavity),
    "masking::smith_ggx": (smith_inputs, smith(lambda_ggx, False)),
    "masking::smith_ggx_separable": (smith_inputs, smith(lambda_ggx, True)),
    "masking::smith_beckmann": (smith_inputs, smith(lambda_beckmann, False)),
    "masking::smith_beckmann_separable": (smith_inputs, smith(lambda_beckmann, True)),
    "masking::kelemen": (lambda: pair(alpha()), kelemen),
    "diffuse::lambert": (lambda: [share()], lambert),
    "diffuse::oren_nayar": (lambda: direction() + direction() + [between(0, 1.57)], oren_nayar),
    "diffuse::oren_nayar_qualitative": (
        lambda: direction() + direction() + [between(0, 1.57), share()],
        oren_nayar_qualitative,
    ),
    "refraction::cos_t": (incidence, lambda c, e: [snell(c, e)]),
    "absorption::transmittance": (
        lambda: [spaced(1e-4, 100), spaced(1e-4, 10), cosine(), cosine()],
        transmittance,
    ),
    "phong::phong": (phong_inputs, phong),
    "phong::blinn_phong": (phong_inputs, blinn_phong),
    "microfacet::torrance_sparrow": (lambda: (lambda a: pair(a) + index() + [a])(alpha()), torrance_sparrow),
    "layered::conserving": (stack_inputs, stack),
}


def number(x):
    """The shortest decimal that is this f32."""
    for digits in range(1, 10):
        text = "%.*g" % (digits, x)
        if single(float(text)) == x:
            return text
    return repr(x)


def main():
    print("term,arguments,results")
    for name, (inputs, term) in TERMS.items():
        rng.seed(zlib.crc32(name.encode()))
        for _ in range(POINTS):
            row = [single(x) for x in inputs()]
            values = term(*[mpf(x) for x in row])
            print(name, " ".join(map(number, row)), " ".join(mp.nstr(v, 20, min_fixed=0, max_fixed=0) for v in values), sep=",")


main()
