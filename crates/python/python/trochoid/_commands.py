"""Functions for the commands of the program that are used most.

Each makes the arguments of a command line, runs it in this process, and returns what it says as values. The program's
warnings become Python's, and its notes go to the logger "trochoid".
"""

from __future__ import annotations

import json
import logging
import operator
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, TypeAlias

from . import _json, _trochoid
from ._trochoid import CommandError, InvalidDocument

Path: TypeAlias = str | os.PathLike[str]
Paths: TypeAlias = Path | Iterable[Path]
Names: TypeAlias = str | Iterable[str]
Frames: TypeAlias = str | int | Iterable[int]
Tolerance: TypeAlias = str | float | Fraction
Palette: TypeAlias = Path | Mapping[str, str]
Progress: TypeAlias = Callable[[int, int], bool | None]

_NOTES = logging.getLogger("trochoid")


def check(
    document: str | dict[str, Any] | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    frame: int | None = None,
    palette: Path | None = None,
    allow: Paths = (),
    strict: bool = False,
    folder: Path | None = None,
    name: str | None = None,
) -> list[dict[str, Any]]:
    """Checks a document: a path, a dictionary, or a text, which begins with "{".

    Returns its warnings, as dictionaries. Raises InvalidDocument with all faults, and OSError if it cannot be read.

    A document in a file is checked as `trochoid check` does it, with the files that it names, at `frame`;
    `palette`, `allow` and `strict` are as on the command line. A dictionary or a text is checked for a `Look`,
    which needs no format; `folder` is what its paths are relative to, and `name` what messages call it.

    >>> trochoid.check({"trochoid": 1, "nodes": {"x": {"type": "ScreenX"}}, "outputs": {"x": {"weights": "x"}}})
    []
    """
    if isinstance(document, dict) or (isinstance(document, str) and document.lstrip().startswith("{")):
        for option, given in [
            ("frame", frame),
            ("palette", palette),
            ("allow", allow or None),
            ("strict", strict or None),
        ]:
            if given is not None:
                raise TypeError(f"found {option}; expected it only with the path of a document")
        return _trochoid.check(document, set=set, folder=folder, name=name)
    for option, text in [("folder", folder), ("name", name)]:
        if text is not None:
            raise TypeError(f"found {option}; expected it only with the text of a document, or a dictionary")
    options = [*_set(set), *_one("frame", frame), *_one("palette", palette), *_all("allow", allow)]
    arguments = [*options, *_flag("strict", strict), "--", os.fspath(document)]
    try:
        found = _trochoid.run(["check", "--json", *arguments]).json()
    except CommandError as error:
        if error.code == 1:
            raise _unread(document, str(error)) from None
        if not error.text:
            raise
        found = json.loads(error.text)
    diagnostics: list[dict[str, Any]] = found["diagnostics"]
    if found["valid"]:
        return diagnostics
    # In words, as the program says it.
    try:
        invalid = InvalidDocument(_trochoid.run(["check", *arguments]).text)
    except CommandError as error:
        invalid = InvalidDocument(str(error))
    invalid.diagnostics = diagnostics
    raise invalid


def render(
    document: Path,
    *,
    frames: Frames | None = None,
    output: Names = (),
    view: Names = (),
    out: Path | None = None,
    set: Mapping[str, Any] | None = None,
    palette: Path | None = None,
    scale: str | float | None = None,
    region: tuple[int, int, int, int] | None = None,
    recipe: Path | None = None,
    require: str | None = None,
    tolerance: Tolerance | None = None,
    plan: Path | None = None,
    certificate: Path | None = None,
    sign: Path | None = None,
    error: Path | None = None,
    report: Path | None = None,
    float: bool = False,
    unoptimized: bool = False,
    resume: bool = False,
    share: bool = False,
    keep_going: bool = False,
    threads: int = 0,
    cache: Path | None = None,
    cache_limit: str | None = None,
    allow: Paths = (),
    strict: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
    """Renders outputs of a document to files, as `trochoid render` does.

    Returns a dictionary for each frame, with the counts of each output and its files: {"frame": 1, "files":
    [{"path": ..., "state": "written", ...}], ...}. `frames` is a list such as "1-10,20-40x2", a number or numbers;
    `out` a pattern such as "out/{output}.####.exr"; `set` has values for knobs and ports. The other arguments are
    the options of the command line: `trochoid.run(["render", "--help"])` explains them.

    `progress(done, total)` is called now and then, with 1000 steps for each frame; if it returns False, the run
    stops, and Cancelled is raised. Raises CommandError if the run fails; its `text` then has a line of JSON for
    each finished frame.

    >>> frames = trochoid.render("water.json", out="water.{output}.png")
    >>> [file["path"] for file in frames[0]["files"]]
    ['water.beauty.png']
    """
    options = [
        *_one("frames", None if frames is None else _frames(frames)),
        *_all("output", output),
        *_all("view", view),
    ]
    options += [*_one("out", out), *_set(set), *_one("palette", palette), *_one("scale", scale)]
    options += _one("region", None if region is None else ",".join(map(str, region)))
    options += [*_one("recipe", recipe), *_one("require", require), *_one("tolerance", tolerance), *_one("plan", plan)]
    options += [*_one("certificate", certificate), *_one("sign", sign), *_one("error", error), *_one("report", report)]
    options += [*_flag("float", float), *_flag("unoptimized", unoptimized), *_flag("resume", resume)]
    options += [*_flag("share", share), *_flag("keep-going", keep_going), *_one("threads", threads or None)]
    options += [*_one("cache", cache), *_one("cache-limit", cache_limit)]
    options += [*_all("allow", allow), *_flag("strict", strict), *_flag("overwrite", overwrite)]
    text = _text(["render", "--json", *options, "--", os.fspath(document)], progress)
    # Other signs that end lines may stand in names.
    return [json.loads(line) for line in text.split("\n") if line]


def palette(
    pictures: Paths,
    *,
    frames: Frames | None = None,
    colors: int | None = None,
    within: float | None = None,
    prior: Path | None = None,
    ignore: float | None = None,
    region: Names = (),
    by_region: bool = False,
    out: Paths = (),
    report: Path | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Finds few colors whose hull encloses every pixel of pictures, as `trochoid palette` does.

    Returns what was found: "palette" has the colors by name, as documents take them. `out` writes them to files,
    .json, .gpl or .png. The other arguments are the options of the command line: `trochoid.run(["palette",
    "--help"])` explains them. Raises CommandError; with `code` 3 if no palette of that many colors encloses every
    pixel.

    >>> found = trochoid.palette("water.beauty.png", colors=4, out="inks.json")
    >>> len(found["palette"])
    4
    """
    options = [*_one("frames", None if frames is None else _frames(frames)), *_one("colors", colors)]
    options += [*_one("within", within), *_one("prior", prior), *_one("ignore", ignore), *_all("region", region)]
    options += [*_flag("by-region", by_region), *_all("out", out), *_one("report", report)]
    options += _flag("overwrite", overwrite)
    found: dict[str, Any] = json.loads(_text(["palette", "--json", *options, "--", *_paths(pictures)], progress))
    return found


def decompose(
    pictures: Paths,
    palette: Palette,
    *,
    out: Path | None = None,
    graph: Path | None = None,
    cube: Path | None = None,
    to: Path | None = None,
    cube_size: int | None = None,
    softness: float | None = None,
    float: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
    """Takes pictures apart into weights over the colors of a palette, as `trochoid decompose` does.

    Returns a dictionary for each picture: {"picture": ..., "files": [...], "outside": 0, "farthest": 0.0}: the
    files that were written, the number of pixels that are farther outside of the palette's hull than the file's
    rounding moves them, and how far the farthest one is, in steps of 255. `out` is an EXR file, a recipe; `graph` a
    small document that mixes the picture again. In both, {name} stands for the picture's name. `palette` is a
    dictionary of colors by name, as `palette` returns it, or a file with such colors. `cube` is a 3-D LUT for other
    programs, which paints in the colors of `to`; for it alone, `pictures` may be empty.

    >>> found = trochoid.decompose("water.beauty.png", "inks.json", out="{name}.recipe.exr")
    >>> found[0]["files"], found[0]["outside"]
    (['water.beauty.recipe.exr'], 0)
    """
    options = [*_one("out", out), *_one("graph", graph), *_one("softness", softness)]
    options += [*_one("cube", cube), *_one("to", to), *_one("cube-size", cube_size)]
    options += [*_flag("float", float), *_flag("overwrite", overwrite)]
    with tempfile.TemporaryDirectory() as folder:
        file = palette
        if isinstance(file, Mapping):
            file = os.path.join(folder, "palette.json")
            with open(file, "w", encoding="utf-8") as written:
                written.write(_json.text(palette))
        options += _one("palette", file)
        found = json.loads(_text(["decompose", "--json", *options, "--", *_paths(pictures)], progress))
    recipes: list[dict[str, Any]] = found["recipes"]
    return recipes


def recolor(
    recipes: Paths,
    out: Path,
    *,
    palette: Palette | None = None,
    set: Mapping[str, str] | None = None,
    frames: Frames | None = None,
    deep: bool = False,
    float: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
    """Paints recipes, of `decompose` or of `render` with `recipe`, in other colors, as `trochoid recolor` does.

    Returns a dictionary for each picture: {"recipe": ..., "file": ..., "colors": 4, "outside": 0, "within": 0.001}:
    the file that was written, the number of its pixels outside of the hull of the colors, and the largest
    difference of a channel from a render in the same colors. `out` is a PNG or EXR file; {name} stands for the
    recipe's name. `set` has colors by name, such as {"glow": "#f2c14e"}; `palette` is a dictionary or file with such
    colors.

    >>> painted = trochoid.recolor("water.beauty.recipe.exr", "warm.png")
    >>> painted[0]["file"], painted[0]["outside"]
    ('warm.png', 0)
    """
    colors = {**(palette if isinstance(palette, Mapping) else {}), **(set or {})}
    options = [*_one("out", out), *_one("palette", None if isinstance(palette, Mapping) else palette)]
    options += [f"--set={name}={color}" for name, color in colors.items()]
    options += [*_one("frames", None if frames is None else _frames(frames)), *_flag("deep", deep)]
    options += [*_flag("float", float), *_flag("overwrite", overwrite)]
    found = json.loads(_text(["recolor", "--json", *options, "--", *_paths(recipes)], progress))
    pictures: list[dict[str, Any]] = found["pictures"]
    return pictures


def plan(
    document: Path,
    *,
    tolerance: Tolerance | None = None,
    frame: int | None = None,
    output: Names = (),
    set: Mapping[str, Any] | None = None,
    palette: Path | None = None,
    out: Path | None = None,
    threads: int = 0,
    allow: Paths = (),
    strict: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Finds the settings that meet a tolerance, as `trochoid plan` does.

    Returns the plan, which `out` writes to a file for the argument `plan` of `render`: its "set" has the settings.
    `tolerance` is the largest error of a displayed value, such as "1/64" or 1 / 64; that of the document, unless
    told. Raises CommandError; with `code` 3 if no settings meet the tolerance.

    >>> trochoid.plan("water.json", tolerance="1/64")["set"]
    {}
    """
    options = [*_one("tolerance", tolerance), *_one("frame", frame), *_all("output", output), *_set(set)]
    options += [*_one("palette", palette), *_one("out", out), *_one("threads", threads or None)]
    options += [*_all("allow", allow), *_flag("strict", strict), *_flag("overwrite", overwrite)]
    found: dict[str, Any] = json.loads(_text(["plan", "--json", *options, "--", os.fspath(document)], progress))
    return found


def _text(arguments: list[str], progress: Progress | None) -> str:
    """Runs a command for a function of this module; returns what it prints."""
    try:
        output = _trochoid.run(arguments, progress=progress)
    except CommandError as error:
        # Remedies name options of the command line; here they are arguments.
        error.messages = [_argument(message) for message in error.messages]
        error.args = tuple(_argument(text) for text in error.args)
        raise
    for message in output.messages:
        kind, _, text = message.partition(": ")
        if kind == "warning":
            # Where the caller of the function is.
            warnings.warn(text, stacklevel=3)
        else:
            _NOTES.info(message)
    return output.text


def _argument(text: str) -> str:
    return re.sub(r"--overwrite\b", "overwrite=True", text)


def _unread(path: Path, message: str) -> OSError:
    """What `open` raises for a file that cannot be read, in the words of the program."""
    words = message.removeprefix("error: ").removeprefix(f"{os.fspath(path)}: ")
    try:
        with open(path, "rb"):
            return OSError(message)
    except OSError as error:
        return OSError(error.errno, words.split(" (os error ")[0], os.fspath(path))


def _paths(paths: Paths) -> list[str]:
    return [os.fspath(paths)] if isinstance(paths, (str, os.PathLike)) else [os.fspath(path) for path in paths]


def _one(option: str, value: object) -> list[str]:
    if value is None:
        return []
    return [f"--{option}={os.fspath(value) if isinstance(value, os.PathLike) else value}"]


def _all(option: str, values: Paths) -> list[str]:
    return [f"--{option}={value}" for value in _paths(values)]


def _flag(option: str, is_set: bool) -> list[str]:
    return [f"--{option}"] if is_set else []


def _set(assignments: Mapping[str, Any] | None) -> list[str]:
    return [f"--set={place}={_json.text(value)}" for place, value in (assignments or {}).items()]


def _frames(frames: Frames) -> str:
    if isinstance(frames, str):
        return frames
    try:
        return str(operator.index(frames))  # type: ignore[arg-type]
    except TypeError:
        return ",".join(map(str, frames))  # type: ignore[arg-type]
