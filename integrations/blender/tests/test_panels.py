"""Tests of what the panels say. Without a window, a layout that remembers its texts stands in for Blender's."""

import bpy
import pytest
from conftest import extension, state, with_arrays, with_plate


class Layout:
    """Takes what a panel draws."""

    def __init__(self, texts=None):
        self.texts = [] if texts is None else texts

    def inner(self, **_):
        return Layout(self.texts)

    row = column = box = inner

    def label(self, text="", **_):
        self.texts.append(text)

    def prop(self, owner, name, text=None, **_):
        owner.path_resolve(name)
        self.texts.append(name if text is None else text)

    def operator(self, name, text=None, **_):
        group, _, operator = name.partition(".")
        assert operator in dir(getattr(bpy.ops, group))
        self.texts.append(name if text is None else text)
        return type("Properties", (), {})()

    def progress(self, text="", **_):
        self.texts.append(text)


@pytest.fixture
def drawn(monkeypatch):
    """Draws all panels of an editor, as far as they are shown, and returns their texts."""
    monkeypatch.setattr(extension.panels, "wrapped", lambda text: [text])

    def drawn():
        texts = []
        for panel in extension.panels.CLASSES:
            if not hasattr(panel, "poll") or panel.poll(bpy.context):
                drawing = type("Drawing", (), {"layout": Layout(texts)})()
                panel.draw(drawing, bpy.context)
        return texts

    return drawn


def test_without_a_graph(scene, drawn):
    assert "Open a graph (.json), and render." in drawn()


@pytest.mark.parametrize("kind", [with_arrays, with_plate])
def test_with_a_graph(scene, opened, drawn, kind):
    opened(kind())
    assert "Checked" in drawn() and "foam" in drawn()
    bpy.ops.render.render()
    assert state(scene).told in drawn()


def test_faults_and_what_to_do(scene, opened, drawn, tmp_path):
    file = opened(with_plate())
    scene.trochoid.frames = "//painted.png"
    assert any("save this one first" in text for text in drawn())
    scene.trochoid.frames = ""
    scene.view_layers[0].use_pass_diffuse_direct = False
    assert any("the pass Diffuse Direct is off" in text for text in drawn())
    scene.render.use_multiview = True
    assert any("found Stereoscopy" in text for text in drawn())
    state(scene).missed = [3, 4]
    assert any(text.endswith(": 3, 4") for text in drawn())
    file.write_text(file.read_text().replace('"plate.exr"', '"../elsewhere.exr"').replace('"= knobs.plate"', '"../x.exr"'))
    (tmp_path.parent / "x.exr").write_bytes(b"")
    assert "allow" not in drawn()
    with pytest.raises(RuntimeError, match="Allow"):
        bpy.ops.trochoid.reload()
    assert "allow" in drawn()
