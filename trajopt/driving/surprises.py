"""Unannounced changes of the world while a robot is driven, from a file or drawn at random.

A file, YAML or JSON, lists them:

    objects:
      - object: crate                                    # new, with a shape; or one of the scene, which moves
        at: 0.4                                          # [s]
        position: [0.4, 0.1, 0.2]                        # in the world [m]
        orientation: [0, 0, 0, 1]                        # (x, y, z, w); upright if omitted
        shape: {type: box, dimensions: [0.1, 0.1, 0.1]}  # as in MoveIt's files
        leaves: 2.5                                      # disappears then; stays if omitted
    sensors: {delay: 0.01, noise: 0.0002}                # [s], [rad | m]
    faults:
      - {kind: stuck, joint: panda_joint4, begin: 0.3, end: 9.0}

A random surprise is a box that appears on the path ahead of the robot, planned in the known world. A time is
drawn from the first nine tenths of the motion, and a later one, at least `NOTICE` after the robot could have
come to rest. The box appears at the first time, at the place of the tip of the group at the second. Its edges
are drawn from 4 to 12 cm, it is turned about the vertical, and displaced by up to half an edge along each
axis. It is drawn again while it is within `ROOM_TO_REST` of the robot, or of an attached object, at that
time, on the way to rest, at the start or at the goal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, pi
from pathlib import Path

import numpy as np

from trajopt.driving.motion_guard import guard_within
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.simulated import EXACT, TOLERANCE, Fault, FaultKind, Sensors
from trajopt.planning.plan import plan
from trajopt.problem.problem import Problem
from trajopt.scene.clearances import Part
from trajopt.scene.group_tools import ends_of
from trajopt.scene.reducing import driven_joints, reduce_model
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.timing.time_scaling import StopsAlong
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.shapes import Box, Shape
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

FIELDS = ("objects", "sensors", "faults")
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
OBJECT_FIELDS = ("object", "at", "position", "orientation", "shape", "leaves")


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Surprise(Value):
    """An object that appears, or changes its place instantly.

    Attributes:
        name: Of a new object, which has a shape, or of an object of the scene, which is moved.
        at: Time of the change [s].
        placement: In the world from then on.
        shape: Of a new object; None for an object of the scene.
        leaves: Time at which it disappears [s].
    """

    name: str
    at: float
    placement: Placement
    shape: Shape | None = None
    leaves: float = inf


@checked_class
@dataclass(frozen=True, eq=False, kw_only=True)
class Surprises(Value):
    """All unannounced changes of a run.

    Attributes:
        sensors: Delay and noise of measurements of the robot; objects are seen with the same delay.
    """

    objects: Sequence[Surprise] = ()
    sensors: Sensors = field(default_factory=lambda: EXACT)
    faults: Sequence[Fault] = ()

    @property
    def times(self) -> tuple[float, ...]:
        """Times of the changes, in order [s]."""
        both = {time for each in self.objects for time in (each.at, each.leaves) if time < inf}
        return tuple(sorted(both))

    def world(self, scene: Scene) -> Scene:
        """Return the real world over time; its clock shows 0 at the start of the robot."""
        for each in self.objects:
            if each.shape is not None:
                scene = scene.add(each.name, each.shape, each.placement, appears=each.at, expires=each.leaves)
                continue
            item = scene.object(each.name)
            moved = SceneObject(f"{each.name} moved", item.parts, each.placement, WORLD, item.touch_links)
            scene = scene.with_motion(each.name, expires=each.at)
            scene = replace(scene, objects={**scene.objects, moved.name: moved})
            scene = scene.with_motion(moved.name, appears=each.at, expires=each.leaves)
        return scene

    def seen(self, scene: Scene, time: float) -> Scene:
        """Return the world as seen at a time on the clock of the run [s]."""
        for each in self.objects:
            if each.leaves <= time:
                scene = scene if each.shape is not None else scene.remove(each.name)
            elif each.at <= time and each.shape is not None:
                scene = scene.add(each.name, each.shape, each.placement)
            elif each.at <= time:
                scene = scene.move(each.name, each.placement)
        return scene


NONE = Surprises()


@checked
def read_surprises(path: Path | str) -> Surprises:
    """Read surprises from a file.

    Raises:
        FileFormatError: If the file does not have the format of this module.
    """
    document = read_document(path).only(FIELDS)
    sensors = document["sensors"].only(("delay", "noise"))
    return Surprises(
        objects=[_surprise(entry.only(OBJECT_FIELDS)) for entry in document["objects"].elements()],
        sensors=Sensors(delay=sensors["delay"].number(0.0), noise=sensors["noise"].number(0.0)),
        faults=[_fault(entry) for entry in document["faults"].elements()],
    )


def _surprise(entry: Node) -> Surprise:
    from trajopt.files.moveit.objects import read_primitive  # only files need it

    shape, orientation = entry["shape"], entry["orientation"]
    turned = UPRIGHT if orientation.missing else orientation.numbers()
    try:
        where = placement(entry["position"].numbers(), quaternion=turned)
    except ShapeError as error:
        raise entry.error(str(error)) from error
    return Surprise(
        name=entry["object"].text(),
        at=entry["at"].number(),
        placement=where,
        shape=None if shape.missing else read_primitive(shape),
        leaves=entry["leaves"].number(inf, infinite=True),
    )


def _fault(entry: Node) -> Fault:
    fields = entry.only(("kind", "joint", "begin", "end", "size"))
    kinds = {kind.value: kind for kind in FaultKind}
    name = fields["kind"].text()
    if name not in kinds:
        raise fields["kind"].error(f"is {name!r}, must be one of {', '.join(kinds)}")
    try:
        return Fault(
            kind=kinds[name],
            begin=fields["begin"].number(),
            end=fields["end"].number(),
            joint=fields["joint"].text(""),
            size=fields["size"].number(0.0),
        )
    except ProblemError as error:
        raise entry.error(str(error)) from error


NOTICE = 0.15
"""Time between the rest of a robot that stops immediately and its arrival at the box [s], for the delays of
sensors and commands."""
BEHIND = SupervisorOptions().ahead
"""Largest delay of a robot behind the clock of the motion when the box appears [s]."""
ROOM_TO_REST = 0.02
"""Least distance between the box and a robot that can no longer avoid it [m]."""
EDGES = (0.04, 0.12)
"""Least and largest edge of the box [m]."""
DRAWS = 200
STOP_STEP = 0.02
"""Time between checked configurations on the way to rest [s]: `ROOM_TO_REST` at 1 m/s."""


@checked
def undisturbed(problem: Problem, *, tolerance: float = TOLERANCE) -> Trajectory:
    """Return the motion of a supervisor without surprises, for `random_surprise`.

    Unlike `plan` it keeps a margin for the tracking error [rad | m].

    Raises:
        PlanningFailed: Without a plan.
    """
    driven = driven_joints(problem.scene.robot)
    guard = guard_within(problem, driven, np.full(len(driven), tolerance))
    return plan(replace(problem, scene=guard.tracked(problem.scene))).require().trajectory


@checked
def random_surprise(problem: Problem, motion: Trajectory, seed: int) -> Surprises:
    """Draw a box on the path of a motion by the rule of this module; equal seeds draw equal boxes.

    Raises:
        ProblemError: If none of the drawn boxes leaves the robot a way to rest.
    """
    rng, stops = np.random.default_rng(seed), StopsAlong(motion, problem.limits)
    scene, reduced = problem.scene, problem.reduced
    ends = ends_of(scene, problem.group)
    tip = ends[int(rng.integers(len(ends))) if len(ends) > 1 else 0]
    for _ in range(DRAWS):
        at = float(rng.uniform(0.0, 0.9 * motion.duration))
        rest = stops.earliest(at).trajectory
        first = at + rest.duration + NOTICE
        edges, turn = rng.uniform(*EDGES, 3), float(rng.uniform(-pi, pi))
        off, share = rng.uniform(-0.5, 0.5, 3) * edges, float(rng.uniform())
        if first >= motion.duration:
            continue
        later = first + share * (motion.duration - first)
        centre = scene.placement_of(tip, reduced.all_positions(motion(later))).translation + off
        box = Surprise(
            name="surprise", at=at, placement=placement(centre, rpy=(0.0, 0.0, turn)), shape=Box(*edges)
        )
        kept = [
            motion(np.arange(max(at - BEHIND, 0.0), at, STOP_STEP)),
            rest(np.arange(0.0, rest.duration + STOP_STEP, STOP_STEP)),
            motion(np.array((0.0, motion.duration))),
        ]
        if has_room(problem, box, np.concatenate(kept)):
            return Surprises(objects=(box,))
    raise ProblemError(
        f"none of {DRAWS} random boxes leaves the robot a way to rest; the motion is too short"
    )


def has_room(problem: Problem, box: Surprise, configurations: Floats) -> bool:
    known = problem.scene
    carried = {name: item for name, item in known.objects.items() if known.part(name) is Part.CARRIED}
    alone = replace(known, objects=carried)
    scene = Surprises(objects=(box,)).seen(alone, box.at).with_clearance(world=ROOM_TO_REST)
    judge = Judge(reduce_model(scene, problem.group, problem.start_positions))
    return all(judge.examine(each).clear for each in configurations)
