"""OMPL's RRT-Connect and its simplifier, with Coal on the same balls behind a Python callback."""

from time import process_time
from typing import Any

import numpy as np
from ompl import base, geometric, util

import trajopt as to
from benchmarks.clouds.checker import Checker
from benchmarks.workers import Row
from trajopt.verify import CheckKind

SECONDS = 30.0
"""Wall-clock time that it may search."""
STEP = 0.02
"""Between configurations that it checks [rad]."""


def rrt_connect(problem: to.Problem, checker: Checker, goal: np.ndarray, *, seed: int) -> Row:
    """Search a path; its polyline is judged at rest in every corner, by the judge that judges ours."""
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    begin = process_time()
    path = _path(problem, checker, goal)
    seconds = process_time() - begin
    row: Row = {"cpu": round(seconds, 4), "found": path is not None, "judged": False}
    if path is not None:
        certificate = to.judge(problem, _stopping(problem, path))
        row["judged"] = all(check.holds for check in certificate.checks if check.kind is CheckKind.CLEARANCE)
    return row


def _path(problem: to.Problem, checker: Checker, goal: np.ndarray) -> np.ndarray | None:
    limits = problem.reduced.limits
    count = len(goal)
    space = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for joint in range(count):
        bounds.setLow(joint, float(limits.lower[joint]))
        bounds.setHigh(joint, float(limits.upper[joint]))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)

    def free(state: Any) -> bool:
        return checker.free(np.array([state[i] for i in range(count)]))

    setup.setStateValidityChecker(free)
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(STEP / space.getMaximumExtent())
    start: Any = space.allocState()
    end: Any = space.allocState()
    for joint in range(count):
        start[joint], end[joint] = float(problem.reduced.start_positions[joint]), float(goal[joint])
    setup.setStartAndGoalStates(start, end)
    setup.setPlanner(geometric.RRTConnect(information))
    setup.solve(SECONDS)
    if not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    states: Any = setup.getSolutionPath().getStates()
    return np.array([[state[i] for i in range(count)] for state in states])


def _stopping(problem: to.Problem, path: np.ndarray) -> to.Trajectory:
    """Return a polyline as a motion that stops in every corner: only where it goes is judged."""
    rest = np.zeros_like(path)
    times = np.append(0.0, np.cumsum(np.maximum(np.abs(np.diff(path, axis=0)).max(axis=1), 1e-3) * 4.0))
    return to.Trajectory(problem.reduced.joint_names, times, path, rest, rest)
