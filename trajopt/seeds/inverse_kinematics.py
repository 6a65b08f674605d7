"""Goal configurations of goals that fix none: placo's inverse kinematics from several starts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.kinematics import link_placement
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import (
    WORLD,
    AxisAlignment,
    FramePlacement,
    JointPositions,
    Requirement,
)
from trajopt.query import Counts, Query, query_of
from trajopt.seeds.straight import nearest_turn
from trajopt.terms import constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE

STARTS = 32
"""Configurations that the search starts from."""
STEPS = 40
"""Steps of the search from each."""
CONVERGED = 1e-7
"""A search has converged when no joint moves more in a step [rad | m]."""
GOAL_FRAME = "trajopt_goal_{}"
"""Name of the link that stands for the frame of a goal."""
SAME = 1e-2
"""Solutions nearer to each other than this in every joint are one [rad | m]."""


@dataclass(frozen=True, eq=False)
class GoalCandidates:
    """What the search found.

    Attributes:
        free: Configurations that hold the goal and touch nothing, nearest to the start first.
        colliding: How many hold the goal but collide.
        blocking: The pair of owners that blocks the nearest colliding one, and its depth [m].
        nearest_miss: Smallest violation of the goal where none holds it [m and rad].
    """

    free: tuple[Floats, ...]
    colliding: int
    blocking: tuple[str, str, float] | None
    nearest_miss: float


def goal_candidates(
    reduced: ReducedModel,
    goals: Sequence[Requirement],
    *,
    rng: np.random.Generator,
    counts: Counts,
    starts: int = STARTS,
) -> GoalCandidates:
    """Search configurations that hold all goals.

    Args:
        reduced: The robot and its surroundings.
        goals: What must hold.
        rng: Draws the starts after the first, which is the start configuration.
        counts: Takes the work done.
        starts: How many starts to search from.
    """
    query = query_of(reduced, counts)
    limits = reduced.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    turning = np.array([_turns(reduced, name) for name in reduced.joint_names], dtype=np.float64)
    search = _PlacoSearch(reduced, goals)
    miss = _violation(reduced, goals, query)
    nearest_miss = np.inf
    found: list[Floats] = []
    for count in range(starts):
        begin = reduced.start_positions if count == 0 else rng.uniform(lower, upper)
        solution = search(np.asarray(begin))
        if solution is None:
            continue
        solution = nearest_turn(reduced.start_positions, solution, limits, turning)
        violation = miss(solution)
        nearest_miss = min(nearest_miss, violation)
        if violation == 0.0 and not any(np.abs(solution - other).max() < SAME for other in found):
            found.append(solution)
    travel = [float(np.max(np.abs(q - reduced.start_positions) / limits.velocity)) for q in found]
    free: list[Floats] = []
    blocking: tuple[str, str, float] | None = None
    for place in map(int, np.argsort(travel)):
        contacts = query.near(found[place][None, :], np.zeros(len(reduced.pairs.margin)))
        if len(contacts.distance) == 0:
            free.append(found[place])
        elif blocking is None:
            worst = int(contacts.pair[np.argmin(contacts.distance)])
            blocking = (*reduced.owners(worst), -float(contacts.distance.min()))
    return GoalCandidates(tuple(free), len(found) - len(free), blocking, nearest_miss)


def _turns(reduced: ReducedModel, joint: str) -> bool:
    model = reduced.model
    return "JointModelR" in model.joints[model.getJointId(joint)].shortname()


def _violation(
    reduced: ReducedModel, goals: Sequence[Requirement], query: Query
) -> Callable[[Floats], float]:
    """Return a function that measures how far a configuration is from holding the goals."""
    items = [item for goal in goals for item in constrain(goal, reduced, WHOLE)]

    limits = reduced.limits

    def worst(positions: Floats) -> float:
        motion = Motion.standing(positions, query)
        excess = max((item.excess(motion) for item in items), default=0.0)
        outside = np.maximum(limits.lower - positions, positions - limits.upper).max(initial=0.0)
        return excess + float(outside if outside > 1e-9 else 0.0)

    return worst


class _PlacoSearch:
    """Placo's task-space inverse kinematics of one set of goals; all else is held."""

    def __init__(self, reduced: ReducedModel, goals: Sequence[Requirement]) -> None:
        import placo

        robot = reduced.scene.robot
        self._reduced = reduced
        urdf = _with_goal_frames(reduced, goals)
        self._wrapper = placo.RobotWrapper("", placo.Flags.ignore_collisions, urdf)
        self._solver = placo.KinematicsSolver(self._wrapper)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(True)
        self._solver.add_regularization_task(1e-6)
        for joint in robot.joint_names:
            if joint not in reduced.joint_names:
                self._solver.mask_dof(joint)
        for count, goal in enumerate(goals):
            self._add(goal, GOAL_FRAME.format(count))

    def __call__(self, begin: Floats) -> Floats | None:
        """Search from a configuration of the group; None where the solver fails."""
        robot = self._reduced.scene.robot
        full = self._reduced.all_positions(begin)
        # Placo refuses a robot outside its limits, even where the joint is masked.
        inside = np.clip(full, robot.limits.lower, robot.limits.upper)
        for joint, value in zip(robot.joint_names, inside, strict=True):
            self._wrapper.set_joint(joint, float(value))
        self._wrapper.update_kinematics()
        now = self._positions()
        for _ in range(STEPS):
            try:
                self._solver.solve(True)
            except RuntimeError:
                return None
            self._wrapper.update_kinematics()
            before, now = now, self._positions()
            if np.abs(now - before).max() < CONVERGED:
                break
        return now

    def _positions(self) -> Floats:
        return np.array([self._wrapper.get_joint(name) for name in self._reduced.joint_names])

    def _in_world(self, reference: str) -> Placement:
        """Return where a reference is; one that moves with the group is taken at the start."""
        scene, start = self._reduced.scene, self._reduced.start
        holder = scene.holder(reference)
        if holder.link == WORLD:
            return holder.placement
        return link_placement(scene.robot, holder.link, start) * holder.placement

    def _add(self, goal: Requirement, frame: str) -> None:
        match goal:
            case FramePlacement():
                self._add_placement(goal, frame)
            case AxisAlignment():
                direction = self._in_world(goal.reference).rotation @ goal.direction
                self._solver.add_axisalign_task(frame, goal.axis, direction)
            case JointPositions():
                names = self._reduced.joint_names
                wanted = {name: value for name, value in goal.positions.items() if name in names}
                self._solver.add_joints_task().set_joints(wanted)
            case _:
                pass

    def _add_placement(self, goal: FramePlacement, frame: str) -> None:
        wanted = self._in_world(goal.reference) * goal.placement
        position, rotation = (
            "".join(axis for axis, t in zip("xyz", side, strict=True) if np.isfinite(t))
            for side in (goal.position_tolerance, goal.rotation_tolerance)
        )
        if position:
            task = self._solver.add_position_task(frame, wanted.translation)
            task.mask.R_custom_world = wanted.rotation.T
            task.mask.set_axises(position, "custom")
        if rotation:
            task = self._solver.add_orientation_task(frame, wanted.rotation)
            task.mask.R_custom_world = wanted.rotation.T
            task.mask.set_axises(rotation, "custom")


def _with_goal_frames(reduced: ReducedModel, goals: Sequence[Requirement]) -> str:
    """Return the robot's URDF with a fixed link for the frame (and point) of every goal."""
    root = ElementTree.fromstring(reduced.scene.robot.urdf_xml)
    for count, goal in enumerate(goals):
        if not isinstance(goal, FramePlacement | AxisAlignment):
            continue
        name, holder = GOAL_FRAME.format(count), reduced.scene.holder(goal.frame)
        offset = goal.offset if isinstance(goal, FramePlacement) else np.zeros(3)
        rpy = holder.placement.rpy
        ElementTree.SubElement(root, "link", name=name)
        joint = ElementTree.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
        ElementTree.SubElement(joint, "parent", link=holder.link)
        ElementTree.SubElement(joint, "child", link=name)
        numbers = (" ".join(repr(float(x)) for x in part) for part in (holder.placement * offset, rpy))
        ElementTree.SubElement(joint, "origin", dict(zip(("xyz", "rpy"), numbers, strict=True)))
    return ElementTree.tostring(root, encoding="unicode")
