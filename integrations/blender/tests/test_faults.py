"""Tests of what goes wrong: it is told with its cause and a remedy, and breaks no render."""

import struct

import bpy
import pytest
from conftest import extension, state, with_arrays

paint, plate, repaint = extension.paint, extension.plate, extension.repaint


# The file with the passes


def header(*attributes, begins=b"\x76\x2f\x31\x01\x02\0\0\0"):
    """The header of an EXR: name, type and value of each attribute."""
    parts = [name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value for name, kind, value in attributes]
    return begins + b"".join(parts) + b"\0"


WINDOW = (b"displayWindow", b"box2i", struct.pack("<4i", 10, 20, 329, 199))
MANIFEST = (b"cryptomatte/0/manifest", b"string", b'{"displayWindow\0box2i\0": "x"}' * 10_000)


def test_the_size_comes_after_any_other_attribute(tmp_path):
    file = tmp_path / "passes.exr"
    file.write_bytes(header(MANIFEST, WINDOW))
    assert plate.size_of(file) == (320, 180)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "another kind of file"),
        (b"\x89PNG\r\n", "another kind of file"),
        (header(MANIFEST), "without the size"),
        (header(MANIFEST, WINDOW)[:-30], "the end of the file"),
        (header((b"n" * 300, b"int", b"")), "more than 255 letters"),
        (header()[:-1] + b"a\0b\0" + struct.pack("<i", -9), "without the size"),
        (header(*[(b"a", b"b", b"")] * 20_000, WINDOW), "without the size"),
    ],
)
def test_files_without_a_size_are_told(tmp_path, data, told):
    file = tmp_path / "passes.exr"
    file.write_bytes(data)
    with pytest.raises(plate.Unreadable, match=rf"passes\.exr: found .*{told}.*; expected .*: render again"):
        plate.size_of(file)


def test_a_scene_of_many_objects_is_painted(scene, opened):
    """Their names come before the size in the file with the passes."""
    mesh = bpy.data.objects["Suzanne"].data
    for number in range(1100):
        scene.collection.objects.link(bpy.data.objects.new(f"{number:05}" + 55 * "n", mesh))
    scene.view_layers[0].use_pass_cryptomatte_object = True
    opened(with_arrays())
    scene.cycles.samples = 1
    bpy.ops.render.render()
    assert not state(scene).has_failed, state(scene).told
    header = extension.render_result.path_of(scene).read_bytes()[:65536]
    assert b"displayWindow" not in header


def test_an_operator_reports_what_nobody_expected(scene, opened, monkeypatch, capfd):
    opened(with_arrays())
    bpy.ops.render.render()

    def fails(_wanted):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(paint, "paint", fails)
    with pytest.raises(RuntimeError) as raised:
        bpy.ops.trochoid.paint()
    assert "ZeroDivisionError('by nothing')" in str(raised.value) and "report it" in str(raised.value)
    assert "Traceback" not in str(raised.value)
    assert "Traceback" in capfd.readouterr().err
