"""Installs the extension from its archive as a user does, and paints by three calls: `python installed.py ARCHIVE`.

BLENDER_USER_RESOURCES names an empty folder, and the Python that runs this has no package `trochoid` of its own.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import bpy

DOCUMENT = {
    "trochoid": 1,
    "palette": {"deep": "#274e53", "foam": "#ece6c2"},
    "nodes": {
        "across": {"type": "ScreenX"},
        "depth": {"type": "FieldMath", "expression": "9*a", "a": "across"},
        "near": {"type": "Clamp", "field": "depth", "min": 4, "max": 10},
        "beauty": {"type": "Mix", "a": "palette.deep", "b": "palette.foam", "weight": "near"},
    },
    "outputs": {"beauty": {"color": "beauty"}},
}


def main():
    # Blender, once imported, has it.
    import addon_utils

    addon_utils.enable("bl_pkg")
    bpy.ops.extensions.package_install_files(
        filepath=str(Path(sys.argv[1]).resolve()), repo="user_default", enable_on_install=True
    )
    import trochoid

    resources = Path(os.environ["BLENDER_USER_RESOURCES"]).resolve()
    assert Path(trochoid.__file__).is_relative_to(resources), f"{trochoid.__file__}: expected the wheel of the extension"
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.resolution_x, scene.render.resolution_y = 160, 90
    scene.view_layers[0].use_pass_z = True
    with tempfile.TemporaryDirectory() as folder:
        graph = Path(folder) / "look.json"
        graph.write_text(json.dumps(DOCUMENT))
        bpy.ops.trochoid.open(filepath=str(graph))
        bpy.ops.render.render()
        image = bpy.data.images["Trochoid"]
        red = list(image.pixels)[::4]
    assert tuple(image.size) == (160, 90) and len(set(red)) > 100, "expected a picture of the cube"
    print(f"installed: trochoid {trochoid.__version__} in Blender {bpy.app.version_string}")


main()
