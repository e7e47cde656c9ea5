"""Reads passes and pictures from EXR files. This module needs no Blender."""

import struct

import numpy as np
import trochoid


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
    """Returns width and height of a file that `save` wrote, from its header."""
    with open(path, "rb") as file:
        # Magic number and version; then attributes: name, type, number of bytes, value.
        header = file.read(65536)
    at = header.index(b"displayWindow\0box2i\0") + len(b"displayWindow\0box2i\0") + 4
    left, top, right, bottom = struct.unpack_from("<4i", header, at)
    return right - left + 1, bottom - top + 1
