"""Tests of the still life: `pytest integrations/mitsuba`, with mitsuba and the package trochoid installed."""

import json

import mitsuba as mi
import numpy as np
import pytest
import still_life
import trochoid

mi.set_variant(still_life.VARIANT)
SIZE = (still_life.WIDTH // 12, still_life.HEIGHT // 12)


@pytest.fixture(scope="module")
def rendered():
    return still_life.passes(*SIZE)


@pytest.fixture(scope="module")
def scene():
    return still_life.scene(*SIZE, 1, {"type": "direct"}, {"type": "constant"})


def test_misses_are_covered_by_nothing(rendered):
    passes, things = rendered
    np.testing.assert_allclose(sum(things.values()), passes["coverage"], atol=1e-6)
    assert ((passes["coverage"] == 0) == np.isinf(passes["depth"])).all()
    # The sky above the table, and no speck of it below.
    assert (passes["coverage"][: SIZE[1] // 10] == 0).all() and (passes["coverage"][-SIZE[1] // 3 :] == 1).all()


def test_masks_are_of_the_things_that_rays_meet(rendered, scene):
    _, things = rendered
    sensor = scene.sensors()[0]
    for name, share in things.items():
        whole = np.argwhere(share == 1)
        assert len(whole) > 0 or name == "stalk"
        for y, x in whole[:: max(len(whole) // 50, 1)]:
            middle = mi.ScalarPoint2f((x + 0.5) / SIZE[0], (y + 0.5) / SIZE[1])
            ray, _ = sensor.sample_ray(0, 0.5, middle, mi.ScalarPoint2f(0.5))
            assert scene.ray_intersect(ray).shape.id().split("_")[0] == name, f"{name} at {x}, {y}"


def test_masks_are_the_shares_of_finer_rasters(rendered):
    _, things = rendered
    _, finer = still_life.passes(*SIZE, fine=6, rays=1)
    for name, share in things.items():
        # Where the finer raster meets one thing only, so does the coarse one, up to what its four rays miss.
        differs = np.abs(share - finer[name])
        assert differs.mean() < 0.01, name
        assert (differs[(finer[name] == 1) | (finer[name] == 0)] > 0.26).mean() < 0.001, name


def test_depth_is_the_distance_of_the_position(rendered, scene):
    passes, _ = rendered
    camera = np.array(scene.sensors()[0].world_transform().translation()).ravel()
    seen = np.isfinite(passes["depth"])
    distance = np.linalg.norm(passes["position"] - camera, axis=-1)
    off = np.abs(passes["depth"] / distance - 1)[seen]
    assert seen.sum() > 1000 and off.max() < 1e-4
    np.testing.assert_allclose(np.linalg.norm(passes["normal"][seen], axis=-1), 1, atol=1e-4)


def test_light_is_cosine_or_shadow(rendered):
    passes, things = rendered
    table = things["table"] == 1
    sun = np.array(still_life.SUN)
    cosine = -sun[1] / np.linalg.norm(sun)
    lit = passes["sun"][table]
    # Most of the table is in full light or in full shadow; the rest are edges of shadows.
    assert ((np.abs(lit - cosine) < 1e-3) | (lit < 1e-6)).mean() > 0.9
    assert (lit < 1e-6).any() and 0.5 < passes["sky"][table].mean() < 1


def test_the_picture_stays_on_its_palette(rendered):
    passes, things = rendered
    nodes = json.loads(still_life.GRAPH.read_text())["nodes"]
    inputs = {name: values for name, values in {**passes, **things}.items() if name in nodes}
    look = trochoid.Look.load(still_life.GRAPH, inputs=list(inputs), illegal="clamp")
    assert all(slot.is_used for slot in look.slots)
    picture = look.picture(inputs)
    assert (picture.audit.hull_exits, picture.audit.nan_count) == (0, 0)
    # Without the pear, its place shows what else is there.
    without = look.picture({**inputs, "pear": np.zeros_like(inputs["pear"])})
    changed = (picture.numpy() != without.numpy()).any(axis=-1)
    reach = 14 * SIZE[0] // still_life.WIDTH + 12
    rows, columns = np.nonzero(things["pear"])
    y, x = np.nonzero(changed)
    assert changed.sum() > 100
    assert rows.min() - reach <= y.min() and y.max() <= rows.max() + reach
    assert columns.min() - reach <= x.min() and x.max() <= columns.max() + reach
