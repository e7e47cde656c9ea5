"""Tests of what goes wrong: it is told with its cause and a remedy, and breaks no render."""

import os
import resource
import struct
from pathlib import Path

import bpy
import pytest
from conftest import extension, state, with_arrays, with_plate

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


def test_a_failure_is_printed_once(scene, opened, monkeypatch, capfd):
    opened(with_arrays())
    bpy.ops.render.render()

    def fails(_scene):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(repaint, "request", fails)
    for _ in range(5):
        bpy.data.objects["Suzanne"].location.x += 1
        bpy.context.view_layer.update()
    told = capfd.readouterr()
    assert told.out.count("Trochoid: ") == 1 and told.err.count("Traceback") == 1


# Renders without passes


def no_camera(scene):
    scene.camera = None
    return "found no camera; expected one"


def no_view_layer(scene):
    scene.view_layers[0].use = False
    return "switch on Use for Rendering in the View Layer tab"


def stereoscopy(scene):
    scene.render.use_multiview = True
    return "found Stereoscopy; expected one view: switch it off"


def views(scene):
    scene.render.views_format = "MULTIVIEW"
    return stereoscopy(scene)


def strips(scene):
    editor = scene.sequence_editor_create()
    if hasattr(editor, "strips"):
        length = "length" if bpy.app.version >= (5, 0) else "frame_end"
        editor.strips.new_effect("color", "COLOR", channel=1, frame_start=1, **{length: 10})
    else:
        editor.sequences.new_effect("color", "COLOR", channel=1, frame_start=1, frame_end=10)
    return "switch off Sequencer under Post Processing"


@pytest.mark.parametrize("cause", [no_camera, no_view_layer, stereoscopy, views, strips])
def test_renders_without_passes_say_their_cause(scene, opened, cause):
    opened(with_arrays())
    bpy.ops.render.render()
    assert not extension.render_result.obstacles(scene)
    told = cause(scene)
    if cause is no_camera:
        with pytest.raises(RuntimeError, match="no camera"):
            bpy.ops.render.render()
    else:
        bpy.ops.render.render()
    (obstacle,) = extension.render_result.obstacles(scene)
    assert told in obstacle and state(scene).has_failed and state(scene).told == obstacle
    assert not repaint.WORK.is_rendering
    with pytest.raises(RuntimeError) as raised:
        bpy.ops.trochoid.paint()
    assert told in str(raised.value) and "Traceback" not in str(raised.value)


def test_muted_strips_and_those_that_are_switched_off_do_no_harm(scene, opened):
    opened(with_arrays())
    strips(scene)
    (strip,) = extension.render_result.strips(scene)
    strip.mute = True
    bpy.ops.render.render()
    assert state(scene).has_failed == (bpy.app.version < (4, 3)) == bool(extension.render_result.obstacles(scene))
    strip.mute = False
    scene.render.use_sequencer = False
    bpy.ops.render.render()
    assert not state(scene).has_failed


# Files of frames


@pytest.mark.parametrize("frame", [0, 1, -1, -5, 123, 12345, -12345, 1048574])
@pytest.mark.parametrize("name", ["shot.####.png", "s#1.####.png", "#.png", "s.#", "a##b###c.png", "####", "a.#####.b.png"])
def test_frames_are_numbered_as_by_blender(scene, tmp_path, name, frame):
    scene.render.filepath = str(tmp_path / name)
    scene.render.use_file_extension = False
    assert extension.image.numbered(name, frame) == Path(scene.render.frame_path(frame=frame)).name


def test_a_name_without_signs_keeps_its_ending():
    assert extension.image.numbered("shot.trochoid.png", -7) == "shot.trochoid-0007.png"


@pytest.mark.parametrize("spelling", ["{folder}/{name}", "{folder}/./x/../{name}", "{folder}/link/{name}", "//{name}"])
def test_paintings_never_replace_blender_s_own_frames(scene, opened, tmp_path, recwarn, spelling):
    opened(with_arrays())
    folder = tmp_path / "shots"
    (folder / "x").mkdir(parents=True)
    (folder / "link").symlink_to(folder)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shot.blend"))
    scene.render.filepath = str(folder / "shot.####.png")
    scene.trochoid.frames = spelling.format(folder=folder, name="shot.####.png")
    # Blender warns of // where a path does not say that it may have it.
    assert not list(recwarn)
    scene.frame_end = 1
    # Before Blender's file is there, too.
    with pytest.raises(extension.image.Unwritable, match="Blender writes its own frame to that file"):
        extension.image.frame_file(scene, 1)
    assert "Blender writes its own" in extension.image.fault_of_frames(scene)
    bpy.ops.render.render(animation=True)
    assert state(scene).has_failed and "expected another name" in state(scene).told
    # The program's PNGs have no such notes.
    assert b"RenderTime" in (folder / "shot.0001.png").read_bytes()
    scene.trochoid.frames = str(folder / "shot.trochoid.####.png")
    bpy.ops.render.render(animation=True)
    assert not state(scene).has_failed and not extension.image.fault_of_frames(scene)
    assert b"RenderTime" not in (folder / "shot.trochoid.0001.png").read_bytes()


@pytest.mark.parametrize("name", ["shot.0001", "shot.0001.png", "shot.0001.exr"])
def test_paintings_never_replace_blender_s_own_still(scene, opened, tmp_path, name):
    opened(with_arrays())
    scene.render.filepath = str(tmp_path / name)
    scene.trochoid.frames = str(tmp_path / "shot.####.png")
    bpy.ops.render.render(write_still=True)
    assert state(scene).has_failed and "expected another name" in state(scene).told
    assert b"RenderTime" in (tmp_path / "shot.0001.png").read_bytes()


@pytest.mark.parametrize("kind", [with_arrays, with_plate])
def test_any_folder_will_do(scene, opened, tmp_path, kind):
    """The program would take braces for places of names, and percent signs for those of numbers."""
    opened(kind())
    folder = tmp_path / "a {output} {x} #1 %04d \u00fcber"
    scene.trochoid.frames = str(folder / "shot.{y}.##.PNG")
    bpy.ops.render.render(write_still=True)
    assert not state(scene).has_failed, state(scene).told
    assert [file.name for file in folder.iterdir()] == ["shot.{y}.01.PNG"]
    assert not list(Path(bpy.app.tempdir).glob("trochoid-*.written*"))


def test_frames_beside_a_file_that_was_never_saved_are_told(scene, opened):
    opened(with_arrays())
    scene.trochoid.frames = "//shot.trochoid.####.png"
    bpy.ops.render.render(write_still=True)
    assert state(scene).has_failed and "save this one first" in state(scene).told
    assert not Path("shot.trochoid.0001.png").exists()


@pytest.mark.parametrize("kind", [with_arrays, with_plate])
def test_a_frame_is_written_whole_or_not_at_all(scene, opened, tmp_path, kind):
    opened(kind())
    bpy.ops.render.render()
    painting = paint.paint(repaint.request(scene))
    folder = tmp_path / "shots"
    file = folder / "shot.0001.png"
    paint.write(painting, file)
    whole = file.read_bytes()
    file.write_bytes(b"of an earlier run")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    # As on a disk that becomes full.
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) // 2, before[1]))
    try:
        with pytest.raises(paint.Unpaintable, match=r"shot\.0001\.png"):
            paint.write(painting, file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert file.read_bytes() == b"of an earlier run"
    assert list(folder.iterdir()) == [file]
    paint.write(painting, file)
    assert file.read_bytes() == whole and list(folder.iterdir()) == [file]
    assert file.stat().st_mode & 0o777 == 0o666 & ~umask()
    file.unlink()
    file.mkdir()
    with pytest.raises(paint.Unpaintable, match=r"shot\.0001\.png"):
        paint.write(painting, file)
    assert list(folder.iterdir()) == [file]


def umask():
    """Returns what new files of this process do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
