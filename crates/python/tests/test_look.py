"""Looks over numpy arrays."""

import copy
import json
import os
import pickle
import threading
from fractions import Fraction

import numpy as np
import pytest
import trochoid
from conftest import EXAMPLES, INPUTS, MIST, POINTS, WATER, known, passes


def test_results_are_those_of_c(look):
    light, rim = passes()
    rgb = look.shade({"light": light, "rim": rim, "palette.mist": MIST})
    assert rgb.dtype == np.float32 and rgb.shape == (POINTS, 3)
    assert rgb.tobytes() == known().tobytes()


def test_slots_are_described(look):
    assert [(slot.name, slot.kind, slot.channels, slot.is_used) for slot in look.slots] == [
        ("light", "mask", 1, True),
        ("rim", "mask", 1, True),
        ("palette.mist", "color", 3, True),
    ]
    assert (look.output, look.kind, look.channels, look.frame) == ("beauty", "color", 3, 1)
    assert repr(look) == 'Look(output="beauty", inputs=["light", "rim", "palette.mist"])'


def test_any_strides_are_read_where_they_are(look):
    light, rim = passes(20, 30)
    image = np.zeros((20, 30, 5), np.float32)
    image[..., 1], image[..., 4] = light, rim
    for view in [image, image[::-1], image[:, ::-1], image[::2, 3:], image.transpose(1, 0, 2)]:
        rgb = look.shade({"light": view[..., 1], "rim": view[..., 4], "palette.mist": MIST})
        one_by_one = [
            look.shade({"light": float(a), "rim": float(b), "palette.mist": MIST})
            for a, b in zip(view[..., 1].ravel(), view[..., 4].ravel())
        ]
        assert rgb.shape == view.shape[:2] + (3,)
        np.testing.assert_array_equal(rgb.reshape(-1, 3), np.array(one_by_one))
    rgb = look.shade({"light": image[..., 1], "rim": image[..., 4], "palette.mist": MIST})
    assert rgb.tobytes() == known().tobytes()


def test_records_that_are_not_aligned_are_read(look):
    records = np.zeros(POINTS, dtype=[("tag", "u1"), ("light", "f4"), ("rim", "f4")])
    records["light"], records["rim"] = passes()
    rgb = look.shade({"light": records["light"], "rim": records["rim"], "palette.mist": MIST})
    assert rgb.tobytes() == known().tobytes()


def test_inputs_are_extended_to_a_common_shape(look):
    light, rim = np.linspace(0, 1, 7, dtype=np.float32), np.linspace(0, 1, 5, dtype=np.float32)
    mist = np.linspace(0, 1, 15, dtype=np.float32).reshape(5, 1, 3)
    rgb = look.shade({"light": light, "rim": rim[:, None], "palette.mist": mist})
    assert rgb.shape == (5, 7, 3)
    for y in range(5):
        for x in range(7):
            one = look.shade({"light": light[x], "rim": rim[y], "palette.mist": tuple(mist[y, 0])})
            np.testing.assert_array_equal(rgb[y, x], one)
    with pytest.raises(ValueError, match="rim"):
        look.shade({"light": light, "rim": rim, "palette.mist": MIST})
    with pytest.raises(ValueError, match="3 channels along its last axis"):
        look.shade({"light": light, "rim": 0.5, "palette.mist": light})
    assert look.shade({"light": light[:0], "rim": 0.5, "palette.mist": MIST}).shape == (0, 3)


def test_results_go_where_they_are_wanted(look):
    light, rim = passes()
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    rgba = np.full((POINTS, 4), -1, np.float32)
    out = rgba[:, :3]
    assert look.shade(inputs, out=out) is out
    assert out.tobytes() == known().tobytes() and (rgba[:, 3] == -1).all()
    with pytest.raises(ValueError, match="expected \\[600, 3\\]"):
        look.shade(inputs, out=rgba)
    with pytest.raises(TypeError, match="an array of float64; expected an array of float32"):
        look.shade(inputs, out=np.zeros((POINTS, 3)))
    out = np.zeros((POINTS, 3), np.float32)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        look.shade(inputs, out=out)


def test_results_may_lie_where_inputs_are(look):
    light, rim = passes()
    mixed = np.stack([light, rim, np.zeros_like(light)], axis=1)
    look.shade({"light": mixed[:, 0], "rim": mixed[:, 1], "palette.mist": MIST}, out=mixed)
    assert mixed.tobytes() == known().tobytes()
    # In another order, or shifted: as if the inputs had been copied.
    nodes = {"a": {"type": "ScreenX"}, "b": {"type": "Invert", "weight": "a"}}
    mask = trochoid.Look({"trochoid": 1, "nodes": nodes, "outputs": {"b": {"weights": "b"}}}, inputs=["a"])
    start = np.linspace(0, 1, 5000, dtype=np.float32)
    for views in [
        lambda a: (a[:-1], a[1:]),
        lambda a: (a[1:], a[:-1]),
        lambda a: (a, a[::-1]),
        lambda a: (a.reshape(50, 100), a.reshape(100, 50).T),
        lambda a: (a[2500], a[:4000]),
        lambda a: (a[::2], a[:2500]),
    ]:
        expected = mask.shade({"a": views(start.copy())[0].copy()}) * np.ones(views(start)[1].shape, np.float32)
        given, out = views(start.copy())
        if given.ndim == 0 or given.shape != out.shape:
            given = np.broadcast_to(given, out.shape)
        mask.shade({"a": given}, out=out)
        np.testing.assert_array_equal(out, expected)


def test_other_numbers_are_converted(look):
    light, rim = passes()
    swapped = rim.astype(">f4")
    for inputs in [
        {"light": light.astype(np.float64), "rim": list(map(float, rim)), "palette.mist": np.array(MIST)},
        {"light": light, "rim": swapped, "palette.mist": list(MIST)},
    ]:
        np.testing.assert_array_equal(look.shade(inputs), known())
    one = look.shade({"light": 1, "rim": np.float32(0), "palette.mist": (0, 0, 0)})
    np.testing.assert_array_equal(one, known()[-1] * 0 + look.shade({"light": 1.0, "rim": 0.0, "palette.mist": MIST}))
    with pytest.raises(TypeError, match="light"):
        look.shade({"light": "bright", "rim": 0, "palette.mist": MIST})
    with pytest.raises(TypeError, match="dictionary"):
        look.shade(5)


def test_illegal_samples_are_named_or_clamped(look):
    light, rim = passes(20, 30)
    light = light.copy()
    light[7, 11] = 1.5
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    with pytest.raises(trochoid.IllegalSample, match="found 1.5") as raised:
        look.shade(inputs)
    assert (raised.value.name, raised.value.slot, raised.value.sample) == ("light", 0, 7 * 30 + 11)
    # Every second column: runs of one row each.
    with pytest.raises(trochoid.IllegalSample, match=f"sample {7 * 15 + 5} ") as raised:
        look.shade({"light": light[:, 1::2], "rim": rim[:, 1::2], "palette.mist": MIST})
    assert raised.value.sample == 7 * 15 + 5
    # Far behind the first piece that is shaded at once.
    far = np.zeros(300_000, np.float32)
    far[250_000] = np.nan
    with pytest.raises(trochoid.IllegalSample) as raised:
        look.shade({"light": 0.5, "rim": far, "palette.mist": MIST})
    assert (raised.value.name, raised.value.slot, raised.value.sample) == ("rim", 1, 250_000)
    # The shader is as good as before.
    look.shade({**inputs, "light": rim})
    patient = trochoid.Look(WATER, inputs=INPUTS, illegal="clamp")
    np.testing.assert_array_equal(patient.shade(inputs), look.shade({**inputs, "light": light.clip(0, 1)}))
    with pytest.raises(trochoid.IllegalSample) as raised:
        look.picture(inputs)
    assert (raised.value.name, raised.value.slot, raised.value.sample) == ("light", 0, 7 * 30 + 11)
    assert patient.picture(inputs).audit.nan_count == 0
    with pytest.raises(ValueError, match="refuse"):
        trochoid.Look(WATER, illegal="ignore")


def test_wrong_names_are_told(look):
    with pytest.raises(ValueError, match='did you mean "light"'):
        look.shade({"lihgt": 0.5, "rim": 0.5, "palette.mist": MIST})
    with pytest.raises(ValueError, match='no "rim"'):
        look.shade({"light": 0.5, "palette.mist": MIST})


def test_files_that_are_not_read_raise_what_open_raises(tmp_path):
    for path in ["no such file.json", tmp_path]:
        with pytest.raises(OSError) as known:
            open(path)
        with pytest.raises(type(known.value), match="found a folder|cannot open the file") as raised:
            trochoid.Look.load(path)
        assert (raised.value.errno, raised.value.filename) == (known.value.errno, str(path))
        assert "os error" not in str(raised.value) and str(raised.value).count(str(path)) == 1
    with pytest.raises(ValueError, match="Look.load\\('water.json'\\) reads a file"):
        trochoid.Look("water.json")
    with pytest.raises(TypeError, match="Look.load reads a file"):
        trochoid.Look(tmp_path / "water.json")


def test_one_name_is_no_list():
    with pytest.raises(TypeError, match="found 'light'; expected a list, such as .*\n.*'inputs'"):
        trochoid.Look(WATER, inputs="light")
    with pytest.raises(TypeError, match="found '.'; expected a list, such as .*\n.*'allow'"):
        trochoid.Look.load(EXAMPLES / "water.json", allow=".")


def test_none_is_no_pass(look):
    for none in [None, [None, 0.5]]:
        with pytest.raises(TypeError, match='"rim": found None.*; expected samples of it'):
            look.shade({"light": 0.5, "rim": none, "palette.mist": MIST})
    half = look.shade({"light": 0.5, "rim": [Fraction(1, 2)], "palette.mist": MIST})
    np.testing.assert_array_equal(half, look.shade({"light": 0.5, "rim": [0.5], "palette.mist": MIST}))
    fields = {"a": {"type": "Noise"}, "b": {"type": "FieldMath", "a": "a", "expression": "a"}}
    field = trochoid.Look({"trochoid": 1, "nodes": fields, "outputs": {"b": {"field": "b"}}}, inputs=["a"])
    # NaN is legal in a field, so nothing else would tell.
    with pytest.raises(TypeError, match='"a": found None'):
        field.shade({"a": None})


def test_a_look_says_that_it_cannot_be_pickled(look):
    for copied in [pickle.dumps, copy.copy]:
        with pytest.raises(TypeError, match="make it anew in each process"):
            copied(look)


def test_a_fault_is_told_once():
    document = json.loads(WATER)
    document["knobs"] = {"storm": {"value": 0.5, "min": 0, "max": 1}}
    document["nodes"]["beauty"]["weight"] = "= knobs.storm"
    with pytest.raises(trochoid.InvalidDocument, match="from 0 to 1") as raised:
        trochoid.Look(document, set={"knobs.storm": 5})
    assert len(raised.value.diagnostics) == 1 and str(raised.value).count("found") == 1


def test_faults_of_documents_are_listed():
    faulty = WATER.replace('"weight": "light"', '"weight": "lihgt"')
    with pytest.raises(trochoid.InvalidDocument, match="did you mean") as raised:
        trochoid.Look(faulty)
    fault = raised.value.diagnostics[0]
    assert fault["node"] == "water" and fault["line"] > 1
    assert isinstance(raised.value, trochoid.Error)
    with pytest.raises(trochoid.InvalidDocument, match="mine.json"):
        trochoid.Look(faulty, name="mine.json")
    with pytest.raises(TypeError, match="expected the text of a document"):
        trochoid.Look(5)


def test_faults_of_looks_are_listed():
    with pytest.raises(trochoid.InvalidLook, match="did you mean") as raised:
        trochoid.Look(WATER, inputs=["light", "palette.foan", "lihgt"], output="beuaty")
    places = [(fault["port"], fault["line"], fault["remedy"]) for fault in raised.value.diagnostics]
    assert places == [
        ("output", 0, 'did you mean "beauty"?'),
        ("inputs[1]", 0, 'did you mean "palette.foam"?'),
        ("inputs[2]", 0, 'did you mean "light"?'),
    ]
    assert isinstance(raised.value, trochoid.Error)
    with pytest.raises(trochoid.InvalidLook, match="inputs\\[1\\]: found \"light\", which is inputs\\[0\\] already"):
        trochoid.Look(WATER, inputs=["light", "light"])
    with pytest.raises(trochoid.InvalidLook, match="leave one of them out"):
        trochoid.Look(WATER, inputs=["palette.foam"], set={"palette.foam": "#fff"})


def test_nodes_in_the_way_are_listed():
    nodes = {
        "noise": {"type": "Noise"},
        "rim": {"type": "ScreenY"},
        "soft": {"type": "Blur", "image": "rim", "size": 3},
        "water": {"type": "Mix", "a": "#000", "b": "#fff", "weight": "both"},
        "both": {"type": "Multiply", "weights": ["soft", "shore"]},
        "shore": {"type": "Clamp", "field": "noise"},
    }
    document = {"trochoid": 1, "nodes": nodes, "outputs": {"beauty": {"color": "water"}}}
    with pytest.raises(trochoid.NotPointwise, match="a Blur") as raised:
        trochoid.Look(document).shade({})
    assert [fault["node"] for fault in raised.value.diagnostics] == ["noise", "soft"]
    trochoid.Look(document, inputs=["noise", "soft"]).shade({"noise": 0, "soft": 0.5})
    assert trochoid.Look(document).picture(size=(8, 8)).audit.judged == 64


def test_recipes_are_no_looks():
    document = {**json.loads(WATER), "outputs": {"parts": {"recipe": "beauty"}}}
    with pytest.raises(trochoid.InvalidLook, match="found the recipe of"):
        trochoid.Look(document)


def test_files_are_read_as_far_as_they_are_allowed(tmp_path):
    document = json.loads(WATER)
    own, other = tmp_path / "own", tmp_path / "other"
    own.mkdir()
    other.mkdir()
    (other / "colors.json").write_text(json.dumps(document["palette"]))
    document["palette"] = "../other/colors.json"
    with pytest.raises(trochoid.InvalidDocument, match="allow it if you trust the document"):
        trochoid.Look(document, folder=own)
    (own / "water.json").write_text(json.dumps(document))
    for look in [
        trochoid.Look(document, folder=own, inputs=INPUTS[:2], allow=[other]),
        trochoid.Look.load(own / "water.json", inputs=INPUTS[:2], allow=[str(other / "colors.json")]),
    ]:
        expected = trochoid.Look(WATER, inputs=INPUTS[:2]).shade({"light": 0.3, "rim": 0.5})
        np.testing.assert_array_equal(look.shade({"light": 0.3, "rim": 0.5}), expected)


def test_values_are_set(look):
    light, rim = passes()
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    misty = look.replace(set={"beauty.weight": 1})
    np.testing.assert_array_equal(misty.shade({"palette.mist": MIST}), np.array(MIST, np.float32))
    assert look.shade(inputs).tobytes() == known().tobytes()
    red = trochoid.Look(WATER, inputs=["light"], set={"palette.deep": "#ff0000", "beauty.weight": 0})
    np.testing.assert_array_equal(red.shade({"light": 0.0}), [1, 0, 0])


def test_numbers_of_numpy_are_taken():
    assert trochoid.Look(WATER, inputs=["light"], set={"beauty.weight": np.float32(0)})
    colors = {"palette.deep": np.array([1, 0, 0]), "beauty.weight": np.int64(0)}
    red = trochoid.Look(WATER, inputs=["light"], set=colors)
    np.testing.assert_array_equal(red.shade({"light": np.float64(0)}), [1, 0, 0])
    with pytest.raises(TypeError, match="found object"):
        trochoid.Look(WATER, set={"beauty.weight": object()})


def test_results_that_memory_cannot_hold_are_refused(look):
    across, down = np.zeros((1, 10**7), np.float32), np.zeros((10**7, 1), np.float32)
    with pytest.raises(MemoryError):
        look.shade({"light": across, "rim": down, "palette.mist": MIST})


def test_a_look_keeps_its_frame():
    keyed = {
        "trochoid": 1,
        "frames": {"first": 1, "last": 11},
        "nodes": {"a": {"type": "ScreenX"}, "m": {"type": "Multiply", "weights": ["a", {"keys": [[1, 0], [11, 1]]}]}},
        "outputs": {"m": {"weights": "m"}},
    }
    look = trochoid.Look(keyed, inputs=["a"], frame=11)
    assert look.shade({"a": 0.5}) == 0.5 and look.replace().frame == 11
    assert look.replace(frame=1).shade({"a": 0.5}) == 0
    assert look.shade({"a": np.full((2, 3), 0.5, np.float32)}).shape == (2, 3)


def test_other_threads_run_meanwhile(look):
    """A thread counts while another one shades a batch that takes long, which it could not if Python was locked."""
    light = np.full(30_000_000, 0.5, np.float32)
    counts, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    before = counts[0]
    look.shade({"light": light, "rim": 0.5, "palette.mist": MIST})
    during = counts[0] - before
    stop.set()
    counter.join()
    assert during > 1000


def test_threads_share_a_look(look):
    light, rim = passes()
    results = []

    def work():
        for _ in range(200):
            results.append(look.shade({"light": light, "rim": rim, "palette.mist": MIST}).tobytes())

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert set(results) == {known().tobytes()} and len(results) == 800


def test_an_interrupt_stops_a_long_batch(interrupts):
    nodes = {"a": {"type": "ScreenX"}}
    for number in range(60):
        before = f"c{number - 1}" if number else "a"
        nodes[f"c{number}"] = {"type": "Clamp", "field": before, "min": 0.1, "max": 0.9, "smooth": True}
    look = trochoid.Look({"trochoid": 1, "nodes": nodes, "outputs": {"m": {"weights": "c59"}}}, inputs=["a"])
    samples = np.full(40_000_000, 0.3, np.float32)
    interrupts(0.1)
    with pytest.raises(KeyboardInterrupt):
        look.shade({"a": samples}, out=samples)
    # The last samples were not reached.
    assert samples[-1] == np.float32(0.3) and samples[0] != np.float32(0.3)


def resident():
    """Memory that the process has, in bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="the system does not tell the memory of a process")
def test_calls_leak_nothing(look):
    light, rim = (values[:16].copy() for values in passes())
    out = np.zeros((16, 3), np.float32)
    inputs = {"light": light, "rim": rim, "palette.mist": MIST}
    illegal = {**inputs, "light": 2.0}

    def calls(count):
        for _ in range(count):
            look.shade(inputs, out=out)
            look.shade({**inputs, "rim": [0.5] * 16})
            try:
                look.shade(illegal)
            except trochoid.IllegalSample:
                pass
        for _ in range(count // 1000):
            look.replace(frame=2).shade(inputs)
            look.picture({**inputs, "light": light.reshape(4, 4), "rim": rim.reshape(4, 4)}).png()

    calls(2000)
    before = resident()
    calls(30_000)
    # One number a call would be 700 KB.
    assert resident() - before < 512 * 1024, f"{resident() - before} bytes more"
