"""Visibility constraints become requirements that accept the postures MoveIt accepts."""

from collections.abc import Callable

import numpy as np
import pytest

from trajopt import Robot, placement
from trajopt.files.moveit import RequestFile
from trajopt.geometry import Query
from trajopt.optimise.terms import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.residual import WHOLE
from trajopt.scene.reducing import reduce_model

Read = Callable[..., RequestFile]

SENSOR = placement((0.05, 0.02, 0.0), rpy=(0.0, np.pi / 2, 0.3))
TARGET = placement((0.7, 0.5, 0.1), rpy=(0.0, -np.pi / 2, 0.4))


def pose(where: object) -> str:
    position, orientation = where.translation.tolist(), where.quaternion.tolist()
    return f"{{position: {position}, orientation: {orientation}}}"


def visibility(angles: str, sensor: str = "hand", target: str = "world") -> str:
    return (
        "{group_name: arm, goal_constraints: [{visibility_constraints: [{"
        f"sensor_pose: {{header: {{frame_id: {sensor}}}, pose: {pose(SENSOR)}}}, "
        f"target_pose: {{header: {{frame_id: {target}}}, pose: {pose(TARGET)}}}, {angles}}}]}}]}}"
    )


def excess(request: RequestFile, positions: np.ndarray) -> float:
    reduced = reduce_model(request.scene, "arm", request.start)
    motion = Motion.single(positions, Query(reduced))
    terms = [item for goal in request.goals for item in constrain(goal, reduced, WHOLE, inset=0.0)]
    return max(item.excess(motion) for item in terms)


@pytest.mark.parametrize("kind", ["max_range_angle", "max_view_angle"])
@pytest.mark.parametrize(("sensor", "target"), [("hand", "world"), ("world", "hand")])
@pytest.mark.parametrize("direction", [0, 1, 2])
def test_the_same_postures_are_accepted(
    request_of: Read, planar_arm: Robot, kind: str, sensor: str, target: str, direction: int
) -> None:
    request = request_of(visibility(f"{kind}: 1.2, sensor_view_direction: {direction}", sensor, target))
    rng, seen = np.random.default_rng(3), set[bool]()
    for positions in rng.uniform(-2.0, 2.0, (60, 2)):
        everything = planar_arm.positions(dict(zip(("shoulder", "elbow"), positions, strict=True)))
        where = request.scene.placement_of(sensor, everything) * SENSOR
        aim = request.scene.placement_of(target, everything) * TARGET
        axis = where.rotation[:, 2 - direction]
        way = aim.translation - where.translation
        other = way / np.linalg.norm(way) if kind == "max_range_angle" else -aim.rotation[:, 2]
        accepted = bool(np.arccos(np.clip(axis @ other, -1, 1)) <= 1.2)
        assert (excess(request, positions) <= 0.0) == accepted
        seen.add(accepted)
    assert False in seen


def test_ignored_occlusion_is_noted(request_of: Read) -> None:
    request = request_of(visibility("max_range_angle: 0.4, max_view_angle: 0.5"))
    assert len(request.goals) == 2
    assert "obstacles between sensor and target are not checked" in request.notes[0]
