"""The bound on what gravity asks of each joint: above every sample, near the largest, loads included."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.verify.arms import mixed_arm, planar_arm
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.scene.bounds import largest_gravity_slopes, largest_gravity_torques
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats


def drawn(reduced: ReducedModel, count: int, rng: np.random.Generator) -> Floats:
    limits = reduced.limits
    return rng.uniform(
        np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi), (count, len(limits.lower))
    )


def loaded(robot: to.Robot, frame: str, group: str) -> ReducedModel:
    scene = to.Scene(robot).add(
        "load", to.Sphere(0.02), to.placement((0.1, 0.02, 0.2)), frame=frame, mass=3.0
    )
    return reduce_model(scene, group, robot.positions())


@pytest.mark.parametrize("kind", ["odd", "mixed", "panda", "ur5"])
def test_no_sample_is_above_the_bound(tmp_path: Path, kind: str) -> None:
    models = {
        "odd": lambda: loaded(odd_arm(tmp_path), "tip", "all"),
        "mixed": lambda: loaded(mixed_arm(tmp_path), "finger", "all"),
        "panda": lambda: loaded(to.load("panda"), "panda_hand", "panda_arm"),
        "ur5": lambda: loaded(to.load("ur5"), "tool0", "manipulator"),
    }
    reduced, rng = models[kind](), np.random.default_rng(7)
    found = DynamicsQuery.loaded(reduced).gravity(drawn(reduced, 4000, rng))
    spare = largest_gravity_torques(reduced) - np.abs(found.torque).max(axis=0)
    assert (spare >= -1e-9).all()
    spare = largest_gravity_slopes(reduced) - np.abs(found.position).max(axis=0)
    assert (spare >= -1e-9).all()


@pytest.mark.parametrize("seed", range(20))
def test_random_trees_keep_the_bound(tmp_path: Path, seed: int) -> None:
    """Joints of every kind about random axes, branching, some mimicking others."""
    rng = np.random.default_rng(seed)
    parts = ['<link name="l0"/>']
    count = int(rng.integers(2, 7))
    for number in range(1, count + 1):
        parent, kind = int(rng.integers(number)), rng.choice(["revolute", "continuous", "prismatic"])
        x, y, z, *inertial = rng.uniform(-0.5, 0.5, 6)
        axis, turned = rng.normal(size=3), rng.uniform(-3.0, 3.0, 3)
        mimic = ""
        if number > 2 and rng.random() < 0.3:
            kind, mimic = "revolute", f'<mimic joint="j1" multiplier="{rng.uniform(-1, 1)}" offset="0.2"/>'
        parts.append(
            f'<link name="l{number}"><inertial><origin xyz="{" ".join(map(str, inertial))}"/>'
            f'<mass value="{rng.uniform(0.0, 3.0)}"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" '
            f'ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{number}" type="{kind}"><parent link="l{parent}"/>'
            f'<child link="l{number}"/><origin xyz="{x} {y} {z}" rpy="{" ".join(map(str, turned))}"/>'
            f'<axis xyz="{" ".join(map(str, axis))}"/>{mimic}'
            '<limit lower="-1.5" upper="2.0" velocity="1" effort="9"/></joint>'
        )
    path = tmp_path / "tree.urdf"
    path.write_text(f'<robot name="tree">{"".join(parts)}</robot>')
    robot = to.Robot.from_urdf(path)
    reduced = reduce_model(to.Scene(robot), "all", robot.positions())
    found = DynamicsQuery.loaded(reduced).gravity(drawn(reduced, 2000, rng))
    assert (np.abs(found.torque).max(axis=0) <= largest_gravity_torques(reduced) + 1e-9).all()
    assert (np.abs(found.position).max(axis=0) <= largest_gravity_slopes(reduced) + 1e-9).all()


def test_the_bound_equals_the_torque_of_a_stretched_arm(tmp_path: Path) -> None:
    """Two rods of 1 kg and 0.5 m in the plane of gravity, 10 g at their end, and a load of 3 kg there."""
    arm = planar_arm(tmp_path, axis="0 -1 0")
    for mass in (0.0, 3.0):
        scene = to.Scene(arm).add("load", to.Sphere(0.01), frame="tip", mass=mass)
        reduced = reduce_model(scene, "all", arm.positions())
        expected = 9.81 * np.array((0.25 + 0.75 + 0.01 + mass, 0.25 + (0.01 + mass) * 0.5))
        assert largest_gravity_torques(reduced) == pytest.approx(expected, rel=1e-12)


def test_joints_about_the_vertical_need_nothing(tmp_path: Path) -> None:
    arm = planar_arm(tmp_path)
    reduced = reduce_model(to.Scene(arm), "all", arm.positions())
    assert largest_gravity_torques(reduced) == pytest.approx(np.zeros(2), abs=1e-12)


@pytest.mark.parametrize(
    ("robot", "group"), [("panda", "panda_arm"), ("ur5", "manipulator"), ("xarm7", "xarm7")]
)
def test_the_bound_is_near_the_largest_sample(robot: str, group: str) -> None:
    """Of joints that bear much; their limits are what it does not know."""
    arm = to.load(robot)
    reduced = reduce_model(to.Scene(arm), group, arm.positions())
    largest = np.abs(
        DynamicsQuery.loaded(reduced).gravity(drawn(reduced, 20000, np.random.default_rng(0))).torque
    )
    assert largest_gravity_torques(reduced).max() <= 1.25 * largest.max()
