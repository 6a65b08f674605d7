"""Motion guard: proves motions before they are driven, in a world snapshot."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import Executor
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.cached import LruCache
from trajopt.values.errors import JointNotFound, ProblemError, shown
from trajopt.values.trajectory import Trajectory, state_of
from trajopt.verify import Certificate, Judge, Specification, Verdict, VerifyOptions

FIRST_INTERVAL = 0.2
"""Intervals at the start of a proof [s]: with a half or twice the length, proofs of pieces measure more."""
DISTANCE_STATUSES = {
    Status.START_IN_COLLISION,
    Status.CLEARANCE_IMPOSSIBLE,
    Status.GOAL_IN_COLLISION,
    Status.NO_WAYPOINT,
    Status.STUCK,
    Status.PROVEN_INFEASIBLE,
    Status.BLOCKED_IN_TIME,
    Status.INEVITABLE,
    Status.FIXED_LINK_MET,
    Status.GOAL_OCCUPIED,
}
"""Failures to plan that larger required distances may cause."""
SMALLEST_MARGIN = 1e-4
"""Smaller tracking margins are not named as a reason [m]."""


@dataclass(frozen=True, eq=False)
class MotionGuard(Value):
    """Proves motions that end at rest anywhere; one for each thread, as judges are.

    Limits and path constraints of the problem must hold, its goal need not. Beyond its clearance, each pair
    of bodies keeps the largest approach that the tracking tolerance can cause.

    Attributes:
        tolerance: Largest distance of each driven joint from its commanded position, by name [rad | m].
    """

    problem: Problem
    tolerance: Mapping[str, float]

    def tracked(self, scene: Scene) -> Scene:
        """Return a scene whose robot may be off by the tracking tolerance; the same for the same scene."""

        def make() -> Scene:
            return replace(scene, model_error=scene.model_error.with_joints(self.tolerance, scene.robot))

        return self._tracked.get(scene, make)

    @cached_property
    def _tracked(self) -> LruCache[Scene, Scene]:
        return LruCache(2)

    def reduced(self, scene: Scene) -> ReducedModel:
        """Return the model of the group in a scene, off by the tracking tolerance, at the problem's start."""
        return reduce_model(self.tracked(scene), self.problem.group, self.problem.start_positions)

    @cached_property
    def deviation(self) -> float:
        """Largest approach of two bodies that the tolerance can cause [m]."""
        return float(self.reduced(self.problem.scene).pairs.error.max(initial=0.0))

    def proven(
        self, motion: Trajectory, world: WorldSnapshot, begin: float, *, requirements: bool = True
    ) -> bool:
        """Return whether a motion is proven, its path constraints only if `requirements`."""
        return self.verdict(motion, world, begin, requirements=requirements).verified

    def verdict(
        self, motion: Trajectory, world: WorldSnapshot, begin: float, *, requirements: bool = True
    ) -> Verdict:
        """Judge a motion; arguments as for `proven`."""
        required = self._specification(motion, requirements=requirements, clock=world.clock(begin))
        return self._judge(world.scene).decide(motion, required)

    def prepare(self, world: WorldSnapshot) -> None:
        """Make the judge of a world before the first motion."""
        self._judge(world.scene)

    def certificate(self, motion: Trajectory, world: WorldSnapshot, begin: float) -> Certificate:
        """Measure every check of a motion; arguments as for `proven`.

        Raises:
            ShapeError: If the motion of an object is no longer predicted when it begins.
        """
        problem, scene = self.problem, world.at(begin)
        positions = np.array(problem.start_positions)
        positions[scene.robot.index(motion.joint_names)] = motion(0.0)
        reduced = reduce_model(self.tracked(scene), problem.group, scene.robot.followed(positions))
        return Judge(reduced, self.options).certify(motion, self._specification(motion, requirements=True))

    def failed_check(self, motion: Trajectory, world: WorldSnapshot, begin: float) -> str:
        """Describe the first check that fails; empty if none."""
        if stale := world.stale(begin):
            return stale
        checks = self.certificate(motion, world, begin).checks
        return next((check.detail for check in checks if not check.holds), "")

    @cached_property
    def options(self) -> VerifyOptions:
        """The options of its judges."""
        return VerifyOptions(first_interval=FIRST_INTERVAL)

    @cached_property
    def _judges(self) -> LruCache[Scene, Judge]:
        return LruCache(2)

    def _judge(self, scene: Scene) -> Judge:
        return self._judges.get(scene, lambda: Judge(self.reduced(scene), self.options))

    def _specification(self, motion: Trajectory, *, requirements: bool, clock: float = 0.0) -> Specification:
        problem, begins = self.problem, state_of(motion, 0.0)
        return Specification(
            goals=(),
            constraints=problem.requirements if requirements else (),
            limits=problem.moving_limits,
            tool_speeds=problem.tool_speeds,
            start_positions=motion.positions[0],
            start_velocities=begins[1],
            start_accelerations=begins[2],
            clock=clock,
        )


def start_from(problem: Problem, positions: Floats, scene: Scene) -> Problem:
    """Return a problem that starts at rest at positions of all joints [rad | m], in a scene."""
    return replace(problem, scene=scene, start=positions, start_velocity={}, start_acceleration={})


def start_at(problem: Problem, committed: CommittedMotion, time: float, scene: Scene) -> Problem:
    """Return a problem that starts at rest at the positions commanded at a time [s], in a scene."""
    positions = np.array(problem.start_positions)
    positions[scene.robot.index(committed.joint_names)] = committed(time)[0]
    return start_from(problem, scene.robot.followed(positions), scene)


def guard_of(problem: Problem, executor: Executor) -> MotionGuard:
    """Return the guard of a problem whose robot an executor drives, within its tolerance.

    Driven joints outside the group stay at the executor's positions, not at the start of the problem.
    """
    names, driven = problem.reduced.joint_names, executor.joint_names
    for name in names:
        if name not in driven:
            raise JointNotFound("joint that is driven", name, driven)
    positions, robot = np.array(problem.start_positions), problem.scene.robot
    positions[robot.index(driven)] = executor.state().commanded
    here = start_from(problem, robot.followed(positions), problem.scene)
    tolerance = floats("Executor.tolerance", executor.tolerance, (len(driven),))
    if tolerance.min(initial=0.0) < 0.0:
        raise ProblemError(f"Executor.tolerance must not be negative, is {shown(tolerance.tolist())}")
    return guard_within(here, driven, tolerance)


def guard_within(problem: Problem, joint_names: tuple[str, ...], tolerance: Floats) -> MotionGuard:
    """Return the guard of a problem whose robot follows within a tolerance, shape (n,) [rad | m].

    Joints outside the group count, too.
    """
    return MotionGuard(problem, dict(zip(joint_names, tolerance.tolist(), strict=True)))


def reason_with_margin(result: Result, deviation: float) -> str:
    if result.status not in DISTANCE_STATUSES or deviation < SMALLEST_MARGIN:
        return result.reason
    reserve = f"up to {1e3 * deviation:.4g} mm for the tracking tolerance"
    return f"{result.reason}; required distances include {reserve}"
