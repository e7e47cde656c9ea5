"""The passes of the last render, in a file.

Blender shows no pixels of a render's passes to Python, so they go through a multilayer EXR in its temporary folder.
"""

from contextlib import contextmanager, suppress
from pathlib import Path

import bpy


def path_of(scene):
    """Returns the file that has the passes of a scene's last render."""
    return Path(bpy.app.tempdir) / f"trochoid-{scene.session_uid}.exr"


def remove_all():
    """Removes the files with passes of all scenes. Blender itself removes its folder only when it ends."""
    for file in Path(bpy.app.tempdir).glob("trochoid-*.exr"):
        with suppress(OSError):
            file.unlink()


def result():
    """Returns the image with the last render; None if there is none."""
    return next((image for image in bpy.data.images if image.type == "RENDER_RESULT"), None)


def obstacles(scene):
    """Says why renders of a scene cannot be painted, and what to switch."""
    return without_passes(scene) + without_pictures(scene)


def without_passes(scene):
    """Says why renders have a picture, but no passes that could be saved."""
    found = []
    if scene.render.use_multiview:
        found.append("found Stereoscopy; expected one view: switch it off in the Output tab, and render again")
    if strips(scene):
        remedy = "switch off Sequencer under Post Processing in the Output tab, and render again"
        found.append(f"found strips of the Video Sequencer, which have no passes; expected a render of the scene: {remedy}")
    return found


def without_pictures(scene):
    """Says why renders have no picture at all."""
    if scene.camera is None:
        return ["found no camera; expected one: choose it in the Scene tab, and render again"]
    if not any(layer.use for layer in scene.view_layers):
        remedy = "switch on Use for Rendering in the View Layer tab, and render again"
        return [f"found no view layer that is rendered; expected one: {remedy}"]
    return []


def strips(scene):
    """Returns the strips that are rendered in place of a scene."""
    editor = scene.sequence_editor if scene.render.use_sequencer else None
    # Since Blender 4.4, they are called strips.
    all_strips = getattr(editor, "strips", None) or getattr(editor, "sequences", None) or []
    # In Blender 4.2, muted strips take the scene's place, too; in 4.5, they do not.
    return [strip for strip in all_strips if strip.type != "SOUND" and (not strip.mute or bpy.app.version < (4, 3))]


def save(scene):
    """Saves all passes of the last render of a scene, uncompressed, as 32-bit floats. Returns the file.

    Raises OSError if there is no render, if it has no passes, or if Blender cannot write it.
    """
    image = result()
    if image is None:
        raise FileNotFoundError("found no render; expected one: render an image first (F12)")
    if told := without_passes(scene):
        # Blender would write a file all the same.
        raise OSError("\n".join(told))
    path = path_of(scene)
    try:
        with written_as(scene.render.image_settings, "OPEN_EXR_MULTILAYER", color_depth="32", exr_codec="NONE"):
            image.save_render(str(path), scene=scene)
    except RuntimeError as error:
        reason = f"found that Blender cannot write {path}; expected a render, and room: render an image first (F12)"
        raise OSError("\n".join(without_pictures(scene)) or f"{reason} ({str(error).strip()})") from error
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
