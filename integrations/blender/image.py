"""Paintings as images of Blender, and the files beside its frames."""

import contextlib
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
    if image is None or image.library is not None or not image.is_float:
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
    pattern = Path(bpy.path.abspath(settings.frames, library=scene.library))
    ending = pattern.suffix.lower()
    if ending not in (".png", ".exr"):
        raise Unwritable(f"found the frames {settings.frames}; expected a name that ends in .png or .exr")
    if ending == ".exr" and not settings.has_plate:
        expected = 'a PNG, since the document has no knob "plate": an EXR is written from the file with the passes'
        raise Unwritable(f"found the frames {settings.frames}; expected {expected}")
    # As Blender does it, a name without signs gets the number before its ending.
    name = pattern.name if "#" in pattern.name else f"{pattern.stem}####{pattern.suffix}"
    file = pattern.with_name(re.sub("#+", lambda signs: str(frame).zfill(len(signs[0])), name))
    return None if file.exists() and not scene.render.use_overwrite else file


def redraw():
    """Draws the panels and images anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("PROPERTIES", "IMAGE_EDITOR"):
                area.tag_redraw()
