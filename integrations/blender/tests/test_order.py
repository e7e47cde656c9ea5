"""Tests of what happens at the same time, in another order, or again and again."""

import json
import threading
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
import trochoid
from conftest import SIZE, extension, pixels, rendered_by_command_line, state, with_arrays, with_plate

paint, render_result, repaint = extension.paint, extension.render_result, extension.repaint


@pytest.fixture
def window(monkeypatch):
    """Lets the extension believe that there is a window. Its timer is called by tests."""
    monkeypatch.setattr(repaint, "has_window", lambda: True)
    yield
    wait_for_thread()


def wait_for_thread():
    while repaint.WORK.thread is not None:
        time.sleep(0.01)


def held_in_thread(monkeypatch, *, before):
    """Holds paintings of the extension's thread, before or after they are painted. Returns what says that one is held, and
    what lets it go."""
    whole, is_held, go = paint.paint, threading.Event(), threading.Event()

    def held(wanted, progress=paint.go_on):
        if threading.current_thread().name != "trochoid":
            return whole(wanted, progress)
        painting = None if before else whole(wanted, progress)
        is_held.set()
        assert go.wait(30)
        return painting or whole(wanted, progress)

    monkeypatch.setattr(paint, "paint", held)
    return is_held, go


# A render while something is painted


@pytest.mark.parametrize("kind", [with_arrays, with_plate])
def test_a_painting_of_an_earlier_render_never_replaces_a_newer_one(scene, opened, window, monkeypatch, kind):
    opened(kind())
    bpy.ops.render.render()
    repaint.tick()
    is_held, go = held_in_thread(monkeypatch, before=False)
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    assert is_held.wait(30)
    bpy.data.objects["Suzanne"].location.x = 2
    bpy.ops.render.render()
    repaint.tick()
    newer = pixels(scene.trochoid.image)[0].copy()
    go.set()
    wait_for_thread()
    repaint.tick()
    assert pixels(scene.trochoid.image)[0].tobytes() == newer.tobytes()
    bpy.ops.trochoid.paint()
    assert pixels(scene.trochoid.image)[0].tobytes() == newer.tobytes()


def test_what_waits_when_a_render_begins_is_not_painted(scene, opened, window, monkeypatch):
    opened(with_arrays())
    bpy.ops.render.render()
    repaint.tick()
    is_held, go = held_in_thread(monkeypatch, before=True)
    colors = []
    whole = paint.look_of

    def look_of(wanted):
        colors.append((threading.current_thread().name, wanted.set.get("palette.foam")))
        return whole(wanted)

    monkeypatch.setattr(paint, "look_of", look_of)
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    assert is_held.wait(30)
    scene.trochoid.palette["foam"].color = (0, 1, 0)
    assert repaint.WORK.wanted
    extension.handlers.begin(scene)
    assert not repaint.WORK.wanted
    go.set()
    wait_for_thread()
    repaint.tick()
    assert state(scene).told and not repaint.WORK.done
    # If the render is canceled, what was changed is painted on the passes that there are.
    extension.handlers.end(scene)
    repaint.tick()
    wait_for_thread()
    repaint.tick()
    assert colors[-1] == ("trochoid", "#00ff00")
    assert state(scene).painted == repaint.fingerprint(repaint.request(scene))


def test_a_change_during_a_render_is_painted_after_it(scene, opened):
    opened(with_arrays())

    def change(scene, *_):
        scene.trochoid.palette["foam"].color = (0, 1, 0)

    bpy.app.handlers.render_post.append(change)
    bpy.ops.render.render()
    shown = pixels(scene.trochoid.image)[0].copy()
    bpy.app.handlers.render_post.remove(change)
    bpy.ops.trochoid.paint()
    assert pixels(scene.trochoid.image)[0].tobytes() == shown.tobytes()
    assert state(scene).painted == repaint.fingerprint(repaint.request(scene))
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    assert pixels(scene.trochoid.image)[0].tobytes() != shown.tobytes()


def test_passes_are_not_read_while_they_are_written(scene, opened, window, monkeypatch):
    opened(with_arrays())
    bpy.ops.render.render()
    repaint.tick()
    scene.trochoid.live = False
    wanted = repaint.request(scene)
    save, orders = render_result.save, []

    def slowly(scene):
        reader = threading.Thread(target=lambda: (paint.paint(wanted), orders.append("read")))
        reader.start()
        time.sleep(0.5)
        file = save(scene)
        orders.append("saved")
        return file

    monkeypatch.setattr(render_result, "save", slowly)
    repaint.keep_passes(scene)
    while len(orders) < 2:
        time.sleep(0.01)
    assert orders == ["saved", "read"]


# Again and again


def test_many_frames_leave_one_painting_to_show(scene, opened, window):
    """Scripts render without a pause for the main thread."""
    opened(with_arrays())
    scene.frame_end = 4
    bpy.ops.render.render(animation=True)
    ((uid, results),) = repaint.WORK.done.items()
    assert uid == scene.session_uid and [painting.request.frame for painting in results] == [4]
    repaint.tick()
    assert not repaint.WORK.done and state(scene).painting is None


def test_a_painting_that_was_not_written_is_never_written_for_another_render(scene, opened, tmp_path):
    opened(with_arrays())
    scene.trochoid.frames = str(tmp_path / "painted.####.png")
    bpy.ops.render.render()
    scene.trochoid.repaint = False
    bpy.ops.render.render(animation=True)
    assert not list(tmp_path.glob("painted.*"))
    scene.trochoid.repaint = True
    bpy.ops.render.render()
    bpy.ops.trochoid.close()
    bpy.ops.render.render(animation=True)
    assert not list(tmp_path.glob("painted.*"))


def test_frames_that_are_missing_are_told_after_an_animation(scene, opened, tmp_path, monkeypatch):
    opened(with_arrays())
    scene.frame_end = 3
    scene.trochoid.frames = str(tmp_path / "painted.####.png")
    (tmp_path / "painted.0001.png").mkdir()
    whole = paint.composed

    def composed(wanted, progress):
        if wanted.frame == 2:
            raise trochoid.Error("no room")
        return whole(wanted, progress)

    monkeypatch.setattr(paint, "composed", composed)
    bpy.ops.render.render(animation=True)
    assert not state(scene).has_failed
    assert repaint.frames_missed(scene).endswith(": 1, 2")
    assert (tmp_path / "painted.0003.png").is_file()
    bpy.ops.render.render()
    assert not repaint.frames_missed(scene)


def test_ten_times_enabled_it_is_there_once(scene):
    for _ in range(10):
        extension.unregister()
        extension.register()
    for name in extension.handlers.HANDLERS:
        ours = [one for one in getattr(bpy.app.handlers, name) if one.__module__.startswith(extension.__name__)]
        assert len(ours) == 1, name


def test_ten_renders_need_one_image_and_one_file(scene, opened):
    opened(with_plate())
    bpy.ops.render.render()
    before = sorted(Path(bpy.app.tempdir).glob("trochoid-*"))
    for _ in range(10):
        bpy.ops.render.render()
        scene.trochoid.knobs["gain"]["value"] *= 0.9
        bpy.ops.trochoid.paint()
    assert [image.name for image in bpy.data.images if image.type != "RENDER_RESULT"] == ["Trochoid"]
    assert sorted(Path(bpy.app.tempdir).glob("trochoid-*")) == before and len(repaint.STATES) == 1


# In another order


def test_passes_of_files_before_are_removed(scene, opened, tmp_path):
    opened(with_plate())
    bpy.ops.render.render()
    assert render_result.path_of(scene).exists()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    assert not list(Path(bpy.app.tempdir).glob("trochoid-*"))
    scene = bpy.context.scene
    bpy.ops.render.render()
    extension.unregister()
    assert not list(Path(bpy.app.tempdir).glob("trochoid-*"))
    extension.register()


def test_a_file_that_was_saved_with_its_painting_is_painted_again(scene, opened, tmp_path):
    file = opened(with_plate())
    bpy.ops.render.render()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    scene = bpy.context.scene
    assert scene.trochoid.image is not None and not state(scene).told
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    bpy.ops.render.render()
    assert not state(scene).has_failed and tuple(scene.trochoid.image.size) == SIZE
    expected = rendered_by_command_line(scene, file, tmp_path, **{"palette.foam": "#ff0000"})
    assert pixels(scene.trochoid.image)[0].tobytes() == expected.tobytes()
    assert len([image for image in bpy.data.images if image.type != "RENDER_RESULT"]) == 1


def test_a_graph_chosen_after_the_render_is_painted_by_paint(scene, tmp_path):
    scene.view_layers[0].use_pass_diffuse_direct = scene.view_layers[0].use_pass_z = True
    bpy.ops.render.render()
    file = tmp_path / "graph.json"
    file.write_text(json.dumps(with_arrays()))
    bpy.ops.trochoid.open(filepath=str(file))
    assert scene.trochoid.image is None
    bpy.ops.trochoid.paint()
    assert pixels(scene.trochoid.image)[0].std() > 0.01


def test_undo_of_the_first_painting_paints_again(scene, opened):
    opened(with_arrays())
    bpy.ops.ed.undo_push(message="opened")
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    bpy.data.objects["Suzanne"].location.x = 1
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert scene.trochoid.image is not None
    np.testing.assert_array_equal(pixels(scene.trochoid.image)[0], before)


def test_an_image_that_was_deleted_is_made_anew(scene, opened):
    opened(with_arrays())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    bpy.data.images.remove(scene.trochoid.image)
    assert scene.trochoid.image is None
    bpy.ops.trochoid.paint()
    np.testing.assert_array_equal(pixels(scene.trochoid.image)[0], before)


def test_without_a_graph_a_render_is_left_alone(scene):
    bpy.ops.render.render()
    assert not state(scene).told and not list(Path(bpy.app.tempdir).glob("trochoid-*"))
    assert not bpy.ops.trochoid.paint.poll() and not bpy.ops.trochoid.show.poll() and not bpy.ops.trochoid.reload.poll()


def test_a_render_without_the_graph_is_not_mistaken_for_the_one_before(scene, opened):
    file = opened(with_arrays())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    bpy.ops.trochoid.close()
    bpy.data.objects["Suzanne"].location.x = 2
    bpy.ops.render.render()
    bpy.ops.trochoid.open(filepath=str(file))
    bpy.ops.trochoid.paint()
    after = pixels(scene.trochoid.image)[0].copy()
    assert after.tobytes() != before.tobytes()
    bpy.ops.render.render()
    assert pixels(scene.trochoid.image)[0].tobytes() == after.tobytes()


def test_the_frame_of_the_passes_is_told(scene, opened):
    opened(with_arrays())
    scene.trochoid.repaint = False
    bpy.ops.render.render()
    scene.frame_set(2)
    bpy.ops.trochoid.paint()
    assert state(scene).rendered == 1 and state(scene).told.endswith(", passes of frame 1")
    bpy.ops.render.render()
    bpy.ops.trochoid.paint()
    assert state(scene).rendered == 2 and "passes of frame" not in state(scene).told


def test_scenes_have_their_own_renders_and_images(scene, opened):
    opened(with_arrays())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    bpy.ops.scene.new(type="FULL_COPY")
    copy = bpy.context.scene
    assert copy != scene and copy.trochoid.image == scene.trochoid.image
    with pytest.raises(RuntimeError, match=r"render an image first \(F12\)"):
        bpy.ops.trochoid.paint()
    copy.objects["Suzanne.001"].location.x = 2
    bpy.ops.render.render()
    assert copy.trochoid.image != scene.trochoid.image
    assert pixels(copy.trochoid.image)[0].tobytes() != before.tobytes()
    assert pixels(scene.trochoid.image)[0].tobytes() == before.tobytes()
    kept = copy.trochoid.image
    bpy.ops.render.render()
    assert copy.trochoid.image == kept


def test_paint_waits_for_no_render(scene, opened):
    opened(with_arrays())
    bpy.ops.render.render()
    scene.trochoid.repaint = False
    told = []

    def press(_scene, *_):
        try:
            bpy.ops.trochoid.paint()
        except RuntimeError as error:
            told.append(str(error))

    bpy.app.handlers.render_post.append(press)
    bpy.ops.render.render()
    bpy.app.handlers.render_post.remove(press)
    assert len(told) == 1 and "found a render under way" in told[0]
    bpy.ops.trochoid.paint()


def test_the_timer_goes_on_whatever_happens(scene, opened, window, monkeypatch, capfd):
    opened(with_arrays())
    bpy.ops.render.render()

    def fails():
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(extension.image, "redraw", fails)
    assert repaint.tick() == repaint.SECONDS_BETWEEN_LOOKS
    assert "by nothing" in capfd.readouterr().err


def test_a_packed_painting_stays_in_the_file(scene, opened, tmp_path):
    opened(with_arrays())
    bpy.ops.render.render()
    before = pixels(scene.trochoid.image)[0].copy()
    scene.trochoid.image.pack()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    scene = bpy.context.scene
    np.testing.assert_array_equal(pixels(scene.trochoid.image)[0], before)
    scene.trochoid.palette["foam"].color = (1, 0, 0)
    bpy.ops.render.render()
    shown = pixels(scene.trochoid.image)[0].copy()
    assert not state(scene).has_failed and shown.tobytes() != before.tobytes()
    expected = paint.paint(repaint.request(scene)).pixels
    assert shown.tobytes() == expected.tobytes()


def test_a_scene_from_another_file_is_left_alone(scene, opened, tmp_path):
    """Linked from a library, with a graph that has vanished since."""
    file = opened(with_arrays())
    scene.name = "Linked"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    file.unlink()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.scenes = ["Linked"]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    linked = next(one for one in bpy.data.scenes if one.library)
    assert linked.trochoid.path == file
    assert bpy.ops.render.render.poll()
