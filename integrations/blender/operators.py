"""Operators: `bpy.ops.trochoid`."""

import bpy
from bpy.props import StringProperty
from bpy.types import Operator

from . import image, repaint


class TROCHOID_OT_open(Operator):
    """Open a graph that paints the renders of this scene"""

    bl_idname = "trochoid.open"
    bl_label = "Open Graph"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(self, context, _event):
        self.filepath = context.scene.trochoid.filepath
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        with repaint.properties.quietly():
            context.scene.trochoid.filepath = self.filepath
        return report_opening(self, context.scene)


class TROCHOID_OT_reload(Operator):
    """Read the graph again. Colors and knobs that were changed here stay changed"""

    bl_idname = "trochoid.reload"
    bl_label = "Reload Graph"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.trochoid.filepath)

    def execute(self, context):
        return report_opening(self, context.scene)


def report_opening(operator, scene):
    """Opens the scene's document, and reports what is wrong with it."""
    told = repaint.open_document(scene)
    errors = [text for is_error, text in told if is_error]
    for is_error, text in told:
        if not is_error:
            operator.report({"WARNING"}, text)
    if errors:
        # One report: from a program, the first one ends the operator.
        operator.report({"ERROR"}, "\n".join(errors))
        return {"CANCELLED"}
    for off in repaint.passes_off(scene):
        operator.report({"WARNING"}, repaint.sentence_of_pass(off))
    return {"FINISHED"}


class TROCHOID_OT_close(Operator):
    """Forget the graph of this scene"""

    bl_idname = "trochoid.close"
    bl_label = "Close Graph"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        context.scene.trochoid.filepath = ""
        return {"FINISHED"}


class TROCHOID_OT_paint(Operator):
    """Paint the last render with the graph, at the current frame"""

    bl_idname = "trochoid.paint"
    bl_label = "Paint"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if not context.scene.trochoid.filepath:
            cls.poll_message_set("Open a graph first")
            return False
        return True

    def execute(self, context):
        try:
            painting = repaint.now(context.scene)
        except Exception as error:  # A traceback tells users nothing; the console has it.
            repaint.fail(context.scene, error)
            off = [repaint.sentence_of_pass(off) for off in repaint.passes_off(context.scene)]
            self.report({"ERROR"}, "\n".join([repaint.state_of(context.scene).told, *off]))
            return {"CANCELLED"}
        self.report({"INFO"}, painting.told)
        return {"FINISHED"}


class TROCHOID_OT_enable_passes(Operator):
    """Switch on the passes that the graph needs. They are there after the next render"""

    bl_idname = "trochoid.enable_passes"
    bl_label = "Enable Passes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.scene.trochoid.is_valid

    def execute(self, context):
        scene = context.scene
        enabled = []
        for label, switch, layer in repaint.passes_off(scene):
            if switch:
                owner, name = repaint.owner_of(scene.view_layers[layer], switch)
                if owner is not None and hasattr(owner, name):
                    setattr(owner, name, True)
                    enabled.append(label)
        for off in repaint.passes_off(scene):
            self.report({"WARNING"}, repaint.sentence_of_pass(off))
        self.report({"INFO"}, f"Switched on: {', '.join(enabled) or 'nothing'}")
        return {"FINISHED"}


class TROCHOID_OT_reset(Operator):
    """Put colors and knobs back to what the graph says. Keyframes stay"""

    bl_idname = "trochoid.reset"
    bl_label = "Reset"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="palette.NAME or knobs.NAME; all if empty")

    @classmethod
    def poll(cls, context):
        return bool(context.scene.trochoid.filepath)

    def execute(self, context):
        settings = context.scene.trochoid
        items = [(f"palette.{item.name}", item) for item in settings.palette]
        items += [(f"knobs.{item.name}", item) for item in settings.knobs]
        chosen = [item for name, item in items if self.name in ("", name)]
        if not chosen:
            self.report({"ERROR"}, f'found "{self.name}"; expected palette.NAME or knobs.NAME of the graph')
            return {"CANCELLED"}
        with repaint.properties.quietly():
            for item in chosen:
                item.reset()
        repaint.soon(context.scene)
        return {"FINISHED"}


class TROCHOID_OT_show(Operator):
    """Show the painting in this image editor, or in the first one that is open"""

    bl_idname = "trochoid.show"
    bl_label = "Show Painting"

    @classmethod
    def poll(cls, context):
        if context.scene.trochoid.image is None:
            cls.poll_message_set("Nothing is painted yet: render an image (F12)")
            return False
        return True

    def execute(self, context):
        areas = [context.area] if context.area else []
        areas += [area for window in context.window_manager.windows for area in window.screen.areas]
        area = next((area for area in areas if area.type == "IMAGE_EDITOR"), None)
        if area is None:
            self.report({"WARNING"}, "found no image editor; open one to look at the painting")
            return {"CANCELLED"}
        area.spaces.active.image = context.scene.trochoid.image
        image.redraw()
        return {"FINISHED"}


CLASSES = [
    TROCHOID_OT_open,
    TROCHOID_OT_reload,
    TROCHOID_OT_close,
    TROCHOID_OT_paint,
    TROCHOID_OT_enable_passes,
    TROCHOID_OT_reset,
    TROCHOID_OT_show,
]
register, unregister = bpy.utils.register_classes_factory(CLASSES)
