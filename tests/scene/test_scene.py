"""Scenes as values: frames, attachments, who may touch whom, what the pairs are."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.scene.reducing import reduce_model


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    return to.Scene(odd_arm(tmp_path)).add("table", to.Box(1, 1, 0.1), to.placement((0.8, 0, -0.3)))


def pairs_of(scene: to.Scene) -> set[frozenset[str]]:
    reduced = reduce_model(scene, "all", scene.robot.positions())
    owners = [body.owner for body in reduced.bodies]
    return {
        frozenset((owners[a], owners[b]))
        for a, b in zip(reduced.pairs.first, reduced.pairs.second, strict=True)
    }


def test_an_edit_gives_a_new_scene(scene: to.Scene) -> None:
    other = scene.add("ball", to.Sphere(0.1))
    assert "ball" not in scene.objects and "ball" in other.objects
    assert "ball" not in other.remove("ball").objects
    moved = other.move("ball", to.placement((1, 2, 3)))
    assert other.object("ball").placement == to.placement()
    assert moved.object("ball").placement.translation == pytest.approx([1, 2, 3])


def test_frames_of_frames(scene: to.Scene) -> None:
    scene = scene.add("tray", to.Box(0.2, 0.2, 0.02), to.placement((0, 0, 0.06)), frame="table")
    scene = scene.add("glass", to.Cylinder(0.03, 0.1), to.placement((0.05, 0, 0.06)), frame="tray")
    where = scene.placement_of("glass", scene.robot.positions())
    assert where.translation == pytest.approx([0.85, 0.0, -0.18])
    moved = scene.move("table", to.placement((0.8, 0.5, -0.3)))
    assert moved.placement_of("glass", scene.robot.positions()).translation == pytest.approx(
        [0.85, 0.5, -0.18]
    )
    with pytest.raises(to.TrajoptError, match="glass"):
        scene.remove("tray")


def test_attach_keeps_the_place_and_detach_leaves_it(scene: to.Scene) -> None:
    at = scene.robot.positions({"pan": 0.4, "elbow": 0.7})
    later = scene.robot.positions({"pan": -1.0, "elbow": 0.2, "reach": 0.2})
    scene = scene.add("part", to.Sphere(0.03), to.placement((0.7, 0.2, 0.1), rpy=(0.1, 0.2, 0.3)))
    held = scene.attach("part", "tip", at=at)
    assert held.placement_of("part", at).homogeneous == pytest.approx(
        scene.object("part").placement.homogeneous
    )
    assert held.placement_of("part", later).translation != pytest.approx([0.7, 0.2, 0.1], abs=1e-2)
    left = held.detach("part", at=later)
    assert left.object("part").frame == "world"
    assert left.placement_of("part", at).homogeneous == pytest.approx(
        held.placement_of("part", later).homogeneous
    )


def test_pairs(scene: to.Scene) -> None:
    pairs = pairs_of(scene)
    assert frozenset(("tip", "table")) in pairs
    assert frozenset(("slide", "fore")) not in pairs, "adjacent links touch by construction"
    assert frozenset(("base", "table")) not in pairs, "neither moves"
    assert frozenset(("tip", "table")) not in pairs_of(scene.allow("tip", "table"))
    assert not any("table" in pair for pair in pairs_of(scene.allow("table")))


def test_attached_objects_of_a_scene(scene: to.Scene) -> None:
    scene = scene.add("part", to.Sphere(0.03), frame="tip", touch_links=["tip"])
    pairs = pairs_of(scene)
    assert frozenset(("part", "table")) in pairs
    assert frozenset(("part", "fore")) in pairs
    assert frozenset(("part", "tip")) not in pairs
    scene = scene.add("other", to.Sphere(0.03), to.placement((0.1, 0, 0)), frame="fore", touch_links=["fore"])
    assert frozenset(("part", "other")) in pairs_of(scene), "attached against attached"
    assert frozenset(("part", "other")) not in pairs_of(scene.allow("part", "other"))


def test_margins(scene: to.Scene) -> None:
    scene = scene.with_margin(0.02).with_margin(0.003, "tip", "table")
    reduced = reduce_model(scene, "all", scene.robot.positions())
    owners = [body.owner for body in reduced.bodies]
    for a, b, margin in zip(reduced.pairs.first, reduced.pairs.second, reduced.pairs.margin, strict=True):
        assert margin == (0.003 if {owners[a], owners[b]} == {"tip", "table"} else 0.02)


def test_joints_outside_the_group_stand_where_the_start_has_them(scene: to.Scene) -> None:
    robot = scene.robot
    start = np.array(robot.positions({"reach": 0.2}))
    start[robot.index(["follow"])[0]] = 3.0
    reduced = reduce_model(scene, "all", start)
    assert reduced.joint_names == ("pan", "reach", "elbow", "wrist")
    assert "follow" in list(reduced.model.names), "what follows a joint of the group moves with it"


@pytest.mark.parametrize("exact", [False, True])
def test_names_an_object_whose_mesh_has_no_area(scene: to.Scene, exact: bool) -> None:
    line = to.Mesh(np.array(((0.0, 0, 0), (1, 0, 0), (2, 0, 0))), [(0, 1, 2)])
    with pytest.raises(to.errors.ShapeError, match="mesh of 'wire': has no face with an area"):
        scene.add("wire", line, meshes=to.MeshPolicy(exact=exact))
