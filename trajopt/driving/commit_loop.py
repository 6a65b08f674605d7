"""Commitment: the proven motion that a robot is bound to make, which ends at rest."""

from dataclasses import dataclass

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.events import EventKind, Journal
from trajopt.driving.executor import Executor
from trajopt.driving.motion_guard import MotionGuard, start_at, with_tracking_margin
from trajopt.driving.soonest_stop import StopTaken, soonest_stop, why_unproven
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning import on_the_way
from trajopt.problem.problem import Problem
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Printed
from trajopt.values.printed import in_joint_position, in_range, in_unit
from trajopt.values.trajectory import Trajectory

ROUNDING = 1e-9
"""A joint that is outside its limits by less than this is at its limit [rad | m]."""


def off_track(executor: Executor, committed: CommittedMotion, robot: Robot) -> str:
    """Say which joint is farther from where it has to be than the executor's tolerance; empty if none is."""
    state = executor.state()
    wanted = committed(state.stamp)[0]
    away = np.abs(state.positions - wanted) - executor.tolerance
    worst = int(away.argmax())
    if away[worst] <= 0.0:
        return ""
    name = executor.joint_names[worst]
    unit = joint_unit(robot.model, name)
    where, should = (in_joint_position(float(each[worst]), unit) for each in (state.positions, wanted))
    allowed = in_unit(float(executor.tolerance[worst]), unit)
    return f"{name} is at {where}, has to be at {should} within {allowed}"


def outside_limits(problem: Problem, executor: Executor) -> str:
    """List the joints outside the group that stand outside their limits; empty if there are none.

    Args:
        problem: Its start is where the executor has the joints.
        executor: What holds them there, within its tolerance of each.
    """
    robot, reduced = problem.scene.robot, problem.reduced
    limits, stands, driven = robot.limits, problem.start_positions, executor.joint_names
    found: list[str] = []
    for index, name in enumerate(robot.joint_names):
        lower, upper, here = (float(each[index]) for each in (limits.lower, limits.upper, stands))
        if name in reduced.moving_joints or lower - ROUNDING <= here <= upper + ROUNDING:
            continue
        unit = joint_unit(robot.model, name)
        held = "stays there"
        if name in driven:
            held = f"is held there within {in_unit(float(executor.tolerance[driven.index(name)]), unit)}"
        elif name in robot.mimics:
            held = f"follows {robot.mimics[name].source}"
        where = in_joint_position(here, unit)
        found.append(
            f"{name} stands at {where}, outside its limits {in_range(lower, upper, unit)}, and {held}"
        )
    return "; ".join(found)


@dataclass(eq=False)
class Commitment(Printed):
    """What a robot will do whatever comes, proven in the world as it is known; it ends at rest.

    Attributes:
        executor: What drives the robot.
        journal: What happened.
        guard: Proves motions to the goal that the robot is on its way to.
        world: As it was last told.
        motion: What the executor has to drive.
        held: Whether it holds what the goal's problem requires on the way, besides limits and clearances: a
            stop may be clear that does not, as may the way back from there.
        left: Where the driven joints were when a stop led off a path on which all held, shape (n,)
            [rad | m]; None once a motion on which all holds is driven again.
    """

    executor: Executor
    journal: Journal
    guard: MotionGuard
    world: WorldSnapshot
    motion: CommittedMotion
    held: bool = True
    left: Floats | None = None

    @property
    def soonest(self) -> float:
        """When a motion that is given now can begin [s]."""
        return self.executor.now() + self.executor.latency

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints of the group."""
        return self.guard.problem.reduced.joint_names

    def stand(self) -> None:
        """Be committed to standing where the robot has to be now."""
        self.motion = CommittedMotion(self.executor.joint_names, self.executor.state().commanded)
        self.held, self.left = True, None

    def proven(self, motion: Trajectory, begin: float) -> bool:
        """Say whether what is committed is proven from a time on [s]; what is not known any more is noted."""
        return not self.stale(begin) and self.guard.proven(motion, self.world, begin, requirements=self.held)

    def stale(self, time: float) -> bool:
        """Whether nothing is known any more at a time of something that moves; it is noted when it begins."""
        words = self.world.stale(time)
        self.journal.note_once(EventKind.STALE, words)
        return bool(words)

    def splice(self, motion: Trajectory, at: float) -> bool:
        """Have a motion driven from a time on [s]; say whether that is accepted."""
        refused = self.executor.splice(motion, at)
        if refused:
            self.journal.note(EventKind.REJECTED, refused)
            return False
        self.motion.splice(motion, at, now=self.executor.now())
        return True

    def holds(self, guard: MotionGuard) -> None:
        """Be committed to a motion on which all holds that a guard has proven."""
        self.guard, self.held, self.left = guard, True, None

    def around(self, at: float, world: WorldSnapshot) -> Scene:
        """Return what will be around the robot at a time [s], for a plan from there.

        It asks for room for how far the robot can be off: without, what is planned might not be proven.
        """
        return with_tracking_margin(world.at(at), self.guard.options.distance_error)

    def from_then(self, problem: Problem, at: float, world: WorldSnapshot) -> Problem:
        """Return a problem from where the robot will be at a time [s], among what will be there."""
        here = self.still_at(problem, at, self.around(at, world))
        running = self.motion.ahead(at, self.joint_names)
        return here if running is None else on_the_way(here, running, 0.0)

    def still_at(self, problem: Problem, at: float, scene: Scene) -> Problem:
        """Return a problem as if the robot stood in a scene where it will be at a time [s]."""
        return start_at(problem, self.motion, at, scene)

    def stop(
        self, problem: Problem, begin: float, along: Trajectory | None, why: str
    ) -> tuple[Trajectory | None, StopTaken] | None:
        """Take the soonest proven stop from a time on.

        Args:
            problem: What is required.
            begin: When it begins, on the executor's clock [s].
            along: The earliest stop on the path that begins then; None where there is none.
            why: What for.

        Returns:
            What it does from then on, and how it stops; no motion where the robot stands. None if the stop
            was not accepted: it came too late.
        """
        ahead = self.motion.ahead(begin, self.joint_names)
        if ahead is None:
            return None, StopTaken(0.0, along=True, proven=True)
        # How hard joints may brake does not depend on the scene, of which nothing may be known any more.
        here = self.still_at(problem, begin, problem.scene)
        self.stale(begin + ahead.duration)
        motion, taken = soonest_stop(self.guard, self.world, begin, here, ahead, along)
        if motion is not ahead and not self.splice(motion, begin):
            return None
        if not taken.along and self.left is None:
            self.left = self.motion(begin)[0]
        self.held = taken.held or not taken.proven
        self.journal.note(EventKind.STOPPING, f"{why}; at rest in {1e3 * taken.duration:.0f} ms")
        if not taken.proven:
            self.journal.note(EventKind.UNPROVEN_STOP, why_unproven(self.guard, self.world, begin, motion))
        return motion, taken

    def brake(self, why: str) -> StopTaken:
        """Have all motors brake at once: no stop that is proven was accepted in time."""
        ahead = self.motion.ahead(self.soonest, self.joint_names)
        self.executor.stop()
        self.journal.note(EventKind.STOPPING, f"{why}; all motors brake at once")
        self.journal.note(EventKind.UNPROVEN_STOP, "no proven stop was accepted in time")
        return StopTaken(0.0 if ahead is None else ahead.duration, along=False, proven=False)
