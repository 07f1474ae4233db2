"""reference.py against values computed with 50 digits. `python -m unittest discover benches/peers` needs numpy only."""

import json
import pathlib
import unittest

import numpy as np

import reference

TERMS = json.loads((pathlib.Path(__file__).parents[2] / "tests" / "reference" / "terms.json").read_text())


class Terms(unittest.TestCase):
    def close(self, value, exact, relative=1e-12):
        self.assertLessEqual(abs(value - exact), relative * abs(exact))

    def test_conductor(self):
        for row in TERMS["fresnel_conductor"]:
            # The amplitudes cancel where F is small: at a weak reflection only the absolute error says something.
            self.assertAlmostEqual(reference.fresnel_conductor(row["c"], row["n"], row["k"]), row["F"], delta=1e-13)

    def test_dielectric(self):
        for row in TERMS["fresnel_dielectric"]:
            if row["eta"] >= 1:
                f = reference.fresnel_dielectric(row["c"], row["eta"])
                self.assertAlmostEqual(f, row["F"], delta=1e-13)

    def test_distributions(self):
        for row in TERMS["distribution"]:
            h = np.array(row["h"]).reshape(3, 1)
            # A half vector of 17 digits leaves the exponent only so many.
            relative = 1e-14 * (10 + row["tan2"] / row["m"] ** 2)
            if row["beckmann"] > 1e-200:
                self.close(reference.d_beckmann(h, row["m"])[0], row["beckmann"], relative)
            self.close(reference.d_ggx(h, row["m"])[0], row["ggx"], relative)

    def test_masking(self):
        # Lambda follows from D: the projected area of the facets seen is that of the surface (Heitz 2014, eq. 12 and 14),
        # cos = G1 * integral of D*max(0, w.m) over the hemisphere. Midpoints in tan(theta) and the azimuth.
        phi = (np.arange(2000) + 0.5) * (2 * np.pi / 2000)
        for name, (d, g1) in reference.DISTRIBUTIONS.items():
            for alpha, cos in [(0.1, 0.05), (0.3, 0.2), (0.3, 0.7), (1.0, 0.1)]:
                # theta = atan(alpha*s/(1-s)) reaches all of the hemisphere.
                s = (np.arange(1000) + 0.5) / 1000
                tan = (alpha * s / (1 - s))[:, None]
                weight = (alpha / (1 - s) ** 2)[:, None] * tan / (1 + tan * tan) ** 1.5
                w = np.array([np.sqrt(1 - cos * cos), 0.0, cos])
                z = 1 / np.sqrt(1 + tan * tan)
                facing = np.maximum(0.0, w[0] * tan * z * np.cos(phi) + w[2] * z)
                m = np.stack([tan * z, 0 * z, z])[:, :, 0]
                area = (d(m, alpha)[:, None] * facing * weight).sum() * (2 * np.pi / 2000) / 1000
                self.close(g1(w.reshape(3, 1), alpha)[0], cos / area, 2e-5)

    def test_errors(self):
        exact = np.array([1.0, 2.0, 0.0])
        found = reference.errors(np.array([1.0, 2.5, 9.0]), exact, 1e-8)
        self.assertEqual((found["max"], found["count"]), (0.25, 2))


if __name__ == "__main__":
    unittest.main()
