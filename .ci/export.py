"""Runs exported shaders in other programs; `.ci/export` says which."""

import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import MaterialX
import moderngl
import numpy
import OpenEXR
from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenShader

TROCHOID = os.environ["TROCHOID"]
# Samples of a graph, as a picture.
WIDTH, HEIGHT = 64, 64
# Difference from a picture that rounding in 32-bit floats may make; in steep powers it adds up, and their `pow` is less exact.
MOST, MOST_OF_STEEP, STEEP = 1e-6, 1e-5, 32
LANGUAGES = {"glsl": "glsl", "osl": "osl", "materialx": "mtlx"}


def run(folder, *arguments, code=0):
    """Runs Trochoid, and returns what it says."""
    done = subprocess.run([TROCHOID, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode != code:
        sys.exit(f"failed: trochoid {shlex.join(arguments)}: found the code {done.returncode}; expected {code}: {done.stderr}")
    return done.stderr


def read(path):
    """Returns the channels of a picture: red, green and blue, or all in the order of their names."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels.astype("f4") for name, channel in file.parts[0].channels.items()}
    return [channels[name] for name in ("RGB" if "R" in channels else sorted(channels, key=order))]


def encoded(linear):
    """Encodes linear light for display, as sRGB."""
    linear = linear.astype("f8")
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * numpy.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def order(name):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


def write(path, planes):
    names = "RGB" if len(planes) == 3 else [f"w{at}" for at in range(len(planes))]
    channels = {name: numpy.ascontiguousarray(plane, "f4") for name, plane in zip(names, planes)}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(str(path))


# Mesa


GL = moderngl.create_context(standalone=True, backend="egl")


def drawn(draw, width, height):
    """Returns red, green and blue of what is drawn, the first row at the top."""
    target = GL.framebuffer([GL.texture((width, height), 4, dtype="f4")])
    target.use()
    target.clear(-1, -1, -1, -1)
    draw()
    pixels = numpy.frombuffer(target.read(components=4, dtype="f4"), "f4").reshape(height, width, 4)
    target.release()
    return [pixels[..., channel].copy() for channel in range(3)]


def in_glsl(path, planes):
    text = path.read_text()
    height, width = planes[0].shape
    returned, name, taken = re.findall(r"^(vec3|float) (\w+)\((.*)\)\n\{", text, re.M)[-1]
    layers = iter(range(len(planes)))
    fetch = lambda: f"texelFetch(data, ivec3(at, {next(layers)}), 0).r"
    passed = [f"vec3({fetch()}, {fetch()}, {fetch()})" if one.startswith("vec3") else fetch() for one in taken.split(", ")]
    program = GL.program(
        vertex_shader="#version 330\nin vec2 corner; void main() { gl_Position = vec4(corner, 0, 1); }",
        fragment_shader=f"#version 330\nuniform sampler2DArray data; out vec4 seen;\n{text}\n"
        f"void main() {{ ivec2 at = ivec2(gl_FragCoord.xy); seen = vec4(vec3({name}({', '.join(passed)})), 1); }}",
    )
    data = GL.texture_array((width, height, len(planes)), 1, numpy.stack(planes).astype("f4").tobytes(), dtype="f4")
    data.use(0)
    corners = GL.buffer(numpy.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
    vertices = GL.vertex_array(program, [(corners, "2f", "corner")])
    found = drawn(lambda: vertices.render(moderngl.TRIANGLES, 3), width, height)
    for used in (data, corners, vertices, program):
        used.release()
    return found


# MaterialX, whose shaders run on Mesa


LIBRARIES = MaterialX.createDocument()
SEARCH = MaterialX.getDefaultDataSearchPath()
MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), SEARCH, LIBRARIES)


def in_materialx(path, planes):
    height, width = planes[0].shape
    document = MaterialX.createDocument()
    MaterialX.readFromXmlFile(document, str(path))
    (graph,) = document.getNodeGraphs()
    document.setDataLibrary(LIBRARIES)
    valid, why = document.validate()
    if not valid:
        sys.exit(f"failed: {path.name}: MaterialX says: {why}")
    # Each input comes from the vertices, four numbers in an attribute.
    for at in range(0, len(planes), 4):
        node = document.addNode("geompropvalue", f"given{at}", "vector4")
        node.setInputValue("geomprop", f"given{at}", "string")
    layers = iter(range(len(planes)))

    def number():
        at = next(layers)
        node = document.addNode("extract", f"number{at}", "float")
        node.addInput("in", "vector4").setNodeName(f"given{at - at % 4}")
        node.setInputValue("index", at % 4)
        return node.getName()

    for taken in graph.getInputs():
        taken.removeAttribute("value")
        if taken.getType() == "color3":
            node = document.addNode("combine3", f"{taken.getName()}_color", "color3")
            for at in (1, 2, 3):
                node.addInput(f"in{at}", "float").setNodeName(number())
            taken.setNodeName(node.getName())
        else:
            taken.setNodeName(number())
    generator = PyMaterialXGenGlsl.GlslShaderGenerator.create()
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(SEARCH)
    (output,) = graph.getOutputs()
    shader = generator.generate("exported", output, context)
    program = GL.program(vertex_shader=shader.getSourceCode("vertex"), fragment_shader=shader.getSourceCode("pixel"))
    for name in program:
        if isinstance(program[name], moderngl.Uniform) and program[name].dimension == 16:
            program[name].value = tuple(numpy.eye(4).ravel())
    # As programs do: the text of the shader has only six digits of each number.
    public = shader.getStage("pixel").getUniformBlock("PublicUniforms")
    for port in (public[at] for at in range(public.size())):
        if port.getVariable() in program and port.getValue() is not None:
            value = port.getValue().getData()
            program[port.getVariable()].value = value if isinstance(value, (int, float)) else tuple(value)
    # A point in the middle of each pixel.
    y, x = numpy.mgrid[0:height, 0:width]
    places = numpy.stack([(2 * x + 1) / width - 1, (2 * y + 1) / height - 1, 0 * x], -1)
    buffers = [(GL.buffer(places.astype("f4").tobytes()), "3f", "i_position")]
    padded = [*planes, *[planes[0]] * (-len(planes) % 4)]
    for at in range(0, len(planes), 4):
        name = f"i_geomprop_given{at}"
        if name in program:
            values = numpy.stack(padded[at : at + 4], -1).astype("f4")
            buffers.append((GL.buffer(values.tobytes()), "4f", name))
    vertices = GL.vertex_array(program, buffers)
    found = drawn(lambda: vertices.render(moderngl.POINTS, width * height), width, height)
    for used in (vertices, program, *(buffer for buffer, _, _ in buffers)):
        used.release()
    return found


# Cycles of Blender


# The module of Python leaves out the folder of the library by which Blender reads the parameters of shaders. It comes first,
# because that library needs Blender's own OpenImageIO.
sys.path[:0] = map(str, Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/*/site-packages"))


def in_osl(path, planes):
    from cycles import osl

    height, width = planes[0].shape
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.shading_system = "CYCLES", "CPU", True
    scene.cycles.samples, scene.cycles.filter_width, scene.cycles.use_denoising = 1, 0.01, False
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    # A face for each pixel, with the inputs as its attributes.
    y, x = numpy.mgrid[0 : height + 1, 0 : width + 1]
    corners = numpy.stack([x, -y, 0 * x], -1).reshape(-1, 3)
    first = (numpy.arange(height)[:, None] * (width + 1) + numpy.arange(width)).ravel()
    faces = numpy.stack([first, first + width + 1, first + width + 2, first + 1], -1)
    mesh = bpy.data.meshes.new("samples")
    mesh.from_pydata(corners.tolist(), [], faces.tolist())
    for at, plane in enumerate(planes):
        values = mesh.attributes.new(f"given{at}", "FLOAT", "FACE")
        values.data.foreach_set("value", plane.astype("f4").ravel())
    material = bpy.data.materials.new("exported")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    script = tree.nodes.new("ShaderNodeScript")
    text = bpy.data.texts.new("exported.osl")
    text.write(path.read_text())
    script.mode, script.script = "INTERNAL", text
    said = []
    osl.update_script_node(script, lambda _, text: said.append(text))
    layers = iter(range(len(planes)))

    def number():
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = f"given{next(layers)}"
        return node.outputs["Fac"]

    for taken in script.inputs:
        if taken.type == "RGBA":
            node = tree.nodes.new("ShaderNodeCombineColor")
            for part in node.inputs:
                tree.links.new(number(), part)
            tree.links.new(node.outputs[0], taken)
        else:
            tree.links.new(number(), taken)
    if next(layers, None) is not None or len(script.outputs) != 1:
        sys.exit(f"failed: {path.name}: Blender finds {len(script.inputs)} inputs and says: {said}")
    light, out = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
    tree.links.new(script.outputs[0], light.inputs[0])
    tree.links.new(light.outputs[0], out.inputs[0])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("samples", mesh))
    camera = bpy.data.cameras.new("above")
    camera.type, camera.ortho_scale = "ORTHO", max(width, height)
    above = bpy.data.objects.new("above", camera)
    above.location = (width / 2, -height / 2, 10)
    scene.collection.objects.link(above)
    scene.camera = above
    scene.view_settings.view_transform = "Raw"
    image = scene.render.image_settings
    image.media_type, image.file_format, image.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path.with_suffix(".exr"))
    bpy.ops.render.render(write_still=True)
    return read(path.with_suffix(".exr"))


RUN = {"glsl": in_glsl, "osl": in_osl, "materialx": in_materialx}


# What is exported


class Graph:
    """A document, what its shader is given, and the picture that it makes of legal values of the same."""

    def __init__(self, folder, name, space, output="beauty", linear=False):
        self.folder, self.name, self.space, self.output, self.linear = folder, name, space, output, linear
        self.bound, self.planes = [], []

    def worked(self, plane):
        """Returns a channel of a color in the working space; in files it is linear light."""
        return encoded(plane) if self.space == "srgb" else plane

    def exports(self):
        for language, ending in LANGUAGES.items():
            out = f"{self.name}.{ending}"
            more = [word for name in self.bound for word in ("--bind", name)] + ["--linear"] * self.linear
            run(self.folder, "export", f"{self.name}.json", "--to", language, "--output", self.output, *more, "-o", out)
            yield language, self.folder / out

    def check(self, picture):
        """Compares every program's colors with the picture's, which are in the hull of its palette."""
        expected = read(picture)
        if not self.linear:
            expected = [self.worked(plane) for plane in expected]
        told = []
        nodes = json.loads((self.folder / f"{self.name}.json").read_text())["nodes"].values()
        is_steep = any(node.get("power", 1) > STEEP for node in nodes)
        for language, path in self.exports():
            found = RUN[language](path, self.planes)
            apart = max(float(numpy.abs(a.astype("f8") - b).max()) for a, b in zip(found, expected))
            most = MOST_OF_STEEP if is_steep or "<power " in path.read_text() else MOST
            if not apart <= most:
                worst = max(range(3), key=lambda c: numpy.nan_to_num(numpy.abs(found[c] - expected[c]), nan=9).max())
                at = numpy.nan_to_num(numpy.abs(found[worst] - expected[worst]), nan=9).argmax()
                given = [float(plane.ravel()[at]) for plane in self.planes]
                sys.exit(
                    f"failed: {path}: found {found[worst].ravel()[at]!r}, {apart:.2g} from the picture's "
                    f"{expected[worst].ravel()[at]!r}; expected at most {most} (inputs {self.bound}: {given})"
                )
            WORST[language] = max(WORST[language], apart)
            told.append(f"{language} {apart:.1e}")
        print(f"{self.name}: {', '.join(told)}", flush=True)


WORST = dict.fromkeys(LANGUAGES, 0.0)


# Graphs that are drawn


class Drawn:
    """A random graph of every pointwise node, over inputs of every kind, whose values go beyond their ranges."""

    def __init__(self, seed, folder):
        self.dice, self.numbers = random.Random(seed), numpy.random.default_rng(seed)
        self.space = self.dice.choice(["srgb", "linear-srgb", "acescg"])
        self.graph = Graph(folder, f"drawn{seed}", self.space, linear=seed % 2 == 1)
        self.nodes, self.masks, self.fields, self.colors, self.weights = {}, [], [], [], []
        for at in range(3):
            self.masks.append(self.input(f"mask{at}", "weights", [self.edges(self.uniform(-0.3, 1.3))]))
            self.fields.append(self.input(f"field{at}", "field", [self.edges(self.uniform(-2, 3) * self.scale())]))
        count = self.dice.randint(3, 5)
        raw = numpy.where(self.uniform(0, 1, count) < 0.3, 0, self.uniform(-0.1, 1, count)).astype("f4")
        raw[:, :2, :2] = 0
        self.weights.append((self.input("parts", "weights", list(raw)), count))
        if self.space != "acescg":
            self.colors.append(self.input("color", "color", list(self.uniform(0, 1, 3))))
        for _ in range(self.dice.randint(6, 14)):
            self.add()
        # All that was drawn last shows in the picture.
        of, count = self.weights[-1]
        last = self.node(type="Blend", colors=[self.color() for _ in range(count)], weights=of)
        for mask in self.masks[-6:]:
            last = self.node(type="Mix", a=last, b=self.colors.pop() if self.colors else self.color(), weight=mask)
        self.document(last)

    def uniform(self, low, high, *shape):
        return self.numbers.uniform(low, high, (*shape, HEIGHT, WIDTH)).astype("f4")

    def scale(self):
        return numpy.float32(self.dice.choice([1, 1, 1, 1e-3, 1e6]))

    def edges(self, plane):
        """Puts 0, 1, what is close to them, and what is far away into a plane."""
        ends = [0, -0.0, 1, 0.5, 1 - 2**-24, 1 + 2**-23, 2**-149, -(2**-149), 2**-126, 3e38, -3e38, numpy.inf, -numpy.inf, 7, -7]
        places = self.numbers.choice(plane.size, 20 * len(ends), replace=False)
        plane.ravel()[places] = numpy.tile(numpy.array(ends, "f4"), 20)
        return plane

    def input(self, name, kind, planes):
        """Adds a node that reads legal values, and passes all values to shaders."""
        legal = planes
        if kind == "weights" and len(planes) == 1:
            legal = [numpy.clip(planes[0], 0, 1)]
        elif kind == "weights":
            clipped = numpy.clip(numpy.stack(planes), 0, 1).astype("f8")
            total = clipped.sum(0)
            legal = list(numpy.where(total > 0, clipped / numpy.where(total > 0, total, 1), 1 / len(planes)))
        write(self.graph.folder / f"{self.graph.name}.{name}.exr", legal)
        self.nodes[name] = {"type": "Read", "file": f"{self.graph.name}.{name}.exr", "as": kind}
        if kind == "color":
            planes = [self.graph.worked(plane) for plane in planes]
        else:
            self.nodes[name]["channels"] = ["R", "G", "B"] if len(planes) == 3 else [f"w{at}" for at in range(len(planes))]
        self.graph.bound.append(name)
        self.graph.planes += planes
        return name

    def literal(self):
        return [round(self.dice.random(), 3) for _ in range(3)]

    def color(self):
        return self.dice.choice([*self.colors, self.literal(), self.literal()])

    def mask(self):
        return self.dice.choice([*self.masks, *self.masks, round(self.dice.random(), 3)])

    def node(self, **node):
        name = f"n{len(self.nodes)}"
        self.nodes[name] = node
        return name

    def mix(self):
        self.colors.append(self.node(type="Mix", a=self.color(), b=self.color(), weight=self.dice.choice(self.masks)))
        return self.colors[-1]

    def add(self):
        dice = self.dice
        low = dice.uniform(-1, 1)
        choice = dice.choice("clamp clamp invert multiply screen bands stack normalize pick mix ramp blend patch sheet".split())
        if choice == "clamp":
            high = dice.choice([low, low + dice.uniform(0.5, 3), 3.4e38, 1e-37])
            low = dice.choice([low, -3.4e38]) if high == 3.4e38 else min(low, high)
            power = dice.choice([1, 1, 2, 3, 7, 16, 1.5, 2.25, 20, 1.3, 40, 300.5])
            self.masks.append(
                self.node(type="Clamp", field=dice.choice(self.fields), min=low, max=high, smooth=dice.random() < 0.4, power=power)
            )
        elif choice == "invert":
            self.masks.append(self.node(type="Invert", weight=dice.choice(self.masks)))
        elif choice in ("multiply", "screen"):
            of = [self.mask() for _ in range(dice.randint(2, 4))]
            self.masks.append(self.node(type=choice.title(), weights=of))
        elif choice == "bands":
            at = sorted(dice.uniform(-1, 2) for _ in range(dice.randint(2, 4)))
            bands = self.node(type="Bands", field=dice.choice(self.fields), thresholds=at, width=dice.choice([0, 0.5]))
            self.weights.append((bands, len(at) + 1))
        elif choice == "stack":
            of = [dice.choice(self.masks) for _ in range(dice.randint(2, 4))]
            self.weights.append((self.node(type="Stack", weights=of), len(of) + 1))
        elif choice == "normalize":
            of = [dice.choice([*self.fields, *self.masks]) for _ in range(dice.randint(2, 4))]
            self.weights.append((self.node(type="Normalize", fields=of, floor=dice.choice([1e-3, 0.5, 1e-30])), len(of) + 1))
        elif choice == "pick":
            of, count = dice.choice(self.weights)
            self.masks.append(self.node(type="PickWeight", weights=of, index=dice.randrange(count)))
        elif choice == "mix":
            self.mix()
        elif choice == "ramp":
            at = sorted(round(dice.random(), 3) for _ in range(dice.randint(2, 5)))
            stops = [{"at": at, "color": self.color()} for at in at]
            # Rounding decides on which side of an edge a mask is that was computed.
            by, how = dice.choice([("mask0", "step"), (dice.choice(self.masks), "linear"), (dice.choice(self.masks), "smooth")])
            stops = [stop for at, stop in enumerate(stops) if how == "step" or at == 0 or stop["at"] - stops[at - 1]["at"] > 0.05]
            self.colors.append(self.node(type="Ramp", weight=by, stops=stops, interpolation=how))
        elif choice == "blend":
            of, count = dice.choice([*self.weights, ([0.25, 0.125, 0.625], 3)])
            self.colors.append(self.node(type="Blend", colors=[self.color() for _ in range(count)], weights=of))
        elif choice == "patch":
            colors = [self.color() for _ in range(dice.choice([4, 16]))]
            self.colors.append(self.node(type="Patch", u=dice.choice(self.masks), v=dice.choice(self.masks), colors=colors))
        elif choice == "sheet":
            colors = [self.color() for _ in range(6)]
            self.colors.append(self.node(type="Sheet", u=dice.choice(self.masks), v=dice.choice(self.masks), colors=colors, columns=3))

    def document(self, last):
        name = self.graph.name
        document = {
            "trochoid": 1,
            "format": {"width": WIDTH, "height": HEIGHT},
            "working_space": self.space,
            "nodes": self.nodes,
            "outputs": {"beauty": {"color": last, "file": f"{name}.beauty.exr", "precision": "float"}},
        }
        (self.graph.folder / f"{name}.json").write_text(json.dumps(document, indent=1))

    def check(self):
        run(self.graph.folder, "render", f"{self.graph.name}.json", "--overwrite")
        self.graph.check(self.graph.folder / f"{self.graph.name}.beauty.exr")


# Scenes of the repository


def scene(path, folder, frame):
    """Exports a scene as its refusal says, and gives the shader what the scene's own nodes make."""
    document = json.loads(path.read_text())
    document["format"]["samples"] = 1
    # Small scenes may read pictures of their size.
    if document["format"]["width"] > 640:
        document["format"] |= {"width": 96, "height": 54}
    output = next(iter(document["outputs"]))
    graph = Graph(folder, path.stem, document["working_space"], output)
    document["outputs"] = {output: {"color": document["outputs"][output]["color"]}}
    outputs = document["outputs"]
    outputs[output] |= {"file": f"out/{graph.name}.exr", "precision": "float"}
    (folder / f"{graph.name}.json").write_text(json.dumps(document))
    # What is refused, and the remedy, which works as it is printed.
    told = run(folder, "export", f"{graph.name}.json", "--to", "glsl", "--output", output, code=2)
    words = shlex.split(told.split("make them inputs of the shader: ")[1].splitlines()[0])
    graph.bound = words[1::2]
    kinds = re.findall(r"computes a (.*) from more than", told)
    for at, (name, kind) in enumerate(zip(graph.bound, kinds, strict=True)):
        key = {"Color": "color", "mask": "weights"}.get(kind, "weights" if kind.startswith("Weights") else "field")
        outputs[f"in{at}"] = {key: name, "file": f"out/{graph.name}.in{at}.exr", "precision": "float"}
    (folder / f"{graph.name}.json").write_text(json.dumps(document))
    run(folder, "render", f"{graph.name}.json", "--frames", str(frame), "--overwrite", "--allow", "../samples")
    for at in range(len(graph.bound)):
        planes = read(folder / f"out/{graph.name}.in{at}.exr")
        graph.planes += [graph.worked(plane) for plane in planes] if kinds[at] == "Color" else planes
    graph.check(folder / f"out/{graph.name}.exr")


with tempfile.TemporaryDirectory() as name:
    root = Path(name)
    for seed in range(int(os.environ.get("TROCHOID_DRAWN", "24"))):
        Drawn(seed, root).check()
    for folder in ("graphs", "samples"):
        shutil.copytree(folder, root / folder)
    for scene_name in os.environ.get("TROCHOID_SCENES", "open_sea glow noise_and_shapes painted_normals from_passes").split():
        scene(Path(f"graphs/{scene_name}.json"), root / "graphs", 1)
    print("largest differences:", ", ".join(f"{language} {worst:.1e}" for language, worst in WORST.items()))
