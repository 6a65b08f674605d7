"""Whether a verified motion stands in a scene with moved objects, without judging all of it again."""

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from trajopt.files.proof.leaves import LeafSearch
from trajopt.files.proof.pairs import ConvexPart, convex_part, proven_pairs
from trajopt.files.proof.proof import verified_motion
from trajopt.planning.judgement import judge
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import AxisAlignment, FramePlacement, JointPositions, PositionInRegion
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats, Ints
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement
from trajopt.values.trajectory import Trajectory

PLAIN = (AxisAlignment, FramePlacement, JointPositions, PositionInRegion)
"""Requirements that depend on no object but those that they name."""
CELLS = 64
"""Intervals of a motion in each of which a ball contains each part that moves."""
MERGED = (64, 8)
"""Successive intervals whose balls are contained in a ball, which is looked at first."""


class StandingMotion:
    """A verified motion, prepared for questions about scenes in which objects have moved.

    Only pairs of moved objects are looked at, with balls around the parts of the robot over intervals of
    time. If these do not suffice, and after other changes, the judge verifies the motion again.
    """

    @checked
    def __init__(self, problem: Problem, trajectory: Trajectory) -> None:
        """Verify a motion.

        Args:
            problem: The problem, with one goal.
            trajectory: Of the group's joints, with velocities.

        Raises:
            ProblemError: If the judge does not verify the motion.
        """
        self.problem, self.trajectory = problem, trajectory
        self._motion = verified_motion(problem, trajectory)
        self._pairs = proven_pairs(self._motion)
        times = np.linspace(0.0, self._motion.duration, CELLS + 1)
        centre, radius = LeafSearch(self._motion.among, self._pairs).balls(times)
        self._balls = [*(_merged(centre, radius, count) for count in MERGED), (centre, radius)]
        self._paired: dict[str, list[tuple[ConvexPart, Ints, Floats]]] = {}
        self._bound = self._not_moved()

    @checked
    def proven_in(self, scene: Scene) -> bool:
        """Return whether the motion is proven in a scene, with the same requirements.

        Raises:
            ProblemError: If the problem cannot be stated in the scene.
        """
        moved = self._moved(scene)
        if moved is not None and all(self._apart(name, by) for name, by in moved.items()):
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
        return frozenset(shapeless | carried | named | contacts)

    def _moved(self, scene: Scene) -> Mapping[str, Placement] | None:
        """Return how objects have moved in the world; None if there are other changes."""
        before = self.problem.scene
        if _differ(before, scene, but="objects") or before.objects.keys() != scene.objects.keys():
            return None
        moved: dict[str, Placement] = {}
        for name, item in before.objects.items():
            now = scene.objects[name]
            if now is item:
                continue
            if name in self._bound or not _only_moved(item, now):
                return None
            moved[name] = now.placement * item.placement.inverse()
        return moved

    def _apart(self, name: str, by: Placement) -> bool:
        """Return whether balls around the robot's parts show that an object keeps its clearance."""
        return all(
            self._clear(part.moved(by), others, required) for part, others, required in self._pairs_of(name)
        )

    def _pairs_of(self, name: str) -> list[tuple[ConvexPart, Ints, Floats]]:
        """Return the parts of an object, with the parts of their pairs and the clearances."""
        if name not in self._paired:
            parts, pairs = self._pairs.parts, self._pairs.pairs
            found: list[tuple[ConvexPart, Ints, Floats]] = []
            for number in [at for at, part in enumerate(parts) if part.body.owner == name]:
                rows = np.any(pairs == number, axis=1)
                found.append((parts[number], pairs[rows].sum(axis=1) - number, self._pairs.required[rows]))
            self._paired[name] = found
        return self._paired[name]

    def _clear(self, part: ConvexPart, others: Ints, required: Floats) -> bool:
        for centre, radius in self._balls:
            around = radius[:, others]
            away = part.distance_from(centre[:, others].reshape(-1, 3)).reshape(around.shape)
            near = ((away - around) <= required).any(axis=0)
            others, required = others[near], required[near]
            if not len(others):
                return True
        return False


def _merged(centre: Floats, radius: Floats, count: int) -> tuple[Floats, Floats]:
    """Return balls around as many balls of successive intervals."""
    groups, inner = centre.reshape(-1, count, *centre.shape[1:]), radius.reshape(-1, count, radius.shape[1])
    middle = groups.mean(axis=1)
    reach = np.linalg.norm(groups - middle[:, None], axis=3) + inner
    return middle, reach.max(axis=1)


def _is_unusual(part: ConvexPart | None) -> bool:
    return part is None or part.is_half_space


def _only_moved(before: SceneObject, now: SceneObject) -> bool:
    rests = before.timing.always and now.timing.always and before.frame == now.frame == WORLD
    return rests and not _differ(before, now, but="placement")


def _differ(one: Scene | SceneObject, other: Scene | SceneObject, *, but: str) -> bool:
    names = {each.name for each in fields(one)} - {but}
    sides = ((getattr(one, name), getattr(other, name)) for name in names)
    return any(first is not second and first != second for first, second in sides)
