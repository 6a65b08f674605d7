"""Straight motions without rotation of the tool: configurations along the line, then a problem."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import Evaluator, WorkCounts, evaluator
from trajopt.geometry.geometry import TOUCHING
from trajopt.optimise.kinematics.projection import Projection
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.status import Status
from trajopt.problem.requirements import Requirement, frame_placement, joint_positions, point_on_line
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import GraspingOptions, Straight
from trajopt.values.arrays import Floats, readonly
from trajopt.values.placement import Placement

STEPS = 8
"""Number of configurations along a line checked before planning."""
JUMP = 0.6
"""A joint that moves more between two of them has changed to another branch of solutions [rad | m]."""
SHORTEST = 1e-6
"""A shorter line has no direction [m]."""
KNOTS = 12
"""Knots of a straight motion."""
SHARE = 0.5
"""Share of the gap at the end of a straight motion that becomes the margin along it."""


@dataclass(frozen=True, eq=False)
class LineTrack:
    """Configurations of the arm along a straight line of the tool.

    Attributes:
        end: The group's positions at its far end, shape (n,), or at the last reachable point.
        status: The kind of stop; None if the far end is reached.
        reason: The same in words.
    """

    end: Floats
    status: Status | None = None
    reason: str = ""


def vector_of(straight: Straight, scene: Scene, positions: Floats, usual: Floats) -> Floats:
    """Return the displacement of a straight motion in the world, shape (3,) [m]."""
    given = straight.unit
    direction = usual if given is None else scene.placement_of(straight.frame, positions).rotation @ given
    return straight.distance * direction


def up(scene: Scene) -> Floats:
    """Return the direction against gravity, shape (3,); z without gravity."""
    gravity = np.array(scene.robot.model.gravity.linear)
    strength = float(np.linalg.norm(gravity))
    return -gravity / strength if strength > 0.0 else np.array((0.0, 0.0, 1.0))


def track_line(
    reduced: ReducedModel, tool: str, at: Floats, away: Floats, tracker: BudgetTracker
) -> LineTrack:
    """Follow a straight line of the tool from a configuration, without rotation.

    Args:
        at: The group's positions at its beginning, shape (n,); contact there is ignored.
        away: From beginning to end in the world, shape (3,) [m].
    """
    counts = WorkCounts()
    try:
        return _tracked(evaluator(reduced, counts), tool, at, away, lambda: tracker.check(counts))
    finally:
        tracker.count_work(counts)


def _tracked(query: Evaluator, tool: str, at: Floats, away: Floats, check: Callable[[], None]) -> LineTrack:
    reduced = query.reduced
    begin = reduced.scene.placement_of(tool, reduced.all_positions(at))
    now = at
    for share in np.linspace(0.0, 1.0, STEPS + 1)[1:].tolist():
        check()
        target = Placement(begin.rotation, readonly(begin.translation + share * away))
        projected = Projection(reduced, (frame_placement(tool, target),), query)(now[None])
        after = projected.positions[0]
        where = f"{share * float(np.linalg.norm(away)) * 1e3:.0f} mm along the line"
        if projected.violation[0] > 0.0:
            return LineTrack(now, Status.OUT_OF_REACH, f"no configuration reaches {where}")
        if np.abs(after - now).max() > JUMP:
            return LineTrack(now, Status.BRANCH_JUMP, f"the arm would have to change branch {where}")
        contacts = query.close_pairs(after[None], reduced.pairs.required)
        if len(contacts.distance):
            deepest = int(np.argmin(contacts.distance))
            first, second = reduced.owners(int(contacts.pair[deepest]))
            return LineTrack(now, Status.COLLISION, f"{first} meets {second} {where}")
        now = after
    return LineTrack(readonly(np.array(now)))


def along_line(
    scene: Scene, start: Floats, goal: Floats, tool: str, options: GraspingOptions
) -> tuple[Requirement, Requirement]:
    """Return the requirements that the tool moves on the line between two configurations, without rotation.

    The configurations are positions of all joints [rad | m].
    """
    begin, end = scene.placement_of(tool, start), scene.placement_of(tool, goal)
    way = end.translation - begin.translation
    # A line shorter than the tolerance of a configuration may begin and end in the same one.
    direction = way if np.linalg.norm(way) > SHORTEST else end.rotation[:, 2]
    line = point_on_line(tool, begin.translation, direction, tolerance=options.aside)
    level = frame_placement(tool, end, position_tolerance=np.inf, rotation_tolerance=options.turn)
    return line, level


def to_configuration(scene: Scene, group: str, positions: Floats) -> Requirement:
    robot = scene.robot
    joints = robot.group(group).joints
    return joint_positions(dict(zip(joints, positions[robot.index(joints)].tolist(), strict=True)))


def with_room(reduced: ReducedModel, positions: Floats) -> Scene:
    """Return the scene with smaller margins for pairs that are closer in a configuration (n,).

    A straight motion that ends at a grasp is close to its neighbours all along: half of the gap at its end
    becomes the margin. Pairs in contact there get none.
    """
    scene = reduced.scene
    contacts = evaluator(reduced).close_pairs(positions[None], reduced.pairs.margin)
    gaps: dict[frozenset[str], float] = {}
    for pair, distance in zip(contacts.pair.tolist(), contacts.distance.tolist(), strict=True):
        owners = frozenset(reduced.owners(pair))
        gaps[owners] = min(gaps.get(owners, np.inf), distance)
    for owners, gap in gaps.items():
        first, second = sorted(owners)
        scene = scene.with_margin(SHARE * gap if gap > TOUCHING else 0.0, first, second)
    return scene
