"""Panels: in the Output tab of the Properties editor, and in the sidebar of the Image editor."""

import textwrap

import bpy
from bpy.types import Panel

from . import image, paint, render_result, repaint


class Main:
    bl_label = "Trochoid"

    def draw(self, context):
        draw_graph(self.layout, context.scene)


class Palette:
    bl_label = "Palette"

    @classmethod
    def poll(cls, context):
        return len(context.scene.trochoid.palette) > 0

    def draw(self, context):
        settings = context.scene.trochoid
        column = keyed(self.layout)
        for swatch in settings.palette:
            draw_item(column, swatch, "color", f"palette.{swatch.name}")


class Knobs:
    bl_label = "Knobs"

    @classmethod
    def poll(cls, context):
        return len(context.scene.trochoid.knobs) > 0

    def draw(self, context):
        column = keyed(self.layout)
        for knob in context.scene.trochoid.knobs:
            draw_item(column, knob, knob.path, f"knobs.{knob.name}")
            if knob.help and knob.kind != "NUMBER":
                note(column, knob.help)


class Passes:
    bl_label = "Passes"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.trochoid.is_valid

    def draw(self, context):
        draw_passes(self.layout, context.scene)


def draw_graph(layout, scene):
    settings = scene.trochoid
    row = layout.row(align=True)
    row.prop(settings, "filepath", text="")
    row.operator("trochoid.reload", text="", icon="FILE_REFRESH")
    if not settings.filepath:
        note(layout, "Open a graph (.json), and render.")
        return
    draw_state(layout, scene)
    if settings.allow or any(fault.remedy.endswith(paint.ALLOW) for fault in settings.faults):
        layout.prop(settings, "allow")
    if not settings.is_valid:
        return
    if settings.outputs.count("\n"):
        layout.prop(settings, "output")
    column = layout.column(align=True)
    column.prop(settings, "repaint")
    column.prop(settings, "live")
    layout.prop(settings, "frames")
    if fault := image.fault_of_frames(scene):
        tell(layout, fault, "ERROR")
    row = layout.row(align=True)
    row.operator("trochoid.paint", icon="BRUSH_DATA")
    row.operator("trochoid.show", text="Show", icon="IMAGE_DATA")
    row.operator("trochoid.reset", text="Reset", icon="LOOP_BACK").name = ""


def draw_state(layout, scene):
    """Draws what is known of the document and of the last painting."""
    settings, state = scene.trochoid, repaint.state_of(scene)
    for fault in settings.faults:
        box = layout.box()
        tell(box, f"{fault.place}{fault.message}", "ERROR" if fault.is_error else "INFO")
        if fault.remedy:
            note(box, fault.remedy)
    if settings.is_valid:
        for obstacle in render_result.obstacles(scene):
            tell(layout, obstacle, "ERROR")
        for off in repaint.passes_off(scene):
            tell(layout, repaint.sentence_of_pass(off), "ERROR")
        if any(switch for _, switch, _ in repaint.passes_off(scene)):
            layout.operator("trochoid.enable_passes", icon="RENDERLAYERS")
        if not settings.faults and not state.told:
            layout.label(text="Checked", icon="CHECKMARK")
    if (progress := repaint.WORK.progress_of(scene.session_uid)) is not None:
        layout.progress(factor=progress, text="Painting")
    elif state.told:
        tell(layout, state.told, "ERROR" if state.has_failed else "CHECKMARK")
    if missed := repaint.frames_missed(scene):
        tell(layout, missed, "ERROR")


def draw_item(layout, item, path, name):
    """Draws a color or a knob: its value, and how to put it back, or why it cannot change."""
    row = layout.row(align=True)
    value = row.row(align=True)
    value.enabled = not item.fixed
    value.prop(item, path, text=item.name, slider=True)
    if item.fixed:
        row.label(text="", icon="LOCKED")
        note(layout, item.fixed)
    elif item.is_changed:
        row.operator("trochoid.reset", text="", icon="LOOP_BACK").name = name


def draw_passes(layout, scene):
    settings = scene.trochoid
    if settings.has_plate:
        note(layout, "The knob plate names the file with the passes.")
        for layer in filter(None, settings.layers.split("\n")):
            layout.label(text=layer, icon="RENDERLAYERS")
        if settings.reads_objects:
            layout.label(text="Cryptomatte", icon="RENDERLAYERS")
        return
    if not settings.bindings:
        note(layout, "No node has the name of a pass, such as depth or diffuse_direct, and no knob is called plate.")
    for binding in settings.bindings:
        row = layout.row()
        row.prop(binding, "use", text=binding.name)
        row.label(text=binding.source, icon="RENDERLAYERS")


def keyed(layout):
    """Returns a column whose properties have a dot beside them, which keys them."""
    column = layout.column(align=True)
    column.use_property_split = True
    return column


def tell(layout, text, icon):
    """Draws a text in as many lines as it needs, with an icon before the first."""
    column = layout.column(align=True)
    for at, line in enumerate(wrapped(text)):
        column.label(text=line, icon="BLANK1" if at else icon)


def note(layout, text):
    """Draws a text for which there is no need to look twice."""
    column = layout.column(align=True)
    column.active = False
    for line in wrapped(text):
        column.label(text=line)


def wrapped(text):
    """Breaks a text into lines that fit the region. Blender does not do it, nor does it tell how wide letters are."""
    letters = bpy.context.region.width / (7 * bpy.context.preferences.system.ui_scale) - 8
    return [line for part in text.split("\n") for line in textwrap.wrap(part, max(int(letters), 20)) or [""]]


def panels(space, region, where):
    """Returns the panels for an editor."""
    parent = f"TROCHOID_PT_{space.lower()}"
    place = {"bl_space_type": space, "bl_region_type": region, **where}
    found = [type(parent, (Main, Panel), {"bl_idname": parent, **place})]
    for part in (Palette, Knobs, Passes):
        name = f"{parent}_{part.__name__.lower()}"
        found.append(type(name, (part, Panel), {"bl_idname": name, "bl_parent_id": parent, **place}))
    return found


CLASSES = [
    *panels("PROPERTIES", "WINDOW", {"bl_context": "output"}),
    *panels("IMAGE_EDITOR", "UI", {"bl_category": "Trochoid"}),
]
register, unregister = bpy.utils.register_classes_factory(CLASSES)
