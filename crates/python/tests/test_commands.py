"""The commands of the program."""

import errno
import inspect
import json
import logging
import os
import pathlib
import re
import threading

import numpy as np
import pytest
import trochoid
from conftest import WATER, slow


def test_runs_return_what_the_program_prints():
    output = trochoid.run(["nodes", "Mix"])
    assert output.text.startswith("Mix") and output.messages == [] and str(output) == output.text
    assert "\x1b" not in output.text
    assert trochoid.run(["nodes", "--json"]).json()
    assert trochoid.run(["--version"]).text.strip().endswith(trochoid.__version__)
    assert "Usage: trochoid render" in trochoid.run(["render", "--help"]).text


def test_wrong_usage_is_told_with_the_code_of_the_program():
    for arguments, code, text in [
        (["rendre"], 2, "unrecognized subcommand"),
        (["info", "no such.exr"], 1, "no such.exr"),
        (["edit"], 2, "run the program"),
    ]:
        with pytest.raises(trochoid.CommandError, match=text) as raised:
            trochoid.run(arguments)
        assert raised.value.code == code and text in "\n".join(raised.value.messages)
    with pytest.raises(TypeError):
        trochoid.run(["nodes", 5])


def test_documents_are_checked(scene):
    assert trochoid.check("water.json") == trochoid.check(pathlib.Path("water.json")) == trochoid.check(WATER) == []
    faulty = (scene / "water.json").read_text().replace('"weight": "light"', '"weight": "lihgt"')
    (scene / "faulty.json").write_text(faulty)
    for document in ["faulty.json", faulty, json.loads(faulty)]:
        with pytest.raises(trochoid.InvalidDocument, match="did you mean") as raised:
            trochoid.check(document)
        assert [fault["node"] for fault in raised.value.diagnostics] == ["water"]
    with pytest.raises(trochoid.InvalidDocument, match="nothing"):
        trochoid.check("water.json", set={"water.nothing": 1})
    assert trochoid.check("water.json", set={"palette.foam": "#fff"}) == []
    with pytest.raises(FileNotFoundError, match="cannot open the file.*absent.json") as raised:
        trochoid.check("absent.json")
    assert (raised.value.errno, raised.value.filename) == (errno.ENOENT, "absent.json")
    with pytest.raises(IsADirectoryError, match="found a folder"):
        trochoid.check(scene)
    with pytest.raises(TypeError, match="frame"):
        trochoid.check(WATER, frame=1)
    with pytest.raises(TypeError, match="folder"):
        trochoid.check("water.json", folder=".")


def test_warnings_are_returned_and_files_are_checked(scene):
    document = json.loads((scene / "water.json").read_text())
    document["nodes"]["spare"] = {"type": "ScreenX"}
    document["nodes"]["plate"] = {"type": "Read", "file": "absent.exr", "as": "color"}
    document["outputs"]["plate"] = {"color": "plate"}
    (scene / "warned.json").write_text(json.dumps(document))
    found = trochoid.check("warned.json")
    assert {warning["severity"] for warning in found} == {"warning"}
    assert any("absent.exr" in json.dumps(warning) for warning in found)
    with pytest.raises(trochoid.InvalidDocument) as raised:
        trochoid.check("warned.json", strict=True)
    assert raised.value.diagnostics == found


def test_frames_are_rendered(scene):
    told = []
    frames = trochoid.render(
        "water.json",
        frames=range(1, 4),
        out="out/{output}.####.exr",
        set={"palette.foam": "#ffffff"},
        progress=lambda done, total: told.append((done, total)),
    )
    assert [frame["frame"] for frame in frames] == [1, 2, 3]
    paths = [file["path"] for frame in frames for file in frame["files"]]
    assert paths == [os.path.join("out", f"beauty.000{frame}.exr") for frame in (1, 2, 3)]
    assert all((scene / path).exists() for path in paths)
    assert frames[0]["outputs"]["beauty"]["hull_exits"] == 0
    assert told[-1] == (3000, 3000)
    again = trochoid.render(
        "water.json", frames="2", out="out/{output}.####.exr", set={"palette.foam": "#ffffff"}, resume=True
    )
    assert again[0]["skipped"] is True
    assert len(trochoid.render("water.json", frames=np.int64(2), out="one.png", scale="1/2", region=None)) == 1
    # Names may have signs that end lines elsewhere.
    named = trochoid.render("water.json", frames=1, out="a\u2028b/one.png")
    assert named[0]["files"][0]["path"] == os.path.join("a\u2028b", "one.png")
    assert trochoid.run(["info", "one.png", "--json"]).json()["parts"][0]["display"]["x1"] == 20


def test_the_rendered_picture_is_that_of_a_look(scene):
    trochoid.render("water.json", frames=1, out="whole.exr")
    picture = trochoid.Look.load("water.json").picture(size=(40, 30))
    mean = trochoid.run(["info", "whole.exr", "--json"]).json()["parts"][0]["channels"]
    by_name = {channel["name"]: channel for channel in mean}
    # EXR has linear light.
    srgb = picture.numpy().astype(np.float64)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    for name, values in zip("RGB", np.moveaxis(linear, -1, 0)):
        assert by_name[name]["mean"] == pytest.approx(values.mean(), rel=1e-3)


@pytest.mark.parametrize("name", ["check", "render", "palette", "decompose", "recolor", "plan"])
def test_all_options_have_arguments(name):
    help = trochoid.run([name, "--help"]).text
    options = {option.replace("-", "_") for option in re.findall(r"^ +(?:-\w, )?--([a-z-]+)", help, re.MULTILINE)}
    # How results are told, and what concerns the whole program.
    options -= {"json", "quiet", "progress", "help", "memory"}
    if name == "check":
        options -= {"explain", "measure", "output"}
    if name == "palette":
        # They concern documents only.
        options -= {"allow", "strict"}
    assert options <= set(inspect.signature(getattr(trochoid, name)).parameters)


def test_failures_have_the_code_of_the_program(scene):
    (scene / "foreign.png").write_bytes(b"not by Trochoid")
    with pytest.raises(trochoid.CommandError, match="foreign.png(.|\n)*replace it with overwrite=True") as raised:
        trochoid.render("water.json", frames=1, out="foreign.png")
    assert raised.value.code in (1, 2) and "--overwrite" not in "".join(raised.value.messages)
    assert (scene / "foreign.png").read_bytes() == b"not by Trochoid"
    trochoid.render("water.json", frames=1, out="foreign.png", overwrite=True)
    with pytest.raises(trochoid.CommandError) as raised:
        trochoid.render("water.json", frames="backward")
    assert raised.value.code == 2 and raised.value.text == ""


def test_a_picture_is_taken_apart_and_painted_again(scene):
    trochoid.render("water.json", frames=1, out="water.png")
    found = trochoid.palette("water.png", out=["inks.json", "inks.gpl"])
    assert json.loads((scene / "inks.json").read_text()) and len(found["palette"]) >= 4
    recipes = trochoid.decompose(["water.png"], "inks.json", out="{name}.recipe.exr", float=True)
    assert recipes[0]["files"] == ["water.recipe.exr"] and recipes[0]["outside"] == 0
    name = next(iter(found["palette"]))
    painted = trochoid.recolor("water.recipe.exr", "{name}.warm.png", set={name: "#ff0000"})
    assert [picture["file"] for picture in painted] == ["water.recipe.warm.png"]
    assert painted[0]["recipe"] == "water.recipe.exr" and painted[0]["outside"] == 0 and painted[0]["within"] < 1e-3
    assert (scene / "water.recipe.warm.png").exists()
    assert trochoid.decompose([], "inks.json", cube="same.cube", to="inks.json", cube_size=9) == []
    assert "LUT_3D_SIZE 9" in (scene / "same.cube").read_text()
    with pytest.raises(trochoid.CommandError, match="did you mean|has"):
        trochoid.recolor("water.recipe.exr", "x.png", set={"nobody": "#ff0000"})
    with pytest.raises(trochoid.CommandError) as raised:
        trochoid.palette("water.png", colors=1)
    assert raised.value.code == 3


def test_palettes_are_dictionaries_or_files(scene):
    trochoid.render("water.json", frames=1, out="water.png")
    inks = trochoid.palette("water.png", colors=4, out="inks.json")["palette"]
    of_file = trochoid.decompose("water.png", "inks.json", out="file.exr")
    assert trochoid.decompose("water.png", inks, out="inks.exr")[0]["farthest"] == of_file[0]["farthest"]
    red = dict.fromkeys(inks, "#800000")
    trochoid.recolor("inks.exr", "red.png", palette=red)
    assert list(trochoid.palette("red.png", colors=1)["palette"].values()) == ["#800000"]


def test_a_plan_is_found(scene):
    found = trochoid.plan("water.json", tolerance=1 / 64, out="water.plan.json")
    assert found["set"] == {} and json.loads((scene / "water.plan.json").read_text()) == found
    with pytest.raises(trochoid.CommandError, match="tolerance"):
        trochoid.plan("water.json")


def test_warnings_of_the_program_become_those_of_python(scene, caplog):
    document = json.loads((scene / "water.json").read_text())
    document["nodes"]["spare"] = {"type": "ScreenX"}
    (scene / "spare.json").write_text(json.dumps(document))
    with pytest.warns(UserWarning, match="spare") as warned:
        trochoid.render("spare.json", frames=1, out="spare.png")
    assert warned[0].filename == __file__
    with caplog.at_level(logging.INFO, logger="trochoid"):
        trochoid.render("water.json", frames=7, out="seven.png")
    assert any("7" in record.message for record in caplog.records)


def test_a_missing_folder_is_warned_of_in_each_run(scene):
    for _ in range(2):
        with pytest.warns(UserWarning, match="nowhere"):
            trochoid.render("water.json", frames=1, out="water.png", allow="nowhere")


def test_paths_that_look_like_options_are_paths(scene):
    (scene / "-f.json").write_text((scene / "water.json").read_text())
    frames = trochoid.render("-f.json", frames=1, out="-out.png")
    assert [file["path"] for file in frames[0]["files"]] == ["-out.png"]


def test_memory_is_limited_for_one_run(scene):
    (scene / "large.json").write_text(json.dumps(slow(6000)))
    with pytest.raises(trochoid.CommandError, match="memory") as raised:
        trochoid.run(["render", "large.json", "--memory", "64MB"])
    assert raised.value.code == 1
    assert trochoid.run(["check", "large.json", "--json"]).json()["valid"] is True


def test_a_false_answer_cancels_a_run(scene):
    (scene / "slow.json").write_text(json.dumps(slow(3000)))
    with pytest.raises(trochoid.Cancelled, match="no partial files"):
        trochoid.render("slow.json", progress=lambda done, total: False)
    assert sorted(path.name for path in scene.iterdir()) == ["slow.json", "water.json"]


def test_an_interrupt_stops_a_run(scene, interrupts):
    (scene / "slow.json").write_text(json.dumps(slow(6000)))
    interrupts(0.5)
    with pytest.raises(KeyboardInterrupt):
        trochoid.render("slow.json")
    assert sorted(path.name for path in scene.iterdir()) == ["slow.json", "water.json"]
    assert len(trochoid.render("water.json", frames=1, out="water.png")) == 1


def test_runs_wait_for_each_other(scene):
    results = []

    def work(number):
        for _ in range(5):
            frames = trochoid.render("water.json", frames=1, out=f"{number}.png")
            results.append(frames[0]["files"][0]["path"] == f"{number}.png")

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert results == [True] * 20
