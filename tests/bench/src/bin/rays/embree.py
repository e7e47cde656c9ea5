"""Asks Embree about rays, for `main.rs`: FOLDER has `triangles.f32` and the rays of each question.

Each line of stdin is an order, `time QUESTION any|first` or `answer QUESTION any|first`: the first replies how many
seconds all rays took, the second writes a byte of each ray to `answers`, 1 if it meets something.
"""
import pathlib
import sys
import time

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

folder = pathlib.Path(sys.argv[1])
triangles = np.fromfile(folder / "triangles.f32", dtype="<f4").reshape(-1, 3)
scene = rtcore_scene.EmbreeScene()
mesh = TriangleMesh(scene, triangles, np.arange(len(triangles), dtype=np.int32).reshape(-1, 3))
questions = {}


def rays(question):
    if question not in questions:
        values = np.fromfile(folder / f"{question}.f32", dtype="<f4").reshape(-1, 7)
        parts = values[:, 0:3], values[:, 3:6], values[:, 6]
        questions[question] = [np.ascontiguousarray(part) for part in parts]
    return questions[question]


for line in sys.stdin:
    order, question, kind = line.split()
    origins, directions, limits = rays(question)
    query = "OCCLUDED" if kind == "any" else "INTERSECT"
    started = time.perf_counter()
    found = scene.run(origins, directions, query=query, dists=limits)
    seconds = time.perf_counter() - started
    if order == "answer":
        found = np.asarray(found)
        met = found == 0 if kind == "any" else found >= 0
        (folder / "answers").write_bytes(met.astype(np.uint8).tobytes())
    print(seconds, flush=True)
