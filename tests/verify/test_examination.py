"""One configuration: what touches, and which joints are out of their limits."""

from pathlib import Path

import numpy as np
import pytest

from tests.verify.arms import planar_arm, reduced
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Sphere, convex
from trajopt.verify import Judge, examine


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    scene = Scene(planar_arm(tmp_path)).add("ball", Sphere(0.1), placement((1.2, 0.0, 0.0)))
    scene = scene.add("wall", Box(2.0, 0.1, 1.0), placement((0.0, 0.57, 0.0)))
    return reduced(scene, [0.0, 0.0])


def test_a_clear_configuration(model: ReducedModel) -> None:
    found = examine(model, np.zeros(2))
    assert found.clear
    assert found.smallest is not None
    assert (found.smallest.first, found.smallest.second) == ("lower", "ball")
    assert found.smallest.distance == pytest.approx(0.1, abs=2e-6)


def test_collisions_come_deepest_first_one_for_each_pair(model: ReducedModel) -> None:
    found = examine(model, np.array((np.pi / 2, 0.0)))
    assert [(pair.first, pair.second) for pair in found.collisions] == [("lower", "wall")]
    assert found.collisions[0].distance < -0.05
    assert found.smallest == found.collisions[0]
    assert not found.clear


def test_joints_out_of_limits(model: ReducedModel) -> None:
    found = examine(model, np.array((-3.2, 3.5)))
    assert [(out.joint, out.excess) for out in found.out_of_limits] == [
        ("elbow", pytest.approx(0.5)),
        ("shoulder", pytest.approx(0.2)),
    ]
    assert found.out_of_limits[1].lower == -3.0
    assert examine(model, np.array((3.0 + 1e-9, 0.0))).out_of_limits == ()


def test_positions_are_checked(model: ReducedModel) -> None:
    with pytest.raises(ShapeError, match="positions"):
        examine(model, np.zeros(3))
    with pytest.raises(ShapeError, match="finite"):
        Judge(model).examine(np.array((0.0, np.nan)))


def test_inside_an_exact_mesh(tmp_path: Path) -> None:
    corners = convex([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    scene = Scene(planar_arm(tmp_path)).add(
        "shell", Mesh(corners.vertices * 3.0, corners.faces), meshes=MeshPolicy(exact=True)
    )
    found = examine(reduced(scene, [0.0, 0.0]), np.zeros(2))
    assert {pair.first for pair in found.collisions} == {"upper", "lower"}


def test_a_robot_alone(tmp_path: Path) -> None:
    found = examine(reduced(Scene(planar_arm(tmp_path)), [0.0, 0.0]), np.zeros(2))
    assert found.clear
    assert found.smallest is None


def test_a_list_is_no_reduced_model() -> None:
    with pytest.raises(ProblemError, match=r"reduced \(as problem\.reduced\) must be"):
        Judge([])  # pyright: ignore[reportArgumentType]
