"""Renders a still life with Mitsuba 3, and paints it by the graph beside it: `python still_life.py`.

Mitsuba renders no picture here: only measures. Depth, normals, positions and the indices of shapes come from its integrator
`aov`, the light of the sun and of the sky from white models. All of them go to Trochoid as arrays.
"""

import argparse
import json
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import trochoid

# Runs everywhere. Set another one, such as "llvm_ad_rgb" or "cuda_ad_rgb", if Dr.Jit has what it needs.
VARIANT = "scalar_rgb"
GRAPH = Path(__file__).with_suffix(".json")
WIDTH, HEIGHT = 1200, 1500
# Rays along each side of a pixel, of which masks are means.
FINE = 2
SUN = [0.80, -0.62, -0.36]


# What light falls on it, that a white thing sends back.
WHITE = {"type": "twosided", "white": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1}}}


def model(name, points, faces):
    """Makes a smooth mesh of points and triangles."""
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(WHITE)
    mesh = mi.Mesh(name, len(points), len(faces), props=properties, has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    corners = points[faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], flat)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    parameters["vertex_positions"] = points.astype(np.float32).ravel()
    parameters["vertex_normals"] = normals.astype(np.float32).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    parameters.update()
    return mesh


def grid(points):
    """Makes triangles of rows of points that close around."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1], index[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, d, c], -1), np.stack([a, c, b], -1)]).reshape(-1, 3)
    return points.reshape(-1, 3), faces


def smooth(profile, count=160):
    """Leads a Catmull-Rom curve through the points of a profile."""
    points = np.array(profile, float)
    points = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    place = np.linspace(0, len(points) - 3 - 1e-9, count)
    at, t = place.astype(int), (place % 1)[:, None]
    p = [points[at + step] for step in range(4)]
    return 0.5 * (
        2 * p[1]
        + (p[2] - p[0]) * t
        + (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) * t**2
        + (3 * p[1] - p[0] - 3 * p[2] + p[3]) * t**3
    )


def turned(name, profile, place, tilt=(0, 0), scale=1.0):
    """Turns a profile of radii and heights about its axis. `tilt` leans it: degrees about z, then about y."""
    curve = smooth(profile)
    angle = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    radius, height = np.maximum(curve[:, :1], 1e-4), np.repeat(curve[:, 1:], len(angle), axis=1)
    points, faces = grid(np.stack([radius * np.cos(angle), height, -radius * np.sin(angle)], -1) * scale)
    return model(name, moved(points, place, tilt), faces)


def moved(points, place, tilt):
    lean, turn = np.radians(tilt)
    about_z = np.array([[np.cos(lean), -np.sin(lean), 0], [np.sin(lean), np.cos(lean), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    return points @ about_z.T @ about_y.T + np.array(place)


def tube(name, path, radius):
    """Makes a tube along a path, for handles and stalks."""
    path = smooth(path, 60)
    ahead = np.gradient(path, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, [0.05, 0.02, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, ahead)
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)[:, None]
    circle = side[:, None] * np.cos(angle) + up[:, None] * np.sin(angle)
    return model(name, *grid(path[:, None] + radius * circle))


def boat(name, place, turn, scale):
    """Folds a boat of paper: a hull of four sheets and a sail between them. Every sheet is flat."""
    bow, stern, top = [1.05, 0.62, 0], [-1.05, 0.62, 0], [0, 1.12, 0]
    sheets = []
    for side in (1, -1):
        rim, keel = [0, 0.36, 0.36 * side], [[0.52 * end, 0, 0.2 * side] for end in (1, -1)]
        sheets += [[bow, rim, keel[0]], [rim, keel[1], keel[0]], [rim, stern, keel[1]]]
        sheets += [[top, [-0.54, 0.2, 0.06 * side], [0.54, 0.2, 0.06 * side]]]
    points = moved(np.array(sheets).reshape(-1, 3) * scale, place, (0, turn))
    return model(name, points, np.arange(len(points)).reshape(-1, 3))


def shapes():
    """Returns the shapes, by name; several whose names differ only in what follows "_" are one thing."""
    # fmt: off
    bottle = [(0, 0), (0.40, 0), (0.44, 0.05), (0.45, 0.5), (0.45, 1.35), (0.40, 1.62), (0.22, 1.86), (0.15, 2.05),
              (0.145, 2.55), (0.19, 2.57), (0.19, 2.68), (0.14, 2.70), (0, 2.70)]
    jug = [(0, 0), (0.38, 0), (0.42, 0.06), (0.60, 0.48), (0.58, 0.82), (0.40, 1.14), (0.34, 1.34), (0.44, 1.56),
           (0.42, 1.58), (0.31, 1.35), (0, 1.2)]
    handle = [(0.80, 1.40), (1.12, 1.36), (1.24, 1.02), (0.96, 0.62)]
    bowl = [(0, 0.0), (0.34, 0.0), (0.36, 0.10), (0.62, 0.26), (0.90, 0.56), (1.00, 0.80), (0.97, 0.82), (0.86, 0.58),
            (0.58, 0.32), (0, 0.22)]
    pear = [(0, 0.02), (0.24, 0.0), (0.43, 0.16), (0.48, 0.40), (0.38, 0.68), (0.24, 0.90), (0.17, 1.08), (0.06, 1.17),
            (0, 1.16)]
    lemon = [(0, -0.52), (0.06, -0.50), (0.13, -0.42), (0.30, -0.24), (0.35, 0), (0.30, 0.24), (0.13, 0.42), (0.06, 0.51),
             (0, 0.53)]
    orange = [(0, -0.36), (0.15, -0.345), (0.30, -0.22), (0.37, 0), (0.30, 0.23), (0.15, 0.33), (0.03, 0.32), (0, 0.30)]
    # fmt: on
    return {
        "table": sheet([0, 0, 1], 8, 4.4),
        "cloth": sheet([0.42, 0.012, 1.12], 1.45, 0.95, 12),
        "bottle": turned("bottle", bottle, (-0.95, 0, -1.15)),
        "jug_body": turned("jug_body", jug, (0.42, 0, -1.35)),
        "jug_handle": tube("jug_handle", [(x, y, -1.35) for x, y in handle], 0.065),
        "bowl": turned("bowl", bowl, (-0.28, 0, 0.05)),
        "orange_left": turned("orange_left", orange, (-0.66, 0.72, 0.10), (14, 0)),
        "orange_right": turned("orange_right", orange, (0.10, 0.70, 0.24), (-10, 0)),
        "orange_back": turned("orange_back", orange, (-0.18, 0.94, -0.30), (4, 0)),
        "lemon": turned("lemon", lemon, (0.72, 0.36, 1.12), (82, 38)),
        "pear": turned("pear", pear, (1.42, 0, 0.28), (-5, 0)),
        "stalk": tube("stalk", [(1.52, 1.12, 0.28), (1.54, 1.24, 0.28), (1.62, 1.36, 0.28)], 0.028),
        "boat": boat("boat", (-0.98, 0, 1.40), -42, 0.70),
    }


def sheet(place, width, depth, turn=0):
    """Lays a rectangle on the table; width and depth are measured from its middle."""
    place = mi.ScalarTransform4f().translate(place).rotate([0, 1, 0], turn).rotate([1, 0, 0], -90).scale([width, depth, 1])
    return mi.load_dict({"type": "rectangle", "to_world": place, "bsdf": WHITE})


def scene(width, height, rays, integrator, light):
    """Makes the scene for one kind of pass."""
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "component_format": "float32"}
    camera = {
        "type": "perspective",
        "fov": 26,
        "fov_axis": "x",
        # Depth is measured from this distance on.
        "near_clip": 1e-4,
        "to_world": mi.ScalarTransform4f().look_at([0.25, 3.05, 9.4], [0.18, 1.30, -0.35], [0, 1, 0]),
        "film": film,
        "sampler": {"type": "stratified" if rays > 1 else "independent", "sample_count": rays},
    }
    return mi.load_dict({"type": "scene", "integrator": integrator, "camera": camera, "light": light, **shapes()})


def blocks(array, size):
    """Returns an array with the rays of each pixel on an axis of their own, the third one."""
    height, width = array.shape[0] // size, array.shape[1] // size
    rest = array.shape[2:]
    return array.reshape(height, size, width, size, *rest).swapaxes(1, 2).reshape(height, width, size * size, *rest)


def passes(width, height, fine=FINE, rays=4):
    """Renders the passes: arrays by the names of the graph's nodes, and the share of each pixel that each thing covers."""
    sun = {"type": "directional", "direction": SUN, "irradiance": {"type": "rgb", "value": np.pi}}
    sky = {"type": "constant", "radiance": {"type": "rgb", "value": 1}}
    measures = {"type": "aov", "aovs": "depth:depth,normal:sh_normal,position:position,index:shape_index"}
    # One ray for each pixel of a finer raster: no value is a mean of two things.
    fine_scene = scene(width * fine, height * fine, 1, measures, sun)
    names = [shape.id() for shape in fine_scene.shapes()]
    aovs = blocks(np.array(mi.render(fine_scene, seed=1)), fine)
    depth, normal, position, index = aovs[..., 0], aovs[..., 1:4], aovs[..., 4:7], aovs[..., 7]
    things = {}
    for number, name in enumerate(names, start=1):
        share = (index == number).mean(axis=2, dtype=np.float32)
        name = name.split("_")[0]
        things[name] = things.get(name, 0) + share
    # Of the rays of a pixel, the nearest one stands for it. A depth of 0 is a miss.
    distance = np.where(depth > 0, depth, np.inf)
    nearest = distance.argmin(axis=2)
    pick = np.ogrid[:height, :width]
    lit = {}
    for name, light in (("sun", sun), ("sky", sky)):
        only_light = {"type": "path", "max_depth": 2, "hide_emitters": True}
        lit[name] = np.array(mi.render(scene(width, height, rays, only_light, light), seed=2))[..., 1]
    return {
        "depth": distance[pick[0], pick[1], nearest],
        "normal": normal[pick[0], pick[1], nearest],
        "position": position[pick[0], pick[1], nearest],
        "coverage": (depth > 0).mean(axis=2, dtype=np.float32),
        **lit,
    }, things


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scale", type=float, default=1, help="size of the picture, such as 0.5 for a draft")
    parser.add_argument("--out", type=Path, default=Path("still_life.png"), help="the picture")
    parser.add_argument("--keep", type=Path, help="file in which passes are kept, and from which they are taken again")
    arguments = parser.parse_args()
    mi.set_variant(VARIANT)
    size = round(WIDTH * arguments.scale), round(HEIGHT * arguments.scale)
    begun = time.perf_counter()
    if arguments.keep and arguments.keep.exists():
        inputs = dict(np.load(arguments.keep))
    else:
        measures, things = passes(*size)
        inputs = {**measures, **things}
        if arguments.keep:
            np.savez(arguments.keep, **inputs)
    rendered = time.perf_counter()
    nodes = json.loads(GRAPH.read_text())["nodes"]
    inputs = {name: values for name, values in inputs.items() if name in nodes}
    look = trochoid.Look.load(str(GRAPH), inputs=list(inputs), illegal="clamp")
    picture = look.picture(inputs)
    arguments.out.write_bytes(picture.png())
    audit = picture.audit
    print(f"{arguments.out}: {size[0]} × {size[1]}, hull, {audit.hull_exits} of {audit.pixels} pixels outside")
    print(f"passes {rendered - begun:.1f} s, picture {time.perf_counter() - rendered:.1f} s")


if __name__ == "__main__":
    main()
