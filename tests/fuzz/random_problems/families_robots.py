"""Families of robots that nobody has met: serial ones, trees, and ones whose joints follow each other."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.fuzz.random_problems.any_robot import any_robot
from tests.fuzz.random_problems.case import Arm, Case
from tests.fuzz.random_problems.check import HULLS, fault_of_configuration, fault_of_path
from tests.fuzz.random_problems.drawing import ARMS, COARSE, DRAWS, SPARE, at_end, cluttered
from tests.fuzz.random_problems.families_apart import along
from tests.fuzz.random_problems.load import with_tight_efforts


def robots(*, tree: bool = False, mimics: bool = False) -> Callable[[np.random.Generator], Case]:
    """Return the family of such robots among things that leave a known motion alone.

    Four in ten can bear little more than their own weight along that motion, two in ten must keep on the way
    what it keeps.
    """

    def draw(rng: np.random.Generator) -> Case:
        for _ in range(ARMS):
            arm = any_robot(rng, tree=tree, mimics=mimics)
            spare = HULLS if any(item.body.kind == "mesh" for item in arm.chain.bodies) else SPARE
            case = _moved(arm, rng, spare)
            if case is not None:
                if rng.random() < 0.4:
                    case = replace(case, arm=with_tight_efforts(arm, case.motion, rng))
                if rng.random() < 0.2:
                    case = replace(case, path=(along(case, rng),))
                return at_end(cluttered(case, rng, int(rng.integers(2, 12)), spare=spare), rng)
        raise AssertionError("no motion was found that leaves the robot alone")

    return draw


def _moved(arm: Arm, rng: np.random.Generator, spare: float) -> Case | None:
    """Return a case with a motion of two legs; none if none was found.

    With many joints what is drawn from their whole range meets itself nearly always: each draw keeps nearer
    to where all joints stand at 0, or as near to it as they can.
    """
    low, high = arm.chain.bounds()
    inset = 0.02 * (high - low)
    middle = np.clip(0.0, low + inset, high - inset)
    for wide in np.linspace(1.0, 0.2, DRAWS):
        first = middle + wide * (rng.uniform(low + inset, high - inset) - middle)
        reach = 0.25 * wide * (high - low)
        bend, last = (
            np.clip(first + rng.normal(size=len(low)) * reach, low + inset, high - inset) for _ in "ab"
        )
        corners = np.stack((first, bend, last))
        case = Case(arm=arm, start=first, goals=(), motion=corners)
        if any(fault_of_configuration(case, q, goals=False, spare=spare) for q in corners):
            continue
        if not fault_of_path(case, corners, step=COARSE, spare=spare):
            return case
    return None
