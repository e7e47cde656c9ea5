"""Values as JSON, those of numpy among them."""

from __future__ import annotations

import json
from typing import Any


def text(value: Any) -> str:
    """Returns a value as JSON: numbers and arrays of numpy are written like those of Python."""
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"found {type(value).__name__}; expected what JSON has: numbers, texts, lists, dictionaries")
