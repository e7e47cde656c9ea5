"""Tests of paintings and passes in Blender without a window: `pytest integrations/blender/tests`, with bpy and the wheel."""

import json

import bpy
import numpy as np
import pytest
from conftest import SIZE, command_line, extension, pixels, rendered_by_command_line, state, with_arrays, with_plate

paint, plate, render_result = extension.paint, extension.plate, extension.render_result


# Painting


def test_three_calls_paint(scene, tmp_path):
    file = tmp_path / "graph.json"
    file.write_text(json.dumps(with_arrays()))
    scene.view_layers[0].use_pass_diffuse_direct = scene.view_layers[0].use_pass_z = True
    bpy.ops.trochoid.open(filepath=str(file))
    bpy.ops.render.render()
    image = bpy.data.images["Trochoid"]
    assert tuple(image.size) == SIZE and image.is_float
    assert state(scene).told.startswith(f"hull, 0 of {SIZE[0] * SIZE[1]} pixels outside")


def test_frames_are_those_of_the_command_line(scene, opened, tmp_path):
    file = opened(with_plate())
    scene.trochoid.frames = str(tmp_path / "painted.####.png")
    seen = {}

    def look(scene, *_):
        # After the extension's own handler: the passes of this frame are in the file, its painting in the image.
        seen[scene.frame_current] = (
            pixels(scene.trochoid.image)[0].copy(),
            rendered_by_command_line(scene, file, tmp_path),
            command_line(file, render_result.path_of(scene), tmp_path / "expected.png", scene.frame_current).read_bytes(),
        )

    bpy.app.handlers.render_write.append(look)
    bpy.ops.render.render(animation=True)
    assert sorted(seen) == [1, 2]
    for frame, (shown, expected, png) in seen.items():
        assert shown.tobytes() == expected.tobytes(), f"frame {frame}"
        assert expected.std() > 0.05
        assert (tmp_path / f"painted.{frame:04d}.png").read_bytes() == png
        assert list(tmp_path.glob(f"blender.{frame:04d}.*"))
    assert seen[1][0].tobytes() != seen[2][0].tobytes()


def test_an_exr_beside_each_frame(scene, opened, tmp_path):
    file = opened(with_plate())
    scene.trochoid.frames = str(tmp_path / "painted.####.exr")
    bpy.ops.render.render(write_still=True)
    written = plate.read(tmp_path / "painted.0001.exr", "", "RGB", SIZE)
    assert written.tobytes() == rendered_by_command_line(scene, file, tmp_path).tobytes()
    # A render that writes no frame writes no painting.
    scene.frame_set(2)
    bpy.ops.render.render()
    assert not (tmp_path / "painted.0002.exr").exists()


@pytest.mark.parametrize("name", ["painted.jpg", "painted.####.exr", "nowhere/\0.png"])
def test_files_that_cannot_be_written_are_told(scene, opened, tmp_path, name):
    opened(with_arrays())
    scene.trochoid.frames = str(tmp_path / name.replace("\0", "x" * 300))
    bpy.ops.render.render(write_still=True)
    assert state(scene).has_failed and list(tmp_path.glob("blender.*"))
    if name.endswith(".exr"):
        assert 'no knob "plate"' in state(scene).told
    assert scene.trochoid.image is not None


@pytest.mark.parametrize("space", ["linear-srgb", "srgb", "acescg"])
@pytest.mark.parametrize("kind", [with_plate, with_arrays])
def test_blender_displays_what_the_png_shows(scene, opened, tmp_path, kind, space):
    opened(kind(working_space=space))
    bpy.ops.render.render()
    file = tmp_path / "painted.png"
    paint.write(paint.paint(extension.repaint.request(scene)), file)
    expected = bpy.data.images.load(str(file))
    # What image editors show of an image that is no render, whatever the scene's own view transform is.
    image = scene.trochoid.image
    assert not image.use_view_as_render
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.render.dither_intensity = 0
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    image.save_render(str(tmp_path / "displayed.png"), scene=scene)
    displayed = bpy.data.images.load(str(tmp_path / "displayed.png"))
    steps = 255 * np.abs(pixels(displayed)[0] - pixels(expected)[0])
    # Both round to whole steps of 255.
    assert steps.max() < 1.01 and (steps > 0.5).mean() < 0.01


def test_the_image_is_kept_from_frame_to_frame(scene, opened):
    opened(with_arrays())
    bpy.ops.render.render()
    image = scene.trochoid.image
    image.name = "Renamed"
    scene.render.resolution_percentage = 50
    bpy.ops.render.render()
    assert scene.trochoid.image == image and tuple(image.size) == (SIZE[0] // 2, SIZE[1] // 2)
    assert (pixels(image)[1] == 1).all()
    assert [other.name for other in bpy.data.images if other.type != "RENDER_RESULT"] == ["Renamed"]


def test_pixels_are_those_of_the_render(scene, opened):
    """Without a format, a shift of three pixels is one of three pixels. With one, it shrinks with the picture."""
    document = with_arrays()
    opened(document)
    bpy.ops.render.render()
    still = pixels(scene.trochoid.image)[0].copy()
    document["nodes"]["moved"] = {"type": "Warp", "image": "beauty", "dx": 3}
    document["outputs"] = {"beauty": {"color": "moved"}}
    opened(document)
    moved = pixels(scene.trochoid.image)[0].copy()
    np.testing.assert_array_equal(moved[:, :-3], still[:, 3:])
    opened({**document, "format": {"width": SIZE[0] * 3, "height": SIZE[1] * 3}})
    moved = pixels(scene.trochoid.image)[0].copy()
    np.testing.assert_allclose(moved[:, :-1], still[:, 1:], atol=1e-6)


def test_a_part_of_the_frame(scene, opened):
    opened(with_arrays())
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.21, 0.77
    scene.render.border_min_y, scene.render.border_max_y = 0.13, 0.9
    bpy.ops.render.render()
    assert not state(scene).has_failed
    width, height = scene.trochoid.image.size
    assert 80 <= width <= 92 and 66 <= height <= 72


# Passes


def test_passes_are_as_documents_mean_them(scene, opened):
    """Each pass is painted into a color, and compared with what Blender wrote."""
    names = ["depth", "coverage", "normal", "position", "diffuse_direct"]
    nodes = {
        "across": {"type": "ScreenX"},
        "depth": {"type": "FieldMath", "expression": "9*a", "a": "across"},
        "coverage": {"type": "ScreenX"},
        "normal": {"type": "FieldMath", "expression": "[0, a, 0]", "components": 3, "a": "across"},
        "position": {"type": "FieldMath", "expression": "[0, a, 0]", "components": 3, "a": "across"},
        "diffuse_direct": {"type": "ScreenX"},
        "far": {"type": "Clamp", "field": "depth", "min": 0, "max": 32},
        "all": {
            "type": "FieldMath",
            "expression": "[a.y*0.5 + 0.5, 0.05*b.z + 0.5, min(c, 1)]",
            "components": 3,
            "a": "normal",
            "b": "position",
            "c": "diffuse_direct",
        },
        "up": {"type": "FieldMath", "expression": "a.x", "a": "all"},
        "ahead": {"type": "FieldMath", "expression": "a.y", "a": "all"},
        "lit": {"type": "FieldMath", "expression": "a.z", "a": "all"},
        "m_up": {"type": "Clamp", "field": "up"},
        "m_ahead": {"type": "Clamp", "field": "ahead"},
        "m_lit": {"type": "Clamp", "field": "lit"},
        "seen": {"type": "Clamp", "field": "coverage"},
        "shares": {"type": "Mix", "a": [0, 0, 0], "b": [1, 0, 0], "weight": "m_up"},
        "green": {"type": "Mix", "a": [0, 0, 0], "b": [0, 1, 0], "weight": "m_ahead"},
        "blue": {"type": "Mix", "a": [0, 0, 0], "b": [0, 0, 1], "weight": "m_lit"},
        "two": {"type": "Mix", "a": "shares", "b": "green", "weight": 0.5},
        "three": {"type": "Mix", "a": "two", "b": "blue", "weight": 0.5},
        "distant": {"type": "Mix", "a": [0, 0, 0], "b": [1, 0, 0], "weight": "far"},
        "hit": {"type": "Mix", "a": "distant", "b": [0, 1, 0], "weight": 0.5},
        "mask": {"type": "Mix", "a": [0, 0, 0], "b": "hit", "weight": 1},
        "covered": {"type": "Mix", "a": "mask", "b": [0, 0, 1], "weight": "seen"},
    }
    outputs = {"beauty": {"color": "three"}, "far": {"color": "distant"}, "covered": {"color": "covered"}}
    opened(with_arrays(palette={}, nodes=nodes, outputs=outputs))
    assert [binding.name for binding in scene.trochoid.bindings] == names
    scene.unit_settings.scale_length = 0.5
    bpy.ops.render.render()
    passes = render_result.path_of(scene)
    stored = {name: plate.read_pass(passes, "ViewLayer", extension.passes.OF_NODES[name], SIZE) for name in names}
    depth = stored["depth"][..., 0]
    assert (depth == np.float32(1e10)).sum() > 1000 and (depth < 100).sum() > 1000
    shown = pixels(scene.trochoid.image)[0]
    # Up is z in Blender; behind is its −y, half a meter a unit.
    np.testing.assert_allclose(shown[..., 0], 0.25 * np.clip(stored["normal"][..., 2] * 0.5 + 0.5, 0, 1), atol=2e-6)
    behind = np.clip(0.05 * 0.5 * -stored["position"][..., 1] + 0.5, 0, 1)
    np.testing.assert_allclose(shown[..., 1], 0.25 * behind, atol=2e-6)
    luminance = np.clip(stored["diffuse_direct"] @ [0.2126, 0.7152, 0.0722], 0, 1)
    np.testing.assert_allclose(shown[..., 2], 0.5 * luminance, atol=2e-6)
    scene.trochoid.output = "far"
    shown = pixels(scene.trochoid.image)[0]
    # What is missed is infinitely far away.
    meant = extension.passes.converted(extension.passes.OF_NODES["depth"], stored["depth"], 0.5)[..., 0]
    assert (np.isinf(meant) == (depth > 1e9)).all()
    np.testing.assert_allclose(shown[..., 0], np.clip(depth * 0.5 / 32, 0, 1), atol=2e-6)
    assert (shown[depth > 1e9, 0] == 1).all()
    scene.trochoid.output = "covered"
    assert (pixels(scene.trochoid.image)[0][..., 2] == (depth < 1e9)).all()


def test_far_things_of_scenes_in_millimeters_are_seen(scene, opened):
    """A wall behind everything, a hundred meters away: 100,000 units."""
    bpy.ops.mesh.primitive_plane_add(size=300_000, location=(0, 1e5, 0), rotation=(np.pi / 2, 0, 0))
    scene.camera.data.clip_end = 1e6
    scene.camera.rotation_euler = (np.pi / 2, 0, 0)
    scene.unit_settings.scale_length = 0.001
    nodes = {
        "across": {"type": "ScreenX"},
        "depth": {"type": "FieldMath", "expression": "9*a", "a": "across"},
        "coverage": {"type": "ScreenX"},
        "far": {"type": "FieldMath", "expression": "a/200", "a": "depth"},
        "away": {"type": "Clamp", "field": "far"},
        "seen": {"type": "Clamp", "field": "coverage"},
        "distant": {"type": "Mix", "a": [0, 0, 0], "b": [1, 0, 0], "weight": "away"},
        "covered": {"type": "Mix", "a": "distant", "b": [0, 0, 1], "weight": "seen"},
    }
    opened(with_arrays(palette={}, nodes=nodes, outputs={"far": {"color": "distant"}, "covered": {"color": "covered"}}))
    bpy.ops.render.render()
    # Half of 200 meters.
    np.testing.assert_allclose(pixels(scene.trochoid.image)[0][5, 80, 0], 0.5, atol=1e-3)
    scene.trochoid.output = "covered"
    assert pixels(scene.trochoid.image)[0][5, 80, 2] == 1


def test_only_what_blender_calls_missed_is_missed():
    depth = np.float32([[[10], [65504], [1e7], [9.9e9], [1e10], [2e10], [np.inf]]])
    known = extension.passes.OF_NODES
    expected = np.float32([10, 65504, 1e7, 9.9e9, np.inf, np.inf, np.inf])
    np.testing.assert_array_equal(extension.passes.converted(known["depth"], depth, 1.0).ravel(), expected)
    np.testing.assert_array_equal(extension.passes.converted(known["coverage"], depth, 1.0).ravel(), np.isfinite(expected))


def test_nodes_with_colors_take_no_passes(scene, opened):
    nodes = {**with_arrays()["nodes"], "emission": {"type": "Mix", "a": "palette.sky", "b": "palette.foam", "weight": 0.5}}
    nodes["beauty"] = {**nodes["beauty"], "a": "emission"}
    opened(with_arrays(nodes=nodes))
    assert [binding.name for binding in scene.trochoid.bindings] == ["diffuse_direct", "coverage"]


def test_a_mask_is_no_depth(scene, opened):
    nodes = {**with_arrays()["nodes"], "depth": {"type": "ScreenX"}}
    nodes["seen"] = {"type": "Clamp", "field": "depth"}
    opened(with_arrays(nodes=nodes))
    assert [binding.name for binding in scene.trochoid.bindings] == ["diffuse_direct"]
    _, fault = scene.trochoid.faults
    assert not fault.is_error and str(fault).startswith('node "depth": found a mask; expected a field, as Z is')


def test_a_pass_that_is_off_is_named_and_switched_on(scene, tmp_path):
    file = tmp_path / "graph.json"
    file.write_text(json.dumps(with_plate()))
    bpy.ops.trochoid.open(filepath=str(file))
    (off,) = extension.repaint.passes_off(scene)
    assert off == ("Diffuse Direct", "use_pass_diffuse_direct", "ViewLayer")
    # The render is whole, and its painting says what is missing.
    bpy.ops.render.render()
    assert state(scene).has_failed and scene.trochoid.image is None
    with pytest.raises(RuntimeError, match='Diffuse Direct is off in the view layer "ViewLayer"'):
        bpy.ops.trochoid.paint()
    bpy.ops.trochoid.enable_passes()
    assert scene.view_layers[0].use_pass_diffuse_direct and not extension.repaint.passes_off(scene)
    bpy.ops.render.render()
    assert not state(scene).has_failed and scene.trochoid.image is not None


def test_a_pass_can_be_left_to_the_document(scene, opened):
    opened(with_arrays())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    scene.trochoid.bindings["coverage"].use = False
    after = pixels(scene.trochoid.image)[0]
    assert not np.array_equal(before, after)
    assert list(extension.repaint.request(scene).bound) == ["diffuse_direct"]


def test_layers_of_other_view_layers_are_told(scene, tmp_path):
    file = tmp_path / "graph.json"
    file.write_text(json.dumps(with_plate()).replace("ViewLayer.", "Ocean."))
    bpy.ops.trochoid.open(filepath=str(file))
    told = [extension.repaint.sentence_of_pass(off) for off in extension.repaint.passes_off(scene)]
    assert len(told) == 1 and "no view layer has the name before its dot" in told[0]


def test_view_layers_may_have_dots(scene, opened, tmp_path):
    scene.view_layers[0].name = "View.Layer"
    file = tmp_path / "graph.json"
    file.write_text(json.dumps(with_plate()).replace("ViewLayer.", "View.Layer."))
    bpy.ops.trochoid.open(filepath=str(file))
    (off,) = extension.repaint.passes_off(scene)
    assert off == ("Diffuse Direct", "use_pass_diffuse_direct", "View.Layer")
    bpy.ops.trochoid.enable_passes()
    bpy.ops.render.render()
    assert not state(scene).has_failed, state(scene).told


def test_shader_aovs_are_passes(scene, opened):
    aov = scene.view_layers[0].aovs.add()
    aov.name, aov.type = "rust", "VALUE"
    material = bpy.data.materials.new("Rusty")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = "rust"
    node.inputs["Value"].default_value = 0.25
    bpy.data.objects["Suzanne"].data.materials.append(material)
    nodes = {**with_arrays()["nodes"], "rust": {"type": "ScreenX"}}
    nodes["beauty"] = {**nodes["beauty"], "weight": "rust"}
    opened(with_arrays(nodes=nodes))
    bpy.ops.render.render()
    assert not state(scene).has_failed, state(scene).told
    stored = plate.read(render_result.path_of(scene), "ViewLayer.rust", "X", SIZE)
    assert 0.2 < stored.max() <= 0.25


def test_masks_of_objects(scene, opened):
    document = with_plate()
    document["nodes"]["light"] = {"type": "CryptoMask", "file": "= knobs.plate", "names": ["Suzanne"]}
    file = opened(document)
    assert scene.view_layers[0].use_pass_cryptomatte_object
    bpy.ops.render.render()
    assert not state(scene).has_failed, state(scene).told
    assert extension.document.read(file).reads_objects
