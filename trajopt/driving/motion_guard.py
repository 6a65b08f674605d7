"""Guard: proves what is to be driven next, in the world as it is known at that time."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import Executor
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.scene.deviation import largest_deviation
from trajopt.scene.reduced import ReducedModel, reduce_model
from trajopt.scene.scene import Scene
from trajopt.scene.whole_robot import whole_robot
from trajopt.values.arrays import Floats, Value
from trajopt.values.cached import LruCache
from trajopt.values.errors import JointNotFound
from trajopt.values.trajectory import Trajectory, state_of
from trajopt.verify import Certificate, Judge, Specification, VerifyOptions

FIRST_INTERVALS = 8
"""Into so many intervals a piece and its stop are cut at first: they are half as long as motions mostly are,
which the judge cuts into sixteen."""


@dataclass(frozen=True, eq=False)
class MotionGuard(Value):
    """Proves motions that end at rest somewhere on the way; one for each thread, as judges are.

    What a problem requires all the way must hold for them as well, and the limits; its goal need not. Every
    distance must be larger than is required by as much as the robot can be off where it has to be. The judge
    of a scene is kept: it is asked about one motion after the other, at other times of the scene's clock.

    Attributes:
        problem: What is required, and of which group.
        deviation: How far any point of the robot, or of what it carries, can be off where it has to be [m].
    """

    problem: Problem
    deviation: float

    def proven(
        self, motion: Trajectory, world: WorldSnapshot, begin: float, *, requirements: bool = True
    ) -> bool:
        """Say whether a motion that begins at a time is proven.

        Args:
            motion: Of the group's joints.
            world: What is known of the world.
            begin: When the motion begins, on the executor's clock [s].
            requirements: Whether the problem's own constraints must hold too, besides limits and clearances.
        """
        asked = self._specification(motion, requirements=requirements, clock=world.clock(begin))
        return self._judge(world.scene).decide(motion, asked).verified

    def prepare(self, world: WorldSnapshot) -> None:
        """Make the judge of a world, so that the first motion in it is judged as fast as the others."""
        self._judge(world.scene)

    def certificate(self, motion: Trajectory, world: WorldSnapshot, begin: float) -> Certificate:
        """Measure by how much a motion is proven, or is not; arguments as of `proven`.

        Raises:
            ShapeError: If nothing is known of an object's motion any more when it begins.
        """
        reduced = self._reduced(motion, world.at(begin))
        return Judge(reduced, self.options).certify(motion, self._specification(motion, requirements=True))

    def why_not(self, motion: Trajectory, world: WorldSnapshot, begin: float) -> str:
        """Say which check fails, or of what nothing is known any more; arguments as of `proven`."""
        if stale := world.stale(begin):
            return stale
        checks = self.certificate(motion, world, begin).checks
        return next((check.detail for check in checks if not check.holds), "")

    @cached_property
    def options(self) -> VerifyOptions:
        """The judge's own, and how far the robot can be off taken off every distance."""
        return VerifyOptions(
            distance_error=VerifyOptions.distance_error + self.deviation, first_intervals=FIRST_INTERVALS
        )

    @cached_property
    def _judges(self) -> LruCache[Scene, Judge]:
        return LruCache(2)

    def _judge(self, scene: Scene) -> Judge:
        problem = self.problem

        def make() -> Judge:
            return Judge(reduce_model(scene, problem.group, problem.start_positions), self.options)

        return self._judges.get(scene, make)

    def _reduced(self, motion: Trajectory, scene: Scene) -> ReducedModel:
        problem = self.problem
        positions = np.array(problem.start_positions)
        positions[scene.robot.index(motion.joint_names)] = motion(0.0)
        return reduce_model(scene, problem.group, scene.robot.followed(positions))

    def _specification(self, motion: Trajectory, *, requirements: bool, clock: float = 0.0) -> Specification:
        """State what must hold; the motion begins where it begins, which is for the executor to check."""
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
    """Return a problem from where a robot stands, in a scene.

    Args:
        problem: What is asked.
        positions: Of all joints, shape (number of joints,) [rad | m].
        scene: What is around the robot.
    """
    return replace(problem, scene=scene, start=positions, start_velocity={}, start_acceleration={})


def start_at(problem: Problem, committed: CommittedMotion, time: float, scene: Scene) -> Problem:
    """Return a problem as if the robot stood in a scene where it has to be at a time.

    Args:
        problem: What is asked.
        committed: What the robot has to do.
        time: On the executor's clock [s].
        scene: What is around the robot.
    """
    positions = np.array(problem.start_positions)
    positions[scene.robot.index(committed.joint_names)] = committed(time)[0]
    return start_from(problem, scene.robot.followed(positions), scene)


def guard_of(problem: Problem, executor: Executor) -> MotionGuard:
    """Return the guard of a problem whose robot an executor drives, within its tolerance.

    Joints that it drives and the group does not move stand where the executor has them, whatever the problem
    says.

    Args:
        problem: What is required.
        executor: What drives the robot.

    Raises:
        JointNotFound: If it does not drive a joint of the group.
    """
    names, driven = problem.reduced.joint_names, executor.joint_names
    for name in names:
        if name not in driven:
            raise JointNotFound("joint that is driven", name, driven)
    stands, robot = np.array(problem.start_positions), problem.scene.robot
    stands[robot.index(driven)] = executor.state().commanded
    here = start_from(problem, robot.followed(stands), problem.scene)
    return guard_within(here, driven, executor.tolerance)


def guard_within(problem: Problem, joint_names: tuple[str, ...], tolerance: Floats) -> MotionGuard:
    """Return the guard of a problem whose robot follows within a tolerance.

    Joints outside the group count as well: a finger that is off by a millimetre moves its tip by as much.

    Args:
        problem: What is required; joints outside the group stay at its start.
        joint_names: Joints that are driven.
        tolerance: How far each of them can be off where it has to be, shape (n,) [rad | m].
    """
    whole = whole_robot(problem.scene, joint_names, problem.start_positions)
    return MotionGuard(problem, largest_deviation(whole, tolerance))


OF_DISTANCES = {
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
"""Reasons for which there may be no plan because larger distances are required."""
SMALLEST_SHARE = 1e-4
"""Room that is smaller is not named as a reason [m]."""


def with_tracking_margin(scene: Scene, off: float) -> Scene:
    """Return a scene whose clearances are larger by how far a robot can be off where it has to be.

    Args:
        scene: What is around the robot.
        off: How far any point of it can be off [m].
    """
    stated = scene.clearances
    wider = replace(
        stated,
        everywhere=stated.everywhere + off,
        pairs={pair: value + off for pair, value in stated.pairs.items()},
        links={link: value + off for link, value in stated.links.items()},
        kinds={kind: value + off for kind, value in stated.kinds.items()},
    )
    return replace(scene, clearances=wider)


def with_margin_share(result: Result, off: float) -> str:
    """Return why there is no plan, and how much of the required distances the robot's tolerance takes.

    Args:
        result: Of a problem in a scene that `with_room` made.
        off: How far any point of the robot can be off [m].
    """
    if result.status not in OF_DISTANCES or off < SMALLEST_SHARE:
        return result.reason
    return f"{result.reason}; {1e3 * off:.4g} mm of each required distance is room for the driver's tolerance"
