"""Objects put up by hand: where, how large, carried and put down; and scenes kept in files."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.moveit import read_scene, write_scene
from trajopt.values.errors import ModelError
from trajopt.viewer.live import objects
from trajopt.viewer.live.objects import ObjectKind
from trajopt.viewer.live.workbench import Workbench


@pytest.fixture
def bench() -> Workbench:
    scene = to.Scene(to.load("panda"))
    return Workbench(scene.add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02))))


def added(bench: Workbench, kind: ObjectKind) -> str:
    scene, name = objects.added(bench.reduced, kind)
    bench.change(scene)
    return name


def test_an_added_object_touches_nothing_and_is_on_the_ground(bench: Workbench) -> None:
    kinds = (ObjectKind.BOX, ObjectKind.BOX, ObjectKind.CYLINDER, ObjectKind.SPHERE)
    names = [added(bench, kind) for kind in kinds]
    assert names == ["box", "box 2", "cylinder", "sphere"]
    assert to.examine(bench.reduced, bench.positions).collisions == ()
    for name, low in zip(names, (0.05, 0.05, 0.1, 0.05), strict=True):
        assert bench.placement_of(name).translation[2] == pytest.approx(low)
    places = [bench.placement_of(name).translation for name in names]
    apart = [np.linalg.norm(a - b) for count, a in enumerate(places) for b in places[:count]]
    assert min(apart) > 0.1


@pytest.mark.parametrize("kind", list(ObjectKind))
def test_resizing_keeps_allowed_contacts(bench: Workbench, kind: ObjectKind) -> None:
    name = added(bench, kind)
    bench.change(bench.scene.allow(name, "table"))
    sizes = objects.sizes_of(bench.scene, name)
    assert set(sizes) <= {"x", "y", "z", "radius", "length"}
    larger = {key: 1.5 * value for key, value in sizes.items()}
    scene = objects.resized(bench.scene, name, larger)
    assert objects.sizes_of(scene, name) == pytest.approx(larger)
    assert scene.may_touch(name, "table") and list(scene.objects) == list(bench.scene.objects)
    none = objects.resized(scene, name, dict.fromkeys(sizes, 0.0))
    assert min(objects.sizes_of(none, name).values()) > 0.0


def test_a_shape_without_sizes_cannot_be_resized(bench: Workbench) -> None:
    hull = to.convex(np.random.default_rng(0).uniform(-0.1, 0.1, (20, 3)))
    scene = bench.scene.add("stone", hull, to.placement((0.0, 0.9, 0.1)))
    assert objects.sizes_of(scene, "stone") == {}
    with pytest.raises(ModelError, match="stone"):
        objects.resized(scene, "stone", {"x": 1.0})


def test_an_object_is_grasped_carried_and_put_down(bench: Workbench) -> None:
    name = added(bench, ObjectKind.BOX)
    bench.change(objects.resized(bench.scene, name, {"x": 0.03, "y": 0.03, "z": 0.06}))
    bench.change(objects.moved(bench.scene, name, bench.placement_of(bench.hand)))
    bench.change(objects.grasped(bench.reduced, name, bench.hand))
    assert objects.is_carried(bench.scene, name)
    assert to.examine(bench.reduced, bench.positions).collisions == ()
    with pytest.raises(ModelError, match="carries"):
        objects.moved(bench.scene, name, to.placement((0.0, 0.0, 1.0)))
    bench.stand(bench.positions + np.array((0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    np.testing.assert_allclose(
        bench.placement_of(name).translation, bench.placement_of(bench.hand).translation, atol=1e-9
    )
    bench.change(objects.put_down(bench.reduced, name))
    assert not objects.is_carried(bench.scene, name)
    there = bench.placement_of(name).translation
    bench.stand(bench.positions - np.array((0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    np.testing.assert_allclose(bench.placement_of(name).translation, there, atol=1e-9)


@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_a_scene_is_read_as_it_was_written(bench: Workbench, tmp_path: Path, suffix: str) -> None:
    names = [added(bench, kind) for kind in ObjectKind]
    bench.change(objects.grasped(bench.reduced, names[0], bench.hand))
    bench.change(
        bench.scene.allow(names[1], "table").with_tool(
            "pen", on="panda_hand", placement=to.placement((0, 0, 0.2))
        )
    )
    file = tmp_path / f"scene.{suffix}"
    write_scene(file, bench.scene, bench.reduced.start)
    read = read_scene(file, bench.scene.robot)
    np.testing.assert_allclose(read.positions, bench.reduced.start, atol=1e-12)
    assert set(read.scene.objects) == set(bench.scene.objects)
    for name, item in bench.scene.objects.items():
        other = read.scene.object(name)
        at, there = (each.placement_of(name, bench.reduced.start) for each in (bench.scene, read.scene))
        np.testing.assert_allclose(at.homogeneous, there.homogeneous, atol=1e-9)
        assert [type(shape) for shape, _ in other.parts] == [type(shape) for shape, _ in item.parts]
        assert objects.sizes_of(read.scene, name) == pytest.approx(objects.sizes_of(bench.scene, name))
    assert objects.is_carried(read.scene, names[0]) and read.scene.may_touch(names[1], "table")
    assert "pen" in read.scene.tools
