"""Cost of an exported shader in Cycles: nanoseconds for each time that OSL runs it.

    trochoid export crates/trochoid/benches/look.json --to osl \
        --bind light --bind rim --bind depth --bind glint --out look.osl
    python tests/bench/osl.py look.osl          with bpy from PyPI

The body of the shader runs in a loop within a shader, over inputs that change from turn to turn. From the time of a render
that of the same loop with the sum of the inputs instead is taken away, so that neither rays nor inputs count.
"""

import re
import statistics
import sys
import time
from pathlib import Path

import bpy

# Blender keeps a library of its own there.
sys.path[:0] = map(str, Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/*/site-packages"))
from cycles import osl  # noqa: E402

SIZE, TURNS, ROUNDS = 64, 5000, 5


def looped(text, body):
    """Returns a shader that runs the body, or the sum of the inputs, in a loop."""
    head, name, inputs, rest = re.fullmatch(r"(.*)shader (\w+)\((.*?),\s*output color result = 0.0\)\s*(.*)", text, re.S).groups()
    names = re.findall(r"^\s*float (\w+) =", inputs, re.M)
    given = ", ".join(f"float {name}" for name in names)
    work = rest.replace("result =", "color result =").rstrip().removesuffix("}") + "    return result;\n}\n"
    called = f"{name}_body({', '.join(f'mod({name} + at, 1.0)' for name in names)})"
    summed = f"color({' + '.join(f'mod({name} + at, 1.0)' for name in names)})"
    return (
        f"{head}color {name}_body({given})\n{work}\n"
        f"shader {name}({inputs}, int turns = 0, output color result = 0.0)\n{{\n"
        f"    for (int turn = 0; turn < turns; turn++) {{\n        float at = turn * 0.6180339;\n"
        f"        result += {called if body else summed};\n    }}\n}}\n"
    )


def scene(text):
    """Makes a scene of one face that the shader lights, with coordinates as inputs."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = bpy.context.scene
    made.render.engine, made.cycles.device, made.cycles.shading_system = "CYCLES", "CPU", True
    made.cycles.samples, made.cycles.use_denoising, made.cycles.use_adaptive_sampling = 1, False, False
    made.render.threads_mode, made.render.threads = "FIXED", 1
    made.render.resolution_x, made.render.resolution_y, made.render.resolution_percentage = SIZE, SIZE, 100
    bpy.ops.mesh.primitive_plane_add(size=2)
    material = bpy.data.materials.new("shader")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    script = tree.nodes.new("ShaderNodeScript")
    source = bpy.data.texts.new("shader.osl")
    source.write(text)
    script.mode, script.script = "INTERNAL", source
    said = []
    osl.update_script_node(script, lambda _, text: said.append(text))
    turns = next((taken for taken in script.inputs if taken.name.lower() == "turns"), None)
    if turns is None:
        sys.exit(f"failed: Cycles says: {said}")
    place, parts = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "SeparateXYZ"))
    tree.links.new(place.outputs["Position"], parts.inputs[0])
    for at, taken in enumerate(taken for taken in script.inputs if taken != turns):
        tree.links.new(parts.outputs[at % 2], taken)
    turns.default_value = TURNS
    light, out = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
    tree.links.new(script.outputs[0], light.inputs[0])
    tree.links.new(light.outputs[0], out.inputs[0])
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.cameras.new("above")
    camera.type, camera.ortho_scale = "ORTHO", 2
    above = bpy.data.objects.new("above", camera)
    above.location = (0, 0, 5)
    made.collection.objects.link(above)
    made.camera = above


def seconds(text):
    scene(text)
    bpy.ops.render.render()
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        bpy.ops.render.render()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


source = Path(sys.argv[1]).read_text()
whole, rest = seconds(looped(source, True)), seconds(looped(source, False))
print(f"render with the shader {whole:.3f} s, without {rest:.3f} s")
print(f"{(whole - rest) / (SIZE * SIZE * TURNS) * 1e9:.1f} ns each time")
