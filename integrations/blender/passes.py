"""Blender's passes: what they are called in files, where they are switched on, and how they reach a document.

This module needs no Blender.
"""

from dataclasses import dataclass

import numpy as np

from . import colors

# Depth at and above which Blender says that a ray hit nothing: 10¹⁰ units, but for the rounding of 32-bit floats. What is
# nearer may well be seen: in a scene in millimeters, a mountain is 10⁷ units away.
MISSED = 1e10 * (1 - 1e-6)


@dataclass(frozen=True)
class Pass:
    """A pass of a view layer."""

    # Name of the nodes that it is bound to.
    node: str
    # Label in Blender's panel.
    label: str
    # Names in files: since Blender 5.0, and before.
    names: tuple
    channels: str
    # Property of the view layer that switches it on; empty if it is always there.
    switch: str
    # VALUE, COLOR, DEPTH, COVERAGE, PLACE or DIRECTION: how it is converted.
    meaning: str = "VALUE"


def lights(node, label, names, switch):
    parts = [("direct", "Direct", "Dir"), ("indirect", "Indirect", "Ind"), ("color", "Color", "Col")]
    return [
        Pass(f"{node}_{part}", f"{label} {word}", (f"{label} {word}", names + short), "RGB", f"{switch}_{part}", "COLOR")
        for part, word, short in parts
    ]


PASSES = [
    Pass("depth", "Z", ("Depth",), "Z", "use_pass_z", "DEPTH"),
    Pass("coverage", "Z", ("Depth",), "Z", "use_pass_z", "COVERAGE"),
    Pass("mist", "Mist", ("Mist",), "Z", "use_pass_mist"),
    Pass("position", "Position", ("Position",), "XYZ", "use_pass_position", "PLACE"),
    Pass("normal", "Normal", ("Normal",), "XYZ", "use_pass_normal", "DIRECTION"),
    Pass("uv", "UV", ("UV",), "UV", "use_pass_uv"),
    Pass("object_index", "Object Index", ("Object Index", "IndexOB"), "X", "use_pass_object_index"),
    Pass("material_index", "Material Index", ("Material Index", "IndexMA"), "X", "use_pass_material_index"),
    *lights("diffuse", "Diffuse", "Diff", "use_pass_diffuse"),
    *lights("glossy", "Glossy", "Gloss", "use_pass_glossy"),
    *lights("transmission", "Transmission", "Trans", "use_pass_transmission"),
    Pass("volume_direct", "Volume Direct", ("Volume Direct", "VolumeDir"), "RGB", "cycles.use_pass_volume_direct", "COLOR"),
    Pass(
        "volume_indirect",
        "Volume Indirect",
        ("Volume Indirect", "VolumeInd"),
        "RGB",
        "cycles.use_pass_volume_indirect",
        "COLOR",
    ),
    Pass("emission", "Emission", ("Emission", "Emit"), "RGB", "use_pass_emit", "COLOR"),
    Pass("environment", "Environment", ("Environment", "Env"), "RGB", "use_pass_environment", "COLOR"),
    Pass("shadow", "Shadow", ("Shadow",), "RGB", "use_pass_shadow", "COLOR"),
    Pass(
        "ambient_occlusion",
        "Ambient Occlusion",
        ("Ambient Occlusion", "AO"),
        "RGB",
        "use_pass_ambient_occlusion",
        "COLOR",
    ),
    Pass("shadow_catcher", "Shadow Catcher", ("Shadow Catcher",), "RGB", "cycles.use_pass_shadow_catcher", "COLOR"),
    Pass("combined", "Combined", ("Combined",), "RGB", "use_pass_combined", "COLOR"),
    Pass("alpha", "Combined", ("Combined",), "A", "use_pass_combined"),
]
OF_NODES = {known.node: known for known in PASSES}
OF_NAMES = {name: known for known in reversed(PASSES) for name in known.names}
OBJECTS = {
    "CryptoObject": ("Cryptomatte Object", "use_pass_cryptomatte_object"),
    "CryptoMaterial": ("Cryptomatte Material", "use_pass_cryptomatte_material"),
    "CryptoAsset": ("Cryptomatte Asset", "use_pass_cryptomatte_asset"),
}


def of_aov(name, is_color):
    """Returns the pass of a shader's AOV."""
    return Pass(name, f"Shader AOV {name}", (name,), "RGB" if is_color else "X", "", "COLOR" if is_color else "VALUE")


def switch_of(name):
    """Returns label and switch of the pass of a name, as in `Depth`, `Combined.A` or `CryptoObject00`; None if it is none of
    Blender's own."""
    base = name.split(".")[0]
    for known, (label, switch) in OBJECTS.items():
        if base.rstrip("0123456789") == known:
            return label, switch
    known = OF_NAMES.get(base)
    return known and (known.label, known.switch)


def converted(known, values, scale):
    """Returns a pass as documents mean it: y up, meters, and +∞ as the depth of what was missed.

    `values` has rows, columns and channels, `scale` is the length of Blender's unit in meters.
    """
    match known.meaning:
        case "DEPTH":
            return np.where(values >= MISSED, np.float32(np.inf), values * np.float32(scale))
        case "COVERAGE":
            return (values < MISSED).astype(np.float32)
        case "PLACE" | "DIRECTION":
            turned = np.stack([values[..., 0], values[..., 2], -values[..., 1]], axis=-1)
            return turned * np.float32(scale) if known.meaning == "PLACE" else turned
    return values


def fitted(known, values, channels):
    """Returns a pass with the channels of a node; None if it has other ones. A color becomes its luminance for one channel."""
    if values.shape[-1] == channels:
        return values if channels > 1 else values[..., 0]
    if channels == 1 and known.meaning == "COLOR":
        return (values.astype(np.float64) @ colors.LUMINANCE).astype(np.float32)
    return None
