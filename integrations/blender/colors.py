"""Colors between documents, swatches and Blender.

Documents mix colors in their working space. Swatches show them as sRGB displays do, and pictures go to Blender as linear
light with the primaries of Rec. 709. The numbers are those of `crates/image/src/space.rs`.
"""

import re

import numpy as np

ACESCG_FROM_LINEAR = np.array(
    [
        [0.6130974, 0.33952315, 0.04737945],
        [0.07019372, 0.91635388, 0.0134524],
        [0.02061559, 0.10956977, 0.86981464],
    ]
)
LINEAR_FROM_ACESCG = np.linalg.inv(ACESCG_FROM_LINEAR)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

HEX = re.compile(r"#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})")


def encode(linear):
    """Encodes linear light for an sRGB display (IEC 61966-2-1)."""
    linear = np.asarray(linear, np.float64)
    size = np.abs(linear)
    encoded = np.where(size <= 0.0031308, 12.92 * size, 1.055 * np.power(size, 1 / 2.4) - 0.055)
    return np.copysign(encoded, linear)


def decode(encoded):
    """Decodes what an sRGB display shows to linear light."""
    encoded = np.asarray(encoded, np.float64)
    size = np.abs(encoded)
    linear = np.where(size <= 0.04045, size / 12.92, np.power((size + 0.055) / 1.055, 2.4))
    return np.copysign(linear, encoded)


def to_linear(space, color):
    """Converts colors of a working space to linear light with the primaries of Rec. 709."""
    if space == "srgb":
        return decode(color)
    color = np.asarray(color, np.float64)
    return color @ LINEAR_FROM_ACESCG.T if space == "acescg" else color


def to_display(space, color):
    """Converts colors of a working space to what an sRGB display shows."""
    return np.asarray(color, np.float64) if space == "srgb" else encode(to_linear(space, color))


def from_display(space, shown):
    """Converts what an sRGB display shows to a working space."""
    if space == "srgb":
        return np.asarray(shown, np.float64)
    linear = decode(shown)
    return linear @ ACESCG_FROM_LINEAR.T if space == "acescg" else linear


def shown(space, value):
    """Returns what a display shows of a document's color, as three numbers; None if it is not a plain color."""
    if isinstance(value, str) and HEX.fullmatch(value):
        digits = value[1:] if len(value) == 7 else "".join(2 * digit for digit in value[1:])
        return tuple(int(digits[at : at + 2], 16) / 255 for at in (0, 2, 4))
    if isinstance(value, list) and len(value) == 3 and all(is_number(channel) for channel in value):
        return tuple(float(channel) for channel in to_display(space, value))
    return None


def written(space, color):
    """Returns a swatch as documents write it: `#rrggbb` if it is one, otherwise numbers of the working space."""
    steps = [255 * channel for channel in color]
    # Blender keeps properties in 32-bit floats.
    if all(abs(step - round(step)) < 1e-4 for step in steps):
        return "#" + "".join(f"{round(step):02x}" for step in steps)
    return [float(channel) for channel in from_display(space, color)]


def is_number(value):
    """Whether a value of JSON is a number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)
