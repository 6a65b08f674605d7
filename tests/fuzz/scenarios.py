"""Random problems: arms, clutter and goals; most of them with a motion that is known to hold all of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np
from trajopt_problems import arms

import trajopt as to
from trajopt.geometry import Query
from trajopt.values.arrays import Floats

MARGIN = 0.01
SPARE = 0.003
"""What the known motion keeps beyond the margin [m]."""
SWEEP = 0.005
"""How far bodies move between two samples of the known motion [m]."""
DRAWS = 200


class Kind(Enum):
    """What is known of a problem."""

    FEASIBLE = "a motion is known that holds all that is asked"
    OPEN = "nobody knows whether there is one"
    NONSENSE = "the input is bad"


@dataclass(frozen=True, eq=False)
class Scenario:
    """A random problem, not made yet: making one of bad input raises.

    Attributes:
        number: Which one it is.
        kind: What is known of it.
        arm: Name of the robot.
        make: Makes the problem.
    """

    number: int
    kind: Kind
    arm: str
    make: Callable[[], to.Problem]


@dataclass(frozen=True, eq=False)
class _Planar:
    robot: to.Robot
    group: str
    tip: str
    hand: tuple[str, ...]
    ready: Mapping[str, float]


def _planar() -> _Planar:
    robot = to.load("planar2")
    group = next(iter(robot.groups))
    return _Planar(robot, group, robot.links[-1], (robot.links[-1],), {})


ARMS: dict[str, Callable[[], arms.Arm | _Planar]] = {
    "panda": arms.panda,
    "ur5": arms.ur5,
    "xarm7": arms.xarm7,
    "planar2": _planar,
}


def scenario(number: int) -> Scenario:
    """Return a random problem; the same one for a number on every machine."""
    rng = np.random.default_rng((20261121, number))
    kind = rng.choice(list(Kind), p=[0.6, 0.25, 0.15])
    name = str(rng.choice(list(ARMS), p=[0.35, 0.3, 0.25, 0.1]))
    draw = {Kind.FEASIBLE: _feasible, Kind.OPEN: _open, Kind.NONSENSE: _nonsense}[kind]
    return Scenario(number, kind, name, draw(ARMS[name](), rng))


def _feasible(arm: arms.Arm | _Planar, rng: np.random.Generator) -> Callable[[], to.Problem]:
    """Draw a motion first, put clutter where it does not touch it, then ask for what it does."""
    scene = to.Scene(arm.robot, margin=MARGIN)
    if rng.random() < 0.15 and arm.hand != (arm.tip,):
        scene = _carrying(scene, arm, rng)
    motion = _known_motion(scene, arm, rng)
    scene = _clutter(scene, arm, motion, rng)
    start, goal = (_named(scene, arm, q) for q in (motion[0], motion[-1]))
    asked: list[to.Requirement] = []
    if rng.random() < 0.3 and isinstance(arm, arms.Arm):
        asked.append(_held_along(scene, arm, motion, rng))
    where = scene.placement_of(arm.tip, arm.robot.positions(goal))
    if rng.random() < 0.5:
        wanted = to.joint_positions({name: goal[name] for name in arm.robot.group(arm.group).joints})
    else:
        free = np.inf if not isinstance(arm, arms.Arm) else float(rng.choice([0.02, 0.2]))
        wanted = to.frame_placement(arm.tip, where, position_tolerance=0.005, rotation_tolerance=free)

    def make() -> to.Problem:
        return to.Problem(scene=scene, group=arm.group, start=start, goal=wanted, constraints=asked)

    return make


def _open(arm: arms.Arm | _Planar, rng: np.random.Generator) -> Callable[[], to.Problem]:
    """Draw clutter and a goal without looking at each other."""
    scene = to.Scene(arm.robot, margin=MARGIN)
    for count in range(int(rng.integers(0, 9))):
        scene = scene.add(f"thing{count}", _shape(rng), _somewhere(rng))
    limits = _query(scene, arm).reduced.limits
    low, high = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    start = dict(zip(limits.joint_names, rng.uniform(low, high).tolist(), strict=True))
    if rng.random() < 0.4:
        wide = 1.2 if rng.random() < 0.3 else 1.0
        there = dict(zip(limits.joint_names, (wide * rng.uniform(low, high)).tolist(), strict=True))
        wanted = to.joint_positions(there)
    else:
        wanted = to.frame_placement(
            arm.tip, _somewhere(rng), rotation_tolerance=float(rng.choice([0.02, np.inf]))
        )
    asked = [to.axis_alignment(arm.tip, direction=_direction(rng), tolerance=0.5)] * int(rng.random() < 0.2)

    def make() -> to.Problem:
        return to.Problem(scene=scene, group=arm.group, start=start, goal=wanted, constraints=asked)

    return make


def _nonsense(arm: arms.Arm | _Planar, rng: np.random.Generator) -> Callable[[], to.Problem]:
    """Draw one mistake in an otherwise sound problem."""
    group, scene = arm.group, to.Scene(arm.robot)
    joints = arm.robot.group(group).joints
    goal = to.joint_positions({joints[0]: 0.1})
    mistakes: list[Callable[[], to.Problem]] = [
        lambda: to.Problem(scene=scene, group="no such group", start={}, goal=goal),
        lambda: to.Problem(scene=scene, group=group, start="no such state", goal=goal),
        lambda: to.Problem(scene=scene, group=group, start={"no such joint": 0.0}, goal=goal),
        lambda: to.Problem(scene=scene, group=group, start={joints[0]: np.nan}, goal=goal),
        lambda: to.Problem(scene=scene, group=group, start=np.zeros(3 + len(joints) * 2), goal=goal),
        lambda: to.Problem(scene=scene, group=group, start={}, goal=[]),
        lambda: to.Problem(scene=scene, group=group, start={}, goal=goal, knots=2),
        lambda: to.Problem(scene=scene, group=group, start={}, goal=goal, velocity_scaling=0.0),
        lambda: to.Problem(
            scene=scene,
            group=group,
            start={},
            goal=to.frame_placement("no such frame", to.placement((0, 0, 1))),
        ),
        lambda: to.Problem(
            scene=scene,
            group=group,
            start={},
            goal=to.frame_placement(arm.tip, to.placement((0, np.nan, 1))),
        ),
        lambda: to.Problem(scene=scene.add("thing", to.Box(-1, 1, 1)), group=group, start={}, goal=goal),
        lambda: to.Problem(
            scene=scene.add("thing", to.Sphere(0.1), to.placement((np.inf, 0, 0))),
            group=group, start={}, goal=goal,
        ),
        lambda: to.Problem(
            scene=scene.add("thing", to.Sphere(0.1)).add("thing", to.Sphere(0.1)),
            group=group, start={}, goal=goal,
        ),
        lambda: to.Problem(scene=scene.remove("no such object"), group=group, start={}, goal=goal),
        lambda: to.Problem(scene=scene.with_margin(-0.1), group=group, start={}, goal=goal),
        lambda: to.Problem(scene=scene, group=group, start={}, goal=to.joint_positions({joints[0]: np.nan})),
        lambda: to.Problem(
            scene=scene, group=group, start={}, goal=goal,
            constraints=[to.axis_alignment(arm.tip, direction=(0, 0, 0), tolerance=0.1)],
        ),
        lambda: to.Problem(
            scene=scene, group=group, start={}, goal=goal, tool_speed=to.tool_speed(arm.tip, linear=-1.0)
        ),
    ]  # fmt: skip
    return mistakes[int(rng.integers(len(mistakes)))]


def _named(scene: to.Scene, arm: arms.Arm | _Planar, q: Floats) -> dict[str, float]:
    joints = arm.robot.group(arm.group).joints
    return {**arm.ready, **dict(zip(joints, q.tolist(), strict=True))}


def _query(scene: to.Scene, arm: arms.Arm | _Planar) -> Query:
    joints = arm.robot.group(arm.group).joints
    still = to.Problem(
        scene=scene, group=arm.group, start=dict(arm.ready), goal=to.joint_positions({joints[0]: 0.0})
    )
    assert still.reduced.joint_names == joints
    return Query(still.reduced)


def _free(query: Query, positions: Floats) -> bool:
    margin = query.reduced.pairs.margin + SPARE
    return len(query.close_pairs(positions, margin).distance) == 0


def _dense(query: Query, corners: Floats) -> Floats:
    """Sample a polyline so that no body moves farther than the sweep between two samples."""
    parts: list[Floats] = []
    for first, last in pairwise(corners):
        fine = np.linspace(first, last, 20)
        moved = float(query.displacement(fine[:-1], fine[1:]).sum())
        parts.append(np.linspace(first, last, max(2, int(np.ceil(moved / SWEEP)))))
    return np.concatenate(parts)


def _known_motion(scene: to.Scene, arm: arms.Arm | _Planar, rng: np.random.Generator) -> Floats:
    """Draw a polyline of two legs on which the arm touches neither itself nor the ground."""
    query = _query(scene, arm)
    limits = query.reduced.limits
    low, high = np.maximum(limits.lower, -2.8) + 0.05, np.minimum(limits.upper, 2.8) - 0.05
    for _ in range(DRAWS):
        first = rng.uniform(low, high)
        last = np.clip(first + rng.normal(scale=0.8, size=len(low)), low, high)
        bend = np.clip((first + last) / 2.0 + rng.normal(scale=0.35, size=len(low)), low, high)
        motion = _dense(query, np.stack((first, bend, last)))
        if _free(query, motion):
            return motion
    raise AssertionError("no motion was found that leaves the arm alone")


def _clutter(scene: to.Scene, arm: arms.Arm | _Planar, motion: Floats, rng: np.random.Generator) -> to.Scene:
    """Add things near the motion that it does not touch."""
    wanted = int(rng.integers(1, 9))
    for count in range(40):
        if len(scene.objects) >= wanted:
            break
        near = motion[int(rng.integers(len(motion)))]
        link = str(rng.choice(arm.robot.links))
        centre = scene.placement_of(link, arm.robot.positions(_named(scene, arm, near))).translation
        where = to.placement(centre + rng.normal(scale=0.2, size=3), rpy=rng.uniform(-3, 3, 3))
        trial = scene.add(f"thing{count}", _shape(rng), where)
        if _free(_query(trial, arm), motion):
            scene = trial
    return scene


def _carrying(scene: to.Scene, arm: arms.Arm | _Planar, rng: np.random.Generator) -> to.Scene:
    size = rng.uniform(0.03, 0.1, 3)
    where = to.placement((0.0, 0.0, float(size[2]) / 2.0 + 0.005))
    return scene.add("carried", to.Box(*size), where, frame=arm.tip, touch_links=list(arm.hand))


def _held_along(scene: to.Scene, arm: arms.Arm, motion: Floats, rng: np.random.Generator) -> to.Requirement:
    """Return a path constraint that the known motion holds with something to spare."""
    tips = [scene.placement_of(arm.tip, arm.robot.positions(_named(scene, arm, q))) for q in motion]
    points = np.array([tip.translation for tip in tips])
    if rng.random() < 0.5:
        low, high = points.min(axis=0) - 0.03, points.max(axis=0) + 0.03
        return to.position_in_region(arm.tip, to.Box(*(high - low)), to.placement((low + high) / 2.0))
    axes = np.array([tip.rotation[:, 2] for tip in tips])
    mean = axes.sum(axis=0) / np.linalg.norm(axes.sum(axis=0))
    angle = float(np.arccos(np.clip(axes @ mean, -1.0, 1.0)).max()) + 0.08
    return to.axis_alignment(arm.tip, direction=mean, tolerance=min(angle, 3.0))


def _shape(rng: np.random.Generator) -> to.Box | to.Sphere | to.Cylinder | to.Capsule:
    a, b, c = (float(size) for size in rng.uniform(0.02, 0.25, 3))
    return [to.Box(a, b, c), to.Sphere(a / 2.0), to.Cylinder(a / 2.0, b), to.Capsule(a / 2.0, b)][
        int(rng.integers(4))
    ]


def _direction(rng: np.random.Generator) -> Floats:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _somewhere(rng: np.random.Generator) -> to.Placement:
    return to.placement(rng.uniform((-0.9, -0.9, -0.1), (0.9, 0.9, 1.1)), rpy=rng.uniform(-3, 3, 3))
