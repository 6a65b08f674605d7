"""Problems without a solution, drawn at random; why there is none is known from how they were made."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from trajopt_problems.arms import Arm, panda, pointing, ur5

import trajopt as to

DOWN = (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Unsolvable:
    """A problem and the statuses that are right.

    Attributes:
        problem: The problem.
        right: Statuses that tell the truth.
        proven: Whether the proof is within what the proofs know.
    """

    problem: to.Problem
    right: frozenset[to.Status]
    proven: bool


Maker = Callable[[np.random.Generator], Unsolvable]


def _arm(rng: np.random.Generator) -> Arm:
    return (panda, ur5)[int(rng.integers(2))]()


def _plain(arm: Arm, goal: object, *, scene: to.Scene | None = None, constraints: object = ()) -> to.Problem:
    return to.Problem(
        scene=scene or to.Scene(arm.robot),
        group=arm.group,
        start=arm.ready,
        goal=goal,  # pyright: ignore[reportArgumentType]
        constraints=constraints,  # pyright: ignore[reportArgumentType]
    )


def _direction(rng: np.random.Generator, *, lowest: float = -1.0) -> np.ndarray:
    while True:
        vector = rng.normal(size=3)
        vector /= np.linalg.norm(vector)
        if vector[2] >= lowest:
            return vector


def too_far(rng: np.random.Generator) -> Unsolvable:
    """A point farther away than the arm is long."""
    arm = _arm(rng)
    point = np.array((0.0, 0.0, 0.3)) + rng.uniform(1.35, 2.5) * _direction(rng, lowest=-0.2)
    problem = _plain(arm, arm.tip_at(point, 1e-3))
    return Unsolvable(problem, frozenset({to.Status.NO_INVERSE_KINEMATICS}), True)


def joint_too_far(rng: np.random.Generator) -> Unsolvable:
    """A joint goal beyond its limit: of one joint, or of all."""
    arm = _arm(rng)
    joints = _plain(arm, arm.tip_at(np.zeros(3), 1.0)).reduced
    place = int(rng.integers(len(joints.joint_names)))
    beyond = float(joints.limits.upper[place]) + rng.uniform(0.05, 0.5)
    given = {joints.joint_names[place]: beyond}
    if rng.uniform() < 0.5:
        given = {name: given.get(name, float(arm.ready[name])) for name in joints.joint_names}
    goal = to.joint_positions(given, tolerance=rng.uniform(1e-4, 0.04))
    return Unsolvable(_plain(arm, goal), frozenset({to.Status.GOAL_OUT_OF_LIMITS}), True)


def in_a_block(rng: np.random.Generator) -> Unsolvable:
    """A point in the middle of a block."""
    arm = _arm(rng)
    centre = np.array((rng.uniform(0.4, 0.6), rng.uniform(-0.4, 0.4), rng.uniform(0.1, 0.3)))
    edges = rng.uniform(0.3, 0.4, size=3)
    around = to.placement(centre, rpy=(0.0, 0.0, rng.uniform(-np.pi, np.pi)))
    scene = to.Scene(arm.robot).add("block", to.Box(*edges), around)
    problem = _plain(arm, arm.tip_at(centre, 2e-3), scene=scene)
    right = {to.Status.GOAL_IN_COLLISION}
    free = to.examine(problem.reduced, problem.reduced.start_positions).clear
    return Unsolvable(problem, frozenset(right if free else {to.Status.START_IN_COLLISION}), not free)


def between_walls(rng: np.random.Generator) -> Unsolvable:
    """A UR5 between walls that begin at its base; the goal is on the other side."""
    arm = ur5()
    while True:
        gap, turn = rng.uniform(0.10, 0.12), rng.uniform(-np.pi, np.pi)
        places = [to.placement((side * (gap + 0.7), 0.0, 0.0)) for side in (-1.0, 1.0)]
        walls = [(to.Box(1.4, rng.uniform(0.02, 0.06), 3.0), place) for place in places]
        scene = to.Scene(arm.robot).add("walls", walls, to.placement(rpy=(0.0, 0.0, turn)))
        start = {
            **arm.ready,
            "shoulder_pan_joint": rng.uniform(-1.5, 0.5),
            "shoulder_lift_joint": rng.uniform(-1.2, -0.6),
            "elbow_joint": rng.uniform(0.8, 1.6),
        }
        other = {**start, "shoulder_pan_joint": start["shoulder_pan_joint"] + np.pi}
        problem = to.Problem(scene=scene, group=arm.group, start=start, goal=to.joint_positions(other))
        ends = (problem.reduced.start_positions, np.array([other[n] for n in problem.reduced.joint_names]))
        if all(to.examine(problem.reduced, each).clear for each in ends):
            return Unsolvable(problem, frozenset({to.Status.PROVEN_INFEASIBLE}), True)


def behind_a_spoke(rng: np.random.Generator) -> Unsolvable:
    """An arm in the plane with a wall across the way of its first link."""
    robot = to.load("planar2")
    names = robot.joint_names
    while True:
        angle, inner = rng.uniform(-0.5, 0.5), rng.uniform(0.15, 0.3)
        long = rng.uniform(0.3, 1.0)
        where = to.placement(
            ((inner + long / 2) * np.cos(angle), (inner + long / 2) * np.sin(angle), 0.0), rpy=(0, 0, angle)
        )
        scene = to.Scene(robot).add("spoke", to.Box(long, 0.03, 1.0), where)
        start = dict(zip(names, (angle - rng.uniform(0.5, 1.5), rng.uniform(-1.0, 1.0)), strict=True))
        end = dict(zip(names, (angle + rng.uniform(0.5, 1.5), rng.uniform(-1.0, 1.0)), strict=True))
        problem = to.Problem(scene=scene, start=start, goal=to.joint_positions(end))
        ends = (problem.reduced.start_positions, np.array(list(end.values())))
        limits = problem.reduced.limits
        inside = all(((q > limits.lower) & (q < limits.upper)).all() for q in ends)
        if inside and all(to.examine(problem.reduced, each).clear for each in ends):
            return Unsolvable(problem, frozenset({to.Status.PROVEN_INFEASIBLE}), True)


def turned_away(rng: np.random.Generator) -> Unsolvable:
    """A tool that must point down all the way, and elsewhere at the end."""
    arm = _arm(rng)
    cone, spread = rng.uniform(0.1, 0.4), rng.uniform(0.03, 0.2)
    tilt, azimuth = rng.uniform(cone + spread + 0.15, np.pi), rng.uniform(-np.pi, np.pi)
    away = (np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), -np.cos(tilt))
    while True:
        point = (rng.uniform(0.3, 0.5), rng.uniform(-0.35, 0.35), rng.uniform(0.3, 0.6))
        goal = pointing(arm, point, away, cone=spread)
        upright = to.axis_alignment(arm.tip, direction=DOWN, tolerance=cone)
        alone = _plain(arm, goal)
        if to.goal_configurations(alone) and to.goal_configurations(replace(alone, goal=(goal[0], upright))):
            problem = _plain(arm, goal, constraints=[upright])
            return Unsolvable(problem, frozenset({to.Status.CONFLICTING_CONSTRAINTS}), True)


def outside_of_a_region(rng: np.random.Generator) -> Unsolvable:
    """A tool that must stay in a region all the way, and be outside of it at the end."""
    arm = _arm(rng)
    scene = to.Scene(arm.robot)
    begin = scene.placement_of(arm.tip, arm.robot.positions(arm.ready)).translation
    while True:
        radius = rng.uniform(0.08, 0.2)
        shape = (to.Sphere(radius), to.Box(2 * radius, 2 * radius, 2 * radius))[int(rng.integers(2))]
        point = begin + rng.uniform(1.9, 2.5) * radius * _direction(rng)
        goal = arm.tip_at(point, 2e-3)
        if to.goal_configurations(_plain(arm, goal)):
            inside = to.position_in_region(arm.tip, shape, to.placement(begin))
            problem = _plain(arm, goal, constraints=[inside])
            return Unsolvable(problem, frozenset({to.Status.CONFLICTING_CONSTRAINTS}), True)


def joints_against_cone(rng: np.random.Generator) -> Unsolvable:
    """Joints at the goal that tilt what must stay upright."""
    arm = _arm(rng)
    cone = rng.uniform(0.1, 0.3)
    upright = to.axis_alignment(arm.tip, direction=DOWN, tolerance=cone)
    reduced = _plain(arm, upright).reduced
    tilting = -3 if len(reduced.joint_names) == 6 else -2
    wrist = reduced.joint_names[tilting]
    while True:
        turn = rng.choice((-1.0, 1.0)) * rng.uniform(cone + 0.1, cone + 0.9)
        goal = {name: float(arm.ready[name]) for name in reduced.joint_names}
        goal[wrist] += turn
        problem = _plain(arm, to.joint_positions(goal), constraints=[upright])
        if to.examine(reduced, np.array(list(goal.values()))).clear:
            return Unsolvable(problem, frozenset({to.Status.GOAL_BREAKS_CONSTRAINT}), True)


def two_places_at_once(rng: np.random.Generator) -> Unsolvable:
    """A frame asked to be at two places, each within reach."""
    arm = _arm(rng)
    while True:
        points = [np.array((rng.uniform(0.3, 0.5), rng.uniform(-0.35, 0.35), 0.4)) for _ in range(2)]
        goals = [arm.tip_at(point, 2e-3) for point in points]
        apart = np.linalg.norm(points[0] - points[1]) > 0.02
        if apart and all(to.goal_configurations(_plain(arm, goal)) for goal in goals):
            right = frozenset({to.Status.CONFLICTING_CONSTRAINTS})
            return Unsolvable(_plain(arm, goals), right, True)


FAMILIES: dict[str, tuple[Maker, ...]] = {
    "unreachable": (too_far, joint_too_far, in_a_block),
    "walled in": (between_walls, behind_a_spoke),
    "conflicting": (turned_away, outside_of_a_region, joints_against_cone, two_places_at_once),
}


def draw(count: int) -> Iterator[tuple[str, int, Unsolvable]]:
    """Yield so many problems, the families in turn and their kinds in turn; the same every time."""
    for number in range(count):
        family = list(FAMILIES)[number % len(FAMILIES)]
        makers = FAMILIES[family]
        make = makers[number // len(FAMILIES) % len(makers)]
        yield make.__name__, number, make(np.random.default_rng((20261, number)))
