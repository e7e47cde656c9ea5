"""Tests of documents, colors and knobs, and of what Blender keeps: `pytest integrations/blender/tests`."""

import json
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import bpy
import numpy as np
import pytest
import trochoid
from conftest import HERE, PALETTE, extension, pixels, rendered_by_command_line, state, with_arrays, with_plate

paint, render_result = extension.paint, extension.render_result


# Documents


def test_faults_are_reported_with_line_and_remedy(scene, tmp_path):
    file = tmp_path / "faulty.json"
    file.write_text(json.dumps(with_plate(), indent=1).replace('"weight": "soft"', '"weight": "sotf"'))
    line = next(n for n, text in enumerate(file.read_text().splitlines(), 1) if "sotf" in text)
    with pytest.raises(RuntimeError, match=f'line {line}: node "beauty", weight: .*did you mean "soft"'):
        bpy.ops.trochoid.open(filepath=str(file))
    (fault,) = scene.trochoid.faults
    assert fault.is_error and fault.remedy == 'did you mean "soft"?'
    # Renders go on.
    bpy.ops.render.render()
    assert state(scene).has_failed and f"line {line}" in state(scene).told
    with pytest.raises(RuntimeError, match=f"line {line}"):
        bpy.ops.trochoid.paint()
    # Mended, it paints at once, without another render.
    file.write_text(file.read_text().replace("sotf", "soft"))
    scene.view_layers[0].use_pass_diffuse_direct = True
    bpy.ops.render.render()
    bpy.ops.trochoid.paint()
    assert scene.trochoid.image is not None and not scene.trochoid.faults


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1]",
        "{}",
        '{"trochoid": 1, "nodes": 7}',
        '{"trochoid": 1, "palette": {"a": {"keys": 3}}}',
        '{"trochoid": 1, "palette": {"a": {"keys": []}}}',
        '{"trochoid": 1, "palette": {"a": {"keys": [[]]}}}',
        '{"trochoid": 1, "palette": {"a": {"keys": [[1]]}}}',
        '{"trochoid": 1, "palette": {"a": {"keys": [[1, "#fff"], 7]}}}',
        '{"trochoid": 1, "palette": {"a": [[1]]}}',
        '{"trochoid": 1, "format": {"width": "wide"}}',
        '{"trochoid": 1, "knobs": {"a": ' + 5000 * "[" + 5000 * "]" + "}}",
        '{"a": ' + 100_000 * "[",
        "\udcff\udcfe{}",
    ],
)
def test_hostile_documents_are_refused(scene, tmp_path, text):
    file = tmp_path / "strange.json"
    file.write_text(text, errors="surrogateescape")
    with pytest.raises(RuntimeError, match="found .*expected") as raised:
        bpy.ops.trochoid.open(filepath=str(file))
    assert "Traceback" not in str(raised.value) and "fault of the extension" not in str(raised.value)
    assert not scene.trochoid.is_valid and 'no "format"' not in str(raised.value)
    with pytest.raises(RuntimeError):
        bpy.ops.trochoid.open(filepath=str(tmp_path / "none.json"))


def test_folders_are_allowed(scene, opened, tmp_path):
    (tmp_path / "graphs").mkdir()
    document = with_plate()
    document["outputs"]["beauty"]["file"] = "../out/beauty.exr"
    file = tmp_path / "graphs/graph.json"
    file.write_text(json.dumps(document))
    with pytest.raises(RuntimeError, match="may reach") as raised:
        bpy.ops.trochoid.open(filepath=str(file))
    assert f"choose {tmp_path / 'out'} as Allow in the panel Trochoid" in str(raised.value)
    assert "--" not in str(raised.value)
    scene.trochoid.allow = str(tmp_path)
    assert scene.trochoid.is_valid
    bpy.ops.trochoid.enable_passes()
    bpy.ops.render.render()
    assert not state(scene).has_failed, state(scene).told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("owner", "name"), [(extension.document, "swatches"), (extension.repaint, "bind")])
def test_a_faulty_document_stops_no_other_scene(scene, opened, tmp_path, monkeypatch, owner, name):
    other = bpy.data.scenes.new("Other")
    other.trochoid.filepath = str(opened(with_plate(), "other.json"))
    file = opened(with_plate())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    file.write_text('{"trochoid": 1, "palette": {"a": {"keys": []}}}')
    changed = with_plate(palette={**PALETTE, "more": "#123456"})
    (tmp_path / "other.json").write_text(json.dumps(changed))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    assert any("palette.a" in str(fault) for fault in bpy.data.scenes["Scene"].trochoid.faults)
    assert "more" in bpy.data.scenes["Other"].trochoid.palette
    # Not even if the extension itself is faulty.
    whole = getattr(owner, name)

    def fails(first, *others):
        if first in (file, bpy.data.scenes["Scene"]):
            raise ZeroDivisionError("by nothing")
        return whole(first, *others)

    monkeypatch.setattr(owner, name, fails)
    file.write_text(json.dumps(with_plate()))
    (tmp_path / "other.json").write_text(json.dumps(with_plate()))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    *_, fault = bpy.data.scenes["Scene"].trochoid.faults
    assert "a fault of the extension, ZeroDivisionError('by nothing')" in str(fault)
    assert bpy.data.scenes["Other"].trochoid.is_valid and "more" not in bpy.data.scenes["Other"].trochoid.palette


def test_a_knob_of_empty_keys_that_nothing_needs_is_only_shown(scene, opened):
    """The program accepts it."""
    opened(with_plate(knobs={**with_plate()["knobs"], "slow": {"keys": []}}))
    assert scene.trochoid.knobs["slow"].fixed == "The document animates it"


def test_warnings_of_documents_without_a_format_are_told(scene, opened):
    document = with_arrays()
    document["nodes"]["spare"] = {"type": "ScreenY"}
    file = opened(document)
    line = next(n for n, text in enumerate(file.read_text().splitlines(), 1) if "spare" in text)
    (fault,) = scene.trochoid.faults
    assert not fault.is_error and str(fault).startswith(f'line {line}: node "spare": found a node that no output needs')
    assert scene.trochoid.is_valid


def test_faults_when_painting_have_their_lines(scene, opened):
    """Also if the document has no format, and gets one for the render."""
    file = opened(with_arrays())
    text = "\n\n" + file.read_text().replace('"weight": "tone"', '"weight": "tome"')
    file.write_text(text)
    line = next(n for n, text in enumerate(text.splitlines(), 1) if "tome" in text)
    bpy.ops.render.render()
    assert f'line {line}: node "thing", weight: found' in state(scene).told


def test_places_of_faults(tmp_path):
    file = tmp_path / "look.json"
    document = with_plate(palette="inks.json")
    document["nodes"]["tone"]["max"] = "= knobs.gain"

    def places(**assigned):
        try:
            trochoid.check(json.dumps(document, indent=1), folder=tmp_path, name=str(file), **assigned)
        except trochoid.InvalidDocument as error:
            return [paint.place(fault, file) for fault in error.diagnostics]

    (tmp_path / "inks.json").write_text(json.dumps({"palette": {**PALETTE, "foam": "#zzz"}}, indent=1))
    assert places() == ["inks.json, line 4: palette.foam: "]
    (tmp_path / "inks.json").write_text(json.dumps({"palette": PALETTE}, indent=1))
    assert places(set={"knobs.gain": "much"})[-1] == 'knobs.gain="much": node "tone", max: '
    assert places(set={"palette.foam": "#zz"}) == ["palette.foam: "]


def test_a_document_that_vanishes_breaks_no_render(scene, opened):
    file = opened(with_plate())
    file.unlink()
    bpy.ops.render.render()
    assert state(scene).has_failed and str(file.name) in state(scene).told
    assert bpy.ops.trochoid.close() == {"FINISHED"} and not scene.trochoid.palette


def test_without_a_render_it_says_what_to_do(scene, opened):
    opened(with_arrays())
    with pytest.raises(RuntimeError, match=r"render an image first \(F12\)"):
        bpy.ops.trochoid.paint()


# Colors and knobs


def test_a_change_repaints(scene, opened, tmp_path):
    file = opened(with_plate())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    after = pixels(scene.trochoid.image)[0].copy()
    expected = rendered_by_command_line(scene, file, tmp_path, **{"palette.foam": "#ff0000"})
    assert after.tobytes() == expected.tobytes() and after.tobytes() != before.tobytes()
    scene.trochoid.knobs["gain"]["value"] = 2.0
    bpy.ops.trochoid.paint()
    expected = rendered_by_command_line(scene, file, tmp_path, **{"palette.foam": "#ff0000", "knobs.gain": 2})
    assert pixels(scene.trochoid.image)[0].tobytes() == expected.tobytes()
    bpy.ops.trochoid.reset(name="palette.foam")
    assert list(scene.trochoid.assignments()) == ["knobs.gain"]
    bpy.ops.trochoid.reset()
    assert pixels(scene.trochoid.image)[0].tobytes() == before.tobytes()
    with pytest.raises(RuntimeError, match="palette.NAME"):
        bpy.ops.trochoid.reset(name="palette.fome")


def test_in_a_window_another_thread_paints_the_newest_change(scene, opened, tmp_path, monkeypatch):
    file = opened(with_plate())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    monkeypatch.setattr(extension.repaint, "has_window", lambda: True)
    work, painted = extension.repaint.WORK, []
    whole = paint.paint

    def slowly(wanted, progress):
        painted.append(wanted.set["palette.foam"])
        while len(painted) == 1 and progress(1, 2):
            time.sleep(0.01)
        return whole(wanted, progress)

    monkeypatch.setattr(paint, "paint", slowly)
    for color in [(1, 0, 0), (0, 1, 0), (0, 0, 1)]:
        scene.trochoid.palette["foam"].color = color
        while not painted:
            time.sleep(0.01)
    # Nothing but the main thread touches Blender's data.
    assert pixels(scene.trochoid.image)[0].tobytes() == before.tobytes()
    while work.thread is not None:
        time.sleep(0.01)
    extension.repaint.tick()
    expected = rendered_by_command_line(scene, file, tmp_path, **{"palette.foam": "#0000ff"})
    assert pixels(scene.trochoid.image)[0].tobytes() == expected.tobytes()
    assert painted[0] == "#ff0000" and painted[-1] == "#0000ff"


def test_knobs_have_their_ranges_and_help(scene, opened):
    knobs = {**with_plate()["knobs"], "slow": {"keys": [[1, 0], [10, 1]]}, "twice": "= knobs.gain*2"}
    knobs.update({"paper": "#ff8800", "on": True, "place": [1, 2], "word": "left"})
    document = with_plate(knobs=knobs)
    document["palette"] = {**PALETTE, "dusk": {"keys": [[1, "#000000"], [9, "#ff0000"]]}}
    opened(document)
    settings = scene.trochoid
    told = settings.knobs["gain"].id_properties_ui("value").as_dict()
    assert (told["min"], told["max"], told["description"]) == (0, 3, "Strength of the light.")
    assert "plate" not in settings.knobs
    fixed = {item.name: item.fixed for item in [*settings.palette, *settings.knobs] if item.fixed}
    assert fixed == {
        "dusk": "The document animates it: 2 keys, frames 1 to 9",
        "slow": "The document animates it: 2 keys, frames 1 to 10",
        "twice": "It follows from others: = knobs.gain*2",
        "place": "It is a list: change it in the document, and press Reload",
    }
    assert [knob.kind for knob in settings.knobs] == ["NUMBER", "TEXT", "TEXT", "COLOR", "SWITCH", "TEXT", "TEXT"]


@pytest.mark.parametrize("space", ["linear-srgb", "srgb", "acescg"])
def test_colors_between_steps_are_exact(space):
    """A color that no hex number has reaches the document as numbers of its space."""
    from_hex = extension.colors.written(space, np.float32([0x27 / 255, 0x4E / 255, 0x53 / 255]))
    assert from_hex == "#274e53"
    color = (0.1234, 0.5, 0.8765)
    written = extension.colors.written(space, color)
    look = trochoid.Look(
        {
            "trochoid": 1,
            "working_space": space,
            "nodes": {"c": {"type": "Constant", "color": written}, "d": {"type": "Constant", "color": "#274e53"}},
            "outputs": {"c": {"color": "c"}, "d": {"color": "d"}},
        },
        output="c",
    )
    found = look.picture(size=(1, 1)).numpy()[0, 0]
    np.testing.assert_allclose(extension.colors.to_display(space, found), color, atol=1e-6)
    np.testing.assert_allclose(extension.colors.shown(space, [float(value) for value in found]), color, atol=1e-6)


def test_colors_and_knobs_are_keyed(scene, opened, tmp_path):
    file = opened(with_plate())
    foam, gain = scene.trochoid.palette["foam"], scene.trochoid.knobs["gain"]
    foam.keyframe_insert("color", frame=1)
    gain.keyframe_insert('["value"]', frame=1)
    foam.color, gain["value"] = (1, 0, 0), 2.5
    foam.keyframe_insert("color", frame=2)
    gain.keyframe_insert('["value"]', frame=2)
    shown = {}

    def look(scene, *_):
        assigned = {"palette.foam": "#ff0000", "knobs.gain": 2.5} if scene.frame_current == 2 else {}
        # With a window, renders animate a copy of the scene.
        assert state(scene).animated == {scene.frame_current: assigned}
        expected = rendered_by_command_line(scene, file, tmp_path, **assigned)
        shown[scene.frame_current] = (pixels(scene.trochoid.image)[0].copy(), expected)

    bpy.app.handlers.render_post.append(look)
    bpy.ops.render.render(animation=True)
    for frame in (1, 2):
        assert shown[frame][0].tobytes() == shown[frame][1].tobytes(), f"frame {frame}"


def test_changes_and_curves_follow_their_names(scene, opened):
    document = with_plate()
    opened(document)
    settings = scene.trochoid
    settings.palette["foam"].color = (1, 0, 0)
    settings.palette["foam"].keyframe_insert("color", frame=1)
    settings.palette["sky"].keyframe_insert("color", frame=1)
    document["palette"] = {"new": "#123456", "foam": PALETTE["foam"], "deep": PALETTE["deep"]}
    document["nodes"]["dim"]["b"] = "palette.new"
    opened(document)
    assert settings.palette.keys() == ["new", "foam", "deep"]
    assert tuple(settings.palette["foam"].color) == (1, 0, 0)
    paths = sorted({curve.data_path for curve in extension.curves.of(scene)})
    assert paths == ['trochoid.palette["sky"].color', "trochoid.palette[1].color"]
    opened(with_plate())
    paths = sorted({curve.data_path for curve in extension.curves.of(scene)})
    assert paths == ["trochoid.palette[1].color", "trochoid.palette[2].color"]


def test_undo_repaints(scene, opened):
    opened(with_plate())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    bpy.ops.ed.undo_push(message="before")
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    bpy.ops.ed.undo_push(message="red")
    assert pixels(scene.trochoid.image)[0].tobytes() != before.tobytes()
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert not scene.trochoid.palette["foam"].is_changed
    assert pixels(scene.trochoid.image)[0].tobytes() == before.tobytes()
    bpy.ops.ed.redo()
    assert bpy.context.scene.trochoid.palette["foam"].is_changed


def test_a_saved_file_knows_its_graph(scene, opened, tmp_path):
    opened(with_plate())
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    scene.trochoid.knobs["gain"]["value"] = 2.0
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not bpy.context.scene.trochoid.filepath
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    scene = bpy.context.scene
    assert scene.trochoid.assignments() == {"palette.foam": "#ff0000", "knobs.gain": 2}
    assert state(scene).rendered is None
    bpy.ops.render.render()
    assert not state(scene).has_failed and scene.trochoid.image is not None


# Blender's own settings


def test_settings_of_files_are_put_back(scene):
    settings = scene.render.image_settings
    kinds = {"MULTI_LAYER_IMAGE": ["OPEN_EXR_MULTILAYER"], "VIDEO": ["FFMPEG"]}
    items = {item.identifier for item in settings.bl_rna.properties["file_format"].enum_items}
    tried = 0
    for kind in ["IMAGE", *kinds] if hasattr(settings, "media_type") else [None]:
        if kind:
            settings.media_type = kind
        for name in kinds.get(kind, sorted(items - {"OPEN_EXR_MULTILAYER", "FFMPEG"} if kind else items)):
            try:
                settings.file_format = name
            except TypeError:
                # This build has no such format.
                continue
            for depth in ("8", "16", "32"):
                try:
                    settings.color_depth = depth
                except TypeError:
                    continue
                settings.quality, settings.compression = 77, 33
                before = render_result.taken(settings)
                with (
                    pytest.raises(ZeroDivisionError),
                    render_result.written_as(settings, "OPEN_EXR_MULTILAYER", color_depth="32", exr_codec="NONE"),
                ):
                    assert settings.file_format == "OPEN_EXR_MULTILAYER"
                    raise ZeroDivisionError
                assert render_result.taken(settings) == before
                tried += 1
    assert tried > 10


def test_it_leaves_nothing_behind(scene):
    extension.unregister()
    assert not hasattr(bpy.types.Scene, "trochoid")
    ours = [h for name in extension.handlers.HANDLERS for h in getattr(bpy.app.handlers, name) if "trochoid" in h.__module__]
    assert not ours
    extension.register()
    assert bpy.context.scene.trochoid.filepath == ""


def test_the_archive_is_an_extension(tmp_path):
    """Blender's own tool accepts the archive."""
    wheel = tmp_path / "trochoid-0.1.0-cp310-abi3-manylinux_2_34_x86_64.whl"
    wheel.write_bytes(b"")
    subprocess.run([sys.executable, HERE / "build.py", wheel, "--out", tmp_path], check=True)
    (archive,) = tmp_path.glob("*.zip")
    names = zipfile.ZipFile(archive).namelist()
    assert f"wheels/{wheel.name}" in names and "__init__.py" in names and not any("test" in name for name in names)
    folder = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"
    done = subprocess.run([sys.executable, folder, "validate", archive], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
