"""The passes of the last render, in a file.

Blender shows no pixels of a render's passes to Python, so they go through a multilayer EXR in its temporary folder.
"""

from contextlib import contextmanager
from pathlib import Path

import bpy


def path_of(scene):
    """Returns the file that has the passes of a scene's last render."""
    return Path(bpy.app.tempdir) / f"trochoid-{scene.session_uid}.exr"


def result():
    """Returns the image with the last render; None if there is none."""
    return next((image for image in bpy.data.images if image.type == "RENDER_RESULT"), None)


def save(scene):
    """Saves all passes of the last render of a scene, uncompressed, as 32-bit floats. Returns the file.

    Raises FileNotFoundError if there is none, and OSError if Blender cannot write it.
    """
    image = result()
    if image is None:
        raise FileNotFoundError("found no render; expected one: render an image first (F12)")
    path = path_of(scene)
    try:
        with written_as(scene.render.image_settings, "OPEN_EXR_MULTILAYER", color_depth="32", exr_codec="NONE"):
            image.save_render(str(path), scene=scene)
    except RuntimeError as error:
        raise OSError(f"{path}: found that Blender cannot write the passes; expected room there ({error})") from error
    return path


@contextmanager
def written_as(settings, file_format, **values):
    """Sets the format of files that Blender writes, and puts everything back as it was."""
    before = taken(settings)
    try:
        # Since Blender 5.0, formats are grouped by what they hold.
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE" if file_format == "OPEN_EXR_MULTILAYER" else "IMAGE"
        settings.file_format = file_format
        for name, value in {"use_preview": False, **values}.items():
            setattr(settings, name, value)
        yield
    finally:
        put_back(settings, before)


def taken(settings):
    """Returns the values of all settings of a format."""
    simple = [known.identifier for known in settings.bl_rna.properties if known.type != "POINTER" and not known.is_readonly]
    # Others depend on these two, in this order.
    first = [name for name in ("media_type", "file_format") if name in simple]
    return {name: getattr(settings, name) for name in first + [name for name in simple if name not in first]}


def put_back(settings, values):
    """Sets values that were taken."""
    for name, value in values.items():
        if getattr(settings, name) != value:
            setattr(settings, name, value)
