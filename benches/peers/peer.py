"""Times brdf and Mitsuba 3 side by side on the same directions. `benches/peers/run` sets it up and starts it."""

import argparse
import ctypes
import json
import math
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

import reference

# The materials. `ours.rs` has the same numbers.
COPPER_N = [0.213, 1.007, 1.240]
COPPER_K = [4.057, 2.582, 2.393]
METAL_ALPHA = 0.3
COAT_ALPHA = 0.1
COAT_INDEX = 1.5
ALBEDO = [0.5, 0.4, 0.3]

# What is compared: the ratio's name, our subject, theirs.
PAIRS = [
    ("conductor_beckmann", "conductor_beckmann", "roughconductor_beckmann"),
    ("conductor_beckmann_fitted", "conductor_beckmann_fitted", "roughconductor_beckmann"),
    ("conductor_ggx", "conductor_ggx", "roughconductor_ggx"),
    ("layered_vs_roughplastic", "layered", "roughplastic"),
    ("layered_tinted_vs_roughplastic", "layered_tinted", "roughplastic"),
    ("layered_vs_roughplastic_fitted", "layered_tinted_fitted", "roughplastic"),
]

# Errors are relative where f is above this, at every STEP-th pair.
FLOOR = 1e-8
STEP = 61


def directions(count):
    """Pairs of unit directions of f32, shape (6, count): uniform in the cosine above .02 and in the azimuth.

    Roberts 2018: the root of x^5 = x + 1 gives the steps of a sequence in four dimensions.
    """
    root = 1.1673039782614187
    u = [np.modf(0.5 + np.arange(count) * root**-axis)[0] for axis in range(1, 5)]
    rows = []
    for height, azimuth in (u[:2], u[2:]):
        z, phi = 0.02 + 0.98 * height, 2 * math.pi * azimuth
        sin = np.sqrt(1 - z * z)
        rows += [sin * np.cos(phi), sin * np.sin(phi), z]
    return np.stack(rows).astype("<f4")


class Ours:
    """The process of ours.rs."""

    def __init__(self, program, path, avx2):
        self.process = subprocess.Popen(
            [program, path] + ["avx2"] * avx2, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )

    def ask(self, *words):
        self.process.stdin.write(" ".join(str(word) for word in words) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit("peers: our side ended before it answered")
        answer = json.loads(line)
        if isinstance(answer, dict) and "error" in answer:
            sys.exit(f"peers: our side refused {words}: {answer['error']}")
        return answer

    def seconds(self, name, threads):
        return self.ask("eval", name, threads)["seconds"]

    def error(self, name):
        return self.ask("error", name, STEP, FLOOR)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def without_avx512(drjit):
    """Has Dr.Jit compile for this processor as if it had no AVX-512. Its Python module does not offer that, its library does."""
    core = ctypes.CDLL(str(next(pathlib.Path(drjit.__file__).parent.glob("libdrjit-core.*"))))
    cpu, features = core["_Z19jit_llvm_target_cpuv"], core["_Z24jit_llvm_target_featuresv"]
    cpu.restype = features.restype = ctypes.c_char_p
    kept = [feature for feature in features().decode().split(",") if "avx512" not in feature]
    removed = ["-avx512f", "-avx512vl", "-avx512bw", "-avx512dq"]
    core["_Z19jit_llvm_set_targetPKcS0_j"](cpu(), ",".join(kept + removed).encode(), 8)


class Mitsuba:
    """Mitsuba's BSDFs, compiled by LLVM."""

    def __init__(self, rows, avx2):
        import drjit
        import mitsuba

        mitsuba.set_variant("llvm_ad_rgb")
        if avx2:
            without_avx512(drjit)
        self.dr, self.mi, self.rows, self.threads = drjit, mitsuba, rows, None
        # Arrays in memory: Dr.Jit cannot fold what it has not seen.
        arrays = [mitsuba.Float(row) for row in rows]
        self.wi, self.wo = mitsuba.Vector3f(*arrays[:3]), mitsuba.Vector3f(*arrays[3:])
        drjit.make_opaque(self.wi, self.wo)
        drjit.sync_thread()
        self.context = mitsuba.BSDFContext()

        # In RGB mode `rgb` is taken as it is: no spectrum is fitted, and values above 1 are allowed for indices.
        rgb = lambda value: {"type": "rgb", "value": value}
        metal = lambda distribution: {
            "type": "roughconductor",
            "distribution": distribution,
            "alpha": METAL_ALPHA,
            "eta": rgb(COPPER_N),
            "k": rgb(COPPER_K),
        }
        plastic = lambda diffuse: {
            "type": "roughplastic",
            "distribution": "beckmann",
            "alpha": COAT_ALPHA,
            "int_ior": COAT_INDEX,
            "ext_ior": 1.0,
            "diffuse_reflectance": rgb(diffuse),
        }
        load = mitsuba.load_dict
        self.subjects = {
            "diffuse": load({"type": "diffuse", "reflectance": rgb(ALBEDO)}),
            "roughconductor_beckmann": load(metal("beckmann")),
            "roughconductor_ggx": load(metal("ggx")),
            "roughplastic": load(plastic(ALBEDO)),
        }
        # Only its reflection has a formula; the light that leaves its base is a table made by sampling.
        self.bare_plastic = load(plastic([0.0, 0.0, 0.0]))

    def evaluate(self, bsdf, wi, wo):
        interaction = self.dr.zeros(self.mi.SurfaceInteraction3f)
        interaction.wi = wi
        return bsdf.eval(self.context, interaction, wo)

    def seconds(self, name, threads):
        """One evaluation of all pairs into memory. Tracing is not timed, nor compiling once the kernel is cached."""
        if threads != self.threads:
            self.dr.set_thread_count(threads)
            self.threads = threads
        value = self.evaluate(self.subjects[name], self.wi, self.wo)
        start = time.perf_counter()
        self.dr.eval(value)
        self.dr.sync_thread()
        return time.perf_counter() - start

    def error(self, name):
        """Against the formula in f64; none where there is none."""
        rows = self.rows[:, ::STEP]
        arrays = [self.mi.Float(np.ascontiguousarray(row)) for row in rows]
        bsdf = self.bare_plastic if name == "roughplastic" else self.subjects[name]
        value = self.evaluate(bsdf, self.mi.Vector3f(*arrays[:3]), self.mi.Vector3f(*arrays[3:]))
        wi, wo = rows[:3].astype(np.float64), rows[3:].astype(np.float64)
        # Mitsuba returns f·cos_o.
        f = np.array(value).astype(np.float64).reshape(3, -1) / wo[2]
        if name == "diffuse":
            exact = np.outer(ALBEDO, np.ones(f.shape[1])) / math.pi
        elif name == "roughplastic":
            exact = reference.rough_dielectric_coat("beckmann", wi, wo, COAT_INDEX, COAT_ALPHA)
        else:
            distribution = name.removeprefix("roughconductor_")
            exact = reference.rough_conductor(distribution, wi, wo, COPPER_N, COPPER_K, METAL_ALPHA)
        return reference.errors(f, exact, FLOOR)


def measure(sides, threads, rounds, calls, pause):
    """Seconds of every (side, name, threads), a row for each round, in which all take turns."""
    times = {}
    # Whoever is compared stands side by side in the round.
    turns = [("theirs", "diffuse")]
    for _, ours, theirs in PAIRS:
        turns += [turn for turn in (("theirs", theirs), ("ours", ours)) if turn not in turns]
    # The first round compiles kernels, fits materials and touches memory: it is not counted.
    for current in range(rounds + 1):
        for count in threads:
            for side, name in turns:
                # Threads that have just become idle still spin for a while.
                time.sleep(pause)
                samples = [sides[side].seconds(name, count) for _ in range(calls + 1)]
                if current > 0:
                    # The first call refills the caches.
                    times.setdefault((side, name, count), []).append(samples[1:])
        if sys.stderr.isatty():
            print(f"\rround {current} of {rounds}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r                    \r", end="", file=sys.stderr)
    return times


def thread_counts(most):
    """1, 2, 4, … and the most."""
    counts = [1]
    while counts[-1] * 2 < most:
        counts.append(counts[-1] * 2)
    return counts + [most] if most > 1 else counts


def main():
    parser = argparse.ArgumentParser(prog="benches/peers/run", description=__doc__)
    parser.add_argument("--json", action="store_true", help="end with one line of JSON: ratios, rates and errors")
    parser.add_argument("--rounds", type=int, default=7, help="rounds in which all take turns (7)")
    parser.add_argument("--calls", type=int, default=3, help="timed calls of each in a round (3)")
    parser.add_argument("--pairs", type=int, default=1 << 22, help="pairs of directions (4194304)")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    parser.add_argument("--threads", type=int, default=cores, help="the most threads; 1, 2, 4, … are taken (all cores)")
    parser.add_argument("--avx2", action="store_true", help="both sides without AVX-512, on one thread")
    parser.add_argument("--pause", type=float, default=0.05, help="seconds between turns (.05)")
    parser.add_argument("--program", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--folder", required=True, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    for name in ("rounds", "calls", "pairs", "threads"):
        if getattr(arguments, name) < 1:
            parser.error(f"--{name} must be at least 1")

    rows = directions(arguments.pairs)
    path = pathlib.Path(arguments.folder) / "directions.f32"
    path.write_bytes(rows.tobytes())
    sides = {"ours": Ours(arguments.program, path, arguments.avx2), "theirs": Mitsuba(rows, arguments.avx2)}
    threads = [1] if arguments.avx2 else thread_counts(arguments.threads)
    times = measure(sides, threads, arguments.rounds, arguments.calls, arguments.pause)
    times = {key: np.array(samples) for key, samples in times.items()}
    rates = {key: arguments.pairs / np.median(samples) / 1e6 for key, samples in times.items()}
    subjects = dict.fromkeys((side, name) for side, name, _ in rates)
    errors = {(side, name): sides[side].error(name) for side, name in subjects}
    sides["ours"].close()

    mitsuba = sides["theirs"].mi.__version__
    print(f"brdf and Mitsuba {mitsuba} (llvm_ad_rgb), {arguments.pairs} pairs of directions, RGB, f32, into memory.")
    if arguments.avx2:
        print("Both without AVX-512.")
    print(f"Medians of {arguments.rounds} rounds of {arguments.calls} calls, all taking turns. Mega-evaluations per second")
    print("(three channels are one evaluation) by threads, quartiles behind; relative errors against each side's own")
    print(f"model in f64 where f > {FLOOR:g}.\n")
    title = "".join(f"{f'{count} threads' if count > 1 else '1 thread':>22}" for count in threads)
    print(f"{'':8}{'':28}{title}{'max error':>12}{'p99.9':>10}")
    for side, name in subjects:
        line = f"{'Mitsuba' if side == 'theirs' else 'brdf':8}{name:28}"
        for count in threads:
            low, high = np.percentile(arguments.pairs / times[side, name, count] / 1e6, [25, 75])
            line += f"{rates[side, name, count]:9.1f} ({f'{low:.0f}–{high:.0f})':<11}"
        error = errors[side, name]
        print(line + f"{error['max']:>11.1e}{error['p999']:>10.1e}")
    print(
        "\nNot the same: Mitsuba masks with Smith's G1(wi)·G1(wo) (for Beckmann a rational approximation of it, which is its"
        "\nerror here), brdf with V-cavities under Beckmann and with height-correlated Smith under GGX. Mitsuba returns f·cos,"
        "\nbrdf f. roughplastic has a diffuse base whose transmittance is a table, `layered` a copper base under a clear coat;"
        "\nroughplastic's error is that of its reflection alone. `_fitted` is fresnel::Fit, judged against exact Fresnel."
    )

    def ratio(ours, theirs, count):
        # By rounds: what slows the machine for a while slows both.
        by_round = [np.median(times[key], axis=1) for key in (("theirs", theirs, count), ("ours", ours, count))]
        return float(np.median(by_round[0] / by_round[1]))

    ratios = {name: {str(count): ratio(ours, theirs, count) for count in threads} for name, ours, theirs in PAIRS}
    print("\nbrdf over Mitsuba by threads, the median of the rounds' own ratios")
    for name, by_threads in ratios.items():
        print(f"  {name:34}" + "".join(f"{ratio:8.2f}" for ratio in by_threads.values()))
    if arguments.json:
        rounded = lambda value: float(f"{value:.4g}")
        report = {
            "ratios": {name: {c: rounded(r) for c, r in by.items()} for name, by in ratios.items()},
            "rates": {
                side: {
                    name: {str(c): rounded(rates[side, name, c]) for c in threads} for s, name in subjects if s == side
                }
                for side in ("ours", "theirs")
            },
            "errors": {side: {n: errors[s, n] for s, n in subjects if s == side} for side in ("ours", "theirs")},
            "mitsuba": mitsuba,
            "pairs": arguments.pairs,
            "rounds": arguments.rounds,
        }
        print(json.dumps(report))


if __name__ == "__main__":
    main()
