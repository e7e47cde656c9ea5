"""A scene made in code, and documents for it."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import trochoid

HERE = Path(__file__).resolve().parents[1]
SIZE = (160, 90)
PALETTE = {"deep": "#274e53", "foam": "#ece6c2", "sky": "#88aacc"}


def load_extension():
    """Loads the extension as a package of its own name; `trochoid` is the wheel."""
    spec = importlib.util.spec_from_file_location(
        "trochoid_blender", HERE / "__init__.py", submodule_search_locations=[str(HERE)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


extension = load_extension()


def diffuse():
    """What this Blender calls the pass of direct diffuse light."""
    return "Diffuse Direct" if bpy.app.version >= (5, 0) else "DiffDir"


def with_plate(**changes):
    """A document that names the file with the passes."""
    document = {
        "trochoid": 1,
        "format": {"width": SIZE[0], "height": SIZE[1], "samples": 4},
        "working_space": "srgb",
        "knobs": {
            "plate": {"value": "plate.exr", "help": "EXR with all passes."},
            "gain": {"value": 1, "min": 0, "max": 3, "help": "Strength of the light."},
        },
        "palette": PALETTE,
        "nodes": {
            "light": {
                "type": "Read",
                "file": "= knobs.plate",
                "as": "field",
                "layer": f"ViewLayer.{diffuse()}",
                "channels": ["G"],
            },
            "lit": {"type": "FieldMath", "expression": "a*b", "a": "light", "b": "= knobs.gain"},
            "tone": {"type": "Clamp", "field": "lit", "min": 0.1, "max": 0.8},
            "soft": {"type": "Blur", "image": "tone", "size": 1.5},
            "beauty": {"type": "Mix", "a": "palette.deep", "b": "palette.foam", "weight": "soft"},
            "dim": {"type": "Mix", "a": "beauty", "b": "palette.sky", "weight": 0.5},
        },
        "outputs": {"beauty": {"color": "beauty", "precision": "float"}, "dim": {"color": "dim"}},
    }
    return {**document, **changes}


def with_arrays(**changes):
    """A document whose nodes have the names of passes."""
    document = {
        "trochoid": 1,
        "working_space": "linear-srgb",
        "palette": PALETTE,
        "nodes": {
            "diffuse_direct": {"type": "ScreenX"},
            "coverage": {"type": "ScreenY"},
            "tone": {"type": "Clamp", "field": "diffuse_direct"},
            "seen": {"type": "Clamp", "field": "coverage"},
            "thing": {"type": "Mix", "a": "palette.deep", "b": "palette.foam", "weight": "tone"},
            "beauty": {"type": "Mix", "a": "palette.sky", "b": "thing", "weight": "seen"},
        },
        "outputs": {"beauty": {"color": "beauty"}},
    }
    return {**document, **changes}


@pytest.fixture
def scene(tmp_path):
    """A scene with a plane, a monkey, a sphere, a sun and a camera, and the extension."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    extension.register()
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.ops.mesh.primitive_monkey_add(location=(0, 0, 1.2), rotation=(0, 0, 0.5))
    bpy.ops.mesh.primitive_uv_sphere_add(location=(3, 4, 1))
    for kind, data, rotation in [
        ("sun", bpy.data.lights.new("Sun", "SUN"), (0.9, 0.2, 0.6)),
        ("camera", bpy.data.cameras.new("Camera"), (1.45, 0, 0)),
    ]:
        made = bpy.data.objects.new(kind, data)
        made.rotation_euler = rotation
        scene.collection.objects.link(made)
    bpy.data.objects["camera"].location = (0, -8, 2.2)
    scene.camera = bpy.data.objects["camera"]
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 4, False, "CPU"
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.filepath = str(tmp_path / "blender.")
    monkey = bpy.data.objects["Suzanne"]
    monkey.keyframe_insert("rotation_euler", frame=1)
    monkey.rotation_euler.z = 1.5
    monkey.keyframe_insert("rotation_euler", frame=2)
    scene.frame_end = 2
    scene.frame_set(1)
    yield scene
    extension.unregister()


@pytest.fixture
def opened(scene, tmp_path):
    """Opens a document in the scene, with the passes that it needs, and returns its file."""

    def opened(document, name="graph.json"):
        file = tmp_path / name
        file.write_text(json.dumps(document, indent=1))
        assert bpy.ops.trochoid.open(filepath=str(file)) == {"FINISHED"}
        bpy.ops.trochoid.enable_passes()
        return file

    return opened


def pixels(image):
    """Returns an image of Blender as rows from the top, and its alpha."""
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, 4)[::-1]
    return values[..., :3], values[..., 3]


def state(scene):
    return extension.repaint.state_of(scene)


def command_line(file, passes, out, frame, **assigned):
    """Renders a document as one does on the command line: by the program that TROCHOID names, or by the wheel's own."""
    assigned = {"knobs.plate": str(passes), **assigned}
    arguments = ["render", str(file), "--output", "beauty", "--frames", str(frame), "--out", str(out)]
    arguments += [f"--set={name}={json.dumps(value)}" for name, value in assigned.items()]
    if program := os.environ.get("TROCHOID"):
        subprocess.run([program, *arguments], check=True, capture_output=True)
    else:
        trochoid.run(arguments)
    return out


def rendered_by_command_line(scene, file, folder, **assigned):
    """Returns what the command line makes of the passes of the last render."""
    out = command_line(file, extension.render_result.path_of(scene), folder / "expected.exr", scene.frame_current, **assigned)
    values = extension.plate.read(out, "", "RGB", SIZE)
    out.unlink()
    return values
