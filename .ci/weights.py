"""Opens recipes in other programs; `.ci/weights` says which."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy
import OpenEXR
import OpenImageIO

TROCHOID = os.environ["TROCHOID"]
# Names that programs take for channels or layers of their own, that differ only in case, and that are long; and more
# colors than a pass of Blender has channels.
NAMES = [*"R g b A X Y Z V".split(), *"red Red alpha depth images recipe combined _".split(), "n" * 63]
NAMES += [f"color_{number}" for number in range(15)]
COLORS = {name: f"#{7 * at:02x}{255 - 7 * at:02x}{(99 * at) % 256:02x}" for at, name in enumerate(NAMES)}


def scene(with_images):
    stops = [{"at": at / len(NAMES), "color": f"palette.{name}"} for at, name in enumerate(NAMES)]
    photo = {"photo": {"type": "Read", "file": "photo.png", "as": "color"}} if with_images else {}
    return {
        "trochoid": 1,
        "format": {"width": 128, "height": 72, "samples": 4},
        "working_space": "srgb",
        "palette": COLORS,
        "nodes": {
            **photo,
            "x": {"type": "ScreenX"},
            "noise": {"type": "Noise", "scale": 5},
            "mask": {"type": "Clamp", "field": "noise", "min": -0.3, "max": 0.6},
            "all": {"type": "Ramp", "weight": "x", "stops": stops},
            "mixed": {"type": "Mix", "a": "all", "b": "photo" if with_images else "#5a3f5e", "weight": "mask"},
            "soft": {"type": "Blur", "image": "mixed", "size": 4},
        },
        "outputs": {"photo": {"color": "soft", "file": "photo.png"}},
    }


def made(folder):
    """Writes recipes of renders and of a finished picture, of halves and of floats, with images and without."""

    def run(*arguments):
        subprocess.run([TROCHOID, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    few = [name for name in NAMES if len(name) < 5]
    (folder / "few.json").write_text(json.dumps({name: COLORS[name] for name in few}))
    for name, with_images in ("plain", False), ("images", True):
        (folder / f"{name}.json").write_text(json.dumps(scene(with_images)))
        for kind, more in ("half", []), ("float", ["--float"]):
            out = ["--out", f"{name}.png", "--overwrite"] if with_images else ["--overwrite"]
            run("render", f"{name}.json", "--recipe", f"{name}.{kind}.exr", *more, *out)
    run("decompose", "photo.png", "--palette", "few.json", "--out", "taken.half.exr")
    run("decompose", "photo.png", "--palette", "few.json", "--out", "taken.float.exr", "--float")
    return sorted(folder.glob("*.exr"))


def channels(path):
    """Returns all channels of a file as OpenEXR reads them, and what it says of its recipe."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        pixels = {name: channel.pixels.copy() for part in file.parts for name, channel in part.channels.items()}
        return pixels, json.loads(file.parts[0].header.get("trochoid:recipe", "{}"))


def in_blender(path, folder):
    """Writes all sockets of an Image node of the compositor to a file, and returns its channels."""
    tree = bpy.data.node_groups.new("masks", "CompositorNodeTree")
    image, out = (tree.nodes.new(f"CompositorNode{kind}") for kind in ("Image", "OutputFile"))
    image.image = bpy.data.images.load(str(path))
    out.directory, out.file_name = str(folder), path.stem
    out.format.media_type = "MULTI_LAYER_IMAGE"
    out.format.color_depth = "32"
    for socket in image.outputs:
        if not socket.is_unavailable:
            out.file_output_items.new("FLOAT" if socket.type == "VALUE" else socket.type, socket.name)
            tree.links.new(socket, out.inputs[socket.name])
    scene = bpy.context.scene
    scene.compositing_node_group = tree
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 128, 72, 100
    scene.render.compositor_precision = "FULL"
    bpy.ops.render.render()
    return channels(folder / path.name)[0]


def equal(a, b):
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def check(path, folder):
    def expect(holds, what):
        if not holds:
            sys.exit(f"failed: {path.name}: {what}")

    stored, recipe = channels(path)
    # A color without a name has that of its node and port, and the layer of images is no color's.
    masks = [{"images": "images_2", "mixed.b": "mixed_b"}.get(name, name) for name in recipe["names"]]
    images = [f"recipe.images.{channel}" for channel in "RGBA"] if recipe["images"] else []
    expect(stored.keys() == {*images, *(f"recipe.{mask}.Y" for mask in masks)}, f"the channels {sorted(stored)}")
    weights = numpy.stack([pixels for name, pixels in stored.items() if name not in images[:3]]).astype("f8")
    expect((weights >= 0).all() and (weights.sum(0) == 1).all(), "weights that are not ≥ 0 with the sum 1")
    expect(sum(mask.any() for mask in weights) > len(weights) / 2, "masks without anything on them")

    other = OpenImageIO.ImageInput.open(str(path))
    pixels = other.read_image(str(other.spec().format))
    read = {name: pixels[..., at] for at, name in enumerate(other.spec().channelnames)}
    expect(read.keys() == stored.keys(), f"OpenImageIO has the channels {sorted(read)}")
    expect(all(equal(read[name], stored[name]) for name in stored), "OpenImageIO reads other weights")

    # Blender calls the channel of a mask V.
    shown = in_blender(path, folder).items()
    read = {f"recipe.{name[:-1] + 'Y' if name.endswith('.V') else name}": mask for name, mask in shown}
    expect(read.keys() == stored.keys(), f"Blender shows {sorted(read)}")
    expect(all(equal(read[name], stored[name].astype("f4")) for name in stored), "Blender shows other weights")
    print(f"{path.name}: {len(masks)} masks{' and images' * bool(images)}, equal in OpenImageIO and Blender")


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    for path in made(folder):
        check(path, folder / "shown")
