"""Cost of shading samples from Python, for the batches of `cargo bench --workspace --bench look`.

    python crates/python/bench.py          with the package installed, built in release mode

prints nanoseconds per sample: the median over many batches, as the benchmark of Rust does. With the figures of Rust for
4096 samples as arguments, `bench.py BATCH STRIDED` in the same unit, prints the ratios, too.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import trochoid

LOOK = json.loads((Path(__file__).parents[1] / "trochoid/benches/look.json").read_text())
PASSES = ["light", "rim", "depth", "glint"]


def passes(count):
    """Three masks, and the depth in meters."""
    random = np.random.default_rng(1)
    made = {name: random.random(count, dtype=np.float32) for name in PASSES}
    made["depth"] *= 90
    return made


def nanoseconds(count, work):
    """Returns the median time for a sample."""
    rounds = max(20, 200_000 // count)
    times = []
    for _ in range(200):
        start = time.perf_counter_ns()
        for _ in range(rounds):
            work()
        times.append((time.perf_counter_ns() - start) / rounds / count)
    return statistics.median(times)


def main():
    rust = [float(number) for number in sys.argv[1:3]]
    look = trochoid.Look(LOOK, inputs=PASSES)
    for count in [16, 256, 4096, 65_536]:
        inputs = passes(count)
        planar = np.zeros((3, count), np.float32).T
        side_by_side = np.stack([inputs[name] for name in PASSES], axis=1)
        points = {name: side_by_side[:, index] for index, name in enumerate(PASSES)}
        pixels = np.zeros((count, 3), np.float32)
        times = [
            nanoseconds(count, lambda: look.shade(inputs, out=planar)),
            nanoseconds(count, lambda: look.shade(points, out=pixels)),
            nanoseconds(count, lambda: look.shade(inputs, out=pixels)),
            nanoseconds(count, lambda: look.shade(inputs)),
        ]
        names = ["batch", "strided", "rows into pixels", "rows into a new array"]
        told = ", ".join(f"{name} {time:.2f}" for name, time in zip(names, times))
        print(f"{count} samples: ns per sample: {told}")
        if count == 4096 and rust:
            ratios = [f"{name} {own / other:.2f}" for name, own, other in zip(names, times, rust)]
            print(f"{count} samples: times the time of Rust: {', '.join(ratios)}")


main()
