"""What families draw: motions that hold all that is asked, and things that leave them alone."""

from dataclasses import replace

import numpy as np

from tests.fuzz.random_problems.arms import planar, random_arm
from tests.fuzz.random_problems.asked import Joints, Spot, near
from tests.fuzz.random_problems.case import Arm, Case, Thing
from tests.fuzz.random_problems.chain import turned
from tests.fuzz.random_problems.check import fault_of_configuration, fault_of_path
from tests.fuzz.random_problems.shapes import Body, ball, box, cylinder, prism, sphere
from trajopt.values.arrays import Floats

SPARE = 0.004
"""What a known motion keeps beyond what is required [m]."""
COARSE = 4e-3
"""How far a point moves between two looks while drawing [m]; the attack looks closer."""
DRAWS = 40
ARMS = 30


def small_arm(rng: np.random.Generator) -> Arm:
    """Return a planar or a random arm."""
    return planar(rng) if rng.random() < 0.5 else random_arm(rng)


def moving(rng: np.random.Generator, draw: object = small_arm, **asked: object) -> Case:
    """Return a case without goals whose arm makes a motion of two legs that leaves itself alone."""
    for _ in range(ARMS):
        arm = draw(rng)
        case = moved(arm, rng, **asked)
        if case is not None:
            return case
    raise AssertionError("no motion was found that leaves the arm alone")


def moved(arm: Arm, rng: np.random.Generator, *, spare: float = SPARE, **asked: object) -> Case | None:
    """Return a case without goals with a motion of an arm; none if none was found."""
    low, high = arm.chain.bounds()
    inset = 0.02 * (high - low)
    for _ in range(DRAWS):
        first = rng.uniform(low + inset, high - inset)
        reach = 0.25 * (high - low)
        bend, last = (
            np.clip(first + rng.normal(size=len(low)) * reach, low + inset, high - inset) for _ in "ab"
        )
        corners = np.stack((first, bend, last))
        case = Case(arm=arm, start=first, goals=(), motion=corners, **asked)
        if any(fault_of_configuration(case, q, goals=False, spare=spare) for q in corners):
            continue  # a look at the corners is cheap
        if not fault_of_path(case, corners, step=COARSE, spare=spare):
            return case
    return None


def cluttered(
    case: Case, rng: np.random.Generator, wanted: int, *, spare: float = SPARE, kinds: str = "convex"
) -> Case:
    """Return the case with things near its motion that the motion leaves alone."""
    for count in range(3 * wanted):
        if len(case.things) >= wanted:
            break
        near_to = case.motion[int(rng.integers(len(case.motion)))]
        link = str(rng.choice([item.link for item in case.arm.chain.bodies]))
        centre = case.arm.chain.places(near_to[None])[link][0][:3, 3] + rng.normal(scale=0.15, size=3)
        thing = Thing(f"thing{count}", some_body(rng, kinds), somewhere(rng, centre))
        if clear(replace(case, things=(thing,)), spare, only=thing.name):
            case = replace(case, things=(*case.things, thing))
    return case


def clear(case: Case, spare: float = SPARE, only: str = "") -> bool:
    """Whether the known motion holds all of a case; with `only`, keeps clear of that owner."""
    return not fault_of_path(case, case.motion, step=COARSE, spare=spare, only=only)


def somewhere(rng: np.random.Generator, centre: Floats) -> Floats:
    """Return a placement at a point, turned at random."""
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turned(*rng.uniform(-3, 3, 3)), centre
    return place


def at(point: Floats) -> Floats:
    """Return an upright placement at a point."""
    place = np.eye(4)
    place[:3, 3] = point
    return place


def some_body(rng: np.random.Generator, kinds: str) -> Body:
    """Return a convex body, a closed mesh ("closed") or an open one ("open")."""
    a, b, c = rng.uniform(0.03, 0.2, 3)
    if kinds == "convex":
        return [box(a, b, c), sphere(a / 2.0), cylinder(a / 2.0, b)][int(rng.integers(3))]
    if kinds == "closed" and rng.random() < 0.4:
        return ball(a / 2.0)
    turns = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(8, 16))))
    far = rng.uniform(0.4, 1.0, len(turns)) * a / 2.0  # a star: seldom convex
    outline = np.stack((far * np.cos(turns), far * np.sin(turns)), axis=1)
    return prism(outline, b, lids=kinds == "closed")


def at_end(case: Case, rng: np.random.Generator) -> Case:
    """Return the case with a goal that its motion reaches: joints, or the tip at a point."""
    if rng.random() < 0.6:
        return replace(case, goals=(joints_at_end(case, float(rng.choice([1e-4, 1e-2]))),))
    tip = case.arm.chain.places(case.motion[-1:])[case.arm.tip][0][:3, 3]
    return replace(case, goals=(Spot(case.arm.tip, tip, 0.005),))


def joints_at_end(case: Case, tolerance: float) -> Joints:
    """Return a goal of all driven joints at the end of the motion."""
    return near(dict(zip(case.arm.chain.driven, case.motion[-1].tolist(), strict=True)), tolerance)
