"""Pictures of looks."""

import struct
import time
import zlib

import numpy as np
import pytest
import trochoid
from conftest import MIST, passes, slow


def decoded(png):
    """Returns the pixels of a PNG of 8 bits, whose rows have the filters that its header says."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data = 8, b""
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at : at + 8])
        chunk = png[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", chunk[:10])
        data += chunk if kind == b"IDAT" else b""
        at += 12 + length
    channels = {0: 1, 2: 3}[color]
    assert bits == 8
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    pixels = np.zeros((height, width * channels), np.int32)
    for y, row in enumerate(rows):
        above = pixels[y - 1] if y else np.zeros(width * channels, np.int32)
        for x, value in enumerate(row[1:].astype(np.int32)):
            left = pixels[y, x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            guess = left + above[x] - corner
            paeth = min([left, above[x], corner], key=lambda near: abs(guess - near))
            pixels[y, x] = (value + [0, left, above[x], (left + above[x]) // 2, paeth][row[0]]) % 256
    return pixels.reshape(height, width, channels)


def test_pictures_equal_samples(look):
    light, rim = passes(20, 30)
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    told = []
    picture = look.picture(inputs, progress=lambda done, total: told.append((done, total)))
    assert picture.size == (30, 20) and picture.numpy().shape == (20, 30, 3)
    np.testing.assert_array_equal(picture.numpy(), look.shade(inputs))
    np.testing.assert_array_equal(np.asarray(picture, np.float64), look.shade(inputs).astype(np.float64))
    assert (picture.audit.pixels, picture.audit.nan_count, picture.audit.hull_exits) == (600, 0, 0)
    assert told and told[-1][0] == told[-1][1]
    # Views of any strides are copied.
    wide = np.zeros((20, 60), np.float32)
    wide[:, ::-2] = light
    np.testing.assert_array_equal(look.picture({**inputs, "light": wide[:, ::-2]}).numpy(), picture.numpy())
    mix = [node for node in picture.nodes if node.name == "beauty"]
    assert mix[0].type == "Mix" and mix[0].seconds >= 0


def test_the_size_is_that_of_the_inputs_or_told(look):
    light, rim = passes(20, 30)
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    assert look.picture({**inputs, "light": 0.5, "rim": 0.5}, size=(4, 3)).numpy().shape == (3, 4, 3)
    with pytest.raises(ValueError, match="size"):
        look.picture({**inputs, "light": 0.5, "rim": 0.5})
    with pytest.raises(ValueError, match="shape"):
        look.picture(inputs, size=(4, 3))
    with pytest.raises(ValueError):
        look.picture({**inputs, "light": 0.5, "rim": 0.5}, size=(0, 3))


def test_a_png_shows_what_a_display_shows(look):
    light, rim = passes(20, 30)
    picture = look.picture({"light": light, "rim": rim, "palette.mist": MIST})
    assert picture._repr_png_() == picture.png()
    # The working space of this document is that of the display.
    expected = np.round(picture.numpy().astype(np.float64) * 255)
    assert np.abs(decoded(picture.png()) - expected).max() <= 0.5
    assert repr(picture) == "Picture(30 x 20, 0 outside of the palette)"


def test_a_report_tells_what_was_judged(look):
    light, rim = passes(20, 30)
    picture = look.picture({"light": light, "rim": rim, "palette.mist": MIST})
    # Three colors of the document, and one of the input, which is the same everywhere.
    assert (picture.audit.judged, picture.audit.control_count) == (600, 4)
    document = {"trochoid": 1, "nodes": {"a": {"type": "ScreenX"}}, "outputs": {"a": {"weights": "a"}}}
    mask = trochoid.Look(document).picture(size=(30, 20))
    assert (mask.audit.judged, mask.audit.hull_exits) == (0, 0)
    assert repr(mask) == "Picture(30 x 20)" and "judged=0" in repr(mask.audit)


def test_samples_are_averaged():
    nodes = {"a": {"type": "ScreenX"}, "b": {"type": "Clamp", "field": "a", "min": 0.46, "max": 0.47}}
    look = trochoid.Look({"trochoid": 1, "nodes": nodes, "outputs": {"b": {"weights": "b"}}})
    one, many = (look.picture(size=(9, 1), samples=samples).numpy().ravel() for samples in (1, 16))
    assert set(one[[0, 8]]) == set(many[[0, 8]]) == {0, 1}
    assert one[4] == 1 and 0.2 < many[4] < 0.8
    with pytest.raises(ValueError, match="samples"):
        look.picture(size=(9, 1), samples=5)


def test_threads_are_limited():
    document = {"trochoid": 1, "nodes": {"a": {"type": "ScreenX"}}, "outputs": {"a": {"weights": "a"}}}
    for threads in (1, 3):
        assert trochoid.Look(document, threads=threads).picture(size=(30, 20)).threads == threads


def test_fields_and_masks_are_shown_gray():
    def picture(kind, node, values):
        document = {"trochoid": 1, "nodes": {"a": {"type": node}}, "outputs": {"a": {kind: "a"}}}
        return trochoid.Look(document, inputs=["a"]).picture({"a": np.array(values, np.float32)})

    field = picture("field", "Noise", [[-2, 0, 2]])
    assert field.numpy().shape == (1, 3)
    assert decoded(field.png()).ravel().tolist() in ([0, 127, 255], [0, 128, 255])
    mask = picture("weights", "ScreenX", [[0, 0.2, 1]])
    assert decoded(mask.png()).ravel().tolist() == [0, 51, 255]
    assert decoded(picture("field", "Noise", [[7, 7]]).png()).ravel().tolist() == [0, 0]


def test_what_a_progress_function_raises_is_raised(look):
    light, rim = passes(20, 30)
    with pytest.raises(ZeroDivisionError):
        look.picture({"light": light, "rim": rim, "palette.mist": MIST}, progress=lambda done, total: 1 / 0)


def test_a_false_answer_cancels():
    calls = []
    with pytest.raises(trochoid.Cancelled):
        trochoid.Look(slow(3000)).picture(size=(3000, 3000), progress=lambda *at: calls.append(at) or np.False_)
    assert len(calls) < 10, "it goes on after the answer"


def test_one_long_node_can_be_stopped():
    calls = []
    started = time.monotonic()
    with pytest.raises(trochoid.Cancelled):
        trochoid.Look(slow(6000)).picture(size=(6000, 6000), progress=lambda *at: calls.append(at) or len(calls) < 2)
    assert len(calls) < 9 and time.monotonic() - started < 20


def test_an_interrupt_cancels(interrupts):
    look = trochoid.Look(slow(6000))
    interrupts(0.3)
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        look.picture(size=(6000, 6000))
    assert time.monotonic() - started < 20
    # The look is as good as before.
    assert look.picture(size=(30, 20)).size == (30, 20)


def test_pictures_too_large_are_refused(look):
    with pytest.raises(ValueError, match="65000"):
        trochoid.Look(slow(100)).picture(size=(65_000, 65_000))
    # As few numbers as there are, memory is counted before any of it is taken.
    for light in (0.5, np.zeros((1, 65_000), np.float32)):
        with pytest.raises(MemoryError, match="copies of passes"):
            look.picture({"light": light, "rim": 0.25, "palette.mist": MIST}, size=(65_000, 32_000))


def test_sizes_that_do_not_fit_are_told(look):
    light, rim = passes(20, 30)
    with pytest.raises(ValueError, match=r"shape \[20, 30\], rows by columns.*size of 4 x 5"):
        look.picture({"light": light, "rim": rim, "palette.mist": MIST}, size=(4, 5))
