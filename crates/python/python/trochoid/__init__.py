"""A compositor whose pictures cannot leave their palette, with the sea built in.

A `Look` is one output of a document whose passes come from you:

    look = trochoid.Look.load("water.json", inputs=["light"])
    rgb = look.shade({"light": np.linspace(0, 1, 256, dtype=np.float32)})
    picture = look.picture({"light": passes[..., 0]})

The commands of the program are functions: `check`, `render`, `palette`, `decompose`, `recolor` and `plan`; `run` takes
the arguments of any other.

    trochoid.render("storm.json", frames=range(1, 97), out="out/{output}.####.exr", set={"knobs.storm": 0.5})
"""

from ._commands import check, decompose, palette, plan, recolor, render
from ._trochoid import (
    Audit,
    Cancelled,
    CommandError,
    Error,
    IllegalSample,
    InvalidDocument,
    InvalidLook,
    Look,
    Node,
    NotPointwise,
    Output,
    Picture,
    Slot,
    __version__,
    run,
)

__all__ = [
    "Audit",
    "Cancelled",
    "CommandError",
    "Error",
    "IllegalSample",
    "InvalidDocument",
    "InvalidLook",
    "Look",
    "Node",
    "NotPointwise",
    "Output",
    "Picture",
    "Slot",
    "__version__",
    "check",
    "decompose",
    "palette",
    "plan",
    "recolor",
    "render",
    "run",
]
