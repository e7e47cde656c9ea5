"""What a scene knows of its graph: properties that are saved with it, animated and undone."""

import json
from contextlib import contextmanager
from pathlib import Path

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatVectorProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from . import colors
from .curves import renumber

# Numbers are custom properties, since only these have ranges and explanations of their own.
VALUE = "value"
# Since Blender 4.5, paths say whether they may begin with //, the folder of the file.
IS_TOLD = "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties
PATH = {"PATH_SUPPORTS_BLEND_RELATIVE"} if IS_TOLD else set()


class Calls:
    """What happens when somebody changes a property: set by `repaint`, which knows how to paint."""

    changed = None
    reread = None
    # Above 0 while properties are filled in by a program.
    quiet = 0


@contextmanager
def quietly():
    """Changes properties without painting for each of them."""
    Calls.quiet += 1
    try:
        yield
    finally:
        Calls.quiet -= 1


def changed(item, _context=None):
    """Repaints the scene that an item belongs to."""
    if not Calls.quiet and Calls.changed:
        Calls.changed(item.id_data)


def reread(settings, _context):
    """Reads the document anew after its path has changed."""
    if not Calls.quiet and Calls.reread:
        Calls.reread(settings.id_data)


class TrochoidSwatch(PropertyGroup):
    """A color of the document's palette."""

    color: FloatVectorProperty(
        name="Color",
        description="Color of the palette, as displayed. Every pixel is a mix of these",
        subtype="COLOR_GAMMA",
        size=3,
        min=0,
        max=1,
        update=changed,
    )
    original: FloatVectorProperty(subtype="COLOR_GAMMA", size=3)
    fixed: StringProperty()

    @property
    def is_changed(self):
        return not self.fixed and any(abs(a - b) > 1e-6 for a, b in zip(self.color, self.original))

    def reset(self):
        self.color = self.original

    def assignment(self, space):
        return colors.written(space, self.color)


class TrochoidKnob(PropertyGroup):
    """A knob of the document."""

    kind: StringProperty()
    # The document's own value, as JSON.
    original: StringProperty()
    help: StringProperty()
    fixed: StringProperty()
    color: FloatVectorProperty(name="Color", subtype="COLOR_GAMMA", size=3, min=0, max=1, update=changed)
    switch: BoolProperty(name="On", update=changed)
    text: StringProperty(name="Text", update=changed)

    @property
    def path(self):
        """The property that holds the value."""
        return {"NUMBER": f'["{VALUE}"]', "COLOR": "color", "SWITCH": "switch"}.get(self.kind, "text")

    @property
    def value(self):
        return self[VALUE] if self.kind == "NUMBER" else getattr(self, self.path)

    @property
    def is_changed(self):
        if self.fixed:
            return False
        original = json.loads(self.original)
        if self.kind == "COLOR":
            return any(abs(a - b) > 1e-6 for a, b in zip(self.color, original))
        return self.value != original

    def reset(self):
        original = json.loads(self.original)
        if self.kind == "NUMBER":
            self[VALUE] = original
        else:
            setattr(self, self.path, original)

    def assignment(self, space):
        if self.kind == "COLOR":
            return colors.written(space, self.color)
        value = self.value
        # A knob of whole numbers takes no 3.0.
        return int(value) if self.kind == "NUMBER" and value == int(value) else value

    def describe(self, knob):
        """Takes what the document says."""
        self.kind, self.help, self.fixed = knob.kind, knob.help, knob.fixed
        self.original = json.dumps(knob.value)
        if knob.kind == "NUMBER":
            self[VALUE] = knob.value
            limits = {"min": knob.least, "max": knob.most, "soft_min": knob.least, "soft_max": knob.most}
            limits = {name: float(limit) for name, limit in limits.items() if limit is not None}
            self.id_properties_ui(VALUE).update(description=knob.help, default=knob.value, **limits)


class TrochoidBinding(PropertyGroup):
    """A node that takes a pass of the render. Its name is that of the node."""

    source: StringProperty()
    use: BoolProperty(
        name="Take the Pass",
        description="Take the pass of the render in place of what the document has there",
        default=True,
        update=changed,
    )


class TrochoidFault(PropertyGroup):
    """A fault or a warning of the document."""

    is_error: BoolProperty()
    place: StringProperty()
    message: StringProperty()
    remedy: StringProperty()

    def __str__(self):
        return f"{self.place}{self.message}. {self.remedy}" if self.remedy else f"{self.place}{self.message}"


def outputs(settings, _context):
    """Items of the enumeration of outputs."""
    names = [name for name in settings.outputs.split("\n") if name]
    # Blender does not keep these texts alive.
    KEPT[:] = [(name, name, f'The output "{name}" of the document') for name in names] or [("", "None", "")]
    return KEPT


KEPT = []


class TrochoidScene(PropertyGroup):
    """The graph of a scene."""

    filepath: StringProperty(
        name="Graph",
        description="Document that paints the passes of this scene's renders",
        subtype="FILE_PATH",
        options=PATH,
        update=reread,
    )
    allow: StringProperty(
        name="Allow",
        description="Folder that the graph may reach besides its own, for graphs that you trust",
        subtype="DIR_PATH",
        options=PATH,
        update=reread,
    )
    output: EnumProperty(name="Output", description="Output of the document to paint", items=outputs, update=changed)
    # Names of the outputs with colors, and the layers that they have in files, one a line.
    outputs: StringProperty()
    layers_of_outputs: StringProperty()
    repaint: BoolProperty(
        name="Repaint After Render",
        description="Paint each frame as soon as it is rendered",
        default=True,
    )
    live: BoolProperty(name="Repaint on Change", description="Paint again when a color or a knob changes", default=True)
    frames: StringProperty(
        name="Frames",
        description=(
            "PNG or EXR file that each painted frame of an animation is written to, such as //shot.trochoid.####.png; "
            "none if empty"
        ),
        subtype="FILE_PATH",
        options=PATH,
    )
    image: PointerProperty(type=bpy.types.Image, name="Painting")
    palette: CollectionProperty(type=TrochoidSwatch)
    knobs: CollectionProperty(type=TrochoidKnob)
    bindings: CollectionProperty(type=TrochoidBinding)
    faults: CollectionProperty(type=TrochoidFault)
    space: StringProperty()
    has_plate: BoolProperty()
    # Layers of the plate that the document reads, one a line.
    layers: StringProperty()
    reads_objects: BoolProperty()
    # Width and height that the document states; 0 without a format.
    document_size: IntVectorProperty(size=2)
    # The document as it was when the panel was filled: time of the file's change.
    stamp: StringProperty()

    @property
    def path(self):
        """The document's file."""
        return Path(bpy.path.abspath(self.filepath, library=self.id_data.library))

    @property
    def is_valid(self):
        return bool(self.filepath) and bool(self.outputs) and not any(fault.is_error for fault in self.faults)

    def assignments(self):
        """Returns what was changed, as `set` takes it."""
        values = {f"palette.{swatch.name}": swatch.assignment(self.space) for swatch in self.palette if swatch.is_changed}
        values.update({f"knobs.{knob.name}": knob.assignment(self.space) for knob in self.knobs if knob.is_changed})
        return values

    def fill(self, read):
        """Takes what a document has. What was changed stays changed, and curves follow their colors and knobs."""
        self.space, self.has_plate, self.reads_objects = read.space, read.has_plate, read.reads_objects
        self.outputs, self.layers = "\n".join(read.outputs), "\n".join(read.layers)
        self.layers_of_outputs = "\n".join(read.outputs.values())
        self.document_size = read.format or (0, 0)
        if read.outputs and self.output not in read.outputs:
            self.output = next(iter(read.outputs))
        kept = {swatch.name: tuple(swatch.color) for swatch in self.palette if swatch.is_changed}
        order = [swatch.name for swatch in self.palette]
        self.palette.clear()
        for told in read.swatches:
            swatch = self.palette.add()
            swatch.name, swatch.fixed, swatch.original = told.name, told.fixed, told.color
            swatch.color = kept.get(told.name, told.color) if not told.fixed else told.color
        renumber(self.id_data, "trochoid.palette", order, [swatch.name for swatch in self.palette])
        kept = {knob.name: (knob.kind, knob.value) for knob in self.knobs if knob.is_changed}
        order = [knob.name for knob in self.knobs]
        self.knobs.clear()
        for told in read.knobs:
            knob = self.knobs.add()
            knob.name = told.name
            knob.describe(told)
            knob.reset()
            kind, value = kept.get(told.name, (None, None))
            if kind == told.kind and not told.fixed:
                if kind == "NUMBER":
                    knob[VALUE] = value
                else:
                    setattr(knob, knob.path, value)
        renumber(self.id_data, "trochoid.knobs", order, [knob.name for knob in self.knobs])

    def empty(self):
        """Forgets the document."""
        for items in (self.palette, self.knobs, self.bindings, self.faults):
            items.clear()
        self.outputs, self.layers, self.stamp = "", "", ""


CLASSES = [TrochoidSwatch, TrochoidKnob, TrochoidBinding, TrochoidFault, TrochoidScene]


def register():
    for known in CLASSES:
        bpy.utils.register_class(known)
    bpy.types.Scene.trochoid = PointerProperty(type=TrochoidScene)


def unregister():
    del bpy.types.Scene.trochoid
    for known in reversed(CLASSES):
        bpy.utils.unregister_class(known)


def stamp_of(path):
    """Returns what tells whether a file has changed."""
    try:
        told = path.stat()
    except OSError:
        return ""
    return f"{told.st_mtime_ns} {told.st_size}"
