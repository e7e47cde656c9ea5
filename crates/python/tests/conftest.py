"""What the tests share. Run them with `pytest crates/python/tests`, with the package installed."""

import json
import os
import pathlib
import signal
import threading

import numpy as np
import pytest
import trochoid

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "capi" / "examples"
WATER = (EXAMPLES / "water.json").read_text()
INPUTS = ["light", "rim", "palette.mist"]
MIST = (0.25, 0.5, 0.75)
POINTS = 600


def passes(*shape):
    """The passes of the example in C, as rows and columns if a shape is given."""
    at = np.arange(POINTS)
    light = at.astype(np.float32) / np.float32(POINTS - 1)
    rim = (at * 7 % POINTS).astype(np.float32) / np.float32(POINTS)
    return tuple(values.reshape(shape or POINTS) for values in (light, rim))


def known():
    """What the C interface gives, bit for bit."""
    lines = (EXAMPLES / "shade.txt").read_text().split()
    return np.array([int(bits, 16) for bits in lines], dtype=np.uint32).view(np.float32).reshape(POINTS, 3)


def slow(size):
    """A look of a picture that takes seconds, if it is large."""
    nodes = {"a": {"type": "Noise", "scale": 40}}
    for number in range(4):
        nodes[f"b{number}"] = {"type": "Blur", "image": f"b{number - 1}" if number else "a", "size": 40}
    document = {"trochoid": 1, "nodes": nodes, "outputs": {"b": {"field": "b3", "file": "b.exr"}}}
    return {**document, "format": {"width": size, "height": size}}


@pytest.fixture
def look():
    return trochoid.Look.load(EXAMPLES / "water.json", inputs=INPUTS)


@pytest.fixture
def interrupts():
    """Interrupts this process later, once, as Ctrl-C does; also where Python was started without its handler."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timers = []

    def later(seconds):
        timers.append(threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)))
        timers[-1].start()

    yield later
    [timer.join() for timer in timers]
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """The current folder, with water.json as a scene of its own, 40 by 30 pixels, three frames."""
    document = json.loads(WATER)
    document["format"] = {"width": 40, "height": 30}
    document["frames"] = {"first": 1, "last": 3}
    (tmp_path / "water.json").write_text(json.dumps(document))
    monkeypatch.chdir(tmp_path)
    return tmp_path
