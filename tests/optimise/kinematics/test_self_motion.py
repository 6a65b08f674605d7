"""Self-motion: the placement is held, neighbours are near, the ends are limits or the loop closes."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import forward_kinematics, self_motion, validity
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model

TCP = "panda_hand_tcp"

RING = """<robot name="ring">
  <link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="one" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>
  <joint name="two" type="continuous"><parent link="a"/><child link="b"/><origin xyz="1 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="three" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="tip" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0.4 0 0"/></joint>
</robot>"""
"""A planar arm of three joints without limits: its self-motions are loops."""


def test_a_seven_joint_arm_holds_the_placement(panda: ReducedModel) -> None:
    where = forward_kinematics(panda, TCP, panda.start_positions)[0]
    goal = to.frame_placement(TCP, where)
    found = self_motion(panda, goal, panda.start_positions)
    assert len(found.positions) > 40 and not found.closed
    np.testing.assert_array_equal(found.positions[found.begin], panda.start_positions)
    for q, free in zip(found.positions, found.free, strict=True):
        judged = validity(panda, q, requirements=[goal])
        assert all(check.holds for check in judged.checks) and not judged.examination.out_of_limits
        assert free == (not judged.examination.collisions)
    steps = np.abs(np.diff(found.positions, axis=0)).max(axis=1)
    assert 0.0 < steps.min() and steps.max() <= 0.1
    # A seven-joint arm's elbow swings far; it ends where a joint is at its limit.
    for end in (found.positions[0], found.positions[-1]):
        room = np.minimum(end - panda.limits.lower, panda.limits.upper - end)
        assert room.min() < 0.05


def test_the_joint_that_leads_moves_upward_first(panda: ReducedModel) -> None:
    goal = to.frame_placement(TCP, forward_kinematics(panda, TCP, panda.start_positions)[0])
    found = self_motion(panda, goal, panda.start_positions, joint="panda_joint7")
    assert found.positions[found.begin + 1][6] > found.positions[found.begin][6]


def test_a_loop_closes(tmp_path: Path) -> None:
    (tmp_path / "ring.urdf").write_text(RING)
    robot = to.load(tmp_path / "ring.urdf")
    ring = reduce_model(to.Scene(robot), "all", robot.positions({"one": 0.3, "two": 1.4, "three": 0.5}))
    where = forward_kinematics(ring, "d", ring.start_positions)[0]
    goal = to.frame_placement("d", where, rotation_tolerance=np.inf)
    found = self_motion(ring, goal, ring.start_positions)
    assert found.closed and len(found.positions) > 20
    reached = forward_kinematics(ring, "d", found.positions).translation
    assert np.abs(reached - where.translation).max() <= 1e-4


def test_misuse_is_named(panda: ReducedModel, odd: ReducedModel) -> None:
    q = panda.start_positions
    goal = to.frame_placement(TCP, forward_kinematics(panda, TCP, q)[0])
    with pytest.raises(to.TrajoptError, match="does not hold where the sweep begins"):
        self_motion(panda, goal, q + 0.1)
    with pytest.raises(to.TrajoptError, match="no joint in the group named 'panda_joint8'"):
        self_motion(panda, goal, q, joint="panda_joint8")
    with pytest.raises(to.TrajoptError, match="step: must be positive"):
        self_motion(panda, goal, q, step=0.0)
    fixed = to.joint_positions(dict(zip(odd.joint_names, odd.start_positions.tolist(), strict=True)))
    with pytest.raises(to.TrajoptError, match="no joint can move there while the goal is held"):
        self_motion(odd, fixed, odd.start_positions)
