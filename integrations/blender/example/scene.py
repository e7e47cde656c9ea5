"""Builds a scene, and paints it: `python scene.py painted.png`, with Blender as a module and the package trochoid.

In Blender itself, the extension is installed already; then only the part from `bpy.ops.trochoid.open` on is needed.
"""

import importlib.util
import math
import random
import sys
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 1280, 720


def extension():
    """Loads the extension from its sources."""
    folder = HERE.parent
    spec = importlib.util.spec_from_file_location(
        "trochoid_blender", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def build(scene):
    """A head of a giant among columns, at the edge of a plain."""
    mesh = bpy.ops.mesh
    mesh.primitive_plane_add(size=400)
    mesh.primitive_monkey_add(size=4.4, location=(0.3, 0, 1.72), rotation=(-0.42, 0.12, 0.42))
    head = bpy.context.object
    head.modifiers.new("smooth", "SUBSURF").render_levels = 3
    mesh.primitive_cylinder_add(vertices=48, radius=3.4, depth=0.5, location=(0.3, 0, 0.25))
    mesh.primitive_cylinder_add(vertices=48, radius=4.3, depth=0.25, location=(0.3, 0, 0.12))
    rng = random.Random(5)
    for number in range(9):
        angle = math.radians(-8 + 24.5 * number)
        x, y = 0.3 + 8.2 * math.cos(angle), 1.5 + 8.2 * math.sin(angle)
        height = rng.choice([1.2, 3.4, 5.6, 5.6])
        mesh.primitive_cylinder_add(vertices=40, radius=0.5, depth=height, location=(x, y, height / 2))
        mesh.primitive_cube_add(size=1, location=(x, y, 0.15), scale=(1.5, 1.5, 0.3))
        if height > 5:
            mesh.primitive_cube_add(size=1, location=(x, y, height + 0.15), scale=(1.5, 1.5, 0.3))
    for number in range(26):
        x, y = rng.uniform(-26, 26), rng.uniform(16, 60)
        mesh.primitive_cone_add(vertices=32, radius1=rng.uniform(2, 6), depth=rng.uniform(4, 13), location=(x, y, 2))
    for number in range(16):
        x, y, size = rng.uniform(-7, 8), rng.uniform(-6.5, -1), rng.uniform(0.12, 0.4)
        mesh.primitive_ico_sphere_add(subdivisions=2, radius=size, location=(x, y, size * 0.6))
    for found in scene.objects:
        if found.type == "MESH" and found != head and len(found.data.polygons) > 20:
            found.data.shade_smooth()
            found.modifiers.new("edges", "EDGE_SPLIT").split_angle = math.radians(30)
    head.data.shade_smooth()
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.9, 0.01, (math.radians(52), 0, math.radians(-48))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.6, -15.5, 2.3), (math.radians(89.5), 0, math.radians(2))
    camera.data.lens = 34
    for made in (sun, camera):
        scene.collection.objects.link(made)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 16, False
    scene.cycles.max_bounces = 0
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    trochoid_blender = extension()
    trochoid_blender.register()
    scene = bpy.context.scene
    build(scene)
    if len(sys.argv) > 2:
        scene.render.resolution_percentage = int(sys.argv[2])
    bpy.ops.trochoid.open(filepath=str(HERE / "gouache.json"))
    bpy.ops.trochoid.enable_passes()
    scene.trochoid.frames = str(Path(sys.argv[1]).resolve())
    scene.render.filepath = str(Path(bpy.app.tempdir) / "blender.")
    bpy.ops.render.render(write_still=True)
    print(trochoid_blender.repaint.state_of(scene).told)


if __name__ == "__main__":
    main()
