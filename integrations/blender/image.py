"""Paintings as images of Blender, and the files beside its frames."""

import contextlib
import os
import re
from pathlib import Path

import bpy
import numpy as np

NAME = "Trochoid"
# Blender's name of linear light with the primaries of Rec. 709.
LINEAR = "Linear Rec.709"


class Unwritable(Exception):
    """No painted frame may have that name. The message says why, and what to do."""


def show(scene, painting):
    """Puts a painting into the scene's image, which is made if there is none.

    Its pixels are linear light, so Blender displays what the program's PNG shows. They are not seen through the scene's view
    transform, such as AgX, which would take the picture off its palette.
    """
    height, width, _ = painting.pixels.shape
    image = scene.trochoid.image
    # The copy of a scene has the image of the first.
    is_shared = any(other.trochoid.image == image for other in bpy.data.scenes if other != scene)
    if image is None or is_shared or image.library is not None or not image.is_float:
        image = bpy.data.images.new(NAME, width, height, alpha=False, float_buffer=True)
        scene.trochoid.image = image
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    if image.colorspace_settings.name != LINEAR:
        with contextlib.suppress(TypeError):
            # A configuration of OpenColorIO may call it otherwise; new images of floats are linear light in any case.
            image.colorspace_settings.name = LINEAR
    image.use_view_as_render = False
    # Blender has rows from below.
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = painting.pixels[::-1]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def frame_file(scene, frame):
    """Returns the file of a painted frame; None if none is to be written. Raises Unwritable."""
    settings = scene.trochoid
    if not settings.frames:
        return None
    found = f"found the frames {settings.frames}"
    if settings.frames.startswith("//") and not (scene.library or bpy.data.filepath):
        raise Unwritable(f"{found}; expected a whole path, or // in a file that was saved: save this one first")
    pattern = Path(bpy.path.abspath(settings.frames, library=scene.library))
    ending = pattern.suffix.lower()
    if ending not in (".png", ".exr"):
        raise Unwritable(f"{found}; expected a name that ends in .png or .exr")
    if ending == ".exr" and not settings.has_plate:
        expected = 'a PNG, since the document has no knob "plate": an EXR is written from the file with the passes'
        raise Unwritable(f"{found}; expected {expected}")
    file = pattern.with_name(numbered(pattern.name, frame))
    if any(is_same(file, own) for own in own_files(scene, frame)):
        expected = "another name: Blender writes its own frame to that file"
        raise Unwritable(f"{found}, which is {file} at frame {frame}; expected {expected}")
    return None if file.exists() and not scene.render.use_overwrite else file


def numbered(name, frame):
    """Returns the name of a frame's file. As for Blender's own, the last signs stand for the number, and a sign has no
    place among them; but a name without signs gets the number before its ending."""
    if "#" not in name:
        stem, ending = Path(name).stem, Path(name).suffix
        name = f"{stem}####{ending}"
    start, signs, rest = re.fullmatch(r"(.*?)(#+)([^#]*)", name, re.DOTALL).groups()
    return f"{start}{'-' if frame < 0 else ''}{str(abs(frame)).zfill(len(signs))}{rest}"


def own_files(scene, frame):
    """Returns the files that Blender may write a frame to: one of an animation, and a still, whose name has no number."""
    render = scene.render
    still = Path(bpy.path.abspath(render.filepath, library=scene.library))
    endings = [still.name + render.file_extension, still.stem + render.file_extension]
    return [Path(render.frame_path(frame=frame)), still, *map(still.with_name, endings if still.name else [])]


def is_same(file, other):
    """Whether two paths are of one file, which may not be there yet."""
    with contextlib.suppress(OSError):
        # Not every file system tells capital letters from small ones.
        return os.path.samefile(file, other)
    return os.path.normcase(os.path.realpath(file)) == os.path.normcase(os.path.realpath(other))


def fault_of_frames(scene):
    """Returns why painted frames cannot be written; empty if they can, or if none are to be."""
    try:
        frame_file(scene, scene.frame_current)
    except Unwritable as error:
        return str(error)
    return ""


def redraw():
    """Draws the panels and images anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("PROPERTIES", "IMAGE_EDITOR"):
                area.tag_redraw()
