"""What a panel needs to know of a document: its palette, its knobs, its outputs, and the passes that it reads.

Only `trochoid` itself decides what is valid. This reads what is there, from documents that it accepted.
"""

import json
from dataclasses import dataclass
from pathlib import Path

from . import colors

PLATE = "plate"
PLATE_LINK = f"= knobs.{PLATE}"
# Knobs of nodes that name a layer of the file.
LAYERS = ("layer", "depth", "position", "normal", "coverage")


@dataclass(frozen=True)
class Swatch:
    """A color of the palette."""

    name: str
    color: tuple = (0.5, 0.5, 0.5)
    # Why it cannot be changed here; empty if it can.
    fixed: str = ""


@dataclass(frozen=True)
class Knob:
    """A knob of the document. `kind` is NUMBER, COLOR, SWITCH or TEXT."""

    name: str
    kind: str
    value: object
    least: float | None = None
    most: float | None = None
    help: str = ""
    fixed: str = ""


@dataclass(frozen=True)
class Document:
    """A document that was read from a file."""

    path: Path
    space: str
    swatches: list
    knobs: list
    # Outputs that have colors, with their layers in files.
    outputs: dict
    # Width and height; None without a format.
    format: tuple | None
    has_plate: bool
    # Layers that it reads from the plate.
    layers: list
    # Whether it makes masks of the objects of the plate without naming their layer.
    reads_objects: bool
    # Names of its nodes.
    nodes: list


def text_of(path):
    """Returns the text of a document. Raises OSError or ValueError."""
    return Path(path).read_text(encoding="utf-8-sig")


def states_size(text):
    """Whether a document states its size, or takes that of the file with the passes, so that the program renders it as it is.
    Also if it is no document at all: the program says why."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return True
    return not isinstance(data, dict) or "format" in data or PLATE in mapping(data, "knobs")


def with_size(text, size):
    """Returns a document that states no size with one. Its lines are the same, for those are told."""
    before, _, after = text.partition("{")
    return f'{before}{{"format": {{"width": {size[0]}, "height": {size[1]}}},{after}'


def read(path):
    """Reads a document. Raises OSError or ValueError if it is no JSON object, and any other error if it is faulty."""
    path = Path(path)
    data = json.loads(text_of(path))
    if not isinstance(data, dict):
        raise ValueError(f"{path}: expected a JSON object")
    space = data.get("working_space", "linear-srgb")
    knobs = [knob(space, name, value) for name, value in mapping(data, "knobs").items()]
    nodes = mapping(data, "nodes")
    of_groups = [node for group in mapping(data, "groups").values() for node in mapping(group, "nodes").values()]
    readers = [node for node in [*nodes.values(), *of_groups] if reads_plate(node)]
    layers = {node[name]: None for node in readers for name in LAYERS if isinstance(node.get(name), str)}
    picture = data.get("format")
    return Document(
        path=path,
        space=space,
        swatches=swatches(path, space, data.get("palette")),
        knobs=[knob for knob in knobs if knob.name != PLATE],
        outputs={name: output.get("layer", "") for name, output in mapping(data, "outputs").items() if is_color(output)},
        format=(picture["width"], picture["height"]) if isinstance(picture, dict) else None,
        has_plate=PLATE in mapping(data, "knobs"),
        layers=list(layers),
        reads_objects=any(node.get("type") == "CryptoMask" and "layer" not in node for node in readers),
        nodes=list(nodes),
    )


def mapping(data, key):
    value = data.get(key) if isinstance(data, dict) else None
    return value if isinstance(value, dict) else {}


def is_color(output):
    return isinstance(output, dict) and "color" in output


def reads_plate(node):
    file = node.get("file") if isinstance(node, dict) else None
    return isinstance(file, str) and file.replace(" ", "") == PLATE_LINK.replace(" ", "")


def swatches(path, space, palette):
    """Returns the colors of a palette, which may be in a file beside the document."""
    if isinstance(palette, str):
        file = path.parent / palette
        if file.suffix.lower() != ".json":
            return []
        try:
            palette = json.loads(text_of(file))
        except (OSError, ValueError, RecursionError):
            # `trochoid.check` says what is wrong with it.
            return []
        palette = palette.get("palette", palette) if isinstance(palette, dict) else None
    if not isinstance(palette, dict):
        return []
    return [swatch(space, name, value) for name, value in palette.items()]


def swatch(space, name, value):
    color = colors.shown(space, value)
    if color is None:
        shown = first(space, value)
        return Swatch(name, shown or Swatch.color, reason(value) or "It is no plain color")
    if not all(-1e-9 <= channel <= 1 + 1e-9 for channel in color):
        clamped = tuple(min(max(channel, 0.0), 1.0) for channel in color)
        return Swatch(name, clamped, "An sRGB display cannot show it, so no swatch can")
    return Swatch(name, color)


def first(space, value):
    """Returns the color of the first key of a keyed color."""
    return next((colors.shown(space, key[1]) for key in keys_of(value)), None)


def keys_of(value):
    """Returns the keys of a keyed value: lists of a frame and a value. What is none of that, the program tells."""
    keys = value.get("keys") if isinstance(value, dict) else None
    keys = keys if isinstance(keys, list) else []
    return [key for key in keys if isinstance(key, list) and len(key) > 1 and colors.is_number(key[0])]


def reason(value):
    """Returns why a value cannot be changed here; empty if it can."""
    if isinstance(value, dict) and "keys" in value:
        frames = [key[0] for key in keys_of(value)]
        told = f": {len(frames)} keys, frames {frames[0]:g} to {frames[-1]:g}" if frames else ""
        return f"The document animates it{told}"
    if isinstance(value, str) and value.startswith("="):
        return f"It follows from others: {value}"
    if isinstance(value, (list, dict)):
        return "It is a list: change it in the document, and press Reload"
    return ""


def knob(space, name, entry):
    told = entry if isinstance(entry, dict) and "keys" not in entry else {"value": entry}
    value, help = told.get("value"), told.get("help", "")
    unit = told.get("unit")
    help = f"{help} ({unit})" if unit else help
    if colors.is_number(value):
        return Knob(name, "NUMBER", float(value), told.get("min"), told.get("max"), help)
    if isinstance(value, bool):
        return Knob(name, "SWITCH", value, help=help)
    color = colors.shown(space, value)
    if color is not None and (isinstance(value, str) or not reason(value)):
        return Knob(name, "COLOR", color, help=help)
    fixed = reason(value)
    text = value if isinstance(value, str) else json.dumps(value)
    return Knob(name, "TEXT", text, help=help, fixed=fixed)
