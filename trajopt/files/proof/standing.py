"""Proof of a verified motion in a scene with moved objects."""

import json
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from operator import attrgetter
from typing import Any

import numpy as np

from trajopt.files.proof.pairs import BodyPart, convex_part, proven_pairs
from trajopt.files.proof.proof import verified_motion
from trajopt.files.proof.statement import statement
from trajopt.native.checker import SweptParts
from trajopt.planning.judgement import judge
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import AxisAlignment, FramePlacement, JointPositions, PositionInRegion
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked_class
from trajopt.values.placement import WORLD, Placement
from trajopt.values.trajectory import Trajectory

PLAIN = (AxisAlignment, FramePlacement, JointPositions, PositionInRegion)
"""Requirements that depend on no object but those that they name."""
CELLS = 64
"""Further intervals of a motion in which a ball contains each part."""


def _all_fields(kind: type[Any], but: str) -> Callable[[object], tuple[object, ...]]:
    return attrgetter(*(each.name for each in fields(kind) if each.name != but))


_of_scene, _of_object = _all_fields(Scene, "objects"), _all_fields(SceneObject, "placement")


@checked_class
class StandingMotion:
    """A verified motion, prepared for questions about scenes in which objects have moved.

    The fast kernel checks pairs of moved objects, with balls around the robot's parts over intervals of time.
    Otherwise the judge verifies the motion again.
    """

    def __init__(self, problem: Problem, trajectory: Trajectory) -> None:
        """Verify a motion, with velocities, of a problem with one goal.

        Raises:
            ProblemError: If the judge does not verify the motion.
        """
        self.problem, self.trajectory = problem, trajectory
        self._motion = verified_motion(problem, trajectory)
        self._pairs = proven_pairs(self._motion)
        self._bound = self._not_moved()
        self._swept = self._swept_parts()

    def proven_in(self, scene: Scene) -> bool:
        """Return whether the motion is proven in a scene, with the same requirements.

        Raises:
            ProblemError: If the problem cannot be stated in the scene.
        """
        moved = self._moved(scene)
        if moved is not None and all(
            self._swept.keep_apart(name, place.rotation, place.translation) for name, place in moved.items()
        ):
            return True
        return judge(replace(self.problem, scene=scene), self.trajectory).verified

    def _not_moved(self) -> frozenset[str]:
        """Return objects whose movement changes more than clearance from convex parts."""
        problem, bodies = self.problem, self._motion.among.reduced.bodies
        shapeless = {body.owner for body in bodies if _is_unusual(convex_part(body)) or body.joint}
        carried = {item.frame for item in problem.scene.placed.values()}
        stated = [each for each in (*problem.goals, *problem.constraints) if isinstance(each, PLAIN)]
        if len(stated) < len(problem.goals) + len(problem.constraints) or problem.waypoints:
            return frozenset(problem.scene.objects)
        named = {frame for each in stated for frame in each.frames}
        contacts = {
            owner for *owners, reason in self._pairs.excused if "judged" in reason for owner in owners
        }
        contacts.update(*self._pairs.contacts)
        return frozenset(shapeless | carried | named | contacts)

    def _swept_parts(self) -> SweptParts:
        stated = json.dumps(statement(self.problem, self._motion, self._pairs), allow_nan=False)
        frames: dict[str, tuple[Floats, Floats]] = {
            name: (item.placement.rotation, item.placement.translation)
            for name, item in self.problem.scene.objects.items()
            if name not in self._bound
        }
        times = np.linspace(0.0, self._motion.duration, CELLS + 1)
        return SweptParts(json.loads(stated), times.tolist(), frames)

    def _moved(self, scene: Scene) -> Mapping[str, Placement] | None:
        before = self.problem.scene
        if _of_scene(before) != _of_scene(scene) or before.objects.keys() != scene.objects.keys():
            return None
        moved: dict[str, Placement] = {}
        for name, item in before.objects.items():
            now = scene.objects[name]
            if now is item:
                continue
            if name in self._bound or not _only_moved(item, now):
                return None
            moved[name] = now.placement
        return moved


def _is_unusual(part: BodyPart | None) -> bool:
    return part is None or part.is_half_space


def _only_moved(before: SceneObject, now: SceneObject) -> bool:
    rests = before.timing.always and now.timing.always and before.frame == now.frame == WORLD
    return rests and _of_object(before) == _of_object(now)
