"""Paints passes by a document. This module needs no Blender, and runs in any thread.

A document with the knob `plate` is rendered as the command `render` does, with the file of the passes as the knob's value. Of
any other, passes take the place of the nodes that have their names, as arrays.
"""

import contextlib
import os
import secrets
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import trochoid

from . import colors, document, passes, plate

# The property that lets a document reach a folder, as users find it.
ALLOW = "Allow in the panel Trochoid"
# Held while files with passes are read or written: a render replaces them in whatever thread it has.
PASSES = threading.RLock()


class Unpaintable(Exception):
    """There is no picture. The message says why, and what to do."""


@dataclass
class Request:
    """What to paint."""

    document: Path
    # What tells whether the document's file has changed.
    stamp: str
    output: str
    # Its layer in files; empty if it is the main one.
    layer: str
    # Working space of the document.
    space: str
    # What was changed, as `set` takes it.
    set: dict
    frame: int
    # File with the passes, and their view layer.
    plate: Path
    view_layer: str
    # Whether the document names that file itself, by its knob.
    has_plate: bool
    # Folders that the document may reach besides its own.
    allow: list
    # Width and height: of the render, and those that the document states, or 0.
    render_size: tuple
    size: tuple
    # Passes by the names of the nodes that they are bound to.
    bound: dict = field(default_factory=dict)
    # Length of Blender's unit in meters.
    scale: float = 1.0
    # Frame at which the passes were rendered.
    rendered: int | None = None


@dataclass
class Painting:
    """A picture."""

    request: Request
    # Rows from the top, in linear light with the primaries of Rec. 709.
    pixels: np.ndarray
    # What was counted, for people.
    told: str
    # The picture as PNG; None if the program renders one.
    png: bytes | None = None


def go_on(_done, _total):
    return True


def paint(request, progress=go_on):
    """Paints. Raises Unpaintable or trochoid.Cancelled."""
    begun = time.perf_counter()
    try:
        painting = rendered(request, progress) if request.has_plate else composed(request, progress)
    except trochoid.Cancelled:
        raise
    except trochoid.InvalidDocument as error:
        raise Unpaintable("\n".join(sentence(fault, request.document) for fault in error.diagnostics) or str(error)) from error
    except (trochoid.Error, ValueError, KeyError, OSError) as error:
        raise Unpaintable(str(error)) from error
    painting.told += f", {time.perf_counter() - begun:.2f} s"
    if request.rendered not in (None, request.frame):
        painting.told += f", passes of frame {request.rendered}"
    return painting


def composed(request, progress):
    """Paints with passes as arrays."""
    look = look_of(request)
    with PASSES:
        inputs = {slot.name: taken(request, slot) for slot in look.slots if slot.is_used}
    picture = look.picture(inputs, size=request.render_size, progress=progress)
    pixels = colors.to_linear(request.space, picture.numpy()).astype(np.float32)
    audit = picture.audit
    return Painting(request, pixels, counts(audit.hull_exits, audit.pixels), picture.png())


def look_of(request):
    """Returns the document with its inputs."""
    options = {
        "output": request.output,
        "inputs": list(request.bound),
        "set": request.set,
        "frame": request.frame,
        # Light goes beyond what a mask may hold.
        "illegal": "clamp",
    }
    if request.size[0]:
        return trochoid.Look.load(request.document, **options)
    # Without a format of its own, what it gives in pixels is in those of the render.
    text = document.with_size(document.text_of(request.document), request.render_size)
    return trochoid.Look(text, folder=request.document.parent, name=str(request.document), **options)


def taken(request, slot):
    """Returns the samples of an input: a pass, as documents mean it."""
    known = request.bound[slot.name]
    try:
        values = plate.read_pass(request.plate, request.view_layer, known, request.render_size)
    except plate.Missing as error:
        found = f'found no pass {known.names[0]} of the view layer "{request.view_layer}" in the render'
        remedy = f"switch on {known.label} there, and render that view layer again"
        raise Unpaintable(f'node "{slot.name}": {found}; expected one: {remedy} ({error})') from error
    values = passes.fitted(known, passes.converted(known, values, request.scale), slot.channels)
    if values is None:
        found = f"found the pass {known.names[0]} of {len(known.channels)} channels; expected {slot.channels}"
        remedy = "rename the node, or switch the pass off in the panel"
        raise Unpaintable(f'node "{slot.name}": {found}: {remedy}')
    return values


def rendered(request, progress):
    """Paints as the command `render` does."""
    file = request.plate.with_suffix(".painted.exr")
    with PASSES:
        told = render(request, file, progress)["outputs"][request.output]
        pixels = plate.read(file, request.layer, "RGB", request.size)
    if request.space == "acescg":
        pixels = colors.to_linear(request.space, pixels).astype(np.float32)
    return Painting(request, pixels, counts(told["hull_exits"], told["pixels"]))


def render(request, file, progress=go_on):
    """Renders the document to a file, and returns what is counted."""
    with PASSES:
        frames = trochoid.render(
            request.document,
            frames=request.frame,
            output=request.output,
            out=str(file).replace("#", "\\#").replace("%", "\\%"),
            set=request.set,
            allow=request.allow,
            overwrite=True,
            progress=progress,
        )
    return frames[0]


def write(painting, file):
    """Writes a painting to a file, as the program makes it: all of it, or nothing. Raises Unpaintable."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        replace(file, painting.png or encoded(painting.request, file.suffix.lower()))
    except (trochoid.Error, OSError) as error:
        raise Unpaintable(f"{file}: {error}") from error


def encoded(request, ending):
    """Returns a picture as the program renders it to a file. Its name for the program is a pattern, in which braces mean more
    than they do in that of a frame."""
    file = request.plate.with_suffix(f".written{ending}")
    with PASSES:
        try:
            render(request, file)
            return file.read_bytes()
        finally:
            file.unlink(missing_ok=True)


def replace(file, data):
    """Writes a file under another name beside its place, and then takes that place, so that no half of it is ever there."""
    # The program removes what looks like its own partial files and is not locked; this name does not.
    partial = file.with_name(f".trochoid-blender-{secrets.token_hex(8)}.partial")
    try:
        # With the permissions that any new file gets.
        with open(partial, "xb") as opened:
            opened.write(data)
        os.replace(partial, file)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise


def counts(outside, pixels):
    return f"hull, {outside} of {pixels} pixels outside"


def sentence(fault, path):
    """Returns a diagnostic of Trochoid as text. `path` is the document's."""
    told = place(fault, path) + message(fault)
    return f"{told}; {remedy(fault)}" if fault.get("remedy") else told


def place(fault, path):
    """Returns where a fault is: `line 7: node "beauty", weight: `."""
    file, line, node, port = (fault.get(key) for key in ("file", "line", "node", "port"))
    parts = []
    if line:
        # A palette may be in a file of its own.
        parts.append(f"line {line}" if Path(file) == path else f"{Path(file).name}, line {line}")
    elif file and node:
        # What was set, and at which node it will not do.
        parts.append(file.removeprefix("--set "))
    if node:
        parts.append(f'node "{node}", {port}' if port else f'node "{node}"')
    elif port:
        parts.append(port)
    return "".join(f"{part}: " for part in parts)


def remedy(fault):
    """Returns what to do, in the words of the panel: there are no options to give."""
    told, is_refused, folders = (fault.get("remedy") or "").partition("--allow ")
    return f"{told}choose {folders.replace(' --allow ', ', ')} as {ALLOW}" if is_refused else told


def message(fault):
    return f"found {fault['found']}; expected {fault['expected']}"
