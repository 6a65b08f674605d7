"""Attacks on proofs: what is called proven must stand against known motions, samples and other methods."""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

import trajopt as to
from tests.fuzz.random_problems.case import Case
from tests.fuzz.random_problems.check import (
    fault_of_configuration,
    fault_of_path,
    fault_of_trajectory,
    spare_of,
)
from trajopt.optimise.methods import method_named
from trajopt.values.arrays import Floats

SAMPLES = 400
DESCENTS = 6
NODES = 300
AT_START = (
    to.Status.START_IN_COLLISION,
    to.Status.START_OUT_OF_LIMITS,
    to.Status.START_BREAKS_CONSTRAINT,
    to.Status.START_CANNOT_BE_HELD,
)
AT_GOAL = (
    to.Status.GOAL_IN_COLLISION, to.Status.GOAL_OUT_OF_LIMITS, to.Status.GOAL_BREAKS_CONSTRAINT,
    to.Status.GOAL_CANNOT_BE_HELD, to.Status.NO_INVERSE_KINEMATICS, to.Status.CONFLICTING_CONSTRAINTS,
)  # fmt: skip


def counterexample(case: Case, result: to.Result, rng: np.random.Generator) -> str:
    """Return what shows that a proof is false, in words; empty if nothing was found."""
    if case.motion is not None and not fault_of_path(case, case.motion, spare=spare_of(case)):
        return "a motion is known"
    if case.impossible:
        return ""
    if result.status in AT_START:
        return (
            ""
            if fault_of_configuration(case, case.start, goals=False, spare=spare_of(case))
            else "the start holds all of it"
        )
    if result.status is to.Status.CLEARANCE_IMPOSSIBLE:
        low, high = case.arm.chain.bounds()
        drawn = rng.uniform(low, high, (SAMPLES, len(low)))
        held = [q for q in drawn if not fault_of_configuration(case, q, goals=False, spare=spare_of(case))]
        return f"a configuration keeps all clearances: {held[0].tolist()}" if held else ""
    ends = ends_of(case, rng)
    if result.status in AT_GOAL:
        return f"a configuration at the goal holds all of it: {ends[0].tolist()}" if ends else ""
    for end in ends[:2]:
        found = _grown(case, end, rng)
        if found is not None:
            return f"a motion was grown, over {found.tolist()}"
    other = to.plan(case.problem(), method=method_named("stomp"), budget=to.Budget(attempts=2))
    if other.verified and not fault_of_trajectory(case, other.require().trajectory):
        return "another method found a motion"
    return ""


def ends_of(case: Case, rng: np.random.Generator) -> list[Floats]:
    """Return configurations that hold goals and all else, from samples and from descents of the nearest."""
    low, high = case.arm.chain.bounds()

    def broken(positions: Floats) -> float:
        chain, places = case.arm.chain, case.arm.chain.places(positions[None])
        parts = [float(item.excess(chain, positions[None], places)[0]) for item in (*case.goals, *case.path)]
        parts.append(chain.excess_of_limits(positions[None]))
        return sum(max(part, 0.0) for part in parts)

    drawn = rng.uniform(low, high, (SAMPLES, len(low)))
    if case.motion is not None:
        drawn[0] = case.motion[-1]
    ranked = sorted(drawn, key=broken)
    found: list[Floats] = [ranked[0]]
    for first in ranked[:DESCENTS]:
        bounds = list(zip(low, high, strict=True))
        found.append(minimize(broken, first, method="Nelder-Mead", bounds=bounds, options={"maxfev": 400}).x)
    return [end for end in found if not fault_of_configuration(case, end, goals=True, spare=spare_of(case))]


def _grown(case: Case, end: Floats, rng: np.random.Generator) -> Floats | None:
    """Grow two trees from start and end towards each other; return the corners of a motion, or none."""
    low, high = case.arm.chain.bounds()
    trees: tuple[list[tuple[Floats, int]], ...] = ([(case.start, -1)], [(end, -1)])

    def free(first: Floats, last: Floats) -> bool:
        moved = _at(case, first)
        return not fault_of_path(moved, np.stack((first, last)), step=5e-3, spare=0.0)

    def towards(tree: list[tuple[Floats, int]], goal: Floats) -> bool:
        place = int(np.argmin([np.linalg.norm(node - goal) for node, _ in tree]))
        here, way = tree[place][0], goal - tree[place][0]
        far = float(np.linalg.norm(way))
        there = goal if far < 0.3 else here + 0.3 * way / far
        if far < 1e-9 or not free(here, there):
            return False
        tree.append((there, place))
        return far < 0.3

    for count in range(NODES):
        mine, other = trees[count % 2], trees[1 - count % 2]
        size = len(mine)
        towards(mine, rng.uniform(low, high))
        if len(mine) > size:
            goal = mine[-1][0]
            for _ in range(20):
                size = len(other)
                if towards(other, goal):
                    corners = np.array(_back(trees[0])[::-1] + _back(trees[1])[1:])
                    return None if fault_of_path(case, corners, spare=spare_of(case)) else corners
                if len(other) == size:
                    break
    return None


def _at(case: Case, start: Floats) -> Case:
    return replace(case, start=start, goals=())


def _back(tree: list[tuple[Floats, int]]) -> list[Floats]:
    place, found = len(tree) - 1, list[Floats]()
    while place >= 0:
        node, place = tree[place]
        found.append(node)
    return found
