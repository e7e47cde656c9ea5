"""What happens when Blender renders, undoes, loads a file or changes frames."""

import bpy
from bpy.app.handlers import persistent

from . import properties, repaint


@persistent
def begin(scene, *_):
    repaint.WORK.is_rendering = True
    repaint.before_render(scene)


@persistent
def after_frame(scene, *_):
    repaint.after_render(scene)


@persistent
def after_write(scene, *_):
    repaint.after_write(scene)


@persistent
def end(scene, *_):
    repaint.WORK.is_rendering = False
    repaint.after_all(scene)


@persistent
def frame_changed(scene, depsgraph=None):
    settings = scene.trochoid
    if not settings.filepath:
        return
    if repaint.WORK.is_rendering and depsgraph is not None:
        animated = scene.evaluated_get(depsgraph)
        repaint.state_of(scene).animated = {animated.frame_current: animated.trochoid.assignments()}
    elif scene.frame_current == repaint.state_of(scene).rendered:
        # At other frames, the passes are not those of the frame; Paint takes them all the same.
        repaint.soon(scene)


@persistent
def changed(scene, _depsgraph=None):
    # Custom properties, which hold the numbers, have no callback of their own.
    if scene.trochoid.filepath and scene.frame_current == repaint.state_of(scene).rendered:
        repaint.soon(scene)


@persistent
def undone(_scene, *_):
    for scene in bpy.data.scenes:
        if scene.trochoid.filepath:
            if scene.trochoid.image is None:
                # It was made after what is undone.
                repaint.state_of(scene).painted = None
            repaint.soon(scene)


@persistent
def loaded(*_):
    """Forgets the renders of the file before, and reads documents again if they have changed since the file was saved."""
    repaint.forget()
    for scene in bpy.data.scenes:
        settings = scene.trochoid
        if settings.filepath and properties.stamp_of(settings.path) != settings.stamp:
            repaint.open_document(scene)


HANDLERS = {
    "render_init": begin,
    "render_post": after_frame,
    "render_write": after_write,
    "render_complete": end,
    "render_cancel": end,
    "frame_change_post": frame_changed,
    "depsgraph_update_post": changed,
    "undo_post": undone,
    "redo_post": undone,
    "load_post": loaded,
}


def register():
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
