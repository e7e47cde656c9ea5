"""Types of the extension module."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

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
    "run",
]

__version__: str

_Kind: TypeAlias = Literal["color", "mask", "weights", "field"]
_Illegal: TypeAlias = Literal["refuse", "clamp"]
_Progress: TypeAlias = Callable[[int, int], bool | None]

class Error(Exception): ...

class InvalidDocument(Error):
    diagnostics: list[dict[str, Any]]

class InvalidLook(Error):
    diagnostics: list[dict[str, Any]]

class NotPointwise(Error):
    diagnostics: list[dict[str, Any]]

class IllegalSample(Error):
    name: str
    slot: int
    sample: int

class CommandError(Error):
    code: int
    messages: list[str]
    text: str

class Cancelled(Error): ...

@final
class Slot:
    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> _Kind: ...
    @property
    def channels(self) -> int: ...
    @property
    def is_used(self) -> bool: ...

@final
class Audit:
    @property
    def pixels(self) -> int: ...
    @property
    def judged(self) -> int: ...
    @property
    def hull_exits(self) -> int: ...
    @property
    def nan_count(self) -> int: ...
    @property
    def control_count(self) -> int: ...

@final
class Node:
    @property
    def name(self) -> str: ...
    @property
    def type(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def seconds(self) -> float: ...

@final
class Picture:
    def numpy(self) -> NDArray[np.float32]: ...
    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]: ...
    def png(self) -> bytes: ...
    def _repr_png_(self) -> bytes: ...
    @property
    def audit(self) -> Audit: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def threads(self) -> int: ...
    @property
    def nodes(self) -> list[Node]: ...

@final
class Output:
    @property
    def text(self) -> str: ...
    @property
    def messages(self) -> list[str]: ...
    def json(self) -> Any: ...

@final
class Look:
    def __new__(
        cls,
        document: str | dict[str, Any],
        *,
        inputs: Sequence[str] = ...,
        output: str | None = None,
        set: Mapping[str, Any] | None = None,
        frame: int = 1,
        folder: str | PathLike[str] | None = None,
        name: str | None = None,
        samples: int | None = None,
        illegal: _Illegal = "refuse",
        allow: Sequence[str | PathLike[str]] = ...,
        threads: int | None = None,
    ) -> Look: ...
    @staticmethod
    def load(
        path: str | PathLike[str],
        *,
        inputs: Sequence[str] = ...,
        output: str | None = None,
        set: Mapping[str, Any] | None = None,
        frame: int = 1,
        samples: int | None = None,
        illegal: _Illegal = "refuse",
        allow: Sequence[str | PathLike[str]] = ...,
        threads: int | None = None,
    ) -> Look: ...
    def replace(self, *, set: Mapping[str, Any] | None = None, frame: int | None = None) -> Look: ...
    @property
    def slots(self) -> list[Slot]: ...
    @property
    def output(self) -> str: ...
    @property
    def kind(self) -> _Kind: ...
    @property
    def channels(self) -> int: ...
    @property
    def frame(self) -> int: ...
    def shade(self, inputs: Mapping[str, ArrayLike], out: NDArray[np.float32] | None = None) -> NDArray[np.float32]: ...
    def picture(
        self,
        inputs: Mapping[str, ArrayLike] | None = None,
        *,
        size: tuple[int, int] | None = None,
        samples: Literal[1, 4, 16] = 1,
        progress: _Progress | None = None,
    ) -> Picture: ...

def check(
    document: str | dict[str, Any],
    *,
    set: Mapping[str, Any] | None = None,
    folder: str | PathLike[str] | None = None,
    name: str | None = None,
) -> list[dict[str, Any]]: ...
def run(arguments: Sequence[str | PathLike[str]], *, progress: _Progress | None = None) -> Output: ...
