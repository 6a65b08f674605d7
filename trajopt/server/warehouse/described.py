"""Searchable descriptions of entries: robot, scene, goal and words."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from trajopt.files.bundle import Bundle
from trajopt.files.bundle.codec import BundleWriter
from trajopt.files.bundle.fingerprint import digest_as_written
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.result import Plan, Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import GoalSet
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse.kept import Constraints, Kind, State
from trajopt.values.errors import ProblemError, shown
from trajopt.values.trajectory import Trajectory

Keepable: TypeAlias = Result | Plan | Problem | Scene | Robot | State | Constraints
"""Values that a warehouse stores."""


@dataclass(frozen=True, kw_only=True)
class Described:
    """Description of an entry.

    Attributes:
        kind: Its kind.
        robot: Name of the robot.
        scene: Fingerprint of its scene, in hexadecimal digits; empty without one.
        goal: The goal in words.
        ends: Final or goal positions of the joints that it determines [rad | m].
        status: Status of planning.
        duration: Of the motion [s].
        words: All its words, for text search.
    """

    kind: Kind
    robot: str
    scene: str = ""
    goal: str = ""
    ends: Mapping[str, float] = field(default_factory=dict[str, float])
    status: str = ""
    duration: float | None = None
    words: str = ""


def described(value: Keepable | Bundle) -> Described:
    """Describe something.

    Raises:
        ProblemError: If it is nothing that a warehouse keeps.
        ModelError: If its scene holds code of the caller's.
    """
    match value:
        case Robot():
            words = " ".join((value.name, *value.links, *value.joint_names, *value.groups))
            return Described(kind=Kind.ROBOT, robot=value.name, words=words)
        case Scene():
            words = " ".join((value.robot.name, *value.objects, *value.tools))
            return Described(
                kind=Kind.SCENE, robot=value.robot.name, scene=scene_fingerprint(value), words=words
            )
        case Problem():
            return _of_problem(value)
        case Result() | Plan():
            motion = value.trajectory
            if isinstance(value, Plan):
                return _of_answer(value.problem, motion, "SOLVED", "")
            return _of_answer(
                value.problem, motion if value.verified else None, value.status.name, value.reason
            )
        case Bundle():
            if not value.answer:
                return _of_problem(value.problem)
            motion = value.trajectory if value.answer.get("verified") is True else None
            return _of_answer(value.problem, motion, value.status, str(value.answer.get("message", "")))
        case State():
            words = " ".join((value.robot, *value.positions))
            return Described(kind=Kind.STATE, robot=value.robot, ends=value.positions, words=words)
        case Constraints():
            words = " ".join((value.robot, value.group, *map(str, value.requirements)))
            return Described(kind=Kind.CONSTRAINTS, robot=value.robot, words=words)
    raise ProblemError(
        "a warehouse keeps results, plans, problems, scenes, robots, states and constraints, "
        f"not {shown(value)}"
    )


def scene_fingerprint(scene: Scene) -> str:
    """Return a fingerprint of a scene and its robot, equal for equal numbers."""
    return digest_as_written(BundleWriter(), scene)


def _of_problem(problem: Problem) -> Described:
    goal = problem.goal
    fixed = None if isinstance(goal, GoalSet) else fixed_positions(problem.goals, problem.reduced)
    joints = problem.reduced.joint_names
    return Described(
        kind=Kind.PROBLEM,
        robot=problem.scene.robot.name,
        scene=scene_fingerprint(problem.scene),
        goal=str(goal) if isinstance(goal, GoalSet) else " and ".join(map(str, problem.goals)),
        ends={} if fixed is None else dict(zip(joints, map(float, fixed), strict=True)),
        words=" ".join((problem.name, str(problem), *problem.scene.objects)),
    )


def _of_answer(problem: Problem, motion: Trajectory | None, status: str, reason: str) -> Described:
    asked = _of_problem(problem)
    ends = asked.ends
    if motion is not None:
        ends = dict(zip(motion.joint_names, map(float, motion.positions[-1]), strict=True))
    return Described(
        kind=Kind.PLAN,
        robot=asked.robot,
        scene=asked.scene,
        goal=asked.goal,
        ends=ends,
        status=status,
        duration=None if motion is None else motion.duration,
        words=f"{asked.words} {reason}",
    )
