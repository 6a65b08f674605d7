"""A baseline: wait at the start until the box has passed, then move as in the static scene.

The box has passed when it is never again within 5 mm of what the still motion sweeps, at 61 evenly spaced
times of it. While the arm stands, the box must keep 1 mm off. Distances are Coal's; a time in which
nothing can come nearer than that is skipped, by the box's speed. What is then proven by the judge is the
still motion by the box's later clock; where it is refused, the arm waits 50 ms longer, up to ten times.
Where the box touches a link that no joint moves before the motion is over, waiting is no answer.
"""

from dataclasses import replace

import numpy as np

import trajopt as to
from benchmarks.moving.crossings import BOX, Arm, Crossing
from benchmarks.moving.fixed_links import first_touch

NEAR, STANDING, SAMPLES = 5e-3, 1e-3, 61
LONGER, TRIES = 0.05, 10
LEAST = 1e-3
"""Shortest time that is skipped [s]."""


def waited(problem: to.Problem, crossing: Crossing, still: to.Trajectory) -> float | None:
    """Return the time after which the still motion can begin; None if the box meets the arm before its end.

    Args:
        problem: With the box.
        crossing: The box.
        still: The still problem's motion.
    """
    arm, track = Arm(problem.reduced), crossing.track
    swept = [arm.placements(q) for q in still(np.linspace(0.0, still.duration, SAMPLES))]
    speed = float(np.linalg.norm(crossing.velocity))

    def away(bodies: list[list[to.Placement]], time: float) -> float:
        where = track.at(time)
        return min(arm.distance(each, crossing.shape, where) for each in bodies)

    passed = track.end
    while passed > 0.0 and (distance := away(swept, passed)) > NEAR:
        passed -= max((distance - NEAR) / speed, LEAST)
    passed, now = max(passed, 0.0), 0.0
    while now < passed:
        distance = away(swept[:1], now)
        if distance < STANDING:
            return None
        now += max((distance - STANDING) / speed, LEAST)
    touched = first_touch(problem, crossing, near=STANDING)
    for wait in passed + LONGER * np.arange(TRIES):
        if touched is not None and touched <= wait + still.duration:
            return None
        later = replace(problem, scene=problem.scene.at(float(wait)))
        if to.judge(later, still).verified:
            return float(wait)
    raise RuntimeError(f"{crossing.key}: the still motion is refused after {BOX} has passed")
