"""Reads passes and pictures from EXR files. This module needs no Blender."""

import os
import struct

import numpy as np
import trochoid

# How EXR files begin.
MAGIC = b"\x76\x2f\x31\x01"
# Names in headers have up to 255 letters, and no program writes this many attributes.
MOST_LETTERS = 255
MOST_ATTRIBUTES = 10_000


class Unreadable(OSError):
    """The file is not what Blender writes."""


class Missing(OSError):
    """The file has no such pass."""


def read(path, layer, channels, size):
    """Reads a layer as an array of rows, columns and channels. The main layer has no name. Raises Missing if the file lacks
    it, or has another size."""
    node = {"type": "Read", "file": path.name, "as": "field", "channels": list(channels)}
    if layer:
        node["layer"] = layer
    document = {
        "trochoid": 1,
        "format": {"width": size[0], "height": size[1]},
        "nodes": {"pass": node},
        "outputs": {"pass": {"field": "pass"}},
    }
    try:
        look = trochoid.Look(document, folder=path.parent, name=path.name)
        return look.picture(size=size).numpy().reshape(size[1], size[0], len(channels))
    except (trochoid.Error, ValueError, OSError) as error:
        raise Missing(str(error)) from error


def read_pass(path, view_layer, known, size):
    """Reads a pass by any of its names."""
    missing = None
    for name in known.names:
        try:
            return np.ascontiguousarray(read(path, f"{view_layer}.{name}", known.channels, size))
        except Missing as error:
            missing = missing or error
    raise missing


def size_of(path):
    """Returns width and height of a file that `save` wrote, from its header. Raises Unreadable."""
    with open(path, "rb") as file:
        if file.read(4) != MAGIC:
            raise Unreadable(f"{path}: found another kind of file; expected an EXR: render again")
        file.read(4)  # The version.
        # Attributes: name, type, number of bytes, value. The names of objects in a cryptomatte come first and have any length.
        for _ in range(MOST_ATTRIBUTES):
            # A name of no letters ends the header.
            if not (name := text(file)):
                break
            kind = text(file)
            (length,) = struct.unpack("<i", exactly(file, 4))
            if (name, kind, length) == (b"displayWindow", b"box2i", 16):
                left, top, right, bottom = struct.unpack("<4i", exactly(file, 16))
                return right - left + 1, bottom - top + 1
            if length < 0:
                break
            file.seek(length, os.SEEK_CUR)
    raise Unreadable(f"{path}: found a header without the size; expected one with a displayWindow: render again")


def text(file):
    """Returns a text of a header, which ends with a zero byte."""
    found = bytearray()
    while (byte := exactly(file, 1)) != b"\0":
        found += byte
        if len(found) > MOST_LETTERS:
            raise Unreadable(f"{file.name}: found a name of more than {MOST_LETTERS} letters; expected a header: render again")
    return bytes(found)


def exactly(file, count):
    """Reads a number of bytes."""
    found = file.read(count)
    if len(found) < count:
        raise Unreadable(f"{file.name}: found the end of the file; expected the rest of its header: render again")
    return found
